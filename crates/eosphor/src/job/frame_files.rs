//! Frames as numbered files.

use super::files::{check_output, make_folder};
use super::frames::{FramePicture, FrameSink};
use super::sequence::{FlatSequence, MadeFrom};
use super::{JobControl, JobError, Sequence, SequenceOutcome};
use eosphor_picture::frames::{FramePattern, Manifest, PatternError, Wanted};
use eosphor_picture::output::{DevelopSettings, Format, SaveOptions, save_developed_within, save_within};
use std::fmt;
use std::path::{Path, PathBuf};

/// The names of numbered files, and of the account of them.
pub struct FrameNames {
    name: PathBuf,
    path_of: Box<dyn Fn(u32) -> PathBuf + Send + Sync>,
}

impl FrameNames {
    /// By a path with one `%d` or `%04d` in its last part.
    ///
    /// # Errors
    ///
    /// Where its last part has no `%d`, or more than one.
    pub fn pattern(path: &Path) -> Result<FrameNames, PatternError> {
        let pattern = FramePattern::new(path)?;
        Ok(FrameNames::new(path, move |frame| pattern.path(frame)))
    }

    /// Each frame goes to the path that `path_of` returns for its number. The account of the frames is kept in
    /// `NAME.manifest`.
    pub fn new(name: &Path, path_of: impl Fn(u32) -> PathBuf + Send + Sync + 'static) -> FrameNames {
        FrameNames { name: name.to_owned(), path_of: Box::new(path_of) }
    }

    /// The file of a frame.
    pub fn path(&self, frame: u32) -> PathBuf {
        (self.path_of)(frame)
    }

    fn manifest_path(&self) -> PathBuf {
        manifest_path(&self.name)
    }
}

impl fmt::Debug for FrameNames {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "FrameNames({})", self.name.display())
    }
}

/// The file with the account of what is done, beside an output.
pub(super) fn manifest_path(output: &Path) -> PathBuf {
    let mut name = output.as_os_str().to_owned();
    name.push(".manifest");
    name.into()
}

impl Sequence<'_> {
    /// Renders the frames and writes a file of each. The folder is made where it is missing. The same frames by the same names
    /// are of one process at a time, or of all that share them.
    ///
    /// # Errors
    ///
    /// Where the scene has no animation or not so many frames, a file cannot be written, the memory is too small, frames are in
    /// work elsewhere, those that are there were made of something else, or the device fails; [`JobError::FramesKept`] where
    /// frames were done until then; [`JobError::Cancelled`] where the job was cancelled before anything was begun.
    pub fn write_frames(
        &self,
        names: &FrameNames,
        control: &JobControl,
    ) -> Result<SequenceOutcome, JobError> {
        let range = self.range(&names.name)?;
        let first = names.path(range.start);
        check_output(&first)?;
        let format = Format::of(&first)?;
        let flat = FlatSequence::new(self, range.clone(), Some(format), control)?;
        let SaveOptions { develop: _, jpeg_quality, exr_half, layers: _, alpha: _, metadata, window: _ } =
            &flat.options;
        let identity = match &self.made_from {
            Some(MadeFrom { files, .. }) => flat.identity(files),
            None => flat.identity(&format!("{format:?} {jpeg_quality} {exr_half} {metadata:?}")),
        };
        let wanted = match self.is_shared {
            true => Wanted::Shared(range.clone()),
            false if self.resume => Wanted::Missing(range.clone()),
            false => Wanted::Anew(range.clone()),
        };
        make_folder(&first)?;
        let manifest = Manifest::open(&names.manifest_path(), &identity, wanted)?;
        let missing: Vec<u32> = range.filter(|&frame| !manifest.is_done(frame, &names.path(frame))).collect();
        let part = manifest.part();
        let sink = Files { names, part: &part, manifest: &manifest, format, options: &flat.options };
        let outcome = flat.render(&missing, &sink, None)?;
        if outcome.complete {
            manifest.finish()?;
        }
        Ok(outcome)
    }
}

/// Where frames become files.
struct Files<'a> {
    names: &'a FrameNames,
    part: &'a Path,
    manifest: &'a Manifest,
    format: Format,
    /// Of frames: without layers and alpha, which would need more than bytes.
    options: &'a SaveOptions,
}

impl FrameSink for Files<'_> {
    fn develop(&self) -> Option<DevelopSettings> {
        (!self.format.is_linear() && !self.options.needs_features()).then_some(self.options.develop)
    }

    fn take(&self, frame: u32, picture: FramePicture) -> Result<(), JobError> {
        let path = self.names.path(frame);
        match picture {
            FramePicture::Film(rendered) => save_within(self.part, &rendered.film, &path, self.options)?,
            FramePicture::Bytes(rendered) => {
                save_developed_within(self.part, &rendered.developed(), &path, self.options)?;
            }
        }
        Ok(self.manifest.note(frame, &path)?)
    }

    fn claim(&self, frame: u32) -> Result<bool, JobError> {
        Ok(self.manifest.claim(frame, &self.names.path(frame))?)
    }
}
