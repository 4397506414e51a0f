//! What differs from frame to frame: the camera and what follows from it, lights, where instances are, and shapes of meshes whose
//! vertices move. No other triangle is touched for it.

use super::lights::{Emitters, LightArrays};
use super::shapes::{ShapedArrays, Shapes};
use super::{SceneData, camera, lights, places, settings};
use crate::error::SceneError;
use crate::model::{Camera as ModelCamera, RenderSettings, Scene};
use eosphor_core::camera::Camera;
use eosphor_core::geometry::{Bounds, Instance};
use eosphor_core::light::{Light, LightNode};
use eosphor_core::math::Vec3;
use eosphor_core::settings::{Integrator, Settings};
use eosphor_core::view::SceneView;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// The state of a frame of an animation: all that may differ between frames. The rest of the [`SceneData`] is the same for all.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrameState {
    /// The camera.
    pub camera: Camera,
    /// Lights, in the order of [`SceneData::lights`].
    pub lights: Vec<Light>,
    /// The tree by which they are chosen, as [`SceneData::light_nodes`].
    pub light_nodes: Vec<LightNode>,
    /// The place of each light in that, as [`SceneData::light_places`].
    pub light_places: Vec<u32>,
    /// Settings that reach a pixel; the size is the scene's.
    pub settings: Settings,
    /// Where instances are; `None` where they stand still.
    pub places: Option<Places>,
    /// Shapes of the meshes whose vertices move; `None` where there are none.
    pub shapes: Option<Shapes>,
}

/// Where instances are in a frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Places {
    /// As many as [`SceneData::instances`], in the same order; number 0 is the world itself.
    pub instances: Vec<Instance>,
}

/// Makes the state of any frame of a scene.
pub struct FrameStates<'a> {
    scene: &'a Scene,
    data: &'a SceneData,
    bounds: Cow<'a, FrameBounds>,
}

/// What the states of all frames of a scene need, which takes a look at every primitive.
#[derive(Clone)]
pub struct FrameBounds {
    /// Bounds of each geometry, not padded.
    bounds: Vec<Bounds>,
    /// Bounds of the whole scene, where nothing moves.
    world: Bounds,
    /// Triangles that shine, where they may move.
    emitters: Option<Emitters>,
    /// Whether the only light is that of the camera.
    has_headlight: bool,
}

impl FrameBounds {
    /// `data` is what [`SceneData::flatten`] made of `scene`.
    pub fn new(scene: &Scene, data: &SceneData) -> FrameBounds {
        let is_own = |light: &Light| light.is_lamp();
        let has_headlight = scene.lights.is_empty() && data.lights.len() == 1 && !is_own(&data.lights[0]);
        let bounds = data.bounds_of_geometries();
        let world = places::world_bounds(&bounds, &data.instances);
        let emitters = data.instances_move.then(|| data.emitters());
        FrameBounds { bounds, world, emitters, has_headlight }
    }

    /// The middle of the box around the scene as it was flattened; 0 where there is nothing.
    pub fn center(&self) -> Vec3 {
        if self.world.is_empty() { Vec3::ZERO } else { (self.world.max + self.world.min) * 0.5 }
    }

    /// Half the diagonal of the box around the scene as it was flattened, in world units; 0 where there is nothing.
    pub fn radius(&self) -> f32 {
        if self.world.is_empty() { 0.0 } else { (self.world.max - self.world.min).length() / 2.0 }
    }
}

impl<'a> FrameStates<'a> {
    /// `data` is what [`SceneData::flatten`] made of `scene`.
    pub fn new(scene: &'a Scene, data: &'a SceneData) -> FrameStates<'a> {
        FrameStates { scene, data, bounds: Cow::Owned(FrameBounds::new(scene, data)) }
    }

    /// The same with bounds that are kept, for programs that ask for a frame now and then.
    pub fn with_bounds(scene: &'a Scene, data: &'a SceneData, bounds: &'a FrameBounds) -> FrameStates<'a> {
        FrameStates { scene, data, bounds: Cow::Borrowed(bounds) }
    }

    /// The state of a frame (0 is the first): what [`SceneData::flatten`] would make of the scene at that frame.
    ///
    /// # Errors
    /// Where the camera of this frame spans no view, or an instance leaves the range of coordinates.
    pub fn at(&self, frame: u32) -> Result<FrameState, SceneError> {
        self.seen_by(frame, self.scene.camera_at(frame).as_ref(), &self.scene.settings)
    }

    /// The state of a frame as another camera sees it, under other settings; without a camera, that of the scene. The size may
    /// be another, too. What flattening has made of the scene stays: normals, textures, what materials are composed of, units of
    /// light and falloff are those of the scene's own settings.
    ///
    /// # Errors
    /// Where the camera spans no view, or an instance leaves the range of coordinates.
    pub fn seen_by(
        &self,
        frame: u32,
        camera: Option<&ModelCamera>,
        settings: &RenderSettings,
    ) -> Result<FrameState, SceneError> {
        let deforms = self.data.deforming_geometries > 0;
        let (shapes, shaped_bounds) =
            deforms.then(|| Shapes::of_frame(self.scene, self.data, frame)).transpose()?.unzip();
        let mut bounds = Cow::Borrowed(&self.bounds.bounds);
        if let Some(own) = shaped_bounds {
            let first = bounds.len() - own.len();
            bounds.to_mut()[first..].copy_from_slice(&own);
        }
        let places = self.data.instances_move.then(|| self.places(frame, &bounds)).transpose()?;
        let world = match &places {
            Some(places) => places::world_bounds(&bounds, &places.instances),
            None => self.bounds.world,
        };
        let [width, height] = settings.size;
        let camera = match camera {
            Some(camera) => camera::from_model(camera, width, height)?,
            None => self.data.camera,
        };
        let LightArrays { lights, tree } = match self.bounds.has_headlight {
            true => {
                let own = vec![camera::headlight(&camera)];
                LightArrays::new(own, Vec::new(), settings, &self.data.view(), None)
            }
            false => self.lights(frame, (places.as_ref(), shapes.as_ref()), settings),
        };
        let is_dark = settings::surroundings(settings).is_some();
        let mut settings = settings::build(settings, &camera, &world);
        settings.light_falloff = self.data.settings.light_falloff;
        if settings.integrator == Integrator::Path {
            settings.shadow_mode = self.data.settings.shadow_mode;
            if is_dark {
                settings.background = self.data.settings.background;
            }
        }
        let (light_nodes, light_places) = (tree.nodes, tree.places);
        Ok(FrameState { camera, lights, light_nodes, light_places, settings, places, shapes })
    }

    fn lights(
        &self,
        frame: u32,
        (places, shapes): (Option<&Places>, Option<&Shapes>),
        settings: &RenderSettings,
    ) -> LightArrays {
        let data = self.data;
        let own = lights::explicit(self.scene, frame);
        // Whole arrays are made for lamps whose vertices move, and for these alone.
        let first = data.first_deforming();
        let shines = |emitters: &&Emitters| shapes.is_some() && emitters.shine_from(first, &data.view());
        let lamps = self.bounds.emitters.as_ref().filter(shines);
        let shaped = shapes.filter(|_| lamps.is_some()).map(|shapes| ShapedArrays::of_frame(data, shapes));
        let view = shaped.as_ref().map_or_else(|| data.view(), |arrays| arrays.view(data));
        let shining = match (&self.bounds.emitters, places) {
            (Some(emitters), Some(Places { instances })) => {
                emitters.lights(&self.scene.settings, &view, instances)
            }
            _ => data.lights[own.len()..].to_vec(),
        };
        let way = |s: &RenderSettings| (s.integrator, s.lights);
        let is_alike = way(settings) == way(&self.scene.settings);
        LightArrays::new(own, shining, settings, &view, is_alike.then_some(data))
    }

    /// `bounds` has those of each geometry in this frame.
    fn places(&self, frame: u32, bounds: &[Bounds]) -> Result<Places, SceneError> {
        let first_deforming = self.data.first_deforming();
        let mut instances = self.data.instances.clone();
        for instance in instances.iter_mut().skip(1) {
            // An instance is an object, which has the number that it has in the scene.
            let number = instance.object as usize;
            let geometry = instance.geometry as usize;
            if self.scene.instances[number].moves.is_empty() && geometry < first_deforming {
                continue;
            }
            let bounds = &bounds[geometry];
            let (map, inverse) = places::maps_of_geometry(self.scene, number, frame, bounds)?;
            (instance.world_from_object, instance.object_from_world) = (map, inverse);
            instance.world_bounds = bounds.placed(&map, &inverse);
        }
        Ok(Places { instances })
    }
}

impl SceneData {
    /// The arrays that shading a frame reads, borrowed; without a state those of the scene as it was flattened. `shaped` has the
    /// arrays of the frame's shapes, where it has some ([`ShapedArrays::take`]).
    pub fn view_at<'a>(
        &'a self,
        state: Option<&'a FrameState>,
        shaped: Option<&'a ShapedArrays>,
    ) -> SceneView<'a> {
        let view = shaped.map_or_else(|| self.view(), |arrays| arrays.view(self));
        let Some(FrameState { camera, lights, light_nodes, light_places, settings, places, shapes }) = state
        else {
            return view;
        };
        debug_assert_eq!(shapes.is_some(), shaped.is_some(), "arrays go with shapes");
        let view = SceneView { camera, lights, light_nodes, light_places, settings, ..view };
        match places {
            Some(Places { instances }) => SceneView { instances, ..view },
            None => view,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Animation, CameraMotion, Interpolation, MaterialKind, Move, MoveKey};
    use crate::{LoadOptions, load};
    use eosphor_core::math::vec3;
    use std::sync::Arc;

    fn state_of(data: SceneData, places: Option<Places>) -> FrameState {
        let SceneData { camera, lights, light_nodes, light_places, settings, .. } = data;
        FrameState { camera, lights, light_nodes, light_places, settings, places, shapes: None }
    }

    /// A frame's state is what flattening the scene with the frame's camera makes.
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
            let states = FrameStates::new(&scene, &data);
            assert_eq!(states.bounds.has_headlight, is_dark);
            for frame in 0..7 {
                let mut still = Scene { lights: scene.lights_at(frame), ..scene.clone() };
                still.camera = scene.camera_at(frame);
                still.animation = None;
                let (expected, _) = SceneData::flatten(&still).unwrap();
                let expected = state_of(expected, None);
                assert_eq!(states.at(frame).unwrap(), expected, "{frame}");
                let (of_frame, _) = SceneData::flatten(&Scene { frame, ..scene.clone() }).unwrap();
                assert_eq!(state_of(of_frame, None), expected, "{frame}");
            }
        }
        scene.camera = Some(ModelCamera { up: vec3(0.0, 0.0, 1.0), ..ModelCamera::default() });
        scene.animation = None;
        let (data, _) =
            SceneData::flatten(&load("builtin:cornell", &LoadOptions::default()).unwrap().scene).unwrap();
        assert!(FrameStates::new(&scene, &data).at(0).is_err());
    }

    /// The same for another camera, size and settings than the scene's.
    #[test]
    fn another_view_is_what_flattening_makes() {
        let whitted = load("builtin:cornell", &LoadOptions::default()).unwrap().scene;
        let mut paths = whitted.clone();
        paths.settings.integrator = Integrator::Path;
        // Without any light there are surroundings.
        let mut dark = paths.clone();
        dark.materials.retain_mut(|m| {
            m.kind = MaterialKind::Matte { color: Vec3::ONE };
            true
        });
        (dark.settings.ambient, dark.settings.background) = (0.0, Vec3::ZERO);
        for scene in [whitted, paths, dark] {
            assert_another_view_is_what_flattening_makes(scene);
        }
    }

    fn assert_another_view_is_what_flattening_makes(scene: Scene) {
        let (data, _) = SceneData::flatten(&scene).unwrap();
        let mut other = scene.clone();
        let camera = other.camera.as_mut().unwrap();
        (camera.position, camera.fov_x_degrees) = (camera.position + vec3(0.1, -0.2, 0.3), 61.0);
        (other.settings.size, other.settings.samples) = ([77, 41], 3);
        (other.settings.light_samples, other.settings.depth, other.settings.seed) = (5, 2, 9);
        let (expected, _) = SceneData::flatten(&other).unwrap();
        assert_ne!(expected.settings, data.settings);
        let state =
            FrameStates::new(&scene, &data).seen_by(0, other.camera.as_ref(), &other.settings).unwrap();
        assert_eq!(state, state_of(expected, None));
    }

    /// The same where an object moves: here to places that single precision can name.
    #[test]
    fn moved_instances_are_what_flattening_makes() {
        let mut scene = load("builtin:cornell", &LoadOptions::default()).unwrap().scene;
        scene.settings.max_distance = None;
        let key = |seconds: f32| MoveKey {
            seconds,
            translate: Some(vec3(seconds / 16.0, 0.0, 0.0)),
            rotate_degrees: Some(vec3(0.0, 10.0 * seconds, 0.0)),
            ..MoveKey::default()
        };
        let motion = |keys: Vec<MoveKey>| {
            vec![Arc::new(Move { keys, interpolation: Interpolation::Linear, ..Move::default() })]
        };
        scene.animation = Some(Animation { fps: 1.0, ..Animation::of_frames(5) });
        for instance in &mut scene.instances {
            instance.moves = motion(vec![key(0.0), key(8.0)]);
        }
        let (data, _) = SceneData::flatten(&scene).unwrap();
        assert!(data.instances_move && data.lights.len() > 1 && data.instances.len() > 1);
        let states = FrameStates::new(&scene, &data);
        for frame in 0..5 {
            let mut still = scene.clone();
            for instance in &mut still.instances {
                instance.moves = motion(vec![MoveKey { seconds: 0.0, ..key(frame as f32) }]);
            }
            let (expected, _) = SceneData::flatten(&still).unwrap();
            let places = Some(Places { instances: expected.instances.clone() });
            assert_eq!(states.at(frame).unwrap(), state_of(expected, places), "{frame}");
            // A still of the frame has the same.
            let still = Scene { frame, ..scene.clone() };
            let (data, _) = SceneData::flatten(&still).unwrap();
            let places = Some(Places { instances: data.instances.clone() });
            assert_eq!(states.at(frame).unwrap(), state_of(data, places), "{frame}");
        }
        assert!(states.at(1).unwrap().lights != states.at(2).unwrap().lights);
    }
}
