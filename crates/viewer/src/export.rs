//! What a page exports: the command line of its view, a scene file, the picture in linear colours.

use crate::client::Client;
use crate::encode;
use crate::frames::file_options;
use crate::page_view::{PageView, Show};
use crate::renderer::Shared;
use eosphor::Scene;

/// The command line that renders a page's view.
pub(crate) fn command_line(shared: &Shared, view: &PageView) -> String {
    let stage = shared.stage();
    let mut flags = Vec::new();
    if let Some(device) = &stage.device {
        flags.extend([format!("--backend={}", device.backend), format!("--accel={}", device.accel)]);
    }
    flags.extend(view.flags(&stage.scene, &stage.own));
    shared.source.command(flags)
}

/// The text of a scene file that shows what the page shows.
///
/// # Errors
///
/// Where no file can say it, in a line for readers.
pub(crate) fn scene_file(shared: &Shared, client: &Client) -> Result<String, String> {
    let view = view_of(client)?;
    let stage = shared.stage();
    let (camera, settings) = view.applied(&stage.scene, &stage.own);
    let mut shown = Scene { settings, frame: view.frame, ..(*stage.scene).clone() };
    // One that was framed for the size of the start would be framed anew for another size.
    if view.camera_of_scene(&stage.scene, &stage.own).is_none() {
        // As flags that say the whole camera do.
        shown.camera = Some(camera);
        shown.animation.iter_mut().for_each(|animation| animation.camera = None);
    }
    shared.source.scene_file(&shown).map_err(|error| error.0)
}

/// The picture at rest as the EXR that `eosphor render --no-metadata` writes.
///
/// # Errors
///
/// Where there is none, in a line for readers.
pub(crate) fn exr(shared: &Shared, client: &Client) -> Result<Vec<u8>, String> {
    let view = view_of(client)?;
    let stage = shared.stage();
    let (_, settings) = view.applied(&stage.scene, &stage.own);
    let film = {
        let state = client.state();
        let progress = state.progress.as_ref().filter(|p| p.version == stage.version && p.is_whole());
        let progress = progress.filter(|_| view.show == Show::Picture);
        progress.map(|progress| progress.sums.film(progress.samples))
    };
    let film = film.ok_or("there is no picture at rest yet; wait until all its samples are there")?;
    encode::exr(&film, &file_options(&settings)).map_err(|error| error.to_string())
}

fn view_of(client: &Client) -> Result<PageView, String> {
    let wanted = client.state().wanted;
    wanted.map(|wanted| wanted.view).ok_or_else(|| "the page shows nothing yet".to_owned())
}
