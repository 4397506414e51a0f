//! Whether what rests on a page is what `render` writes: for the command line that the page gives, and for the scene that it saves.

use crate::orbit::turned;
use crate::socket::Page;
use crate::{Result, Viewer};
use eosphor::settings::{LightingModel, ShadowMode};
use eosphor_viewer::PageView;
use std::path::Path;
use std::process::Command;
use tungstenite::Message;

/// How many of so many pictures were the same bytes.
#[derive(Default)]
pub(crate) struct Same {
    pub(crate) command_lines: u32,
    pub(crate) saved_scenes: u32,
    pub(crate) of: u32,
}

/// Views that differ from the scene's own in what people change most.
fn changed(own: &PageView) -> [PageView; 3] {
    let mut lens = turned(own, 0.4);
    (lens.camera.fov, lens.camera.aperture) = (own.camera.fov * 0.8, 0.01);
    let mut light = turned(own, -0.3);
    (light.lighting, light.shadows, light.exposure) = (LightingModel::BlinnPhong, ShadowMode::Opaque, 0.5);
    let mut size = *own;
    (size.size, size.samples, size.depth) = ([333, 187], 5, 3);
    [lens, light, size]
}

/// Compares three views of a scene with the files of `program`.
pub(crate) fn compare(program: &str, backend: &str, arguments: &[String], same: &mut Same) -> Result<()> {
    let on_backend = [arguments, &["--backend".to_owned(), backend.to_owned()]].concat();
    let (_viewer, url) = Viewer::start(program, &on_backend)?;
    let mut page = Page::connect(&url)?;
    let (scene, own) = page.scene()?;
    for view in changed(&own) {
        let (picture, _) = page.at_rest(&view)?;
        page.socket.send(Message::text(r#"{"type":"command"}"#))?;
        let command = page.text("command")?["text"].as_str().unwrap_or_default().to_owned();
        let folder = tempfile::tempdir()?;
        let file = folder.path().join("picture.png");
        let command = command.replacen("eosphor", program, 1).replace("picture.png", &file.to_string_lossy());
        same.command_lines += u32::from(is_written(&command, &file)? == picture);
        let saved = folder.path().join("scene.json");
        std::fs::write(&saved, page.download("/scene.json")?)?;
        let command = format!(
            "{program} render {} --backend {backend} --no-metadata -o {}",
            saved.display(),
            file.display()
        );
        same.saved_scenes += u32::from(is_written(&command, &file)? == picture);
        same.of += 1;
    }
    let of = same.of;
    let (lines, saved) = (same.command_lines, same.saved_scenes);
    println!("{}, {}: {lines} command lines, {saved} saved scenes of {of}", arguments[0], scene["backend"]);
    Ok(())
}

/// The file that a command line writes.
fn is_written(command: &str, file: &Path) -> Result<Vec<u8>> {
    let _ = std::fs::remove_file(file);
    let status = Command::new("sh").args(["-c", &format!("{command} -q")]).status()?;
    match status.success() {
        true => Ok(std::fs::read(file)?),
        false => Err(format!("{command}: {status}").into()),
    }
}
