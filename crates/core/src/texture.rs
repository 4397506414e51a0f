//! Colour textures.

use crate::math::{Vec3, clamp, floor, fma, min, vec3};
use crate::memory::prefetch;
use crate::out_of_line::{out_of_line, out_of_line_on_gpus};

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

/// What the components of a texture's texels are. A texel has 1 to 4 of them, without gaps to the next texel's: grey; grey
/// and alpha; red, green and blue; these and alpha. Bytes and halves fill words from the low end up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum TexelFormat {
    /// Bytes, colours sRGB-coded, alpha linear.
    Srgb8,
    /// Bytes, all linear.
    Linear8,
    /// A word a texel, whatever the number of components: bytes of red, green, blue and their exponent, as in Radiance
    /// pictures, from the low byte up.
    Rgbe,
    /// Half-precision floats as in OpenEXR pictures: not negative, colours multiplied by alpha; infinity is
    /// [`MAX_TEXEL`].
    Half,
    /// Single-precision floats.
    Float,
}

/// The largest texel: infinity in a picture file is read as this. Scenes have no larger number either.
pub const MAX_TEXEL: f32 = 1e12;

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
    /// What the components are.
    pub format: TexelFormat,
    /// Components of a texel, 1 to 4.
    pub channels: u32,
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
    pub(crate) fn picture_uv(&self, uvs: &[[f32; 2]; 2]) -> [f32; 2] {
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
    pub(crate) fn mix(&self, other: &Rgba, weight: f32) -> Rgba {
        Rgba {
            color: self.color.plus_scaled(other.color + -self.color, weight),
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

    /// Tells memory that [`Textures::sample`] will read a point.
    #[inline(always)]
    pub fn prefetch(&self, texture: u32, uvs: &[[f32; 2]; 2]) {
        let Some(t) = self.textures.get(texture as usize) else { return };
        let [u, v] = t.picture_uv(uvs);
        let column = texel_at(wrapped(u, t.wrap_u) * t.width as f32, t.width);
        // Texels about the point: of a row, they are mostly in one line of the cache.
        let y = (1.0 - wrapped(v, t.wrap_v)) * t.height as f32 - 0.5;
        let bytes = match t.format {
            TexelFormat::Float => 4 * t.channels,
            TexelFormat::Half => 2 * t.channels,
            TexelFormat::Rgbe => 4,
            TexelFormat::Srgb8 | TexelFormat::Linear8 => t.channels,
        };
        for row in [texel_at(y, t.height), texel_at(y + 1.0, t.height)] {
            let number = row as usize * t.width as usize + column as usize;
            prefetch(self.words, t.first_word as usize + number * bytes as usize / 4);
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
        let channels = t.channels as usize;
        // Checked reads: headers come from scene data, and this costs little beside the read itself.
        let word = |i: usize| self.words.get(t.first_word as usize + i).copied().unwrap_or(0);
        if t.format == TexelFormat::Float {
            let [first, second, third, fourth] =
                [0, 1, 2, 3].map(|k| f32::from_bits(word(number * channels + k)));
            let (green, blue) = if channels < 3 { (first, first) } else { (second, third) };
            let last = if channels == 2 { second } else { fourth };
            let alpha = if channels & 1 == 0 { last } else { 1.0 };
            return Rgba { color: vec3(first, green, blue), alpha };
        }
        // On GPUs there is one function for all such texels.
        if cfg!(not(target_arch = "nvptx64")) & (t.format == TexelFormat::Rgbe) {
            return Rgba { color: radiance(word(number)), alpha: 1.0 };
        }
        let is_bytes = matches!(t.format, TexelFormat::Srgb8 | TexelFormat::Linear8);
        let packed = if is_bytes & (channels == 4) {
            // The quick way for most.
            word(number)
        } else {
            let size = match t.format {
                TexelFormat::Rgbe => 4,
                TexelFormat::Half => 2 * channels,
                _ => channels,
            };
            // A texel may lie across the border of two words, but then has no part in a third.
            let byte = number * size;
            let (low, high, shift) = (word(byte / 4), word(byte / 4 + 1), byte as u32 % 4 * 8);
            if !is_bytes {
                return high_range_texel(low, high, shift, t.channels, t.format == TexelFormat::Half);
            }
            // In two steps, since shifting by 32 is none.
            with_all_channels(low >> shift | high << 1 << (31 - shift), t.channels)
        };
        let [r, g, b, alpha] = packed.to_le_bytes();
        let linear = |byte: u8| byte as f32 / 255.0;
        let decode = |byte: u8| {
            if t.format == TexelFormat::Srgb8 { self.srgb_decode[byte as usize] } else { linear(byte) }
        };
        Rgba { color: vec3(decode(r), decode(g), decode(b)), alpha: linear(alpha) }
    }
}

out_of_line_on_gpus! {
    /// The colour that [`Textures::sample`] finds, for rarer readers: what surrounds a scene, lamps.
    pub(crate) fn color_at(textures: &Textures<'_>, texture: u32, uvs: &[[f32; 2]; 2]) -> Vec3 {
        textures.sample(texture, uvs).color
    }
}

out_of_line! {
    /// A texel of halves, or of a Radiance picture, which begins at bit `shift` of two words. Few pictures are of these, and
    /// the code is long.
    fn high_range_texel(low: u32, high: u32, shift: u32, channels: u32, is_half: bool) -> Rgba {
        let bits = (low as u64 | (high as u64) << 32) >> shift;
        if !is_half {
            return Rgba { color: radiance(bits as u32), alpha: 1.0 };
        }
        let value = |k: u32| half((bits >> (k * 16)) as u32);
        let red = value(0);
        let (green, blue) = if channels < 3 { (red, red) } else { (value(1), value(2)) };
        let alpha = match channels {
            2 => value(1),
            4 => value(3),
            _ => 1.0,
        };
        let divisor = if alpha > 0.0 { alpha } else { 1.0 };
        let plain = |x: f32| min(x / divisor, MAX_TEXEL);
        Rgba { color: vec3(plain(red), plain(green), plain(blue)), alpha }
    }
}

/// Bytes of 1 to 3 channels, in the low end of a word, as four: red, green, blue and alpha.
#[inline(always)]
fn with_all_channels(bytes: u32, channels: u32) -> u32 {
    let opaque = 0xff00_0000;
    let grey = (bytes & 0xff) * 0x01_0101;
    match channels {
        1 => opaque | grey,
        2 => (bytes & 0xff00) << 16 | grey,
        _ => opaque | bytes,
    }
}

/// The colour of a texel of a Radiance picture: mantissas times 2^(exponent - 136), all 0 where the exponent is 0.
#[inline(always)]
fn radiance(word: u32) -> Vec3 {
    vec3(radiance_channel(word, 0), radiance_channel(word, 1), radiance_channel(word, 2))
}

/// One channel of that.
#[inline(always)]
pub(crate) fn radiance_channel(word: u32, channel: u32) -> f32 {
    let (mantissa, exponent) = ((word >> (8 * channel)) & 0xff, word >> 24);
    // 2^(exponent - 127), but for the two largest exponents, which are far beyond the limit, as 253 is. Multiplying by
    // powers of two is exact: even what is denormal is a multiple of 2^-135.
    let scale = f32::from_bits(exponent.min(253) << 23);
    min(mantissa as f32 * (1.0 / 512.0) * scale, MAX_TEXEL)
}

/// The number that 16 bits are as a half-precision float, exactly; infinity is [`MAX_TEXEL`]. The sign and all higher bits
/// are left out.
#[inline(always)]
fn half(bits: u32) -> f32 {
    let bits = bits & 0x7fff;
    let value = match bits {
        // Denormal: whole multiples of 2^-24.
        0..=0x3ff => bits as f32 * f32::from_bits((127 - 24) << 23),
        // Exponents count from 127 instead of 15.
        _ => f32::from_bits((bits << 13) + ((127 - 15) << 23)),
    };
    if bits < 0x7c00 { value } else { MAX_TEXEL }
}

/// A coordinate taken into [0, 1]; zero when it is NaN, or infinite and not clamped.
#[inline(always)]
pub(crate) fn wrapped(coordinate: f32, wrap: TextureWrap) -> f32 {
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
pub(crate) fn neighbours(place: f32, size: u32, wrap: TextureWrap) -> (u32, u32, f32) {
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
            channels: 4,
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

    /// Texels in bytes, four of them a texel, packed as files have `channels` of them.
    fn packed(texels: &[[u8; 4]], channels: usize) -> Vec<u32> {
        let bytes: Vec<u8> = texels
            .iter()
            .flat_map(|&[r, g, b, a]| match channels {
                1 => vec![r],
                2 => vec![r, a],
                3 => vec![r, g, b],
                _ => vec![r, g, b, a],
            })
            .collect();
        let word = |bytes: &[u8]| bytes.iter().rev().fold(0, |word, &byte| word << 8 | byte as u32);
        // Nothing lies behind the last texel.
        bytes.chunks(4).map(word).collect()
    }

    /// What a texture of these gives at places between and on its texels.
    fn samples(texture: &Texture, words: &[u32]) -> Vec<Rgba> {
        let textures = [Nearest, Bilinear].map(|filter| Texture { filter, ..*texture });
        let textures = Textures { textures: &textures, words, srgb_decode: &curve() };
        let places = (0..4 * texture.width).map(|i| (i as f32 + 0.7) / (4 * texture.width) as f32);
        places.flat_map(|x| [0, 1].map(|number| textures.sample(number, &[[x, 1.3 * x]; 2]))).collect()
    }

    /// Bits of colour and alpha.
    fn bits(samples: &[Rgba]) -> Vec<[u32; 4]> {
        let bits = |s: &Rgba| [s.color.x, s.color.y, s.color.z, s.alpha].map(f32::to_bits);
        samples.iter().map(bits).collect()
    }

    /// All 256 values in each channel, behind another texture, at any place within a word.
    #[test]
    fn fewer_bytes_are_what_four_of_them_are() {
        let texels = |channels: usize| -> Vec<[u8; 4]> {
            let all = (0..3 * 256u32).map(|i| [i, i * 7 + 1, i * 31 + 2, i * 101 + 3].map(|x| x as u8));
            all.map(|[r, g, b, a]| match channels {
                1 => [r, r, r, 255],
                2 => [r, r, r, a],
                3 => [r, g, b, 255],
                _ => [r, g, b, a],
            })
            .collect()
        };
        for (channels, srgb) in (1..=4).flat_map(|channels| [(channels, false), (channels, true)]) {
            let texels = texels(channels as usize);
            let texture = Texture { first_word: 1, width: 256, height: 3, ..header(Nearest, Repeat, srgb) };
            let words = |channels| [vec![0xdead_beef], packed(&texels, channels)].concat();
            let expected = samples(&texture, &words(4));
            let got = samples(&Texture { channels, ..texture }, &words(channels as usize));
            assert_eq!(bits(&got), bits(&expected), "{channels} {srgb}");
        }
    }

    #[test]
    fn every_half_is_exact() {
        for bits in 0..0x7c00u32 {
            let (exponent, mantissa) = ((bits >> 10) as i32, (bits & 0x3ff) as f64);
            let expected = match exponent {
                0 => mantissa * 2f64.powi(-24),
                _ => (1024.0 + mantissa) * 2f64.powi(exponent - 25),
            };
            assert_eq!(half(0xabcd_0000 | bits) as f64, expected, "{bits:x}");
        }
        assert_eq!((half(0x3c00), half(0x7bff), half(0x7c00)), (1.0, 65_504.0, MAX_TEXEL));
    }

    /// Halves and floats of 1 to 4 components, against floats of four.
    #[test]
    fn floats_of_all_numbers_of_components() {
        // 0, 1/4, 1/2, ... and alpha.
        let of = |i: u32, k: u32| if k == 3 { (i % 5) as f32 * 0.25 } else { (i * 3 + k) as f32 * 0.25 };
        let half_of = |x: f32| if x == 0.0 { 0 } else { (x.to_bits() >> 13) - (112 << 10) };
        for channels in 1..=4u32 {
            let source = |k: u32| match (channels, k) {
                (1 | 2, 0..=2) => Some(0),
                (1 | 3, 3) => None,
                _ => Some(k),
            };
            let at = |i: u32, k: u32| source(k).map_or(1.0, |k| of(i, k));
            let stored = |i: u32| (0..4).filter(move |&k| source(k) == Some(k)).map(move |k| of(i, k));
            let texture = Texture {
                first_word: 0,
                width: 7,
                height: 3,
                channels: 4,
                format: TexelFormat::Float,
                ..header(Nearest, Repeat, false)
            };
            let plain: Vec<u32> = (0..21).flat_map(|i| (0..4).map(move |k| at(i, k).to_bits())).collect();
            let floats: Vec<u32> = (0..21).flat_map(stored).map(f32::to_bits).collect();
            assert_eq!(floats.len(), 21 * channels as usize);
            let got = samples(&Texture { channels, ..texture }, &floats);
            assert_eq!(bits(&got), bits(&samples(&texture, &plain)), "{channels}");

            let divided =
                |i: u32, k: u32| if k < 3 && at(i, 3) > 0.0 { at(i, k) / at(i, 3) } else { at(i, k) };
            let plain: Vec<u32> =
                (0..21).flat_map(|i| (0..4).map(move |k| divided(i, k).to_bits())).collect();
            let halves: Vec<u32> = (0..21).flat_map(stored).map(half_of).collect();
            let halves: Vec<u32> =
                halves.chunks(2).map(|h| h[0] | h.get(1).copied().unwrap_or(0) << 16).collect();
            let got = samples(&Texture { channels, format: TexelFormat::Half, ..texture }, &halves);
            assert_eq!(bits(&got), bits(&samples(&texture, &plain)), "{channels}");
        }
        // Beyond the limit is at it, by infinity and by division.
        let texture =
            Texture { first_word: 0, width: 1, height: 1, channels: 4, ..header(Nearest, Clamp, false) };
        let texture = Texture { format: TexelFormat::Half, ..texture };
        let got = samples(&texture, &[0x7bff_7c00, 0x0001_0000])[0];
        assert_eq!(got, Rgba { color: vec3(MAX_TEXEL, MAX_TEXEL, 0.0), alpha: 2f32.powi(-24) });
    }
}
