//! Viewers and pages that talk to them.

use crate::page::{Heard, Page, Small, connect, file_of, start, token_of};
use eosphor_viewer::{PageView, SceneSource, Viewer, ViewerOptions};
use serde_json::{Value, json};
use std::fs;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::time::Duration;
use tungstenite::Message;

#[test]
fn what_rests_is_the_file() {
    let source = Small("builtin:cornell".into());
    let viewer = start(&source.0);
    let mut page = Page::open(&viewer);
    let own = page.scene();
    let mut scene = source.read().unwrap().scene;
    let input = page.want(&own, false);
    let (picture, samples) = page.at_rest(input);
    assert_eq!(samples, [1, 4, 5]);
    assert!(picture == file_of(&scene), "the file's own view");
    // The same again, for an input that changed nothing.
    let input = page.want(&own, false);
    assert!(page.at_rest(input) == (picture, vec![5]));

    // A view that a page has chosen; first in motion.
    let mut view = own;
    view.camera.eye[0] += 0.1;
    view.camera.fov = 50.5;
    page.want(&view, true);
    (view.size, view.samples, view.light_samples, view.exposure) = ([50, 30], 2, 2, 0.75);
    let input = page.want(&view, false);
    let (picture, _) = page.at_rest(input);
    let [eye, look_at] = [view.camera.eye, view.camera.look_at].map(|p| scene.point_of_file(p));
    let camera = scene.camera.as_mut().unwrap();
    (camera.position, camera.look_at) = (eye, Some(look_at));
    (camera.fov_x_degrees, camera.fov_y_degrees) = (50.5, None);
    let settings = &mut scene.settings;
    (settings.size, settings.samples, settings.light_samples, settings.exposure) = ([50, 30], 2, 2, 0.75);
    assert!(picture == file_of(&scene), "a view of the page");

    // A pixel of it, and its command line.
    page.say(json!({ "type": "pixel", "x": 25, "y": 15 }));
    let pixel = page.text("pixel");
    assert_eq!(pixel["samples"], 2);
    assert!(pixel["linear"][0].as_f64().unwrap() > 0.0);
    page.say(json!({ "type": "command" }));
    let command = page.text("command")["text"].as_str().unwrap().to_owned();
    assert!(command.starts_with("eosphor render a.json --size=50x30 --eye="), "{command}");
    assert!(
        command.ends_with("--no-metadata -o picture.png") && command.contains("--samples=2"),
        "{command}"
    );
}

#[test]
fn moving_frames_show_the_newest_input_and_wait_for_the_page() {
    let viewer = start(Path::new("builtin:cornell"));
    let mut page = Page::open(&viewer);
    let mut view = page.scene();
    for _ in 0..50 {
        view.camera.eye[1] += 0.001;
        page.want(&view, true);
    }
    let last = page.want(&view, false);
    let mut inputs = Vec::new();
    loop {
        let Heard::Frame(header, _) = page.hear() else { continue };
        inputs.push(header["input"].as_u64().unwrap());
        if header["input"] == last {
            break;
        }
    }
    // None is older than one before, and those in between were never rendered.
    assert!(inputs.is_sorted() && inputs.len() < 50, "{inputs:?}");

    // A page that takes no frames gets two, and no more.
    let mut silent = connect(viewer.address(), &token_of(&viewer), &[]).unwrap();
    let mut frames = 0;
    let text = silent.socket.read().unwrap();
    let scene: Value = serde_json::from_str(text.to_text().unwrap()).unwrap();
    let mut view: PageView = serde_json::from_value(scene["view"].clone()).unwrap();
    silent.socket.get_ref().set_read_timeout(Some(Duration::from_millis(300))).unwrap();
    for _ in 0..10 {
        view.camera.eye[1] += 0.001;
        silent.want(&view, true);
        match silent.socket.read() {
            Ok(Message::Binary(_)) => frames += 1,
            Ok(_) => {}
            Err(tungstenite::Error::Io(_)) => break,
            Err(error) => panic!("{error}"),
        }
    }
    assert_eq!(frames, 2);
}

#[test]
fn large_pictures_come_in_pieces_that_a_camera_that_moves_does_not_wait_for() {
    let source = Small("builtin:cornell".into());
    let viewer = start(&source.0);
    let mut page = Page::open(&viewer);
    let mut view = page.scene();
    (view.size, view.samples) = ([600, 400], 1);
    let mut scene = source.read().unwrap().scene;
    (scene.settings.size, scene.settings.samples) = (view.size, view.samples);
    let input = page.want(&view, false);
    let Heard::Frame(header, picture) = page.hear() else { panic!() };
    assert_eq!((&header["input"], &header["format"]), (&json!(input), &json!("image/png")));
    assert!(header["piece"][1].as_u64().unwrap() > 1, "{header}, {} bytes", picture.len());
    assert!(picture == file_of(&scene));

    // A page that takes no more than the first two pieces, and moves: what comes next is the movement.
    let mut slow = connect(viewer.address(), &token_of(&viewer), &[]).unwrap();
    slow.scene();
    slow.want(&view, false);
    let header_of = |message: Message| {
        let Message::Binary(bytes) = message else { return None };
        let length = u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
        Some(serde_json::from_slice::<Value>(&bytes[4..4 + length]).unwrap())
    };
    let next = |page: &mut Page| loop {
        if let Some(header) = header_of(page.socket.read().unwrap()) {
            return header;
        }
    };
    let pieces = [next(&mut slow), next(&mut slow)];
    assert_eq!(pieces.clone().map(|header| header["piece"][0].as_u64()), [Some(0), Some(1)]);
    view.camera.eye[0] += 0.1;
    let input = slow.want(&view, true);
    slow.say(json!({ "type": "ack", "frame": pieces[1]["frame"] }));
    let header = next(&mut slow);
    assert_eq!((&header["input"], &header["at-rest"]), (&json!(input), &json!(false)));
}

#[test]
fn only_who_has_the_token_comes_in_from_the_page_itself() {
    let viewer = start(Path::new("builtin:cornell"));
    let (address, token) = (viewer.address(), token_of(&viewer));
    assert!(connect(address, &token, &[]).is_ok());
    let wrong: String = token.chars().rev().collect();
    for (token, headers) in [
        (wrong.as_str(), vec![]),
        ("", vec![]),
        (token.as_str(), vec![("origin", "http://evil.example")]),
        (token.as_str(), vec![("origin", "null")]),
        (token.as_str(), vec![("host", "evil.example")]),
    ] {
        let error = connect(address, token, &headers).err().unwrap();
        assert!(error.contains("403"), "{headers:?}: {error}");
    }
    let ask = |line: &str, headers: &str| {
        let mut stream = TcpStream::connect(address).unwrap();
        // A request that is refused before its end resets the connection: what was answered until then counts.
        let _ =
            write!(stream, "GET {line} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n{headers}\r\n");
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        String::from_utf8(answer).unwrap()
    };
    assert!(ask("/", "").starts_with("HTTP/1.1 403"));
    assert!(ask("/?token=0", "").starts_with("HTTP/1.1 403"));
    let first = ask(&format!("/?token={token}"), "");
    assert!(first.starts_with("HTTP/1.1 303") && first.contains("location: /\r\n"), "{first}");
    assert!(first.contains("SameSite=Strict; HttpOnly") && first.contains("default-src 'none'"), "{first}");
    let cookie = format!("Cookie: eosphor-{}={token}\r\n", address.port());
    let page = ask("/", &cookie);
    assert!(page.starts_with("HTTP/1.1 200") && page.contains("<canvas"), "{page}");
    let long = ask(&format!("/{}", "a".repeat(20_000)), &cookie);
    // The reset may overtake the answer.
    assert!(long.is_empty() || long.starts_with("HTTP/1.1 4"), "{long}");
    // All of it is there, and nothing of it comes from elsewhere.
    let folder = fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/page")).unwrap();
    let names = folder.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let scripts: Vec<String> = names.filter(|name| name.ends_with(".js")).collect();
    assert!(scripts.iter().any(|name| name == "viewer.js"), "{scripts:?}");
    for name in ["", "style.css"].into_iter().chain(scripts.iter().map(String::as_str)) {
        let path = format!("/{name}");
        let text = ask(&path, &cookie);
        assert!(text.starts_with("HTTP/1.1 200"), "{path}");
        assert!(
            !name.ends_with(".js") || page.contains(&format!("\"modulepreload\" href=\"{path}\"")),
            "{path}"
        );
        assert!(!text.contains("https:") && !text.contains("src=\"http"), "{path}");
    }
}

#[test]
fn messages_that_make_no_sense_are_answered_and_the_picture_goes_on() {
    let viewer = start(Path::new("builtin:cornell"));
    let mut page = Page::open(&viewer);
    let own = page.scene();
    let text = |view: &PageView| json!({ "type": "view", "input": 1, "moving": false, "view": view });
    let mut wrong = vec![
        json!(null),
        json!([1, 2]),
        json!({ "type": "view" }),
        json!({ "type": "nothing" }),
        json!({ "type": "ack", "frame": -1 }),
        json!({ "type": "pixel", "x": 1e30, "y": 0 }),
        json!({ "type": "command", "more": 1 }),
    ];
    for change in [
        |view: &mut PageView| view.size = [u32::MAX, u32::MAX],
        |view: &mut PageView| view.size = [0, 10],
        |view: &mut PageView| view.samples = 0,
        |view: &mut PageView| view.depth = 65,
        |view: &mut PageView| view.camera.fov = 180.0,
        |view: &mut PageView| view.camera.eye[1] = 1e300,
        |view: &mut PageView| view.camera.look_at = view.camera.eye,
        |view: &mut PageView| view.camera.up = [0.0; 3],
        |view: &mut PageView| view.exposure = 1e9,
    ] {
        let mut view = own;
        change(&mut view);
        wrong.push(text(&view));
    }
    for message in wrong {
        page.say(message.clone());
        let answer = page.text("refused");
        assert!(!answer["text"].as_str().unwrap().is_empty(), "{message}");
    }
    page.socket.send(Message::binary(vec![0; 100])).unwrap();
    page.text("refused");
    // Pixels that are not there are not answered.
    page.say(json!({ "type": "pixel", "x": 4_000_000_000u32, "y": 0 }));
    let input = page.want(&own, false);
    page.at_rest(input);
    // One that is too long ends the connection, and no other.
    let mut other = Page::open(&viewer);
    other.scene();
    page.socket.send(Message::text("x".repeat(100_000))).unwrap();
    while page.socket.read().is_ok() {}
    let input = other.want(&own, false);
    other.at_rest(input);
}

#[test]
fn pages_beyond_the_limit_are_refused_until_one_leaves() {
    let viewer = start(Path::new("builtin:cornell"));
    let (address, token) = (viewer.address(), token_of(&viewer));
    let mut pages: Vec<Page> = (0..64).map(|_| Page::open(&viewer)).collect();
    let error = connect(address, &token, &[]).err().unwrap();
    assert!(error.contains("503"), "{error}");
    drop(pages.pop());
    // The server hears of it soon.
    let again = (0..200).any(|_| {
        std::thread::sleep(Duration::from_millis(20));
        connect(address, &token, &[]).is_ok()
    });
    assert!(again);
    // The others are still served.
    let page = &mut pages[0];
    let view = page.scene();
    let input = page.want(&view, false);
    page.at_rest(input);
}

#[test]
fn files_are_followed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.json");
    let scene = |x: f64, color: &str| {
        format!(
            r#"{{ "eosphor": 2, "camera": {{ "position": [{x}, 0, 5], "look-at": [0, 0, 0] }},
            "materials": {{ "m": {{ "matte": {{ "color": {color} }} }} }},
            "spheres": [{{ "center": [0, 0, 0], "radius": 1, "material": "m" }}] }}"#
        )
    };
    std::fs::write(&path, scene(0.0, "[1, 0, 0]")).unwrap();
    let viewer = start(&path);
    let mut page = Page::open(&viewer);
    let own = page.scene();
    let input = page.want(&own, false);
    let (red, _) = page.at_rest(input);
    // A mistake: it is shown with its place, and the last picture stays.
    std::fs::write(&path, scene(0.0, "[1, 0, \"blue\"]")).unwrap();
    let error = page.text("error")["text"].as_str().unwrap().to_owned();
    assert!(error.contains("scene.json") && error.contains(":2:"), "{error}");
    let input = page.want(&own, false);
    assert!(input > 0);
    // Repaired, in another colour: the picture follows by itself.
    std::fs::write(&path, scene(0.0, "[0, 0, 1]")).unwrap();
    let message = page.text("scene");
    assert_eq!((&message["version"], &message["take-camera"]), (&json!(2), &json!(false)));
    let (blue, _) = page.at_rest(input);
    assert!(blue != red);
    // Another camera in the file is one to take.
    std::fs::write(&path, scene(0.25, "[0, 0, 1]")).unwrap();
    let message = page.text("scene");
    assert_eq!((&message["version"], &message["take-camera"]), (&json!(3), &json!(true)));
    assert_eq!(message["view"]["camera"]["eye"][0], 0.25);
}

#[test]
fn what_cannot_be_shown_is_said_at_the_start() {
    let missing = Small("no such file.json".into());
    let error = Viewer::start(Box::new(missing), &ViewerOptions::default()).err().unwrap().to_string();
    assert!(error.contains("no such file.json"), "{error}");
    let viewer = start(Path::new("builtin:cornell"));
    let port = viewer.address().port();
    let taken = ViewerOptions { port, ..ViewerOptions::default() };
    let error = Viewer::start(Box::new(Small("builtin:cornell".into())), &taken).err().unwrap().to_string();
    assert!(error.contains("cannot listen on 127.0.0.1"), "{error}");
    // The next one at this port is found with the same token.
    let token = viewer.token().to_owned();
    viewer.end();
    let again = ViewerOptions { port, token: Some(token.clone()), ..ViewerOptions::default() };
    let viewer = Viewer::start(Box::new(Small("builtin:cornell".into())), &again).unwrap();
    connect(viewer.address(), &token, &[]).unwrap().scene();
}
