//! New shapes for the same primitives.

use super::{Bvh, pack};
use crate::SceneGeometry;
use eosphor_core::geometry::{Bounds, Geometry};
use eosphor_core::hierarchy::BvhNode;
use eosphor_core::intersect::sphere_bounds;
use std::fmt;

/// Why a hierarchy does not fit a scene: it was built over another number of things.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RefitError {
    /// The number of geometries, or of instances.
    Counts {
        /// What is counted.
        what: &'static str,
        /// How many the hierarchy was built over.
        built: usize,
        /// How many the scene has.
        scene: usize,
    },
    /// A geometry's numbers of triangles or spheres, or an array that is too short for its ranges.
    Geometry {
        /// Its number.
        number: usize,
    },
    /// An instance places another geometry than before.
    Instance {
        /// Its number.
        number: usize,
    },
}

impl fmt::Display for RefitError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            RefitError::Counts { what, built, scene } => {
                write!(
                    f,
                    "the hierarchy was built over {built} {what}, the scene has {scene}: build it again"
                )
            }
            RefitError::Geometry { number } => {
                write!(
                    f,
                    "geometry {number} has other numbers of primitives than the hierarchy: build it again"
                )
            }
            RefitError::Instance { number } => {
                write!(f, "instance {number} places another geometry than in the hierarchy: build it again")
            }
        }
    }
}

impl std::error::Error for RefitError {}

/// Whether a scene has what a hierarchy was built over, apart from shapes and places.
pub(crate) fn check(
    geometries: &[Geometry],
    instances: &[eosphor_core::geometry::Instance],
    scene: &SceneGeometry,
) -> Result<(), RefitError> {
    let counts = |what, built, scene| {
        if built == scene { Ok(()) } else { Err(RefitError::Counts { what, built, scene }) }
    };
    counts("geometries", geometries.len(), scene.geometries().len())?;
    counts("instances", instances.len(), scene.instances().len())?;
    for (number, (built, new)) in geometries.iter().zip(scene.geometries()).enumerate() {
        let end = |first: u32, count: u32| first as usize + count as usize;
        let same = built.triangle_count == new.triangle_count
            && built.sphere_count == new.sphere_count
            && end(new.first_triangle, new.triangle_count) <= scene.triangles().len()
            && end(new.first_sphere, new.sphere_count) <= scene.spheres().len();
        if !same {
            return Err(RefitError::Geometry { number });
        }
    }
    for (number, (built, new)) in instances.iter().zip(scene.instances()).enumerate() {
        if built.geometry != new.geometry {
            return Err(RefitError::Instance { number });
        }
    }
    Ok(())
}

/// Whether the geometries before number `first` are those that a hierarchy was built over, but for their vertices.
pub(crate) fn check_before(
    geometries: &[Geometry],
    first: usize,
    scene: &SceneGeometry,
) -> Result<(), RefitError> {
    let new = scene.geometries();
    if first > geometries.len() || first > new.len() {
        let (built, scene) = (geometries.len(), new.len());
        return Err(RefitError::Counts { what: "geometries", built, scene });
    }
    let ranges = |g: &Geometry| (g.first_triangle, g.triangle_count, g.first_sphere, g.sphere_count);
    match (0..first).find(|&k| ranges(&geometries[k]) != ranges(&new[k])) {
        Some(number) => Err(RefitError::Geometry { number }),
        None => Ok(()),
    }
}

impl Bvh {
    /// Takes new vertices, spheres and transforms for the primitives and instances it was built over: boxes are made
    /// anew from the leaves up, so hits are those of a hierarchy that was built over the new scene. The farther things
    /// have moved apart, the slower it gets. Triangles that were cut (by spatial splits, or in
    /// the 8-wide hierarchy because they are large) get whole boxes everywhere.
    ///
    /// # Errors
    /// Where the scene has other numbers of primitives or instances than the one that was built over; nothing is
    /// changed then.
    pub fn refit(&mut self, scene: &SceneGeometry) -> Result<(), RefitError> {
        check(&self.primitives.geometries, &self.primitives.instances, scene)?;
        self.primitives.geometries.copy_from_slice(scene.geometries());
        self.primitives.instances.copy_from_slice(scene.instances());
        for (number, geometry) in scene.geometries().iter().enumerate() {
            self.refit_geometry(self.roots[number], geometry, scene);
        }
        if !self.instance_order.is_empty() {
            for at in self.depth_first(self.instance_root).into_iter().rev() {
                let node = self.nodes[at as usize];
                let bounds = if node.is_inner() {
                    self.union_of_children(&node)
                } else {
                    let numbers = &self.instance_order[node.first as usize..][..node.count as usize];
                    union(numbers.iter().map(|&i| scene.instances()[i as usize].world_bounds))
                };
                self.set_bounds(at, bounds);
            }
        }
        Ok(())
    }

    fn refit_geometry(&mut self, root: u32, geometry: &Geometry, scene: &SceneGeometry) {
        let vertices = &scene.triangles()[geometry.first_triangle as usize..];
        let spheres = &scene.spheres()[geometry.first_sphere as usize..];
        let mut packed = Vec::new();
        for at in self.depth_first(root).into_iter().rev() {
            let node = self.nodes[at as usize];
            let range = node.first as usize..node.first as usize + (node.count & !BvhNode::SPHERES) as usize;
            let bounds = if node.is_inner() {
                self.union_of_children(&node)
            } else if node.count & BvhNode::SPHERES == 0 {
                let triangles = &mut self.primitives.triangles[range];
                let order: Vec<u32> = triangles.iter().map(|t| t.primitive).collect();
                packed.clear();
                pack(&mut packed, vertices, &order);
                triangles.copy_from_slice(&packed);
                union(triangles.iter().map(|t| t.bounds()))
            } else if range.is_empty() {
                continue;
            } else {
                for k in range.clone() {
                    let number = self.primitives.sphere_primitives[k] - geometry.triangle_count;
                    self.primitives.spheres[k] = spheres[number as usize];
                }
                union(self.primitives.spheres[range].iter().map(sphere_bounds))
            };
            self.set_bounds(at, bounds);
        }
    }

    /// The nodes below and with one, parents first.
    fn depth_first(&self, root: u32) -> Vec<u32> {
        let (mut order, mut pending) = (Vec::new(), vec![root]);
        while let Some(at) = pending.pop() {
            order.push(at);
            let node = &self.nodes[at as usize];
            if node.is_inner() {
                pending.extend([node.first + 1, node.first]);
            }
        }
        order
    }

    fn union_of_children(&self, node: &BvhNode) -> Bounds {
        let [a, b] = [0, 1].map(|k| self.nodes[node.first as usize + k].bounds());
        a.union(&b)
    }

    fn set_bounds(&mut self, at: u32, bounds: Bounds) {
        let node = &mut self.nodes[at as usize];
        (node.min, node.max) = (bounds.min, bounds.max);
    }
}

/// The box around boxes.
pub(crate) fn union(all: impl Iterator<Item = Bounds>) -> Bounds {
    all.fold(Bounds::EMPTY, |a, b| a.union(&b))
}
