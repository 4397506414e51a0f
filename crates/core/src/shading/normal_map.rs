//! Normals from textures in tangent space.

use crate::material::Material;
use crate::math::{Vec3, fma};
use crate::texture::Textures;

/// The shading normal that a material's texture of normals gives instead of `smooth` (any length), where it says
/// `texel`.
///
/// The tangents are the triangle's own derivatives of position by texture coordinate, made perpendicular to the
/// shading normal; `edges` are those from the first corner to the others, at any scale, `corner_uvs` both sets at the
/// corners. Where these span no plane the normal stays as it is.
#[inline(always)]
pub fn normal_map(
    textures: &Textures,
    material: &Material,
    smooth: Vec3,
    edges: &[Vec3; 2],
    corner_uvs: &[[[f32; 2]; 3]; 2],
    texel: Vec3,
) -> Vec3 {
    let texture = material.normal_texture;
    let corner = |k: usize| textures.picture_uv(texture, &[corner_uvs[0][k], corner_uvs[1][k]]);
    let [[u0, v0], [u1, v1], [u2, v2]] = [corner(0), corner(1), corner(2)];
    let (du1, dv1, du2, dv2) = (u1 - u0, v1 - v0, u2 - u0, v2 - v0);
    let sign = if fma(du1, dv2, -(du2 * dv1)) < 0.0 { -1.0 } else { 1.0 };
    let n = smooth.normalize_or(Vec3::ZERO);
    // Along growing u, and, by the sign of the mapping, along growing v.
    let along_u = (edges[0] * (dv2 * sign)).plus_scaled(edges[1], -dv1 * sign);
    let tangent = along_u.plus_scaled(n, -along_u.dot(n)).normalize_or(Vec3::ZERO);
    let bitangent = n.cross(tangent) * sign;
    let scale = material.normal_scale;
    let (x, y, z) =
        (fma(2.0, texel.x, -1.0) * scale, fma(2.0, texel.y, -1.0) * scale, fma(2.0, texel.z, -1.0));
    let mapped = (n * z).plus_scaled(tangent, x).plus_scaled(bitangent, y);
    if tangent == Vec3::ZERO { smooth } else { mapped.normalize_or(n) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::vec3;
    use crate::texture::{TexelFormat, Texture, TextureFilter, TextureWrap};

    /// One texel: tilted a little along +u and a lot along +v.
    const TILTED: [f32; 4] = [0.6, 0.9, 1.0, 1.0];

    fn map(corner_uvs: [[f32; 2]; 3], scale: f32) -> Vec3 {
        let words = TILTED.map(f32::to_bits);
        let texture = Texture {
            first_word: 0,
            width: 1,
            height: 1,
            format: TexelFormat::Float,
            channels: 4,
            filter: TextureFilter::Nearest,
            wrap_u: TextureWrap::Repeat,
            wrap_v: TextureWrap::Repeat,
            uv_set: 0,
            picture_from_mesh_uv: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        };
        let textures = Textures { textures: &[texture], words: &words, srgb_decode: &[0.0; 256] };
        let material = Material { normal_texture: 0, normal_scale: scale, ..Material::default() };
        let edges = [vec3(2.0, 0.0, 0.0), vec3(0.0, 0.5, 0.0)];
        let texel = textures.sample(0, &[[0.5; 2]; 2]).color;
        normal_map(&textures, &material, vec3(0.0, 0.0, 3.0), &edges, &[corner_uvs; 2], texel)
    }

    #[test]
    fn texels_tilt_along_the_coordinates() {
        let near = |a: Vec3, b: Vec3| assert!((a - b.normalize()).length() < 1e-5, "{a:?} {b:?}");
        // u along +x, v along +y.
        near(map([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], 1.0), vec3(0.2, 0.8, 1.0));
        // Mirrored: u along -x.
        near(map([[1.0, 0.0], [0.0, 0.0], [1.0, 1.0]], 1.0), vec3(-0.2, 0.8, 1.0));
        // Turned: u along +y, v along -x.
        near(map([[0.0, 1.0], [0.0, 0.0], [1.0, 1.0]], 1.0), vec3(-0.8, 0.2, 1.0));
        near(map([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], 0.5), vec3(0.1, 0.4, 1.0));
        // No coordinates at all.
        assert_eq!(map([[0.0; 2]; 3], 1.0), vec3(0.0, 0.0, 3.0));
    }
}
