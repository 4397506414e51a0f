//! The origin of what lies far from the 0 of its file: coordinates in single precision are counted from there.

use super::transform::{add, double, single};
use super::{Animation, CameraMotion, Instance, Mesh, Move, Scene, Triangle};
use eosphor_core::math::Vec3;
use std::collections::HashMap;
use std::sync::Arc;

/// A scene has an origin of its own where its first placed vertex is farther from 0 than so many sizes of the mesh that has
/// it. There single precision would leave 8 bits of the mesh.
pub(crate) const FAR: f64 = 65_536.0;

/// A mesh keeps its vertices about a point of its own from so many of its sizes on: what places it may take it anywhere.
/// Nearer ones keep 16 bits and more.
pub(crate) const APART: f64 = 256.0;

/// Motions that several instances share, by their address.
pub(crate) type SharedMoves = HashMap<*const Move, Arc<Move>>;

/// The largest absolute coordinate.
fn reach(p: [f64; 3]) -> f64 {
    p.iter().fold(0.0, |most, x| x.abs().max(most))
}

/// The largest power of two that is not larger.
fn power_of_two(x: f64) -> f64 {
    f64::from_bits(x.to_bits() & (0x7ff << 52))
}

/// The first of these points and the largest side of the box around them all, where that point is farther from 0 than so
/// many of these sides. Of what is not far, no more points are looked at than it takes.
fn far(points: impl IntoIterator<Item = [f64; 3]>, sizes: f64) -> Option<([f64; 3], f64)> {
    let mut points = points.into_iter();
    let first = points.next()?;
    let (mut low, mut high, mut size) = (first, first, 0.0);
    for p in points {
        for axis in 0..3 {
            low[axis] = low[axis].min(p[axis]);
            high[axis] = high[axis].max(p[axis]);
            size = (high[axis] - low[axis]).max(size);
        }
        if size * sizes >= reach(first) {
            return None;
        }
    }
    (reach(first) > 0.0 && reach(first).is_finite()).then_some((first, size))
}

/// Rounded to a grid of 4 sizes or more, by a power of two, and so that single precision holds it. What is of this size has
/// coordinates of a few sizes there; and while it moves and changes by less, the point stays.
fn rounded(p: [f64; 3], size: f64) -> [f64; 3] {
    let last_bit = power_of_two(reach(p)) * 2f64.powi(-23);
    let grid = (2.0 * power_of_two(4.0 * size)).max(last_bit);
    p.map(|x| (x / grid).round_ties_even() * grid)
}

/// Where the coordinates of a mesh should be counted from, in those of its file, so that it is not farther from there than
/// so many of its sizes; `origin` is from where they are.
pub(crate) fn of_triangles(
    positions: &[Vec3],
    triangles: &[Triangle],
    origin: [f64; 3],
    sizes: f64,
) -> [f64; 3] {
    let points = corners(positions, triangles).map(|p| add(double(p), origin));
    // What has no extent in single precision may have one in double.
    let seen = far(points, sizes).filter(|(_, size)| *size > 0.0 || origin == [0.0; 3]);
    seen.map_or([0.0; 3], |(first, size)| rounded(first, size))
}

/// Whether a mesh lies far from 0 where it is placed.
pub(crate) fn is_apart(mesh: &Mesh, instance: &Instance) -> bool {
    far(placed_corners(mesh, instance), APART).is_some()
}

/// Corners of triangles in their place, in frame 0.
fn placed_corners(mesh: &Mesh, instance: &Instance) -> impl Iterator<Item = [f64; 3]> {
    let moved = Move::map_of_all(instance.moves.iter().map(|motion| &**motion), 0.0);
    let map = moved.after(&instance.world_from_object.to_double());
    corners(&mesh.positions, &mesh.triangles).map(move |p| map.point(double(p)))
}

/// Corners of triangles: vertices that no triangle has are not seen.
fn corners(positions: &[Vec3], triangles: &[Triangle]) -> impl Iterator<Item = Vec3> {
    triangles.iter().flat_map(|t| t.positions).map(|i| positions[i as usize])
}

impl Mesh {
    /// Counts the coordinates from a point of the mesh's own, where it lies far from 0; that point.
    pub(crate) fn count_from_own(&mut self) -> [f64; 3] {
        let points = corners(&self.positions, &self.triangles).map(double);
        let seen = far(points, APART).filter(|(_, size)| *size > 0.0);
        let Some((first, size)) = seen else { return [0.0; 3] };
        let origin = rounded(first, size);
        let by = origin.map(|x| -x);
        self.positions.iter_mut().for_each(|p| *p = single(add(double(*p), by)));
        origin
    }
}

impl Scene {
    /// A point of the file, as the scene has it.
    pub fn point_of_file(&self, p: [f64; 3]) -> Vec3 {
        single(add(p, self.origin.map(|x| -x)))
    }

    /// A point of the scene in coordinates of the file.
    pub fn point_in_file(&self, p: Vec3) -> [f64; 3] {
        add(double(p), self.origin)
    }

    /// Where the origin should be by the first placed vertex: 0, but for scenes far from there. Other meshes have no say,
    /// so that the origin stays when something is added.
    pub(crate) fn far_origin(&self) -> [f64; 3] {
        let mesh_of = |i: &Instance| self.meshes.get(i.mesh as usize).filter(|m| !m.triangles.is_empty());
        let first = self.instances.iter().find_map(|i| Some((i, mesh_of(i)?)));
        let Some((instance, mesh)) = first else { return [0.0; 3] };
        let points = placed_corners(mesh, instance).map(|p| add(p, self.origin));
        // A mesh without an extent is not seen.
        let seen = far(points, FAR).filter(|(_, size)| *size > 0.0);
        seen.map_or([0.0; 3], |(first, size)| rounded(first, size))
    }

    /// Puts the origin where the first placed vertex says: after geometry has come or moved.
    pub fn settle_origin(&mut self) {
        self.set_origin(self.far_origin());
    }

    /// Counts all coordinates from another point of the file. Nothing moves.
    pub fn set_origin(&mut self, origin: [f64; 3]) {
        self.set_origin_with(origin, SharedMoves::new());
    }

    /// [`Scene::set_origin`] with motions whose counterparts are known.
    pub(crate) fn set_origin_with(&mut self, origin: [f64; 3], mut shared: SharedMoves) {
        let by = [0, 1, 2].map(|axis| self.origin[axis] - origin[axis]);
        if by == [0.0; 3] {
            return;
        }
        self.origin = origin;
        self.shift_views(by);
        let shift = |p: &mut Vec3| *p = single(add(double(*p), by));
        self.spheres.iter_mut().for_each(|sphere| shift(&mut sphere.center));
        self.parallelograms.iter_mut().for_each(|p| shift(&mut p.corner));
        let mut last_ones = SharedMoves::new();
        for instance in &mut self.instances {
            if let Some(last) = last_that_leads_far(instance, by) {
                let known = last_ones.entry(Arc::as_ptr(last));
                *last = Arc::clone(known.or_insert_with(|| Arc::new(last.then_moved(by))));
                continue;
            }
            instance.world_from_object.offset = add(instance.world_from_object.offset, by);
            for motion in &mut instance.moves {
                let known = shared.entry(Arc::as_ptr(motion));
                *motion = Arc::clone(known.or_insert_with(|| Arc::new(motion.shifted(by))));
            }
        }
    }

    /// Moves all geometry in coordinates of the file, where that takes more digits than single precision has; camera and
    /// lights stay. False where it does not: then nothing has moved.
    pub(super) fn move_far_geometry(&mut self, by: [f64; 3]) -> bool {
        let before = self.origin;
        self.origin = add(before, by);
        let origin = self.far_origin();
        let is_far = |p: [f64; 3]| p != [0.0; 3];
        let is_apart = |instance: &Instance| is_far(instance.world_from_object.offset);
        if !is_far(before) && !is_far(origin) && !self.instances.iter().any(is_apart) {
            self.origin = before;
            return false;
        }
        self.shift_views(by.map(|x| -x));
        self.set_origin(origin);
        true
    }

    /// Adds to the coordinates of the camera and the lights.
    fn shift_views(&mut self, by: [f64; 3]) {
        let shift = |p: &mut Vec3| *p = single(add(double(*p), by));
        if let Some(camera) = &mut self.camera {
            shift(&mut camera.position);
            camera.look_at.iter_mut().for_each(shift);
        }
        for light in &mut self.lights {
            light.parts().position.map(shift);
        }
        if let Some(animation) = &mut self.animation {
            animation.shift(by);
        }
    }
}

/// The last motion of an instance that begins near 0 and is taken far away at the end, as nodes are that move within
/// others: there it is enough to come out elsewhere.
fn last_that_leads_far(instance: &mut Instance, by: [f64; 3]) -> Option<&mut Arc<Move>> {
    let begins = instance.world_from_object.to_double().0[3];
    let last = instance.moves.last_mut()?;
    (last.transform.offset != [0.0; 3] && reach(begins) < reach(add(begins, by))).then_some(last)
}

impl Animation {
    fn shift(&mut self, by: [f64; 3]) {
        let shift = |p: &mut Vec3| *p = single(add(double(*p), by));
        let shift_all =
            |moves: &mut Vec<Move>| moves.iter_mut().for_each(|motion| *motion = motion.shifted(by));
        match &mut self.camera {
            None | Some(CameraMotion::Laws { .. }) => {}
            Some(CameraMotion::Orbit { around, .. }) => {
                around.iter_mut().for_each(shift);
            }
            Some(CameraMotion::Keys { keys, .. }) => {
                for key in keys {
                    shift(&mut key.position);
                    shift(&mut key.look_at);
                }
            }
            Some(CameraMotion::Moves(moves)) => shift_all(moves),
        }
        for motion in &mut self.lights {
            motion.keys.iter_mut().filter_map(|key| key.position.as_mut()).for_each(shift);
            shift_all(&mut motion.moves);
        }
    }
}
