//! Our own scene format: JSON with a version key. scenes/README.md documents it by example, scenes/REFERENCE.md in full.
//!
//! The way of a file: text → `parse` → a tree that knows the place of everything → `check` by the schema → `format`, the
//! types that serde fills → `build` → the model.

mod base;
#[cfg(test)]
mod base_tests;
mod build;
mod check;
mod document;
mod environment;
mod far;
mod fault;
mod format;
mod material;
mod meshes;
pub(super) mod nearest;
mod parse;
mod quadrilaterals;
mod reference;
mod rules;
mod save;
#[cfg(test)]
mod save_tests;
mod schema;
#[cfg(test)]
mod schema_tests;
mod semantics;
mod solids;
#[cfg(test)]
mod solids_tests;
#[cfg(test)]
mod tests;
mod texture;
mod tree;

use super::loader::Loader;
use crate::error::SceneError;
use document::{Document, error_at};
use fault::Fault;
use format::SceneFile;
use std::path::Path;
use tree::{Node, Value};

pub(super) use fault::quoted;
pub use reference::scene_reference;
pub use save::{CannotSave, scene_over_base};
pub use schema::scene_schema;

/// The version of the format. The one before, [`OLD_VERSION`], differs by the default units of light.
const VERSION: f64 = 2.0;

/// Read too: its lights were not physical.
const OLD_VERSION: u32 = 1;

/// Reads a JSON scene into the loader.
pub(super) fn read(loader: &mut Loader, path: &Path) -> Result<(), SceneError> {
    let bytes = loader.read(path)?;
    let text =
        std::str::from_utf8(&bytes).map_err(|problem| not_utf8(path, &bytes[..problem.valid_up_to()]))?;
    let document = Document::of(path, text.strip_prefix('\u{feff}').unwrap_or(text))?;
    let mut file = file_of(&document)?;
    let mut builder = build::Builder { loader, document: &document };
    match file.base.take() {
        Some(base) => builder.build_over(&base, file),
        None => builder.build(file),
    }
}

impl<'a> Document<'a> {
    /// A file whose form is right, by its text.
    fn of(path: &'a Path, text: &'a str) -> Result<Document<'a>, SceneError> {
        let root = parse::parse(text)
            .and_then(|root| check_version(&root).map(|()| root))
            .and_then(|root| check::check(&rules::RULES, &root).map(|()| root))
            .map_err(|fault| error_at(path, text, fault))?;
        Ok(Document { path, text, root })
    }
}

fn file_of(document: &Document) -> Result<SceneFile, SceneError> {
    serde_json::from_str(document.text).map_err(|problem| {
        let message = format!("the file does not follow the format ({problem}); see scenes/REFERENCE.md");
        document.error(document.root.at, message)
    })
}

/// The version is looked at before anything else, so that a newer file fails for that and not for a new key.
fn check_version(root: &Node) -> Result<(), Fault> {
    let Some(version) = root.get("eosphor") else {
        let message = "this is no Eosphor scene; it needs the key \"eosphor\": 2";
        return Err(Fault::new(root.at, message));
    };
    match &version.value {
        Value::Number(number, _) if *number == VERSION || *number == f64::from(OLD_VERSION) => Ok(()),
        Value::Number(_, word) => {
            let message = format!(
                "this is version {} of the format; the program reads versions {OLD_VERSION} and {VERSION}",
                short(word)
            );
            Err(Fault::new(version.at, message))
        }
        _ => Err(Fault::new(version.at, format!("\"eosphor\" must be the version of the format, {VERSION}"))),
    }
}

/// A number of the file, cut where it is long.
fn short(word: &str) -> String {
    quoted(word).trim_matches('"').to_owned()
}

fn not_utf8(path: &Path, valid: &[u8]) -> SceneError {
    let text = String::from_utf8_lossy(valid);
    error_at(path, &text, Fault::new(text.len(), "the file is not UTF-8 text; save it as UTF-8"))
}
