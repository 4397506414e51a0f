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
    for name in ["structures", "builders", "threads", "resolution", "samples"] {
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
    assert!(row("other").contains("other work or answers: no ratio"), "{}", run.stdout);
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
    assert!(report.ends_with(&run.stdout));
    place.run(&["lab", "run", "small.json", "--seed", "8"]).is_wrong_usage(&["--seed 8", "seed 7"]);
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
    assert!(places.len() % 5 == 0 && (15..=30).contains(&places.len()), "{places:?}");
}
