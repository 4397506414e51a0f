//! What the fuzz target `message` calls.

use crate::message::FromPage;
use crate::page_view::PageView;
use eosphor::{FrameStates, Scene, SceneData};

/// Takes a message of a page, up to the frame and the command line that it asks for.
///
/// # Panics
///
/// Where a view that passes the check cannot be shown, or an error says nothing: that is what is looked for.
pub fn fuzz_message(scene: &Scene, data: &SceneData, own: &PageView, bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let message = match FromPage::read(text) {
        Ok(message) => message,
        Err(error) => return assert!(!error.is_empty()),
    };
    let FromPage::View { view, .. } = message else { return };
    if let Err(error) = view.check(scene, own) {
        return assert!(!error.is_empty());
    }
    let (camera, settings) = view.applied(scene, own);
    let state = FrameStates::new(scene, data).seen_by(view.frame, Some(&camera), &settings);
    assert!(state.is_ok(), "{view:?}");
    assert!(!view.flags(scene, own).is_empty());
}
