//! `cargo xtask lab`: whether `eosphor lab` lies. Runs experiments whose truth is known, on a quiet machine and beside other work.

use anyhow::{Context, bail, ensure};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// The core that processes of an experiment with one core are bound to, and another one.
const CORE: u32 = 0;
const OTHER_CORE: u32 = 1;

/// A case: what it shows, and what does.
type Case = (&'static str, fn(&Lab, u32) -> anyhow::Result<String>);

const CASES: [Case; 5] = [
    ("quiet", |lab, runs| equal_variants(lab, runs)),
    ("other-core", |lab, runs| {
        let _hog = Hog::on(OTHER_CORE)?;
        equal_variants(lab, runs)
    }),
    ("slower", slower_variant),
    ("same-core", beside_a_hog),
    ("kills", kills),
];

/// `[CASE...] [--runs N]`; the program is `target/release/eosphor`, which `EOSPHOR_PROGRAM` replaces.
pub fn run(arguments: &[String]) -> anyhow::Result<()> {
    let mut cases = Vec::new();
    let mut runs = None;
    let mut words = arguments.iter();
    while let Some(word) = words.next() {
        match word.as_str() {
            "--runs" => runs = Some(words.next().context("--runs needs a number")?.parse()?),
            name => cases.push(*CASES.iter().find(|case| case.0 == name).with_context(|| {
                format!("there is no case {name}: there are {}", CASES.map(|case| case.0).join(", "))
            })?),
        }
    }
    if cases.is_empty() {
        cases = CASES.to_vec();
    }
    let lab = Lab::build()?;
    for (name, case) in cases {
        let start = Instant::now();
        println!(
            "{name}: {} ({:.0} s)",
            case(&lab, runs.unwrap_or(DEFAULT_RUNS))?,
            start.elapsed().as_secs_f64()
        );
    }
    Ok(())
}

const DEFAULT_RUNS: u32 = 200;

/// The programs, and where their runs are.
struct Lab {
    eosphor: PathBuf,
    spin: PathBuf,
    folder: PathBuf,
}

impl Lab {
    fn build() -> anyhow::Result<Lab> {
        let root = crate::root();
        let build = |arguments: &[&str]| {
            let mut cargo = Command::new("cargo");
            cargo.args(["build", "--release", "--locked"]).args(arguments).current_dir(&root);
            ensure!(cargo.status()?.success(), "cargo build failed");
            Ok(())
        };
        build(&["-p", "eosphor-lab", "--example", "spin"])?;
        let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), PathBuf::from);
        let eosphor = crate::build_program()?;
        let folder = std::env::temp_dir().join(format!("eosphor-lab-{}", std::process::id()));
        fs::create_dir_all(&folder)?;
        Ok(Lab { eosphor, spin: target.join("release/examples/spin"), folder })
    }

    /// An experiment of two variants that take so many steps.
    fn experiment(&self, steps: [u64; 2]) -> anyhow::Result<PathBuf> {
        let spin = self.spin.to_str().context("the path of spin is no UTF-8")?;
        let variant = |name: &str, steps: u64| {
            format!(r#"{{ "name": "{name}", "program": "{spin}", "arguments": ["{steps}", "7"] }}"#)
        };
        let text = format!(
            r#"{{ "name": "tiny", "question": "?", "measures": "rays", "cores": 1, "base": "a",
                 "variants": [{}, {}] }}"#,
            variant("a", steps[0]),
            variant("b", steps[1])
        );
        let path = self.folder.join("tiny.json");
        fs::write(&path, text)?;
        Ok(path)
    }

    fn command(&self, experiment: &Path, output: &Path) -> Command {
        let mut command = Command::new(&self.eosphor);
        command.args(["lab", "run", "--quiet"]).arg(experiment).arg("-o").arg(output);
        command.stderr(Stdio::null()).stdin(Stdio::null());
        command
    }

    /// What a run says of the variant `b`.
    fn said(&self, experiment: &Path, number: u32) -> anyhow::Result<String> {
        let output = self.folder.join(format!("run-{number}"));
        let ended = self.command(experiment, &output).output()?;
        ensure!(ended.status.success(), "lab run ended with {}", ended.status);
        fs::remove_dir_all(output)?;
        let text = String::from_utf8(ended.stdout)?;
        let row = text.lines().find(|line| line.starts_with("| b |")).context("no row of variant b")?;
        Ok(row.trim_end_matches([' ', '|']).rsplit('|').next().unwrap_or_default().trim().to_owned())
    }

    /// How often runs say what.
    fn all_said(&self, experiment: &Path, runs: u32) -> anyhow::Result<Vec<(String, u32)>> {
        let mut counts: Vec<(String, u32)> = Vec::new();
        for number in 0..runs {
            let said = self.said(experiment, number)?;
            match counts.iter_mut().find(|(text, _)| *text == said) {
                Some((_, count)) => *count += 1,
                None => counts.push((said, 1)),
            }
        }
        counts.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        Ok(counts)
    }
}

impl Drop for Lab {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.folder);
    }
}

/// Some 6 milliseconds.
const STEPS: u64 = 4_000_000;

fn text_of(counts: &[(String, u32)]) -> String {
    counts.iter().map(|(text, count)| format!("{count} x \"{text}\"")).collect::<Vec<_>>().join(", ")
}

fn count_of(counts: &[(String, u32)], words: &[&str]) -> u32 {
    counts.iter().filter(|(text, _)| words.contains(&text.as_str())).map(|(_, count)| count).sum()
}

const CLAIMS: [&str; 2] = ["**faster**", "**slower**"];

/// Of two variants that are the same, a difference is claimed in a run of twenty at most.
fn equal_variants(lab: &Lab, runs: u32) -> anyhow::Result<String> {
    let counts = lab.all_said(&lab.experiment([STEPS; 2])?, runs)?;
    let wrong = count_of(&counts, &CLAIMS);
    ensure!(wrong * 20 <= runs, "{wrong} of {runs} runs claim a difference: {}", text_of(&counts));
    Ok(format!("{wrong} of {runs} runs claim a difference; {}", text_of(&counts)))
}

/// A twentieth more steps is found in nine runs of ten.
fn slower_variant(lab: &Lab, runs: u32) -> anyhow::Result<String> {
    let runs = runs.min(50);
    let counts = lab.all_said(&lab.experiment([STEPS, STEPS + STEPS / 20])?, runs)?;
    let found = count_of(&counts, &CLAIMS[1..]);
    ensure!(found * 10 >= runs * 9, "{found} of {runs} runs find it: {}", text_of(&counts));
    Ok(format!("{found} of {runs} runs find 5 %; {}", text_of(&counts)))
}

/// Beside a program on the same core nothing is claimed.
fn beside_a_hog(lab: &Lab, runs: u32) -> anyhow::Result<String> {
    let runs = runs.min(10);
    let _hog = Hog::on(CORE)?;
    let counts = lab.all_said(&lab.experiment([STEPS, STEPS + STEPS / 20])?, runs)?;
    let claims = count_of(&counts, &CLAIMS);
    let unstable: u32 =
        counts.iter().filter(|(text, _)| text.contains("unstable")).map(|(_, count)| count).sum();
    ensure!(claims == 0 && unstable == runs, "{}", text_of(&counts));
    Ok(text_of(&counts))
}

/// A run that is killed at random moments ends with every process once.
fn kills(lab: &Lab, _: u32) -> anyhow::Result<String> {
    let experiment = lab.experiment([STEPS; 2])?;
    let output = lab.folder.join("killed");
    let mut random = SystemTime::now().duration_since(UNIX_EPOCH)?.subsec_nanos() | 1;
    let mut killed = 0;
    while killed < 20 {
        let mut child = lab.command(&experiment, &output).stdout(Stdio::null()).spawn()?;
        random ^= random << 13;
        random ^= random >> 17;
        random ^= random << 5;
        std::thread::sleep(Duration::from_millis(u64::from(random % 400)));
        if child.try_wait()?.is_some() {
            // It was quicker than this: from the beginning.
            fs::remove_dir_all(&output)?;
            continue;
        }
        child.kill()?;
        child.wait()?;
        killed += 1;
    }
    let status = lab.command(&experiment, &output).stdout(Stdio::null()).status()?;
    ensure!(status.success(), "the last run ended with {status}");
    let text = fs::read_to_string(output.join("tiny.jsonl"))?;
    let mut places = BTreeSet::new();
    for line in text.lines().skip(1) {
        // All that stands before the outcome says what ran.
        let place = line.split("\"outcome\"").next().unwrap_or_default();
        if !places.insert(place) {
            bail!("twice in the file: {place}");
        }
    }
    ensure!(places.len().is_multiple_of(3) && places.len() >= 18, "{} processes", places.len());
    Ok(format!("{killed} kills, {} processes, each once", places.len()))
}

/// A process that keeps a core busy.
struct Hog(Child);

impl Hog {
    fn on(core: u32) -> anyhow::Result<Hog> {
        let mut command = Command::new("taskset");
        command.args(["-c", &core.to_string(), "sh", "-c", "while :; do :; done"]);
        Ok(Hog(command.spawn().context("cannot run taskset")?))
    }
}

impl Drop for Hog {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}
