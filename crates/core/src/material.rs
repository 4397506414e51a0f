//! What surfaces do with light, in the form that shading reads.

use crate::math::{Vec3, max};

/// "No texture", "no primitive", "no light", "no material".
pub const NONE: u32 = u32::MAX;

/// How a material's numbers become reflected, transmitted and scattered light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum SurfaceModel {
    /// They are what they are named: flattening has composed them.
    Composed,
    /// Base colour ([`Material::diffuse`]), metallic and roughness, by the rule in `shading/evaluated_material.rs`.
    MetallicRoughness,
}

/// How the Fresnel factor `F` enters a material's reflection and transmission.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Refraction {
    /// Without bending.
    Straight,
    /// By Snell's law, with total internal reflection.
    Snell,
}

/// What the opacity of a surface does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum AlphaUse {
    /// Nothing.
    Ignore,
    /// The surface has a hole where it is below [`Material::alpha_cutoff`].
    Mask,
    /// Opacity is the share of the surface that is there; the rest lets rays pass.
    Blend,
}

/// One channel of a texture, or none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ScalarTexture {
    /// Number of the texture, or [`NONE`].
    pub texture: u32,
    /// 0 red, 1 green, 2 blue, 3 alpha.
    pub channel: u32,
}

impl ScalarTexture {
    /// No texture.
    pub const NONE: ScalarTexture = ScalarTexture { texture: NONE, channel: 0 };
}

/// One surface material. The radiance of a hit is
/// `emission + ambient + sum over lights + kr * reflected + kt * refracted` with `kr` = [`Material::reflection`]
/// and `kt` = [`Material::transmission`], both weighted by [`Material::fresnel`]. Where the surface has a hole, what is
/// behind it shows instead, in proportion.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Material {
    /// How the numbers are meant.
    pub model: SurfaceModel,
    /// Some texture is not [`NONE`]; the others are not looked at otherwise.
    pub is_textured: bool,
    /// `Kd` or base colour, multiplied by its texture and the vertex colour where there are any.
    pub diffuse: Vec3,
    /// Number of the texture of the diffuse colour, or [`NONE`].
    pub diffuse_texture: u32,
    /// How rough what scatters diffusely is, 0 (Lambert) to 1, for path tracing: [`Eon`](crate::bsdf::Eon).
    pub diffuse_roughness: f32,
    /// `Ks` of the highlight; of metallic-roughness materials weight and colour of the reflection of what is no metal.
    pub specular: Vec3,
    /// Number of the texture of the highlight's colour, or [`NONE`].
    pub specular_texture: u32,
    /// `Ns`, the highlight's exponent.
    pub shininess: f32,
    /// `Ke`, radiance that leaves the surface by itself.
    pub emission: Vec3,
    /// Number of the texture of the emission, or [`NONE`].
    pub emission_texture: u32,
    /// Index of refraction inside over outside.
    pub ior: f32,
    /// `kr` before Fresnel.
    pub reflection: Vec3,
    /// How `F` enters.
    pub fresnel: FresnelUse,
    /// `kt` before Fresnel; of metallic-roughness materials the share that is transmitted, the same in all components.
    pub transmission: Vec3,
    /// Texture of that share.
    pub transmission_texture: ScalarTexture,
    /// How transmitted rays go on.
    pub refraction: Refraction,
    /// What coloured shadows multiply light by that crosses this surface; black for opaque ones.
    pub shadow_filter: Vec3,
    /// `a` of the body behind the surface: after a distance of d world units `2^(-a d)` of the light is left.
    pub attenuation: Vec3,
    /// Rays a glossy reflection spreads over; 0 for a sharp mirror.
    pub glossy_rays: u32,
    /// Exponent of the glossy lobe `cos^n` about the mirror direction.
    pub glossy_exponent: f32,
    /// How much of the surface is metal, 0 to 1.
    pub metallic: f32,
    /// Texture of the former.
    pub metallic_texture: ScalarTexture,
    /// Roughness as in glTF, 0 (sharp) to 1.
    pub roughness: f32,
    /// Texture of the former.
    pub roughness_texture: ScalarTexture,
    /// It is not there for rays that come from behind.
    pub single_sided: bool,
    /// All that is made of it encloses what it refracts into: path tracing follows which of these bodies a path is in. Below 65,535
    /// in number.
    pub is_body: bool,
    /// What the opacity does.
    pub alpha: AlphaUse,
    /// For [`AlphaUse::Mask`].
    pub alpha_cutoff: f32,
    /// 1 is opaque; multiplied by its texture and the vertex colour's alpha.
    pub opacity: f32,
    /// Texture of the opacity.
    pub opacity_texture: ScalarTexture,
    /// Number of the texture of normals in tangent space, or [`NONE`].
    pub normal_texture: u32,
    /// Multiplies x and y of these normals.
    pub normal_scale: f32,
}

impl Material {
    /// Whether its surfaces let no light through anywhere, for coloured shadows.
    #[inline(always)]
    pub fn stops_all_light(&self) -> bool {
        let is_there = (self.alpha == AlphaUse::Ignore) & !self.single_sided;
        let passes = match self.model {
            SurfaceModel::MetallicRoughness => self.transmission,
            _ => self.shadow_filter,
        };
        is_there & (passes.max_component() <= 0.0)
    }

    /// Whether Whitted's rays end on its surfaces, whatever its textures say.
    #[inline(always)]
    pub fn ends_rays(&self) -> bool {
        let is_whole = (self.alpha == AlphaUse::Ignore) & !self.single_sided;
        let goes_on = max(self.reflection.max_component(), self.transmission.max_component()) > 0.0;
        is_whole & (self.model != SurfaceModel::MetallicRoughness) & !goes_on
    }

    /// Whether what is made of it is a light to path tracing: it shines, and nothing passes it straight. Other emitters are found
    /// by rays that meet them.
    #[inline(always)]
    pub fn is_lamp_of_paths(&self) -> bool {
        let is_closed = (self.alpha == AlphaUse::Ignore)
            & ((self.refraction != Refraction::Straight) | !(self.transmission.max_component() > 0.0));
        is_closed & (self.emission.max_component() > 0.0)
    }

    /// Whether triangles of it that are lights to path tracing shine to both sides, as glTF's double-sided materials do.
    #[inline(always)]
    pub fn shines_to_both_sides(&self) -> bool {
        (self.model == SurfaceModel::MetallicRoughness) & !self.single_sided
    }

    /// Whether light passes it straight on in path tracing, with what it takes: holes, panes, and backs that are not there.
    #[inline(always)]
    pub fn is_passed_by_paths(&self) -> bool {
        let is_pane = (self.refraction == Refraction::Straight)
            & ((self.transmission.max_component() > 0.0) | (self.transmission_texture.texture != NONE));
        is_pane | (self.alpha != AlphaUse::Ignore) | self.single_sided
    }

    /// The textures of all its properties, in the order in which `MaterialTexels` has their texels: indices, or [`NONE`].
    #[inline(always)]
    pub fn textures(&self) -> [u32; 8] {
        [
            self.diffuse_texture,
            self.specular_texture,
            self.emission_texture,
            self.metallic_texture.texture,
            self.roughness_texture.texture,
            self.transmission_texture.texture,
            self.opacity_texture.texture,
            self.normal_texture,
        ]
    }
}

impl Default for Material {
    fn default() -> Material {
        Material {
            model: SurfaceModel::Composed,
            is_textured: false,
            diffuse: Vec3::splat(0.75),
            diffuse_texture: NONE,
            diffuse_roughness: 0.0,
            specular: Vec3::ZERO,
            specular_texture: NONE,
            shininess: 1.0,
            emission: Vec3::ZERO,
            emission_texture: NONE,
            ior: 1.0,
            reflection: Vec3::ZERO,
            fresnel: FresnelUse::Ignore,
            transmission: Vec3::ZERO,
            transmission_texture: ScalarTexture::NONE,
            refraction: Refraction::Straight,
            shadow_filter: Vec3::ZERO,
            attenuation: Vec3::ZERO,
            glossy_rays: 0,
            glossy_exponent: 1.0,
            metallic: 0.0,
            metallic_texture: ScalarTexture::NONE,
            roughness: 1.0,
            roughness_texture: ScalarTexture::NONE,
            single_sided: false,
            is_body: false,
            alpha: AlphaUse::Ignore,
            alpha_cutoff: 0.5,
            opacity: 1.0,
            opacity_texture: ScalarTexture::NONE,
            normal_texture: NONE,
            normal_scale: 1.0,
        }
    }
}
