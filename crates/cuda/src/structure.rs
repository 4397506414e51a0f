//! Which structures there are on GPUs: for each its kernel, and what that takes before the parameters of the scene.

use crate::parameters::Parameters;
use crate::scheduler::GpuScheduler;
use crate::traversal::Traversal;
use eosphor_accel::{Bvh, BvhPairs, BvhWide};
use eosphor_core::device::{Link, WideNode};
use eosphor_core::hierarchy::{InstanceTreeView, PrimitivesView};
use eosphor_core::settings::Integrator;
use eosphor_render::{Accel, BackendError, Hierarchy};

/// The names of kernels that render over a structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum KernelNames {
    /// One, whose threads follow samples from the camera to the end.
    Whole(&'static str),
    /// Those that work on queues and trace rays.
    Queues(WalkNames),
}

/// Those of queues that trace rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct WalkNames {
    /// Finds what rays hit.
    pub(crate) hits: &'static str,
    /// Finds which lights are seen.
    pub(crate) seen: &'static str,
    /// Finds what comes through surfaces that are in the way.
    pub(crate) crossed: &'static str,
}

/// The kernels that render over a structure, `placed` with instances. (A world alone takes fewer registers, and in it the
/// threads of a warp can walk together.) Or those that count.
///
/// # Errors
///
/// Says which structures there are where this one is for CPUs alone.
pub(crate) fn kernels(
    accel: Accel,
    traversal: Traversal,
    placed: bool,
    counts: bool,
    integrator: Integrator,
    scheduler: GpuScheduler,
) -> Result<KernelNames, BackendError> {
    if scheduler == GpuScheduler::Megakernel {
        return match megakernel(accel, traversal, placed) {
            Some(name) if integrator == Integrator::Whitted && !counts => Ok(KernelNames::Whole(name)),
            _ => Err(BackendError::Failed(
                "megakernel: that is for Whitted's integrator and a bvh, where threads go by themselves or by vote, and for kernels \
                 that do not count: leave that out, or choose queues"
                    .into(),
            )),
        };
    }
    let find = |accel| {
        if counts { counting(accel) } else { walks(accel, traversal, placed) }
    };
    find(accel).map(KernelNames::Queues).ok_or_else(|| {
        let is_there = |accel: &&Accel| find(**accel).is_some();
        let names: Vec<&str> = Accel::ALL.iter().filter(is_there).map(|a| a.name()).collect();
        BackendError::Failed(format!(
            "{accel} is made for the SIMD instructions of CPUs: on GPUs choose one of {}",
            names.join(", ")
        ))
    })
}

/// The one kernel that renders by Whitted's integrator, where there is one.
fn megakernel(accel: Accel, traversal: Traversal, placed: bool) -> Option<&'static str> {
    match (accel, traversal) {
        (Accel::Bvh, Traversal::Auto | Traversal::Single | Traversal::Vote) => {
            Some(if placed { "render_bvh" } else { "render_bvh_world" })
        }
        _ => None,
    }
}

/// The names of the kernels of a structure that begin with this.
macro_rules! walk_names {
    ($start:literal, $structure:literal) => {
        WalkNames {
            hits: concat!($start, "hits_", $structure),
            seen: concat!($start, "seen_", $structure),
            crossed: concat!($start, "crossed_", $structure),
        }
    };
}

/// Those of queues that trace rays.
fn walks(accel: Accel, traversal: Traversal, placed: bool) -> Option<WalkNames> {
    Some(match accel {
        Accel::None => walk_names!("", "exhaustive"),
        Accel::Bvh => match traversal {
            Traversal::Reconverge => walk_names!("", "bvh_in_step"),
            Traversal::Wide => walk_names!("", "bvh_wide"),
            _ if placed => walk_names!("", "bvh"),
            _ => walk_names!("", "bvh_world"),
        },
        Accel::Bvh8 => return None,
        Accel::Octree => walk_names!("", "octree"),
        Accel::OctreeParametric => walk_names!("", "octree_parametric"),
        Accel::Grid => walk_names!("", "grid"),
        Accel::KdTree => walk_names!("", "kdtree"),
    })
}

/// Those that count.
fn counting(accel: Accel) -> Option<WalkNames> {
    Some(match accel {
        Accel::None => walk_names!("count_", "exhaustive"),
        Accel::Bvh => walk_names!("count_", "bvh"),
        Accel::Bvh8 => return None,
        Accel::Octree => walk_names!("count_", "octree"),
        Accel::OctreeParametric => walk_names!("count_", "octree_parametric"),
        Accel::Grid => walk_names!("count_", "grid"),
        Accel::KdTree => walk_names!("count_", "kdtree"),
    })
}

/// The parameter that says where the tree over the instances begins.
pub(crate) const INSTANCE_ROOT: &str = "instance_root";

/// Frames that can be on a device at a time, each with room for the tree over its instances.
pub(crate) const ROOMS: usize = 4;

/// A structure as GPUs read it.
pub(crate) struct Structure<'h> {
    hierarchy: &'h Hierarchy,
    /// What a bounding volume hierarchy becomes, but for kernels that count.
    pub(crate) trees: Option<Trees>,
}

impl<'h> Structure<'h> {
    /// As it was built, for a kernel that counts.
    pub(crate) fn for_counting(hierarchy: &Hierarchy) -> Structure<'_> {
        Structure { hierarchy, trees: None }
    }

    /// From the one that was built. With room for the instances of frames, where these move.
    ///
    /// # Errors
    ///
    /// As [`Trees::new`].
    pub(crate) fn new(
        hierarchy: &'h Hierarchy,
        traversal: Traversal,
        moving: usize,
    ) -> Result<Structure<'h>, BackendError> {
        let trees = match hierarchy {
            Hierarchy::Bvh(bvh) => Some(Trees::new(bvh, traversal, moving * ROOMS)?),
            _ => None,
        };
        Ok(Structure { hierarchy, trees })
    }
}

impl Structure<'_> {
    pub(crate) fn accel(&self) -> Accel {
        self.hierarchy.accel()
    }
}

/// A bounding volume hierarchy as GPUs read it.
pub(crate) enum Trees {
    /// Two children a node, and the way through them.
    Pairs(BvhPairs, Traversal),
    /// Eight children a node.
    Wide(BvhWide),
}

impl Trees {
    /// For a way through it, with room for so many nodes more.
    ///
    /// # Errors
    ///
    /// Says how much there may be where there is more.
    pub(crate) fn new(bvh: &Bvh, traversal: Traversal, room: usize) -> Result<Trees, BackendError> {
        let mut pairs = BvhPairs::new(bvh).ok_or_else(|| {
            BackendError::Failed(format!(
                "a bvh on a GPU can have {} triangles at most, and twice as many spheres and instances: this scene has \
                 more (choose another structure, or --backend cpu)",
                Link::TRIANGLES_END
            ))
        })?;
        if traversal != Traversal::Wide {
            pairs.make_room(room);
            return Ok(Trees::Pairs(pairs, traversal));
        }
        let wide = BvhWide::new(&pairs).and_then(|wide| wide.with_room(room)).ok_or_else(|| {
            BackendError::Failed(format!(
                "a wide bvh on a GPU can have {} nodes at most: this scene has more (choose another traversal)",
                WideNode::MOST
            ))
        })?;
        Ok(Trees::Wide(wide))
    }

    /// Rays that start within this of 0 along each axis are not far away from the world.
    pub(crate) fn reach(&self) -> f32 {
        match self {
            Trees::Pairs(pairs, _) => pairs.roots().first().map_or(0.0, |root| root.reach),
            Trees::Wide(wide) => wide.roots().first().map_or(0.0, |root| root.reach),
        }
    }
}

/// Adds the structure's own parameters, in the order of `gpu/src/kernels.rs`. Gives back its primitives, which come next.
///
/// # Errors
///
/// As [`kernels`].
pub(crate) fn add_structure<'a>(
    parameters: &mut Parameters<'a>,
    structure: &'a Structure,
) -> Result<PrimitivesView<'a>, BackendError> {
    match structure.hierarchy {
        Hierarchy::Exhaustive(exhaustive) => Ok(exhaustive.primitives().view()),
        Hierarchy::Bvh(bvh) => match &structure.trees {
            Some(trees) => Ok(add_trees(parameters, bvh, trees)),
            None => {
                let bvh = bvh.view();
                parameters.array("nodes", bvh.nodes);
                parameters.array("roots", bvh.roots);
                add_instance_tree(parameters, &bvh.instances);
                Ok(bvh.primitives)
            }
        },
        Hierarchy::Bvh8(_) => {
            Err(kernels(Accel::Bvh8, Traversal::Auto, false, false, Integrator::Whitted, GpuScheduler::Auto)
                .expect_err("it has none"))
        }
        Hierarchy::Octree(octree) | Hierarchy::OctreeParametric(octree) => {
            let tree = octree.view();
            parameters.array("nodes", tree.nodes);
            parameters.array("roots", tree.roots);
            parameters.array("references", tree.references);
            add_instance_tree(parameters, &tree.instances);
            Ok(tree.primitives)
        }
        Hierarchy::Grid(grid) => {
            let grid = grid.view();
            parameters.array("starts", grid.starts);
            parameters.array("roots", grid.roots);
            parameters.array("references", grid.references);
            add_instance_tree(parameters, &grid.instances);
            Ok(grid.primitives)
        }
        Hierarchy::KdTree(tree) => {
            let tree = tree.view();
            parameters.array("nodes", tree.nodes);
            parameters.array("roots", tree.roots);
            parameters.array("references", tree.references);
            add_instance_tree(parameters, &tree.instances);
            Ok(tree.primitives)
        }
    }
}

/// [`add_structure`] for a bounding volume hierarchy.
pub(crate) fn add_trees<'a>(
    parameters: &mut Parameters<'a>,
    bvh: &'a Bvh,
    trees: &'a Trees,
) -> PrimitivesView<'a> {
    match trees {
        Trees::Pairs(pairs, traversal) => {
            let view = pairs.view(bvh);
            parameters.array("pairs", view.pairs);
            parameters.array("roots", view.roots);
            parameters.number(INSTANCE_ROOT, view.instance_root.bits());
            parameters.number("warp_mode", traversal.warp_mode().bits());
        }
        Trees::Wide(wide) => {
            parameters.array("nodes", wide.nodes());
            parameters.array("roots", wide.roots());
            parameters.number(INSTANCE_ROOT, wide.view(bvh).instance_root);
        }
    }
    bvh.primitives().view()
}

pub(crate) fn add_instance_tree<'a>(parameters: &mut Parameters<'a>, tree: &InstanceTreeView<'a>) {
    parameters.array("instance_nodes", tree.nodes);
    parameters.array("instance_order", tree.order);
    parameters.number(INSTANCE_ROOT, tree.root);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn structures_for_cpus_alone_are_refused_with_the_others_names() {
        let message =
            kernels(Accel::Bvh8, Traversal::Auto, false, false, Integrator::Whitted, GpuScheduler::Auto)
                .unwrap_err()
                .to_string();
        assert!(
            message.starts_with("bvh8 is made for") && message.contains("none, bvh, octree,"),
            "{message}"
        );
        for counts in [false, true] {
            let refused = |accel: &&Accel| {
                kernels(**accel, Traversal::Auto, true, counts, Integrator::Path, GpuScheduler::Auto).is_err()
            };
            assert_eq!(Accel::ALL.iter().filter(refused).count(), 1);
        }
    }
}
