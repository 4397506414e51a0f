//! Arrays out of kernel parameters.
//!
//! Parameters are references to the first items of arrays, because for kernel parameters `&T` means read-only and
//! unaliased to the compiler, which then loads them through the read-only cache; slices and raw pointers lose that.

use core::slice::from_raw_parts;
use eosphor_core::hierarchy::{BvhNode, InstanceTreeView};

/// The array that starts with `first` and has `length` items.
///
/// # Safety
///
/// The caller of the kernel must have put that many items there.
#[inline(always)]
pub(crate) unsafe fn array<'a, T>(first: &'a T, length: u64) -> &'a [T] {
    // SAFETY: uploaded arrays: the host has put `length` items there.
    unsafe { from_raw_parts(first, length as usize) }
}

/// The array that starts with `first`, for readers that do not look at its length: they take indices from the scene.
///
/// # Safety
///
/// As for [`array`], for every index that the scene holds.
#[inline(always)]
pub(crate) unsafe fn indexed<'a, T>(first: &'a T) -> &'a [T] {
    // SAFETY: uploaded arrays: every index that is read leads into what the host has put there.
    unsafe { from_raw_parts(first, isize::MAX as usize / size_of::<T>()) }
}

/// The tree over the instances, for structures that keep it apart.
///
/// # Safety
///
/// As for [`indexed`].
#[inline(always)]
pub(crate) unsafe fn instance_tree<'a>(
    nodes: &'a BvhNode,
    order: &'a u32,
    root: u32,
) -> InstanceTreeView<'a> {
    // SAFETY: uploaded arrays: every index of the tree leads into what the host has put there.
    unsafe { InstanceTreeView { nodes: indexed(nodes), root, order: indexed(order) } }
}
