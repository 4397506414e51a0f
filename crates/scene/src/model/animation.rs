//! What moves: frames are numbered from 0, and each is a scene of its own.

use super::schema_types::{Color, Vector};
use super::transform::{double, single};
use super::{Camera, Deformation, Instance, Interpolation, Light, LightParts, Move, Scene};
use eosphor_core::math::{Affine, Vec3, elementary64};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// The most frames of an animation: a day at 69 a second.
pub const MAX_FRAMES: u32 = 6_000_000;

/// How a scene moves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(extend("examples" = [{ "frames": 120, "camera": { "orbit": { "turns": 1 } } }]))]
pub struct Animation {
    /// How many frames there are.
    #[schemars(range(min = 1, max = 6_000_000))]
    pub frames: u32,
    /// Frames a second, for videos and for what moves by time.
    #[serde(default = "twenty_four")]
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1000))]
    pub fps: f32,
    /// How the camera moves.
    #[serde(default)]
    pub camera: Option<CameraMotion>,
    /// How lights move and change.
    #[serde(default)]
    pub lights: Vec<LightMotion>,
}

impl Animation {
    /// So many frames, in which nothing moves.
    pub fn of_frames(frames: u32) -> Animation {
        Animation { frames, fps: twenty_four(), camera: None, lights: Vec::new() }
    }
}

/// How a camera moves. What a motion does not set stays as the scene's camera has it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", rename_all_fields = "kebab-case", deny_unknown_fields)]
#[schemars(extend("examples" = [{ "orbit": { "turns": 1 } }]))]
pub enum CameraMotion {
    /// Around a point, about the camera's up: a turntable.
    Orbit {
        /// Times around over all frames; below 0 the other way.
        #[serde(default = "one")]
        turns: f32,
        /// The point; the camera's look-at where not given, and where it has none, the origin.
        #[serde(default)]
        #[schemars(with = "Option<Vector>")]
        around: Option<Vec3>,
    },
    /// By laws in cylindrical coordinates about the z axis (PLATO's flight). Time runs from 0 to 2π over all frames.
    Laws {
        /// Where the camera is.
        position: Law,
        /// The point in the middle of the picture.
        look_at: Law,
    },
    /// Through points at given times.
    Keys {
        /// By time.
        keys: Vec<CameraKey>,
        /// How it goes from one to the next.
        #[serde(default)]
        interpolation: Interpolation,
    },
    /// As objects do: one after the other, the first one first.
    Moves(Vec<Move>),
}

/// A camera at a time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(rename = "CameraKey", extend("examples" = [{ "seconds": 1.5, "position": [0, 2, 7], "look-at": [0, 1, 0] }]))]
pub struct CameraKey {
    /// Seconds from the first frame.
    #[schemars(range(min = 0))]
    pub seconds: f32,
    /// Where the camera is.
    #[schemars(with = "Vector")]
    pub position: Vec3,
    /// The point in the middle of the picture.
    #[schemars(with = "Vector")]
    pub look_at: Vec3,
}

/// How a light moves and changes. What no key sets stays as the light has it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(extend("examples" = [{ "light": 0, "keys": [
    { "seconds": 0, "color": [0, 0, 0] }, { "seconds": 2, "color": [20, 20, 18] }
] }]))]
pub struct LightMotion {
    /// Which of the scene's `lights`, from 0.
    #[schemars(range(min = 0, max = 4_294_967_295u32))]
    pub light: u32,
    /// By time.
    #[serde(default)]
    pub keys: Vec<LightKey>,
    /// How it goes from one to the next.
    #[serde(default)]
    pub interpolation: Interpolation,
    /// As objects do, after the keys: one after the other, the first one first.
    #[serde(default)]
    pub moves: Vec<Move>,
}

/// A light at a time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(extend("examples" = [{ "seconds": 1.5, "position": [0, 3, 0] }]))]
pub struct LightKey {
    /// Seconds from the first frame.
    #[schemars(range(min = 0))]
    pub seconds: f32,
    /// Where a point or spot light is.
    #[serde(default)]
    #[schemars(with = "Option<Vector>")]
    pub position: Option<Vec3>,
    /// The way that a directional or spot light shines.
    #[serde(default)]
    #[schemars(with = "Option<Vector>")]
    pub direction: Option<Vec3>,
    /// Its colour.
    #[serde(default, alias = "colour")]
    #[schemars(with = "Option<Color>")]
    pub color: Option<Vec3>,
}

/// A point that moves: `r = r0 + a_r sin(w_r t + p_r)`, `z = z0 + a_z sin(w_z t + p_z)`, `phi = phi0 + w_phi t`; x is
/// `r cos phi`, y is `r sin phi`. Angles in radians.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
#[schemars(extend("examples" = [{ "r": 7, "z": 3, "r-amplitude": 2, "r-frequency": 2, "phi-frequency": 1 }]))]
pub struct Law {
    /// Distance from the z axis, in the middle.
    pub r: f32,
    /// Height, in the middle.
    pub z: f32,
    /// Angle about the z axis at the start.
    pub phi: f32,
    /// How far the distance swings.
    pub r_amplitude: f32,
    /// How far the height swings.
    pub z_amplitude: f32,
    /// Swings of the distance over all frames.
    pub r_frequency: f32,
    /// Swings of the height over all frames.
    pub z_frequency: f32,
    /// Turns about the z axis over all frames.
    pub phi_frequency: f32,
    /// Phase of the distance's swing.
    pub r_phase: f32,
    /// Phase of the height's swing.
    pub z_phase: f32,
}

impl Law {
    /// The point at a time from 0 to 2π.
    pub fn point(&self, t: f64) -> Vec3 {
        single(self.exact_point(t))
    }

    pub(crate) fn exact_point(&self, t: f64) -> [f64; 3] {
        let swing = |middle: f32, amplitude: f32, frequency: f32, phase: f32| {
            let angle = f64::from(frequency) * t + f64::from(phase);
            f64::from(middle) + f64::from(amplitude) * elementary64::sin(angle)
        };
        let r = swing(self.r, self.r_amplitude, self.r_frequency, self.r_phase);
        let z = swing(self.z, self.z_amplitude, self.z_frequency, self.z_phase);
        let phi = f64::from(self.phi) + f64::from(self.phi_frequency) * t;
        [r * elementary64::cos(phi), r * elementary64::sin(phi), z]
    }
}

impl CameraMotion {
    /// Whether it says where the camera is and where it looks, so that these of the scene's camera do not count.
    pub(crate) fn sets_view(&self) -> bool {
        match self {
            CameraMotion::Laws { .. } => true,
            CameraMotion::Keys { keys, .. } => !keys.is_empty(),
            CameraMotion::Orbit { .. } | CameraMotion::Moves(_) => false,
        }
    }
}

impl Animation {
    /// Seconds from the first frame.
    fn seconds(&self, frame: u32) -> f64 {
        f64::from(frame) / f64::from(self.fps)
    }

    /// A light of a frame; `light` is the scene's.
    fn light_at(&self, frame: u32, number: u32, light: Light) -> Light {
        let mut light = light;
        let seconds = self.seconds(frame);
        for motion in self.lights.iter().filter(|motion| motion.light == number) {
            let track = |of: fn(&LightKey) -> Option<Vec3>, now: Vec3| {
                let keys = motion.keys.iter().filter_map(|key| Some((f64::from(key.seconds), of(key)?)));
                motion.interpolation.vector(keys, seconds).unwrap_or(now)
            };
            let carried =
                (!motion.moves.is_empty()).then(|| Move::map_of_all(&motion.moves, seconds).affine());
            let carried = carried.unwrap_or(Affine::IDENTITY);
            let place = |now: Vec3| carried.point(track(|key| key.position, now));
            let way = |now: Vec3| carried.direction(track(|key| key.direction, now));
            // Smooth curves swing beyond their keys: there is no colour below black.
            let shade = |now: Vec3| track(|key| key.color, now).max(Vec3::ZERO);
            let LightParts { position, direction, color } = light.parts();
            if let Some(position) = position {
                *position = place(*position);
            }
            if let Some(direction) = direction {
                *direction = way(*direction);
            }
            *color = shade(*color);
        }
        light
    }

    /// The camera of a frame; `camera` and `origin` are the scene's.
    fn camera_at(&self, frame: u32, camera: Camera, origin: [f64; 3]) -> Camera {
        let of_file = |p: [f64; 3]| single([p[0] - origin[0], p[1] - origin[1], p[2] - origin[2]]);
        let share = f64::from(frame) / f64::from(self.frames);
        match &self.camera {
            None => camera,
            Some(CameraMotion::Orbit { turns, around }) => {
                let center = around.or(camera.look_at).unwrap_or_else(|| of_file([0.0; 3]));
                let up = camera.up.normalize_or(Vec3::ZERO);
                let turned = |v: Vec3| turn(v, up, f64::from(*turns) * share * TAU);
                Camera {
                    position: center + turned(camera.position - center),
                    look_at: camera.look_at.map(|point| center + turned(point - center)),
                    direction: turned(camera.direction),
                    ..camera
                }
            }
            Some(CameraMotion::Laws { position, look_at }) => {
                let t = 2.0 * PI * share;
                let look_at = of_file(look_at.exact_point(t));
                Camera { position: of_file(position.exact_point(t)), look_at: Some(look_at), ..camera }
            }
            Some(CameraMotion::Keys { keys, interpolation }) => {
                let at = |of: fn(&CameraKey) -> Vec3| {
                    let keys = keys.iter().map(|key| (f64::from(key.seconds), of(key)));
                    interpolation.vector(keys, self.seconds(frame))
                };
                let position = at(|key| key.position).unwrap_or(camera.position);
                Camera { position, look_at: at(|key| key.look_at).or(camera.look_at), ..camera }
            }
            Some(CameraMotion::Moves(moves)) => {
                let map = Move::map_of_all(moves, self.seconds(frame)).affine();
                Camera {
                    position: map.point(camera.position),
                    look_at: camera.look_at.map(|point| map.point(point)),
                    direction: map.direction(camera.direction),
                    up: map.direction(camera.up),
                    ..camera
                }
            }
        }
    }
}

fn mix(axis: impl Fn(usize) -> f64) -> Vec3 {
    Vec3 { x: axis(0) as f32, y: axis(1) as f32, z: axis(2) as f32 }
}

/// Rotates about an axis of unit length (Rodrigues).
fn turn(v: Vec3, axis: Vec3, radians: f64) -> Vec3 {
    let (sin, cos) = (elementary64::sin(radians), elementary64::cos(radians));
    let [v, k] = [v, axis].map(|v| [v.x, v.y, v.z].map(f64::from));
    let dot = k[0] * v[0] + k[1] * v[1] + k[2] * v[2];
    mix(|axis| {
        let (next, after) = ((axis + 1) % 3, (axis + 2) % 3);
        let cross = k[next] * v[after] - k[after] * v[next];
        v[axis] * cos + cross * sin + k[axis] * dot * (1.0 - cos)
    })
}

impl Scene {
    /// The camera of a frame. `None` where the scene has no camera, and nothing moves it.
    pub fn camera_at(&self, frame: u32) -> Option<Camera> {
        match &self.animation {
            Some(animation) if animation.camera.is_some() => {
                let camera = || Camera {
                    position: self.point_of_file(double(Camera::default().position)),
                    ..Camera::default()
                };
                Some(animation.camera_at(frame, self.camera.unwrap_or_else(camera), self.origin))
            }
            _ => self.camera,
        }
    }
}

impl Scene {
    /// An animation that lasts until the last key of what moves: these, and the instances. None where nothing does.
    pub(crate) fn animate(&mut self, camera: Option<CameraMotion>, lights: Vec<LightMotion>) {
        let of_camera = match &camera {
            Some(CameraMotion::Moves(moves)) => moves.as_slice(),
            _ => &[],
        };
        let of_instances = self.instances.iter().flat_map(|instance| &instance.moves).map(|motion| &**motion);
        let all = of_instances.chain(of_camera).chain(lights.iter().flat_map(|motion| &motion.moves));
        let of_vertices = self.placed_deformations().filter_map(|deformation| deformation.last_seconds());
        let last_keys = all.filter_map(|motion| motion.keys.last()).map(|key| key.seconds);
        self.animation = last_keys.chain(of_vertices).reduce(f32::max).map(|seconds| {
            let animation = Animation::of_frames(1);
            // Times in single precision are not quite those that were meant: 25 frames are not 26.
            let frames = (f64::from(seconds) * f64::from(animation.fps) - 1e-3).ceil();
            let frames = frames.clamp(1.0, f64::from(MAX_FRAMES)) as u32;
            Animation { frames, camera, lights, ..animation }
        });
    }

    /// Whether its animation says where the camera is and where it looks, so that position, direction and look-at of its
    /// own camera do not count.
    pub fn camera_is_led(&self) -> bool {
        let motion = self.animation.as_ref().and_then(|animation| animation.camera.as_ref());
        motion.is_some_and(CameraMotion::sets_view)
    }

    /// Whether any instance has a motion, even one whose keys leave it where it is.
    pub fn has_moving_instances(&self) -> bool {
        self.instances.iter().any(|instance| !instance.moves.is_empty())
    }

    /// Whether the vertices of anything that is placed move within their mesh, by skins or morph targets.
    pub fn has_moving_vertices(&self) -> bool {
        self.placed_deformations().next().is_some()
    }

    /// What moves vertices of placed meshes, once for each place.
    pub fn placed_deformations(&self) -> impl Iterator<Item = &Deformation> {
        let mesh = |instance: &Instance| self.meshes.get(instance.mesh as usize);
        self.instances.iter().filter_map(mesh).filter_map(|mesh| mesh.deformation.as_deref())
    }

    /// Whether anything moves by seconds, so that the frames of a second change what frames show.
    pub fn moves_by_seconds(&self) -> bool {
        let by_keys = |animation: &Animation| {
            !animation.lights.is_empty() || matches!(animation.camera, Some(CameraMotion::Keys { .. }))
        };
        self.has_moving_instances()
            || self.has_moving_vertices()
            || self.animation.as_ref().is_some_and(by_keys)
    }

    /// Seconds from the first frame; 0 without an animation.
    pub(crate) fn seconds(&self, frame: u32) -> f64 {
        self.animation.as_ref().map_or(0.0, |animation| animation.seconds(frame))
    }

    /// The lights of a frame.
    pub fn lights_at(&self, frame: u32) -> Vec<Light> {
        let Some(animation) = self.animation.as_ref().filter(|animation| !animation.lights.is_empty()) else {
            return self.lights.clone();
        };
        let at = |(number, &light): (usize, &Light)| animation.light_at(frame, number as u32, light);
        self.lights.iter().enumerate().map(at).collect()
    }
}

fn twenty_four() -> f32 {
    24.0
}

fn one() -> f32 {
    1.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{MoveKey, Transform};
    use eosphor_core::math::vec3;

    const HERE: [f64; 3] = [0.0; 3];

    fn near(a: Vec3, b: Vec3) -> bool {
        (a - b).length() < 1e-5
    }

    #[test]
    fn laws_are_those_of_the_course() {
        let law = Law {
            r: 7.0,
            z: 3.0,
            phi: 0.5,
            r_amplitude: 2.0,
            z_amplitude: 1.0,
            r_frequency: 2.0,
            z_frequency: 6.0,
            phi_frequency: 1.0,
            r_phase: 0.25,
            z_phase: -0.5,
        };
        for t in [0.0f64, 0.3, 2.0, 6.1] {
            let r = 7.0 + 2.0 * (2.0 * t + 0.25).sin();
            let (z, phi) = (3.0 + (6.0 * t - 0.5).sin(), 0.5 + t);
            let expected = vec3((r * phi.cos()) as f32, (r * phi.sin()) as f32, z as f32);
            assert!(near(law.point(t), expected), "{t}");
        }
    }

    #[test]
    fn an_orbit_goes_around_and_looks_at_the_middle() {
        let camera =
            Camera { position: vec3(1.0, 2.0, 5.0), look_at: Some(vec3(1.0, 0.0, 0.0)), ..Camera::default() };
        let orbit = CameraMotion::Orbit { turns: 1.0, around: None };
        let animation = Animation { camera: Some(orbit), ..Animation::of_frames(4) };
        assert!(near(animation.camera_at(0, camera, HERE).position, camera.position));
        // A quarter about y takes z to x.
        assert!(near(animation.camera_at(1, camera, HERE).position, vec3(6.0, 2.0, 0.0)));
        assert!(near(animation.camera_at(2, camera, HERE).position, vec3(1.0, 2.0, -5.0)));
        assert!(near(animation.camera_at(3, camera, HERE).look_at.unwrap(), vec3(1.0, 0.0, 0.0)));
    }

    #[test]
    fn cameras_and_lights_are_carried() {
        let at = |seconds, x| MoveKey { seconds, translate: Some(vec3(x, 0.0, 0.0)), ..MoveKey::default() };
        let by = Move { keys: vec![at(0.0, 0.0), at(2.0, 4.0)], ..Move::default() };
        let turn = Move {
            transform: Transform { rotate_degrees: vec3(0.0, 90.0, 0.0), ..Transform::default() },
            ..Move::default()
        };
        let moves = vec![by, turn];
        let animation = Animation {
            fps: 1.0,
            camera: Some(CameraMotion::Moves(moves.clone())),
            lights: vec![LightMotion {
                light: 0,
                keys: Vec::new(),
                interpolation: Interpolation::Linear,
                moves,
            }],
            ..Animation::of_frames(3)
        };
        let (position, direction) = (vec3(0.0, 1.0, 0.0), vec3(1.0, 0.0, 0.0));
        let camera = Camera { position, direction, look_at: None, ..Camera::default() };
        let sun = Light::Directional { direction, color: Vec3::ONE };
        let scene =
            Scene { camera: Some(camera), lights: vec![sun], animation: Some(animation), ..Scene::default() };
        // x becomes -z.
        let camera = scene.camera_at(1).unwrap();
        assert!(near(camera.position, vec3(0.0, 1.0, -2.0)) && near(camera.direction, vec3(0.0, 0.0, -1.0)));
        let [Light::Directional { direction, .. }] = scene.lights_at(2)[..] else { panic!() };
        assert!(near(direction, vec3(0.0, 0.0, -1.0)));
    }

    #[test]
    fn animations_last_until_the_last_key() {
        let frames = |seconds: &[f32]| {
            let keys = seconds.iter().map(|&seconds| MoveKey { seconds, ..MoveKey::default() }).collect();
            let mut scene = Scene::default();
            scene.animate(Some(CameraMotion::Moves(vec![Move { keys, ..Move::default() }])), Vec::new());
            scene.animation.map(|animation| animation.frames)
        };
        assert_eq!(frames(&[]), None);
        for (last, expected) in [(0.0, 1), (1.0, 24), (1.01, 25), (25.0 / 24.0, 25), (1e9, MAX_FRAMES)] {
            assert_eq!(frames(&[0.0, last]), Some(expected), "{last}");
        }
    }

    #[test]
    fn lights_change_what_their_keys_set() {
        let lamp = Light::Point { position: vec3(1.0, 2.0, 3.0), color: Vec3::splat(8.0) };
        let sun = Light::Directional { direction: vec3(0.0, -1.0, 0.0), color: Vec3::ONE };
        let key =
            |seconds, color| LightKey { seconds, color: Some(Vec3::splat(color)), ..LightKey::default() };
        let keys = vec![key(0.0, 0.0), key(1.0, 4.0)];
        let fades = LightMotion { light: 0, keys, interpolation: Interpolation::Linear, moves: Vec::new() };
        let animation = Animation { fps: 4.0, lights: vec![fades], ..Animation::of_frames(9) };
        let scene = Scene { lights: vec![lamp, sun], animation: Some(animation), ..Scene::default() };
        for (frame, expected) in [(0, 0.0), (1, 1.0), (3, 3.0), (8, 4.0)] {
            let at = Light::Point { position: vec3(1.0, 2.0, 3.0), color: Vec3::splat(expected) };
            assert_eq!(scene.lights_at(frame), [at, sun]);
        }
    }

    #[test]
    fn keys_are_passed_at_their_times_and_ends_hold() {
        let key = |seconds, x| CameraKey { seconds, position: vec3(x, x * x, 0.0), look_at: Vec3::ZERO };
        let keys = vec![key(0.5, 1.0), key(1.0, 2.0), key(2.0, 4.0), key(2.5, 5.0)];
        for interpolation in [Interpolation::Linear, Interpolation::Smooth] {
            let camera = CameraMotion::Keys { keys: keys.clone(), interpolation };
            let animation = Animation { fps: 4.0, camera: Some(camera), ..Animation::of_frames(12) };
            let x = |frame| animation.camera_at(frame, Camera::default(), HERE).position.x;
            // x goes up by 2 a second, and both keep to that.
            let found: Vec<f32> = (0..12).map(x).collect();
            let expected = [1.0, 1.0, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0, 5.0];
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{found:?}");
        }
    }
}
