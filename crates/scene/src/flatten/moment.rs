//! What differs from frame to frame where nothing is built again: the camera, and what follows from it.

use super::{SceneData, camera, lights, settings};
use crate::error::SceneError;
use crate::model::Scene;
use eosphor_core::camera::Camera;
use eosphor_core::geometry::Bounds;
use eosphor_core::light::Light;
use eosphor_core::settings::Settings;
use eosphor_core::view::SceneView;

/// What a frame has of its own. The rest of the [`SceneData`] is the same for all of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Moment {
    /// The camera.
    pub camera: Camera,
    /// Lights, in the order of the scene's.
    pub lights: Vec<Light>,
    /// Settings that reach a pixel; the size is the scene's.
    pub settings: Settings,
}

/// The frames of a scene whose geometry stands still.
pub struct Moments<'a> {
    scene: &'a Scene,
    data: &'a SceneData,
    world: Bounds,
    /// Whether the only light is that of the camera.
    has_headlight: bool,
}

impl<'a> Moments<'a> {
    /// Of a scene and what [`SceneData::flatten`] made of it.
    pub fn new(scene: &'a Scene, data: &'a SceneData) -> Moments<'a> {
        let is_own = |light: &Light| matches!(light, Light::Triangle { .. });
        let has_headlight = scene.lights.is_empty() && data.lights.len() == 1 && !is_own(&data.lights[0]);
        Moments { scene, data, world: data.world_bounds(), has_headlight }
    }

    /// A frame, as [`SceneData::flatten`] would make it.
    ///
    /// # Errors
    /// Where the camera of this frame spans no view.
    pub fn at(&self, frame: u32) -> Result<Moment, SceneError> {
        let [width, height] = self.scene.settings.size;
        let camera = match self.scene.camera_at(frame) {
            Some(camera) => camera::from_model(&camera, width, height)?,
            None => self.data.camera,
        };
        let mut settings = settings::build(&self.scene.settings, &camera, &self.world);
        settings.light_falloff = self.data.settings.light_falloff;
        let lights = match self.has_headlight {
            true => vec![camera::headlight(&camera)],
            false => {
                let own = lights::explicit(self.scene, frame);
                let shining = self.data.lights[own.len()..].iter().copied();
                own.iter().copied().chain(shining).collect()
            }
        };
        Ok(Moment { camera, lights, settings })
    }
}

impl SceneData {
    /// Borrowed, for shading a frame; without a moment as it is.
    pub fn view_at<'a>(&'a self, moment: Option<&'a Moment>) -> SceneView<'a> {
        let view = self.view();
        match moment {
            Some(Moment { camera, lights, settings }) => SceneView { camera, lights, settings, ..view },
            None => view,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Animation, Camera as ModelCamera, CameraMotion};
    use crate::{LoadOptions, load};
    use eosphor_core::math::vec3;

    /// A moment is what flattening the scene with the frame's camera makes.
    #[test]
    fn moments_are_what_flattening_makes() {
        let mut scene = load("builtin:cornell", &LoadOptions::default()).unwrap().scene;
        scene.settings.max_distance = None;
        let camera = scene.camera.as_mut().unwrap();
        camera.look_at = Some(vec3(0.0, 0.8, 0.0));
        let orbit = CameraMotion::Orbit { turns: 1.0, around: None };
        scene.animation = Some(Animation { camera: Some(orbit), ..Animation::of_frames(7) });
        for is_dark in [false, true] {
            if is_dark {
                scene.materials.iter_mut().for_each(|m| *m = crate::Material::default_material());
            }
            let (data, _) = SceneData::flatten(&scene).unwrap();
            let moments = Moments::new(&scene, &data);
            assert_eq!(moments.has_headlight, is_dark);
            for frame in 0..7 {
                let mut still = Scene { lights: scene.lights_at(frame), ..scene.clone() };
                still.camera = scene.camera_at(frame);
                still.animation = None;
                let (expected, _) = SceneData::flatten(&still).unwrap();
                let SceneData { camera, lights, settings, .. } = expected;
                assert_eq!(moments.at(frame).unwrap(), Moment { camera, lights, settings }, "{frame}");
            }
        }
        scene.camera = Some(ModelCamera { up: vec3(0.0, 0.0, 1.0), ..ModelCamera::default() });
        scene.animation = None;
        let (data, _) =
            SceneData::flatten(&load("builtin:cornell", &LoadOptions::default()).unwrap().scene).unwrap();
        assert!(Moments::new(&scene, &data).at(0).is_err());
    }
}
