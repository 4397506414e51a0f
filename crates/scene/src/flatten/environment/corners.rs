//! How bright the corners of the cells of an environment's table are: middles of texels, or of groups of them in large pictures.

use crate::sky::DiskOfSun;
use eosphor_core::math::elementary64;
use eosphor_core::texture::Textures as TextureView;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// The brightness of corners of cells, row by row, without that of the sun's disk, which stands beside it.
pub(super) fn corners(
    view: &TextureView,
    picture_rows: u32,
    most_cells: [u32; 2],
    sun: Option<DiskOfSun>,
) -> (Vec<Vec<f64>>, f64) {
    let header = &view.textures[0];
    let columns = header.width.min(most_cells[0]);
    let rows = picture_rows.min(most_cells[1]);
    let across: Vec<Reads> = (0..columns).map(|column| Reads::new(column, columns, header.width)).collect();
    let (corners, of_sun): (Vec<Vec<f64>>, Vec<f64>) = (0..rows.div_ceil(ROWS_OF_BLOCK))
        .into_par_iter()
        .flat_map_iter(|block| {
            let mut texels = TexelRows { view, picture_rows, sun, across: &across, kept: Vec::new() };
            let block = block * ROWS_OF_BLOCK..rows.min((block + 1) * ROWS_OF_BLOCK);
            block.map(|row| texels.corners(row, rows)).collect::<Vec<_>>()
        })
        .unzip();
    let sine = |row: u32| elementary64::sin((f64::from(row) + 0.5) * PI / f64::from(rows));
    (corners, (0..rows).zip(of_sun).map(|(row, of_sun)| of_sun * sine(row)).sum())
}

/// Rows of a table that are made one after the other, since neighbours read the same texels.
const ROWS_OF_BLOCK: u32 = 16;

/// Rows of a picture's texels, as the corners of cells see them.
struct TexelRows<'a> {
    view: &'a TextureView<'a>,
    picture_rows: u32,
    sun: Option<DiskOfSun>,
    /// What each corner reads of a row.
    across: &'a [Reads],
    /// The last few rows that were read.
    kept: Vec<TexelRow>,
}

/// A row of texels.
struct TexelRow {
    number: u32,
    /// The brightness that each corner sees.
    corners: Vec<f64>,
    /// The brightness that was the sun's.
    of_sun: f64,
}

impl TexelRows<'_> {
    /// The brightness of a row of corners, and what was the sun's.
    fn corners(&mut self, row: u32, rows: u32) -> (Vec<f64>, f64) {
        let (mut sums, mut of_sun) = (vec![0.0; self.across.len()], 0.0);
        for (y, share) in Reads::new(row, rows, self.picture_rows).texels() {
            let texels = self.row(y.clamp(0, i64::from(self.picture_rows) - 1) as u32);
            of_sun += share * texels.of_sun;
            for (sum, corner) in sums.iter_mut().zip(&texels.corners) {
                *sum += share * corner;
            }
        }
        (sums, of_sun)
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
            corners: self.across.iter().map(|reads| reads.texels().map(read).sum()).collect(),
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

/// The sum of a texel's channels; 0 for what is no light, as pictures of other programs may have it: NaN, infinity, less than 0.
fn brightness(view: &TextureView, x: u32, y: u32, picture_rows: u32) -> f64 {
    let header = &view.textures[0];
    let middle = |k: u32, count: u32| (f64::from(k) + 0.5) / f64::from(count);
    let uv = [middle(x, header.width) as f32, (1.0 - middle(y, picture_rows)) as f32];
    let color = view.sample(0, &[uv, uv]).color;
    let sum = f64::from(color.x) + f64::from(color.y) + f64::from(color.z);
    if sum > 0.0 && sum.is_finite() { sum } else { 0.0 }
}

/// The texels that a corner stands for along one axis, and how much of each: its own one where there are as many of both. In larger
/// pictures they are what is to be seen half-way to the next corners: colours are interpolated, so a texel reaches as far as the
/// middles of its neighbours.
struct Reads {
    first: i64,
    shares: Vec<f64>,
}

impl Reads {
    fn new(corner: u32, corners: u32, texels: u32) -> Reads {
        if corners == texels {
            return Reads { first: corner.into(), shares: vec![1.0] };
        }
        // The borders, in texels.
        let border = |k: u32| f64::from(k) * f64::from(texels) / f64::from(corners);
        let (from, to) = (border(corner), border(corner + 1));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_stand_for_the_texels_around_them() {
        let shares = |corner, corners, texels| {
            let reads = Reads::new(corner, corners, texels);
            reads.texels().filter(|(_, share)| *share > 0.0).collect::<Vec<_>>()
        };
        assert_eq!(shares(3, 4, 4), [(3, 1.0)]);
        assert_eq!(shares(1, 2, 4), [(1, 0.0625), (2, 0.4375), (3, 0.4375), (4, 0.0625)]);
        for (corners, texels) in [(7, 16), (5, 5), (1, 1), (3, 100)] {
            let all: f64 = (0..corners).flat_map(|c| shares(c, corners, texels)).map(|(_, s)| s).sum();
            assert!((all - f64::from(corners)).abs() < 1e-12);
        }
    }
}
