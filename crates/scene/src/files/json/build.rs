//! From the keys of a JSON scene to the model: files are read, names become numbers.

use super::OLD_VERSION;
use super::document::Document;
use super::environment::EnvironmentEntry;
use super::fault::quoted;
use super::format::{ParallelogramEntry, SceneFile, SphereEntry};
use super::material::{Entries, MaterialEntry, TextureSlots};
use super::nearest::hint;
use super::semantics;
use super::texture::{ChannelTextureEntry, TextureEntry};
use super::tree::{Step, way};
use crate::error::{Problem, SceneError};
use crate::files::loader::Loader;
use crate::model::{
    CameraMotion, Channel, EnvironmentMap, LightUnits, Material, MaterialTextures, Parallelogram,
    RenderSettings, Sphere, TextureChannel, TextureContent,
};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// What a scene of the old version is told.
const OLD_UNITS: &str = "version 1 of the format: its light looks as it did, by \"light-units\": \"plain\" in its \"settings\". \
                         For physical light write \"eosphor\": 2 and multiply the colours of lights and the radiance of \
                         lamps by 3.1416 (docs/units.md)";

/// In scenes that state an origin, meshes farther from 0 than so many of their sizes are read with all digits.
const STATED_APART: f64 = 2.0;

pub(super) struct Builder<'a> {
    pub(super) loader: &'a mut Loader,
    pub(super) document: &'a Document<'a>,
}

/// The numbers of the file's materials.
pub(super) struct MaterialNames {
    names: Vec<String>,
    numbers: HashMap<String, u32>,
}

impl Builder<'_> {
    pub(super) fn build(&mut self, file: SceneFile) -> Result<(), SceneError> {
        if let Some(camera) = &file.camera {
            let motion = file.animation.as_ref().and_then(|animation| animation.camera.as_ref());
            let is_moved = motion.is_some_and(CameraMotion::sets_view);
            semantics::check_camera(self.document, &self.first_camera(camera, motion), is_moved)?;
        }
        self.loader.scene.camera = file.camera;
        let RenderSettings { headlight, .. } = self.loader.scene.settings;
        semantics::check_settings(self.document, file.settings.integrator)?;
        self.loader.scene.settings = file.settings;
        self.loader.scene.settings.headlight &=
            headlight && file.lights.as_ref().is_none_or(|lights| !lights.is_empty());
        self.loader.scene.lights = file.lights.unwrap_or_default();
        self.loader.scene.environment = self.environment(file.environment)?;
        let keeps_units = self.keep_old_units(file.version);
        self.loader.scene.animation = file.animation;
        self.loader.scene.frame = file.frame.unwrap_or(0);
        (self.loader.scene.device, self.loader.scene.output) = (file.device, file.output);
        let materials = self.materials(file.materials)?;
        // Who states an origin counts on all digits about it.
        if file.origin.is_some_and(|origin| origin != [0.0; 3]) {
            self.loader.apart = STATED_APART;
        }
        let (origins, moves) = self.place_meshes(file.meshes, file.instances, &materials, file.origin)?;
        let middle_lights = self.add_solids(&file.solids)?;
        for (i, SphereEntry { center, radius, material }) in file.spheres.into_iter().enumerate() {
            let material = self.material(material, &materials, &way!["spheres", i, "material"])?;
            let material = material.unwrap_or_else(|| self.loader.default_material());
            self.loader.scene.spheres.push(Sphere { center, radius, material });
        }
        for (i, entry) in file.parallelograms.into_iter().enumerate() {
            let ParallelogramEntry { corner, edge_u, edge_v, material } = entry;
            let material = self.material(material, &materials, &way!["parallelograms", i, "material"])?;
            let material = material.unwrap_or_else(|| self.loader.default_material());
            let parallelogram = Parallelogram { corner, edge_u, edge_v, material };
            semantics::check_edges(self.document, i, &parallelogram)?;
            self.loader.scene.parallelograms.push(parallelogram);
        }
        self.add_quadrilaterals(file.quadrilaterals, &materials)?;
        if keeps_units && (self.brings_light() || !middle_lights.is_empty()) {
            let line = self.document.line_of_version();
            self.loader.warnings.add(self.document.path, line, OLD_UNITS);
        }
        let origin = |instance: usize| origins.get(instance).map(|&(list, i)| way![list, i]);
        let document = self.document;
        let invalid = |problem: Problem| document.problem(&problem, origin);
        self.loader.scene.validate().map_err(invalid)?;
        match self.count_from_origin(file.origin, &moves) {
            true => self.loader.scene.validate().map_err(invalid),
            false => Ok(()),
        }?;
        self.add_middle_lights(middle_lights);
        Ok(())
    }

    /// Scenes of the old version keep their look: where they do not say what their light is, it is what it was.
    fn keep_old_units(&mut self, version: u32) -> bool {
        let settings = self.document.root.get("settings");
        let old = version == OLD_VERSION && settings.is_none_or(|s| s.get("light-units").is_none());
        if old {
            self.loader.scene.settings.light_units = LightUnits::Plain;
        }
        old
    }

    /// Whether units of light matter: the headlight looks the same in all of them.
    fn brings_light(&self) -> bool {
        let scene = &self.loader.scene;
        !scene.lights.is_empty() || scene.has_emissive_triangles()
    }

    /// Adds the materials; their names by number.
    fn materials(&mut self, entries: Entries<MaterialEntry>) -> Result<MaterialNames, SceneError> {
        let (mut names, mut numbers) = (Vec::new(), HashMap::new());
        for (name, MaterialEntry { kind, texture, textures, diffuse_roughness, alpha }) in entries.0 {
            let way = way!["materials", name.as_str()];
            if texture.is_some() && textures.color.is_some() {
                let message = "\"texture\" says the same as \"color\" of \"textures\"; drop one of them";
                return Err(self.document.error_in(&[way[0], way[1], "texture".into()], message));
            }
            let textures = self.textures(way, texture, textures)?;
            numbers.insert(name.clone(), self.loader.scene.materials.len() as u32);
            names.push(name.clone());
            let plain = Material::new(name, kind);
            self.loader.scene.materials.push(Material { textures, diffuse_roughness, alpha, ..plain });
        }
        Ok(MaterialNames { names, numbers })
    }

    /// The textures of a material. `short` is the one that stands beside its kind.
    fn textures(
        &mut self,
        material: [Step; 2],
        short: Option<TextureEntry>,
        slots: TextureSlots,
    ) -> Result<MaterialTextures, SceneError> {
        use TextureContent::{Color, Data};
        let [a, b] = material;
        let way = |key| [a, b, "textures".into(), Step::Key(key)];
        let color = match short {
            Some(short) => self.texture(&[a, b, "texture".into()], Some(short), Color)?,
            None => self.texture(&way("color"), slots.color, Color)?,
        };
        Ok(MaterialTextures {
            color,
            opacity: self.channel(&way("opacity"), slots.opacity, Channel::Alpha)?,
            specular: self.texture(&way("specular"), slots.specular, Color)?,
            emission: self.texture(&way("emission"), slots.emission, Color)?,
            metallic: self.channel(&way("metallic"), slots.metallic, Channel::Blue)?,
            roughness: self.channel(&way("roughness"), slots.roughness, Channel::Green)?,
            transmission: self.channel(&way("transmission"), slots.transmission, Channel::Red)?,
            normal: self.texture(&way("normal"), slots.normal, Data)?,
            normal_scale: slots.normal_scale,
        })
    }

    /// The number of a texture; none where there is none or none is wanted.
    fn texture(
        &mut self,
        way: &[Step],
        entry: Option<TextureEntry>,
        content: TextureContent,
    ) -> Result<Option<u32>, SceneError> {
        let Some(entry) = entry.filter(|_| self.loader.wants_textures()) else { return Ok(None) };
        let folder = self.document.path.parent().unwrap_or(Path::new(""));
        let image = self.loader.image_beside(folder, entry.file()).map_err(|error| {
            let file = [way, &["file".into()]].concat();
            self.document.error_in(&file, format!("texture: {error}"))
        })?;
        Ok(Some(self.loader.texture(entry.of_image(image, content))))
    }

    /// The environment, if there is one.
    pub(super) fn environment(
        &mut self,
        entry: Option<EnvironmentEntry>,
    ) -> Result<Option<EnvironmentMap>, SceneError> {
        let Some(entry) = entry else { return Ok(None) };
        let folder = self.document.path.parent().unwrap_or(Path::new(""));
        let image = entry.file().map(|file| self.loader.image_beside(folder, file)).transpose();
        let image = image.map_err(|error| {
            let is_short = matches!(entry, EnvironmentEntry::File(_));
            let way =
                if is_short { way!["environment"].to_vec() } else { way!["environment", "file"].to_vec() };
            self.document.error_in(&way, format!("environment: {error}"))
        })?;
        entry.build(image, self.document).map(Some)
    }

    fn channel(
        &mut self,
        way: &[Step],
        entry: Option<ChannelTextureEntry>,
        usual: Channel,
    ) -> Result<Option<TextureChannel>, SceneError> {
        let Some((entry, channel)) = entry.map(ChannelTextureEntry::split) else { return Ok(None) };
        let texture = self.texture(way, Some(entry), TextureContent::Data)?;
        Ok(texture.map(|texture| TextureChannel { texture, channel: channel.unwrap_or(usual) }))
    }

    /// The number of a named material; `way` leads to the name.
    pub(super) fn material(
        &self,
        name: Option<String>,
        materials: &MaterialNames,
        way: &[Step],
    ) -> Result<Option<u32>, SceneError> {
        let Some(name) = name else { return Ok(None) };
        match materials.numbers.get(&name) {
            Some(&number) => Ok(Some(number)),
            None => {
                let hint = hint(&name, materials.names.iter().map(String::as_str));
                Err(self.document.error_in(way, format!("unknown material {}; {hint}", quoted(&name))))
            }
        }
    }

    /// The path of a file that is named relative to the scene.
    pub(super) fn beside(&self, file: &Path) -> PathBuf {
        self.document.path.parent().unwrap_or(Path::new("")).join(file)
    }
}
