//! Textures: one array of texels, and the table that decodes sRGB.

use crate::error::{Problem, SceneError};
use crate::model::Scene;
use eosphor_core::math::elementary64;
use eosphor_core::texture::Texture;

/// All textures of a scene.
pub(super) struct Textures {
    pub(super) headers: Vec<Texture>,
    pub(super) texels: Vec<u32>,
}

pub(super) fn build(scene: &Scene) -> Result<Textures, SceneError> {
    let total: u64 = scene.textures.iter().map(|t| t.texels.len() as u64).sum();
    if total > u64::from(u32::MAX) {
        let message = format!("{total} texels are too many; the limit is 2^32 - 1. Use smaller pictures");
        return Err(Problem::new("textures", message).into());
    }
    let mut texels = Vec::with_capacity(total as usize);
    let mut headers = Vec::with_capacity(scene.textures.len());
    for t in &scene.textures {
        headers.push(Texture {
            first_texel: texels.len() as u32,
            width: t.width,
            height: t.height,
            filter: t.filter,
            wrap: t.wrap,
            srgb: scene.settings.srgb_textures,
        });
        texels.extend_from_slice(&t.texels);
    }
    Ok(Textures { headers, texels })
}

/// The linear value of each sRGB byte.
pub(super) fn srgb_decode() -> [f32; 256] {
    let mut table = [0.0; 256];
    for (byte, linear) in table.iter_mut().enumerate() {
        *linear = elementary64::srgb_to_linear(byte as f64 / 255.0) as f32;
    }
    table
}
