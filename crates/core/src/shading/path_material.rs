//! What a material is at one point for path tracing: shares of lobes.
//!
//! | | base | layer over it | metal | glass |
//! |---|---|---|---|---|
//! | metallic-roughness | `b` | `s F0` to `s` | share `m`, colour `b` | share `(1 - m) t`, tint `b` |
//! | matte | `Kd` | – | – | – |
//! | with highlight `Ks`, `Ns` | `Kd` | `Ks F0` to `Ks`, `alpha^2 = 2 / (Ns + 2)` | – | – |
//! | mirror without Fresnel | `Kd` | `kr` to `kr` | – | – |
//! | mirror with Fresnel | `Kd` | `kr F0` to `kr` | – | – |
//! | glass | `Kd` | – | – | `1 - max Kd`, tint `kt` |
//!
//! `b` is the base colour, `m` metallic, `t` transmission, `s` weight and colour of the reflection, `F0` the reflectance at normal
//! incidence of the index of refraction; "to" stands between normal and grazing incidence. A base is as rough as
//! [`Material::diffuse_roughness`] says, Lambert's with 0. The layer takes from it what it reflects. Glass that does not refract is
//! thin. A mirror's highlights are its own: `Ks` adds none. What a surface lets through straight without being glass (`d`, PLATO's
//! transparency) is `through`.

use super::surface::material_of_triangle;
use super::{MaterialTexels, MaterialValues};
use crate::bsdf::{Closure, reflectance_at_normal_incidence};
use crate::material::{AlphaUse, FresnelUse, Material, NONE, Refraction, SurfaceModel};
use crate::math::{Vec3, clamp, max, min, sqrt};
use crate::ray::Hit;
use crate::texture::Rgba;
use crate::view::{SceneView, item};

/// The index of refraction where a highlight has none that reflects.
const USUAL_IOR: f32 = 1.5;

/// The least index of refraction of a body.
pub const LEAST_IOR: f32 = 0.1;

/// A material at a point, for path tracing. Shares add up to no more than 1.
#[derive(Clone, Copy, Debug)]
pub struct PathMaterial {
    /// Share that is matte below a layer.
    opaque: f32,
    /// Albedo of the matte base, before what lies over it.
    diffuse: Vec3,
    /// Roughness of the base.
    diffuse_roughness: f32,
    /// Reflectance of the layer over the base at normal incidence.
    f0: Vec3,
    /// The same at grazing incidence.
    f90: Vec3,
    /// Share of metal.
    metal: f32,
    /// Its colour at normal incidence.
    metal_f0: Vec3,
    /// Share of glass.
    glass: f32,
    /// What transmitted light is multiplied by.
    glass_tint: Vec3,
    /// Index of refraction inside over outside; as the material has it, outside is nothing.
    pub ior: f32,
    /// Glass has two sides close together and does not refract.
    is_thin: bool,
    /// Roughness: alpha of the microfacets.
    alpha: f32,
    /// What goes straight through, as through a hole.
    pub through: Vec3,
    /// Radiance that leaves the surface by itself.
    pub emission: Vec3,
    /// The share of the surface that is there.
    opacity: f32,
}

impl MaterialValues for PathMaterial {
    #[inline(always)]
    fn new(material: &Material, texels: &MaterialTexels, color: &Rgba) -> PathMaterial {
        let base = material.diffuse * texels.diffuse.color * color.color;
        let specular = material.specular * texels.specular.color;
        let is_straight = material.refraction == Refraction::Straight;
        let values = PathMaterial {
            opaque: 1.0,
            diffuse: base,
            diffuse_roughness: clamp(material.diffuse_roughness, 0.0, 1.0),
            f0: Vec3::ZERO,
            f90: Vec3::ZERO,
            metal: 0.0,
            metal_f0: Vec3::ZERO,
            glass: 0.0,
            glass_tint: material.transmission,
            ior: max(material.ior, LEAST_IOR),
            is_thin: is_straight,
            alpha: 0.0,
            through: Vec3::ZERO,
            emission: material.emission * texels.emission.color,
            opacity: texels.opacity_of(material, color),
        };
        if material.model == SurfaceModel::MetallicRoughness {
            values.metallic_roughness(
                base,
                specular,
                clamp(material.metallic * texels.metallic, 0.0, 1.0),
                clamp(material.roughness * texels.roughness, 0.0, 1.0),
                clamp(material.transmission.x * texels.transmission, 0.0, 1.0),
            )
        } else {
            values.composed(material, specular)
        }
    }

    #[inline(always)]
    fn opacity(&self) -> f32 {
        self.opacity
    }
}

impl PathMaterial {
    #[inline(always)]
    fn metallic_roughness(
        self,
        base: Vec3,
        specular: Vec3,
        metallic: f32,
        roughness: f32,
        transmitted: f32,
    ) -> PathMaterial {
        let base = base.min(Vec3::ONE);
        let dielectric = 1.0 - metallic;
        let f0 = (specular * reflectance_at_normal_incidence(self.ior)).min(Vec3::ONE);
        PathMaterial {
            opaque: dielectric * (1.0 - transmitted),
            diffuse: base,
            f0,
            f90: Vec3::splat(min(specular.max_component(), 1.0)),
            metal: metallic,
            metal_f0: base,
            glass: dielectric * transmitted,
            glass_tint: base,
            alpha: roughness * roughness,
            ..self
        }
    }

    #[inline(always)]
    fn composed(self, material: &Material, specular: Vec3) -> PathMaterial {
        let mirror = material.reflection.min(Vec3::ONE);
        let mut values = self;
        values.diffuse = self.diffuse.min(Vec3::ONE);
        // As wide as the lobe `cos^n` about the mirror direction.
        if material.glossy_rays > 0 {
            values.alpha = sqrt(1.0 / (2.0 * material.glossy_exponent + 1.0));
        }
        if material.fresnel == FresnelUse::Both {
            // The base and glass share the surface.
            values.opaque = values.diffuse.max_component();
            values.glass = 1.0 - values.opaque;
            values.diffuse = values.diffuse * (1.0 / max(values.opaque, f32::MIN_POSITIVE));
            values.glass_tint = self.glass_tint.min(Vec3::ONE);
            return values;
        }
        if material.refraction == Refraction::Straight {
            values.through = material.transmission.min(Vec3::ONE);
        }
        if mirror.max_component() > 0.0 {
            let with_fresnel = material.fresnel == FresnelUse::Reflection;
            let normal = if with_fresnel { reflectance_at_normal_incidence(self.ior) } else { 1.0 };
            values.f0 = mirror * normal;
            values.f90 = mirror;
        } else if specular.max_component() > 0.0 {
            let ior = if self.ior > 1.0 { self.ior } else { USUAL_IOR };
            values.f90 = specular.min(Vec3::ONE);
            values.f0 = values.f90 * reflectance_at_normal_incidence(ior);
            values.alpha = min(sqrt(2.0 / (material.shininess + 2.0)), 1.0);
        }
        values
    }

    /// Whether a material is matte and smooth and nothing else wherever it is, and its textures change neither normals nor what is
    /// there.
    #[inline(always)]
    pub fn is_matte(material: &Material) -> bool {
        let shines = max(material.reflection.max_component(), material.specular.max_component()) > 0.0;
        let is_base =
            (material.model != SurfaceModel::MetallicRoughness) & (material.fresnel != FresnelUse::Both);
        let passes =
            (material.refraction == Refraction::Straight) & (material.transmission.max_component() > 0.0);
        let is_whole = (material.alpha == AlphaUse::Ignore) & (material.normal_texture == NONE);
        let is_smooth = !(material.diffuse_roughness > 0.0);
        is_base & is_whole & is_smooth & !shines & !passes & !(material.attenuation.max_component() > 0.0)
    }

    /// Albedo and emission where the number-th triangle of the scene was hit, whose material is matte.
    #[inline(always)]
    pub fn matte_at(view: &SceneView, number: u32, material: &Material, hit: &Hit) -> (Vec3, Vec3) {
        if !material.is_textured & (item(view.triangle_shading, number).extra == NONE) {
            // As below, where all texels and colours are white.
            return (material.diffuse.min(Vec3::ONE), material.emission);
        }
        let values: PathMaterial = material_of_triangle(view, number, material, hit);
        (values.diffuse * values.opaque, values.emission)
    }

    /// How it scatters light, on the side that is seen.
    #[inline(always)]
    pub fn closure(&self, is_front: bool) -> Closure {
        Closure {
            diffuse: self.diffuse * self.opaque,
            diffuse_roughness: self.diffuse_roughness,
            f0: self.f0 * self.opaque,
            f90: self.f90 * self.opaque,
            metal_f0: self.metal_f0 * self.metal,
            metal: self.metal,
            glass: self.glass,
            glass_tint: self.glass_tint,
            // Thin glass has air on both sides.
            eta: if is_front | self.is_thin { self.ior } else { 1.0 / self.ior },
            is_thin: self.is_thin,
            alpha: self.alpha,
        }
    }
}
