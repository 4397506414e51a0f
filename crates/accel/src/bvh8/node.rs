//! What the 8-wide hierarchy is made of.

use eosphor_core::intersect::PackedTriangle;
use eosphor_core::math::Vec3;

/// Where a child is: an inner node, or a leaf by kind.
///
/// Inner nodes are plain numbers of nodes. Leaves have [`LEAF`] set; with [`SPHERE`] they are one sphere, with
/// [`INSTANCE`] one place in the order of the instances, with neither one block of triangles.
pub type Child = u32;

/// Set in leaves.
pub const LEAF: Child = 1 << 31;
/// Set in leaves that are one sphere: the rest is its place in the array.
pub const SPHERE: Child = 1 << 30;
/// Set in leaves that are one instance: the rest is its number.
pub const INSTANCE: Child = 1 << 29;
/// The bits that are a place.
pub const PLACE: Child = INSTANCE - 1;
/// No child: its box is turned inside out, so no ray enters it.
pub const EMPTY: Child = u32::MAX;

/// Up to eight children: 256 bytes, four cache lines.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct Node8 {
    /// Boxes of the children: smallest x, largest x, smallest y, and so on. The far plane of an axis stands 32 bytes
    /// from the near one, whichever is which.
    pub planes: [[f32; 8]; 6],
    /// The children; [`EMPTY`] ones may stand anywhere. Any hit is most cheaply looked for in the last ones.
    pub children: [Child; 8],
    /// For each octant of directions (bit 0: x below 0, bit 1: y, bit 2: z), the places of the children in three bits
    /// each, farthest first, so that the nearest ends on top of the stack. Empty ones come first.
    pub orders: [u32; 8],
}

impl Node8 {
    /// Without children.
    pub const EMPTY: Node8 = Node8 {
        planes: [
            [f32::INFINITY; 8],
            [f32::NEG_INFINITY; 8],
            [f32::INFINITY; 8],
            [f32::NEG_INFINITY; 8],
            [f32::INFINITY; 8],
            [f32::NEG_INFINITY; 8],
        ],
        children: [EMPTY; 8],
        orders: [0o01234567; 8],
    };
}

/// Up to four triangles, lane by lane as [`PackedTriangle`] has them: 192 bytes for the first step, and 96 more that only
/// double precision reads. Unused lanes have lengths below 0, so they are never hit, and `primitive` is `u32::MAX`. Used ones
/// come first.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct TriangleBlock {
    /// First vertices.
    pub v0: [[f32; 4]; 3],
    /// From the first vertices to the second, rounded.
    pub e1: [[f32; 4]; 3],
    /// From the first vertices to the third, rounded.
    pub e2: [[f32; 4]; 3],
    /// From the first vertices to the second.
    pub length1: [f32; 4],
    /// From the first vertices to the third.
    pub length2: [f32; 4],
    /// Numbers in the geometry.
    pub primitive: [u32; 4],
    /// Second vertices.
    pub v1: [[f32; 4]; 3],
    /// Third vertices.
    pub v2: [[f32; 4]; 3],
}

impl TriangleBlock {
    /// Without triangles.
    pub const EMPTY: TriangleBlock = TriangleBlock {
        v0: [[0.0; 4]; 3],
        e1: [[0.0; 4]; 3],
        e2: [[0.0; 4]; 3],
        length1: [-1.0; 4],
        length2: [-1.0; 4],
        primitive: [u32::MAX; 4],
        v1: [[0.0; 4]; 3],
        v2: [[0.0; 4]; 3],
    };

    /// Puts a triangle into a lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, triangle: &PackedTriangle) {
        let (e1, e2) = (triangle.e1(), triangle.e2());
        for axis in 0..3 {
            self.v0[axis][lane] = triangle.v0[axis];
            self.e1[axis][lane] = e1[axis];
            self.e2[axis][lane] = e2[axis];
            self.v1[axis][lane] = triangle.v1[axis];
            self.v2[axis][lane] = triangle.v2[axis];
        }
        self.length1[lane] = triangle.length1;
        self.length2[lane] = triangle.length2;
        self.primitive[lane] = triangle.primitive;
    }

    /// The triangle in a lane.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> PackedTriangle {
        let pick = |v: &[[f32; 4]; 3]| Vec3 { x: v[0][lane], y: v[1][lane], z: v[2][lane] };
        PackedTriangle {
            v0: pick(&self.v0),
            length1: self.length1[lane],
            v1: pick(&self.v1),
            length2: self.length2[lane],
            v2: pick(&self.v2),
            primitive: self.primitive[lane],
        }
    }
}
