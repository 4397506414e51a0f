//! Scenes that lie far from 0: what single precision would lose is taken from the tree, which has all digits of the file.

use super::build::Builder;
use super::tree::{Node, Step, Value};
use crate::model::origin::{APART, FAR, SharedMoves};
use crate::model::{
    Camera, CameraMotion, ExactTransform, LightMotion, Matrix, Move, Scene, Transform, add, double, single,
};
use eosphor_core::math::Vec3;
use std::sync::Arc;

/// Motions of the file, and where they stand in it.
pub(super) type PlacedMoves<'s> = Vec<(Arc<Move>, [Step<'s>; 4])>;

/// A stated origin is rounded to single precision: what is at 0 of the file has exact coordinates then.
fn stated(origin: [f64; 3]) -> [f64; 3] {
    origin.map(|x| f64::from(x as f32))
}

/// A transform of the file with all its digits.
pub(super) fn exact_map(node: &Node) -> Matrix {
    let vector = |key: &str| node.get(key).and_then(Node::numbers::<3>);
    let scale = match node.get("scale").map(|node| &node.value) {
        Some(&Value::Number(scale, _)) => [scale; 3],
        _ => vector("scale").unwrap_or([1.0; 3]),
    };
    let matrix = node.get("matrix").filter(|node| matches!(node.value, Value::List(_)));
    let row = |k: usize| matrix.and_then(|node| node.at_end(&[Step::Item(k)])?.numbers::<4>());
    let (rotate_degrees, translate) = (vector("rotate-degrees"), vector("translate"));
    ExactTransform {
        scale,
        rotate_degrees: rotate_degrees.unwrap_or([0.0; 3]),
        translate: translate.unwrap_or([0.0; 3]),
        matrix: match (row(0), row(1), row(2)) {
            (Some(x), Some(y), Some(z)) => Some([x, y, z]),
            _ => None,
        },
    }
    .map()
}

impl Builder<'_> {
    /// A vector of the file with all its digits.
    pub(super) fn exact(&self, way: &[Step]) -> Option<[f64; 3]> {
        self.document.root.at_end(way)?.numbers()
    }

    /// Whether what the file itself describes, of this size, lies where single precision would lose its digits.
    pub(super) fn is_beyond(&self, place: [f64; 3], size: f64) -> bool {
        let sizes = if self.loader.apart < APART { self.loader.apart } else { FAR };
        place.iter().any(|x| x.abs() > size * sizes)
    }

    /// The camera of the first frame, at 0: which way it looks then has all digits. What moves by laws or through keys is not
    /// where it rests.
    pub(super) fn first_camera(&self, camera: &Camera, motion: Option<&CameraMotion>) -> Camera {
        let (position, look_at) = match motion {
            Some(CameraMotion::Laws { position, look_at }) => {
                (position.exact_point(0.0), look_at.exact_point(0.0))
            }
            Some(CameraMotion::Keys { keys, .. }) if !keys.is_empty() => {
                let exact = |key: &str, rounded: Vec3| {
                    let way = ["animation", "camera", "keys", "keys"].map(Step::Key);
                    let way = [&way[..], &[Step::Item(0), Step::Key(key)]].concat();
                    self.exact(&way).unwrap_or(double(rounded))
                };
                (exact("position", keys[0].position), exact("look-at", keys[0].look_at))
            }
            _ => return self.camera_about_itself(camera),
        };
        let look_at = Some(single(add(look_at, position.map(|x| -x))));
        Camera { position: Vec3::ZERO, look_at, ..*camera }
    }

    /// A camera that is at 0.
    pub(super) fn camera_about_itself(&self, camera: &Camera) -> Camera {
        let of_file = |key: &str, rounded: Vec3| {
            self.exact(&[Step::Key("camera"), Step::Key(key)]).unwrap_or(double(rounded))
        };
        let back = of_file("position", camera.position).map(|x| -x);
        let look_at = camera.look_at.map(|rounded| single(add(of_file("look-at", rounded), back)));
        Camera { position: Vec3::ZERO, look_at, ..*camera }
    }

    /// Whether the digits of transforms count: a model or the scene lies far from 0.
    pub(super) fn is_far(&self, origin: Option<[f64; 3]>) -> bool {
        let scene = &self.loader.scene;
        let is_apart = |transform: &Transform| transform.offset != [0.0; 3];
        let origin = origin.map_or_else(|| scene.far_origin(), stated);
        origin != [0.0; 3]
            || scene.instances.iter().any(|instance| {
                is_apart(&instance.world_from_object)
                    || instance.moves.iter().any(|motion| is_apart(&motion.transform))
            })
    }

    /// Counts the coordinates of the scene from the origin that the file states, or else from that which its first placed
    /// vertex gives. Whether that is not 0.
    pub(super) fn count_from_origin(&mut self, origin: Option<[f64; 3]>, moves: &PlacedMoves) -> bool {
        let origin = origin.map_or_else(|| self.loader.scene.far_origin(), stated);
        if origin == self.loader.scene.origin {
            return false;
        }
        let by = origin.map(|x| -x);
        let mut shared = SharedMoves::new();
        for (motion, way) in moves {
            let mut shifted = motion.shifted(by);
            self.mend_move(&mut shifted, by, way);
            shared.insert(Arc::as_ptr(motion), Arc::new(shifted));
        }
        let mut scene = std::mem::take(&mut self.loader.scene);
        scene.set_origin_with(origin, shared);
        self.mend_places(&mut scene, by);
        self.loader.scene = scene;
        true
    }

    /// Places that were shifted, now with the digits that the file has.
    fn mend_places(&self, scene: &mut Scene, by: [f64; 3]) {
        let mend = |p: &mut Vec3, way: &[Step]| self.mend(p, by, way);
        if let Some(camera) = &mut scene.camera {
            mend(&mut camera.position, &[Step::Key("camera"), Step::Key("position")]);
            camera.look_at.iter_mut().for_each(|p| mend(p, &[Step::Key("camera"), Step::Key("look-at")]));
        }
        for (i, light) in scene.lights.iter_mut().enumerate() {
            let way = [Step::Key("lights"), Step::Item(i), Step::Key(light.key()), Step::Key("position")];
            if let Some(position) = light.parts().position {
                mend(position, &way);
            }
        }
        for (i, sphere) in scene.spheres.iter_mut().enumerate() {
            mend(&mut sphere.center, &[Step::Key("spheres"), Step::Item(i), Step::Key("center")]);
        }
        for (i, p) in scene.parallelograms.iter_mut().enumerate() {
            mend(&mut p.corner, &[Step::Key("parallelograms"), Step::Item(i), Step::Key("corner")]);
        }
        if let Some(animation) = &mut scene.animation {
            if let Some(camera) = &mut animation.camera {
                self.mend_camera_motion(camera, by);
            }
            for (i, motion) in animation.lights.iter_mut().enumerate() {
                self.mend_light_motion(motion, i, by);
            }
        }
    }

    fn mend(&self, p: &mut Vec3, by: [f64; 3], way: &[Step]) {
        if let Some(exact) = self.exact(way) {
            *p = single(add(exact, by));
        }
    }

    fn mend_camera_motion(&self, motion: &mut CameraMotion, by: [f64; 3]) {
        let way = [Step::Key("animation"), Step::Key("camera")];
        match motion {
            CameraMotion::Laws { .. } => {}
            CameraMotion::Orbit { around, .. } => {
                let way = [way[0], way[1], Step::Key("orbit"), Step::Key("around")];
                around.iter_mut().for_each(|around| self.mend(around, by, &way));
            }
            CameraMotion::Keys { keys, .. } => {
                for (k, key) in keys.iter_mut().enumerate() {
                    let way = |name| {
                        let list = [way[0], way[1], Step::Key("keys"), Step::Key("keys")];
                        [list[0], list[1], list[2], list[3], Step::Item(k), Step::Key(name)]
                    };
                    self.mend(&mut key.position, by, &way("position"));
                    self.mend(&mut key.look_at, by, &way("look-at"));
                }
            }
            CameraMotion::Moves(moves) => {
                for (k, motion) in moves.iter_mut().enumerate() {
                    self.mend_move(motion, by, &[way[0], way[1], Step::Key("moves"), Step::Item(k)]);
                }
            }
        }
    }

    fn mend_light_motion(&self, motion: &mut LightMotion, number: usize, by: [f64; 3]) {
        let way = [Step::Key("animation"), Step::Key("lights"), Step::Item(number)];
        for (k, key) in motion.keys.iter_mut().enumerate() {
            let way = [&way[..], &[Step::Key("keys"), Step::Item(k), Step::Key("position")]].concat();
            key.position.iter_mut().for_each(|p| self.mend(p, by, &way));
        }
        for (k, motion) in motion.moves.iter_mut().enumerate() {
            self.mend_move(motion, by, &[&way[..], &[Step::Key("moves"), Step::Item(k)]].concat());
        }
    }

    /// A motion that is shifted already.
    fn mend_move(&self, motion: &mut Move, by: [f64; 3], way: &[Step]) {
        let Some(node) = self.document.root.at_end(way) else { return };
        if let Some(around) = node.get("around").and_then(Node::numbers) {
            motion.around = single(add(around, by));
        }
        if let Some(transform) = node.get("transform") {
            motion.transform = motion.transform.conjugated(by, &exact_map(transform));
        }
        // What its keys bring from 0 to here, the transform does: of the keys the rest is left.
        let translate = |k: usize| {
            node.at_end(&[Step::Key("keys"), Step::Item(k), Step::Key("translate")])?.numbers::<3>()
        };
        let Some(first) = (0..motion.keys.len()).find_map(translate) else { return };
        let rest = add(first, by);
        let reach = |p: [f64; 3]| p.iter().fold(0.0, |most: f64, x| x.abs().max(most));
        if reach(rest) * 256.0 >= reach(first) {
            return;
        }
        for (k, key) in motion.keys.iter_mut().enumerate() {
            if let Some(exact) = translate(k) {
                key.translate = Some(single(add(exact, by)));
            }
        }
        let map = motion.transform.to_double();
        motion.transform = Transform::exactly(&motion.transform.affine(), map.point(by.map(|x| -x)));
    }
}
