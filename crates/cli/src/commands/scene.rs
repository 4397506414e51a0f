//! The scene of a command, with all that its flags change.

use super::config;
use crate::arguments::{CameraFlags, PictureFlags, RenderFlags, SettingsFlags};
use crate::failure::Failure;
use crate::outputs::is_stdout;
use crate::streams::Verbosity;
use eosphor::job::check_sources;
use eosphor::math::Vec3;
use eosphor::{Animation, Camera, CameraMotion, Move, Note, Scene, SceneData, Transform, load};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The scene with everything that the flags change.
pub(super) fn load_scene(flags: &RenderFlags, notes: &mut Vec<String>) -> Result<Scene, Failure> {
    let options =
        flags.settings.load_options(flags.camera.choice(), flags.picture.are_lit(), &flags.textures);
    let loaded = load(&flags.scene, &options)?;
    notes.extend(loaded.warnings.iter().map(ToString::to_string));
    let mut scene = loaded.scene;
    let files: Vec<&Path> =
        flags.outputs.iter().map(PathBuf::as_path).filter(|output| !is_stdout(output)).collect();
    check_sources(&loaded.files_read, &files)?;
    for path in &loaded.files_read {
        flags.report.verbosity().say(Verbosity::Verbose, &format!("read {}", path.display()));
    }
    flags.animation.apply(&mut scene);
    apply(&mut scene, &flags.picture, &flags.settings, &flags.camera)?;
    settle_orbit(&mut scene)?;
    config::tell(flags, &scene);
    Ok(scene)
}

/// Changes a scene as flags say.
pub(super) fn apply(
    scene: &mut Scene,
    picture: &PictureFlags,
    settings: &SettingsFlags,
    camera: &CameraFlags,
) -> Result<(), Failure> {
    if let Some(preset) = picture.preset {
        preset.apply(scene);
    }
    settings.apply(&mut scene.settings);
    settings.check(&scene.settings)?;
    if let Some(offset) = picture.translate {
        move_all(scene, offset);
    }
    picture.lights.apply(scene)?;
    camera.apply(scene, framed_camera)?;
    // The file was valid by itself: what is out of range now came with a flag.
    scene.validate().map_err(Failure::usage)
}

/// The camera that flattening gives a scene without one.
pub(super) fn framed_camera(scene: &Scene) -> Result<Camera, Failure> {
    let (_, notes) = SceneData::flatten(scene)?;
    let camera = |note: Note| match note {
        Note::FramedCamera { camera, .. } => Some(camera),
        _ => None,
    };
    // Where there is nothing, any camera sees it.
    Ok(notes.into_iter().find_map(camera).unwrap_or_default())
}

/// A turntable about nothing in particular goes around the middle of the scene.
fn settle_orbit(scene: &mut Scene) -> Result<(), Failure> {
    let is_open =
        |animation: &Animation| matches!(animation.camera, Some(CameraMotion::Orbit { around: None, .. }));
    if scene.camera.is_some_and(|camera| camera.look_at.is_some()) {
        return Ok(());
    }
    let Some(mut animation) = scene.animation.take_if(|animation| is_open(animation)) else { return Ok(()) };
    let (data, _) = SceneData::flatten(scene)?;
    let middle = data.world_bounds().center();
    if scene.camera.is_none() {
        scene.camera = Some(Camera { look_at: Some(middle), ..framed_camera(scene)? });
    }
    if let Some(CameraMotion::Orbit { around, .. }) = &mut animation.camera {
        *around = Some(middle);
    }
    scene.animation = Some(animation);
    Ok(())
}

/// Moves all geometry.
fn move_all(scene: &mut Scene, by: [f64; 3]) {
    if scene.move_far_geometry(by) {
        return;
    }
    let offset = Vec3::from(by.map(|x| x as f32));
    let motion = Arc::new(Move { transform: Transform::translation(offset), ..Move::default() });
    for instance in &mut scene.instances {
        if !instance.moves.is_empty() {
            // What moves is moved as it comes out of its motions.
            instance.moves.push(Arc::clone(&motion));
            continue;
        }
        let Transform { translate, matrix, .. } = &mut instance.world_from_object;
        match matrix {
            // The matrix comes after the translation.
            Some(rows) => rows.iter_mut().zip(<[f32; 3]>::from(offset)).for_each(|(row, by)| row[3] += by),
            None => *translate += offset,
        }
    }
    scene.spheres.iter_mut().for_each(|sphere| sphere.center += offset);
    scene.parallelograms.iter_mut().for_each(|parallelogram| parallelogram.corner += offset);
}
