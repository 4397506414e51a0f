//! Words of the text, with their lines, as numbers in their ranges. Every error names line and field.

use crate::error::SceneError;
use eosphor_core::math::{Vec3, vec3};
use std::path::Path;

/// Coordinates and lengths: far less than what overflows, far more than a flight needs.
const FARTHEST: f32 = 1e9;

/// Words longer than this are cut in messages.
const SHOWN: usize = 40;

pub(super) struct Words<'a> {
    path: &'a Path,
    rest: &'a str,
    /// Of the end of what was taken, from 1.
    line: u32,
}

impl<'a> Words<'a> {
    pub(super) fn new(text: &'a str, path: &'a Path) -> Words<'a> {
        Words { path, rest: text, line: 1 }
    }

    /// The next word, if there is one.
    fn next(&mut self) -> Option<&'a str> {
        let start = self.rest.trim_start();
        let blank = &self.rest.as_bytes()[..self.rest.len() - start.len()];
        self.line = self.line.saturating_add(blank.iter().filter(|&&b| b == b'\n').count() as u32);
        let end = start.find(char::is_whitespace).unwrap_or(start.len());
        let (word, rest) = start.split_at(end);
        self.rest = rest;
        (!word.is_empty()).then_some(word)
    }

    /// The line of the word that was taken last, from 1.
    pub(super) fn line(&self) -> u32 {
        self.line
    }

    /// An error about the word that was taken last.
    pub(super) fn error(&self, field: &str, message: impl AsRef<str>) -> SceneError {
        SceneError::at(self.path, self.line, format!("{field}: {}", message.as_ref()))
    }

    pub(super) fn word(&mut self, field: &str) -> Result<&'a str, SceneError> {
        self.next().ok_or_else(|| self.error(field, "it is missing; the text ends here"))
    }

    /// A whole number in a range.
    pub(super) fn whole(&mut self, field: &str, low: u32, high: u32) -> Result<u32, SceneError> {
        let word = self.word(field)?;
        let number: i128 = match word.parse() {
            Ok(number) => number,
            Err(_) => {
                let kind = if word.parse::<f64>().is_ok() { "a whole number" } else { "a number" };
                return Err(self.error(field, format!("\"{}\" is not {kind}", shown(word))));
            }
        };
        if number < i128::from(low) || number > i128::from(high) {
            let message = format!("{} is out of range; it must be {low} to {high}", shown(word));
            return Err(self.error(field, message));
        }
        Ok(number as u32)
    }

    /// A number that `fits`; `range` says which do.
    pub(super) fn number(
        &mut self,
        field: &str,
        range: &str,
        fits: impl Fn(f32) -> bool,
    ) -> Result<f32, SceneError> {
        let word = self.word(field)?;
        match word.parse::<f32>() {
            Ok(number) if number.is_finite() && fits(number) => Ok(number),
            Ok(_) => Err(self.error(field, format!("{} is out of range; it must be {range}", shown(word)))),
            Err(_) => Err(self.error(field, format!("\"{}\" is not a number", shown(word)))),
        }
    }

    /// A number from 0 to 1.
    pub(super) fn share(&mut self, field: &str) -> Result<f32, SceneError> {
        self.number(field, "0 to 1", |x| (0.0..=1.0).contains(&x))
    }

    /// A coordinate or a length that may be negative.
    pub(super) fn coordinate(&mut self, field: &str) -> Result<f32, SceneError> {
        self.number(field, "-1e9 to 1e9", |x| x.abs() <= FARTHEST)
    }

    /// A length over 0.
    pub(super) fn length(&mut self, field: &str) -> Result<f32, SceneError> {
        self.number(field, "over 0 and at most 1e9", |x| x > 0.0 && x <= FARTHEST)
    }

    /// An angle, a phase or a frequency.
    pub(super) fn angle(&mut self, field: &str) -> Result<f32, SceneError> {
        self.number(field, "-1e6 to 1e6", |x| x.abs() <= 1e6)
    }

    pub(super) fn point(&mut self, field: &str) -> Result<Vec3, SceneError> {
        self.three(field, ["x", "y", "z"], Words::coordinate)
    }

    pub(super) fn color(&mut self, field: &str) -> Result<Vec3, SceneError> {
        self.three(field, ["red", "green", "blue"], Words::share)
    }

    /// The colour of a light, which may be brighter than white.
    pub(super) fn light_color(&mut self, field: &str) -> Result<Vec3, SceneError> {
        let component =
            |words: &mut Self, field: &str| words.number(field, "0 to 1e6", |x| (0.0..=1e6).contains(&x));
        self.three(field, ["red", "green", "blue"], component)
    }

    fn three(
        &mut self,
        field: &str,
        names: [&str; 3],
        one: impl Fn(&mut Self, &str) -> Result<f32, SceneError>,
    ) -> Result<Vec3, SceneError> {
        let mut next = |name: &str| one(self, &format!("{name} of {field}"));
        Ok(vec3(next(names[0])?, next(names[1])?, next(names[2])?))
    }

    /// Nothing may follow.
    pub(super) fn end(mut self) -> Result<(), SceneError> {
        match self.next() {
            None => Ok(()),
            Some(word) => Err(self.error(
                "after the end",
                format!(
                    "\"{}\" is too much; the root of rays a pixel is the last number. Is the number of lights right?",
                    shown(word)
                ),
            )),
        }
    }
}

/// What a message quotes of a word.
fn shown(word: &str) -> String {
    let mut letters = word.chars();
    let start: String = letters.by_ref().take(SHOWN).collect();
    if letters.next().is_some() { start + "..." } else { start }
}
