//! Where what moves gets to in the frames of an animation.

use super::subject::Subject;
use super::surfaces::{BOX_SIDES, Surfaces, area_vector};
use crate::double::{Vec3d, double, length, single};
use crate::flatten::{geometry, places};
use crate::model::{Mesh, Poses, Scene};
use eosphor_core::geometry::Bounds;
use eosphor_core::math::{Affine, Vec3};
use std::rc::Rc;

/// Frames that are looked at, at most; of longer animations as many at even distances, with the first and the last.
const MOST_FRAMES: u32 = 49;

/// Meshes of animations that have more moving triangles in all these frames count as their boxes.
const MOST_TRIANGLES: u64 = 1 << 18;

type Triangles = Rc<Vec<[Vec3; 3]>>;

/// What moves, in its own space and with its place: in the first frame, as [`Surfaces`] have it, and in others.
#[derive(Default)]
pub(in crate::flatten) struct Motion {
    instances: Vec<Vec<Stop>>,
    /// How many frames the animation has where anything moves, or 1.
    pub(super) frames: u32,
}

/// An instance in a frame. A triangle has the same number in each.
struct Stop {
    map: Affine,
    triangles: Triangles,
}

impl Motion {
    /// `first_deforming` is the number of the first geometry whose vertices move.
    pub(in crate::flatten) fn new(scene: &Scene, surfaces: &Surfaces, first_deforming: usize) -> Motion {
        let frames = scene.animation.as_ref().map_or(1, |animation| animation.frames);
        let moves = |number: &usize| {
            let instance = &surfaces.instances[*number];
            instance.geometry as usize >= first_deforming
                || !scene.instances[instance.object as usize].moves.is_empty()
        };
        let moving: Vec<usize> = (1..surfaces.instances.len()).filter(moves).collect();
        if moving.is_empty() || frames < 2 {
            return Motion { instances: Vec::new(), frames: 1 };
        }
        let count = |number: &usize| {
            let geometry = surfaces.instances[*number].geometry;
            u64::from(surfaces.geometries[geometry as usize].triangle_count)
        };
        let looked_at = looked_at(frames);
        let all = moving.iter().map(count).sum::<u64>() * looked_at.len() as u64;
        let shape = Shape { scene, surfaces, first_deforming, are_boxes: all > MOST_TRIANGLES };
        let first = |&number: &usize| {
            let instance = &surfaces.instances[number];
            let triangles = shape.in_first_frame(instance.geometry as usize);
            vec![Stop { map: instance.world_from_object, triangles }]
        };
        let mut instances: Vec<Vec<Stop>> = moving.iter().map(first).collect();
        for frame in looked_at {
            let posed = shape.in_frame(frame);
            for (stops, &number) in instances.iter_mut().zip(&moving) {
                let instance = &surfaces.instances[number];
                let own = (instance.geometry as usize).checked_sub(first_deforming);
                let triangles = own.map_or(&stops[0].triangles, |n| &posed[n]);
                // Where it cannot be placed there is nothing to see; a frame that is rendered says so.
                if let Ok((map, _)) = places::maps(scene, instance.object as usize, frame) {
                    let triangles = Rc::clone(triangles);
                    stops.push(Stop { map, triangles });
                }
            }
        }
        Motion { instances, frames }
    }

    /// The corners, in other frames than the first, of all triangles that the subject has in the first.
    pub(super) fn points(&self, subject: &Subject) -> Vec<Vec3d> {
        let mut points = Vec::new();
        for stops in &self.instances {
            let Some((first, others)) = stops.split_first() else { continue };
            let counts: Vec<bool> =
                (0..first.triangles.len()).map(|n| subject.has_triangle(&first.placed(n))).collect();
            for stop in others {
                let numbers = (0..stop.triangles.len()).zip(&counts).filter(|(_, counts)| **counts);
                let all = numbers.map(|(n, _)| stop.placed(n));
                let has_area = |t: &[Vec3d; 3]| {
                    let area = length(area_vector(t));
                    area > 0.0 && area.is_finite()
                };
                points.extend(all.filter(has_area).flatten());
            }
        }
        points
    }

    /// The box around all that moves, in other frames than the first.
    pub(in crate::flatten) fn bounds(&self) -> Bounds {
        let points = self.points(&Subject::default());
        points.into_iter().fold(Bounds::EMPTY, |bounds, p| bounds.including(single(p)))
    }
}

impl Stop {
    fn placed(&self, number: usize) -> [Vec3d; 3] {
        self.triangles[number].map(|p| self.map.point64(double(p)))
    }
}

/// The frames after the first that are looked at.
fn looked_at(frames: u32) -> Vec<u32> {
    let count = frames.min(MOST_FRAMES);
    let last = u64::from(frames - 1);
    (1..count).map(|n| (u64::from(n) * last / u64::from(count - 1)) as u32).collect()
}

/// Triangles of geometries, or their boxes.
struct Shape<'a> {
    scene: &'a Scene,
    surfaces: &'a Surfaces<'a>,
    first_deforming: usize,
    are_boxes: bool,
}

impl Shape<'_> {
    fn in_first_frame(&self, geometry: usize) -> Triangles {
        let part = &self.surfaces.geometries[geometry];
        if self.are_boxes {
            return sides(&self.surfaces.bounds[geometry]);
        }
        let first = part.first_triangle as usize;
        Rc::new(self.surfaces.triangles[first..first + part.triangle_count as usize].to_vec())
    }

    /// Those of the geometries whose vertices move, in a frame.
    fn in_frame(&self, frame: u32) -> Vec<Triangles> {
        let mut poses = Poses::at(self.scene.seconds(frame));
        let numbers = geometry::deforming(self.scene);
        let all: Vec<Triangles> = numbers
            .map(|number| {
                let mesh = &self.scene.meshes[number as usize];
                self.of_mesh(mesh.posed(&mut poses).as_ref().unwrap_or(mesh))
            })
            .collect();
        debug_assert_eq!(all.len(), self.surfaces.geometries.len() - self.first_deforming, "the last ones");
        all
    }

    fn of_mesh(&self, mesh: &Mesh) -> Triangles {
        let corners = mesh.triangles.iter().map(|t| t.positions.map(|n| mesh.positions[n as usize]));
        if self.are_boxes {
            let include = |bounds: Bounds, t: [Vec3; 3]| t.iter().fold(bounds, |b, &p| b.including(p));
            return sides(&corners.fold(Bounds::EMPTY, include));
        }
        Rc::new(corners.collect())
    }
}

/// A box as triangles; none where it is empty.
fn sides(bounds: &Bounds) -> Triangles {
    let corner = |n: usize| {
        let pick = |k: usize, min: f32, max: f32| if n >> k & 1 == 1 { max } else { min };
        let Bounds { min, max } = bounds;
        Vec3 { x: pick(0, min.x, max.x), y: pick(1, min.y, max.y), z: pick(2, min.z, max.z) }
    };
    match bounds.is_empty() {
        true => Rc::default(),
        false => Rc::new(BOX_SIDES.iter().map(|side| side.map(corner)).collect()),
    }
}
