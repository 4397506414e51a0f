//! The top level of a frame's own: the tree over instances that are elsewhere than where the scene was prepared.
//!
//! It is built on the CPU. The nodes of a bounding volume hierarchy are named by their numbers in one array, so frames
//! have rooms at its end; the trees of other structures go where the rest of the frame's own data goes.

use crate::memory::write;
use crate::parameters::Parameters;
use crate::structure::{INSTANCE_ROOT, ROOMS, Trees, add_instance_tree};
use cudarc::driver::{CudaStream, DriverError};
use eosphor_accel::{BvhPairs, BvhWide};
use eosphor_core::geometry::Instance;
use eosphor_render::{Accel, Hierarchy};
use std::sync::{Arc, Condvar, Mutex, PoisonError};

/// How the top level of a frame is made.
pub(crate) struct TopLevel {
    accel: Accel,
    /// For a bounding volume hierarchy.
    rooms: Option<Rooms>,
}

/// Room for nodes at the end of an array.
struct Rooms {
    is_wide: bool,
    /// For rays from within this the trees are made.
    reach: f32,
    /// The number of the first node.
    first: u32,
    /// Nodes of a room.
    size: u32,
    free: Mutex<Vec<u32>>,
    given_back: Condvar,
}

/// A room in use.
pub(crate) struct Taken<'a> {
    rooms: &'a Rooms,
    number: u32,
}

impl Drop for Taken<'_> {
    fn drop(&mut self) {
        self.rooms.free.lock().unwrap_or_else(PoisonError::into_inner).push(self.number);
        self.rooms.given_back.notify_one();
    }
}

impl Rooms {
    /// Waits where none is free.
    fn take(&self) -> Taken<'_> {
        let mut free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
        loop {
            if let Some(number) = free.pop() {
                return Taken { rooms: self, number };
            }
            free = self.given_back.wait(free).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

impl TopLevel {
    /// For a scene with so many instances, over which this structure was built with room for them.
    pub(crate) fn new(accel: Accel, trees: Option<&Trees>, instances: usize) -> TopLevel {
        let rooms = trees.map(|trees| {
            let (is_wide, nodes, reach) = match trees {
                Trees::Pairs(pairs, _) => (false, pairs.pairs().len(), pairs.roots()[0].reach),
                Trees::Wide(wide) => (true, wide.nodes().len(), wide.roots()[0].reach),
            };
            Rooms {
                is_wide,
                reach,
                first: (nodes - ROOMS * instances) as u32,
                size: instances as u32,
                free: Mutex::new((0..ROOMS as u32).collect()),
                given_back: Condvar::new(),
            }
        });
        TopLevel { accel, rooms }
    }

    /// Builds it.
    pub(crate) fn build(&self, instances: &[Instance]) -> Hierarchy {
        Hierarchy::build_top(self.accel, instances).expect("a frame's instances are in range")
    }

    /// Adds it to the parameters of a frame. `nodes` is the address of the array that has the rooms. What comes back must be
    /// kept until the frame is done.
    pub(crate) fn add<'a, 'r>(
        &'r self,
        own: &mut Parameters<'a>,
        top: &'a Hierarchy,
        stream: &Arc<CudaStream>,
        nodes: u64,
    ) -> Result<Option<Taken<'r>>, DriverError> {
        // Kernels that count have a bvh as CPUs read it, and its tree over the instances as other structures have theirs.
        let (Hierarchy::Bvh(bvh), Some(rooms)) = (top, self.rooms.as_ref()) else {
            if let Some(tree) = top.instance_tree() {
                add_instance_tree(own, &tree);
            }
            return Ok(None);
        };
        let room = rooms.take();
        let first = rooms.first + room.number * rooms.size;
        if rooms.is_wide {
            let (pairs, root) = BvhPairs::over_instances(bvh, rooms.reach, 0);
            let (own_nodes, root) = BvhWide::over_instances(&pairs, root, first);
            assert!(own_nodes.len() <= rooms.size as usize);
            // SAFETY: the room is this frame's alone, and there are no more nodes than instances.
            unsafe { write(stream, nodes, first, &own_nodes) }?;
            own.number(INSTANCE_ROOT, root);
        } else {
            let (pairs, root) = BvhPairs::over_instances(bvh, rooms.reach, first);
            assert!(pairs.len() <= rooms.size as usize);
            // SAFETY: the room is this frame's alone, and there are no more pairs than instances.
            unsafe { write(stream, nodes, first, &pairs) }?;
            own.number(INSTANCE_ROOT, root.bits());
        }
        Ok(Some(room))
    }
}
