//! Collects warnings: repeats are counted, and a file full of oddities does not flood.

use crate::error::{Place, Warning, one_line};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Different messages that are kept; more are counted only.
const MAX_DIFFERENT: usize = 100;

#[derive(Default)]
pub(crate) struct Warnings {
    list: Vec<Warning>,
    index: HashMap<(PathBuf, String), usize>,
    left_out: u32,
}

impl Warnings {
    /// Adds a warning; an equal message about the same file is counted.
    pub(crate) fn add(&mut self, path: &Path, line: Option<u32>, message: impl Into<String>) {
        let key = (path.to_path_buf(), one_line(message));
        if let Some(&i) = self.index.get(&key) {
            self.list[i].count = self.list[i].count.saturating_add(1);
        } else if self.list.len() < MAX_DIFFERENT {
            let place = Place { line, ..Place::file(path) };
            self.list.push(Warning { place, message: key.1.clone(), count: 1 });
            self.index.insert(key, self.list.len() - 1);
        } else {
            self.left_out = self.left_out.saturating_add(1);
        }
    }

    /// All warnings in the order of their first appearance.
    pub(crate) fn finish(mut self, path: &Path) -> Vec<Warning> {
        if self.left_out > 0 {
            let message = format!("{} more warnings are left out", self.left_out);
            self.list.push(Warning { place: Place::file(path), message, count: 1 });
        }
        self.list
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repeats_are_counted_and_floods_cut() {
        let mut warnings = Warnings::default();
        let file = Path::new("a.obj");
        for line in 1..=3 {
            warnings.add(file, Some(line), "odd");
        }
        for n in 0..200 {
            warnings.add(file, None, format!("odd {n}"));
        }
        let list = warnings.finish(file);
        assert_eq!(list[0].to_string(), "a.obj:1: odd (3 times in this file)");
        assert_eq!(list.len(), MAX_DIFFERENT + 1);
        assert_eq!(list[MAX_DIFFERENT].to_string(), "a.obj: 101 more warnings are left out");
    }
}
