//! From the modes of primitives to triangles.

use super::document::Mode;
use eosphor_core::math::{Vec3, sqrt64, vec3};

/// Whether a mode draws surfaces.
pub(super) fn has_triangles(mode: Mode) -> bool {
    matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)
}

/// The triangles of a primitive, in the file's order, by the formulas of the specification (3.7.2.1): every second
/// one of a strip is turned round, so that all have their fronts on one side.
pub(super) fn for_each_triangle(mode: Mode, indices: &[u32], mut take: impl FnMut([u32; 3])) {
    match mode {
        Mode::Triangles => {
            for triangle in indices.chunks_exact(3) {
                take([triangle[0], triangle[1], triangle[2]]);
            }
        }
        Mode::TriangleStrip => {
            for (i, window) in indices.windows(3).enumerate() {
                let [a, b, c] = [window[0], window[1], window[2]];
                take(if i % 2 == 0 { [a, b, c] } else { [a, c, b] });
            }
        }
        Mode::TriangleFan => {
            let Some((&center, rim)) = indices.split_first() else { return };
            for edge in rim.windows(2) {
                take([edge[0], edge[1], center]);
            }
        }
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => {}
    }
}

/// How many triangles that gives.
pub(super) fn triangle_count(mode: Mode, indices: usize) -> usize {
    match mode {
        Mode::Triangles => indices / 3,
        Mode::TriangleStrip | Mode::TriangleFan => indices.saturating_sub(2),
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => 0,
    }
}

/// The unit normal on the side from which the triangle runs counter-clockwise; zero where it has no area.
pub(super) fn face_normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    let difference = |p: Vec3, q: Vec3| [0, 1, 2].map(|axis| f64::from(p[axis]) - f64::from(q[axis]));
    let (e, f) = (difference(b, a), difference(c, a));
    let n = [e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]];
    let length = sqrt64(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    if !(length > 0.0 && length.is_finite()) {
        return Vec3::ZERO;
    }
    vec3((n[0] / length) as f32, (n[1] / length) as f32, (n[2] / length) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangles(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
        let mut all = Vec::new();
        for_each_triangle(mode, indices, |t| all.push(t));
        assert_eq!(all.len(), triangle_count(mode, indices.len()));
        all
    }

    #[test]
    fn modes_as_the_specification_has_them() {
        let five = [10, 11, 12, 13, 14];
        assert_eq!(triangles(Mode::Triangles, &five), [[10, 11, 12]]);
        assert_eq!(triangles(Mode::TriangleStrip, &five), [[10, 11, 12], [11, 13, 12], [12, 13, 14]]);
        assert_eq!(triangles(Mode::TriangleFan, &five), [[11, 12, 10], [12, 13, 10], [13, 14, 10]]);
        for mode in [Mode::Triangles, Mode::TriangleStrip, Mode::TriangleFan, Mode::LineLoop] {
            for n in 0..3 {
                assert!(triangles(mode, &five[..n]).is_empty());
            }
        }
    }

    #[test]
    fn face_normals_at_any_size() {
        for scale in [1e-20, 1.0, 1e11] {
            let corners = [Vec3::ZERO, vec3(0.0, scale, 0.0), vec3(0.0, 0.0, scale)];
            assert_eq!(face_normal(corners), vec3(1.0, 0.0, 0.0));
        }
        assert_eq!(face_normal([Vec3::ONE; 3]), Vec3::ZERO);
    }
}
