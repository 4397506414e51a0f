//! Materials, as people and files describe them.

use eosphor_core::math::Vec3;
use serde::{Deserialize, Serialize};

/// A named material.
#[derive(Clone, Debug)]
pub struct Material {
    /// As in the file.
    pub name: String,
    /// What it is.
    pub kind: MaterialKind,
    /// Number of the texture that multiplies the diffuse colour.
    pub diffuse_texture: Option<u32>,
}

impl Material {
    /// The name of the material of faces, spheres and parallelograms that have none.
    pub const DEFAULT_NAME: &str = "default";

    /// The material of what has none.
    pub fn default_material() -> Material {
        Material {
            name: Material::DEFAULT_NAME.into(),
            kind: MaterialKind::Mtl(Mtl::default()),
            diffuse_texture: None,
        }
    }

    /// The radiance that leaves the surface by itself.
    pub fn emission(&self) -> Vec3 {
        match self.kind {
            MaterialKind::Mtl(mtl) => mtl.Ke,
            MaterialKind::Emissive { radiance } => radiance,
            _ => Vec3::ZERO,
        }
    }

    /// Whether this is [`Material::default_material`]; presets replace it by that of the system they imitate.
    pub fn is_default(&self) -> bool {
        self.name == Material::DEFAULT_NAME
            && self.kind == MaterialKind::Mtl(Mtl::default())
            && self.diffuse_texture.is_none()
    }
}

/// Kinds of material.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", rename_all_fields = "kebab-case", deny_unknown_fields)]
pub enum MaterialKind {
    /// The fields of an MTL file; what reflects and transmits follows from [`super::Composition`].
    Mtl(Mtl),
    /// Lit by lights only.
    Matte {
        /// Diffuse colour.
        #[serde(alias = "colour")]
        color: Vec3,
    },
    /// A sharp mirror.
    Mirror {
        /// Share of light that is reflected.
        reflectance: Vec3,
    },
    /// Glass, water, diamond: reflects by Fresnel, refracts the rest.
    Dielectric {
        /// Index of refraction; files may name a substance ([`super::INDICES_OF_REFRACTION`]).
        #[serde(deserialize_with = "super::ior::number_or_name")]
        ior: f32,
        /// Share of light that gets through a surface.
        #[serde(default = "one")]
        tint: Vec3,
    },
    /// A blurred mirror over a diffuse ground.
    Glossy {
        /// Share of light that is reflected.
        reflectance: Vec3,
        /// Exponent of the lobe `cos^n` about the mirror direction.
        exponent: f32,
        /// Reflected rays a hit.
        #[serde(default = "eight")]
        rays: u32,
        /// Diffuse colour.
        #[serde(default, alias = "colour")]
        color: Vec3,
    },
    /// Coloured, partly mirror and partly see-through without bending (PLATO's faces).
    Transparent {
        /// Diffuse colour; also the colour of its shadow.
        #[serde(alias = "colour")]
        color: Vec3,
        /// Share of light that goes straight through, 0 to 1.
        transparency: f32,
        /// Share of light that is reflected, 0 to 1; also the weight of the highlight.
        #[serde(default)]
        reflection: f32,
        /// Exponent of the highlight.
        #[serde(default = "sixty_four")]
        shininess: f32,
    },
    /// Shines by itself. Triangles of it are lights.
    Emissive {
        /// Radiance.
        radiance: Vec3,
    },
}

/// The fields of an MTL file that rendering uses.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[allow(non_snake_case, reason = "the names are MTL's own")]
pub struct Mtl {
    /// Diffuse colour.
    pub Kd: Vec3,
    /// Specular colour.
    pub Ks: Vec3,
    /// Emitted radiance.
    pub Ke: Vec3,
    /// Transmission filter; `None` when the file has none.
    pub Tf: Option<Vec3>,
    /// Exponent of the highlight.
    pub Ns: f32,
    /// Index of refraction; `None` when the file has none.
    pub Ni: Option<f32>,
    /// Opacity: 1 is opaque.
    pub d: f32,
    /// Illumination model, 0 to 10.
    pub illum: u32,
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
        }
    }
}

fn one() -> Vec3 {
    Vec3::ONE
}
fn eight() -> u32 {
    8
}
fn sixty_four() -> f32 {
    64.0
}
