//! What is at a pixel: its values, and what its camera ray finds first.

use crate::client::Client;
use crate::message::{Surface, ToPage};
use crate::page_view::{PageView, Show};
use crate::renderer::Shared;
use std::sync::Arc;

/// Answers a page about a pixel, on another thread: the ray waits for threads that render. Of several questions meanwhile, the
/// newest is answered.
pub(crate) fn ask(shared: &Arc<Shared>, client: &Arc<Client>, pixel: [u32; 2]) {
    if !client.hover.ask(pixel) {
        return;
    }
    let (shared, client) = (Arc::clone(shared), Arc::clone(client));
    tokio::task::spawn_blocking(move || {
        while let Some([x, y]) = client.hover.next() {
            let wanted = client.state().wanted;
            if let Some(wanted) = wanted.filter(|w| x < w.view.size[0] && y < w.view.size[1]) {
                client.tell(answer(&shared, &client, &wanted.view, [x, y]));
            }
        }
    });
}

fn answer(shared: &Shared, client: &Client, view: &PageView, [x, y]: [u32; 2]) -> ToPage {
    let (linear, samples) = match linear_color(client, view, [x, y]) {
        Some((linear, samples)) => (Some(linear), samples),
        None => (None, 0),
    };
    ToPage::Pixel { x, y, linear, samples, surface: surface(shared, view, [x, y]) }
}

/// Linear colours of a pixel of the picture at rest, with the samples taken so far.
fn linear_color(client: &Client, view: &PageView, [x, y]: [u32; 2]) -> Option<([f32; 3], u32)> {
    let state = client.state();
    let progress = state.progress.as_ref().filter(|_| view.show == Show::Picture)?;
    let (width, height) = (progress.sums.width, progress.sums.height);
    if x >= width || y >= height || progress.samples == 0 {
        return None;
    }
    let mean = progress.sums.sums[y as usize * width as usize + x as usize].mean(progress.samples);
    Some(([mean.x, mean.y, mean.z], progress.samples))
}

/// What the first camera ray of a pixel finds.
fn surface(shared: &Shared, view: &PageView, [x, y]: [u32; 2]) -> Option<Surface> {
    let stage = shared.stage();
    let (mut state, _) = stage.at_rest(view).ok()?;
    state.settings.samples = 1;
    let features = stage.features().ok()?.pixel(x, y, &state).ok()?;
    if features.object == u32::MAX {
        return None;
    }
    let [object_name, material_name] = stage.names(features.object, features.material);
    Some(Surface {
        depth: features.depth,
        normal: [features.normal.x, features.normal.y, features.normal.z],
        object: features.object,
        object_name,
        material: features.material,
        material_name,
    })
}
