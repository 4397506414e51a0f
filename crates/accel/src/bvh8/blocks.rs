//! Blocks of triangles, four lanes at a time: the bits of [`PackedTriangle::new`] in a third of its time.

use super::TriangleBlock;
use crate::bvh::finite_box;
use eosphor_core::geometry::Bounds;
#[cfg(target_arch = "x86_64")]
use eosphor_core::intersect::BOX_SLACK;
use eosphor_core::intersect::PackedTriangle;
use eosphor_core::math::Vec3;
use std::mem::MaybeUninit;

/// What packing tells of a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Packed {
    /// The box around its triangles, with slack.
    pub(super) bounds: Bounds,
    /// How far a first vertex is from 0, in the sum of its coordinates' sizes, together with the lengths of its two edges: the
    /// largest of the block.
    pub(super) farthest: f32,
}

/// The same of a triangle.
#[inline(always)]
pub(super) fn farthest(triangle: &PackedTriangle) -> f32 {
    let v0 = triangle.v0.abs();
    // Lengths are below 0 in triangles without area, which are not hit wherever they are.
    v0.x + v0.y + v0.z + (triangle.length1 + triangle.length2).max(0.0)
}

/// Writes a block of the first `count` of these triangles, of which there is one at least; the rest of the numbers are
/// any.
///
/// # Safety
/// With `AVX2` the CPU must have AVX2 and FMA.
#[inline(always)]
pub(super) unsafe fn pack<const AVX2: bool>(
    place: &mut MaybeUninit<TriangleBlock>,
    numbers: [u32; 4],
    count: usize,
    vertices: &[[Vec3; 3]],
) -> Packed {
    #[cfg(target_arch = "x86_64")]
    if AVX2 {
        // SAFETY: instruction set: the CPU has AVX2 and FMA, as promised to this function.
        let (packed, clear) = unsafe { pack_avx2(place, numbers, count, vertices) };
        if clear {
            return packed;
        }
    }
    one_by_one(place, &numbers[..count], vertices)
}

/// Where vectors are not at hand, or some triangle may have no area or a box without end.
#[inline(never)]
fn one_by_one(place: &mut MaybeUninit<TriangleBlock>, numbers: &[u32], vertices: &[[Vec3; 3]]) -> Packed {
    let block = place.write(TriangleBlock::EMPTY);
    let mut farthest = 0.0f32;
    for (lane, &number) in numbers.iter().enumerate() {
        let triangle = PackedTriangle::new(vertices[number as usize], number);
        block.set(lane % 4, &triangle);
        farthest = farthest.max(self::farthest(&triangle));
    }
    Packed { bounds: finite_box(numbers.iter().map(|n| &vertices[*n as usize])), farthest }
}

/// What is known of the sine between two edges without dividing by their lengths: squared, it is above this, with a
/// margin over [`PackedTriangle::new`]'s own limit (2^-44) that is far larger than all rounding.
#[cfg(target_arch = "x86_64")]
const CLEAR_SINE_SQUARED: f32 = 1e-10;

/// Areas, squared, above this are not the result of underflow.
#[cfg(target_arch = "x86_64")]
const CLEAR_AREA_SQUARED: f32 = 1e-30;

/// [`pack`], and whether what it wrote and returned counts: triangles have an area, and the box is finite.
#[cfg(target_arch = "x86_64")]
#[inline]
#[target_feature(enable = "avx2,fma")]
fn pack_avx2(
    place: &mut MaybeUninit<TriangleBlock>,
    numbers: [u32; 4],
    count: usize,
    vertices: &[[Vec3; 3]],
) -> (Packed, bool) {
    use core::arch::x86_64::*;
    let transposed = |mut rows: [__m128; 4]| {
        let [a, b, c, d] = &mut rows;
        _MM_TRANSPOSE4_PS(a, b, c, d);
        rows
    };
    let corners = numbers.map(|n| vertices[n as usize].as_ptr().cast::<f32>());
    // SAFETY: nine numbers are read of the nine of each triangle.
    let [first, second, last] = unsafe {
        let z = corners.map(|p| *p.add(8));
        [
            transposed(corners.map(|p| _mm_loadu_ps(p))),
            transposed(corners.map(|p| _mm_loadu_ps(p.add(4)))),
            [_mm_setr_ps(z[0], z[1], z[2], z[3]); 4],
        ]
    };
    let v0 = [first[0], first[1], first[2]];
    let v1 = [first[3], second[0], second[1]];
    let v2 = [second[2], second[3], last[0]];
    let minus = |a: [__m128; 3], b: [__m128; 3]| {
        [_mm_sub_ps(a[0], b[0]), _mm_sub_ps(a[1], b[1]), _mm_sub_ps(a[2], b[2])]
    };
    // As `Vec3` does it.
    let dot = |a: [__m128; 3], b: [__m128; 3]| {
        _mm_fmadd_ps(a[2], b[2], _mm_fmadd_ps(a[1], b[1], _mm_mul_ps(a[0], b[0])))
    };
    let (e1, e2) = (minus(v1, v0), minus(v2, v0));
    let (q1, q2) = (dot(e1, e1), dot(e2, e2));
    let normal_on = |a: usize, b: usize| _mm_fmsub_ps(e1[a], e2[b], _mm_mul_ps(e1[b], e2[a]));
    let normal = [normal_on(1, 2), normal_on(2, 0), normal_on(0, 1)];
    let area = dot(normal, normal);
    let least = _mm_mul_ps(_mm_set1_ps(CLEAR_SINE_SQUARED), _mm_mul_ps(q1, q2));
    let least = _mm_max_ps(least, _mm_set1_ps(CLEAR_AREA_SQUARED));
    let clear = _mm_movemask_ps(_mm_cmpgt_ps(area, least)) == 15;

    let all = |largest: bool| {
        let op = |a, b| if largest { _mm_max_ps(a, b) } else { _mm_min_ps(a, b) };
        let on = |axis: usize| op(v0[axis], op(v1[axis], v2[axis]));
        let z = on(2);
        let [a, b, c, d] = transposed([on(0), on(1), z, z]);
        op(op(a, b), op(c, d))
    };
    // As `Bounds::with_slack`.
    let (low, high) = (all(false), all(true));
    let slack = |x| _mm_mul_ps(_mm_andnot_ps(_mm_set1_ps(-0.0), x), _mm_set1_ps(BOX_SLACK));
    let (low, high) = (_mm_sub_ps(low, slack(low)), _mm_add_ps(high, slack(high)));
    let size = _mm_sub_ps(high, low);
    let finite = _mm_movemask_ps(_mm_cmplt_ps(size, _mm_set1_ps(f32::INFINITY))) == 15;

    let used = _mm_cmpgt_epi32(_mm_set1_epi32(count as i32), _mm_setr_epi32(0, 1, 2, 3));
    let used_ps = _mm_castsi128_ps(used);
    let only_used = |v: [__m128; 3]| v.map(|x| to_array(_mm_and_ps(x, used_ps)));
    let or_unused = |x: __m128, unused: f32| to_array(_mm_blendv_ps(_mm_set1_ps(unused), x, used_ps));
    let (length1, length2) = (_mm_sqrt_ps(q1), _mm_sqrt_ps(q2));
    let lengths = _mm_add_ps(length1, length2);
    // As `farthest` does it; lanes that are not used repeat the first.
    let [x, y, z] = v0.map(|x| _mm_andnot_ps(_mm_set1_ps(-0.0), x));
    let far = _mm_add_ps(_mm_add_ps(_mm_add_ps(x, y), z), lengths);
    let far = _mm_max_ps(far, _mm_movehl_ps(far, far));
    let far = _mm_max_ss(far, _mm_shuffle_ps::<1>(far, far));
    let mut primitive = [u32::MAX; 4];
    for k in 0..4 {
        primitive[k] = if k < count { numbers[k] } else { u32::MAX };
    }
    place.write(TriangleBlock {
        v0: only_used(v0),
        v1: only_used(v1),
        v2: only_used(v2),
        lengths: or_unused(lengths, -2.0),
        product: or_unused(_mm_mul_ps(length1, length2), 1.0),
        primitive,
    });
    let (low, high) = (to_array(low), to_array(high));
    let corner = |x: [f32; 4]| Vec3 { x: x[0], y: x[1], z: x[2] };
    let bounds = Bounds { min: corner(low), max: corner(high) };
    (Packed { bounds, farthest: _mm_cvtss_f32(far) }, clear & finite)
}

/// The four numbers of a register.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn to_array(x: core::arch::x86_64::__m128) -> [f32; 4] {
    // SAFETY: lanes: both are four numbers.
    unsafe { std::mem::transmute(x) }
}

/// The numbers of a block's triangles, and the first again in the lanes that are not used.
#[inline(always)]
pub(super) fn lanes(count: usize, number: impl Fn(usize) -> u32) -> [u32; 4] {
    [0, 1, 2, 3].map(|k| number(if k < count { k } else { 0 }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd_level::has_avx2;
    use eosphor_core::math::vec3;

    /// A few simple numbers that look random.
    fn random(state: &mut u32) -> f32 {
        *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (*state >> 8) as f32 / 8_388_608.0 - 1.0
    }

    #[test]
    fn blocks_are_those_of_triangles_packed_one_by_one() {
        let mut state = 1;
        let mut vertices: Vec<[Vec3; 3]> = Vec::new();
        for scale in [1.0, 1e-3, 1e-6, 1e-9, 1e-15, 1e-20, 1e9, 1e12, 1e18] {
            for thin in [1.0, 1e-3, 1e-5, 1e-6, 3e-7, 1e-7, 0.0] {
                for _ in 0..8 {
                    let mut corner =
                        || vec3(random(&mut state), random(&mut state), random(&mut state)) * scale;
                    let (a, b, c) = (corner(), corner(), corner());
                    vertices.push([a, b, b + (b - a) * 0.5 + c * thin]);
                    vertices.push([a, a + (b - a), a + (c - a) * thin]);
                }
            }
        }
        for count in 1..=4 {
            for first in 0..vertices.len() - count {
                let numbers = lanes(count, |k| (first + k) as u32);
                let mut places = [const { MaybeUninit::uninit() }; 2];
                let [place, right] = &mut places;
                let fast = has_avx2();
                // SAFETY: instruction set: the CPU has been asked for AVX2 and FMA.
                let packed = unsafe {
                    if fast {
                        pack::<true>(place, numbers, count, &vertices)
                    } else {
                        pack::<false>(place, numbers, count, &vertices)
                    }
                };
                let right_packed = one_by_one(right, &numbers[..count], &vertices);
                // SAFETY: written places: both are written.
                let [block, right] = places.map(|p| unsafe { p.assume_init() });
                let bits = |b: &TriangleBlock| -> Vec<u32> {
                    let vectors = [b.v0, b.v1, b.v2];
                    vectors.as_flattened().as_flattened().iter().map(|x| x.to_bits()).collect()
                };
                assert_eq!((bits(&block), block), (bits(&right), right), "{first} {count}");
                assert_eq!(packed, right_packed, "{first} {count}");
            }
        }
    }
}
