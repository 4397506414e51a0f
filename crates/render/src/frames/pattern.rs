//! Names of frames: `img_%d.data`, `img_%04d.png`.

use std::path::{Path, PathBuf};

/// The name of every frame: a path with one `%d` or `%04d` in its last part.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FramePattern {
    folder: PathBuf,
    before: String,
    after: String,
    digits: usize,
    pattern: PathBuf,
}

/// Why a path is no pattern.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}: frames need names of their own: put the frame's number into the name, as in frame_%04d.png", path.display())]
pub struct PatternError {
    path: PathBuf,
}

/// The most digits that a number is filled up to.
const MOST_DIGITS: usize = 12;

impl FramePattern {
    /// From a path.
    ///
    /// # Errors
    ///
    /// Where its last part has no `%d`, or more than one.
    pub fn new(path: &Path) -> Result<FramePattern, PatternError> {
        let problem = || PatternError { path: path.to_owned() };
        let name = path.file_name().and_then(|name| name.to_str()).ok_or_else(problem)?;
        let (before, rest) = name.split_once('%').ok_or_else(problem)?;
        let (width, after) = rest.split_once('d').ok_or_else(problem)?;
        let digits = if width.is_empty() { 1 } else { width.parse().map_err(|_| problem())? };
        let is_number = width.bytes().all(|byte| byte.is_ascii_digit());
        if !is_number || !(1..=MOST_DIGITS).contains(&digits) || after.contains('%') {
            return Err(problem());
        }
        Ok(FramePattern {
            folder: path.parent().unwrap_or(Path::new("")).to_owned(),
            before: before.to_owned(),
            after: after.to_owned(),
            digits,
            pattern: path.to_owned(),
        })
    }

    /// Whether a path has the sign of a pattern.
    pub fn is_one(path: &Path) -> bool {
        path.file_name().is_some_and(|name| name.to_string_lossy().contains('%'))
    }

    /// The file of a frame.
    pub fn path(&self, frame: u32) -> PathBuf {
        let FramePattern { folder, before, after, digits, .. } = self;
        folder.join(format!("{before}{frame:0digits$}{after}"))
    }

    /// What is kept about the frames, beside them.
    pub fn manifest_path(&self) -> PathBuf {
        let mut name = self.pattern.clone().into_os_string();
        name.push(".manifest");
        name.into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_have_names() {
        let path = |pattern: &str, frame| FramePattern::new(Path::new(pattern)).unwrap().path(frame);
        assert_eq!(path("out/img_%d.data", 7), Path::new("out/img_7.data"));
        assert_eq!(path("%04d.png", 7), Path::new("0007.png"));
        assert_eq!(path("a%03db.png", 12345), Path::new("a12345b.png"));
        let pattern = FramePattern::new(Path::new("out/%d.png")).unwrap();
        assert_eq!(pattern.manifest_path(), Path::new("out/%d.png.manifest"));
    }

    #[test]
    fn what_is_no_pattern_is_refused() {
        for bad in
            ["a.png", "a%.png", "a%s.png", "a%d%d.png", "%d/a.png", "a%+4d.png", "a%99d.png", "a%0d.png", ""]
        {
            assert!(FramePattern::new(Path::new(bad)).is_err(), "{bad}");
        }
    }
}
