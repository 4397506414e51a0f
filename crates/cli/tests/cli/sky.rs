//! Skies from the command line.

use crate::place::{Place, Run};
use eosphor::Picture;
use std::fs;

/// A matte quadrilateral under this environment.
fn scene(place: &Place, name: &str, environment: &str) {
    let text = format!(
        r#"{{"eosphor": 2, "camera": {{"position": [0, 2, 5], "look-at": [0, 0, 0]}}, {environment}
            "quadrilaterals": [{{"corners": [[-3, -1, 3], [-3, -1, -3], [3, -1, -3], [3, -1, 3]]}}]}}"#
    );
    fs::write(place.path(name), text).unwrap();
}

fn render(place: &Place, scene: &str, out: &str, more: &[&str]) -> Run {
    let flags = ["render", scene, "-o", out, "--size", "16x16", "--no-metadata", "--integrator", "path"];
    place.run(&[&flags[..], more].concat())
}

/// Flags make the same picture as keys; without any, it is neither dark nor cut at white.
#[test]
fn skies_of_flags_are_those_of_scenes() {
    let place = Place::new();
    scene(&place, "bare.json", "");
    let same = |flags: &[&str], environment: &str| {
        scene(&place, "sky.json", environment);
        render(&place, "bare.json", "a.exr", flags).succeeded();
        render(&place, "sky.json", "b.exr", &[]).succeeded();
        assert!(
            fs::read(place.path("a.exr")).unwrap() == fs::read(place.path("b.exr")).unwrap(),
            "{flags:?}"
        );
    };
    let sky =
        r#""sky": {"sun-elevation-degrees": 20, "sun-azimuth-degrees": -30, "turbidity": 5, "albedo": 0}"#;
    same(
        &[
            "--sky",
            "--sky-sun",
            "20,-30",
            "--sky-turbidity",
            "5",
            "--sky-albedo",
            "0",
            "--environment-strength",
            "0.5",
            "--environment-up",
            "0,1,1",
        ],
        &format!(r#""environment": {{{sky}, "strength": 0.5, "up": [0, 1, 1]}},"#),
    );
    let at = r#""sun-at": {"time": "2026-06-21T15:30+02:00", "latitude-degrees": 50.1, "longitude-degrees": 14.4}"#;
    same(
        &[
            "--sky",
            "--sky-time",
            "2026-06-21T15:30+02:00",
            "--sky-place",
            "50.1,14.4",
            "--sky-sun-strength",
            "0",
        ],
        &format!(r#""environment": {{"sky": {{{at}, "sun-strength": 0}}}},"#),
    );
    same(&["--environment", "builtin:studio"], r#""environment": "builtin:studio","#);
    render(&place, "bare.json", "a.png", &["--environment", "builtin:flat"])
        .failed_with(&["no built-in picture \"flat\"", "studio"]);
    render(&place, "bare.json", "a.png", &["--sky", "--samples", "16"]).succeeded();
    let Picture::Bytes(picture) = Picture::read(&place.path("a.png")).unwrap() else {
        panic!("PNG has bytes")
    };
    let pixels = picture.rgba.len() as f64;
    let mean = picture.rgba.iter().map(|&[_, green, ..]| f64::from(green)).sum::<f64>() / pixels;
    assert!((80.0..220.0).contains(&mean), "{mean}");
}

#[test]
fn flags_of_skies_that_do_not_go_together() {
    let place = Place::new();
    scene(&place, "bare.json", "");
    for (flags, message) in [
        (&["--sky", "--environment", "a.hdr"][..], "cannot be used with"),
        (&["--sky-sun", "3"], "--sky-sun would do nothing here: it needs --sky"),
        (&["--sky-turbidity", "3"], "--sky-turbidity would do nothing here: it needs --sky"),
        (
            &["--sky", "--sky-sun", "3", "--sky-time", "2026-06-21T15:30Z", "--sky-place", "1,2"],
            "cannot be used with",
        ),
        (&["--sky", "--sky-time", "2026-06-21T15:30Z"], "--sky-place"),
        (&["--sky", "--sky-time", "2026-06-21T00:00Z", "--sky-place", "0,0"], "degrees below the horizon"),
        (&["--sky", "--sky-time", "2026-06-21T12:00Z", "--sky-place", "91,0"], "latitude 91 is out of range"),
        (&["--sky", "--sky-sun", "-1"], "0 to 90 degrees over the horizon"),
        (&["--sky", "--sky-turbidity", "nan"], "1 to 10"),
        (&["--sky", "--integrator", "whitted"], "--sky would do nothing here: it needs --integrator path"),
    ] {
        let run = render(&place, "bare.json", "a.png", flags);
        assert_eq!(run.code, Some(2), "{flags:?}: {}", run.stderr);
        assert!(run.stderr.contains(message), "{flags:?}: {}", run.stderr);
    }
    // A scene's sky may be changed.
    scene(&place, "sky.json", r#""environment": {"sky": {}},"#);
    render(&place, "sky.json", "a.png", &["--sky-sun", "5", "--hide-environment"]).succeeded();
    let run = place.run(&["render", "sky.json", "-o", "b.png"]);
    assert_eq!(run.code, Some(1), "{}", run.stderr);
    assert!(run.stderr.contains("environment: the integrator whitted has none"), "{}", run.stderr);
}
