//! A texture of oak staves in herringbone, made by whole numbers alone: the same bytes on every machine.

use crate::model::{Image, Texels};
use eosphor_core::sampling::hash_pair;

/// What names it where a texture file is asked for.
pub(crate) const PARQUET: &str = "builtin:parquet";

/// Texels a side. The picture repeats without a seam.
const SIDE: u32 = 1024;

/// Width of a stave in texels.
const WIDTH: i32 = 32;

/// Length of a stave in widths.
const LENGTH: i32 = 4;

/// Darkest and lightest wood, sRGB-coded.
const DARK: [u32; 3] = [92, 52, 26];
const LIGHT: [u32; 3] = [204, 146, 90];

/// The picture.
pub(crate) fn parquet() -> Image {
    let texels = (0..SIDE * SIDE).map(|i| texel((i % SIDE) as i32, (i / SIDE) as i32)).collect();
    Image { name: "parquet".into(), width: SIDE, height: SIDE, texels: Texels::rgba8(texels) }
}

fn texel(x: i32, y: i32) -> u32 {
    let stave = Stave::at(x, y);
    let edge = [stave.along, stave.across, LENGTH * WIDTH - 1 - stave.along, WIDTH - 1 - stave.across];
    // Joints are dark, and the edges beside them are rounded off.
    let light = match edge.into_iter().min() {
        Some(0) => 110,
        Some(1) => 215,
        _ => 256,
    };
    let wood = stave.wood();
    let [r, g, b] = [0, 1, 2].map(|c| ((DARK[c] * 256 + (LIGHT[c] - DARK[c]) * wood) * light) >> 16);
    u32::from_le_bytes([r as u8, g as u8, b as u8, 255])
}

/// A place on a stave.
struct Stave {
    /// Texels along it and across, from its corner.
    along: i32,
    across: i32,
    /// Its own random number.
    key: u32,
}

impl Stave {
    /// In herringbone, square cells of a row belong to lying and standing staves by turns, `LENGTH` of each, and each row
    /// is moved on by one.
    fn at(x: i32, y: i32) -> Stave {
        let (column, row) = (x / WIDTH, y / WIDTH);
        let turn = (column - row).rem_euclid(2 * LENGTH);
        let key = |column: i32, row: i32, standing: u32| {
            let [column, row] = [column, row].map(|n| n.rem_euclid(SIDE as i32 / WIDTH) as u32);
            hash_pair(hash_pair(standing, column), row)
        };
        if turn < LENGTH {
            let along = turn * WIDTH + x % WIDTH;
            Stave { along, across: y % WIDTH, key: key(column - turn, row, 0) }
        } else {
            let cells = 2 * LENGTH - 1 - turn;
            let along = cells * WIDTH + y % WIDTH;
            Stave { along, across: x % WIDTH, key: key(column, row - cells, 1) }
        }
    }

    /// How light the wood is, 0 to 256: the stave's own tone, year rings that wander along it, and fibres.
    fn wood(&self) -> u32 {
        let (along, across) = (self.along as u32, self.across as u32);
        let wander = noise(along * 4, across * 10, self.key);
        // Rings: a wave of equal slopes over the way across, bent by the noise.
        let phase = (across * (10 + (self.key >> 28)) + wander * 2 + (self.key & 0xff)) & 0x1ff;
        let rings = if phase < 256 { phase } else { 511 - phase };
        let fibres = noise(along * 9, across * 200, !self.key);
        let tone = (self.key >> 8) & 0xff;
        (tone * 110 + rings * 74 + fibres * 72) >> 8
    }
}

/// Smooth noise, 0 to 255, between random numbers at the whole multiples of 256.
fn noise(x: u32, y: u32, key: u32) -> u32 {
    let (i, j) = (x >> 8, y >> 8);
    // 3 t^2 - 2 t^3 in 256ths.
    let smooth = |t: u32| (t * t * (768 - 2 * t)) >> 16;
    let (s, t) = (smooth(x & 0xff), smooth(y & 0xff));
    let at = |i: u32, j: u32| hash_pair(hash_pair(key, i), j) & 0xff;
    let mix = |a: u32, b: u32, share: u32| (a * (256 - share) + b * share) >> 8;
    mix(mix(at(i, j), at(i + 1, j), s), mix(at(i, j + 1), at(i + 1, j + 1), s), t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn staves_have_their_size_and_meet_at_the_seam() {
        let mut area = std::collections::HashMap::new();
        for y in 0..SIDE as i32 {
            for x in 0..SIDE as i32 {
                let stave = Stave::at(x, y);
                assert!((0..LENGTH * WIDTH).contains(&stave.along) && (0..WIDTH).contains(&stave.across));
                *area.entry(stave.key).or_insert(0) += 1;
            }
        }
        assert!(area.values().all(|&texels| texels == WIDTH * WIDTH * LENGTH));
        assert_eq!(area.len() as i32 * WIDTH * WIDTH * LENGTH, (SIDE * SIDE) as i32);
    }

    #[test]
    fn the_picture_is_always_the_same() {
        let texels = parquet().texels;
        let hash = texels.words().iter().fold(0, |hash, &t| hash_pair(hash, t));
        assert_eq!((texels.len(), hash), (1024 * 1024, 0x8caf_9cef));
    }
}
