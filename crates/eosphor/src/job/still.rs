//! A still, from the scene to its files.

use super::file_options::{FileOptions, of_format};
use super::files::make_folder;
use super::output::{check_apart, check_writable};
use super::seconds::timed;
use super::strips::{Done, Features, Product, Strips, share};
use super::{Event, JobControl, JobError, Output, Share, StillSeconds, memory};
use eosphor_picture::output::{Format, OutputError, PICTURE_VERSION, SaveOptions, ShareHeader, share_path};
use eosphor_picture::scene_hash;
use eosphor_picture::still::{Checkpoint, Part, SampleShare, checkpoint_path, sample_share_path};
use eosphor_render::{
    Backend, CpuBackend, CpuOptions, FeaturePass, HierarchyStatistics, PickedRows, PreparedRegion,
    PreparedRows, PreparedScene, RayStatistics, Region,
};
use eosphor_scene::{Note, Scene, SceneData};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

/// Most shares that the rows of a picture are divided into; more are of no use.
const MAX_SHARES: u32 = 500;

/// A still to be rendered, with where it goes and how. [`Still::run`] renders it.
///
/// It is rendered in strips of rows, so that it takes little memory whatever its size. What is done is kept in `OUT.part`
/// beside the first file: every [`Still::checkpoint_interval`], after an error and where the job is cancelled. The same with
/// [`Still::resume`] goes on from there. Nothing of all this changes a pixel.
pub struct Still<'a> {
    /// The scene to render.
    pub scene: &'a Scene,
    /// The backend that renders the picture.
    pub backend: &'a dyn Backend,
    /// The files or streams that the picture is written to: at least one, each in its format. A share has one output; the
    /// name of the share's file begins with that of the output.
    pub outputs: Vec<Output>,
    /// What the files are like.
    pub file: FileOptions,
    /// A part of the picture, as a picture of its own size; `None`: all of it.
    pub region: Option<Region>,
    /// A share of it; `None`: all of it.
    pub share: Option<Share>,
    /// Go on with what an earlier run of the same has done, where there is any.
    pub resume: bool,
    /// Between two writings of what is done: 60 seconds by default. The time of rendering that is lost is no longer where the
    /// process is killed.
    pub checkpoint_interval: Duration,
    /// Count nodes and tests and time searches ([`crate::RenderControl::count_work`]).
    pub count_work: bool,
    /// Rows that are in memory at a time; `None`: about 4 million pixels.
    pub most_rows: Option<u32>,
    /// Options of the CPU, which finds what layers and alpha show, whatever the backend.
    pub cpu: CpuOptions,
}

/// What became of a still.
#[derive(Clone, Debug)]
pub struct StillOutcome {
    /// Every pixel has all its samples, and the files are whole. False where the job was cancelled.
    pub complete: bool,
    /// The share of the samples that is done, 0 to 1. Where it is 0, nothing was written.
    pub done: f64,
    /// The share of the samples that an earlier run had done, 0 to 1.
    pub resumed: f64,
    /// The file that keeps what is done of a still that is not complete; `None` where nothing is kept.
    pub kept: Option<PathBuf>,
    /// The files that were written: the outputs, or partial pictures beside them, or the file of a share. Streams are not
    /// among them.
    pub written: Vec<PathBuf>,
    /// Width and height in pixels of what was rendered: the picture, a part of it, or the rows of a share.
    pub size: (u32, u32),
    /// Rays and work of this run.
    pub statistics: RayStatistics,
    /// Size, depth and build time of the hierarchy.
    pub hierarchy: HierarchyStatistics,
    /// The time that each phase took.
    pub seconds: StillSeconds,
    /// What was done about all that the scene leaves open.
    pub notes: Vec<Note>,
}

impl<'a> Still<'a> {
    /// A still of all that a scene's settings say, which goes nowhere yet.
    pub fn new(scene: &'a Scene, backend: &'a dyn Backend) -> Still<'a> {
        Still {
            scene,
            backend,
            outputs: Vec::new(),
            file: FileOptions::default(),
            region: None,
            share: None,
            resume: false,
            checkpoint_interval: Duration::from_secs(60),
            count_work: false,
            most_rows: None,
            cpu: CpuOptions::default(),
        }
    }

    /// With one more file, whose name says its format.
    ///
    /// # Errors
    ///
    /// [`OutputError::UnknownFormat`].
    pub fn to_file(mut self, path: &Path) -> Result<Still<'a>, OutputError> {
        self.outputs.push(Output::file(path)?);
        Ok(self)
    }

    /// Renders it and writes the files; the still is used up, since a stream is written once. Folders that are missing are made.
    /// Where it is cancelled, the outcome says what is kept: the pixels that are done are written beside each output
    /// (`a.partial.png`), and the rest of them is black.
    ///
    /// # Errors
    ///
    /// Where scene, part or share are out of range, an output cannot be written or is named twice, the memory is too small,
    /// `OUT.part` is of something else or in use, or the device fails; [`JobError::StillKept`] where what was done until then
    /// is kept; [`JobError::Cancelled`] where the job was cancelled before anything was begun.
    pub fn run(mut self, control: &JobControl) -> Result<StillOutcome, JobError> {
        self.check()?;
        let most_rows = memory::bands(self.size(), self.file.needs_features(), self.most_rows)?.rows();
        not_cancelled(control)?;
        let mut seconds = StillSeconds::default();
        let (data, notes) = timed(&mut seconds.flatten, || SceneData::flatten(self.scene))?;
        control.tell(Event::Flattened(&notes));
        let data = Arc::new(data);
        self.check_samples(data.settings.samples)?;
        let formats: Vec<Format> = self.outputs.iter().map(Output::format).collect();
        let save_options = || self.file.save_options((self.scene, &data), &formats, self.region);
        let options = timed(&mut seconds.write, save_options);
        not_cancelled(control)?;
        self.outputs.iter().try_for_each(Output::make_folder)?;
        let (checkpoint, product) = self.product(&data, &options, control)?;
        let prepared = timed(&mut seconds.build, || self.prepare(&data))?;
        let pass = match self.is_layered(&product) {
            false => None,
            true => Some(timed(&mut seconds.build, || self.feature_pass(data, &*prepared))?),
        };
        let (prepared, features) = rows_of(&product, prepared, pass, control)?;
        not_cancelled(control)?;
        let strips = Strips {
            prepared: &*prepared,
            features,
            count_work: self.count_work,
            most_rows,
            checkpoint_interval: self.checkpoint_interval,
            samples: checkpoint.samples(),
            control,
        };
        let Done { complete, done, resumed, kept, written, statistics } =
            strips.run(product, checkpoint, &mut seconds)?;
        let (size, hierarchy) = (prepared.size(), prepared.hierarchy_statistics());
        Ok(StillOutcome {
            complete,
            done,
            resumed,
            kept,
            written,
            size,
            statistics,
            hierarchy,
            seconds,
            notes,
        })
    }

    /// Width and height of the picture, or of the part of it.
    fn size(&self) -> (u32, u32) {
        let whole = self.scene.settings.size.into();
        self.region.map_or(whole, |region| (region.width, region.height))
    }

    /// What can be known before the scene is looked at.
    fn check(&self) -> Result<(), JobError> {
        let whole = self.scene.settings.size.into();
        if let Some(region) = self.region.filter(|region| !region.is_in(whole)) {
            return Err(JobError::NotInPicture { region, size: whole });
        }
        if self.outputs.is_empty() {
            return Err(JobError::NoOutput);
        }
        if let Some(share) = &self.share {
            self.check_share(share)?;
        }
        check_apart(&self.outputs)?;
        Ok(check_writable(&self.outputs)?)
    }

    fn check_share(&self, share: &Share) -> Result<(), JobError> {
        if self.outputs.len() > 1 || self.outputs[0].path().is_none() {
            return Err(JobError::ShareOutput);
        }
        match share {
            Share::Samples(_) if self.file.needs_features() => Err(JobError::SampleLayers),
            &Share::Rows { number, count } if number < 1 || number > count || count > MAX_SHARES => {
                Err(JobError::ShareNumber { number, count })
            }
            Share::Samples(_) | Share::Rows { .. } => Ok(()),
        }
    }

    fn check_samples(&self, all: u32) -> Result<(), JobError> {
        match &self.share {
            Some(Share::Samples(samples)) if samples.is_empty() || samples.end > all => {
                Err(JobError::NoSuchSamples { samples: samples.clone(), all })
            }
            Some(Share::Samples(_) | Share::Rows { .. }) | None => Ok(()),
        }
    }

    /// What is to be made, and what an earlier run has done of it. The outputs go into it.
    fn product(
        &mut self,
        data: &Arc<SceneData>,
        options: &SaveOptions,
        control: &JobControl,
    ) -> Result<(Checkpoint, Product), JobError> {
        let first = self.outputs.iter().find_map(|output| Some((output.path()?, output.format())));
        let Some((path, format)) = first else {
            // Nothing is kept of a picture for a stream.
            return Ok((Checkpoint::nowhere(Arc::clone(data)), self.pictures(options)));
        };
        let path = path.to_owned();
        match self.share.clone() {
            None => {
                let checkpoint = self.checkpoint(&checkpoint_path(&path), data, None, control)?;
                Ok((checkpoint, self.pictures(options)))
            }
            Some(Share::Samples(samples)) => {
                let share = SampleShare {
                    samples,
                    all: data.settings.samples,
                    scene: scene_hash(data, &options.develop),
                    options: of_format(options, format),
                };
                let path = sample_share_path(&path, &share.samples);
                Ok((self.checkpoint(&path, data, Some(share), control)?, Product::Samples))
            }
            Some(Share::Rows { number, count }) => {
                let path = share_path(&path, (number, count));
                let header = ShareHeader {
                    program: format!("Eosphor {}, pictures {PICTURE_VERSION}", env!("CARGO_PKG_VERSION")),
                    size: self.size(),
                    scene: scene_hash(data, &options.develop),
                    options: options.clone(),
                    share: (number, count),
                };
                make_folder(&path)?;
                let checkpoint = self.checkpoint(&checkpoint_path(&path), data, None, control)?;
                Ok((checkpoint, Product::Rows(path, Box::new(header))))
            }
        }
    }

    fn pictures(&mut self, options: &SaveOptions) -> Product {
        let with_options = |output: Output| {
            let options = of_format(options, output.format());
            (output, options)
        };
        Product::Pictures(std::mem::take(&mut self.outputs).into_iter().map(with_options).collect())
    }

    /// What an earlier run has done, where it is to be gone on with.
    fn checkpoint(
        &self,
        path: &Path,
        data: &Arc<SceneData>,
        samples: Option<SampleShare>,
        control: &JobControl,
    ) -> Result<Checkpoint, JobError> {
        let is_samples = samples.is_some();
        let rows = match self.share {
            Some(Share::Rows { number, count }) => Some((number, count)),
            Some(Share::Samples(_)) | None => None,
        };
        let part = Part { region: self.region, rows };
        let of = (Arc::clone(data), part);
        let checkpoint = Checkpoint::open(path, of, samples, self.checkpoint_interval, self.resume)?;
        match self.resume {
            true if checkpoint.is_kept() => {
                let done = share(checkpoint.samples_done(), checkpoint.samples_total());
                control.tell(Event::Resumed { done });
            }
            true => control.tell(Event::NothingToResume { checkpoint: path }),
            false if checkpoint.has_other() && !is_samples => {
                control.tell(Event::CheckpointFound { checkpoint: path });
            }
            false => {}
        }
        Ok(checkpoint)
    }

    /// Builds the hierarchy for the picture, or the part of it.
    fn prepare(&self, data: &Arc<SceneData>) -> Result<Box<dyn PreparedScene>, JobError> {
        let whole = self.backend.prepare(Arc::clone(data))?;
        Ok(match self.region {
            Some(region) => Box::new(PreparedRegion::new(whole, region)?),
            None => whole,
        })
    }

    /// Whether any of the files has what camera rays find.
    fn is_layered(&self, product: &Product) -> bool {
        match product {
            Product::Pictures(outputs) => outputs.iter().any(|(_, options)| options.needs_features()),
            Product::Samples => false,
            Product::Rows(_, header) => header.options.needs_features(),
        }
    }

    /// What makes the layers and the alpha. Where the picture is rendered on the CPU too, they share the hierarchy.
    fn feature_pass(
        &self,
        data: Arc<SceneData>,
        prepared: &dyn PreparedScene,
    ) -> Result<FeaturePass, JobError> {
        let pass = CpuBackend::new(self.cpu)?.feature_pass(data, prepared.hierarchy())?;
        Ok(match self.region {
            Some(region) => pass.of_region(region)?,
            None => pass,
        })
    }
}

/// What is rendered of a prepared picture for a product, with its layers: all, or the rows of a share.
fn rows_of<'a>(
    product: &Product,
    prepared: Box<dyn PreparedScene>,
    pass: Option<FeaturePass>,
    control: &'a JobControl<'a>,
) -> Result<(Box<dyn PreparedScene>, Option<Features<'a>>), JobError> {
    let of_rows = |pass: FeaturePass| move |rows: Range<u32>| pass.rows(rows, None, control.cancel.overdue());
    match product {
        Product::Pictures(_) | Product::Samples => {
            Ok((prepared, pass.map(|pass| -> Features<'a> { Box::new(of_rows(pass)) })))
        }
        Product::Rows(_, header) => {
            let picked = PickedRows::new(header.bands());
            let features = pass.map(|pass| -> Features<'a> {
                let (picked, of_rows) = (picked.clone(), of_rows(pass));
                Box::new(move |rows| picked.features(&rows, &of_rows))
            });
            Ok((Box::new(PreparedRows::new(prepared, picked)?), features))
        }
    }
}

/// Ends a job between two phases.
pub(super) fn not_cancelled(control: &JobControl) -> Result<(), JobError> {
    match control.cancel.is_asked() {
        true => Err(JobError::Cancelled),
        false => Ok(()),
    }
}
