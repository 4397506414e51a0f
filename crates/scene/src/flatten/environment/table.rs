//! The table by which bright directions of an environment are chosen.

use eosphor_core::environment::{BANDS, TABLE_UNIT, corners_word, for_index_words};
use eosphor_core::math::elementary64;
use rayon::prelude::*;
use std::f64::consts::PI;

/// A table by which directions are chosen, as `eosphor_core::environment` reads it.
pub(super) struct Table {
    pub(super) cells: Cells,
    pub(super) words: Vec<u32>,
    /// What all directions weigh, in brightness times the sine of the angle from up.
    pub(super) weight: f64,
}

/// The cells of a table.
#[derive(Clone, Copy)]
pub(super) struct Cells {
    pub(super) columns: u32,
    /// Of corners.
    pub(super) rows: u32,
    pub(super) band_rows: [u32; BANDS - 1],
    pub(super) band_sums: [u32; BANDS],
}

/// The table of a picture whose corners are as bright as that, row by row. `None` where all are black.
pub(super) fn table(corners: &[Vec<f64>]) -> Option<Table> {
    let (rows, columns) = (corners.len(), corners[0].len());
    // What a cell of each row weighs beside its brightness. The first and the last row have half the height of others.
    let area = |row: usize| {
        let (from_up, height) = match row {
            0 => (0.25, 0.5),
            row if row == rows => (rows as f64 - 0.25, 0.5),
            row => (row as f64, 1.0),
        };
        height * elementary64::sin(from_up * PI / rows as f64)
    };
    let areas: Vec<f64> = (0..=rows).map(area).collect();
    let band_rows = band_rows(corners, &areas);
    let columns_of_cells: Vec<Column> = (0..columns)
        .into_par_iter()
        .with_min_len(16)
        .map(|column| Column::new(column, corners, &areas, &band_rows))
        .collect();
    let in_band = |band: usize| columns_of_cells.iter().map(move |column| column.weights[band]);
    let bands: [f64; BANDS] = std::array::from_fn(|band| in_band(band).sum());
    let band_sums = running_sums(&bands, TABLE_UNIT)?;
    let mut words = Vec::new();
    for band in 0..BANDS {
        let weights: Vec<f64> = in_band(band).collect();
        // A band without light is never chosen.
        add_indexed(&mut words, &running_sums(&weights, TABLE_UNIT).unwrap_or_else(|| vec![0; columns + 1]));
    }
    columns_of_cells.iter().for_each(|column| words.extend(&column.words));
    let band_sums = std::array::from_fn(|band| band_sums[band + 1]);
    let cells = Cells { columns: columns as u32, rows: rows as u32, band_rows, band_sums };
    Some(Table { cells, words, weight: bands.iter().sum() })
}

/// The first rows of cells of all bands but the first one, for cells of these areas. Of fewer rows than bands, the last bands are
/// empty.
fn band_rows(corners: &[Vec<f64>], areas: &[f64]) -> [u32; BANDS - 1] {
    let last = corners.len() - 1;
    let of_corners: Vec<f64> = corners.iter().map(|row| row.iter().sum()).collect();
    let mut sum = 0.0;
    let sums: Vec<f64> = areas
        .iter()
        .enumerate()
        .map(|(row, area)| {
            sum += area * (of_corners[row.saturating_sub(1)] + of_corners[row.min(last)]);
            sum
        })
        .collect();
    let mut first = 0;
    std::array::from_fn(|band| {
        let share = sum * (band + 1) as f64 / BANDS as f64;
        // The row that this share ends in belongs to the band before.
        first = (sums.partition_point(|sum| *sum < share) + 1).max(first + 1).min(areas.len());
        first as u32
    })
}

/// A column of cells.
struct Column {
    words: Vec<u32>,
    /// What its cells weigh in each band.
    weights: [f64; BANDS],
}

impl Column {
    /// Between a column of corners and the next one.
    fn new(column: usize, corners: &[Vec<f64>], areas: &[f64], band_rows: &[u32; BANDS - 1]) -> Column {
        const PART: u32 = TABLE_UNIT / BANDS as u32;
        let (rows, columns) = (corners.len(), corners[0].len());
        let next = if column + 1 < columns { column + 1 } else { 0 };
        let row = |row: usize| [corners[row][column], corners[row][next]];
        let cells: Vec<[[f64; 2]; 2]> =
            (0..=rows).map(|below| [row(below.saturating_sub(1)), row(below.min(rows - 1))]).collect();
        let weight = |(corners, area): (&[[f64; 2]; 2], &f64)| {
            corners.as_flattened().iter().sum::<f64>() * 0.25 * area
        };
        let weights: Vec<f64> = cells.iter().zip(areas).map(weight).collect();
        let (mut sums, mut from) = (vec![0], 0);
        let of_bands = std::array::from_fn(|band| {
            let to = band_rows.get(band).map_or(weights.len(), |row| *row as usize);
            let weights = &weights[from..to];
            from = to;
            let start = band as u32 * PART;
            match running_sums(weights, PART) {
                Some(of_band) => sums.extend(of_band[1..].iter().map(|sum| start + sum)),
                // Where a band has no light in this column, its cells are never chosen.
                None => sums.extend(weights.iter().map(|_| start + PART)),
            }
            weights.iter().sum()
        });
        let mut words = Vec::new();
        add_indexed(&mut words, &sums);
        words.extend(cells.into_iter().map(corners_word));
        Column { words, weights: of_bands }
    }
}

/// Appends running sums and the index into them.
fn add_indexed(words: &mut Vec<u32>, sums: &[u32]) {
    words.extend(sums);
    for_index_words(sums, |word| words.push(word));
}

/// Running sums of weights, from 0 to `unit`; every weight over 0 has at least 1. `None` where all are 0.
fn running_sums(weights: &[f64], unit: u32) -> Option<Vec<u32>> {
    let total: f64 = weights.iter().sum();
    if !(total > 0.0) {
        return None;
    }
    let count = weights.iter().filter(|weight| **weight > 0.0).count() as u32;
    let left = f64::from(unit - count);
    let (mut sum, mut seen) = (0.0, 0);
    let mut sums = vec![0];
    for weight in weights {
        sum += weight;
        seen += u32::from(*weight > 0.0);
        sums.push((left * (sum / total)).min(left) as u32 + seen);
    }
    // Rounding may leave the last one below.
    let last = *sums.last().expect("it begins with 0");
    let first_full = sums.iter().position(|sum| *sum == last).expect("the last one");
    sums[first_full..].fill(unit);
    Some(sums)
}

#[cfg(test)]
mod tests {
    use super::*;
    use eosphor_core::environment::Environment;
    use eosphor_core::math::{Vec3, elementary, vec3};
    use eosphor_core::sampling::{mix, point_2d, with_digits};

    #[test]
    fn sums_keep_every_weight() {
        let sums = running_sums(&[0.0, 1e-30, 3.0, 0.0, 1.0, 0.0], TABLE_UNIT).unwrap();
        assert_eq!((sums[0], sums[1], sums[2]), (0, 0, 1));
        assert!((f64::from(sums[3] - sums[2]) / f64::from(TABLE_UNIT) - 0.75).abs() < 1e-6);
        assert_eq!((sums[4], sums[5], sums[6]), (sums[3], TABLE_UNIT, TABLE_UNIT));
        assert!(running_sums(&[0.0, 0.0], TABLE_UNIT).is_none());
    }

    /// An environment of a picture whose texels are as bright as that, turned about two axes.
    fn environment(brightness: &[&[u32]]) -> (Environment, Vec<u32>) {
        let corners: Vec<Vec<f64>> =
            brightness.iter().map(|row| row.iter().map(|x| f64::from(*x)).collect()).collect();
        let Table { words, cells, .. } = table(&corners).expect("light");
        let Cells { columns, rows, band_rows, band_sums } = cells;
        let [a, b] = [0.6, 0.8];
        let picture_from_world = [vec3(a, b, 0.0), vec3(-b * b, a * b, a), vec3(a * b, -a * a, b)];
        let chance = 1.0;
        let nowhere = Environment::NOWHERE;
        let environment =
            Environment { chance, columns, rows, band_rows, band_sums, picture_from_world, ..nowhere };
        assert_eq!(environment.table_length(), words.len() as u64);
        (environment, words)
    }

    /// Even over the picture, and the solid angle that it stands for among all of these.
    fn direction(environment: &Environment, i: u32) -> (Vec3, f32) {
        let [a, b] = point_2d(i, 77);
        let (sine, cosine) = elementary::sin_cos(core::f32::consts::PI * a);
        let (s, c) = elementary::sin_cos(core::f32::consts::TAU * b);
        let angle = sine * core::f32::consts::PI * core::f32::consts::TAU;
        let [x, y, z] = environment.picture_from_world;
        (x * (sine * c) + y * cosine + z * (sine * s), angle)
    }

    #[test]
    fn directions_are_as_dense_as_is_said() {
        const COUNT: u32 = 1 << 18;
        let tables: [&[&[u32]]; 4] = [
            &[&[1]],
            &[&[1, 1, 1, 1], &[1, 1, 1, 1]],
            &[&[0, 1, 0], &[7, 0, 300], &[0, 0, 0], &[1, 2, 3], &[50, 0, 1]],
            &[&[1, 0, 0, 0, 0, 0, 0, 0], &[0, 0, 0, 0, 0, 0, 0, 1_000]],
        ];
        for weights in tables {
            let (mut environment, table) = environment(weights);
            if weights.len() == 5 {
                let (to_sun, sun_radius) = (vec3(0.36, -0.48, 0.8), 0.4);
                environment = Environment { sun_chance: 0.25, to_sun, sun_radius, ..environment };
            }
            // Boxes of the sphere: 8 of z by 8 around.
            let part = |d: Vec3| {
                let around = (elementary::atan2(d.y, d.x) * (4.0 / core::f32::consts::PI) + 4.0) as usize;
                ((d.z * 4.0 + 4.0) as usize).min(7) * 8 + around.min(7)
            };
            let (mut sampled, mut said) = ([0f64; 64], [0f64; 64]);
            for i in 0..COUNT {
                let sample = environment.sample(&table, point_2d(i, 3).map(|u| with_digits(u, mix(i))));
                assert!((sample.to_light.length() - 1.0).abs() < 1e-6);
                assert!(sample.density > 0.0 && sample.density.is_finite());
                sampled[part(sample.to_light)] += 1.0 / f64::from(COUNT);
                let (d, angle) = direction(&environment, i);
                said[part(d)] += f64::from(environment.density(&table, d) * angle) / f64::from(COUNT);
            }
            assert!((said.iter().sum::<f64>() - 1.0).abs() < 3e-3, "{weights:?}");
            for (k, (a, b)) in sampled.iter().zip(&said).enumerate() {
                assert!((a - b).abs() < 4e-3, "{weights:?}, part {k}: {a} {b}");
            }
        }
    }

    /// The density that a sample states is that of its direction, but for rounding: at the borders of cells, and in dark corners of
    /// cells where the others are bright.
    #[test]
    fn samples_state_the_density_of_their_direction() {
        let weights: Vec<Vec<u32>> =
            (0..64u32).map(|row| (0..128).map(|column| mix(row * 128 + column) >> 20).collect()).collect();
        let weights: Vec<&[u32]> = weights.iter().map(Vec::as_slice).collect();
        let (environment, table) = environment(&weights);
        let mut others = 0;
        for i in 0..100_000 {
            let sample = environment.sample(&table, point_2d(i, 3).map(|u| with_digits(u, mix(i))));
            let said = environment.density(&table, sample.to_light);
            others += u32::from((sample.density / said - 1.0).abs() > 1e-3);
        }
        assert!(others < 100, "{others}");
    }
}
