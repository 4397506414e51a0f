//! The crate `gltf` as a second opinion: what both it and `document` read is equal.

mod items;
mod materials;
mod scenes;

use super::fuzz;
use crate::files::gltf::container;
use crate::files::gltf::document::{Document, Index};
use gltf::json::{self, Root, validation::Checked};
use proptest::prelude::*;
use std::fmt::Debug;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Compares all that both read. `{:?}` has all bits of a number, also the sign of zero.
fn agree(ours: &Document, theirs: &Root) {
    same(
        "the file",
        (
            (&ours.asset.version, index(ours.scene), &ours.extensions_used, &ours.extensions_required),
            (ours.accessors.len(), ours.animations.len(), ours.buffers.len(), ours.buffer_views.len()),
            (ours.cameras.len(), ours.images.len(), ours.materials.len(), ours.meshes.len()),
            (ours.nodes.len(), ours.samplers.len(), ours.scenes.len(), ours.textures.len()),
        ),
        (
            (
                &theirs.asset.version,
                crate_index(theirs.scene),
                &theirs.extensions_used,
                &theirs.extensions_required,
            ),
            (
                theirs.accessors.len(),
                theirs.animations.len(),
                theirs.buffers.len(),
                theirs.buffer_views.len(),
            ),
            (theirs.cameras.len(), theirs.images.len(), theirs.materials.len(), theirs.meshes.len()),
            (theirs.nodes.len(), theirs.samplers.len(), theirs.scenes.len(), theirs.textures.len()),
        ),
    );
    items::agree(ours, theirs);
    materials::agree(ours, theirs);
    scenes::agree(ours, theirs);
}

fn same(place: &str, ours: impl Debug, theirs: impl Debug) {
    assert_eq!(format!("{ours:?}"), format!("{theirs:?}"), "{place}");
}

fn index(ours: Option<Index>) -> Option<usize> {
    ours.map(Index::value)
}

fn crate_index<T>(theirs: Option<json::Index<T>>) -> Option<usize> {
    theirs.map(|index| index.value())
}

/// A value of an enumeration; `None` where the crate does not know it.
fn known<T>(theirs: &Checked<T>) -> Option<&T> {
    match theirs {
        Checked::Valid(value) => Some(value),
        Checked::Invalid => None,
    }
}

/// All glTF files below a folder, in a fixed order.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    for path in entries.map(|entry| entry.unwrap().path()) {
        if path.is_dir() {
            found.extend(files(&path));
        } else if path.extension().is_some_and(|e| e == "gltf" || e == "glb") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// Reads all files below a folder both ways; how many there are.
fn compare(folder: &Path) -> usize {
    let all = files(folder);
    for path in &all {
        eprintln!("{}", path.display());
        let bytes = std::fs::read(path).unwrap();
        let container = container::split(&bytes).unwrap();
        if container.is_glb {
            let glb = gltf::Glb::from_slice(&bytes).unwrap();
            assert!(container.json == &*glb.json && container.binary == glb.bin.as_deref());
        }
        let ours = Document::from_slice(container.json).unwrap();
        let theirs = Root::from_slice(container.json).unwrap();
        agree(&ours, &theirs);
    }
    all.len()
}

#[test]
fn files_of_the_repository() {
    let count = compare(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes"));
    assert!(count > 0);
}

#[test]
fn files_of_the_standard_test_scenes() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/scenes");
    if folder.is_dir() {
        assert!(compare(&folder) > 0);
    } else {
        // A clone alone does not have them. Written past the harness, which keeps what passing tests print to itself.
        let line = format!("SKIPPED files_of_the_standard_test_scenes: {} is not there\n", folder.display());
        let _ = std::io::stderr().write_all(line.as_bytes());
    }
}

#[test]
fn a_file_that_uses_nearly_everything() {
    let json = fuzz::json();
    agree(&Document::from_slice(json.as_bytes()).unwrap(), &Root::from_slice(json.as_bytes()).unwrap());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, ..ProptestConfig::default() })]

    /// Numbers beyond those of an index are not among them: the crate cuts them to 32 bits.
    #[test]
    fn what_the_crate_reads_of_a_changed_file_is_read_alike(
        edits in fuzz::edits(&[
            "0", "-0.0", "1", "2", "3", "4", "5", "7", "255", "-1", "1e30", "1e-30", "5120", "5121", "5125", "9728",
            "33648", "4294967295", "0.1", "null", "[]", "\"LINEAR\"", "true", "{}",
        ]),
    ) {
        // The crate keeps this extension as it is; its indices are checked here.
        let json = fuzz::renumbered(edits).replace("EXT_mesh_gpu_instancing", "EXT_another");
        if let Ok(theirs) = Root::from_slice(json.as_bytes()) {
            agree(&Document::from_slice(json.as_bytes()).unwrap(), &theirs);
        }
    }
}
