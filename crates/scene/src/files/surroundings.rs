//! The surroundings of models that bring no light.

use crate::model::{Material, Scene};
use eosphor_core::math::Vec3;

/// Their radiance. Metal shows nothing where there is nothing to reflect, and what is dark cannot be told from black.
const GREY: f32 = 0.25;

/// Puts grey surroundings around a model that nothing lights, where its settings let light be added. They are seen behind it, too.
pub(super) fn add(scene: &mut Scene, has_lamps: bool) {
    if scene.settings.headlight && scene.lights.is_empty() && !has_lamps {
        (scene.settings.background, scene.settings.ambient) = (Vec3::splat(GREY), GREY);
    }
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
