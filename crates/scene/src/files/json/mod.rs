//! Our own scene format: JSON with a version key. scenes/README.md documents it by example.

mod build;
mod format;
mod material;
pub(super) mod nearest;
mod text;

use super::loader::Loader;
use crate::error::{Place, SceneError};
use serde::Deserialize;
use serde_json::Value;
use std::path::Path;

/// The version of the format that is read.
const VERSION: u64 = 1;

/// Reads a JSON scene into the loader.
pub(super) fn read(loader: &mut Loader, path: &Path) -> Result<(), SceneError> {
    let bytes = loader.read(path)?;
    let Ok(text) = std::str::from_utf8(&bytes) else {
        let message = "the file is not UTF-8 text; save it as UTF-8".into();
        return Err(SceneError::Invalid { place: Place::file(path), message });
    };
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    check_version(path, text)?;
    text::check_numbers(path, text)?;
    let file: format::SceneFile = serde_json::from_str(text).map_err(|e| syntax_error(path, &e))?;
    build::Builder { loader, path, text }.build(file)
}

/// The version is looked at before anything else, so that a newer file fails for that and not for a new key.
fn check_version(path: &Path, text: &str) -> Result<(), SceneError> {
    #[derive(Deserialize)]
    struct Version {
        #[serde(default)]
        eosphor: Option<Value>,
    }
    let Version { eosphor } = serde_json::from_str(text).map_err(|e| syntax_error(path, &e))?;
    let message = match eosphor {
        Some(Value::Number(n)) if n.as_u64() == Some(VERSION) => return Ok(()),
        Some(other) => format!("\"eosphor\" is {other}; this program reads version {VERSION}"),
        None => format!("this is no Eosphor scene; it needs the key \"eosphor\": {VERSION}"),
    };
    let line = text::line_of_key(text, "eosphor");
    Err(SceneError::Invalid { place: Place { line, ..Place::file(path) }, message })
}

/// serde_json's message in our form: the place first, names in straight quotes.
fn syntax_error(path: &Path, error: &serde_json::Error) -> SceneError {
    let whole = error.to_string();
    let suffix = format!(" at line {} column {}", error.line(), error.column());
    let message = whole.strip_suffix(&suffix).unwrap_or(&whole).replace('`', "\"");
    let line = u32::try_from(error.line()).ok().filter(|&l| l > 0);
    let column = u32::try_from(error.column()).ok().filter(|_| line.is_some());
    SceneError::Invalid { place: Place { path: path.to_path_buf(), line, column }, message }
}

#[cfg(test)]
mod tests;
