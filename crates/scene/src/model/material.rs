//! Materials, as people and files describe them.

use super::Pbr;
use super::schema_types::{Color, IndexOfRefraction};
use eosphor_core::math::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A named material.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The name in the file.
    pub name: String,
    /// The kind of material, with its parameters.
    pub kind: MaterialKind,
    /// Pictures that vary it over the surface.
    pub textures: MaterialTextures,
    /// How rough the ground is that scatters light to all sides, 0 (Lambert's) to 1 (clay, dust), by the model EON
    /// ([`eosphor_core::bsdf::Eon`]). For path tracing; kinds without a ground have 0.
    pub diffuse_roughness: f32,
    /// Whether the opacity of its texture makes holes.
    pub alpha: AlphaMode,
    /// Whether the surface cannot be seen from behind, as in glTF. Its shadows do not depend on this.
    pub single_sided: bool,
}

/// Numbers of textures ([`super::Scene::textures`]); each multiplies what it is named after.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaterialTextures {
    /// The texture that multiplies the diffuse or base colour.
    pub color: Option<u32>,
    /// The opacity; counts where [`Material::alpha`] is not `Opaque`.
    pub opacity: Option<TextureChannel>,
    /// The highlight's colour (`Ks`) of MTL materials.
    pub specular: Option<u32>,
    /// The texture that multiplies the emitted radiance.
    pub emission: Option<u32>,
    /// The texture that multiplies [`Pbr::metallic`].
    pub metallic: Option<TextureChannel>,
    /// The texture that multiplies [`Pbr::roughness`].
    pub roughness: Option<TextureChannel>,
    /// The texture that multiplies [`Pbr::transmission`].
    pub transmission: Option<TextureChannel>,
    /// Normals in tangent space: (R, G, B) from 0..1 to -1..1, x along u, y along v (up), z off the surface. It
    /// replaces the shading normal.
    pub normal: Option<u32>,
    /// Multiplies x and y of these normals.
    pub normal_scale: f32,
}

impl MaterialTextures {
    /// No textures at all.
    pub const NONE: MaterialTextures = MaterialTextures {
        color: None,
        opacity: None,
        specular: None,
        emission: None,
        metallic: None,
        roughness: None,
        transmission: None,
        normal: None,
        normal_scale: 1.0,
    };
}

impl Default for MaterialTextures {
    fn default() -> MaterialTextures {
        MaterialTextures::NONE
    }
}

/// One channel of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TextureChannel {
    /// Index into [`super::Scene::textures`].
    pub texture: u32,
    /// The channel of the texture that is read.
    pub channel: Channel,
}

/// A channel of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[allow(missing_docs, reason = "the names say it")]
pub enum Channel {
    Red,
    Green,
    Blue,
    Alpha,
}

/// What a material's opacity does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", rename_all_fields = "kebab-case", deny_unknown_fields)]
pub enum AlphaMode {
    /// Nothing: there are no holes.
    #[default]
    Opaque,
    /// Where it is under the cutoff there is a hole.
    Mask {
        /// 0 to 1.
        #[schemars(description = "The opacity below which there is a hole.")]
        #[serde(default = "half")]
        #[schemars(range(min = 0, max = 1))]
        cutoff: f32,
    },
    /// It is the share of the surface that is there; the rest is a hole.
    Blend,
}

impl Material {
    /// The name of the material of faces, spheres and parallelograms that have none.
    pub const DEFAULT_NAME: &str = "default";

    /// A material without textures and holes.
    pub fn new(name: impl Into<String>, kind: MaterialKind) -> Material {
        Material {
            name: name.into(),
            kind,
            textures: MaterialTextures::NONE,
            diffuse_roughness: 0.0,
            alpha: AlphaMode::Opaque,
            single_sided: false,
        }
    }

    /// The material of what has none.
    pub fn default_material() -> Material {
        Material::new(Material::DEFAULT_NAME, MaterialKind::Mtl(Mtl::default()))
    }

    /// The radiance that leaves the surface by itself, before textures.
    pub fn emission(&self) -> Vec3 {
        match self.kind {
            MaterialKind::Mtl(mtl) => mtl.Ke,
            MaterialKind::Pbr(pbr) => pbr.emission,
            MaterialKind::Emissive { radiance } => radiance,
            _ => Vec3::ZERO,
        }
    }

    /// Whether this is [`Material::default_material`]; presets replace it by that of the system they imitate.
    pub fn is_default(&self) -> bool {
        self.name == Material::DEFAULT_NAME
            && self.kind == MaterialKind::Mtl(Mtl::default())
            && self.textures == MaterialTextures::NONE
    }
}

/// The kind of a material, with its parameters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", rename_all_fields = "kebab-case", deny_unknown_fields)]
pub enum MaterialKind {
    /// The fields of an MTL file; what reflects and transmits follows from [`super::Composition`].
    Mtl(Mtl),
    /// Metal and plastic by roughness, as in glTF.
    Pbr(Pbr),
    /// Lit by lights only.
    Matte {
        /// Diffuse colour.
        #[serde(alias = "colour")]
        #[schemars(with = "Color")]
        color: Vec3,
    },
    /// A sharp mirror.
    Mirror {
        /// Share of light that is reflected.
        #[schemars(with = "Color")]
        reflectance: Vec3,
    },
    /// Glass, water, diamond: reflects by Fresnel, refracts the rest.
    Dielectric {
        /// Index of refraction; files may name a substance ([`super::INDICES_OF_REFRACTION`]).
        #[serde(deserialize_with = "super::ior::number_or_name")]
        #[schemars(with = "IndexOfRefraction", description = "Index of refraction.")]
        ior: f32,
        /// Share of light that gets through a surface.
        #[serde(default = "one")]
        #[schemars(with = "Color")]
        tint: Vec3,
    },
    /// A blurred mirror over a diffuse ground.
    Glossy {
        /// Share of light that is reflected.
        #[schemars(with = "Color")]
        reflectance: Vec3,
        /// Exponent of the lobe `cos^n` about the mirror direction.
        #[schemars(range(min = 0, max = 1000000))]
        exponent: f32,
        /// Reflected rays a hit.
        #[serde(default = "eight")]
        #[schemars(range(min = 1, max = 65536))]
        rays: u32,
        /// Diffuse colour.
        #[serde(default, alias = "colour")]
        #[schemars(with = "Color")]
        color: Vec3,
    },
    /// Coloured, partly mirror and partly see-through without bending (PLATO's faces).
    Transparent {
        /// Diffuse colour; also the colour of its shadow.
        #[serde(alias = "colour")]
        #[schemars(with = "Color")]
        color: Vec3,
        /// Share of light that goes straight through, 0 to 1.
        #[schemars(range(min = 0, max = 1))]
        transparency: f32,
        /// Share of light that is reflected, 0 to 1; also the weight of the highlight.
        #[serde(default)]
        #[schemars(range(min = 0, max = 1))]
        reflection: f32,
        /// Exponent of the highlight.
        #[serde(default = "sixty_four")]
        #[schemars(range(min = 0, max = 1000000))]
        shininess: f32,
        /// Share of the diffuse colour that answers lights, 0 to 1; its shadow keeps the whole colour.
        #[serde(default = "whole")]
        #[schemars(range(min = 0, max = 1))]
        diffuse: f32,
    },
    /// Shines by itself. Triangles of it are lights.
    Emissive {
        /// Radiance.
        #[schemars(with = "Color")]
        radiance: Vec3,
    },
}

impl MaterialKind {
    /// Whether some materials of the kind scatter light in all directions: [`Material::diffuse_roughness`] is for these.
    pub(super) fn has_ground(&self) -> bool {
        match self {
            MaterialKind::Mtl(_)
            | MaterialKind::Pbr(_)
            | MaterialKind::Matte { .. }
            | MaterialKind::Glossy { .. }
            | MaterialKind::Transparent { .. } => true,
            MaterialKind::Mirror { .. } | MaterialKind::Dielectric { .. } | MaterialKind::Emissive { .. } => {
                false
            }
        }
    }
}

/// The fields of an MTL file that rendering uses.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[allow(non_snake_case, reason = "the names are MTL's own")]
pub struct Mtl {
    /// Diffuse colour.
    #[schemars(with = "Color")]
    pub Kd: Vec3,
    /// Specular colour.
    #[schemars(with = "Color")]
    pub Ks: Vec3,
    /// Emitted radiance.
    #[schemars(with = "Color")]
    pub Ke: Vec3,
    /// Transmission filter; what stands for none depends on [`super::Composition`].
    #[schemars(with = "Option<Color>")]
    pub Tf: Option<Vec3>,
    /// Exponent of the highlight.
    #[schemars(range(min = 0, max = 1000000))]
    pub Ns: f32,
    /// Index of refraction.
    #[schemars(range(min = 0.01, max = 100))]
    pub Ni: Option<f32>,
    /// Opacity: 1 is opaque.
    #[schemars(range(min = 0, max = 1))]
    pub d: f32,
    /// Illumination model, 0 to 10.
    #[schemars(range(min = 0, max = 10))]
    pub illum: u32,
    /// Roughness, of the PBR extension. Where a material has `Pr` or `Pm`, the native composition takes it for a
    /// metallic-roughness material; the presets take no notice.
    #[schemars(range(min = 0, max = 1))]
    pub Pr: Option<f32>,
    /// Metallic, of the PBR extension.
    #[schemars(range(min = 0, max = 1))]
    pub Pm: Option<f32>,
    /// Sheen; kept, not rendered.
    pub Ps: Option<f32>,
    /// Clearcoat; kept, not rendered.
    pub Pc: Option<f32>,
    /// Clearcoat's roughness; kept, not rendered.
    pub Pcr: Option<f32>,
    /// Anisotropy; kept, not rendered.
    pub aniso: Option<f32>,
    /// Its rotation; kept, not rendered.
    pub anisor: Option<f32>,
}

impl Default for Mtl {
    fn default() -> Mtl {
        Mtl {
            Kd: Vec3::splat(0.8),
            Ks: Vec3::ZERO,
            Ke: Vec3::ZERO,
            Tf: None,
            Ns: 10.0,
            Ni: None,
            d: 1.0,
            illum: 2,
            Pr: None,
            Pm: None,
            Ps: None,
            Pc: None,
            Pcr: None,
            aniso: None,
            anisor: None,
        }
    }
}

fn half() -> f32 {
    0.5
}
fn one() -> Vec3 {
    Vec3::ONE
}
fn eight() -> u32 {
    8
}
fn whole() -> f32 {
    1.0
}
fn sixty_four() -> f32 {
    64.0
}
