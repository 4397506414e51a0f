//! Textures: one array of words for all texels, and the table that decodes sRGB.

use crate::error::{Problem, SceneError};
use crate::model::{Scene, Texels, TextureContent};
use eosphor_core::math::elementary64;
use eosphor_core::texture::{TexelFormat, Texture};

/// All textures of a scene.
pub(super) struct Textures {
    pub(super) headers: Vec<Texture>,
    pub(super) words: Vec<u32>,
}

pub(super) fn build(scene: &Scene) -> Result<Textures, SceneError> {
    let words_of = |texels: &Texels| match texels {
        Texels::Rgba8(texels) => texels.len() as u64,
        Texels::Float(texels) => texels.len() as u64 * 4,
    };
    let total: u64 = scene.images.iter().map(|image| words_of(&image.texels)).sum();
    if total > u64::from(u32::MAX) {
        let message = format!(
            "{total} words of texels are too many (1 a texel of 8 bits, 4 of floats); the limit is 2^32 - 1. Use \
             smaller pictures"
        );
        return Err(Problem::new("textures", message).into());
    }
    let mut words = Vec::with_capacity(total as usize);
    let mut first_words = Vec::with_capacity(scene.images.len());
    for image in &scene.images {
        first_words.push(words.len() as u32);
        match &image.texels {
            Texels::Rgba8(texels) => words.extend_from_slice(texels),
            Texels::Float(texels) => words.extend(texels.iter().flatten().map(|x| x.to_bits())),
        }
    }
    let header = |t: &crate::model::Texture| {
        let image = &scene.images[t.image as usize];
        Texture {
            first_word: first_words[t.image as usize],
            width: image.width,
            height: image.height,
            format: match (&image.texels, t.content) {
                (Texels::Float(_), _) => TexelFormat::Float,
                (_, TextureContent::Color) if scene.settings.srgb_textures => TexelFormat::Srgb8,
                _ => TexelFormat::Linear8,
            },
            filter: t.filter,
            wrap_u: t.wrap_u,
            wrap_v: t.wrap_v,
            uv_set: t.uv_set,
            picture_from_mesh_uv: t.picture_from_mesh_uv,
        }
    };
    Ok(Textures { headers: scene.textures.iter().map(header).collect(), words })
}

/// The linear value of each sRGB byte.
pub(super) fn srgb_decode() -> [f32; 256] {
    let mut table = [0.0; 256];
    for (byte, linear) in table.iter_mut().enumerate() {
        *linear = elementary64::srgb_to_linear(byte as f64 / 255.0) as f32;
    }
    table
}
