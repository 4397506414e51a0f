//! Processes, files, and runs that were ended.

use super::{experiment, header};
use eosphor_lab::statistics::CountedRandom;
use eosphor_lab::{
    Clock, Experiment, Measure, Outcome, Records, RecordsFile, Run, RunOptions, Step, Verdict, compare, run,
};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

const LINE: &str = r#"echo '{"quantity":"time","unit":"ms","values":[1.5,2.5],"work":9,"answer":"NAME"}'"#;

fn options(blocks: u32) -> RunOptions {
    RunOptions { blocks, program: "false".into(), has_gpu: false }
}

fn run_all(path: &Path, script: &str, blocks: u32) -> Records {
    let mut file = RecordsFile::open(path, header(experiment(&["a", "b"], script))).unwrap();
    assert!(run(&mut file, &options(blocks), &AtomicBool::new(false), &|_| ()).unwrap());
    file.records.clone()
}

/// How often each variant ran in each block.
fn places(records: &Records) -> BTreeMap<(u32, String, bool), u32> {
    let mut places = BTreeMap::new();
    for record in &records.records {
        *places.entry((record.block, record.variant.clone(), record.again)).or_insert(0) += 1;
    }
    places
}

#[test]
fn a_run_is_in_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("test.jsonl");
    let records = run_all(&path, LINE, 2);
    assert_eq!(Records::read(&path).unwrap(), records);
    let places = places(&records);
    assert!(
        places.values().all(|&count| count == 1) && places.len().is_multiple_of(3) && places.len() >= 6,
        "{places:?}"
    );
    let Outcome::Measured(measured) = &records.records[0].outcome else { panic!("{:?}", records.records[0]) };
    assert_eq!(measured.quantities[0].values, [1.5, 2.5]);
    assert!(measured.wall_seconds > 0.0);
    // Run again, nothing runs.
    assert_eq!(run_all(&path, LINE, 2), records);
}

#[test]
fn a_run_that_was_cut_off_anywhere_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("test.jsonl");
    run_all(&path, LINE, 2);
    let whole = fs::read(&path).unwrap();
    let first = whole.iter().position(|&byte| byte == b'\n').unwrap() + 1;
    let mut random = CountedRandom::new(3);
    for _ in 0..20 {
        let end = first + random.next_below(whole.len() - first);
        fs::write(&path, &whole[..end]).unwrap();
        let resumed = run_all(&path, LINE, 2);
        let places = places(&resumed);
        assert!(places.values().all(|&count| count == 1) && places.len() >= 6, "{end}: {places:?}");
        assert_eq!(Records::read(&path).unwrap(), resumed);
    }
}

#[test]
fn runs_are_taken_by_turns() {
    let folder = tempfile::tempdir().unwrap();
    let mut files = ["one", "two"].map(|name| {
        RecordsFile::open(&folder.path().join(name), header(experiment(&["a", "b"], LINE))).unwrap()
    });
    let (options, cancel) = (options(2), AtomicBool::new(false));
    let mut runs = files.each_mut().map(|file| Run::new(file, &options));
    for turn in 1..=2 {
        for run in &mut runs {
            assert_eq!(run.next_block(&cancel, &|_| ()).unwrap(), Step::Block);
        }
        for run in &runs {
            assert_eq!(run.records().records.len(), 3 * turn);
        }
    }
}

#[test]
fn a_run_that_is_cancelled_keeps_what_has_run() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("test.jsonl");
    let mut file = RecordsFile::open(&path, header(experiment(&["a", "b"], LINE))).unwrap();
    let (cancel, count) = (AtomicBool::new(false), AtomicU32::new(0));
    let on_progress = |_: eosphor_lab::RunProgress| {
        if count.fetch_add(1, Ordering::Relaxed) == 3 {
            cancel.store(true, Ordering::Relaxed);
        }
    };
    assert!(!run(&mut file, &options(3), &cancel, &on_progress).unwrap());
    assert_eq!(Records::read(&path).unwrap().records.len(), 4);
}

#[test]
fn processes_that_fail_are_recorded() {
    let folder = tempfile::tempdir().unwrap();
    for (name, script, what) in [
        ("exit", "echo first >&2; echo last >&2; exit 3", "exit status: 3: first"),
        ("signal", "kill -9 $$", "signal: 9"),
        ("nothing", "true", "it measured nothing"),
        ("nonsense", "echo hello", "line 1 of its output"),
        ("much", "exec head -c 10000000 /dev/zero", "signal: 13"),
    ] {
        let records = run_all(&folder.path().join(name), script, 1);
        let Outcome::Failed(why) = &records.records[0].outcome else { panic!("{name}") };
        assert!(why.contains(what), "{name}: {why}");
        assert!(compare(&[records])[0].is_empty());
    }
    let mut missing = experiment(&["a"], "");
    missing.variants[0].program = Some("/no/such/program".into());
    let mut file = RecordsFile::open(&folder.path().join("missing"), header(missing)).unwrap();
    assert!(run(&mut file, &options(1), &AtomicBool::new(false), &|_| ()).unwrap());
    let Outcome::Failed(why) = &file.records.records[0].outcome else { panic!("it ran") };
    assert!(why.contains("cannot run /no/such/program"), "{why}");
}

#[test]
fn what_would_change_nothing_is_refused() {
    let plain = experiment(&["a", "b"], LINE);
    assert_eq!(plain.check_use(), Ok(()));
    let whole = Experiment { measures: Measure::Process, ..plain.clone() };
    let noise = Experiment { measures: Measure::Noise, clock: Clock::Cpu, ..plain.clone() };
    let held = Experiment { held: vec!["--size".into()], ..plain };
    for (useless, word) in [(whole, "repeats"), (noise, "clock"), (held, "held")] {
        let error = useless.check_use().unwrap_err().to_string();
        assert!(error.contains(&format!("\"{word}\"")), "{error}");
    }
}

#[test]
fn variants_without_their_gpu_are_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let mut two = experiment(&["a", "b"], LINE);
    two.variants[1].needs_gpu = true;
    let mut file = RecordsFile::open(&folder.path().join("gpu"), header(two)).unwrap();
    assert!(run(&mut file, &options(1), &AtomicBool::new(false), &|_| ()).unwrap());
    let verdict = compare(&[file.records.clone()])[0][0].variants[1].verdict.clone();
    assert_eq!(verdict, Verdict::NotMeasured("no GPU here".into()));
}

#[test]
fn files_of_other_runs_and_damaged_ones_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("test.jsonl");
    run_all(&path, LINE, 1);
    let open = |experiment| RecordsFile::open(&path, header(experiment)).map(|_| ());
    let other = open(experiment(&["a", "c"], LINE)).unwrap_err().to_string();
    assert!(other.contains("another experiment"), "{other}");
    let held = RecordsFile::open(&path, header(experiment(&["a", "b"], LINE))).unwrap();
    let busy = open(experiment(&["a", "b"], LINE)).unwrap_err().to_string();
    assert!(busy.contains("another process"), "{busy}");
    drop(held);
    let text = fs::read_to_string(&path).unwrap();
    for (damaged, what) in [
        (text.replace("\"variant\":\"b\"", "\"variant\":\"x\""), "no variant \"x\""),
        (text.replacen("\"block\"", "\"blok\"", 1), "no record"),
        (text.replacen("\"format\":1", "\"format\":9", 1), "format 9"),
        (text.replacen("\"repeats\":1", "\"repeats\":0", 1), "repeats"),
        ("hello\n".into(), "no run"),
        ("hello".into(), "holds no run"),
    ] {
        fs::write(&path, damaged).unwrap();
        let error = Records::read(&path).unwrap_err().to_string();
        assert!(error.contains("test.jsonl:") && error.contains(what), "{what}: {error}");
        assert!(open(experiment(&["a", "b"], LINE)).is_err());
    }
}
