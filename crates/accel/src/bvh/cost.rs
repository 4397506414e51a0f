//! What a hierarchy is worth.

use super::Bvh;
use eosphor_core::hierarchy::BvhNode;

impl Bvh {
    /// Expected cost of a ray that passes through the box of the world (the first geometry): the surface area heuristic
    /// (Goldsmith and Salmon 1987, MacDonald and Booth 1990) with 1 for a visit to an inner node and 1 for a test of a
    /// primitive. 0 where that box has no area.
    pub fn sah_cost(&self) -> f64 {
        let Some(&root) = self.roots.first() else { return 0.0 };
        let area = |n: &BvhNode| f64::from(n.bounds().half_area());
        let root_area = area(&self.nodes[root as usize]);
        if root_area <= 0.0 {
            return 0.0;
        }
        let mut sum = 0.0;
        let mut pending = vec![root];
        while let Some(at) = pending.pop() {
            let node = &self.nodes[at as usize];
            if node.is_inner() {
                sum += area(node);
                pending.extend([node.first, node.first + 1]);
            } else {
                sum += area(node) * f64::from(node.count & !BvhNode::SPHERES);
            }
        }
        sum / root_area
    }
}
