//! `eosphor bench`.

use crate::place::Place;

#[test]
fn the_cpu_answers_as_its_scalar_search_does() {
    let place = Place::new();
    let arguments = ["bench", "rays", "builtin:cornell", "--size", "40x30", "--repeats", "2", "--json"];
    let report = place.run(&arguments).succeeded().json();
    let rows = report["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 6);
    assert!(rows.iter().all(|row| row["different"] == 0), "{report}");
    assert_eq!(rows[0]["rays"], 40 * 30);
    // One from each hit, in order and shuffled.
    assert_eq!((&rows[2]["rays"], rows[2]["rays"].as_u64() > Some(0)), (&rows[4]["rays"], true));
}

#[test]
fn several_devices_and_no_repeats_are_wrong_usage() {
    let place = Place::new();
    let with =
        |more: &[&str]| place.run(&[&["bench", "rays", "builtin:cornell", "--size", "8x8"], more].concat());
    with(&["--backend", "cuda:0,1"]).is_wrong_usage(&["one device at a time", "cuda:0"]);
    with(&["--repeats", "0"]).is_wrong_usage(&["1 to 10000"]);
}

#[test]
fn a_picture_is_timed_and_not_written() {
    let place = Place::new();
    let arguments = ["bench", "render", "builtin:cornell", "--preset", "pg1", "--size", "16x12"];
    let settings = ["--light-samples", "2", "--repeats", "3", "--backend", "cpu", "--json"];
    let report = place.run(&[&arguments[..], &settings[..]].concat()).succeeded().json();
    assert_eq!(
        (&report["width"], &report["height"], &report["triangles"]),
        (&16.into(), &12.into(), &2188.into())
    );
    let number = |name: &str| report[name].as_f64().unwrap();
    assert!(number("rays") > 16.0 * 12.0 && number("milliseconds") > 0.0, "{report}");
    assert!(number("shortest_milliseconds") <= number("milliseconds"), "{report}");
}

/// What is hashed are the bytes then, which a picture file has, and no film.
#[test]
fn developed_pictures_are_timed() {
    let place = Place::new();
    let arguments = ["bench", "render", "builtin:cornell", "--preset", "pg1", "--size", "16x12"];
    let settings = ["--light-samples", "2", "--repeats", "2", "--backend", "cpu"];
    let run = |more: &[&str]| place.run(&[&arguments[..], &settings[..], more].concat()).succeeded();
    let report = run(&["--developed", "--json"]).json();
    assert_eq!(report["developed"], true, "{report}");
    assert!(report["milliseconds"].as_f64().unwrap() > 0.0, "{report}");
    assert!(run(&["--developed"]).stdout.contains("\ndeveloped "));
    let answer = |more: &[&str]| {
        let line = run(&[more, &["--lines"]].concat()).stdout;
        serde_json::from_str::<serde_json::Value>(&line).unwrap()["answer"].clone()
    };
    let [film, bytes, brighter] =
        [&[][..], &["--developed"], &["--developed", "--exposure", "1"]].map(answer);
    assert!(film != bytes && bytes != brighter && brighter != film);
    assert_eq!(film, answer(&["--exposure", "1"]), "a film is linear");
}
