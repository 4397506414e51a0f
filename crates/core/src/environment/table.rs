//! Directions by how bright they are.
//!
//! The table divides the picture into cells of equal width and height. It begins with running sums of the weights of its rows, from
//! 0 to [`TABLE_UNIT`], and an index into them (`index.rs`); then, row by row, there are those of a row's cells. Sums are whole
//! numbers, as random numbers have digits: so the probability of a cell is exactly what is said of it. In a cell all directions are
//! equally likely.

use super::index::{Pick, Sums};
use super::{Environment, PicturePlace, TABLE_UNIT, direction_at, index_length};
use crate::math::{Vec3, Vec3Lanes, elementary, fma};
use crate::memory::prefetch;
use crate::sampling::place_within;

/// A direction from which light may come.
#[derive(Clone, Copy, Debug)]
pub struct DirectionSample {
    /// A unit vector of the world.
    pub to_light: Vec3,
    /// Density per steradian.
    pub density: f32,
}

/// Directions in several lanes.
#[derive(Clone, Copy, Debug)]
pub struct DirectionLanes<const W: usize> {
    /// Unit vectors of the world.
    pub to_light: Vec3Lanes<W>,
    /// Densities per steradian.
    pub density: [f32; W],
}

impl Environment {
    /// A direction by its brightness, from two numbers in [0, 1), of which the first one chooses the sun or the table, too. There
    /// must be light: [`Environment::chance`] is above 0.
    #[inline(always)]
    pub fn sample(&self, table: &[u32], u: [f64; 2]) -> DirectionSample {
        match self.share_of_table(u[0]) {
            None => self.sample_of_sun(table, u),
            Some(across) => {
                let row = self.rows_of(table).pick(u[1]);
                let column = self.cells_of(table, row.number).pick(across);
                self.sample_at(&row, &column)
            }
        }
    }

    /// As [`Environment::sample`] in several lanes.
    #[inline(always)]
    pub fn sample_lanes<const W: usize>(&self, table: &[u32], u: &[[f64; W]; 2]) -> DirectionLanes<W> {
        let mut lanes = DirectionLanes { to_light: Vec3Lanes::ZERO, density: [0.0; W] };
        let mut across = [0.0; W];
        let mut is_sun = [false; W];
        for lane in 0..W {
            let share = self.share_of_table(u[0][lane]);
            (across[lane], is_sun[lane]) = (share.unwrap_or(0.0), share.is_none());
        }
        // The few rows are in the caches; what follows is not, and each loop waits for all lanes together.
        let mut rows = [Pick::NONE; W];
        for lane in 0..W {
            rows[lane] = self.rows_of(table).pick(u[1][lane]);
            self.cells_of(table, rows[lane].number).prefetch_index(across[lane]);
        }
        for lane in 0..W {
            self.cells_of(table, rows[lane].number).prefetch_sums(across[lane]);
        }
        let mut columns = [Pick::NONE; W];
        for lane in 0..W {
            columns[lane] = self.cells_of(table, rows[lane].number).pick(across[lane]);
        }
        for lane in 0..W {
            let sample = self.sample_at(&rows[lane], &columns[lane]);
            lanes.to_light.set(lane, sample.to_light);
            lanes.density[lane] = sample.density;
        }
        // Few pictures have a sun, and without this all lanes would sample one, to throw it away.
        if self.sun_chance > 0.0 {
            for lane in 0..W {
                if is_sun[lane] {
                    let sample = self.sample_of_sun(table, [u[0][lane], u[1][lane]]);
                    lanes.to_light.set(lane, sample.to_light);
                    lanes.density[lane] = sample.density;
                }
            }
        }
        lanes
    }

    /// Where a number lies that does not go to the sun, among all of these.
    #[inline(always)]
    fn share_of_table(&self, u: f64) -> Option<f64> {
        let to_sun = self.sun_chance as f64;
        if u < to_sun { None } else { Some((u - to_sun) / (1.0 - to_sun)) }
    }

    /// By the sun, which `u` goes to.
    #[inline(always)]
    fn sample_of_sun(&self, table: &[u32], u: [f64; 2]) -> DirectionSample {
        let within = [u[0] / self.sun_chance as f64, u[1]].map(place_within);
        let to_light = self.in_world(self.sample_sun(within));
        DirectionSample { to_light, density: self.density(table, to_light) }
    }

    /// In a cell.
    #[inline(always)]
    fn sample_at(&self, row: &Pick, column: &Pick) -> DirectionSample {
        // From the nearer pole, where shares are small: they have all their digits there.
        let is_lower = 2 * row.number >= self.rows;
        let from_pole = if is_lower { self.rows.wrapping_sub(1 + row.number) } else { row.number };
        let near = elementary::sin(from_pole as f32 * self.half_row());
        let far = elementary::sin((from_pole + 1) as f32 * self.half_row());
        let (near, far) = (near * near, far * far);
        let rest = if is_lower { 1.0 - row.rest } else { row.rest };
        let x = (column.number as f32 + column.rest) / self.columns as f32;
        let direction = direction_at(x, fma(far - near, rest, near), is_lower);
        let density = self.density_of([row.weight, column.weight], row.number);
        DirectionSample { to_light: self.in_world(direction), density: self.with_sun(density, direction) }
    }

    /// How densely [`Environment::sample`] gives a direction, a unit vector of the world, per steradian.
    #[inline(always)]
    pub fn density(&self, table: &[u32], direction: Vec3) -> f32 {
        self.density_at(table, &self.place(direction))
    }

    /// The same at a place of the picture.
    #[inline(always)]
    pub fn density_at(&self, table: &[u32], place: &PicturePlace) -> f32 {
        let (row, column) = self.cell(place);
        let weight = |sums: Sums, number: u32| {
            let sum = |at: usize| table.get(at).copied().unwrap_or(0);
            let at = sums.first + number as usize;
            sum(at + 1).wrapping_sub(sum(at))
        };
        let weights = [weight(self.rows_of(table), row), weight(self.cells_of(table, row), column)];
        self.with_sun(self.density_of(weights, row), place.direction)
    }

    /// Tells memory that [`Environment::density_at`] will read a place.
    #[inline(always)]
    pub fn prefetch_density(&self, table: &[u32], place: &PicturePlace) {
        let (row, column) = self.cell(place);
        prefetch(table, self.cells_of(table, row).first + column as usize);
    }

    /// The row and the column of a place.
    #[inline(always)]
    fn cell(&self, place: &PicturePlace) -> (u32, u32) {
        let cell = |place: f32, count: u32| {
            let number = (place * count as f32) as u32;
            if number < count { number } else { count.wrapping_sub(1) }
        };
        let [x, y] = place.place;
        (cell(y, self.rows), cell(x, self.columns))
    }

    /// The density of all samples in a direction of the picture's frame, where that of those by the table is this.
    #[inline(always)]
    fn with_sun(&self, density: f32, direction: Vec3) -> f32 {
        if !(self.sun_chance > 0.0) {
            return density;
        }
        fma(self.sun_chance, self.sun_density(direction), (1.0 - self.sun_chance) * density)
    }

    /// The sums of the rows.
    #[inline(always)]
    fn rows_of<'a>(&self, table: &'a [u32]) -> Sums<'a> {
        Sums { table, first: 0, count: self.rows }
    }

    /// Those of a row's cells.
    #[inline(always)]
    fn cells_of<'a>(&self, table: &'a [u32], row: u32) -> Sums<'a> {
        Sums { table, first: self.first_of_row(row), count: self.columns }
    }

    #[inline(always)]
    fn first_of_row(&self, row: u32) -> usize {
        index_length(self.rows as usize) + row as usize * index_length(self.columns as usize)
    }

    /// Half the angle between two borders of rows, in radians.
    #[inline(always)]
    fn half_row(&self) -> f32 {
        core::f32::consts::FRAC_PI_2 / self.rows as f32
    }

    /// Of a cell with these weights of its row and in it.
    #[inline(always)]
    fn density_of(&self, [row_weight, weight]: [u32; 2], row: u32) -> f32 {
        const PART: f32 = 1.0 / TABLE_UNIT as f32;
        let probability = (row_weight as f32 * PART) * (weight as f32 * PART);
        probability / (self.cell_angle * elementary::sin((2 * row + 1) as f32 * self.half_row()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::for_index_words;
    use crate::math::{sqrt, vec3};
    use crate::sampling::{mix, point_2d, with_digits};

    /// Sums of these weights, of a table of their rows.
    fn table(weights: &[&[u32]]) -> (Environment, Vec<u32>) {
        let sums = |weights: &[u32]| {
            let total: u32 = weights.iter().sum();
            let mut sum = 0u64;
            let mut sums = vec![0];
            for weight in weights {
                sum += u64::from(*weight);
                sums.push((sum * u64::from(TABLE_UNIT) / u64::from(total.max(1))) as u32);
            }
            let mut index = Vec::new();
            for_index_words(&sums, |word| index.push(word));
            sums.extend(index);
            sums
        };
        let rows: Vec<u32> = weights.iter().map(|row| row.iter().sum()).collect();
        let mut all = sums(&rows);
        weights.iter().for_each(|row| all.extend(sums(row)));
        let (columns, rows) = (weights[0].len() as u32, weights.len() as u32);
        let half_row = core::f32::consts::FRAC_PI_2 / rows as f32;
        let cell_angle = core::f32::consts::TAU / columns as f32 * 2.0 * elementary::sin(half_row);
        let [a, b] = [0.6, 0.8];
        // Turned about two axes.
        let picture_from_world = [vec3(a, b, 0.0), vec3(-b * b, a * b, a), vec3(a * b, -a * a, b)];
        let environment = Environment {
            chance: 1.0,
            columns,
            rows,
            cell_angle,
            picture_from_world,
            ..Environment::NOWHERE
        };
        (environment, all)
    }

    /// Uniform over the sphere.
    fn direction(i: u32) -> Vec3 {
        let [a, b] = point_2d(i, 77);
        let z = 2.0 * a - 1.0;
        let (s, c) = elementary::sin_cos(core::f32::consts::TAU * b);
        let radius = sqrt(1.0 - z * z);
        vec3(radius * c, radius * s, z)
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
            let (mut environment, table) = table(weights);
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
                let d = direction(i);
                said[part(d)] +=
                    f64::from(environment.density(&table, d)) * 4.0 * std::f64::consts::PI / f64::from(COUNT);
            }
            assert!((said.iter().sum::<f64>() - 1.0).abs() < 3e-3, "{weights:?}");
            for (k, (a, b)) in sampled.iter().zip(&said).enumerate() {
                assert!((a - b).abs() < 4e-3, "{weights:?}, part {k}: {a} {b}");
            }
        }
    }

    /// The density that a sample states is that of its direction, but for rounding at the borders of cells.
    #[test]
    fn samples_state_the_density_of_their_direction() {
        let weights: Vec<Vec<u32>> =
            (0..64u32).map(|row| (0..128).map(|column| mix(row * 128 + column) >> 20).collect()).collect();
        let weights: Vec<&[u32]> = weights.iter().map(Vec::as_slice).collect();
        let (environment, table) = table(&weights);
        let mut others = 0;
        for i in 0..100_000 {
            let sample = environment.sample(&table, point_2d(i, 3).map(|u| with_digits(u, mix(i))));
            let said = environment.density(&table, sample.to_light);
            others += u32::from((sample.density / said - 1.0).abs() > 1e-5);
        }
        assert!(others < 20, "{others}");
    }
}
