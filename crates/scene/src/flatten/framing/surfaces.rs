//! Everything that is placed, as framing looks at it: in double precision, one triangle after the other.

use crate::double::{Vec3d, cross, double, sub};
use eosphor_core::geometry::{Bounds, Geometry, Instance, Sphere};
use eosphor_core::math::{Affine, Vec3};

/// Instances of a scene with more placed triangles than this count as their boxes.
const MAX_FRAMED_TRIANGLES: u64 = 1 << 22;

/// The sides of a box by its corners' numbers (bit k says whether coordinate k is the upper one), seen from outside.
pub(super) const BOX_SIDES: [[usize; 3]; 12] = [
    [0, 4, 6],
    [0, 6, 2],
    [1, 3, 7],
    [1, 7, 5],
    [0, 1, 5],
    [0, 5, 4],
    [2, 6, 7],
    [2, 7, 3],
    [0, 2, 3],
    [0, 3, 1],
    [4, 5, 7],
    [4, 7, 6],
];

/// What the geometry of a scene is made of, while it is flattened.
pub(in crate::flatten) struct Surfaces<'a> {
    pub(in crate::flatten) triangles: &'a [[Vec3; 3]],
    pub(in crate::flatten) spheres: &'a [Sphere],
    pub(in crate::flatten) geometries: &'a [Geometry],
    pub(in crate::flatten) instances: &'a [Instance],
    /// Of each geometry, in its own space.
    pub(in crate::flatten) bounds: &'a [Bounds],
}

/// A box in double precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Box3 {
    pub(super) min: Vec3d,
    pub(super) max: Vec3d,
}

impl Box3 {
    pub(super) const EMPTY: Box3 = Box3 { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] };

    pub(super) fn include(&mut self, p: Vec3d) {
        for k in 0..3 {
            self.min[k] = self.min[k].min(p[k]);
            self.max[k] = self.max[k].max(p[k]);
        }
    }

    pub(super) fn union(mut self, other: Box3) -> Box3 {
        self.include(other.min);
        self.include(other.max);
        self
    }

    pub(super) fn is_empty(&self) -> bool {
        self.min[0] > self.max[0]
    }

    pub(super) fn size(&self) -> Vec3d {
        if self.is_empty() { [0.0; 3] } else { sub(self.max, self.min) }
    }

    pub(super) fn center(&self) -> Vec3d {
        [0, 1, 2].map(|k| 0.5 * (self.min[k] + self.max[k]))
    }
}

impl Surfaces<'_> {
    /// Takes every triangle that is placed, in the world; of scenes with very many, the boxes of instances instead.
    pub(super) fn each_triangle(&self, mut take: impl FnMut(&[Vec3d; 3])) {
        let count = |i: &Instance| u64::from(self.geometries[i.geometry as usize].triangle_count);
        let are_many = self.instances.iter().map(count).sum::<u64>() > MAX_FRAMED_TRIANGLES;
        for instance in self.instances {
            let map = &instance.world_from_object;
            let geometry = &self.geometries[instance.geometry as usize];
            let first = geometry.first_triangle as usize;
            let triangles = &self.triangles[first..first + geometry.triangle_count as usize];
            if *map == Affine::IDENTITY {
                triangles.iter().for_each(|t| take(&t.map(double)));
            } else if are_many && !triangles.is_empty() {
                let Bounds { min, max } = self.bounds[instance.geometry as usize];
                let (min, max) = (double(min), double(max));
                let pick = |n: usize| [0, 1, 2].map(|k| if n >> k & 1 == 1 { max[k] } else { min[k] });
                BOX_SIDES.iter().for_each(|side| take(&side.map(|n| map.point64(pick(n)))));
            } else {
                triangles.iter().for_each(|t| take(&t.map(|p| map.point64(double(p)))));
            }
        }
    }

    /// Takes every sphere that is placed: number, centre and a radius that is large enough.
    pub(super) fn each_sphere(&self, mut take: impl FnMut(usize, Vec3d, f64)) {
        let mut number = 0;
        for instance in self.instances {
            let map = &instance.world_from_object;
            let geometry = &self.geometries[instance.geometry as usize];
            let first = geometry.first_sphere as usize;
            for s in &self.spheres[first..first + geometry.sphere_count as usize] {
                let growth = if *map == Affine::IDENTITY { 1.0 } else { f64::from(map.growth()) };
                take(number, map.point64(double(s.center)), f64::from(s.radius) * growth);
                number += 1;
            }
        }
    }
}

/// Twice the area of a triangle along its normal.
pub(super) fn area_vector(t: &[Vec3d; 3]) -> Vec3d {
    cross(sub(t[1], t[0]), sub(t[2], t[0]))
}
