//! Whether SceneData holds together.

use super::SceneData;
use crate::error::Problem;
use eosphor_core::integrator::MAX_DEPTH;
use eosphor_core::light::Light;
use eosphor_core::view::{SceneArray, SceneCounts, SceneItem, SceneVisitor};

impl SceneData {
    /// Whether every number leads somewhere. What [`SceneData::flatten`] makes does; backends ask because the fields are
    /// open to change, and devices do not look where a number leads.
    ///
    /// # Errors
    /// The first array that is too short, or the first number that is too large.
    pub fn check(&self) -> Result<(), Problem> {
        let wrong = |what: &str, why: &str| Err(Problem::new(what, why.to_owned()));
        let view = self.view();
        let mut links = Links { counts: view.counts(), wrong: None };
        view.visit(&mut links);
        if let Some(problem) = links.wrong {
            return Err(problem);
        }
        // What the items do not say of themselves.
        let (triangles, spheres) = (self.triangles.len(), self.spheres.len());
        if self.triangle_shading.len() != triangles || self.sphere_materials.len() != spheres {
            return wrong("scene data", "primitives and their shading differ in number");
        }
        if self.sphere_materials.iter().any(|&m| m as usize >= self.materials.len()) {
            return wrong("scene data: sphere materials", "one leads to a material that is not there");
        }
        if self.instances.first().is_none_or(|world| world.geometry != 0) {
            return wrong("scene data: instances", "index 0 must be the world");
        }
        // The world is not among them.
        if self.deforming_geometries as usize >= self.geometries.len() {
            return wrong(
                "scene data: deforming geometries",
                "there are more of them than geometries but the world",
            );
        }
        if self.textures.iter().any(|t| t.width == 0 || t.height == 0 || !(1..=4).contains(&t.channels)) {
            return wrong("scene data: textures", "one has no texels, or not 1 to 4 channels");
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

/// Looks for an index that leads nowhere.
struct Links {
    counts: SceneCounts,
    /// The first one.
    wrong: Option<Problem>,
}

impl<'a> SceneVisitor<'a> for Links {
    fn array<T: SceneItem>(&mut self, array: SceneArray, items: &'a [T]) {
        let (counts, mut wrong) = (self.counts, None);
        for (number, item) in items.iter().enumerate() {
            item.links(&mut |to, index| {
                if index >= counts.of(to) && wrong.is_none() {
                    wrong = Some((number, to, index));
                }
            });
            if wrong.is_some() {
                break;
            }
        }
        if let Some((number, to, index)) = wrong
            && self.wrong.is_none()
        {
            let (what, count) = (format!("scene data: {}", array.label()), counts.of(to));
            let why =
                format!("item {number} leads to number {index} of the {}, which are {count}", to.label());
            self.wrong = Some(Problem::new(what, why));
        }
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
