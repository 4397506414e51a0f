//! A hash of what the pixels of a picture depend on.

use crate::output::DevelopSettings;
use eosphor_core::settings::Settings;
use eosphor_core::view::{SceneArray, SceneItem, SceneView, SceneVisitor};
use eosphor_scene::SceneData;
use std::fmt::{Debug, Write};

/// A BLAKE3 hash, in hexadecimal digits, of all that the pixels of a developed picture depend on besides the version of
/// the program: every array of the scene (so the contents of all files, as far as they matter), the settings and how
/// colours become bytes. Paths, devices, threads and formats are not in it.
///
/// It is a name for one version of the program only: another may order or name things otherwise.
pub fn scene_hash(scene: &SceneData, develop: &DevelopSettings) -> String {
    hash_with(scene, &scene.settings, develop)
}

/// The hash of a scene with these settings instead of its own.
pub(crate) fn hash_with(scene: &SceneData, settings: &Settings, develop: &DevelopSettings) -> String {
    let mut hasher = Hasher::default();
    SceneView { settings, ..scene.view() }.visit(&mut hasher);
    hasher.text("develop", develop);
    hasher.0.finalize().to_hex().to_string()
}

#[derive(Default)]
struct Hasher(blake3::Hasher);

impl<'a> SceneVisitor<'a> for Hasher {
    fn array<T: SceneItem>(&mut self, array: SceneArray, items: &'a [T]) {
        if T::HAS_WORDS {
            self.words(array.label(), items.len(), items);
        } else {
            self.text(array.label(), &items);
        }
    }

    fn one<T: SceneItem>(&mut self, array: SceneArray, item: &'a T) {
        if T::HAS_WORDS {
            let mut count = 0;
            item.words(&mut |_| count += 1);
            self.words(array.label(), count, std::slice::from_ref(item));
        } else {
            self.text(array.label(), item);
        }
    }
}

impl Hasher {
    /// The bits of all numbers. Name and length come first, so that nothing can move from one array to the next.
    fn words<T: SceneItem>(&mut self, name: &str, length: usize, items: &[T]) {
        self.begin(name, length);
        let mut bytes = Vec::new();
        for some in items.chunks(4096) {
            bytes.clear();
            some.iter().for_each(|item| item.words(&mut |word| bytes.extend(word.to_le_bytes())));
            self.0.update(&bytes);
        }
    }

    /// The text that `Debug` writes: it has every field, and floats in it are exact.
    fn text(&mut self, name: &str, value: &impl Debug) {
        let mut text = String::new();
        // Strings never fail.
        let _ = write!(text, "{value:?}");
        self.begin(name, text.len());
        self.0.update(text.as_bytes());
    }

    fn begin(&mut self, name: &str, length: usize) {
        self.0.update(name.as_bytes());
        self.0.update(&[0]);
        self.0.update(&(length as u64).to_le_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eosphor_core::develop::ToneCurve;
    use eosphor_core::geometry::Sphere;
    use eosphor_core::math::Vec3;
    use eosphor_scene::{LoadOptions, load};

    #[test]
    fn everything_that_reaches_a_pixel_counts() {
        let scene = load("builtin:cornell", &LoadOptions::default()).unwrap().scene;
        let (data, _) = SceneData::flatten(&scene).unwrap();
        let develop = DevelopSettings::default();
        let hash = |change: fn(&mut SceneData)| {
            let mut data = data.clone();
            change(&mut data);
            scene_hash(&data, &develop)
        };
        let plain = hash(|_| {});
        assert_eq!((plain.len(), &plain), (64, &hash(|_| {})));
        let changes: [fn(&mut SceneData); 9] = [
            |data| data.triangles[7][1].y += 1e-6,
            |data| data.triangle_shading[7].normals[2].z += 1e-6,
            |data| data.triangle_shading[7].material += 1,
            |data| data.spheres.push(Sphere { center: Vec3::ZERO, radius: 1.0 }),
            |data| data.materials[0].diffuse.x += 1e-6,
            |data| std::sync::Arc::make_mut(&mut data.texture_words).push(0),
            |data| data.lights.truncate(1),
            |data| data.camera.eye.x += 1e-6,
            |data| data.settings.seed += 1,
        ];
        let mut hashes: Vec<String> = changes.into_iter().map(hash).collect();
        hashes.push(scene_hash(&data, &DevelopSettings { exposure: 1.0, ..develop }));
        hashes.push(scene_hash(&data, &DevelopSettings { tone_curve: ToneCurve::Agx, ..develop }));
        hashes.push(plain);
        let count = hashes.len();
        hashes.sort();
        hashes.dedup();
        assert_eq!(hashes.len(), count);
    }
}
