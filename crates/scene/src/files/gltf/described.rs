//! What the file says of a material, in the model's terms.

use super::Part;
use super::document::{self, MaterialExtensions, PbrMetallicRoughness, SpecularGlossiness, TextureInfo};
use super::textures::Map;
use crate::files::loader::Loader;
use crate::model::{AlphaMode, Pbr, TextureContent};
use eosphor_core::math::{Vec3, vec3};
use std::path::Path;

/// Emission beyond this is cut: it would not fit the sums of a picture.
const MAX_EMISSION: f32 = 1e9;

/// A material, its textures not yet read.
pub(super) struct Described {
    pub(super) name: String,
    pub(super) pbr: Pbr,
    pub(super) alpha: AlphaMode,
    pub(super) double_sided: bool,
    pub(super) maps: Maps,
    /// Shown as its base colour, whatever shines on it.
    pub(super) unlit: bool,
}

/// Textures by what they multiply.
pub(super) struct Maps {
    pub(super) color: Option<Map>,
    pub(super) metallic_roughness: Option<Map>,
    pub(super) emission: Option<Map>,
    pub(super) transmission: Option<Map>,
    pub(super) normal: Option<Map>,
    pub(super) normal_scale: f32,
}

impl Default for Maps {
    fn default() -> Maps {
        Maps {
            color: None,
            metallic_roughness: None,
            emission: None,
            transmission: None,
            normal: None,
            normal_scale: 1.0,
        }
    }
}

impl Maps {
    pub(super) fn all(&self) -> impl Iterator<Item = &Map> {
        [&self.color, &self.metallic_roughness, &self.emission, &self.transmission, &self.normal]
            .into_iter()
            .flatten()
    }
}

impl Described {
    /// Reads a material. Warnings are given only of one that is used.
    pub(super) fn new(
        loader: &mut Loader,
        path: &Path,
        number: usize,
        file: &document::Material,
        is_used: bool,
    ) -> Described {
        let name = match &file.name {
            Some(name) => super::clean(name),
            None => Part::new("material", number, None).to_string(),
        };
        let mut warn = |message: &str| {
            if is_used {
                loader.warnings.add(path, None, message);
            }
        };
        let alpha = match file.alpha_mode {
            Some(document::AlphaMode::Mask) => {
                AlphaMode::Mask { cutoff: file.alpha_cutoff.unwrap_or(0.5).clamp(0.0, 1e6) }
            }
            Some(document::AlphaMode::Blend) => AlphaMode::Blend,
            Some(document::AlphaMode::Opaque) | None => AlphaMode::Opaque,
        };
        let (pbr, maps) = Described::core(file, &mut warn);
        let double_sided = file.double_sided;
        let mut described = Described { name, pbr, alpha, double_sided, maps, unlit: false };
        if let Some(extensions) = &file.extensions {
            described.extend(extensions, &file.pbr_metallic_roughness, &mut warn);
        }
        described
    }

    /// What glTF itself knows.
    fn core(file: &document::Material, warn: &mut impl FnMut(&str)) -> (Pbr, Maps) {
        let rough = &file.pbr_metallic_roughness;
        let [r, g, b, opacity] = rough.base_color_factor.map(unit);
        let pbr = Pbr {
            color: vec3(r, g, b),
            opacity,
            metallic: unit(rough.metallic_factor),
            roughness: unit(rough.roughness_factor),
            emission: bright(file.emissive_factor, 1.0),
            ..Pbr::default()
        };
        let maps = Maps {
            color: rough.base_color_texture.as_ref().map(color_map),
            metallic_roughness: rough.metallic_roughness_texture.as_ref().map(data_map),
            emission: file.emissive_texture.as_ref().map(color_map),
            normal: file.normal_texture.as_ref().map(Map::of_normals),
            normal_scale: file.normal_texture.as_ref().map_or(1.0, |t| t.scale.clamp(-1e6, 1e6)),
            transmission: None,
        };
        if file.occlusion_texture.is_some() {
            warn("occlusion textures are not rendered");
        }
        (pbr, maps)
    }

    fn extend(
        &mut self,
        extensions: &MaterialExtensions,
        rough: &PbrMetallicRoughness,
        warn: &mut impl FnMut(&str),
    ) {
        let (pbr, maps) = (&mut self.pbr, &mut self.maps);
        if let Some(glossy) = extensions.specular_glossiness.as_ref().filter(|_| says_nothing(rough)) {
            warn(
                "KHR_materials_pbrSpecularGlossiness is converted: its factors and diffuse texture count, its \
                 texture of specular colour and glossiness does not",
            );
            of_specular_glossiness(pbr, glossy);
            maps.color = glossy.diffuse_texture.as_ref().map(color_map);
        }
        if let Some(strength) = &extensions.emissive_strength {
            pbr.emission = bright(pbr.emission.into(), strength.emissive_strength);
        }
        if let Some(ior) = &extensions.ior {
            // 0 stands for infinity: it reflects everything.
            pbr.ior = if ior.ior > 0.0 { ior.ior.clamp(0.01, 100.0) } else { 100.0 };
        }
        if let Some(specular) = &extensions.specular {
            pbr.specular = unit(specular.specular_factor);
            pbr.specular_color = bright(specular.specular_color_factor, 1.0);
            if specular.specular_texture.is_some() || specular.specular_color_texture.is_some() {
                warn("the textures of KHR_materials_specular are not rendered; its factors are");
            }
        }
        if let Some(transmission) = &extensions.transmission {
            pbr.transmission = unit(transmission.transmission_factor);
            maps.transmission = transmission.transmission_texture.as_ref().map(data_map);
        }
        if let Some(volume) = &extensions.volume {
            pbr.solid = volume.thickness_factor > 0.0;
            pbr.attenuation_color = Vec3::from(volume.attenuation_color.map(unit));
            let distance = volume.attenuation_distance;
            pbr.attenuation_distance = (distance > 0.0 && distance <= 1e12).then_some(distance);
        }
        if extensions.unlit.is_some() {
            self.unlit = true;
            *pbr = Pbr {
                color: Vec3::ZERO,
                specular: 0.0,
                emission: pbr.color,
                opacity: pbr.opacity,
                ..Pbr::default()
            };
            let color = maps.color.take();
            *maps = Maps { emission: color.clone(), color, ..Maps::default() };
        }
    }
}

fn color_map(info: &TextureInfo) -> Map {
    Map::new(info, TextureContent::Color)
}

fn data_map(info: &TextureInfo) -> Map {
    Map::new(info, TextureContent::Data)
}

/// Whether the metallic-roughness part is missing, or as good as.
fn says_nothing(rough: &PbrMetallicRoughness) -> bool {
    rough.base_color_texture.is_none()
        && rough.metallic_roughness_texture.is_none()
        && rough.base_color_factor == [1.0; 4]
        && rough.metallic_factor == 1.0
        && rough.roughness_factor == 1.0
}

/// The nearest metallic-roughness material: no metal, its reflection at normal incidence the specular colour.
fn of_specular_glossiness(pbr: &mut Pbr, glossy: &SpecularGlossiness) {
    /// What an index of refraction of 1.5 reflects at normal incidence; `Pbr::specular_color` multiplies it.
    const REFLECTANCE: f32 = 0.04;
    let [r, g, b, opacity] = glossy.diffuse_factor.map(unit);
    let specular = Vec3::from(glossy.specular_factor.map(unit));
    pbr.color = vec3(r, g, b) * (1.0 - specular.max_component());
    pbr.opacity = opacity;
    pbr.metallic = 0.0;
    pbr.roughness = 1.0 - unit(glossy.glossiness_factor);
    pbr.specular_color = specular * (1.0 / REFLECTANCE);
}

/// A factor from 0 to 1.
fn unit(x: f32) -> f32 {
    if x > 0.0 { x.min(1.0) } else { 0.0 }
}

/// Colours beyond 1.
fn bright(color: [f32; 3], strength: f32) -> Vec3 {
    Vec3::from(color.map(|x| (x * strength).clamp(0.0, MAX_EMISSION)))
}
