//! What a material's textures say at a point.

use crate::material::{AlphaUse, Material, NONE, ScalarTexture};
use crate::math::{Vec3, clamp};
use crate::texture::{Rgba, Textures};

/// What a material's textures say at a point; white where it has none.
pub struct MaterialTexels {
    pub(super) diffuse: Rgba,
    pub(super) specular: Rgba,
    pub(super) emission: Rgba,
    pub(super) metallic: f32,
    pub(super) roughness: f32,
    pub(super) transmission: f32,
    opacity: f32,
    /// The normal in tangent space, as a colour.
    pub(super) normal: Vec3,
}

impl MaterialTexels {
    /// Of a material without textures.
    pub(super) const WHITE: MaterialTexels = MaterialTexels {
        diffuse: Rgba::WHITE,
        specular: Rgba::WHITE,
        emission: Rgba::WHITE,
        metallic: 1.0,
        roughness: 1.0,
        transmission: 1.0,
        opacity: 1.0,
        normal: Vec3::ONE,
    };

    /// Samples all textures of a material at `uvs`, the point's two sets of texture coordinates. Properties without a texture
    /// get white.
    #[inline(always)]
    pub fn new(textures: &Textures, m: &Material, uvs: &[[f32; 2]; 2]) -> MaterialTexels {
        let mut texels = [Rgba::WHITE; 8];
        if m.is_textured {
            let slots = m.textures();
            // A loop, so that the code that reads a texture is there once: it is long and inlined.
            for slot in 0..slots.len() {
                if slots[slot] != NONE {
                    texels[slot] = textures.sample(slots[slot], uvs);
                }
            }
        }
        let scalar = |slot: usize, texture: &ScalarTexture| texels[slot].channel(texture.channel);
        MaterialTexels {
            diffuse: texels[0],
            specular: texels[1],
            emission: texels[2],
            metallic: scalar(3, &m.metallic_texture),
            roughness: scalar(4, &m.roughness_texture),
            transmission: scalar(5, &m.transmission_texture),
            opacity: scalar(6, &m.opacity_texture),
            normal: texels[7].color,
        }
    }

    /// The share of the surface that is there.
    #[inline(always)]
    pub(super) fn opacity_of(&self, material: &Material, color: &Rgba) -> f32 {
        let there = material.opacity * color.alpha * self.opacity;
        match material.alpha {
            AlphaUse::Ignore => 1.0,
            AlphaUse::Mask if there >= material.alpha_cutoff => 1.0,
            AlphaUse::Mask => 0.0,
            AlphaUse::Blend => clamp(there, 0.0, 1.0),
        }
    }
}
