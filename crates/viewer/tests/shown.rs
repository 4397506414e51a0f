//! What is shown beside the picture, and what pages take with them.

use crate::page::{Page, Small, file_of, get, start};
use eosphor::job::{CostPicture, FileOptions, JobControl, Output};
use eosphor::{CpuBackend, CpuOptions, Metadata, SaveOptions, Scene, render, save};
use eosphor_viewer::{PageView, SceneSource, Show, Viewer};
use serde_json::{Value, json};
use std::path::Path;

/// A viewer with a page, the number of the page, and the view of the file.
fn open(scene: &str) -> (Viewer, Page, u64, PageView) {
    let viewer = start(Path::new(scene));
    let mut page = Page::open(&viewer);
    let message = page.text("scene");
    let view = serde_json::from_value(message["view"].clone()).unwrap();
    (viewer, page, message["page"].as_u64().unwrap(), view)
}

#[test]
fn frames_of_an_animation_are_those_of_the_animation() {
    let (_viewer, mut page, _, mut view) = open("builtin:solids");
    view.frame = 77;
    let input = page.want(&view, false);
    let (picture, _) = page.at_rest(input);
    let scene = Small("builtin:solids".into()).read().unwrap().scene;
    let frozen = Scene { camera: scene.camera_at(77), animation: None, ..scene.clone() };
    // Nothing moves there but the camera.
    assert!(picture == file_of(&frozen));
    page.say(json!({ "type": "command" }));
    let command = page.text("command")["text"].as_str().unwrap().to_owned();
    assert!(command.ends_with("--frame=77 --no-metadata -o picture.png"), "{command}");
    view.frame = scene.animation.unwrap().frames;
    page.want(&view, false);
    assert!(page.text("refused")["text"].as_str().unwrap().contains("there is no frame"));
}

#[test]
fn pages_of_paths_have_no_settings_of_whitted() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("paths.json");
    let scene = json!({ "eosphor": 2, "base": "builtin:cornell", "settings": { "integrator": "path" } });
    std::fs::write(&path, scene.to_string()).unwrap();
    let viewer = start(&path);
    let mut page = Page::open(&viewer);
    let message = page.text("scene");
    assert_eq!(message["integrator"], "path");
    let mut view: PageView = serde_json::from_value(message["view"].clone()).unwrap();
    view.light_samples += 1;
    page.want(&view, false);
    assert!(page.text("refused")["text"].as_str().unwrap().contains("path tracing"));
}

#[test]
fn costs_are_the_picture_of_costs() {
    let (_viewer, mut page, _, mut view) = open("builtin:cornell");
    view.show = Show::Cost;
    let input = page.want(&view, false);
    let (picture, _) = page.at_rest(input);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    let scene = Small("builtin:cornell".into()).read().unwrap().scene;
    let job = CostPicture {
        outputs: vec![Output::file(&path).unwrap()],
        file: FileOptions { metadata: false, ..FileOptions::default() },
        ..CostPicture::new(&scene)
    };
    job.run(&JobControl::default()).unwrap();
    assert!(picture == std::fs::read(&path).unwrap());
    page.say(json!({ "type": "command" }));
    let command = page.text("command")["text"].as_str().unwrap().to_owned();
    assert!(command.ends_with("--no-metadata --show=cost -o picture.png"), "{command}");
}

#[test]
fn normals_depths_objects_and_materials_are_shown_moving_and_at_rest() {
    let (_viewer, mut page, _, mut view) = open("builtin:cornell");
    let mut pictures = Vec::new();
    for (show, layer) in [
        (Show::Normals, "normal"),
        (Show::Depth, "depth"),
        (Show::Objects, "object"),
        (Show::Materials, "material"),
    ] {
        view.show = show;
        page.want(&view, true);
        let input = page.want(&view, false);
        let (picture, samples) = page.at_rest(input);
        assert_eq!(samples, [5]);
        // The same again is not rendered again, and is what it was.
        let input = page.want(&view, false);
        assert!(page.at_rest(input).0 == picture);
        pictures.push(picture);
        page.say(json!({ "type": "command" }));
        let command = page.text("command")["text"].as_str().unwrap().to_owned();
        assert!(command.ends_with(&format!("--layers={layer} -o picture.exr")), "{command}");
    }
    pictures.sort();
    pictures.dedup();
    assert_eq!(pictures.len(), 4);
}

#[test]
fn a_pixel_says_what_is_seen_there() {
    let (_viewer, mut page, _, view) = open("builtin:cornell");
    let input = page.want(&view, false);
    page.at_rest(input);
    let mut ask = |x: u32, y: u32| {
        page.say(json!({ "type": "pixel", "x": x, "y": y }));
        page.text("pixel")
    };
    // The middle of the back wall, whose normal points to the camera.
    let middle = ask(32, 18);
    let surface = &middle["surface"];
    let normal: Vec<f64> =
        surface["normal"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
    assert_eq!((normal[0].round(), normal[1].round(), normal[2].round()), (0.0, 0.0, 1.0));
    let depth = surface["depth"].as_f64().unwrap();
    assert!((5.0..6.0).contains(&depth), "{depth}");
    assert_eq!(surface["material-name"], "backWall");
    assert!(middle["linear"][0].as_f64().unwrap() > 0.0);
}

#[test]
fn a_lens_is_that_of_the_flags() {
    let (_viewer, mut page, _, mut view) = open("builtin:cornell");
    (view.camera.aperture, view.camera.focus_distance) = (0.125, Some(3.5));
    let input = page.want(&view, false);
    let (picture, _) = page.at_rest(input);
    let mut scene = Small("builtin:cornell".into()).read().unwrap().scene;
    let look_at = scene.point_of_file(view.camera.look_at);
    let camera = scene.camera.as_mut().unwrap();
    camera.lens = Some(eosphor::Lens { aperture_radius: 0.125, focus_distance: Some(3.5) });
    camera.look_at = Some(look_at);
    assert!(picture == file_of(&scene));
    page.say(json!({ "type": "command" }));
    let command = page.text("command")["text"].as_str().unwrap().to_owned();
    assert!(command.contains("--aperture=0.125 --focus-distance=3.5"), "{command}");
    for (aperture, focus) in [(-1.0, None), (1e30, None), (0.1, Some(0.0)), (0.1, Some(-2.0))] {
        (view.camera.aperture, view.camera.focus_distance) = (aperture, focus);
        page.want(&view, false);
        page.text("refused");
    }
}

#[test]
fn pages_take_linear_colours_and_scene_files_with_them() {
    let (viewer, mut page, number, mut view) = open("builtin:cornell");
    view.size = [40, 30];
    let (head, text) = get(&viewer, "/picture.exr?page=1");
    assert!(head.starts_with("HTTP/1.1 409"), "{head}: {}", String::from_utf8_lossy(&text));
    let input = page.want(&view, false);
    page.at_rest(input);
    let (head, exr) = get(&viewer, &format!("/picture.exr?page={number}"));
    assert!(head.starts_with("HTTP/1.1 200") && head.contains("image/x-exr"), "{head}");
    let mut scene = Small("builtin:cornell".into()).read().unwrap().scene;
    scene.settings.size = [40, 30];
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let film = render(&scene, &CpuBackend::new(CpuOptions::default()).unwrap()).unwrap().film;
    let options = SaveOptions { metadata: Metadata::default(), ..SaveOptions::from(&scene.settings) };
    save(&film, &path, &options).unwrap();
    assert!(exr == std::fs::read(&path).unwrap());

    let (head, text) = get(&viewer, &format!("/scene.json?page={number}"));
    assert!(head.starts_with("HTTP/1.1 200") && head.contains("application/json"), "{head}");
    let Scene { settings, camera, .. } = &scene;
    assert_eq!(String::from_utf8(text).unwrap(), format!("{:?} {settings:?}", camera.unwrap()));
    for path in ["/scene.json", "/scene.json?page=99", "/picture.exr?page=x"] {
        assert!(get(&viewer, path).0.starts_with("HTTP/1.1 404"), "{path}");
    }
}

/// Frames a model without a camera for the size of the start, which a page may change.
#[test]
fn a_framed_camera_is_part_of_the_scene_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.obj");
    std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let (viewer, mut page, number, mut view) = open(path.to_str().unwrap());
    for size in [view.size, [30, 60]] {
        view.size = size;
        let input = page.want(&view, false);
        let (picture, _) = page.at_rest(input);
        let (head, text) = get(&viewer, &format!("/scene.json?page={number}"));
        assert!(head.starts_with("HTTP/1.1 200"), "{size:?}: {}", String::from_utf8_lossy(&text));
        let mut scene = Small(path.clone()).read().unwrap().scene;
        scene.settings.size = size;
        scene.camera = Some(eosphor::Camera {
            position: scene.point_of_file(view.camera.eye),
            look_at: Some(scene.point_of_file(view.camera.look_at)),
            fov_x_degrees: view.camera.fov,
            ..Default::default()
        });
        assert!(picture == file_of(&scene));
    }
}

#[test]
fn another_hierarchy_shows_the_same_picture_to_all_pages() {
    let (viewer, mut page, _, view) = open("builtin:cornell");
    let mut other = Page::open(&viewer);
    other.scene();
    let input = page.want(&view, false);
    let (before, _) = page.at_rest(input);
    let choice = |accel: &str| json!({ "type": "device", "choice": { "backend": "cpu", "accel": accel } });
    page.say(choice("octree"));
    for page in [&mut page, &mut other] {
        let message: Value = page.text("scene");
        assert_eq!((&message["version"], &message["device"]["accel"]), (&json!(2), &json!("octree")));
        assert_eq!(message["take-camera"], false);
    }
    let (after, _) = page.at_rest(input);
    assert!(after == before);
    page.say(json!({ "type": "command" }));
    let command = page.text("command")["text"].as_str().unwrap().to_owned();
    assert!(command.contains("--backend=cpu --accel=octree --size="), "{command}");
    // What is not offered is refused, also where it exists.
    for accel in ["pyramid", "none"] {
        page.say(choice(accel));
        let text = page.text("refused")["text"].as_str().unwrap().to_owned();
        assert!(text.contains("is not offered"), "{text}");
    }
}
