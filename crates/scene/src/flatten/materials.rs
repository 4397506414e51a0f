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
//! | native, illum 3, 5, 8 with Ks and Pr, without Pm | the same, glossy | | |
//! | else native with Pr or Pm, `pbr` | by `eosphor_core`'s `shading/evaluated_material.rs` | | |

use crate::model::{
    AlphaMode, Channel, Composition, Material, MaterialKind, MaterialTextures, Mtl, Pbr, TextureChannel,
};
use eosphor_core::material::{
    self as core, AlphaUse, FresnelUse, NONE, Refraction, ScalarTexture, SurfaceModel,
};
use eosphor_core::math::{Vec3, elementary64};

/// Glass, where an MTL file gives no Ni.
const DEFAULT_IOR: f32 = 1.5;

/// Mirror weight of EOS.
const EOS_REFLECTION: f32 = 0.4;

/// Roughness, where an MTL file gives Pm but no Pr.
const DEFAULT_ROUGHNESS: f32 = 0.5;

/// Largest exponent of a lobe, which is a mirror to the eye.
const LARGEST_EXPONENT: f32 = 1e6;

/// The most that a body takes; beyond, nothing is left of the light anyway.
const MAX_ATTENUATION: f64 = 1e12;

/// The form that shading reads.
pub(super) fn compose(material: &Material, composition: Composition) -> core::Material {
    let composed = match material.kind {
        MaterialKind::Mtl(mtl) => match composition {
            Composition::Native => native(&mtl, material.textures.roughness.is_some()),
            Composition::Pg1 => pg1(&mtl),
            Composition::Eos => eos(&mtl),
        },
        kind => own_kind(kind),
    };
    let composed = core::Material {
        single_sided: material.single_sided,
        diffuse_roughness: material.diffuse_roughness,
        ..composed
    };
    with_alpha(with_textures(composed, &material.textures), material.alpha)
}

fn with_textures(m: core::Material, textures: &MaterialTextures) -> core::Material {
    let number = |texture: Option<u32>| texture.unwrap_or(NONE);
    core::Material {
        is_textured: *textures
            != MaterialTextures { normal_scale: textures.normal_scale, ..MaterialTextures::NONE },
        diffuse_texture: number(textures.color),
        specular_texture: number(textures.specular),
        emission_texture: number(textures.emission),
        metallic_texture: scalar(textures.metallic),
        roughness_texture: scalar(textures.roughness),
        transmission_texture: scalar(textures.transmission),
        opacity_texture: scalar(textures.opacity),
        normal_texture: number(textures.normal),
        normal_scale: textures.normal_scale,
        ..m
    }
}

fn scalar(texture: Option<TextureChannel>) -> ScalarTexture {
    texture.map_or(ScalarTexture::NONE, |t| ScalarTexture {
        texture: t.texture,
        channel: match t.channel {
            Channel::Red => 0,
            Channel::Green => 1,
            Channel::Blue => 2,
            Channel::Alpha => 3,
        },
    })
}

fn with_alpha(m: core::Material, alpha: AlphaMode) -> core::Material {
    let (alpha, alpha_cutoff) = match alpha {
        AlphaMode::Opaque => (m.alpha, m.alpha_cutoff),
        AlphaMode::Mask { cutoff } => (AlphaUse::Mask, cutoff),
        AlphaMode::Blend => (AlphaUse::Blend, m.alpha_cutoff),
    };
    core::Material { alpha, alpha_cutoff, ..m }
}

fn pbr(pbr: &Pbr) -> core::Material {
    core::Material {
        model: SurfaceModel::MetallicRoughness,
        diffuse: pbr.color,
        specular: pbr.specular_color * pbr.specular,
        emission: pbr.emission,
        ior: pbr.ior,
        transmission: Vec3::splat(pbr.transmission),
        refraction: if pbr.solid { Refraction::Snell } else { Refraction::Straight },
        attenuation: if pbr.solid { attenuation(pbr) } else { Vec3::ZERO },
        metallic: pbr.metallic,
        roughness: pbr.roughness,
        opacity: pbr.opacity,
        ..black()
    }
}

/// `a` so that `2^(-a d)` is the attenuation colour at the attenuation distance d.
fn attenuation(pbr: &Pbr) -> Vec3 {
    let Some(distance) = pbr.attenuation_distance else { return Vec3::ZERO };
    let of = |color: f32| {
        // Black takes what leaves nothing a float can hold.
        let log2 = if color > 0.0 { elementary64::log2(f64::from(color)) } else { -160.0 };
        (-log2 / f64::from(distance)).clamp(0.0, MAX_ATTENUATION) as f32
    };
    let [r, g, b] = <[f32; 3]>::from(pbr.attenuation_color);
    Vec3::from([of(r), of(g), of(b)])
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

/// The metallic-roughness material that the PBR extension of MTL describes.
fn mtl_pbr(mtl: &Mtl) -> core::Material {
    let transmits = refracts(mtl);
    pbr(&Pbr {
        color: if transmits { mtl.Tf.unwrap_or(Vec3::ONE).min(Vec3::ONE) } else { mtl.Kd },
        opacity: mtl.d,
        metallic: mtl.Pm.unwrap_or(0.0),
        roughness: mtl.Pr.unwrap_or(DEFAULT_ROUGHNESS),
        emission: mtl.Ke,
        // Exporters write `Ni 1` for what has no index of its own.
        ior: mtl.Ni.filter(|ni| *ni > 1.0).unwrap_or(DEFAULT_IOR),
        transmission: if transmits { 1.0 } else { 0.0 },
        solid: transmits,
        ..Pbr::default()
    })
}

/// Roughness that is read from a texture is for the metallic-roughness material.
fn native(mtl: &Mtl, has_roughness_texture: bool) -> core::Material {
    // A file that calls a material a mirror, and says how strong, means one.
    let is_mirror = matches!(mtl.illum, 3 | 5 | 8) && mtl.Ks != Vec3::ZERO && !has_roughness_texture;
    if mtl.Pm.is_some() || mtl.Pr.is_some() && !is_mirror {
        let m = mtl_pbr(mtl);
        return if mtl.d < 1.0 && !refracts(mtl) { with_alpha(m, AlphaMode::Blend) } else { m };
    }
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
    if let Some(roughness) = mtl.Pr.filter(|&roughness| roughness > 0.0) {
        (m.glossy_rays, m.glossy_exponent) = (1, lobe_exponent(roughness));
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

/// The exponent of a lobe about the mirror direction as wide as that of a microfacet distribution of `alpha` = roughness²:
/// (2 / alpha² - 2) about the half vector (Walter et al. 2007), a fourth of that about the mirror direction.
fn lobe_exponent(roughness: f32) -> f32 {
    let alpha = roughness.min(1.0) * roughness.min(1.0);
    (0.5 / (alpha * alpha) - 0.5).min(LARGEST_EXPONENT)
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
        MaterialKind::Mtl(mtl) => native(&mtl, false),
        MaterialKind::Pbr(kind) => pbr(&kind),
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
        MaterialKind::Transparent { color, transparency, reflection, shininess, diffuse } => core::Material {
            diffuse: color * diffuse,
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
