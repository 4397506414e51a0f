//! What the 8-wide hierarchy is made of.

use eosphor_core::intersect::PackedTriangle;
use eosphor_core::math::Vec3;

/// Where a child is: an inner node, or a leaf by kind.
///
/// Inner nodes are plain numbers of nodes. Leaves have [`LEAF`] set; with [`SPHERE`] they are one sphere, with
/// [`INSTANCE`] one place in the order of the instances, with neither one block of triangles.
pub type Child = u32;

/// This bit of a [`Child`] is set in leaves.
pub const LEAF: Child = 1 << 31;
/// This bit of a [`Child`] is set in leaves that are one sphere: [`PLACE`] is its place among the spheres.
pub const SPHERE: Child = 1 << 30;
/// This bit of a [`Child`] is set in leaves that are one instance: [`PLACE`] is its number.
pub const INSTANCE: Child = 1 << 29;
/// The bits of a [`Child`] that is a leaf which are a place: in the array of blocks or spheres, or the number of an instance.
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
    /// A node without children.
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

/// Up to four triangles, lane by lane as [`PackedTriangle`] has them: 192 bytes, three cache lines. (With the edges beside
/// the vertices it would be five: single rays in Sponza were up to 20 percent slower.) Unused lanes have lengths below 0, so
/// they are never hit, and `primitive` is `u32::MAX`. Used ones come first.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct TriangleBlock {
    /// First vertices: x, y and z of each lane.
    pub v0: [[f32; 4]; 3],
    /// Second vertices: x, y and z of each lane.
    pub v1: [[f32; 4]; 3],
    /// Third vertices: x, y and z of each lane.
    pub v2: [[f32; 4]; 3],
    /// Lengths of the edges from the first vertices, added up.
    pub lengths: [f32; 4],
    /// Lengths of the edges from the first vertices, multiplied.
    pub product: [f32; 4],
    /// Numbers of the triangles in their geometry.
    pub primitive: [u32; 4],
}

impl TriangleBlock {
    /// A block without triangles.
    pub const EMPTY: TriangleBlock = TriangleBlock {
        v0: [[0.0; 4]; 3],
        v1: [[0.0; 4]; 3],
        v2: [[0.0; 4]; 3],
        lengths: [-2.0; 4],
        product: [1.0; 4],
        primitive: [u32::MAX; 4],
    };

    /// Puts a triangle into a lane, 0 to 3.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, triangle: &PackedTriangle) {
        for axis in 0..3 {
            self.v0[axis][lane] = triangle.v0[axis];
            self.v1[axis][lane] = triangle.v1[axis];
            self.v2[axis][lane] = triangle.v2[axis];
        }
        self.lengths[lane] = triangle.length1 + triangle.length2;
        self.product[lane] = triangle.length1 * triangle.length2;
        self.primitive[lane] = triangle.primitive;
    }

    /// The triangle in a lane, 0 to 3. In a lane that is not used, one that is never hit.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> PackedTriangle {
        let pick = |v: &[[f32; 4]; 3]| Vec3 { x: v[0][lane], y: v[1][lane], z: v[2][lane] };
        PackedTriangle::new([pick(&self.v0), pick(&self.v1), pick(&self.v2)], self.primitive[lane])
    }
}

/// Primitives of a leaf, or the one instance.
#[inline(always)]
pub(super) fn held(blocks: &[TriangleBlock], leaf: Child) -> u32 {
    if leaf & (SPHERE | INSTANCE) != 0 {
        return 1;
    }
    let primitives = blocks[(leaf & PLACE) as usize].primitive;
    primitives.iter().filter(|&&primitive| primitive != u32::MAX).count() as u32
}
