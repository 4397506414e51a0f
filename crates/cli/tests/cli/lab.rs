//! `eosphor lab`.

use super::place::Place;
use std::fs;
use std::process::Stdio;
use std::time::{Duration, Instant};

/// Two variants that give the same picture, and one of another.
const EXPERIMENT: &str = r#"{
  "name": "small", "question": "Is it quick?", "measures": "picture", "base": "bvh", "repeats": 2,
  "held": ["builtin:cornell", "--size", "16x16", "--backend", "cpu", "--threads", "1"],
  "variants": [
    { "name": "bvh", "arguments": ["--accel", "bvh"] },
    { "name": "octree", "arguments": ["--accel", "octree"] },
    { "name": "other", "arguments": ["--samples", "2"] },
    { "name": "wrong", "arguments": ["--no-such-flag"] }
  ]
}"#;

fn with_experiment() -> Place {
    let place = Place::new();
    fs::write(place.path("small.json"), EXPERIMENT).unwrap();
    place
}

#[test]
fn experiments_are_listed_and_have_no_runs_at_first() {
    let place = Place::new();
    let list = place.run(&["lab", "list"]).succeeded().stdout;
    for name in ["structures", "builders", "threads", "resolution", "samples", "ranks", "distance"] {
        assert!(list.lines().any(|line| line.starts_with(name)), "{list}");
    }
    place.run(&["lab", "report"]).failed_with(&["eosphor-lab", "no such file or folder"]);
    fs::create_dir(place.path("eosphor-lab")).unwrap();
    place.run(&["lab", "report"]).failed_with(&["eosphor-lab has no runs"]);
}

#[test]
fn a_quick_run_claims_nothing_and_says_what_it_found() {
    let place = with_experiment();
    let run = place.run(&["lab", "run", "small.json", "--quick", "--seed", "7"]).succeeded();
    let row = |name: &str| run.stdout.lines().find(|line| line.starts_with(&format!("| {name} |"))).unwrap();
    assert!(row("bvh").contains("| base |"), "{}", run.stdout);
    assert!(row("octree").contains("no claim"), "{}", run.stdout);
    assert!(row("other").contains("different work: no ratio"), "{}", run.stdout);
    assert!(
        row("wrong").contains("not measured") && row("wrong").contains("exit status: 2"),
        "{}",
        run.stdout
    );
    assert!(run.stdout.contains("seed 7"));
    assert_eq!(place.names(), ["eosphor-lab", "small.json"]);
    // The same again runs nothing, and reports the same.
    let again = place.run(&["lab", "run", "small.json", "--quick"]).succeeded();
    assert_eq!((again.stdout.as_str(), again.stderr.as_str()), (run.stdout.as_str(), ""));
    let report = place.run(&["lab", "report"]).succeeded().stdout;
    assert!(report.contains("report.html"), "{report}");
    let page = fs::read_to_string(place.path("eosphor-lab/report.html")).unwrap();
    assert!(page.starts_with("<!DOCTYPE html>") && !page.contains("<script"));
    assert!(fs::read_to_string(place.path("eosphor-lab/report.md")).unwrap().contains("| octree |"));
    let table = place.run(&["lab", "report", "--table"]).succeeded().stdout;
    assert!(table.contains("| octree |") && table.contains("Medians of"), "{table}");
    place
        .run(&["lab", "run", "small.json", "--quick", "--seed", "8"])
        .is_wrong_usage(&["--seed 8", "seed 7"]);
}

#[test]
fn what_is_wrong_is_said() {
    let place = with_experiment();
    place.run(&["lab", "run", "nothing"]).is_wrong_usage(&["no experiment nothing", "structures"]);
    place.run(&["lab", "run"]).is_wrong_usage(&["EXPERIMENT"]);
    place.run(&["lab", "run", "nothing.json"]).failed_with(&["nothing.json", "no such file"]);
    for (wrong, what) in [
        (EXPERIMENT.replace("\"picture\"", "\"speed\""), "small.json: unknown variant `speed`"),
        (EXPERIMENT.replace("\"base\": \"bvh\"", "\"base\": \"x\""), "\"x\", which others are compared with"),
        (EXPERIMENT.replace("\"small\"", "\"../small\""), "letters, digits and hyphens"),
        (EXPERIMENT.replace("\"octree\",", "\"bvh\","), "a name of its own"),
        (EXPERIMENT.replace("\"repeats\": 2", "\"repeats\": 0"), "\"repeats\" must be"),
        (EXPERIMENT.replace("\"repeats\": 2", "\"repeat\": 2"), "unknown field `repeat`"),
    ] {
        fs::write(place.path("small.json"), wrong).unwrap();
        place.run(&["lab", "run", "small.json", "--quick"]).failed_with(&[what]);
    }
    fs::write(place.path("small.json"), EXPERIMENT).unwrap();
    fs::write(place.path("eosphor-lab"), "a file").unwrap();
    place.run(&["lab", "run", "small.json", "--quick"]).failed_with(&["eosphor-lab"]);
}

/// Killed again and again, it ends with every process once.
#[cfg(unix)]
#[test]
fn a_run_that_is_killed_goes_on() {
    let place = with_experiment();
    let arguments = ["lab", "run", "small.json", "--blocks", "3", "-q"];
    for milliseconds in [50, 130, 290] {
        let mut child =
            place.command(&arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        let start = Instant::now();
        while child.try_wait().unwrap().is_none() && start.elapsed() < Duration::from_millis(milliseconds) {
            std::thread::sleep(Duration::from_millis(5));
        }
        let _ = child.kill();
        child.wait().unwrap();
    }
    place.run(&arguments).succeeded();
    let text = fs::read_to_string(place.path("eosphor-lab/small.jsonl")).unwrap();
    let mut places = std::collections::BTreeSet::new();
    for line in text.lines().skip(1) {
        let record: serde_json::Value = serde_json::from_str(line).unwrap();
        let of = (record["block"].to_string(), record["variant"].to_string(), record["again"].to_string());
        assert!(places.insert(of.clone()), "{of:?} twice");
    }
    // Blocks that other tests disturb are run again, twice as many at most.
    assert!(places.len().is_multiple_of(5) && (15..=30).contains(&places.len()), "{places:?}");
}

/// A triangle that a single ray hits is missing in one of two files.
#[test]
fn a_variant_that_loses_a_hit_gets_no_ratio() {
    let place = Place::new();
    let wall = "v -9 -9 -4\nv 9 -9 -4\nv 0 9 -4\nv 0 0 -3.9\nv 0.3 0 -3.9\nv 0 0.3 -3.9\nf 1 2 3\n";
    fs::write(place.path("whole.obj"), format!("{wall}f 4 5 6\n")).unwrap();
    fs::write(place.path("less.obj"), wall).unwrap();
    let text = r#"{
      "name": "lost", "question": "Which is quicker?", "measures": "rays", "base": "whole", "repeats": 1,
      "held": ["--size", "16x16", "--backend", "cpu", "--eye", "0,0,0", "--look-at", "0,0,-1", "--fov", "60"],
      "variants": [ { "name": "whole", "arguments": ["whole.obj"] }, { "name": "less", "arguments": ["less.obj"] } ]
    }"#;
    fs::write(place.path("lost.json"), text).unwrap();
    let run = place.run(&["lab", "run", "lost.json", "--quick"]).succeeded();
    let mut rows = run.stdout.lines().filter(|line| line.starts_with("| less |"));
    assert!(rows.any(|row| row.contains("| – | – | – | different answers: no ratio |")), "{}", run.stdout);
}

#[test]
fn two_runs_are_compared() {
    let place = with_experiment();
    for output in ["before", "after"] {
        place.run(&["lab", "run", "small.json", "--quick", "-o", output]).succeeded();
    }
    let compared = place.run(&["lab", "compare", "before", "after"]).succeeded().stdout;
    assert!(compared.contains("| small | octree | picture |") && compared.contains("a quick run"));
    let one = place.run(&["lab", "compare", "before/small-quick.jsonl", "after/small-quick.jsonl"]);
    assert_eq!(one.succeeded().stdout, compared);
    // Six blocks of a run that is slower in truth: its times are written by hand.
    let path = place.path("before/small-quick.jsonl");
    let text = fs::read_to_string(&path).unwrap();
    let header = text.lines().next().unwrap().replace("\"is-quick\":true,", "");
    let run = |ms: f64| {
        let record = |block: u32| {
            let ms = ms + 0.01 * f64::from(block);
            format!(
                r#"{{"block":{block},"variant":"bvh","outcome":{{"measured":{{"quantities":[{{"quantity":"picture","unit":"ms","values":[{ms}],"answer":"x"}}],"wall-seconds":1.0,"cpu-seconds":1.0,"load":null}}}}}}"#
            )
        };
        format!("{header}\n{}\n", (0..6).map(record).collect::<Vec<_>>().join("\n"))
    };
    fs::write(&path, run(10.0)).unwrap();
    fs::write(place.path("after/small-quick.jsonl"), run(11.0)).unwrap();
    let slower = place.run(&["lab", "compare", "before", "after"]);
    assert_eq!(slower.code, Some(1));
    assert!(slower.stderr.contains("1 of 1 values of the second run are higher"), "{}", slower.stderr);
    assert!(slower.stdout.contains("**slower**"), "{}", slower.stdout);
    place.run(&["lab", "compare", "after", "before"]).succeeded();
}

#[test]
fn the_schema_knows_all_that_an_experiment_may_say() {
    let place = Place::new();
    let schema = place.run(&["lab", "schema"]).succeeded().stdout;
    let schema: serde_json::Value = serde_json::from_str(&schema).unwrap();
    for name in ["name", "question", "measures", "held", "variants", "base", "cores", "axis", "published"] {
        assert!(schema["properties"][name].is_object(), "{name}");
    }
}

#[test]
fn noise_of_a_picture_shrinks_with_samples_and_is_refused_where_nothing_is_random() {
    let place = Place::new();
    let noise = |samples: &str| {
        let flags = [
            "bench",
            "noise",
            "builtin:cornell",
            "--size",
            "20x16",
            "--lines",
            "--repeats",
            "1",
            "--samples",
        ];
        let line = place.run(&[&flags[..], &[samples]].concat()).succeeded().stdout;
        let line: serde_json::Value = serde_json::from_str(line.lines().next().unwrap()).unwrap();
        line["values"][0].as_f64().unwrap()
    };
    // The only sample of a pixel lies in its middle.
    let [few, many] = [noise("4"), noise("64")];
    assert!(many < few / 4.0, "{few} {many}");
    let flags =
        ["bench", "noise", "builtin:hare", "--size", "8x8", "--samples", "1", "--pixel-sampling", "center"];
    place.run(&flags).is_wrong_usage(&["nothing in this scene"]);
}

#[test]
fn rays_are_exported_for_other_programs() {
    let place = Place::new();
    let flags = ["bench", "rays", "builtin:hare", "--size", "8x8", "--repeats", "1", "--export", "data"];
    place.run(&flags).succeeded();
    let count = |name: &str, bytes_of_one: usize| {
        let bytes = fs::read(place.path(&format!("data/{name}"))).unwrap();
        let count = u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
        assert_eq!(bytes.len(), 4 + count * bytes_of_one, "{name}");
        count
    };
    assert!(count("mesh.tris", 36) > 1000);
    for set in ["primary", "bounce", "shuffled"] {
        assert_eq!(count(&format!("{set}.rays"), 32), count(&format!("{set}.hits"), 8));
    }
    assert_eq!(count("primary.rays", 32), 64);
    place.run(&["bench", "rays", "builtin:glass", "--export", "other"]).is_wrong_usage(&["triangles alone"]);
    assert_eq!(place.names(), ["data"]);
}
