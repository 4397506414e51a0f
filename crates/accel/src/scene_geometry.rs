//! What hierarchies are built over.

use eosphor_core::geometry::{Bounds, Geometry, Instance, Sphere};
use eosphor_core::intersect::LARGEST_NUMBER;
use eosphor_core::math::Vec3;
use rayon::prelude::*;
use std::fmt;

/// What hierarchies are built over: triangles and spheres of all geometries, and the instances that place them, borrowed.
///
/// What it says of itself holds together: builders rely on that, and traversals follow these numbers unchecked.
#[derive(Clone, Copy, Debug)]
pub struct SceneGeometry<'a> {
    triangles: &'a [[Vec3; 3]],
    spheres: &'a [Sphere],
    geometries: &'a [Geometry],
    instances: &'a [Instance],
    /// How many geometries instances name: one more than the largest number of one.
    named_geometries: usize,
}

/// Why arrays are no [`SceneGeometry`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum GeometryError {
    /// There is no geometry, or no instance: number 0 of both is the world.
    NoWorld,
    /// The range of a geometry's triangles or spheres does not begin where that of the one before ends, or goes beyond the array.
    Range {
        /// The geometry's number.
        geometry: usize,
    },
    /// Primitives of the array are in no geometry.
    LeftOver,
    /// There are 2^31 primitives or more.
    TooMany,
    /// An instance places a geometry that there is not, or instance 0 another than the world.
    Instance {
        /// The instance's number.
        number: usize,
    },
    /// A coordinate, radius or extent is not finite, or beyond [`LARGEST_NUMBER`]; a radius is not over 0, or an extent is
    /// below 0.
    OutOfRange {
        /// What has it: a triangle, sphere, geometry or instance.
        what: &'static str,
        /// The number of that.
        number: usize,
    },
}

impl fmt::Display for GeometryError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            GeometryError::NoWorld => {
                f.write_str("there is no geometry 0 or no instance 0: they are the world")
            }
            GeometryError::Range { geometry } => write!(
                f,
                "the primitives of geometry {geometry} do not follow those of the one before, or are not there"
            ),
            GeometryError::LeftOver => f.write_str("some primitives are in no geometry"),
            GeometryError::TooMany => f.write_str("2^31 primitives or more"),
            GeometryError::Instance { number } => {
                write!(f, "instance {number} places a geometry that is not there, or 0 is not the world")
            }
            GeometryError::OutOfRange { what, number } => write!(
                f,
                "{what} {number} has a number that is not finite or too large; numbers must be within {LARGEST_NUMBER:e}"
            ),
        }
    }
}

impl std::error::Error for GeometryError {}

/// Numbers of primitives are below this.
const PRIMITIVES_END: u64 = 1 << 31;

impl<'a> SceneGeometry<'a> {
    /// Checks arrays and borrows them: vertices of the triangles of all geometries, their spheres, the ranges of both (number 0 is
    /// the world; each begins where the one before ends), and the placed geometries (number 0 is the world itself). Everything is
    /// looked at once, on the threads of the current rayon pool.
    ///
    /// # Errors
    /// Where the numbers in the arrays do not hold together, or coordinates are out of range.
    pub fn new(
        triangles: &'a [[Vec3; 3]],
        spheres: &'a [Sphere],
        geometries: &'a [Geometry],
        instances: &'a [Instance],
    ) -> Result<SceneGeometry<'a>, GeometryError> {
        if geometries.is_empty() || instances.is_empty() {
            return Err(GeometryError::NoWorld);
        }
        if triangles.len() as u64 + spheres.len() as u64 >= PRIMITIVES_END {
            return Err(GeometryError::TooMany);
        }
        let (mut next_triangle, mut next_sphere) = (0u64, 0u64);
        for (number, g) in geometries.iter().enumerate() {
            let follows =
                (u64::from(g.first_triangle), u64::from(g.first_sphere)) == (next_triangle, next_sphere);
            next_triangle += u64::from(g.triangle_count);
            next_sphere += u64::from(g.sphere_count);
            if !follows || next_triangle > triangles.len() as u64 || next_sphere > spheres.len() as u64 {
                return Err(GeometryError::Range { geometry: number });
            }
        }
        if (next_triangle, next_sphere) != (triangles.len() as u64, spheres.len() as u64) {
            return Err(GeometryError::LeftOver);
        }
        for (number, instance) in instances.iter().enumerate() {
            if instance.geometry as usize >= geometries.len() || (number == 0 && instance.geometry != 0) {
                return Err(GeometryError::Instance { number });
            }
        }
        check_each("triangle", triangles, |corners| corners.iter().all(|&p| is_in_range(p)))?;
        check_each("sphere", spheres, |s| {
            is_in_range(s.center) && s.radius > 0.0 && s.radius <= LARGEST_NUMBER
        })?;
        check_each("geometry", geometries, |g| (0.0..=LARGEST_NUMBER).contains(&g.extent))?;
        check_each("instance", instances, is_placed_in_range)?;
        Ok(SceneGeometry::of_checked(triangles, spheres, geometries, instances))
    }

    /// [`SceneGeometry::new`] of what is known to hold together and to be in range.
    pub(crate) fn of_checked(
        triangles: &'a [[Vec3; 3]],
        spheres: &'a [Sphere],
        geometries: &'a [Geometry],
        instances: &'a [Instance],
    ) -> SceneGeometry<'a> {
        let named_geometries = instances.iter().map(|i| i.geometry as usize + 1).max().unwrap_or(0);
        SceneGeometry { triangles, spheres, geometries, instances, named_geometries }
    }

    /// Checks and borrows instances alone, of geometries that are elsewhere. What is built over them finds instances of a hierarchy
    /// that was built over everything: where nothing but instances moves, no more than this has to be built for a frame.
    ///
    /// # Errors
    /// Where coordinates of an instance are out of range.
    pub fn of_instances(instances: &'a [Instance]) -> Result<SceneGeometry<'a>, GeometryError> {
        check_each("instance", instances, is_placed_in_range)?;
        Ok(SceneGeometry::of_checked(&[], &[], &[], instances))
    }

    /// Vertices of the triangles of all geometries.
    pub fn triangles(&self) -> &'a [[Vec3; 3]] {
        self.triangles
    }

    /// Spheres of all geometries.
    pub fn spheres(&self) -> &'a [Sphere] {
        self.spheres
    }

    /// Ranges of triangles and spheres; number 0 is the world.
    pub fn geometries(&self) -> &'a [Geometry] {
        self.geometries
    }

    /// Placed geometries; number 0 is the world itself.
    pub fn instances(&self) -> &'a [Instance] {
        self.instances
    }

    pub(crate) fn named_geometries(&self) -> usize {
        self.named_geometries
    }
}

fn check_each<T: Sync>(
    what: &'static str,
    items: &[T],
    is_in_range: impl Fn(&T) -> bool + Sync,
) -> Result<(), GeometryError> {
    const PART: usize = 1 << 14;
    // Whole parts first, without looking for which: that is as fast as memory.
    let bad = items
        .par_chunks(PART)
        .position_first(|part| !part.iter().fold(true, |all, item| all & is_in_range(item)));
    let Some(part) = bad else { return Ok(()) };
    let number = (part * PART..items.len()).find(|&k| !is_in_range(&items[k])).expect("one in this part");
    Err(GeometryError::OutOfRange { what, number })
}

/// NaN is not.
fn is_in_range(p: Vec3) -> bool {
    let p = p.abs();
    (p.x <= LARGEST_NUMBER) & (p.y <= LARGEST_NUMBER) & (p.z <= LARGEST_NUMBER)
}

/// Maps are finite; the box is in range, or holds nothing.
fn is_placed_in_range(instance: &Instance) -> bool {
    let b = &instance.world_bounds;
    let is_box = (is_in_range(b.min) && is_in_range(b.max)) || *b == Bounds::EMPTY;
    is_box && instance.object_from_world.is_finite() && instance.world_from_object.is_finite()
}
