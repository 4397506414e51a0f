//! Frames of an animation, from the scene to what they are written to.

use super::frames::{FrameDone, FrameSink, Frames, FramesDone};
use super::still::not_cancelled;
use super::{Event, FileOptions, JobControl, JobError, memory};
use eosphor_picture::frames::FramesIdentity;
use eosphor_picture::output::{Format, SaveOptions};
use eosphor_picture::scene_hash;
use eosphor_render::{Backend, HierarchyStatistics, RayStatistics};
use eosphor_scene::{FrameStates, Move, Note, Scene, SceneData};
use std::collections::HashMap;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// Frames of an animation to be rendered. [`Sequence::write_frames`] writes a file of each, [`Sequence::write_video`] one of all.
///
/// What is done is kept account of, so that the same with [`Sequence::resume`] renders only what is missing, whatever ended the
/// job. Frames are the same bytes however many are in work and whoever renders them.
pub struct Sequence<'a> {
    /// What is rendered. It has an animation. Where its camera orbits around nothing in particular, [`Scene::settle_orbit`] makes
    /// that the middle of the scene; until then it is 0.
    pub scene: &'a Scene,
    /// The backend that renders the frames.
    pub backend: &'a dyn Backend,
    /// The frames, by number; `None`: all.
    pub frames: Option<Range<u32>>,
    /// What the files are like. Layers and alpha are for single pictures, and a command line would tell how often one was
    /// resumed: frames have none of them.
    pub file: FileOptions,
    /// Keep the frames that an earlier run of the same has done.
    pub resume: bool,
    /// Render the frames together with other processes that do the same, on this machine or by a shared file system: each
    /// takes those that are not done and nobody else has in work. Numbered files only.
    pub is_shared: bool,
    /// Frames that are in work at the same time; `None`: what suits the device. Fewer are where memory is short.
    pub in_flight: Option<usize>,
    /// One frame is rendered at a time, while others are developed and written, so that its time is its own.
    pub one_at_a_time: bool,
    /// Count nodes and tests and time searches ([`crate::RenderControl::count_work`]).
    pub count_work: bool,
    /// What the account is of, where it is not the scene alone that says it.
    pub made_from: Option<MadeFrom>,
}

/// What frames are made from, where a scene was made from something else that says all about them: frames that an earlier run
/// made from other texts are not kept.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MadeFrom {
    /// All that moves, in whatever words.
    pub motion: String,
    /// What numbered files are like.
    pub files: String,
}

/// What became of a sequence.
#[derive(Clone, Debug)]
pub struct SequenceOutcome {
    /// All frames are done, by whomever, and the files are whole. False where the job was cancelled.
    pub complete: bool,
    /// How many frames were wanted.
    pub wanted: usize,
    /// How many of the wanted frames an earlier run had done.
    pub kept: usize,
    /// How many frames this run has done.
    pub done: usize,
    /// How many frames other processes have done or have in work.
    pub left: usize,
    /// A video was whole before, and nothing was done.
    pub was_whole: bool,
    /// Each frame that was done now, in order.
    pub frames: Vec<FrameDone>,
    /// Rays and work of all frames that were done now.
    pub statistics: RayStatistics,
    /// The hierarchy in numbers; `None` where nothing had to be rendered.
    pub hierarchy: Option<HierarchyStatistics>,
    /// Wall-clock seconds, from building the hierarchy to the last frame.
    pub seconds: f64,
    /// What was done about all that the scene leaves open.
    pub notes: Vec<Note>,
}

impl<'a> Sequence<'a> {
    /// All frames of a scene's animation.
    pub fn new(scene: &'a Scene, backend: &'a dyn Backend) -> Sequence<'a> {
        Sequence {
            scene,
            backend,
            frames: None,
            file: FileOptions::default(),
            resume: false,
            is_shared: false,
            in_flight: None,
            one_at_a_time: false,
            count_work: false,
            made_from: None,
        }
    }

    /// The numbers of the frames that go to an output.
    pub(super) fn range(&self, output: &Path) -> Result<Range<u32>, JobError> {
        let Some(animation) = &self.scene.animation else {
            return Err(JobError::NoAnimation { output: output.to_owned() });
        };
        match &self.frames {
            None => Ok(0..animation.frames),
            Some(frames) if !frames.is_empty() && frames.end <= animation.frames => Ok(frames.clone()),
            Some(frames) => Err(JobError::NoSuchFrames { frames: frames.clone(), all: animation.frames }),
        }
    }
}

/// A sequence whose scene is flattened.
pub(super) struct FlatSequence<'a> {
    pub(super) sequence: &'a Sequence<'a>,
    pub(super) data: Arc<SceneData>,
    pub(super) notes: Vec<Note>,
    pub(super) options: SaveOptions,
    /// Format of numbered files; `None` for a video.
    pub(super) format: Option<Format>,
    /// The numbers of the frames that are wanted.
    pub(super) range: Range<u32>,
    pub(super) control: &'a JobControl<'a>,
}

impl<'a> FlatSequence<'a> {
    /// Of frames that are saved in a format, of which a video has none.
    pub(super) fn new(
        sequence: &'a Sequence<'a>,
        range: Range<u32>,
        format: Option<Format>,
        control: &'a JobControl<'a>,
    ) -> Result<FlatSequence<'a>, JobError> {
        not_cancelled(control)?;
        let (data, notes) = SceneData::flatten(sequence.scene)?;
        control.tell(Event::Flattened(&notes));
        let file =
            FileOptions { layers: Vec::new(), alpha: false, command_line: None, ..sequence.file.clone() };
        let options = file.save_options((sequence.scene, &data), format.as_slice(), None);
        Ok(FlatSequence { sequence, data: Arc::new(data), notes, options, format, range, control })
    }

    /// What the frames are made of, for files that are like this.
    pub(super) fn identity(&self, file: &str) -> FramesIdentity {
        let Sequence { scene, made_from, .. } = self.sequence;
        let [width, height] = scene.settings.size;
        let animation = match made_from {
            Some(MadeFrom { motion, .. }) => FramesIdentity::hash(motion),
            None => {
                let shapes: Vec<u64> = scene.placed_deformations().map(|d| d.fingerprint()).collect();
                // Frames of scenes without any keep the identity that they had.
                let shapes = if shapes.is_empty() { String::new() } else { format!(" {shapes:?}") };
                FramesIdentity::hash(&format!("{:?} {:?}{shapes}", scene.animation, motions(scene)))
            }
        };
        FramesIdentity {
            scene: scene_hash(&self.data, &self.options.develop),
            animation,
            file: FramesIdentity::hash(file),
            stated: vec![("size", format!("{width} x {height}"))],
        }
    }

    /// Renders the frames that are missing. `in_flight` wins over what the sequence says.
    pub(super) fn render(
        &self,
        missing: &[u32],
        sink: &dyn FrameSink,
        in_flight: Option<usize>,
    ) -> Result<SequenceOutcome, JobError> {
        let (start, all) = (Instant::now(), self.range.len());
        let kept = all - missing.len();
        if kept > 0 {
            self.control.tell(Event::FramesKept { kept, all });
        }
        if missing.is_empty() {
            return Ok(self.outcome(kept, FramesDone::default(), None, start));
        }
        let Sequence { scene, backend, count_work, one_at_a_time, .. } = *self.sequence;
        let prepared = backend.prepare(Arc::clone(&self.data))?;
        let in_flight = in_flight.or(self.sequence.in_flight).unwrap_or_else(|| backend.frames_in_flight());
        let frames = Frames {
            prepared: &*prepared,
            states: &FrameStates::new(scene, &self.data),
            frames: missing,
            in_flight: memory::frames(prepared.size(), in_flight)?,
            count_work,
            one_at_a_time,
            control: self.control,
        };
        self.control.tell(Event::RenderBegins);
        let mut done = frames.run(sink);
        // Those who had the frames that were left may be gone without having done them.
        while done.failure.is_none() && done.left > 0 && !self.control.cancel.is_asked() {
            let more = frames.run(sink);
            if more.failure.is_none() && more.count == 0 {
                break;
            }
            done.add(more);
        }
        self.control.tell(Event::RenderEnds);
        match done.failure.take() {
            Some(error) => Err(self.still_there(error, kept + done.told.len())),
            None => Ok(self.outcome(kept, done, Some(prepared.hierarchy_statistics()), start)),
        }
    }

    /// With what is left of numbered files that failed. Of a video its folder is what is left.
    fn still_there(&self, error: JobError, done: usize) -> JobError {
        match self.format.is_some() && done > 0 {
            true => {
                let (all, is_shared) = (self.range.len(), self.sequence.is_shared);
                JobError::FramesKept { error: Box::new(error), done, all, is_shared }
            }
            false => error,
        }
    }

    pub(super) fn outcome(
        &self,
        kept: usize,
        done: FramesDone,
        hierarchy: Option<HierarchyStatistics>,
        start: Instant,
    ) -> SequenceOutcome {
        let FramesDone { count, left, statistics, told, failure: _ } = done;
        SequenceOutcome {
            complete: kept + count + left >= self.range.len(),
            wanted: self.range.len(),
            kept,
            done: count,
            left,
            was_whole: false,
            frames: told,
            statistics,
            hierarchy,
            seconds: start.elapsed().as_secs_f64(),
            notes: self.notes.clone(),
        }
    }
}

/// How objects move: each motion once, as many may share one, and then the numbers of those that each instance has.
fn motions(scene: &Scene) -> (Vec<&Move>, Vec<Vec<usize>>) {
    let (mut all, mut numbers): (Vec<&Move>, _) = (Vec::new(), HashMap::new());
    let mut of_instances = Vec::with_capacity(scene.instances.len());
    for instance in &scene.instances {
        let mut own = Vec::with_capacity(instance.moves.len());
        for motion in &instance.moves {
            own.push(*numbers.entry(Arc::as_ptr(motion)).or_insert_with(|| {
                all.push(motion);
                all.len() - 1
            }));
        }
        of_instances.push(own);
    }
    (all, of_instances)
}
