//! Building hierarchies.

use crate::{Case, ball};
use eosphor_accel::{BuildOptions, Builder, Bvh, Bvh8, Scene};

/// The hierarchy of two children, by bins.
pub struct BuildBinned(Scene);

impl Case for BuildBinned {
    const AT_LEAST: usize = 3000;

    fn new() -> BuildBinned {
        BuildBinned(ball::scene())
    }

    fn run(&self) -> usize {
        Bvh::build(&self.0.geometry(), &BuildOptions::of(Builder::Binned)).nodes().len()
    }
}

/// The hierarchy of two children, along a Morton curve.
pub struct BuildMorton(Scene);

impl Case for BuildMorton {
    const AT_LEAST: usize = 3000;

    fn new() -> BuildMorton {
        BuildMorton(ball::scene())
    }

    fn run(&self) -> usize {
        Bvh::build(&self.0.geometry(), &BuildOptions::of(Builder::Morton)).nodes().len()
    }
}

/// The hierarchy of eight children, as it is built by default.
pub struct BuildEight(Scene);

impl Case for BuildEight {
    const AT_LEAST: usize = 300;

    fn new() -> BuildEight {
        BuildEight(ball::scene())
    }

    fn run(&self) -> usize {
        Bvh8::build(&self.0.geometry(), &BuildOptions::default()).nodes().len()
    }
}
