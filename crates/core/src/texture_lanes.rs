//! Colours of a texture at several points.

use crate::math::{Vec3Lanes, fma};
use crate::texture::{TexelFormat, Texture, TextureFilter, Textures, neighbours, radiance_channel, wrapped};

impl Textures<'_> {
    /// The colours that [`Textures::sample`] has at the points of those lanes that are wanted. Those of Radiance pictures, which
    /// most environments are, are computed together: what lanes read does not depend on each other, so it comes from memory
    /// together, and the rest are loops over arrays, free of branches.
    #[inline(always)]
    pub fn colors<const W: usize>(
        &self,
        texture: u32,
        uv: &[[f32; W]; 2],
        is_wanted: &[bool; W],
    ) -> Vec3Lanes<W> {
        if let Some(t) = self.textures.get(texture as usize)
            && t.format == TexelFormat::Rgbe
            && t.filter == TextureFilter::Bilinear
        {
            return self.radiance_between_texels(t, uv);
        }
        let at = |lane: usize| [[uv[0][lane], uv[1][lane]]; 2];
        for lane in 0..W {
            if is_wanted[lane] {
                self.prefetch(texture, &at(lane));
            }
        }
        let mut colors = Vec3Lanes::ZERO;
        for lane in 0..W {
            if is_wanted[lane] {
                colors.set(lane, self.sample(texture, &at(lane)).color);
            }
        }
        colors
    }

    /// Of a Radiance picture, between texels.
    #[inline(always)]
    fn radiance_between_texels<const W: usize>(&self, t: &Texture, uv: &[[f32; W]; 2]) -> Vec3Lanes<W> {
        let (mut columns, mut rows) = ([[0; W]; 2], [[0; W]; 2]);
        let mut weights = [[0.0; W]; 2];
        for lane in 0..W {
            let [u, v] = t.picture_uv(&[[uv[0][lane], uv[1][lane]]; 2]);
            let x = wrapped(u, t.wrap_u) * t.width as f32;
            let y = (1.0 - wrapped(v, t.wrap_v)) * t.height as f32;
            (columns[0][lane], columns[1][lane], weights[0][lane]) = neighbours(x, t.width, t.wrap_u);
            (rows[0][lane], rows[1][lane], weights[1][lane]) = neighbours(y, t.height, t.wrap_v);
        }
        let mut words = [[[0; W]; 2]; 2];
        for lane in 0..W {
            for row in 0..2 {
                for column in 0..2 {
                    let number = rows[row][lane] as usize * t.width as usize + columns[column][lane] as usize;
                    words[row][column][lane] =
                        self.words.get(t.first_word as usize + number).copied().unwrap_or(0);
                }
            }
        }
        let mut channels = [[0.0; W]; 3];
        for channel in 0..3 {
            for lane in 0..W {
                let texel =
                    |row: usize, column: usize| radiance_channel(words[row][column][lane], channel as u32);
                let between = |row: usize| mix(texel(row, 0), texel(row, 1), weights[0][lane]);
                channels[channel][lane] = mix(between(0), between(1), weights[1][lane]);
            }
        }
        Vec3Lanes::from_components(channels)
    }
}

/// As colours are mixed.
#[inline(always)]
fn mix(a: f32, b: f32, weight: f32) -> f32 {
    fma(b - a, weight, a)
}

#[cfg(test)]
mod tests {
    use crate::sampling::mix;
    use crate::texture::{
        MAX_TEXEL, TexelFormat, Texture, TextureFilter, TextureWrap, Textures, radiance_channel,
    };

    /// The definition, in double precision, which holds all of it exactly.
    #[test]
    fn every_mantissa_and_exponent_of_radiance_pictures() {
        for (mantissa, exponent) in (0..=255u32).flat_map(|m| (0..=255u32).map(move |e| (m, e))) {
            let exact = mantissa as f64 * 2f64.powi(exponent as i32 - 136);
            let expected = if exponent == 0 { 0.0 } else { (exact as f32).min(MAX_TEXEL) };
            let got = radiance_channel(exponent << 24 | mantissa << 8 | (255 - mantissa), 1);
            assert_eq!(got.to_bits(), expected.to_bits(), "{mantissa} {exponent}");
        }
    }

    #[test]
    fn lanes_have_the_colors_of_points() {
        let words: Vec<u32> = (0..7 * 5 * 4).map(mix).collect();
        let table = [0.5; 256];
        for format in [TexelFormat::Rgbe, TexelFormat::Srgb8] {
            for filter in [TextureFilter::Bilinear, TextureFilter::Nearest] {
                for wrap in [TextureWrap::Repeat, TextureWrap::Clamp, TextureWrap::Mirror] {
                    let texture = Texture {
                        first_word: 3,
                        width: 7,
                        height: 5,
                        format,
                        channels: 3,
                        filter,
                        wrap_u: wrap,
                        wrap_v: TextureWrap::Clamp,
                        uv_set: 0,
                        picture_from_mesh_uv: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
                    };
                    let textures = Textures { textures: &[texture], words: &words, srgb_decode: &table };
                    let number = |k: usize| mix(k as u32) as f32 / u32::MAX as f32 * 1.4 - 0.2;
                    let mut uv = [std::array::from_fn(number), std::array::from_fn(|k| number(k + 16))];
                    (uv[0][3], uv[1][4], uv[0][5], uv[1][6]) = (f32::NAN, f32::INFINITY, 1.0, 0.0);
                    let colors = textures.colors::<16>(0, &uv, &[true; 16]);
                    for k in 0..16 {
                        let point = [uv[0][k], uv[1][k]];
                        assert_eq!(colors.get(k), textures.sample(0, &[point; 2]).color);
                    }
                }
            }
        }
    }
}
