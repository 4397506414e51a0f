//! The scene of a command, with all that its flags change.

use super::pg1_config;
use crate::arguments::{CameraFlags, PictureFlags, RenderFlags, SettingsFlags, TextureFlags};
use crate::failure::Failure;
use crate::outputs::is_stdout;
use crate::streams::Verbosity;
use eosphor::job::check_sources;
use eosphor::{Scene, load};
use std::path::{Path, PathBuf};

/// The scene with everything that the flags change.
pub(super) fn load_scene(flags: &RenderFlags, notes: &mut Vec<String>) -> Result<Scene, Failure> {
    let options = flags.settings.load_options(flags.camera.choice(), &flags.picture, &flags.textures);
    let loaded = load(&flags.scene, &options)?;
    notes.extend(loaded.warnings.iter().map(ToString::to_string));
    let mut scene = loaded.scene;
    let files: Vec<&Path> =
        flags.outputs.iter().map(PathBuf::as_path).filter(|output| !is_stdout(output)).collect();
    let mut sources = loaded.files_read;
    sources.extend(flags.picture.lights.environment_file().map(Path::to_path_buf));
    check_sources(&sources, &files)?;
    for path in &sources {
        flags.report.verbosity().say(Verbosity::Verbose, &format!("read {}", path.display()));
    }
    flags.animation.apply(&mut scene)?;
    apply(&mut scene, &flags.picture, &flags.settings, &flags.camera, &flags.textures)?;
    flags.device.check_paths()?;
    scene.settle_orbit()?;
    pg1_config::tell(flags, &scene);
    Ok(scene)
}

/// Changes a scene as flags say.
pub(super) fn apply(
    scene: &mut Scene,
    picture: &PictureFlags,
    settings: &SettingsFlags,
    camera: &CameraFlags,
    textures: &TextureFlags,
) -> Result<(), Failure> {
    if let Some(preset) = picture.preset {
        preset.apply(scene);
    }
    settings.apply(&mut scene.settings);
    settings.check(&scene.settings)?;
    if let Some(offset) = picture.translate {
        scene.move_geometry(offset);
    }
    picture.lights.apply(scene, textures.memory_bytes())?;
    camera.apply(scene)?;
    // The file was valid by itself: what is out of range now came with a flag.
    scene.validate().map_err(Failure::usage)
}
