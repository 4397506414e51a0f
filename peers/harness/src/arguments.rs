//! The command line.

use std::ffi::OsString;
use std::path::PathBuf;

/// How much time a library may spend on building, where it offers a choice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quality {
    /// A fast build.
    Low,
    /// The library's middle way.
    Medium,
    /// The fastest rays, whatever the build takes.
    High,
}

/// How to measure.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Measurements of each quantity, after one that is not counted.
    pub repeats: usize,
    /// Rays in a call.
    pub batch: usize,
    /// Threads that build and trace.
    pub threads: usize,
    /// Of the structure.
    pub quality: Quality,
}

pub(crate) struct Arguments {
    pub library: String,
    pub folder: PathBuf,
    pub options: Options,
}

impl Arguments {
    pub fn parse(words: impl Iterator<Item = OsString>, names: &[&str]) -> Result<Self, String> {
        let usage = || {
            format!(
                "usage: PROGRAM LIBRARY DATA_FOLDER [--repeats N] [--batch N] [--threads N] [--quality low|medium|high]; \
                 libraries: {}",
                names.join(", ")
            )
        };
        let mut options = Options { repeats: 5, batch: 4096, threads: 1, quality: Quality::High };
        let mut places = Vec::new();
        let mut words = words;
        while let Some(word) = words.next() {
            let Some(flag) = word.to_str().filter(|word| word.starts_with("--")) else {
                places.push(word);
                continue;
            };
            let value = words.next().ok_or_else(|| format!("{flag} needs a value; {}", usage()))?;
            let value = value.to_str().ok_or_else(|| format!("{flag}: its value is not text"))?;
            match flag {
                "--repeats" => options.repeats = number(flag, value, 1000)?,
                "--batch" => options.batch = number(flag, value, 1 << 24)?,
                "--threads" => options.threads = number(flag, value, 1024)?,
                "--quality" => options.quality = quality(value)?,
                _ => return Err(format!("no flag is named {flag}; {}", usage())),
            }
        }
        let [library, folder] = <[OsString; 2]>::try_from(places).map_err(|_| usage())?;
        Ok(Self { library: library.to_string_lossy().into_owned(), folder: folder.into(), options })
    }
}

fn number(flag: &str, value: &str, largest: usize) -> Result<usize, String> {
    match value.parse() {
        Ok(number) if (1..=largest).contains(&number) => Ok(number),
        _ => Err(format!("{flag} {value}: a whole number from 1 to {largest} is needed")),
    }
}

fn quality(value: &str) -> Result<Quality, String> {
    match value {
        "low" => Ok(Quality::Low),
        "medium" => Ok(Quality::Medium),
        "high" => Ok(Quality::High),
        _ => Err(format!("--quality {value}: low, medium or high is needed")),
    }
}
