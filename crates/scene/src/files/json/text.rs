//! Finding places in the text of a JSON file for errors that are noticed only after it is parsed.

use crate::error::{Place, SceneError};
use crate::model::MAX_COORDINATE;
use std::path::Path;

/// The line of the first string that is exactly `name`, from 1.
pub(super) fn line_of_string(text: &str, name: &str) -> Option<u32> {
    let quoted = serde_json::to_string(name).ok()?;
    let at = text.find(&quoted)?;
    Some(line_at(text, at))
}

/// The line of the first key `name`, from 1.
pub(super) fn line_of_key(text: &str, name: &str) -> Option<u32> {
    let quoted = format!("\"{name}\"");
    let is_key = |&(at, _): &(usize, &str)| text[at + quoted.len()..].trim_start().starts_with(':');
    let (at, _) = text.match_indices(&quoted).find(is_key)?;
    Some(line_at(text, at))
}

fn line_at(text: &str, at: usize) -> u32 {
    1 + text.as_bytes()[..at].iter().filter(|&&b| b == b'\n').count() as u32
}

/// Numbers must be within what single precision can square. This looks at the text, for it knows the places; what is
/// no number at all is left to the parser.
pub(super) fn check_numbers(path: &Path, text: &str) -> Result<(), SceneError> {
    let bytes = text.as_bytes();
    let (mut i, mut in_string, mut line, mut line_start) = (0, false, 1, 0);
    while i < bytes.len() {
        match bytes[i] {
            b'\n' => (line, line_start) = (line + 1, i + 1),
            b'\\' if in_string => i += 1,
            b'"' => in_string = !in_string,
            b'-' | b'0'..=b'9' if !in_string => {
                let is_part = |b: &u8| matches!(b, b'-' | b'+' | b'.' | b'e' | b'E' | b'0'..=b'9');
                let length = bytes[i..].iter().position(|b| !is_part(b)).unwrap_or(bytes.len() - i);
                let word = &text[i..i + length];
                if word.parse::<f64>().is_ok_and(|x| x.abs() > f64::from(MAX_COORDINATE)) {
                    let message =
                        format!("{word} is out of range; numbers must be within {MAX_COORDINATE:e}");
                    let column = u32::try_from(i - line_start + 1).ok();
                    let place = Place { path: path.to_path_buf(), line: Some(line), column };
                    return Err(SceneError::Invalid { place, message });
                }
                i += length - 1;
            }
            _ => {}
        }
        i += 1;
    }
    Ok(())
}
