//! The surroundings of models that bring no light.

use crate::model::{Material, RenderSettings, Scene};
use eosphor_core::math::Vec3;

/// Their radiance. Metal shows nothing where there is nothing to reflect, and what is dark cannot be told from black.
const GREY: f32 = 0.25;

/// Puts grey surroundings around a model that nothing lights, where its settings let light be added. They are seen behind it, too.
pub(super) fn add(scene: &mut Scene, has_lamps: bool) {
    if scene.settings.headlight && scene.lights.is_empty() && !has_lamps {
        (scene.settings.background, scene.settings.ambient) = (Vec3::splat(GREY), GREY);
    }
}

/// The same for path tracing, which gives surroundings to all scenes without light by itself: what is left are models that shine
/// through textures alone, such as displays and diodes. That is light, but none to see the rest by. Whether they were put.
pub(super) fn add_for_paths(scene: &mut Scene, has_lamps: bool, has_shining_textures: bool) -> bool {
    let is_meant = scene.settings.headlight && scene.lights.is_empty() && !has_lamps && has_shining_textures;
    if is_meant {
        scene.settings.background = Vec3::splat(RenderSettings::SURROUNDINGS);
    }
    is_meant
}

/// Whether triangles of the material are lights. Those that shine through a texture are none.
pub(super) fn shines(material: &Material) -> bool {
    material.emission() != Vec3::ZERO && material.textures.emission.is_none()
}

/// Whether triangles of the scene are lights.
pub(super) fn has_lamps(scene: &Scene) -> bool {
    let shines: Vec<bool> = scene.materials.iter().map(shines).collect();
    let is_lamp = |material: u32| shines.get(material as usize).is_some_and(|&shines| shines);
    // (Most files have no such material, and a look at each triangle is not needed.)
    shines.contains(&true)
        && scene.meshes.iter().any(|mesh| mesh.triangles.iter().any(|triangle| is_lamp(triangle.material)))
}
