//! Errors of configurations: where, what, and what it should be.

use crate::error::{Place, Problem, SceneError};
use crate::files::json::nearest;
use std::path::Path;

pub(super) fn at(path: &Path, line: Option<u32>, message: String) -> SceneError {
    SceneError::invalid(Place { line, ..Place::file(path) }, message)
}

/// serde_json's message in our form; an unknown name gets the nearest known one.
pub(super) fn wrong(path: &Path, error: &serde_json::Error) -> SceneError {
    if error.is_eof() {
        return at(path, None, "the file ends within its JSON; get it again".into());
    }
    let whole = error.to_string();
    let suffix = format!(" at line {} column {}", error.line(), error.column());
    let plain = whole.strip_suffix(&suffix).unwrap_or(&whole);
    let message = unknown_name(plain).unwrap_or_else(|| plain.replace('`', "\""));
    at(path, u32::try_from(error.line()).ok().filter(|&line| line > 0), message)
}

/// From "unknown field `x`, expected one of `y`, `z`".
fn unknown_name(message: &str) -> Option<String> {
    let (kind, rest) =
        match (message.strip_prefix("unknown field `"), message.strip_prefix("unknown variant `")) {
            (Some(rest), _) => ("key", rest),
            (_, Some(rest)) => ("value", rest),
            _ => return None,
        };
    let mut names = rest.split('`').step_by(2).filter(|name| !name.is_empty());
    let name = names.next()?;
    let known: Vec<&str> = names.collect();
    let hint = match nearest::nearest(name, known.iter().copied()) {
        Some(near) => format!("did you mean \"{near}\"?"),
        None => format!("PG1 has \"{}\" here", known.join("\", \"")),
    };
    Some(format!("unknown {kind} \"{name}\"; {hint}"))
}

/// A setting out of range, by the name that it has in the file.
pub(super) fn problem(path: &Path, text: &str, problem: &Problem) -> SceneError {
    let key = match problem.what.as_str() {
        "settings.size (width)" => "width",
        "settings.size (height)" => "height",
        "settings.samples" => "samples_per_pixel",
        "settings.light-samples" => "samples_per_triangle",
        "settings.depth" => "max_depth",
        "settings.max-distance" => "max_distance",
        "settings.background" => "background_color",
        "camera" => "camera",
        _ => return at(path, None, problem.to_string()),
    };
    at(path, line_of_key(text, key), format!("{key}: {}", problem.message))
}

/// The line of the first key of this name, from 1.
pub(super) fn line_of_key(text: &str, key: &str) -> Option<u32> {
    let quoted = format!("\"{key}\"");
    let is_key = |&(at, _): &(usize, &str)| text[at + quoted.len()..].trim_start().starts_with(':');
    let (at, _) = text.match_indices(&quoted).find(is_key)?;
    u32::try_from(1 + text.as_bytes()[..at].iter().filter(|&&b| b == b'\n').count()).ok()
}
