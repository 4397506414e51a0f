//! A hash of what the pixels of a picture depend on.

use crate::output::DevelopSettings;
use eosphor_core::geometry::{Sphere, TriangleExtra, TriangleShading};
use eosphor_core::math::Vec3;
use eosphor_core::settings::Settings;
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

/// The same with other settings than the scene's own.
pub(crate) fn hash_with(scene: &SceneData, settings: &Settings, develop: &DevelopSettings) -> String {
    // Without `..`, so that a new field does not compile before it is here.
    let SceneData {
        triangles,
        spheres,
        geometries,
        instances,
        // The motions themselves are an animation's.
        instances_move: _,
        triangle_shading,
        triangle_extras,
        sphere_materials,
        materials,
        textures,
        texture_words,
        srgb_decode,
        lights,
        camera,
        settings: _,
    } = scene;
    let mut hasher = Hasher::default();
    // What can be long, number by number.
    hasher.array("triangles", triangles, |[a, b, c], words| {
        words.extend([a, b, c].into_iter().flat_map(vector))
    });
    hasher.array("spheres", spheres, |Sphere { center, radius }, words| {
        words.extend(vector(center));
        words.push(radius.to_bits());
    });
    hasher.array("shading", triangle_shading, |shading, words| {
        let TriangleShading { normals, uvs, material, extra, object } = shading;
        words.extend(normals.iter().flat_map(vector));
        words.extend(uvs.as_flattened().iter().map(|x| x.to_bits()));
        words.extend([*material, *extra, *object]);
    });
    hasher.array("extras", triangle_extras, |TriangleExtra { colors, uvs1 }, words| {
        words.extend(colors.as_flattened().iter().chain(uvs1.as_flattened()).map(|x| x.to_bits()));
    });
    hasher.array("sphere materials", sphere_materials, |&number, words| words.push(number));
    hasher.array("texture words", texture_words, |&word, words| words.push(word));
    hasher.array("sRGB", srgb_decode, |x, words| words.push(x.to_bits()));
    // The rest as the text that `Debug` makes of it: it has every field, and floats in it are exact.
    hasher.text("geometries", geometries);
    hasher.text("instances", instances);
    hasher.text("materials", materials);
    hasher.text("textures", textures);
    hasher.text("lights", lights);
    hasher.text("camera", camera);
    hasher.text("settings", settings);
    hasher.text("develop", develop);
    hasher.0.finalize().to_hex().to_string()
}

fn vector(v: &Vec3) -> [u32; 3] {
    [v.x.to_bits(), v.y.to_bits(), v.z.to_bits()]
}

#[derive(Default)]
struct Hasher(blake3::Hasher);

impl Hasher {
    /// Name and length come first, so that nothing can move from one array to the next.
    fn array<T>(&mut self, name: &str, items: &[T], words_of: impl Fn(&T, &mut Vec<u32>)) {
        self.begin(name, items.len());
        let (mut words, mut bytes) = (Vec::new(), Vec::new());
        for some in items.chunks(4096) {
            words.clear();
            bytes.clear();
            some.iter().for_each(|item| words_of(item, &mut words));
            bytes.extend(words.iter().flat_map(|word| word.to_le_bytes()));
            self.0.update(&bytes);
        }
    }

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
        hashes.push(plain);
        let count = hashes.len();
        hashes.sort();
        hashes.dedup();
        assert_eq!(hashes.len(), count);
    }
}
