//! Materials of the model → materials that shading reads: what reflects and what transmits.
//!
//! | | `kr` | `kt` | Fresnel |
//! |---|---|---|---|
//! | native, illum 0 to 2, 10 | 0 | 1 - d, straight | – |
//! | native, illum 3, 8 | Ks | 1 - d, straight | – |
//! | native, illum 5 with Ni > 1 | Ks | – | reflection |
//! | native, illum 5 without | Ks | – | – |
//! | native, illum 4, 6, 7, 9 | 1 | Tf, else 1; Snell | both |
//! | pg1 | Ks | Tf, else 0, with illum 4, 6, 7, 9; Snell | – |
//! | eos | 0.4 with illum 3 to 9 | Tf, else 0, with illum 4, 6, 7, 9; Snell | – |

use crate::model::{Composition, Material, MaterialKind, Mtl};
use eosphor_core::material::{self as core, FresnelUse, NONE, Refraction};
use eosphor_core::math::Vec3;

/// Glass, where an MTL file gives no Ni.
const DEFAULT_IOR: f32 = 1.5;

/// Mirror weight of EOS.
const EOS_REFLECTION: f32 = 0.4;

/// The form that shading reads.
pub(super) fn compose(material: &Material, composition: Composition) -> core::Material {
    let composed = match material.kind {
        MaterialKind::Mtl(mtl) => match composition {
            Composition::Native => native(&mtl),
            Composition::Pg1 => pg1(&mtl),
            Composition::Eos => eos(&mtl),
        },
        kind => own_kind(kind),
    };
    core::Material { diffuse_texture: material.textures.color.unwrap_or(NONE), ..composed }
}

/// What diffuses nothing, reflects nothing and lets nothing through.
fn black() -> core::Material {
    core::Material { diffuse: Vec3::ZERO, ..core::Material::default() }
}

/// The fields that every composition takes over.
fn local(mtl: &Mtl) -> core::Material {
    core::Material {
        diffuse: mtl.Kd,
        specular: mtl.Ks,
        shininess: mtl.Ns,
        emission: mtl.Ke,
        ior: mtl.Ni.unwrap_or(DEFAULT_IOR),
        ..core::Material::default()
    }
}

/// Whether the file calls the material transparent. Tf alone does not: exporters write `Tf 1 1 1` for opaque ones too.
fn refracts(mtl: &Mtl) -> bool {
    matches!(mtl.illum, 4 | 6 | 7 | 9)
}

fn native(mtl: &Mtl) -> core::Material {
    let mut m = local(mtl);
    // illum 0 and 1 have no highlights.
    if mtl.illum < 2 {
        m.specular = Vec3::ZERO;
    }
    match mtl.illum {
        3 | 8 => m.reflection = mtl.Ks,
        5 => {
            m.reflection = mtl.Ks;
            // A mirror without an index of refraction is metal, of which MTL tells too little for Fresnel.
            if mtl.Ni.is_some_and(|ni| ni > 1.0) {
                m.fresnel = FresnelUse::Reflection;
            }
        }
        4 | 6 | 7 | 9 => {
            m.reflection = Vec3::ONE;
            m.transmission = mtl.Tf.unwrap_or(Vec3::ONE);
            m.fresnel = FresnelUse::Both;
            m.refraction = Refraction::Snell;
            m.shadow_filter = m.transmission;
        }
        _ => {}
    }
    // d dissolves: what the surface itself shows fades as what is behind comes through.
    if mtl.d < 1.0 && !refracts(mtl) && mtl.illum != 5 {
        m.transmission = Vec3::splat(1.0 - mtl.d);
        m.refraction = Refraction::Straight;
        m.shadow_filter = mtl.Kd * (1.0 - mtl.d);
        m.diffuse = mtl.Kd * mtl.d;
        m.specular = m.specular * mtl.d;
    }
    m
}

fn pg1(mtl: &Mtl) -> core::Material {
    let mut m = local(mtl);
    m.reflection = mtl.Ks;
    transmit_by_tf(&mut m, mtl);
    m
}

fn eos(mtl: &Mtl) -> core::Material {
    let mut m = local(mtl);
    if (3..=9).contains(&mtl.illum) {
        m.reflection = Vec3::splat(EOS_REFLECTION);
    }
    transmit_by_tf(&mut m, mtl);
    m
}

fn transmit_by_tf(m: &mut core::Material, mtl: &Mtl) {
    if refracts(mtl) {
        m.transmission = mtl.Tf.unwrap_or(Vec3::ZERO);
        m.refraction = Refraction::Snell;
        m.shadow_filter = m.transmission;
    }
}

/// Kinds other than MTL mean the same in every composition.
fn own_kind(kind: MaterialKind) -> core::Material {
    match kind {
        MaterialKind::Mtl(mtl) => native(&mtl),
        MaterialKind::Pbr(pbr) => core::Material { diffuse: pbr.color, emission: pbr.emission, ..black() },
        MaterialKind::Matte { color } => core::Material { diffuse: color, ..black() },
        MaterialKind::Mirror { reflectance } => core::Material { reflection: reflectance, ..black() },
        MaterialKind::Dielectric { ior, tint } => core::Material {
            ior,
            reflection: Vec3::ONE,
            transmission: tint,
            fresnel: FresnelUse::Both,
            refraction: Refraction::Snell,
            shadow_filter: tint,
            ..black()
        },
        MaterialKind::Glossy { reflectance, exponent, rays, color } => core::Material {
            diffuse: color,
            reflection: reflectance,
            glossy_rays: rays,
            glossy_exponent: exponent,
            ..black()
        },
        MaterialKind::Transparent { color, transparency, reflection, shininess } => core::Material {
            diffuse: color,
            specular: Vec3::splat(reflection),
            shininess,
            reflection: Vec3::splat(reflection),
            transmission: Vec3::splat(transparency),
            refraction: Refraction::Straight,
            shadow_filter: color * transparency,
            ..black()
        },
        MaterialKind::Emissive { radiance } => core::Material { emission: radiance, ..black() },
    }
}
