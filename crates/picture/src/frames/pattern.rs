//! Names of frames: `img_%d.data`, `img_%04d.png`.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

/// The name of every frame: a path with one `%d` or `%04d` in its last part.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FramePattern {
    folder: PathBuf,
    before: OsString,
    after: OsString,
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
const MAX_DIGITS: usize = 12;

impl FramePattern {
    /// From a path.
    ///
    /// # Errors
    ///
    /// Where its last part has no `%d`, or more than one.
    pub fn new(path: &Path) -> Result<FramePattern, PatternError> {
        let problem = || PatternError { path: path.to_owned() };
        let name = path.file_name().ok_or_else(problem)?;
        let (before, rest) = split_at(name, b'%').ok_or_else(problem)?;
        let (width, after) = split_at(&rest, b'd').ok_or_else(problem)?;
        let width = width.to_str().ok_or_else(problem)?;
        let digits = if width.is_empty() { 1 } else { width.parse().map_err(|_| problem())? };
        let is_number = width.bytes().all(|byte| byte.is_ascii_digit());
        if !is_number || !(1..=MAX_DIGITS).contains(&digits) || split_at(&after, b'%').is_some() {
            return Err(problem());
        }
        Ok(FramePattern {
            folder: path.parent().unwrap_or(Path::new("")).to_owned(),
            before,
            after,
            digits,
            pattern: path.to_owned(),
        })
    }

    /// Whether a path names numbered frames: has a `%` that begins the place of a number.
    pub fn is_one(path: &Path) -> bool {
        path.file_name().is_some_and(|name| name.to_string_lossy().contains('%'))
    }

    /// The file of a frame.
    pub fn path(&self, frame: u32) -> PathBuf {
        let FramePattern { folder, before, after, digits, .. } = self;
        let mut name = before.clone();
        name.push(format!("{frame:0digits$}"));
        name.push(after);
        folder.join(name)
    }

    /// What is kept about the frames, beside them.
    pub fn manifest_path(&self) -> PathBuf {
        let mut name = self.pattern.clone().into_os_string();
        name.push(".manifest");
        name.into()
    }
}

/// What is before the first of these letters of ASCII, and what is after it. Names need not be Unicode.
#[cfg(unix)]
fn split_at(name: &OsStr, letter: u8) -> Option<(OsString, OsString)> {
    use std::os::unix::ffi::OsStrExt;
    let bytes = name.as_bytes();
    let middle = bytes.iter().position(|&byte| byte == letter)?;
    let part = |bytes| OsStr::from_bytes(bytes).to_owned();
    Some((part(&bytes[..middle]), part(&bytes[middle + 1..])))
}

/// The same where the standard library takes names apart as Unicode alone.
#[cfg(not(unix))]
fn split_at(name: &OsStr, letter: u8) -> Option<(OsString, OsString)> {
    let (before, after) = name.to_str()?.split_once(char::from(letter))?;
    Some((before.into(), after.into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn names_need_not_be_unicode() {
        use std::os::unix::ffi::OsStrExt;
        let path = |bytes| Path::new(OsStr::from_bytes(bytes));
        let pattern = FramePattern::new(path(b"out/\xff%02d\xfe.png")).unwrap();
        assert_eq!(pattern.path(7), path(b"out/\xff07\xfe.png"));
        assert_eq!(pattern.manifest_path(), path(b"out/\xff%02d\xfe.png.manifest"));
    }

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
