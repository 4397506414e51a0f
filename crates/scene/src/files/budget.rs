//! How much memory textures may take.

use crate::error::SceneError;

/// The texels of a scene in the making, counted before they are decoded. The first picture beyond the limit fails the
/// load, but only at its end: then what all of them need is known and can be said.
pub(super) struct Budget {
    /// `None`: no limit.
    limit_bytes: Option<u64>,
    needed_bytes: u64,
    /// The first picture that did not fit, for the message.
    first_beyond: Option<String>,
}

impl Budget {
    pub(super) fn new(limit_bytes: Option<u64>) -> Budget {
        Budget { limit_bytes, needed_bytes: 0, first_beyond: None }
    }

    /// Counts a picture; whether it may be decoded. After one that may not, none may.
    pub(super) fn admits(&mut self, bytes: u64, name: impl FnOnce() -> String) -> bool {
        self.needed_bytes = self.needed_bytes.saturating_add(bytes);
        if self.first_beyond.is_none() && self.limit_bytes.is_some_and(|limit| self.needed_bytes > limit) {
            self.first_beyond = Some(name());
        }
        self.first_beyond.is_none()
    }

    /// Takes back what was counted for a picture that is broken.
    pub(super) fn release(&mut self, bytes: u64) {
        self.needed_bytes -= bytes;
    }

    /// Fails where a picture did not fit.
    pub(super) fn check(self) -> Result<(), SceneError> {
        match (self.first_beyond, self.limit_bytes) {
            (Some(picture), Some(budget_bytes)) => {
                Err(SceneError::TextureMemory { picture, needed_bytes: self.needed_bytes, budget_bytes })
            }
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::{LoadOptions, load, load_from_memory};
    use crate::{LoadedScene, SceneError};

    /// 2 x 2 texels of three bytes: 12 bytes.
    const FOUR: &str = "P3 2 2 255 0 0 0 1 1 1 2 2 2 3 3 3";
    /// Its head is right, its texels are not.
    const BROKEN: &str = "P3 2 2 255 0 0 0 1 1 1 x x x x x x x x";

    fn options(texture_memory_bytes: u64) -> LoadOptions {
        LoadOptions { texture_memory_bytes: Some(texture_memory_bytes), ..LoadOptions::default() }
    }

    fn read(files: &[(&str, &str)], limit_bytes: u64) -> Result<LoadedScene, SceneError> {
        let files = files
            .iter()
            .map(|(name, text)| (name.into(), text.as_bytes().to_vec()))
            .collect::<Vec<(std::path::PathBuf, Vec<u8>)>>();
        let first = files[0].0.clone();
        load_from_memory(files, first, &options(limit_bytes))
    }

    /// Files of each kind that read `a.ppm` and `b.ppm`.
    fn models() -> [Vec<(&'static str, &'static str)>; 3] {
        let obj = "mtllib m.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nusemtl b\nf 1 2 3\n";
        let mtl = "newmtl a\nmap_Kd a.ppm\nnewmtl b\nmap_Kd b.ppm\n";
        let json = r#"{ "eosphor": 2, "materials": {
            "a": { "matte": { "color": [1, 1, 1] }, "texture": "a.ppm" },
            "b": { "matte": { "color": [1, 1, 1] }, "texture": "b.ppm" } },
            "spheres": [{ "center": [0, 0, 0], "radius": 1, "material": "a" },
                        { "center": [0, 0, 3], "radius": 1, "material": "b" }] }"#;
        let gltf = r#"{ "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
            "buffers": [{ "byteLength": 36,
                "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA" }],
            "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
            "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                "min": [0, 0, 0], "max": [1, 1, 0] }],
            "images": [{ "uri": "a.ppm" }, { "uri": "b.ppm" }], "textures": [{ "source": 0 }, { "source": 1 }],
            "materials": [{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } },
                          { "pbrMetallicRoughness": { "baseColorTexture": { "index": 1 } } }],
            "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "material": 0 },
                                        { "attributes": { "POSITION": 0 }, "material": 1 }] }] }"#;
        [vec![("s.obj", obj), ("m.mtl", mtl)], vec![("s.json", json)], vec![("s.gltf", gltf)]]
    }

    #[test]
    fn files_of_all_kinds_keep_to_it() {
        for model in models() {
            let name = model[0].0;
            let with = |a, b| [&model[..], &[("a.ppm", a), ("b.ppm", b)]].concat();
            let loaded = read(&with(FOUR, FOUR), 24).unwrap();
            assert_eq!(loaded.scene.images.len(), 2, "{name}");
            let bytes: u64 = loaded.scene.images.iter().map(|i| i.texels.bytes()).sum();
            assert_eq!(bytes, 24, "{name}: {:?}", loaded.warnings);
            for (limit, first) in [(23, "b.ppm"), (12, "b.ppm"), (11, "a.ppm"), (0, "a.ppm")] {
                // What does not fit is not decoded: that it is broken is not even found.
                let b = if limit < 12 { FOUR } else { BROKEN };
                match read(&with(FOUR, b), limit).unwrap_err() {
                    SceneError::TextureMemory { picture, needed_bytes, budget_bytes } => {
                        assert_eq!(
                            (picture.as_str(), needed_bytes, budget_bytes),
                            (first, 24, limit),
                            "{name}"
                        );
                    }
                    other => panic!("{name}: {other}"),
                }
            }
            // What is broken takes nothing.
            if name != "s.json" {
                let loaded = read(&with(BROKEN, FOUR), 24).unwrap();
                assert_eq!(loaded.scene.images.len(), 1, "{name}");
            }
        }
    }

    #[test]
    fn built_in_pictures_count() {
        let error = load("builtin:solids", &options(1 << 20)).unwrap_err().to_string();
        let expected = "builtin:solids: parquet: all textures together need 4.0 MiB (4194304 bytes) of memory, their \
                        budget is 1.0 MiB (1048576 bytes): ";
        assert!(error.starts_with(expected), "{error}");
        load("builtin:solids", &options(4 << 20)).unwrap();
    }

    #[test]
    fn the_first_beyond_is_named_and_all_are_counted() {
        let mut budget = Budget::new(Some(100));
        assert!(budget.admits(60, || "a".into()));
        assert!(budget.admits(40, || "broken".into()));
        budget.release(40);
        assert!(!budget.admits(41, || "b".into()));
        assert!(!budget.admits(1, || "c".into()), "what comes later may not slip through");
        let error = budget.check().unwrap_err();
        assert_eq!(
            error.to_string(),
            "b: all textures together need 102 bytes of memory, their budget is 100 bytes: give them more, \
             or use smaller pictures"
        );
    }

    #[test]
    fn without_a_limit_everything_fits() {
        let mut budget = Budget::new(None);
        assert!(budget.admits(u64::MAX, || unreachable!()) && budget.admits(1, || unreachable!()));
        assert!(budget.check().is_ok());
    }
}
