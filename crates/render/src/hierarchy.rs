//! The hierarchy that a backend traces rays through.

use eosphor_accel::{BuildOptions, Bvh, Exhaustive, HierarchyStatistics, PackedPrimitives, SceneGeometry};
use eosphor_scene::SceneData;
use serde::Serialize;
use std::fmt;
use std::str::FromStr;

/// Acceleration structures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Accel {
    /// Every ray tests every primitive.
    None,
    /// Bounding volume hierarchy, binned SAH.
    Bvh,
}

impl Accel {
    /// All, for help texts.
    pub const ALL: [Accel; 2] = [Accel::None, Accel::Bvh];
}

impl fmt::Display for Accel {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Accel::None => "none",
            Accel::Bvh => "bvh",
        })
    }
}

impl FromStr for Accel {
    type Err = String;
    fn from_str(s: &str) -> Result<Accel, String> {
        Accel::ALL.into_iter().find(|a| a.to_string() == s).ok_or_else(|| {
            let names: Vec<String> = Accel::ALL.iter().map(Accel::to_string).collect();
            format!("unknown acceleration structure '{s}': choose one of {}", names.join(", "))
        })
    }
}

/// A structure, built.
#[derive(Clone, Debug)]
pub enum Hierarchy {
    /// For [`Accel::None`].
    Exhaustive(Exhaustive),
    /// For [`Accel::Bvh`].
    Bvh(Bvh),
}

impl Hierarchy {
    /// Builds over a scene, on the threads of the current rayon pool. The result does not depend on their number.
    pub fn build(accel: Accel, scene: &SceneData) -> Hierarchy {
        let geometry = SceneGeometry {
            triangles: &scene.triangles,
            spheres: &scene.spheres,
            geometries: &scene.geometries,
            instances: &scene.instances,
        };
        match accel {
            Accel::None => Hierarchy::Exhaustive(Exhaustive::new(&geometry)),
            Accel::Bvh => Hierarchy::Bvh(Bvh::build(&geometry, &BuildOptions::default())),
        }
    }

    /// It in numbers.
    pub fn statistics(&self) -> HierarchyStatistics {
        match self {
            Hierarchy::Exhaustive(exhaustive) => exhaustive.statistics(),
            Hierarchy::Bvh(bvh) => bvh.statistics(),
        }
    }

    /// Its primitives, in its order.
    pub fn primitives(&self) -> &PackedPrimitives {
        match self {
            Hierarchy::Exhaustive(exhaustive) => &exhaustive.primitives,
            Hierarchy::Bvh(bvh) => &bvh.primitives,
        }
    }
}

/// Runs code with the scalar tracer of whatever structure a hierarchy is; the tracer has the `work` as its public field.
/// This is a macro, since the tracers are types of their own and the code is compiled for each.
macro_rules! with_tracer {
    ($hierarchy:expr, $work:expr, |$tracer:ident| $body:expr) => {
        match $hierarchy {
            $crate::Hierarchy::Exhaustive(structure) => {
                let $tracer = structure.tracer($work);
                $body
            }
            $crate::Hierarchy::Bvh(structure) => {
                let $tracer = structure.tracer($work);
                $body
            }
        }
    };
}
pub(crate) use with_tracer;
