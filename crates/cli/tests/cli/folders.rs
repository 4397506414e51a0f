//! Folders of outputs: made where they are missing, but not for a command that was wrong.

use crate::place::Place;
use std::fs;

const TINY: [&str; 6] = ["--size", "16x16", "--samples", "1", "--light-samples", "1"];

fn render(place: &Place, output: &str, more: &[&str]) -> crate::place::Run {
    place.run(&[&["render", "builtin:cornell", "-o", output], &TINY[..], more].concat())
}

#[test]
fn missing_folders_are_made() {
    let place = Place::new();
    render(&place, "a/b/c.png", &[]).succeeded();
    render(&place, "d/cost.png", &["--show", "cost"]).succeeded();
    render(&place, "e/%d.png", &["--orbit", "2"]).succeeded();
    render(&place, "f/g.png", &["--tiles", "1/1"]).succeeded();
    render(&place, "h/i.png", &["-o", "j/k.exr"]).succeeded();
    place.run(&["merge", "f/g.png.1-of-1.share", "-o", "l/g.png"]).succeeded();
    let compare = ["compare", "a/b/c.png", "d/cost.png", "--diff", "m/n.png"];
    assert_eq!(place.run(&compare).code, Some(1));
    for name in [
        "a/b/c.png",
        "d/cost.png",
        "e/1.png",
        "f/g.png.1-of-1.share",
        "h/i.png",
        "j/k.exr",
        "l/g.png",
        "m/n.png",
    ] {
        assert!(place.path(name).is_file(), "{name}");
    }
    #[cfg(feature = "video")]
    {
        render(&place, "o/p.mp4", &["--orbit", "2"]).succeeded();
        assert!(place.path("o/p.mp4").is_file());
    }
}

#[test]
fn merge_says_what_it_made_or_nothing() {
    let place = Place::new();
    render(&place, "a.png", &["--tiles", "1/1", "-q"]).succeeded();
    let said = place.run(&["merge", "-o", "a.png"]).succeeded();
    assert_eq!((said.stdout.as_str(), said.stderr.as_str()), ("", "a.png: of 1 shares\n"));
    let quiet = place.run(&["merge", "-q", "-o", "b/a.png", "a.png.1-of-1.share"]).succeeded();
    assert_eq!((quiet.stdout.as_str(), quiet.stderr.as_str()), ("", ""));
    assert_eq!(fs::read(place.path("a.png")).unwrap(), fs::read(place.path("b/a.png")).unwrap());
}

#[test]
fn what_is_wrong_leaves_no_folder() {
    let place = Place::new();
    fs::write(place.path("file"), "").unwrap();
    fs::write(place.path("bad.json"), "{").unwrap();
    let before = place.names();
    for (output, flags) in [
        ("a/b.png", &["--samples", "0"][..]),
        ("a/b.png", &["--orbit", "3"]),
        ("a/b.png", &["--region", "0,0,99x99"]),
        ("a/%d.png", &[]),
        ("a/b.png", &["--sample-range", "0..9"]),
        ("a/b.png", &["-o", "a/./b.png"]),
        ("a/%d.png", &["--orbit", "3", "--alpha"]),
    ] {
        assert_eq!(render(&place, output, flags).code, Some(2), "{output} {flags:?}");
        assert_eq!(place.names(), before, "{output} {flags:?}");
    }
    place.run(&["render", "bad.json", "-o", "a/b.png"]).failed_with(&["bad.json"]);
    place.run(&["render", "none.json", "-o", "a/b.png"]).failed_with(&["none.json"]);
    render(&place, "a/b.xyz", &[]).is_wrong_usage(&["a/b.xyz"]);
    render(&place, "file/a/b.png", &[]).failed_with(&["file/a/b.png", "a part of the path is a file"]);
    place.run(&["merge", "none.share", "-o", "a/b.png"]).failed_with(&["none.share"]);
    place.run(&["compare", "none.png", "none.png", "--diff", "a/b.png"]).failed_with(&["none.png"]);
    assert_eq!(place.names(), before);
}
