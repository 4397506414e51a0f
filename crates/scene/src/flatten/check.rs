//! Whether SceneData holds together.

use super::SceneData;
use crate::error::Problem;
use eosphor_core::integrator::whitted::MAX_DEPTH;
use eosphor_core::light::Light;
use eosphor_core::material::{Material, NONE};

impl SceneData {
    /// Whether every number leads somewhere. What [`SceneData::flatten`] makes does; backends ask because the fields are
    /// open to change, and devices do not look where a number leads.
    ///
    /// # Errors
    /// The first array that is too short, or the first number that is too large.
    pub fn check(&self) -> Result<(), Problem> {
        let wrong = |what: &str, why: &str| Err(Problem::new(what, why.to_owned()));
        let (triangles, spheres) = (self.triangles.len() as u64, self.spheres.len() as u64);
        if self.triangle_shading.len() as u64 != triangles || self.sphere_materials.len() as u64 != spheres {
            return wrong("scene data", "primitives and their shading differ in number");
        }
        for g in &self.geometries {
            let fits = |first: u32, count: u32, all: u64| u64::from(first) + u64::from(count) <= all;
            if !fits(g.first_triangle, g.triangle_count, triangles)
                || !fits(g.first_sphere, g.sphere_count, spheres)
            {
                return wrong("scene data: geometries", "one has primitives that are not there");
            }
        }
        if self.instances.first().is_none_or(|world| world.geometry != 0)
            || self.instances.iter().any(|i| i.geometry as usize >= self.geometries.len())
        {
            return wrong(
                "scene data: instances",
                "number 0 must be the world, and each must have a geometry",
            );
        }
        let materials = self.materials.len();
        let overrides = self.instances.iter().map(|i| i.material).filter(|&m| m != NONE);
        let used = self.triangle_shading.iter().map(|t| t.material);
        let used = used.chain(self.sphere_materials.iter().copied()).chain(overrides);
        if used.into_iter().any(|m| m as usize >= materials) {
            return wrong("scene data: materials", "a primitive has one that is not there");
        }
        let extras = self.triangle_extras.len();
        if self.triangle_shading.iter().any(|t| t.extra != NONE && t.extra as usize >= extras) {
            return wrong("scene data: triangles", "one has vertex colours that are not there");
        }
        if self.textures.iter().any(|t| t.width == 0 || t.height == 0 || !(1..=4).contains(&t.channels)) {
            return wrong("scene data: textures", "one has no texels, or not 1 to 4 channels");
        }
        let texture = |t: u32| t == NONE || (t as usize) < self.textures.len();
        let textures = |m: &Material| {
            [m.diffuse_texture, m.specular_texture, m.emission_texture, m.normal_texture]
                .into_iter()
                .all(texture)
                && [m.metallic_texture, m.roughness_texture, m.transmission_texture, m.opacity_texture]
                    .iter()
                    .all(|t| texture(t.texture))
        };
        if !self.materials.iter().all(textures) {
            return wrong("scene data: textures", "a material has one that is not there");
        }
        let no_samples = |light: &Light| light.samples() == 0;
        if self.lights.iter().any(no_samples) {
            return wrong("scene data: lights", "one has no samples");
        }
        let s = &self.settings;
        let sides = 1..=65_535;
        if !sides.contains(&s.width)
            || !sides.contains(&s.height)
            || s.samples == 0
            || s.max_depth > MAX_DEPTH
        {
            return wrong("scene data: settings", "the size, the samples or the depth are out of range");
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LoadOptions, load};

    #[test]
    fn what_flattening_makes_holds_together_and_changes_are_found() {
        let scene = load("builtin:cornell", &LoadOptions::default()).unwrap().scene;
        let (data, _) = SceneData::flatten(&scene).unwrap();
        assert!(data.check().is_ok());
        let changes: [fn(&mut SceneData); 11] = [
            |d| d.materials[0].roughness_texture.texture = 0,
            |d| d.triangle_shading[5].extra = 0,
            |d| d.instances[0].material = 1000,
            |d| d.settings.max_depth = 100,
            |d| d.settings.width = 0,
            |d| d.materials.clear(),
            |d| d.geometries[0].triangle_count += 1,
            |d| d.instances.clear(),
            |d| d.materials[0].diffuse_texture = 3,
            |d| d.triangle_shading.truncate(1),
            |d| d.instances[0].geometry = 7,
        ];
        for (number, change) in changes.iter().enumerate() {
            let mut changed = data.clone();
            change(&mut changed);
            assert!(changed.check().is_err(), "change {number}");
        }
    }
}
