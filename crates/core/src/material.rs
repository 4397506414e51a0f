//! What surfaces do with light, in the form that shading reads.

use crate::math::Vec3;

/// "No texture", "no primitive", "no light".
pub const NONE: u32 = u32::MAX;

/// How the Fresnel factor `F` enters a material's reflection and transmission.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum FresnelUse {
    /// Not at all.
    Ignore,
    /// Reflection is multiplied by `F`.
    Reflection,
    /// Reflection is multiplied by `F` and transmission by `1 - F`.
    Both,
}

/// How transmitted rays go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Refraction {
    /// Without bending.
    Straight,
    /// By Snell's law, with total internal reflection.
    Snell,
}

/// One surface material. The radiance of a hit is
/// `emission + ambient + sum over lights + kr * reflected + kt * refracted` with `kr` = [`Material::reflection`]
/// and `kt` = [`Material::transmission`], both weighted by [`Material::fresnel`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Material {
    /// `Kd`, multiplied by the texture where there is one.
    pub diffuse: Vec3,
    /// Number of the texture of the diffuse colour, or [`NONE`].
    pub diffuse_texture: u32,
    /// `Ks` of the highlight.
    pub specular: Vec3,
    /// `Ns`, the highlight's exponent.
    pub shininess: f32,
    /// `Ke`, radiance that leaves the surface by itself.
    pub emission: Vec3,
    /// Index of refraction inside over outside.
    pub ior: f32,
    /// `kr` before Fresnel.
    pub reflection: Vec3,
    /// How `F` enters.
    pub fresnel: FresnelUse,
    /// `kt` before Fresnel.
    pub transmission: Vec3,
    /// How transmitted rays go on.
    pub refraction: Refraction,
    /// What coloured shadows multiply light by that crosses this surface; black for opaque ones.
    pub shadow_filter: Vec3,
    /// Rays a glossy reflection spreads over; 0 for a sharp mirror.
    pub glossy_rays: u32,
    /// Exponent of the glossy lobe `cos^n` about the mirror direction.
    pub glossy_exponent: f32,
}

impl Default for Material {
    fn default() -> Material {
        Material {
            diffuse: Vec3::splat(0.75),
            diffuse_texture: NONE,
            specular: Vec3::ZERO,
            shininess: 1.0,
            emission: Vec3::ZERO,
            ior: 1.0,
            reflection: Vec3::ZERO,
            fresnel: FresnelUse::Ignore,
            transmission: Vec3::ZERO,
            refraction: Refraction::Straight,
            shadow_filter: Vec3::ZERO,
            glossy_rays: 0,
            glossy_exponent: 1.0,
        }
    }
}
