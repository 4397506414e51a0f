//! What a material is at one point: textures, vertex colours and metallic-roughness resolved.
//!
//! # Metallic-roughness
//!
//! glTF 2.0 gives base colour `b`, metallic `m`, roughness `r`, transmission `t`, weight and colour `s` of the dielectric
//! reflection, and an index of refraction, from which `F` and, at normal incidence, `F0` follow. Whitted's model has
//! sharp rays, lobes `cos^n` and Blinn's highlight. With `alpha = r^2` (at least 0.02):
//!
//! | | |
//! |---|---|
//! | diffuse | `b (1 - m) (1 - t) (1 - F0 s)` |
//! | reflected rays | `s (1 - m) F + m (b + (1 - b) (1 - cos)^5)` |
//! | transmitted rays | `b t (1 - m) (1 - F)`, tinted where they enter and where they leave |
//! | their lobes | sharp for `r` up to 0.05; else exponent `(2 / alpha^2 - 2) / 4` |
//! | rays a lobe | at the first hit 4 for metal, 1 for the rest; 1 at all others |
//! | highlight | exponent `Ns = 2 / alpha^2 - 2`, weight `(s F0 (1 - m) + m b) (Ns + 2) / 8` |
//!
//! The highlight is Blinn-Phong's normal distribution with the visibility term taken as `1 / (4 cos cos)` (Akenine-Möller
//! et al., Real-Time Rendering, 4th ed., 9.8). Lamps, which reflected rays see, throw none on these materials, or they
//! would count twice.

use crate::bsdf::reflectance_at_normal_incidence;
use crate::material::{FresnelUse, Material, Refraction, SurfaceModel};
use crate::math::{Vec3, clamp, max};
use crate::shading::{MaterialTexels, MaterialValues};
use crate::texture::Rgba;

/// Up to this roughness reflections are sharp.
const SHARP: f32 = 0.05;

/// The least `alpha`: the highlights of mirrors stay finite.
const LEAST_ALPHA: f32 = 0.02;

/// Rays of a metal's lobe at the first hit.
const METAL_RAYS: u32 = 4;

/// A material at a point, for Whitted's integrator.
#[derive(Clone, Copy, Debug)]
pub struct EvaluatedMaterial {
    /// What lights are multiplied by, scattered.
    pub diffuse: Vec3,
    /// The highlight's weight.
    pub specular: Vec3,
    /// The highlight's exponent.
    pub shininess: f32,
    /// Lamps throw highlights too; otherwise reflected rays see them, and only points and directions do.
    pub lamp_highlights: bool,
    /// Radiance that leaves the surface by itself.
    pub emission: Vec3,
    /// Index of refraction inside over outside.
    pub ior: f32,
    /// `kr` before Fresnel.
    pub reflection: Vec3,
    /// How `F` enters it and the transmission.
    pub fresnel: FresnelUse,
    /// The part of `kr` that is metal: the share of the surface, and its colour at normal incidence times that share.
    pub metal: f32,
    /// See [`EvaluatedMaterial::metal`].
    pub metal_color: Vec3,
    /// `kt` before Fresnel.
    pub transmission: Vec3,
    /// How transmitted rays go on.
    pub refraction: Refraction,
    /// What coloured shadows multiply light by that crosses this surface where it is there.
    pub shadow_filter: Vec3,
    /// The share of the surface that is there.
    pub opacity: f32,
    /// Rays of the lobes at the first hit; 0 for sharp ones.
    pub glossy_rays: u32,
    /// The same at all other hits.
    pub glossy_rays_later: u32,
    /// Exponent of the lobes.
    pub glossy_exponent: f32,
    /// Transmitted rays have a lobe too.
    pub glossy_transmission: bool,
}

impl MaterialValues for EvaluatedMaterial {
    #[inline(always)]
    fn new(material: &Material, texels: &MaterialTexels, color: &Rgba) -> EvaluatedMaterial {
        EvaluatedMaterial::new(material, texels, color)
    }

    #[inline(always)]
    fn opacity(&self) -> f32 {
        self.opacity
    }
}

impl EvaluatedMaterial {
    /// What `material` is where its textures say this and the vertex colour is `color`.
    #[inline(always)]
    pub fn new(material: &Material, texels: &MaterialTexels, color: &Rgba) -> EvaluatedMaterial {
        let tint = texels.diffuse.color * color.color;
        let mut material_values = EvaluatedMaterial {
            diffuse: material.diffuse * tint,
            specular: material.specular * texels.specular.color,
            shininess: material.shininess,
            lamp_highlights: true,
            emission: material.emission * texels.emission.color,
            ior: material.ior,
            reflection: material.reflection,
            fresnel: material.fresnel,
            metal: 0.0,
            metal_color: Vec3::ZERO,
            transmission: material.transmission,
            refraction: material.refraction,
            shadow_filter: material.shadow_filter,
            opacity: texels.opacity_of(material, color),
            glossy_rays: material.glossy_rays,
            glossy_rays_later: material.glossy_rays,
            glossy_exponent: material.glossy_exponent,
            glossy_transmission: false,
        };
        if material.model == SurfaceModel::MetallicRoughness {
            material_values.metallic_roughness(
                clamp(material.metallic * texels.metallic, 0.0, 1.0),
                clamp(material.roughness * texels.roughness, 0.0, 1.0),
                clamp(material.transmission.x * texels.transmission, 0.0, 1.0),
            );
        } else if material.refraction == Refraction::Straight {
            // A textured pane casts its picture.
            material_values.shadow_filter *= tint;
        }
        material_values
    }

    /// The rule of the table above; the base colour is in `diffuse`, the dielectric's weight in `specular`.
    #[inline(always)]
    fn metallic_roughness(&mut self, metallic: f32, roughness: f32, transmitted: f32) {
        let (base, weight) = (self.diffuse, self.specular);
        let dielectric = 1.0 - metallic;
        let f0 = weight * reflectance_at_normal_incidence(self.ior);
        let alpha = max(roughness * roughness, LEAST_ALPHA);
        let exponent = max(2.0 / (alpha * alpha) - 2.0, 0.0);
        self.diffuse = base * (dielectric * (1.0 - transmitted)) * (Vec3::ONE - f0).max(Vec3::ZERO);
        self.metal = metallic;
        self.metal_color = base * metallic;
        self.reflection = weight * dielectric;
        self.fresnel = FresnelUse::Both;
        self.transmission = base * (dielectric * transmitted);
        self.shadow_filter = self.transmission;
        self.specular = (f0 * dielectric + self.metal_color) * ((exponent + 2.0) * 0.125);
        self.shininess = exponent;
        self.lamp_highlights = false;
        let rough = roughness > SHARP;
        self.glossy_rays = if !rough {
            0
        } else if metallic >= 0.5 {
            METAL_RAYS
        } else {
            1
        };
        self.glossy_rays_later = rough as u32;
        self.glossy_exponent = exponent * 0.25;
        self.glossy_transmission = rough;
    }

    /// Rays of the lobes at a hit after this many bounces; 0 for sharp ones.
    #[inline(always)]
    pub fn lobe_rays(&self, depth: u32) -> u32 {
        if depth == 0 { self.glossy_rays } else { self.glossy_rays_later }
    }

    /// Whether anything is reflected.
    #[inline(always)]
    pub fn reflects(&self) -> bool {
        max(self.reflection.max_component(), self.metal) > 0.0
    }

    /// Whether anything is transmitted.
    #[inline(always)]
    pub fn transmits(&self) -> bool {
        self.transmission.max_component() > 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::AlphaUse;
    use crate::math::vec3;
    use crate::texture::Textures;

    fn values_colored(material: &Material, color: &Rgba) -> EvaluatedMaterial {
        let textures = Textures { textures: &[], words: &[], srgb_decode: &[0.0; 256] };
        let texels = MaterialTexels::new(&textures, material, &[[0.0; 2]; 2]);
        EvaluatedMaterial::new(material, &texels, color)
    }

    fn material_values(material: &Material) -> EvaluatedMaterial {
        values_colored(material, &Rgba::WHITE)
    }

    fn pbr(metallic: f32, roughness: f32, transmission: f32) -> Material {
        Material {
            model: SurfaceModel::MetallicRoughness,
            diffuse: vec3(0.8, 0.4, 0.2),
            specular: Vec3::ONE,
            ior: 1.5,
            metallic,
            roughness,
            transmission: Vec3::splat(transmission),
            ..Material::default()
        }
    }

    #[test]
    fn plastic_metal_and_glass() {
        let near = |a: Vec3, b: Vec3| assert!((a - b).abs().max_component() < 1e-6, "{a:?} {b:?}");
        let plastic = material_values(&pbr(0.0, 1.0, 0.0));
        near(plastic.diffuse, vec3(0.8, 0.4, 0.2) * 0.96);
        near(plastic.specular, Vec3::splat(0.04 * 0.25));
        assert_eq!((plastic.shininess, plastic.metal, plastic.transmits()), (0.0, 0.0, false));
        assert_eq!((plastic.lobe_rays(0), plastic.lobe_rays(1)), (1, 1));
        let metal = material_values(&pbr(1.0, 0.5, 0.5));
        near(metal.diffuse, Vec3::ZERO);
        near(metal.metal_color, vec3(0.8, 0.4, 0.2));
        assert_eq!(
            (metal.metal, metal.transmits(), metal.lobe_rays(0), metal.lobe_rays(3)),
            (1.0, false, 4, 1)
        );
        assert_eq!(metal.shininess, 30.0);
        let glass = material_values(&pbr(0.0, 0.0, 1.0));
        near(glass.diffuse, Vec3::ZERO);
        near(glass.transmission, vec3(0.8, 0.4, 0.2));
        assert_eq!((glass.lobe_rays(0), glass.glossy_transmission, glass.reflects()), (0, false, true));
    }

    #[test]
    fn holes() {
        for (alpha, there, expected) in [
            (AlphaUse::Ignore, 0.2, 1.0),
            (AlphaUse::Mask, 0.5, 0.0),
            (AlphaUse::Mask, 0.75, 1.0),
            (AlphaUse::Blend, 0.75, 0.375),
        ] {
            let material = Material { alpha, opacity: 0.5, alpha_cutoff: 0.375, ..Material::default() };
            let color = Rgba { color: vec3(1.0, 0.5, 0.0), alpha: there };
            let material_values = values_colored(&material, &color);
            assert_eq!(material_values.opacity, expected, "{alpha:?}");
            assert_eq!(material_values.diffuse, vec3(0.75, 0.375, 0.0));
        }
    }
}
