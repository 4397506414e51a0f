//! What the camera rays of each pixel cost, as a picture in false colours.

use super::file_options::{FileOptions, of_format};
use super::output::{check_apart, check_writable};
use super::still::not_cancelled;
use super::{Event, JobControl, JobError, Output, memory};
use eosphor_picture::CostMap;
use eosphor_picture::output::{DevelopSettings, Format, SaveOptions};
use eosphor_render::{CpuBackend, CpuOptions, HierarchyStatistics};
use eosphor_scene::{Scene, SceneData};
use std::sync::Arc;

/// A picture of what the camera rays of each pixel cost: nodes and primitive tests of the scalar traversal, from dark to bright.
/// It is of the CPU's work, and depends on the hierarchy.
pub struct CostPicture<'a> {
    /// What the rays are sent into.
    pub scene: &'a Scene,
    /// The files or streams that the picture is written to: at least one.
    pub outputs: Vec<Output>,
    /// What the files are like; layers and alpha are not for this picture.
    pub file: FileOptions,
    /// Nodes and tests that the brightest colour stands for; `None`: what one pixel of a thousand exceeds.
    pub brightest: Option<u32>,
    /// The hierarchy, and the threads that trace.
    pub cpu: CpuOptions,
    /// Rows that are traced at a time; `None`: about 4 million pixels.
    pub most_rows: Option<u32>,
}

/// What became of a picture of costs.
#[derive(Clone, Debug)]
pub struct CostOutcome {
    /// False where the job was cancelled: nothing was written, as costs are shown of whole pictures.
    pub complete: bool,
    /// Nodes and tests that the brightest colour stands for.
    pub brightest: u32,
    /// Nodes and tests of a pixel's camera rays: the mean over the pixels.
    pub mean: f64,
    /// Nodes visited and primitives tested for the most expensive pixel.
    pub largest: u32,
    /// Size, depth and build time of the hierarchy.
    pub hierarchy: HierarchyStatistics,
}

impl<'a> CostPicture<'a> {
    /// The costs of a scene under the default hierarchy, without outputs yet.
    pub fn new(scene: &'a Scene) -> CostPicture<'a> {
        CostPicture {
            scene,
            outputs: Vec::new(),
            file: FileOptions::default(),
            brightest: None,
            cpu: CpuOptions::default(),
            most_rows: None,
        }
    }

    /// Traces the rays and writes the files. Folders that are missing are made.
    ///
    /// # Errors
    ///
    /// Where the scene is out of range, an output cannot be written or is named twice, or the memory is too small;
    /// [`JobError::Cancelled`] where the job was cancelled before anything was begun.
    pub fn run(self, control: &JobControl) -> Result<CostOutcome, JobError> {
        if self.outputs.is_empty() {
            return Err(JobError::NoOutput);
        }
        check_apart(&self.outputs)?;
        check_writable(&self.outputs)?;
        let size = self.scene.settings.size.into();
        let bands = memory::bands(size, false, self.most_rows)?;
        not_cancelled(control)?;
        let (data, notes) = SceneData::flatten(self.scene)?;
        control.tell(Event::Flattened(&notes));
        let formats: Vec<Format> = self.outputs.iter().map(Output::format).collect();
        let options = self.file.save_options((self.scene, &data), &formats, None);
        // The colours are meant as they are: neither the scene's exposure nor its curve is for them.
        let options =
            SaveOptions { develop: DevelopSettings::default(), layers: Vec::new(), alpha: None, ..options };
        let pass = CpuBackend::new(self.cpu)?.feature_pass(Arc::new(data), None)?;
        let mut work = Vec::new();
        for rows in bands {
            work.extend(pass.rows(rows, None, control.cancel.asked())?.work);
            if control.cancel.is_asked() {
                let (hierarchy, complete) = (pass.hierarchy_statistics(), false);
                return Ok(CostOutcome { complete, brightest: 0, mean: 0.0, largest: 0, hierarchy });
            }
        }
        let CostMap { film, brightest, mean, largest } = CostMap::new(&work, size.0, self.brightest);
        for output in self.outputs {
            output.make_folder()?;
            let options = of_format(&options, output.format());
            let mut writer = output.open(size, &options, control)?;
            writer.write_rows(&film, None)?;
            writer.end(true)?;
        }
        let hierarchy = pass.hierarchy_statistics();
        Ok(CostOutcome { complete: true, brightest, mean, largest, hierarchy })
    }
}
