//! Which structures there are on GPUs: for each its kernel, and what that takes before the parameters of the scene.

use crate::options::Traversal;
use crate::parameters::Parameters;
use eosphor_accel::{Bvh, BvhPairs};
use eosphor_core::hierarchy::{InstanceTreeView, PrimitivesView};
use eosphor_render::{Accel, BackendError, Hierarchy};

/// The kernel that renders over a structure, `placed` with instances. (A world alone takes fewer registers, and in it the
/// threads of a warp can walk together.)
///
/// # Errors
///
/// Says which structures there are where this one is for CPUs alone.
pub(crate) fn kernel(accel: Accel, placed: bool) -> Result<&'static str, BackendError> {
    on_gpus(accel, placed).ok_or_else(|| {
        let names: Vec<&str> =
            Accel::ALL.iter().filter(|&&a| on_gpus(a, placed).is_some()).map(|a| a.name()).collect();
        BackendError::Failed(format!(
            "{accel} is made for the SIMD instructions of CPUs: on GPUs choose one of {}",
            names.join(", ")
        ))
    })
}

fn on_gpus(accel: Accel, placed: bool) -> Option<&'static str> {
    match accel {
        Accel::None => Some("render_exhaustive"),
        Accel::Bvh => Some(if placed { "render_bvh" } else { "render_bvh_world" }),
        Accel::Bvh8 => None,
        Accel::Octree => Some("render_octree"),
        Accel::OctreeParametric => Some("render_octree_parametric"),
        Accel::Grid => Some("render_grid"),
        Accel::KdTree => Some("render_kdtree"),
    }
}

/// A structure as GPUs read it.
pub(crate) struct Structure<'h> {
    hierarchy: &'h Hierarchy,
    /// What a bounding volume hierarchy becomes,
    pairs: Option<BvhPairs>,
    /// and the way through it.
    traversal: Traversal,
}

impl<'h> Structure<'h> {
    /// From the one that was built.
    ///
    /// # Errors
    ///
    /// As [`pairs`].
    pub(crate) fn new(hierarchy: &'h Hierarchy, traversal: Traversal) -> Result<Structure<'h>, BackendError> {
        let pairs = match hierarchy {
            Hierarchy::Bvh(bvh) => Some(pairs(bvh)?),
            _ => None,
        };
        Ok(Structure { hierarchy, pairs, traversal })
    }
}

/// A bounding volume hierarchy as GPUs read it.
///
/// # Errors
///
/// Says how many primitives there may be where there are more.
pub(crate) fn pairs(bvh: &Bvh) -> Result<BvhPairs, BackendError> {
    BvhPairs::new(bvh).ok_or_else(|| {
        BackendError::Failed(format!(
            "a bvh on a GPU can have {} triangles at most, and twice as many spheres and instances: this scene has \
             more (choose another structure, or --backend cpu)",
            eosphor_core::hierarchy::Link::TRIANGLES_END
        ))
    })
}

/// Adds the structure's own parameters, in the order of `gpu/src/kernels.rs`. Gives back its primitives, which come next.
///
/// # Errors
///
/// As [`kernel`].
pub(crate) fn add_structure<'a>(
    parameters: &mut Parameters<'a>,
    structure: &'a Structure,
) -> Result<PrimitivesView<'a>, BackendError> {
    match structure.hierarchy {
        Hierarchy::Exhaustive(exhaustive) => Ok(exhaustive.primitives.view()),
        Hierarchy::Bvh(bvh) => {
            let pairs = structure.pairs.as_ref().expect("a bvh has pairs");
            Ok(add_bvh(parameters, bvh, pairs, structure.traversal))
        }
        Hierarchy::Bvh8(_) => Err(kernel(Accel::Bvh8, false).expect_err("it has none")),
        Hierarchy::Octree(octree) | Hierarchy::OctreeParametric(octree) => {
            let tree = octree.view();
            parameters.array(tree.nodes);
            parameters.array(tree.roots);
            parameters.array(tree.references);
            add_instance_tree(parameters, &tree.instances);
            Ok(tree.primitives)
        }
        Hierarchy::Grid(grid) => {
            let grid = grid.view();
            parameters.array(grid.starts);
            parameters.array(grid.roots);
            parameters.array(grid.references);
            add_instance_tree(parameters, &grid.instances);
            Ok(grid.primitives)
        }
        Hierarchy::KdTree(tree) => {
            let tree = tree.view();
            parameters.array(tree.nodes);
            parameters.array(tree.roots);
            parameters.array(tree.references);
            add_instance_tree(parameters, &tree.instances);
            Ok(tree.primitives)
        }
    }
}

/// [`add_structure`] for a bounding volume hierarchy.
pub(crate) fn add_bvh<'a>(
    parameters: &mut Parameters<'a>,
    bvh: &'a Bvh,
    pairs: &'a BvhPairs,
    traversal: Traversal,
) -> PrimitivesView<'a> {
    let view = pairs.view(bvh);
    parameters.array(view.pairs);
    parameters.array(view.roots);
    parameters.number(view.instance_root.bits());
    parameters.float(view.world_extent);
    parameters.number(traversal.company().bits());
    view.primitives
}

fn add_instance_tree<'a>(parameters: &mut Parameters<'a>, tree: &InstanceTreeView<'a>) {
    parameters.array(tree.nodes);
    parameters.array(tree.order);
    parameters.number(tree.root);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn structures_for_cpus_alone_are_refused_with_the_others_names() {
        let message = kernel(Accel::Bvh8, false).unwrap_err().to_string();
        assert!(
            message.starts_with("bvh8 is made for") && message.contains("none, bvh, octree,"),
            "{message}"
        );
        assert_eq!(Accel::ALL.iter().filter(|&&accel| kernel(accel, true).is_err()).count(), 1);
    }
}
