//! How a hierarchy is built.

use std::fmt;
use std::str::FromStr;

/// What chooses the splits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "kebab-case"))]
pub enum Builder {
    /// Sorted along a Morton curve, split where the code's bits change (Lauterbach et al. 2009, "Fast BVH construction
    /// on GPUs"). The fastest to build.
    Morton,
    /// At the middle of the longest side ("spatial median").
    Median,
    /// The surface area heuristic at every place between two primitives, on every axis (MacDonald and Booth 1990).
    Sweep,
    /// The surface area heuristic between bins (Wald 2007, "On fast construction of SAH-based bounding volume
    /// hierarchies").
    #[default]
    Binned,
    /// The surface area heuristic between bins, and primitives may be split where boxes overlap (Stich et al. 2009, "Spatial splits
    /// in bounding volume hierarchies").
    Spatial,
    /// The preset of the EOS ray tracer: spatial median above 3000 primitives, sweep below, no deeper than 20 levels.
    Hybrid,
}

impl Builder {
    /// All builders, in the order of the names in help texts.
    pub const ALL: [Builder; 6] = [
        Builder::Morton,
        Builder::Median,
        Builder::Sweep,
        Builder::Binned,
        Builder::Spatial,
        Builder::Hybrid,
    ];
}

impl Builder {
    /// Its name on command lines.
    pub fn name(self) -> &'static str {
        match self {
            Builder::Morton => "morton",
            Builder::Median => "median",
            Builder::Sweep => "sweep",
            Builder::Binned => "binned",
            Builder::Spatial => "spatial",
            Builder::Hybrid => "hybrid",
        }
    }
}

impl fmt::Display for Builder {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Builder {
    type Err = String;
    fn from_str(s: &str) -> Result<Builder, String> {
        parse("builder", s, &Builder::ALL)
    }
}

/// How much time building may take for how much less time of tracing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "kebab-case"))]
pub enum Quality {
    /// [`Builder::Morton`]: for a picture of few rays, or geometry that changes every frame.
    Low,
    /// [`Builder::Binned`].
    #[default]
    Medium,
    /// [`Builder::Spatial`]: worth its time for large triangles of many sizes, as buildings have.
    High,
}

impl Quality {
    /// All qualities, lowest first.
    pub const ALL: [Quality; 3] = [Quality::Low, Quality::Medium, Quality::High];

    /// The settings of the builder that it stands for.
    pub fn options(self) -> BuildOptions {
        let builder = match self {
            Quality::Low => Builder::Morton,
            Quality::Medium => Builder::Binned,
            Quality::High => Builder::Spatial,
        };
        BuildOptions::of(builder)
    }
}

impl Quality {
    /// Its name on command lines.
    pub fn name(self) -> &'static str {
        match self {
            Quality::Low => "low",
            Quality::Medium => "medium",
            Quality::High => "high",
        }
    }
}

impl fmt::Display for Quality {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Quality {
    type Err = String;
    fn from_str(s: &str) -> Result<Quality, String> {
        parse("quality", s, &Quality::ALL)
    }
}

/// How a hierarchy is built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BuildOptions {
    /// What chooses the splits.
    pub builder: Builder,
    /// Primitives a leaf may hold, 1 to 255. The 8-wide hierarchy has leaves of up to 4 triangles whatever this says.
    pub max_leaf_primitives: u32,
    /// Cost of visiting a node, in primitive tests. A smaller one makes smaller leaves, but not in the 8-wide hierarchy, which has
    /// rules of its own.
    pub traversal_cost: f32,
    /// Leaves may lie this deep, at most `MAX_BVH_DEPTH` (what is deeper is split in halves there). Below that bound
    /// leaves at this depth hold whatever is left.
    pub max_depth: u32,
    /// Whether [`Builder::Morton`] and [`Builder::Binned`] cut the few triangles that are large beside the whole geometry, and lie
    /// askew (at most one in 16), before they build the 8-wide hierarchy: shadow rays in a colonnade are 1.1 to 1.3 times as fast.
    /// Usual for [`Builder::Binned`]; [`Builder::Morton`] has a faster way without.
    pub cut_large_triangles: bool,
    /// Whether builders take out the largest nodes of the finished tree, and put each where all boxes become smallest together
    /// (Bittner et al. 2013), before they build the 8-wide hierarchy: bounce rays in a colonnade are 1.1 times as fast, and those
    /// at scans of smooth surfaces as fast as before. Usual for [`Builder::Binned`] and [`Builder::Spatial`].
    pub reinsertion: bool,
}

impl BuildOptions {
    /// The usual settings for a builder; [`Builder::Hybrid`] has its own: leaves of up to 5, a traversal cost of 0.5
    /// and 20 levels.
    pub fn of(builder: Builder) -> BuildOptions {
        let usual = BuildOptions {
            builder,
            max_leaf_primitives: 4,
            traversal_cost: 1.0,
            max_depth: eosphor_core::hierarchy::MAX_BVH_DEPTH as u32,
            cut_large_triangles: builder == Builder::Binned,
            reinsertion: matches!(builder, Builder::Binned | Builder::Spatial),
        };
        match builder {
            Builder::Hybrid => {
                BuildOptions { max_leaf_primitives: 5, traversal_cost: 0.5, max_depth: 20, ..usual }
            }
            _ => usual,
        }
    }
}

impl Default for BuildOptions {
    fn default() -> BuildOptions {
        Quality::default().options()
    }
}

impl From<Quality> for BuildOptions {
    fn from(quality: Quality) -> BuildOptions {
        quality.options()
    }
}

impl From<Builder> for BuildOptions {
    fn from(builder: Builder) -> BuildOptions {
        BuildOptions::of(builder)
    }
}

fn parse<T: Copy + fmt::Display>(what: &str, s: &str, all: &[T]) -> Result<T, String> {
    all.iter().copied().find(|x| x.to_string() == s).ok_or_else(|| {
        let names: Vec<String> = all.iter().map(T::to_string).collect();
        format!("unknown {what} '{s}': choose one of {}", names.join(", "))
    })
}
