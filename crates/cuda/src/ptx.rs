//! The kernels, as a text that the driver compiles for its device. `cargo xtask ptx` makes it from `gpu/`.

/// PTX for compute capability 7.5, which loads on everything since Turing.
pub(crate) const PTX: &str = include_str!("../ptx/eosphor.ptx");

/// The oldest devices that [`PTX`] loads on.
pub(crate) const OLDEST_CAPABILITY: (i32, i32) = (7, 5);

/// Threads of a block; the kernels are compiled for at most this many.
pub(crate) const BLOCK: u32 = 128;

/// Renders a band of rows over a BVH.
pub(crate) const RENDER_BVH: &str = "render_bvh";

/// The same without any hierarchy.
pub(crate) const RENDER_EXHAUSTIVE: &str = "render_exhaustive";

/// Closest hits of rays in a BVH.
pub(crate) const CLOSEST_HITS_BVH: &str = "closest_hits_bvh";

/// Whether anything is in the way of rays in a BVH.
pub(crate) const OCCLUDED_BVH: &str = "occluded_bvh";

#[cfg(test)]
mod tests {
    use super::*;

    /// The parameters of a kernel, one a line in the PTX.
    fn parameters(kernel: &str) -> usize {
        let start = PTX.find(&format!(".entry {kernel}(")).expect("the kernel is there");
        PTX[start..].lines().skip(1).take_while(|line| !line.starts_with(')')).count()
    }

    #[test]
    fn kernels_take_what_the_launch_passes() {
        use crate::scene::{BVH_ARGUMENTS, COMMON_ARGUMENTS};
        assert_eq!(parameters(RENDER_BVH), BVH_ARGUMENTS + COMMON_ARGUMENTS);
        assert_eq!(parameters(RENDER_EXHAUSTIVE), COMMON_ARGUMENTS);
    }

    #[test]
    fn target_and_block_are_those_of_the_text() {
        let (major, minor) = OLDEST_CAPABILITY;
        assert!(PTX.contains(&format!("\n.target sm_{major}{minor}\n")));
        assert!(PTX.contains(&format!("\n.maxntid {BLOCK}\n")));
    }
}
