//! Colour textures.

use crate::math::{Vec3, clamp, floor, vec3};

/// How a colour is read between texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
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
#[repr(u32)]
pub enum TextureWrap {
    /// The texel at the border.
    Clamp,
    /// The texture again.
    Repeat,
}

/// Where a texture lies in the array of texels and how it is read. `u` runs right and `v` runs up: `(0, 0)` is the
/// lower left corner of the picture, as in OBJ; rows are stored top first.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Texture {
    /// Number of the first texel.
    pub first_texel: u32,
    /// Texels a row, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// Between texels.
    pub filter: TextureFilter,
    /// Outside the unit square.
    pub wrap: TextureWrap,
    /// Texel bytes are sRGB-coded; otherwise they are linear.
    pub srgb: bool,
}

/// Textures, their texels (8-bit R, G, B, A from the low byte up) and the sRGB decoding table.
#[derive(Clone, Copy, Debug)]
pub struct Textures<'a> {
    /// Headers.
    pub textures: &'a [Texture],
    /// All texels.
    pub texels: &'a [u32],
    /// Linear value of each sRGB byte.
    pub srgb_decode: &'a [f32; 256],
}

impl Textures<'_> {
    /// The linear colour of texture number `texture` at `(u, v)`; alpha is ignored.
    ///
    /// Texel `i` of a row has its centre at `u = (i + 0.5) / width`. sRGB-coded texels are decoded before they are
    /// interpolated. Any coordinates are allowed: infinite ones and NaN read some texel of the texture. A number
    /// without texture gives black, and so do texels that a header promises but the array lacks.
    #[inline(always)]
    pub fn sample(&self, texture: u32, u: f32, v: f32) -> Vec3 {
        let Some(t) = self.textures.get(texture as usize) else { return Vec3::ZERO };
        // Rows are stored top first, v runs up.
        let x = wrapped(u, t.wrap) * t.width as f32;
        let y = (1.0 - wrapped(v, t.wrap)) * t.height as f32;
        match t.filter {
            TextureFilter::Nearest => self.texel(t, texel_at(x, t.width), texel_at(y, t.height)),
            TextureFilter::Bilinear => {
                let (left, right, right_weight) = neighbours(x, t.width, t.wrap);
                let (top, bottom, bottom_weight) = neighbours(y, t.height, t.wrap);
                let upper = mix_colors(self.texel(t, left, top), self.texel(t, right, top), right_weight);
                let lower =
                    mix_colors(self.texel(t, left, bottom), self.texel(t, right, bottom), right_weight);
                mix_colors(upper, lower, bottom_weight)
            }
        }
    }

    /// The decoded texel of a column and a row within the texture.
    #[inline(always)]
    fn texel(&self, t: &Texture, column: u32, row: u32) -> Vec3 {
        debug_assert!(column < t.width && row < t.height);
        let number = t.first_texel as usize + row as usize * t.width as usize + column as usize;
        // A checked read: headers come from scene data, and this costs little beside the read itself.
        let [r, g, b, _] = self.texels.get(number).copied().unwrap_or(0).to_le_bytes();
        let decode = |byte: u8| if t.srgb { self.srgb_decode[byte as usize] } else { byte as f32 / 255.0 };
        vec3(decode(r), decode(g), decode(b))
    }
}

/// A coordinate taken into [0, 1]; zero when it is NaN, or infinite and repeated.
#[inline(always)]
fn wrapped(coordinate: f32, wrap: TextureWrap) -> f32 {
    let inside = match wrap {
        TextureWrap::Clamp => coordinate,
        TextureWrap::Repeat => coordinate - floor(coordinate),
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
        TextureWrap::Clamp => (0, last),
        TextureWrap::Repeat => (last, 0),
    };
    let first = if whole < 0.0 { before_first } else { (whole as u32).min(last) };
    let second = (whole + 1.0) as u32;
    (first, if second > last { after_last } else { second }, place - whole)
}

/// `a` where `weight` is 0, `b` where it is 1.
#[inline(always)]
fn mix_colors(a: Vec3, b: Vec3, weight: f32) -> Vec3 {
    a.along(b + -a, weight)
}

#[cfg(test)]
mod tests {
    use super::*;
    use TextureFilter::{Bilinear, Nearest};
    use TextureWrap::{Clamp, Repeat};

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
        Texture { first_texel: 2, width: 4, height: 2, filter, wrap, srgb }
    }

    fn sample(filter: TextureFilter, wrap: TextureWrap, srgb: bool, u: f32, v: f32) -> Vec3 {
        let textures = [header(Nearest, Clamp, false), header(filter, wrap, srgb)];
        Textures { textures: &textures, texels: &TEXELS, srgb_decode: &curve() }.sample(1, u, v)
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
            for far in [1.5, 1e30, f32::INFINITY] {
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
        let one = Texture { first_texel: 2, width: 1, height: 1, ..header(Bilinear, Repeat, false) };
        let missing = Texture { first_texel: u32::MAX, ..one };
        let textures = [one, missing];
        let textures = Textures { textures: &textures, texels: &TEXELS, srgb_decode: &curve() };
        for (u, v) in [(0.0, 0.0), (0.3, 0.9), (-7.1, 1.0)] {
            assert_near(textures.sample(0, u, v), linear(0, 0));
            assert_eq!(textures.sample(1, u, v), Vec3::ZERO);
            assert_eq!(textures.sample(2, u, v), Vec3::ZERO);
        }
    }
}
