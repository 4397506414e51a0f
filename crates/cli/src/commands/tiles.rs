//! `eosphor render SCENE -o OUT --tiles K/N`: a share of a picture.

use super::render::{layers, prepare};
use crate::arguments::RenderFlags;
use crate::failure::Failure;
use crate::files::make_folder;
use crate::interrupt;
use crate::progress::ProgressView;
use crate::streams::Verbosity;
use crate::text::grouped;
use eosphor::shares::{ShareHeader, ShareWriter, share_path};
use eosphor::{
    Backend, BackendError, FeatureRows, PICTURE_VERSION, Progress, Region, RenderControl, Rendered,
    SaveOptions, SceneData, scene_hash,
};
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// Bands in work at the same time: each is too small for all threads.
const AT_A_TIME: usize = 8;

pub(super) fn render_share(
    flags: &RenderFlags,
    backend: &dyn Backend,
    data: Arc<SceneData>,
    options: SaveOptions,
    share: (u32, u32),
) -> Result<(), Failure> {
    let start = Instant::now();
    let whole = || Region::whole((data.settings.width, data.settings.height));
    let Region { width, height, .. } = flags.file.region.unwrap_or_else(whole);
    let header = ShareHeader {
        program: format!("Eosphor {}, pictures {PICTURE_VERSION}", env!("CARGO_PKG_VERSION")),
        size: (width, height),
        scene: scene_hash(&data, &options.develop),
        options,
        share,
    };
    let path = share_path(flags.output(), share);
    make_folder(&path)?;
    let mut writer = ShareWriter::open(&path, &header)?;
    interrupt::note_unfinished(writer.temporary_path());
    let prepared = prepare(backend, Arc::clone(&data), flags.file.region)?;
    let features = match header.options.needs_features() {
        false => None,
        true => Some(layers(flags, data, &*prepared)?),
    };
    let bands: Vec<Range<u32>> = header.bands().collect();
    let rows: u64 = bands.iter().map(|rows| rows.len() as u64).sum();
    let (pixels_total, view) = (rows * u64::from(width), ProgressView::new(flags.report.verbosity()));
    let (pixels, rays) = (AtomicU64::new(0), AtomicU64::new(0));
    let render = |rows: Range<u32>| -> Result<(Rendered, Option<FeatureRows>), BackendError> {
        let cancel = interrupt::flag();
        let features = features.as_ref().map(|pass| pass.rows(rows.clone(), None, cancel)).transpose()?;
        let control = RenderControl { on_progress: &|_| {}, cancel, count_work: false, moment: None };
        let rendered = prepared.render_rows(rows, &control)?;
        let (more, more_rays) = (rendered.film.pixels.len() as u64, rendered.statistics.total_rays());
        view.update(Progress {
            pixels_done: pixels.fetch_add(more, Ordering::Relaxed) + more,
            pixels_total,
            rays: rays.fetch_add(more_rays, Ordering::Relaxed) + more_rays,
        });
        Ok((rendered, features))
    };
    for some in bands.chunks(AT_A_TIME) {
        let done: Vec<_> = std::thread::scope(|scope| {
            let render = &render;
            let running: Vec<_> = some.iter().map(|rows| scope.spawn(move || render(rows.clone()))).collect();
            let end = |panic| std::panic::resume_unwind(panic);
            running.into_iter().map(|band| band.join().unwrap_or_else(end)).collect()
        });
        for band in done {
            let (rendered, features) = band?;
            if !rendered.complete {
                let message = format!("interrupted: {}: nothing was written", path.display());
                return Err(Failure::Interrupted(message));
            }
            writer.write_rows(&rendered.film, features.as_ref())?;
        }
    }
    view.finish();
    writer.finish()?;
    let text = format!(
        "{}: {rows} of {height} rows on {} in {:.2} s, {} rays",
        path.display(),
        backend.describe(),
        start.elapsed().as_secs_f64(),
        grouped(rays.into_inner())
    );
    flags.report.verbosity().say(Verbosity::Normal, &text);
    Ok(())
}
