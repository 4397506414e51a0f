//! Which structures there are on GPUs: for each its kernel, and what that takes before the parameters of the scene.

use crate::parameters::Parameters;
use eosphor_accel::Bvh;
use eosphor_core::hierarchy::{InstanceTreeView, PrimitivesView};
use eosphor_render::{Accel, BackendError, Hierarchy};

/// The kernel that renders over a structure.
///
/// # Errors
///
/// Says which structures there are where this one is for CPUs alone.
pub(crate) fn kernel(accel: Accel) -> Result<&'static str, BackendError> {
    on_gpus(accel).ok_or_else(|| {
        let names: Vec<&str> =
            Accel::ALL.iter().filter(|&&a| on_gpus(a).is_some()).map(|a| a.name()).collect();
        BackendError::Failed(format!(
            "{accel} is made for the SIMD instructions of CPUs: on GPUs choose one of {}",
            names.join(", ")
        ))
    })
}

fn on_gpus(accel: Accel) -> Option<&'static str> {
    match accel {
        Accel::None => Some("render_exhaustive"),
        Accel::Bvh => Some("render_bvh"),
        Accel::Bvh8 => None,
        Accel::Octree => Some("render_octree"),
        Accel::OctreeParametric => Some("render_octree_parametric"),
        Accel::Grid => Some("render_grid"),
        Accel::KdTree => Some("render_kdtree"),
    }
}

/// Adds the structure's own parameters, in the order of `gpu/src/kernels.rs`. Gives back its primitives, which come next.
///
/// # Errors
///
/// As [`kernel`].
pub(crate) fn add_structure<'a>(
    parameters: &mut Parameters<'a>,
    hierarchy: &'a Hierarchy,
) -> Result<PrimitivesView<'a>, BackendError> {
    match hierarchy {
        Hierarchy::Exhaustive(exhaustive) => Ok(exhaustive.primitives.view()),
        Hierarchy::Bvh(bvh) => Ok(add_bvh(parameters, bvh)),
        Hierarchy::Bvh8(_) => Err(kernel(Accel::Bvh8).expect_err("it has none")),
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
pub(crate) fn add_bvh<'a>(parameters: &mut Parameters<'a>, bvh: &'a Bvh) -> PrimitivesView<'a> {
    parameters.array(&bvh.nodes);
    parameters.array(&bvh.roots);
    parameters.array(&bvh.instance_order);
    parameters.number(bvh.instance_root);
    bvh.primitives.view()
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
        let message = kernel(Accel::Bvh8).unwrap_err().to_string();
        assert!(
            message.starts_with("bvh8 is made for") && message.contains("none, bvh, octree,"),
            "{message}"
        );
        assert_eq!(Accel::ALL.iter().filter(|&&accel| kernel(accel).is_err()).count(), 1);
    }
}
