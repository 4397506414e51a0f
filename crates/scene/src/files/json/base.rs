//! A scene with a base: another file that it starts from, and overrides in part.

use super::OLD_VERSION;
use super::build::Builder;
use super::fault::quoted;
use super::format::SceneFile;
use super::semantics;
use super::tree::{Step, way};
use crate::error::{Place, Problem, SceneError};
use crate::files::{builtin, read_scene};
use crate::model::{Camera, DeviceSettings, Light, PixelSampling, RenderSettings, Scene, double};
use eosphor_core::math::Vec3;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::path::Path;

/// What may stand beside the base.
const BESIDE: [&str; 11] = [
    "eosphor",
    "$schema",
    "description",
    "base",
    "camera",
    "lights",
    "environment",
    "settings",
    "device",
    "output",
    "frame",
];

/// The objects whose keys go over those of the base one by one, as far as they are given.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Given {
    settings: Map<String, Value>,
    device: Map<String, Value>,
}

impl Builder<'_> {
    /// Reads the base of the file, and overrides it by what the file says.
    pub(super) fn build_over(&mut self, base: &Path, mut file: SceneFile) -> Result<(), SceneError> {
        self.check_keys(&file)?;
        let base = if builtin::name_of(base).is_some() { base.to_path_buf() } else { self.beside(base) };
        let headlight = self.loader.scene.settings.headlight;
        self.loader.scene.settings.headlight = headlight && !self.is_darkened(&file);
        // A glTF file has no integrator of its own, and comes with the settings of this one.
        self.loader.integrator = file.settings.integrator;
        self.read_base(&base)?;
        if let Some(environment) = self.environment(file.environment.take())? {
            self.loader.scene.environment = Some(environment);
        }
        let mut scene = std::mem::take(&mut self.loader.scene);
        self.put_over(&mut scene, file, headlight)?;
        self.loader.scene = scene;
        Ok(())
    }

    fn check_keys(&self, file: &SceneFile) -> Result<(), SceneError> {
        if file.version == OLD_VERSION {
            let message = "version 1 of the format has no \"base\"; write \"eosphor\": 2";
            return Err(self.document.error_in(&way!["eosphor"], message));
        }
        match self.document.root.entries().iter().find(|entry| !BESIDE.contains(&&*entry.key)) {
            Some(entry) => {
                let message = format!(
                    "{} cannot be used together with \"base\"; put it into the base file",
                    quoted(&entry.key)
                );
                Err(self.document.error(entry.key_at, message))
            }
            None => Ok(()),
        }
    }

    /// Whether the file says that no light is to be added: then none is added to the base either.
    fn is_darkened(&self, file: &SceneFile) -> bool {
        !file.settings.headlight || file.lights.as_ref().is_some_and(Vec::is_empty)
    }

    /// Reads the base into the loader. What is wrong inside it has its own place; that it cannot be read is said here.
    fn read_base(&mut self, base: &Path) -> Result<(), SceneError> {
        let document = self.document;
        let wrong = |message: String| document.error_in(&way!["base"], format!("base: {message}"));
        self.loader.begin_with(document.path, base).map_err(wrong)?;
        let read = match builtin::name_of(base) {
            Some(name) => {
                let headlight = self.loader.scene.settings.headlight;
                self.loader.take_builtin(name, headlight)
            }
            None => read_scene(self.loader, base, None),
        };
        read.map_err(|error| match &error {
            SceneError::Read { path, .. } if path == base => wrong(error.to_string()),
            SceneError::UnknownFormat { .. } | SceneError::UnknownBuiltin { .. } => wrong(error.to_string()),
            _ => error,
        })?;
        let invalid = |problem: Problem| SceneError::invalid(Place::file(base), problem.to_string());
        self.loader.scene.validate().map_err(invalid)
    }

    /// Puts what the file says over the scene of the base. `headlight`: whether lights may be added at all.
    pub(super) fn put_over(
        &self,
        scene: &mut Scene,
        file: SceneFile,
        headlight: bool,
    ) -> Result<(), SceneError> {
        let Given { settings, device } =
            serde_json::from_str(self.document.text).map_err(|problem| self.not_taken(&problem))?;
        let has_samples = settings.contains_key("samples") && !settings.contains_key("pixel-sampling");
        scene.settings = self.over::<RenderSettings>(&scene.settings, settings)?;
        semantics::check_settings(self.document, scene.settings.integrator)?;
        // As the flag does: a number of samples would not count beside the base's grid.
        if has_samples && matches!(scene.settings.pixel_sampling, PixelSampling::Grid(_)) {
            scene.settings.pixel_sampling = PixelSampling::Random;
        }
        scene.settings.headlight &= headlight && !file.lights.as_ref().is_some_and(Vec::is_empty);
        scene.device = self.over::<DeviceSettings>(&scene.device, device)?;
        if let Some(camera) = file.camera {
            semantics::check_camera(self.document, &self.camera_about_itself(&camera), false)?;
            scene.camera = Some(self.placed_camera(camera, scene));
            scene.animation.iter_mut().for_each(|animation| animation.camera = None);
        }
        if let Some(lights) = file.lights {
            scene.lights = self.placed_lights(lights, scene);
        }
        scene.output = file.output.or(scene.output.take());
        scene.frame = file.frame.unwrap_or(scene.frame);
        scene.validate().map_err(|problem| self.document.problem(&problem, |_| None))
    }

    /// The keys that are given over those that are there.
    fn over<T: Serialize + DeserializeOwned>(
        &self,
        below: &T,
        given: Map<String, Value>,
    ) -> Result<T, SceneError> {
        let merged = serde_json::to_value(below).and_then(|mut all| {
            all.as_object_mut().into_iter().for_each(|all| all.extend(given.clone()));
            serde_json::from_value(all)
        });
        merged.map_err(|problem| self.not_taken(&problem))
    }

    /// The schema has let something through that is not read.
    fn not_taken(&self, problem: &serde_json::Error) -> SceneError {
        let message = format!("the file does not follow the format ({problem}); see scenes/REFERENCE.md");
        self.document.error(self.document.root.at, message)
    }

    /// A camera in coordinates of the file, as the scene counts them.
    fn placed_camera(&self, camera: Camera, scene: &Scene) -> Camera {
        let place = |key: &str, rounded: Vec3| {
            scene.point_of_file(self.exact(&way!["camera", key]).unwrap_or(double(rounded)))
        };
        Camera {
            position: place("position", camera.position),
            look_at: camera.look_at.map(|rounded| place("look-at", rounded)),
            ..camera
        }
    }

    /// Lights in coordinates of the file, as the scene counts them.
    fn placed_lights(&self, mut lights: Vec<Light>, scene: &Scene) -> Vec<Light> {
        for (i, light) in lights.iter_mut().enumerate() {
            let way: [Step; 4] = way!["lights", i, light.key(), "position"];
            if let Some(position) = light.parts().position {
                *position = scene.point_of_file(self.exact(&way).unwrap_or(double(*position)));
            }
        }
        lights
    }
}
