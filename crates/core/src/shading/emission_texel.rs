//! What a texture says of a lamp that is sampled.

use super::surface::blended;
use crate::material::NONE;
use crate::math::Vec3;
use crate::out_of_line::out_of_line;
use crate::ray::PrimitiveId;
use crate::texture::{Textures, color_at};
use crate::view::{SceneView, item};

/// The colour of a texture at a place of a triangle: weights of its second and third corner.
#[inline(always)]
pub fn emission_texel(view: &SceneView, id: PrimitiveId, texture: u32, [u, v]: [f32; 2]) -> Vec3 {
    let geometry = item(view.geometries, item(view.instances, id.instance).geometry);
    let shading = item(view.triangle_shading, geometry.first_triangle + id.primitive);
    let mut uvs = [blended(&shading.uvs, u, v); 2];
    if shading.extra != NONE {
        uvs[1] = blended(&item(view.triangle_extras, shading.extra).uvs1, u, v);
    }
    lamp_color(&view.textures(), texture, &uvs)
}

out_of_line! {
    /// A lamp with a texture is rare, and reading one is long.
    fn lamp_color(textures: &Textures<'_>, texture: u32, uvs: &[[f32; 2]; 2]) -> Vec3 {
        color_at(textures, texture, uvs)
    }
}
