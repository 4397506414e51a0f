//! The environment: its header, and the table by which bright directions are chosen.

use super::textures::Textures;
use crate::model::{EnvironmentSource, Scene};
use crate::sky::{DiskOfSun, PICTURE_ROWS, SkyPicture};
use eosphor_core::environment::{Environment, TABLE_UNIT, for_index_words};
use eosphor_core::math::{elementary64, vec3};
use eosphor_core::texture::{Texture, TextureFilter, Textures as TextureView};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// The most cells of a table, across and down. Larger pictures have several texels a cell.
const MOST_CELLS: [u32; 2] = [2048, 1024];

/// The same of skies, which are smooth but for their sun: few enough for the caches.
const CELLS_OF_SKY: [u32; 2] = [256, 128];

/// The environment of a scene and its table. Its texture comes after all others.
pub(super) fn build(scene: &Scene, textures: &Textures, srgb_decode: &[f32; 256]) -> (Environment, Vec<u32>) {
    let Some(map) = &scene.environment else { return (Environment::NOWHERE, Vec::new()) };
    let number = scene.textures.len() as u32;
    let header = Texture { filter: TextureFilter::Nearest, ..textures.headers[number as usize] };
    let view = TextureView { textures: &[header], words: &textures.words, srgb_decode };
    let environment = Environment {
        texture: number,
        strength: map.strength,
        picture_from_world: map.picture_from_world(),
        is_seen: map.is_seen,
        ..Environment::NOWHERE
    };
    let rows = match map.source {
        EnvironmentSource::Image(_) => header.height,
        // Its texels are those of the upper half.
        EnvironmentSource::Sky(_) => PICTURE_ROWS,
    };
    let sun = match &map.source {
        EnvironmentSource::Image(_) => None,
        EnvironmentSource::Sky(sky) => SkyPicture::sun_disk(sky),
    };
    let most_cells = match map.source {
        EnvironmentSource::Image(_) => MOST_CELLS,
        EnvironmentSource::Sky(_) => CELLS_OF_SKY,
    };
    match table(&view, rows, most_cells, sun).filter(|_| map.strength > 0.0) {
        Some(Table { columns, rows, sun_share, words }) => {
            let cell_angle = TAU / f64::from(columns) * 2.0 * elementary64::sin(PI / 2.0 / f64::from(rows));
            let environment = match sun {
                Some(DiskOfSun { middle, radius }) => Environment {
                    sun_chance: sun_share.min(MOST_OF_SUN) as f32,
                    to_sun: vec3(middle[0] as f32, middle[1] as f32, middle[2] as f32),
                    sun_radius: radius as f32,
                    ..environment
                },
                None => environment,
            };
            // Alone; lights take their share ([`chance`]).
            (Environment { chance: 1.0, columns, rows, cell_angle: cell_angle as f32, ..environment }, words)
        }
        None => (environment, Vec::new()),
    }
}

/// The share of light samples that go to an environment with light, beside other lights.
pub(super) fn chance(has_lights: bool) -> f32 {
    if has_lights { 0.5 } else { 1.0 }
}

/// The most samples that go to the sun: the shade has the sky alone.
const MOST_OF_SUN: f64 = 0.5;

/// A table by which directions are chosen.
struct Table {
    columns: u32,
    rows: u32,
    /// The share of the light that is the sun's.
    sun_share: f64,
    words: Vec<u32>,
}

/// The table of a picture that has so many rows; without its sun, if it has one. `None` where it is black.
fn table(
    view: &TextureView,
    picture_rows: u32,
    most_cells: [u32; 2],
    sun: Option<DiskOfSun>,
) -> Option<Table> {
    let header = &view.textures[0];
    let columns = header.width.min(most_cells[0]);
    let rows = picture_rows.min(most_cells[1]);
    let across: Vec<Reads> = (0..columns).map(|cell| Reads::of_cell(cell, columns, header.width)).collect();
    let weights: Vec<(Vec<f64>, f64)> = (0..rows.div_ceil(ROWS_OF_BLOCK))
        .into_par_iter()
        .flat_map_iter(|block| {
            let mut texels = TexelRows { view, picture_rows, sun, across: &across, kept: Vec::new() };
            let block = block * ROWS_OF_BLOCK..rows.min((block + 1) * ROWS_OF_BLOCK);
            block.map(|row| texels.weights(row, rows)).collect::<Vec<_>>()
        })
        .collect();
    let of_sun: f64 = weights.iter().map(|(_, of_sun)| of_sun).sum();
    let row_weights: Vec<f64> = weights.iter().map(|(row, _)| row.iter().sum()).collect();
    let mut words = Vec::new();
    add_indexed(&mut words, &running_sums(&row_weights)?);
    for (row, _) in &weights {
        // A row without light is never chosen.
        add_indexed(&mut words, &running_sums(row).unwrap_or_else(|| vec![0; row.len() + 1]));
    }
    Some(Table { columns, rows, sun_share: of_sun / (of_sun + row_weights.iter().sum::<f64>()), words })
}

/// Rows of a table that are made one after the other, since neighbours read the same texels.
const ROWS_OF_BLOCK: u32 = 16;

/// Rows of a picture's texels, as the cells of a table see them.
struct TexelRows<'a> {
    view: &'a TextureView<'a>,
    picture_rows: u32,
    sun: Option<DiskOfSun>,
    /// What each cell reads of a row.
    across: &'a [Reads],
    /// The last few rows that were read.
    kept: Vec<TexelRow>,
}

/// A row of texels.
struct TexelRow {
    number: u32,
    /// The brightness that each cell sees.
    cells: Vec<f64>,
    /// The brightness that was the sun's.
    of_sun: f64,
}

impl TexelRows<'_> {
    /// A row of the table: every cell's brightness, times the sine of its angle from up, and what of the row was the sun's.
    fn weights(&mut self, row: u32, rows: u32) -> (Vec<f64>, f64) {
        let (mut sums, mut of_sun) = (vec![0.0; self.across.len()], 0.0);
        for (y, share) in Reads::of_cell(row, rows, self.picture_rows).texels() {
            let texels = self.row(y.clamp(0, i64::from(self.picture_rows) - 1) as u32);
            of_sun += share * texels.of_sun;
            for (sum, cell) in sums.iter_mut().zip(&texels.cells) {
                *sum += share * cell;
            }
        }
        let sine = elementary64::sin((f64::from(row) + 0.5) * PI / f64::from(rows));
        sums.iter_mut().for_each(|sum| *sum *= sine);
        (sums, of_sun * sine)
    }

    fn row(&mut self, number: u32) -> &TexelRow {
        // Two rows of the table share at most three.
        const KEPT: usize = 4;
        let at = self.kept.iter().position(|row| row.number == number).unwrap_or_else(|| {
            if self.kept.len() == KEPT {
                self.kept.remove(0);
            }
            self.kept.push(self.read(number));
            self.kept.len() - 1
        });
        &self.kept[at]
    }

    fn read(&self, number: u32) -> TexelRow {
        let width = self.view.textures[0].width;
        let mut texels: Vec<f64> =
            (0..width).map(|x| brightness(self.view, x, number, self.picture_rows)).collect();
        let taken = self.sun.map_or(0.0, |sun| take_away(sun, number, self.picture_rows, &mut texels));
        let read = |(x, share): (i64, f64)| texels[x.rem_euclid(i64::from(width)) as usize] * share;
        TexelRow {
            number,
            cells: self.across.iter().map(|reads| reads.texels().map(read).sum()).collect(),
            of_sun: taken * self.across.len() as f64 / f64::from(width),
        }
    }
}

/// Takes the sun's disk away from a row of texels, which get the brightness of one beside it; returns what it had. A row that is
/// all the sun's, at the zenith, keeps it.
fn take_away(sun: DiskOfSun, row: u32, rows: u32, texels: &mut [f64]) -> f64 {
    let (level, up) = elementary64::sin_cos((f64::from(row) + 0.5) * PI / f64::from(rows));
    let [x, y, z] = sun.middle;
    // No point of the row is nearer than that.
    if (up - y).abs() > sun.radius {
        return 0.0;
    }
    let columns = texels.len();
    let is_sun = |column: usize| {
        let (sine, cosine) = elementary64::sin_cos((column as f64 + 0.5) * TAU / columns as f64 - PI);
        let off = [level * cosine - x, up - y, level * sine - z];
        off.iter().map(|x| x * x).sum::<f64>() <= sun.radius * sun.radius
    };
    let of_sun: Vec<bool> = (0..columns).map(is_sun).collect();
    let Some(beside) = (0..columns).find(|&column| !of_sun[column] && of_sun[(column + 1) % columns]) else {
        return 0.0;
    };
    let instead = texels[beside];
    let mut taken = 0.0;
    for (texel, _) in texels.iter_mut().zip(&of_sun).filter(|(_, is_sun)| **is_sun) {
        taken += (*texel - instead).max(0.0);
        *texel = instead;
    }
    taken
}

/// Appends running sums and the index into them.
fn add_indexed(words: &mut Vec<u32>, sums: &[u32]) {
    words.extend(sums);
    for_index_words(sums, |word| words.push(word));
}

/// The sum of a texel's channels; 0 for what is no light, as pictures of other programs may have it: NaN, infinity, less than 0.
fn brightness(view: &TextureView, x: u32, y: u32, picture_rows: u32) -> f64 {
    let header = &view.textures[0];
    let middle = |k: u32, count: u32| (f64::from(k) + 0.5) / f64::from(count);
    let uv = [middle(x, header.width) as f32, (1.0 - middle(y, picture_rows)) as f32];
    let color = view.sample(0, &[uv, uv]).color;
    let sum = f64::from(color.x) + f64::from(color.y) + f64::from(color.z);
    if sum > 0.0 && sum.is_finite() { sum } else { 0.0 }
}

/// The texels that a cell shows between its borders along one axis, and how much of each: colours are interpolated, so a texel
/// reaches as far as the middles of its neighbours.
struct Reads {
    first: i64,
    shares: Vec<f64>,
}

impl Reads {
    fn of_cell(cell: u32, cells: u32, texels: u32) -> Reads {
        // The borders, in texels.
        let border = |k: u32| f64::from(k) * f64::from(texels) / f64::from(cells);
        let (from, to) = (border(cell), border(cell + 1));
        let first = (from - 0.5).floor() as i64;
        let last = (to + 0.5).floor() as i64;
        // Of a texel, up to a place: the integral of its tent.
        let up_to = |texel: i64, place: f64| {
            let x = (place - (texel as f64 + 0.5)).clamp(-1.0, 1.0);
            if x < 0.0 { 0.5 * (1.0 + x) * (1.0 + x) } else { 1.0 - 0.5 * (1.0 - x) * (1.0 - x) }
        };
        let share = |texel: i64| (up_to(texel, to) - up_to(texel, from)) / (to - from);
        Reads { first, shares: (first..=last).map(share).collect() }
    }

    fn texels(&self) -> impl Iterator<Item = (i64, f64)> {
        self.shares.iter().enumerate().map(|(k, &share)| (self.first + k as i64, share))
    }
}

/// Running sums of weights, from 0 to [`TABLE_UNIT`]; every weight over 0 has at least 1. `None` where all are 0.
fn running_sums(weights: &[f64]) -> Option<Vec<u32>> {
    let total: f64 = weights.iter().sum();
    if !(total > 0.0) {
        return None;
    }
    let count = weights.iter().filter(|weight| **weight > 0.0).count() as u32;
    let left = f64::from(TABLE_UNIT - count);
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
    sums[first_full..].fill(TABLE_UNIT);
    Some(sums)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_keep_every_weight() {
        let sums = running_sums(&[0.0, 1e-30, 3.0, 0.0, 1.0, 0.0]).unwrap();
        assert_eq!((sums[0], sums[1], sums[2]), (0, 0, 1));
        assert!((f64::from(sums[3] - sums[2]) / f64::from(TABLE_UNIT) - 0.75).abs() < 1e-6);
        assert_eq!((sums[4], sums[5], sums[6]), (sums[3], TABLE_UNIT, TABLE_UNIT));
        assert!(running_sums(&[0.0, 0.0]).is_none());
    }

    #[test]
    fn cells_read_the_texels_around_them() {
        let shares = |cell, cells, texels| {
            Reads::of_cell(cell, cells, texels).texels().filter(|(_, share)| *share > 0.0).collect::<Vec<_>>()
        };
        assert_eq!(shares(0, 4, 4), [(-1, 0.125), (0, 0.75), (1, 0.125)]);
        assert_eq!(shares(1, 2, 4), [(1, 0.0625), (2, 0.4375), (3, 0.4375), (4, 0.0625)]);
        for (cells, texels) in [(7, 16), (5, 5), (1, 1), (3, 100)] {
            let all: f64 = (0..cells).flat_map(|c| shares(c, cells, texels)).map(|(_, share)| share).sum();
            assert!((all - f64::from(cells)).abs() < 1e-12);
        }
    }
}
