//! Colour textures.

use crate::math::{Vec3, clamp, floor, fma, vec3};

/// How a colour is read between texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[repr(u32)]
pub enum TextureFilter {
    /// The texel that holds the point.
    Nearest,
    /// Between the four texels whose centres surround the point.
    Bilinear,
}

/// What lies outside the unit square.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[repr(u32)]
pub enum TextureWrap {
    /// The texel at the border.
    Clamp,
    /// The texture again.
    Repeat,
    /// The texture mirrored, then again.
    Mirror,
}

/// What the texels of a texture are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum TexelFormat {
    /// 8 bits a channel, colours sRGB-coded, alpha linear: one word a texel, red in the low byte.
    Srgb8,
    /// 8 bits a channel, all linear: one word a texel, red in the low byte.
    Linear8,
    /// Single-precision floats: four words a texel, red first.
    Float,
}

/// Where a texture lies in the array of words and how it is read. `u` runs right and `v` runs up: `(0, 0)` is the
/// lower left corner of the picture, as in OBJ; rows are stored top first.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Texture {
    /// Number of the first word.
    pub first_word: u32,
    /// Texels a row, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// What the texels are.
    pub format: TexelFormat,
    /// Between texels.
    pub filter: TextureFilter,
    /// Outside the unit square, along `u`.
    pub wrap_u: TextureWrap,
    /// Outside the unit square, along `v`.
    pub wrap_v: TextureWrap,
    /// Which of the surface's texture coordinates it takes: 0 or 1.
    pub uv_set: u32,
    /// Takes the surface's (u, v, 1) to the picture's (u, v), row by row.
    pub picture_from_mesh_uv: [[f32; 3]; 2],
}

impl Texture {
    #[inline(always)]
    fn picture_uv(&self, uvs: &[[f32; 2]; 2]) -> [f32; 2] {
        let [u, v] = if self.uv_set == 0 { uvs[0] } else { uvs[1] };
        self.picture_from_mesh_uv.map(|row| fma(row[0], u, fma(row[1], v, row[2])))
    }
}

/// A colour with the share of the surface that is there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rgba {
    /// Linear.
    pub color: Vec3,
    /// Alpha.
    pub alpha: f32,
}

impl Rgba {
    /// White, and wholly there.
    pub const WHITE: Rgba = Rgba { color: Vec3::ONE, alpha: 1.0 };

    /// One of the four numbers: 0 red, 1 green, 2 blue, else alpha.
    #[inline(always)]
    pub fn channel(&self, channel: u32) -> f32 {
        match channel {
            0 => self.color.x,
            1 => self.color.y,
            2 => self.color.z,
            _ => self.alpha,
        }
    }

    /// This where `weight` is 0, `other` where it is 1.
    #[inline(always)]
    fn mix(&self, other: &Rgba, weight: f32) -> Rgba {
        Rgba {
            color: self.color.along(other.color + -self.color, weight),
            alpha: fma(other.alpha - self.alpha, weight, self.alpha),
        }
    }
}

/// Textures, the words of their texels, and the sRGB decoding table.
#[derive(Clone, Copy, Debug)]
pub struct Textures<'a> {
    /// Headers.
    pub textures: &'a [Texture],
    /// All texels.
    pub words: &'a [u32],
    /// Linear value of each sRGB byte.
    pub srgb_decode: &'a [f32; 256],
}

impl Textures<'_> {
    /// The linear colour and alpha of texture number `texture` at a point with these two sets of texture coordinates.
    ///
    /// Texel `i` of a row has its centre at `u = (i + 0.5) / width`. sRGB-coded texels are decoded before they are
    /// interpolated. Any coordinates are allowed: infinite ones and NaN read some texel of the texture. A number
    /// without texture gives zeros, and so do texels that a header promises but the array lacks.
    #[inline(always)]
    pub fn sample(&self, texture: u32, uvs: &[[f32; 2]; 2]) -> Rgba {
        let Some(t) = self.textures.get(texture as usize) else {
            return Rgba { color: Vec3::ZERO, alpha: 0.0 };
        };
        let [u, v] = t.picture_uv(uvs);
        // Rows are stored top first, v runs up.
        let x = wrapped(u, t.wrap_u) * t.width as f32;
        let y = (1.0 - wrapped(v, t.wrap_v)) * t.height as f32;
        match t.filter {
            TextureFilter::Nearest => self.texel(t, texel_at(x, t.width), texel_at(y, t.height)),
            TextureFilter::Bilinear => {
                let (left, right, right_weight) = neighbours(x, t.width, t.wrap_u);
                let (top, bottom, bottom_weight) = neighbours(y, t.height, t.wrap_v);
                let upper = self.texel(t, left, top).mix(&self.texel(t, right, top), right_weight);
                let lower = self.texel(t, left, bottom).mix(&self.texel(t, right, bottom), right_weight);
                upper.mix(&lower, bottom_weight)
            }
        }
    }

    /// Where texture number `texture` is read, before wrapping; the origin for a number without texture.
    #[inline(always)]
    pub fn picture_uv(&self, texture: u32, uvs: &[[f32; 2]; 2]) -> [f32; 2] {
        self.textures.get(texture as usize).map_or([0.0; 2], |t| t.picture_uv(uvs))
    }

    /// The decoded texel of a column and a row within the texture.
    #[inline(always)]
    fn texel(&self, t: &Texture, column: u32, row: u32) -> Rgba {
        debug_assert!(column < t.width && row < t.height);
        let number = row as usize * t.width as usize + column as usize;
        // Checked reads: headers come from scene data, and this costs little beside the read itself.
        let word = |i: usize| self.words.get(t.first_word as usize + i).copied().unwrap_or(0);
        if t.format == TexelFormat::Float {
            let value = |k: usize| f32::from_bits(word(4 * number + k));
            return Rgba { color: vec3(value(0), value(1), value(2)), alpha: value(3) };
        }
        let [r, g, b, alpha] = word(number).to_le_bytes();
        let linear = |byte: u8| byte as f32 / 255.0;
        let decode = |byte: u8| {
            if t.format == TexelFormat::Srgb8 { self.srgb_decode[byte as usize] } else { linear(byte) }
        };
        Rgba { color: vec3(decode(r), decode(g), decode(b)), alpha: linear(alpha) }
    }
}

/// A coordinate taken into [0, 1]; zero when it is NaN, or infinite and not clamped.
#[inline(always)]
fn wrapped(coordinate: f32, wrap: TextureWrap) -> f32 {
    let inside = match wrap {
        TextureWrap::Clamp => coordinate,
        TextureWrap::Repeat => coordinate - floor(coordinate),
        TextureWrap::Mirror => {
            // 0 to 2, then back from 1.
            let twice = coordinate - 2.0 * floor(coordinate * 0.5);
            if twice > 1.0 { 2.0 - twice } else { twice }
        }
    };
    clamp(inside, 0.0, 1.0)
}

/// The number of the texel that holds a place in [0, size]; the upper end belongs to the last texel.
#[inline(always)]
fn texel_at(place: f32, size: u32) -> u32 {
    (place as u32).min(size - 1)
}

/// The two texels whose centres surround a place in [0, size], and the weight of the second.
#[inline(always)]
fn neighbours(place: f32, size: u32, wrap: TextureWrap) -> (u32, u32, f32) {
    let place = place - 0.5;
    let whole = floor(place);
    let last = size - 1;
    let (before_first, after_last) = match wrap {
        // Beyond a mirrored border lies the border's own texel.
        TextureWrap::Clamp | TextureWrap::Mirror => (0, last),
        TextureWrap::Repeat => (last, 0),
    };
    let first = if whole < 0.0 { before_first } else { (whole as u32).min(last) };
    let second = (whole + 1.0) as u32;
    (first, if second > last { after_last } else { second }, place - whole)
}

#[cfg(test)]
mod tests {
    use super::*;
    use TextureFilter::{Bilinear, Nearest};
    use TextureWrap::{Clamp, Mirror, Repeat};

    /// 4 x 2 texels, top row first, behind two texels of another texture; no two channels of any two are equal.
    const TEXELS: [u32; 10] = [
        0xdead_beef,
        0xdead_beef, //
        0xff00_5001,
        0xff10_6011,
        0xff20_7021,
        0xff30_8031, //
        0x0040_9041,
        0x0050_a051,
        0x0060_b061,
        0x0070_c071,
    ];

    /// Stands for the sRGB table: any curve that is not a straight line.
    fn curve() -> [f32; 256] {
        core::array::from_fn(|byte| (byte * byte) as f32)
    }

    fn header(filter: TextureFilter, wrap: TextureWrap, srgb: bool) -> Texture {
        Texture {
            first_word: 2,
            width: 4,
            height: 2,
            format: if srgb { TexelFormat::Srgb8 } else { TexelFormat::Linear8 },
            filter,
            wrap_u: wrap,
            wrap_v: wrap,
            uv_set: 0,
            picture_from_mesh_uv: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        }
    }

    fn sample(filter: TextureFilter, wrap: TextureWrap, srgb: bool, u: f32, v: f32) -> Vec3 {
        let textures = [header(Nearest, Clamp, false), header(filter, wrap, srgb)];
        let textures = Textures { textures: &textures, words: &TEXELS, srgb_decode: &curve() };
        textures.sample(1, &[[u, v], [7.0, 7.0]]).color
    }

    fn linear(column: usize, row: usize) -> Vec3 {
        let [r, g, b, _] = TEXELS[2 + row * 4 + column].to_le_bytes();
        vec3(r as f32 / 255.0, g as f32 / 255.0, b as f32 / 255.0)
    }

    fn assert_near(got: Vec3, want: Vec3) {
        assert!((got - want).abs().max_component() < 1e-6, "{got:?} instead of {want:?}");
    }

    #[test]
    fn centres_give_exact_texels() {
        for filter in [Nearest, Bilinear] {
            for wrap in [Clamp, Repeat] {
                for (column, row) in (0..4).flat_map(|column| [(column, 0), (column, 1)]) {
                    // Row 0 is the upper one: v = 3/4.
                    let (u, v) = ((column as f32 + 0.5) / 4.0, 0.75 - row as f32 / 2.0);
                    assert_eq!(sample(filter, wrap, false, u, v), linear(column, row));
                    let [r, g, b, _] =
                        TEXELS[2 + row * 4 + column].to_le_bytes().map(|byte| curve()[byte as usize]);
                    assert_eq!(sample(filter, wrap, true, u, v), vec3(r, g, b));
                }
            }
        }
    }

    #[test]
    fn nearest_holds_a_whole_texel() {
        assert_eq!(sample(Nearest, Clamp, false, 0.25, 0.5), linear(1, 1));
        assert_eq!(sample(Nearest, Clamp, false, 0.249_999, 0.500_001), linear(0, 0));
        assert_eq!(sample(Nearest, Clamp, false, 0.0, 0.0), linear(0, 1));
        assert_eq!(sample(Nearest, Clamp, false, 1.0, 1.0), linear(3, 0));
        assert_eq!(sample(Nearest, Repeat, false, 1.0, 1.0), linear(0, 1));
    }

    #[test]
    fn bilinear_mixes_decoded_neighbours() {
        let middle = |a: Vec3, b: Vec3| (a + b) * 0.5;
        assert_near(sample(Bilinear, Clamp, false, 0.25, 0.75), middle(linear(0, 0), linear(1, 0)));
        assert_near(sample(Bilinear, Clamp, false, 0.125, 0.5), middle(linear(0, 0), linear(0, 1)));
        let quarter = linear(0, 0) * 0.75 + linear(1, 0) * 0.25;
        assert_near(sample(Bilinear, Clamp, false, 0.1875, 0.75), quarter);
        // 0x01 and 0x11: decoding first gives (1 + 289) / 2, not 9 squared.
        assert_eq!(sample(Bilinear, Clamp, true, 0.25, 0.75).x, 145.0);
    }

    #[test]
    fn repeat_wraps_around() {
        let seam = (linear(3, 0) + linear(0, 0)) * 0.5;
        assert_near(sample(Bilinear, Repeat, false, 0.0, 0.75), seam);
        assert_near(sample(Bilinear, Repeat, false, 1.0, 0.75), seam);
        assert_near(sample(Bilinear, Repeat, false, -1e-9, 0.75), seam);
        assert_near(sample(Bilinear, Repeat, false, 0.125, 0.0), (linear(0, 0) + linear(0, 1)) * 0.5);
        for shift in [-3.0, -1.0, 1.0, 8.0] {
            assert_eq!(sample(Nearest, Repeat, false, 0.375 + shift, 0.25 - shift), linear(1, 1));
            assert_eq!(sample(Bilinear, Repeat, false, 0.375 + shift, 0.25 - shift), linear(1, 1));
        }
    }

    #[test]
    fn clamp_holds_the_border() {
        for filter in [Nearest, Bilinear] {
            for far in [1.5, 1e30, f32::MAX] {
                assert_eq!(sample(filter, Clamp, false, far, far), linear(3, 0));
                assert_eq!(sample(filter, Clamp, false, -far, -far), linear(0, 1));
                assert_eq!(sample(filter, Clamp, false, -far, far), linear(0, 0));
            }
        }
    }

    #[test]
    fn any_coordinates_read_the_texture() {
        let odd =
            [f32::NAN, f32::INFINITY, -f32::INFINITY, f32::MAX, -f32::MAX, 1e9, -1e9, -1e-45, -0.0, 1e-45];
        for (u, v) in odd.into_iter().flat_map(|u| odd.map(|v| (u, v))) {
            for (filter, wrap) in [(Nearest, Clamp), (Nearest, Repeat), (Bilinear, Clamp), (Bilinear, Repeat)]
            {
                let c = sample(filter, wrap, false, u, v);
                // Blue tells the column, green the row: both within the texture's own values.
                assert!((0.0..=112.0 / 255.0).contains(&c.z), "{u} {v} {c:?}");
                assert!((79.9 / 255.0..=192.1 / 255.0).contains(&c.y), "{u} {v} {c:?}");
            }
        }
    }

    #[test]
    fn one_texel_and_missing_texels() {
        let one = Texture { first_word: 2, width: 1, height: 1, ..header(Bilinear, Repeat, false) };
        let missing = Texture { first_word: u32::MAX, ..one };
        let textures = [one, missing];
        let textures = Textures { textures: &textures, words: &TEXELS, srgb_decode: &curve() };
        for (u, v) in [(0.0, 0.0), (0.3, 0.9), (-7.1, 1.0)] {
            let sample = |texture| textures.sample(texture, &[[u, v]; 2]);
            assert_near(sample(0).color, linear(0, 0));
            assert_eq!(sample(1), Rgba { color: Vec3::ZERO, alpha: 0.0 });
            assert_eq!(sample(2), Rgba { color: Vec3::ZERO, alpha: 0.0 });
        }
    }

    #[test]
    fn mirror_turns_back_at_the_border() {
        for (u, v) in [(0.375, 0.25), (0.9, 0.6), (0.05, 0.95)] {
            for filter in [Nearest, Bilinear] {
                let want = sample(filter, Mirror, false, u, v);
                assert_near(want, sample(filter, Clamp, false, u, v));
                for (mu, mv) in [(-u, v), (2.0 - u, v), (u, -v), (u + 2.0, 2.0 - v), (u - 4.0, v - 2.0)] {
                    assert_near(sample(filter, Mirror, false, mu, mv), want);
                }
            }
        }
        assert_eq!(sample(Bilinear, Mirror, false, 1.0, 0.75), linear(3, 0));
    }

    #[test]
    fn floats_alpha_and_channels() {
        let words: Vec<u32> = [9.0f32, 1.5, -2.0, 3.0, 0.25, 4.0, 5.0, 6.0, 0.75].map(f32::to_bits).to_vec();
        let texture = Texture {
            first_word: 1,
            width: 2,
            height: 1,
            format: TexelFormat::Float,
            ..header(Bilinear, Clamp, false)
        };
        let textures = [texture, Texture { uv_set: 1, ..texture }];
        let textures = Textures { textures: &textures, words: &words, srgb_decode: &curve() };
        let left = textures.sample(0, &[[0.25, 0.5], [0.75, 0.5]]);
        assert_eq!(left, Rgba { color: vec3(1.5, -2.0, 3.0), alpha: 0.25 });
        assert_eq!([0, 1, 2, 3].map(|c| left.channel(c)), [1.5, -2.0, 3.0, 0.25]);
        let right = textures.sample(1, &[[0.25, 0.5], [0.75, 0.5]]);
        assert_eq!(right, Rgba { color: vec3(4.0, 5.0, 6.0), alpha: 0.75 });
        let middle = textures.sample(0, &[[0.5, 0.5]; 2]);
        assert_eq!((middle.color.x, middle.alpha), (2.75, 0.5));
    }

    #[test]
    fn coordinates_are_mapped_before_they_wrap() {
        // A quarter turn, half the size and a shift.
        let map = [[0.0, 0.5, 0.125], [-0.5, 0.0, 0.75]];
        let texture = Texture { picture_from_mesh_uv: map, ..header(Nearest, Repeat, false) };
        let textures = [texture];
        let textures = Textures { textures: &textures, words: &TEXELS, srgb_decode: &curve() };
        let got = textures.sample(0, &[[0.25, 0.5], [0.0; 2]]).color;
        assert_eq!(got, sample(Nearest, Repeat, false, 0.375, 0.625));
    }
}
