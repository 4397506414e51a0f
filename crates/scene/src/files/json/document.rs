//! A JSON file: its text, its tree, and errors that show the place.

use super::fault::Fault;
use super::tree::{Node, Step};
use crate::error::{Place, Problem, SceneError, one_line};
use crate::snippet::{Snippet, line_at};
use std::path::Path;

/// A file whose form is right.
pub(super) struct Document<'a> {
    pub(super) path: &'a Path,
    pub(super) text: &'a str,
    pub(super) root: Node<'a>,
}

/// An error at a byte of a text.
pub(super) fn error_at(path: &Path, text: &str, fault: Fault) -> SceneError {
    let (line, start) = line_at(text, fault.at);
    let column = u32::try_from(fault.at - start + 1).ok();
    SceneError::Invalid {
        place: Place { path: path.to_path_buf(), line: Some(line), column },
        message: one_line(fault.message),
        snippet: Some(Box::new(Snippet::of(text, fault.at))),
    }
}

impl Document<'_> {
    /// An error at a byte of the file.
    pub(super) fn error(&self, at: usize, message: impl Into<String>) -> SceneError {
        error_at(self.path, self.text, Fault::new(at, message))
    }

    /// The line where the file says its version.
    pub(super) fn line_of_version(&self) -> Option<u32> {
        self.root.get("eosphor").map(|version| line_at(self.text, version.at).0)
    }

    /// An error at the value that a path leads to.
    pub(super) fn error_in(&self, path: &[Step], message: impl Into<String>) -> SceneError {
        self.error(self.root.follow(path).at, message)
    }

    /// A problem of the finished scene, at the key that it speaks of. `instance` leads to the entry that placed the
    /// instance of a number.
    pub(super) fn problem<'s>(
        &self,
        problem: &Problem,
        instance: impl Fn(usize) -> Option<[Step<'s>; 2]>,
    ) -> SceneError {
        let at = self.place_of(&problem.what, instance).unwrap_or(self.root.at);
        self.error(at, problem.to_string())
    }

    /// Finds the value that a problem names, and returns where in the file it begins, in bytes. Names are such as
    /// `lights[0].color`, `settings.size (width)` or `material "glass", ior`. `None` if the file has no such material.
    fn place_of<'s>(&self, what: &str, instance: impl Fn(usize) -> Option<[Step<'s>; 2]>) -> Option<usize> {
        let (mut node, rest) = match what.strip_prefix("material ") {
            Some(named) => {
                let materials = self.root.get("materials")?.entries();
                materials.iter().find_map(|entry| {
                    let rest = named.strip_prefix(&format!("\"{}\"", entry.key))?;
                    Some((&entry.value, rest))
                })?
            }
            None => (&self.root, what),
        };
        let is_divider = |c: char| matches!(c, '.' | '[' | ']' | ',' | ' ' | '(' | ')');
        let mut list = "";
        for word in rest.split(is_divider).filter(|word| !word.is_empty()) {
            let number = word.parse::<usize>().ok();
            let next = match (number, word) {
                (Some(number), _) if list == "instances" => {
                    instance(number).map(|way| self.root.follow(&way))
                }
                (Some(number), _) => Some(node.follow(&[Step::Item(number)])),
                (None, "width") => Some(node.follow(&[Step::Item(0)])),
                (None, "height") => Some(node.follow(&[Step::Item(1)])),
                (None, word) => node.find(word),
            };
            // What is not in the file is a default, or no key at all: what holds it is near enough.
            node = next.unwrap_or(node);
            list = word;
        }
        Some(node.at)
    }
}
