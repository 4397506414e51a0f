//! What is under a pointer: the values of a pixel, and what its camera ray finds first.

use crate::client::Client;
use crate::message::{Surface, ToPage};
use crate::page_view::{PageView, Show};
use crate::renderer::Shared;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The pixel that a page has asked for last, while it is not answered.
#[derive(Default)]
pub(crate) struct Hover(Mutex<Asked>);

#[derive(Default)]
struct Asked {
    pixel: Option<[u32; 2]>,
    /// A thread answers.
    is_answered: bool,
}

impl Hover {
    fn asked(&self) -> MutexGuard<'_, Asked> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Answers a page about a pixel, on another thread: the ray waits for threads that render. Of several questions meanwhile, the
/// newest is answered.
pub(crate) fn ask(shared: &Arc<Shared>, client: &Arc<Client>, pixel: [u32; 2]) {
    let mut asked = client.hover.asked();
    asked.pixel = Some(pixel);
    if asked.is_answered {
        return;
    }
    asked.is_answered = true;
    let (shared, client) = (Arc::clone(shared), Arc::clone(client));
    tokio::task::spawn_blocking(move || {
        loop {
            let [x, y] = {
                let mut asked = client.hover.asked();
                let Some(pixel) = asked.pixel.take() else {
                    asked.is_answered = false;
                    return;
                };
                pixel
            };
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
