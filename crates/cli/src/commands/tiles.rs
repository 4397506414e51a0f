//! `eosphor render SCENE -o OUT --tiles K/N`: a share of a picture.

use super::render::{layers, open_checkpoint, prepare};
use crate::arguments::RenderFlags;
use crate::failure::Failure;
use crate::files::make_folder;
use crate::interrupt;
use crate::picture::{Features, PictureJob, Product};
use crate::progress::ProgressView;
use crate::report::Seconds;
use crate::streams::Verbosity;
use crate::text::grouped;
use eosphor::shares::{ShareHeader, share_path};
use eosphor::{
    Backend, FeaturePass, PICTURE_VERSION, PickedRows, PreparedRows, PreparedScene, Region, SaveOptions,
    SceneData, scene_hash,
};
use std::sync::Arc;
use std::time::Instant;

/// Renders a share, some of whose rows may be in memory at a time.
pub(super) fn render_share(
    flags: &RenderFlags,
    backend: &dyn Backend,
    data: Arc<SceneData>,
    options: SaveOptions,
    (share, most_rows): ((u32, u32), u32),
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
    let checkpoint = open_checkpoint(flags, flags.output(), &data, &header.options)?;
    let prepared = prepare(backend, Arc::clone(&data), flags.file.region)?;
    let features = match header.options.needs_features() {
        false => None,
        true => Some(layers(flags, data, &*prepared)?),
    };
    let picked = PickedRows::new(header.bands());
    let of_rows = |pass: FeaturePass| -> Features {
        let rows_of = move |rows| pass.rows(rows, None, interrupt::overdue());
        let picked = &picked;
        Box::new(move |rows| picked.features(&rows, &rows_of))
    };
    let prepared = PreparedRows::new(prepared, picked.clone())?;
    interrupt::check()?;
    let verbosity = flags.report.verbosity();
    let job = PictureJob {
        prepared: &prepared,
        features: features.map(of_rows),
        product: Product::Rows(&path, &header),
        count_work: false,
        most_rows,
        checkpoint_interval: flags.keep.interval(),
        samples: checkpoint.samples(),
        verbosity,
    };
    let done = job.run(checkpoint, ProgressView::new(verbosity), &mut Seconds::default())?;
    let (name, rows) = (path.display(), prepared.size().1);
    if !done.complete {
        let percent = (done.share * 100.0).floor();
        return Err(Failure::Interrupted(match done.kept {
            None => format!("interrupted: {name}: nothing was written"),
            Some(_) => format!(
                "interrupted: {name} was not written: {percent:.0} % of its samples are done; the same with --resume goes on"
            ),
        }));
    }
    let text = format!(
        "{name}: {rows} of {height} rows on {} in {:.2} s, {} rays",
        backend.describe(),
        start.elapsed().as_secs_f64(),
        grouped(done.statistics.total_rays())
    );
    verbosity.say(Verbosity::Normal, &text);
    Ok(())
}
