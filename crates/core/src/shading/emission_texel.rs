//! What a texture says of a lamp that is sampled.

use super::surface::blended;
use crate::material::NONE;
use crate::math::Vec3;
use crate::ray::PrimitiveId;
use crate::view::{SceneView, item};

/// The colour of a texture at the place (u, v) of a triangle: weights of its second and third corner.
#[inline(always)]
pub fn emission_texel(view: &SceneView, id: PrimitiveId, texture: u32, [u, v]: [f32; 2]) -> Vec3 {
    let geometry = item(view.geometries, item(view.instances, id.instance).geometry);
    let shading = item(view.triangle_shading, geometry.first_triangle + id.primitive);
    let mut uvs = [blended(&shading.uvs, u, v); 2];
    if shading.extra != NONE {
        uvs[1] = blended(&item(view.triangle_extras, shading.extra).uvs1, u, v);
    }
    view.textures().sample(texture, &uvs).color
}
