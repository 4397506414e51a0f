//! How warps walk.

use eosphor_core::device::WarpMode;

/// How the threads of a warp, 32 of them, walk through a bounding volume hierarchy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Traversal {
    /// By vote where all rays start in one point and go the same way along every axis, else each for itself.
    #[default]
    Auto,
    /// Each for itself, the nearer child first.
    Single,
    /// By vote: all go where any has to, first to the child that is nearer for most. Through what instances place each
    /// walks for itself.
    Vote,
    /// Each for itself, but waiting for the others after every node and leaf.
    Reconverge,
    /// The same through a tree with eight children a node, whose boxes have 8 bits a plane.
    Wide,
}

impl Traversal {
    /// All there are.
    pub const ALL: [Traversal; 5] =
        [Traversal::Auto, Traversal::Single, Traversal::Vote, Traversal::Reconverge, Traversal::Wide];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Traversal::Auto => "auto",
            Traversal::Single => "single",
            Traversal::Vote => "vote",
            Traversal::Reconverge => "reconverge",
            Traversal::Wide => "wide",
        }
    }

    /// As kernels take it that know more than one way.
    pub(crate) fn warp_mode(self) -> WarpMode {
        match self {
            Traversal::Vote => WarpMode::VOTING,
            Traversal::Single => WarpMode::INDEPENDENT,
            Traversal::Auto | Traversal::Reconverge | Traversal::Wide => WarpMode::AUTO,
        }
    }
}
