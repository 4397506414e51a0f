//! What a file says does not depend on how it is cut, on the number of threads, or on which way its lines go.

use super::join::{ObjFile, parse_pieces};
use crate::files::warnings::Warnings;
use crate::model::origin::APART;
use proptest::prelude::*;
use std::path::Path;

/// All that reading a file in pieces of a size says, as text: NaN would not compare equal to itself.
fn said(text: &str, size: usize) -> String {
    let path = Path::new("a.obj");
    let mut warnings = Warnings::default();
    let result = parse_pieces(text.as_bytes(), size, APART, path, &mut warnings);
    let list: Vec<String> = warnings.finish(path).iter().map(|w| w.to_string()).collect();
    match result {
        Ok(mut file) => {
            let mended = file.finish_faces(|material| material == 1);
            let ObjFile { mesh, materials, uses_no_material, libraries, origin, .. } = file;
            format!(
                "{mesh:?}\n{materials:?} {uses_no_material}\n{libraries:?}\n{list:#?}\n{mended:?} {origin:?}"
            )
        }
        Err(error) => error.to_string(),
    }
}

/// One line of a file, mostly without errors. Indices may reach back into other pieces.
fn line() -> impl Strategy<Value = String> {
    let number = || {
        prop_oneof![
            "-?[0-9]{1,3}[.][0-9]{0,9}",
            Just("1e2".to_string()),
            Just("+5".to_string()),
            Just("0".to_string())
        ]
    };
    let numbers = |count| proptest::collection::vec(number(), count).prop_map(|list| list.join(" "));
    let index = || prop_oneof![8 => -6..0i32, 8 => 1..4i32, 1 => Just(0)];
    let corner = || {
        prop_oneof![
            4 => index().prop_map(|v| format!("{v}")),
            1 => (index(), index()).prop_map(|(v, t)| format!("{v}/{t}")),
            1 => (index(), index()).prop_map(|(v, n)| format!("{v}//{n}")),
            1 => (index(), index(), index()).prop_map(|(v, t, n)| format!("{v}/{t}/{n}")),
        ]
    };
    let blank = || proptest::sample::select(vec![" ", "  ", "\t", " \\\n", " \\\r\n\t", "\\\r"]);
    let face = (proptest::collection::vec((blank(), corner()), 2..7))
        .prop_map(|corners| corners.iter().fold("f".to_string(), |line, (blank, c)| line + blank + c));
    prop_oneof![
        4 => numbers(3).prop_map(|n| format!("v {n}")),
        1 => numbers(4).prop_map(|n| format!("v {n}")),
        1 => proptest::collection::vec("0[.][0-9]{1,4}", 3).prop_map(|c| format!("v 1 2.5 -3 {}", c.join(" "))),
        1 => numbers(7).prop_map(|n| format!("v {n}")),
        2 => numbers(2).prop_map(|n| format!("vt {n}")),
        2 => numbers(3).prop_map(|n| format!("vn {n}")),
        5 => face,
        1 => proptest::sample::select(vec!["a", "b", ""]).prop_map(|name| format!("usemtl {name}")),
        1 => (0..3u32).prop_map(|group| format!("s {group}")),
        1 => proptest::sample::select(vec![
            "mtllib m.mtl", "# v 1 2 3", "", "g a b", "l 1 2", "v 1. 2.x 3", "# \\", "s off", "usemtl a # b", "f 1 2",
            "vt 1 2 3", "vt 1", "vn 0 0 1 # up",
        ]).prop_map(str::to_string),
        1 => proptest::sample::select(vec!["", "", "", "v 1 x 1", "f 1 2 3.5", "f 9 9 9", "v nan 0 0", "v 1 2"])
            .prop_map(str::to_string),
    ]
}

/// A file that begins with some vertices, so that most indices lead somewhere.
fn file() -> impl Strategy<Value = String> {
    let end = || proptest::sample::select(vec!["\n", "\r\n", "\r", " \n"]);
    proptest::collection::vec((line(), end()), 0..30).prop_map(|lines| {
        let start =
            "v 0 0 0\nv 1 0 0\nv 0 1.5 0\nv 0 0 2\nv 1 1 1\nv 2 2 1\nvt 0 0\nvt 1 0\nvt 0.25 1\nvn 0 0 1\n"
                .to_string();
        lines.iter().fold(start, |text, (line, end)| text + line + end)
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, ..ProptestConfig::default() })]

    #[test]
    fn pieces_say_what_the_whole_says(text in file(), size in 1..200usize) {
        let whole = said(&text, usize::MAX);
        prop_assert_eq!(&whole, &said(&text, size), "{}", text);
        prop_assert_eq!(&whole, &said(&text, 1), "{}", text);
    }

    #[test]
    fn plain_lines_say_what_any_lines_say(text in file()) {
        // A blank in front keeps a line off the fast way.
        let any: String = text.split_inclusive('\n').map(|line| format!(" {line}")).collect();
        let any = any.replace('\r', "\r ").replace("\r \n", "\r\n");
        prop_assert_eq!(said(&text, usize::MAX), said(&any, usize::MAX), "{}", text);
    }
}

#[test]
fn one_thread_says_what_many_say() {
    let text: String = (0..4000)
        .map(|i| {
            format!(
                "v {} {}.5 {}\nvt 0.5 {i}\nusemtl m{}\nf -1 -2 -3\nf {} 1 2 3\n",
                i % 7,
                i % 11,
                i % 3,
                i % 5,
                i + 1
            )
        })
        .collect();
    let text = format!("v 0 0 0\nv 1 0 0\n{text}");
    let whole = said(&text, usize::MAX);
    assert!(whole.len() > 100_000);
    for threads in [1, 2, 5] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert!(pool.install(|| said(&text, 1000)) == whole, "{threads} threads");
    }
}

#[test]
fn errors_and_warnings_name_lines_of_the_file() {
    let long = "v 1 2 3\n".repeat(1000);
    for size in [1, 100, usize::MAX] {
        assert_eq!(
            said(&format!("{long}v 1 2\n{long}v x"), size),
            "a.obj:1001: \"v\" needs 3 numbers, found 2"
        );
        assert_eq!(
            said(&format!("{long}f 1 2 -1001"), size),
            "a.obj:1001: vertex index -1001 is out of range; there are 1000"
        );
        assert_eq!(
            said(&format!("{long}f 1 2 1001\nf 1 2 1001\nf 1 2 1000"), size),
            "a.obj:1001: vertex index 1001 is out of range; the file has 1000"
        );
        assert!(said(&format!("{long}v 1 2 3x\nf 1 2 -1000"), size).contains("a.obj:1001: stray characters"));
    }
}
