//! Paths of numbered frames.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

/// A path with a place for the frame's number, as C's printf has it: `%d`, or `%04d` for at least four digits. `%%` is a
/// percent sign.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CoursePattern {
    /// As written.
    text: String,
    before: String,
    /// The least number of digits.
    digits: usize,
    after: String,
}

/// A path that does not number frames.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("\"{0}\" must have one %d (or %04d, %% for a percent sign) for the number of the frame")]
pub struct WrongCoursePattern(pub String);

impl CoursePattern {
    /// The number between two texts, which hold no percent sign.
    pub(super) fn numbered(before: &str, after: &str) -> CoursePattern {
        let text = format!("{before}%d{after}");
        CoursePattern { text, before: before.into(), digits: 0, after: after.into() }
    }

    /// The path of a frame.
    pub fn path(&self, frame: u32) -> PathBuf {
        let CoursePattern { before, digits, after, .. } = self;
        PathBuf::from(format!("{before}{frame:0digits$}{after}"))
    }
}

impl FromStr for CoursePattern {
    type Err = WrongCoursePattern;
    fn from_str(text: &str) -> Result<CoursePattern, WrongCoursePattern> {
        let wrong = || WrongCoursePattern(text.chars().take(200).collect());
        let mut parts = vec![String::new()];
        let mut digits = 0;
        let mut letters = text.chars();
        while let Some(letter) = letters.next() {
            let last = parts.len() - 1;
            if letter != '%' {
                parts[last].push(letter);
                continue;
            }
            match letters.next().ok_or_else(wrong)? {
                '%' => parts[last].push('%'),
                'd' => parts.push(String::new()),
                '0' => {
                    let width = letters.next().and_then(|digit| digit.to_digit(10)).ok_or_else(wrong)?;
                    if letters.next() != Some('d') {
                        return Err(wrong());
                    }
                    digits = width as usize;
                    parts.push(String::new());
                }
                _ => return Err(wrong()),
            }
        }
        match <[String; 2]>::try_from(parts) {
            Ok([before, after]) if !text.contains('\0') => {
                Ok(CoursePattern { text: text.into(), before, digits, after })
            }
            _ => Err(wrong()),
        }
    }
}

impl fmt::Display for CoursePattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_have_their_numbers() {
        let path = |pattern: &str, frame| pattern.parse::<CoursePattern>().unwrap().path(frame);
        assert_eq!(path("out/img_%d.data", 7), PathBuf::from("out/img_7.data"));
        assert_eq!(path("%04d", 12), PathBuf::from("0012"));
        assert_eq!(path("100%%_%05d.png", 123_456), PathBuf::from("100%_123456.png"));
        for wrong in ["a.data", "%d%d", "%", "%s", "%4d", "%0d", "%0", "%dd%", "%-3d", "\0%d"] {
            let error = wrong.parse::<CoursePattern>().unwrap_err().to_string();
            assert!(error.contains("must have one %d"), "{error}");
        }
    }
}
