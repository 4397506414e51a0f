//! `cargo xtask kills [--stills N] [--ranks N] [--sequences N] [--backend NAME] [--program PATH]`: kills renders at random
//! moments, lets them go on, and looks whether anything was lost: of stills no more than the interval between two checkpoints,
//! of frames none that was whole; and all files are byte for byte those of a render that nobody disturbed.

use crate::build_program;
use anyhow::{Context, Result, bail, ensure};
use std::collections::HashSet;
use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

/// Seconds between two checkpoints.
const INTERVAL: f64 = 1.0;

/// What may be lost besides: a piece of work that takes longer than was expected, and starting.
const NOISE: f64 = 0.5;

/// Ranks of the second part.
const RANKS: u32 = 2;

/// What a still takes at least, in seconds: more samples are rendered otherwise.
const LONG_ENOUGH: f64 = 3.0;

/// The most samples a pixel that the program takes.
const MAX_SAMPLES: u32 = 65_536;

/// What a command renders.
#[derive(Clone, Copy)]
struct Work {
    flags: &'static [&'static str],
    size: (u32, u32),
    samples: u32,
}

/// A large still of one band, a small one of 65,536 samples, one with layers, and one with more sums than wait in memory, of
/// samples that cost next to nothing.
const STILLS: [Work; 4] = [
    Work { flags: &["builtin:cornell", "-o", "large.png"], size: (1600, 1200), samples: 2 },
    Work {
        flags: &["builtin:cornell", "--light-samples", "1", "-o", "small.png"],
        size: (16, 12),
        samples: MAX_SAMPLES,
    },
    Work {
        flags: &["builtin:cornell", "--layers", "all", "-o", "layers.exr"],
        size: (400, 300),
        samples: 30,
    },
    Work {
        flags: &["builtin:cornell", "--lighting", "distance", "-o", "cheap.ppm"],
        size: (12_000, 10_000),
        samples: 1,
    },
];

/// Frames of a sequence.
const FRAMES: u32 = 24;
const SEQUENCE: Work = Work { flags: &["builtin:cornell", "--orbit", "24"], size: (200, 150), samples: 12 };

struct Options {
    stills: u32,
    ranks: u32,
    sequences: u32,
    backend: String,
    program: PathBuf,
}

pub(crate) fn run(arguments: &[String]) -> Result<()> {
    let mut options =
        Options { stills: 100, ranks: 20, sequences: 10, backend: "cpu".into(), program: PathBuf::new() };
    let mut rest = arguments.iter();
    while let Some(flag) = rest.next() {
        let value = rest.next().with_context(|| format!("{flag} needs a value"))?;
        match flag.as_str() {
            "--stills" => options.stills = value.parse()?,
            "--ranks" => options.ranks = value.parse()?,
            "--sequences" => options.sequences = value.parse()?,
            "--backend" => options.backend = value.clone(),
            "--program" => options.program = value.into(),
            _ => bail!("there is no {flag}"),
        }
    }
    if options.program.as_os_str().is_empty() {
        options.program = build_program()?;
    }
    let folder = std::env::temp_dir().join(format!("eosphor-kills-{}", std::process::id()));
    fs::create_dir_all(&folder)?;
    let mut soak = Soak { options, folder, random: std::process::id().into() };
    let done = soak.all();
    if done.is_ok() {
        fs::remove_dir_all(&soak.folder)?;
    }
    done
}

struct Soak {
    options: Options,
    folder: PathBuf,
    random: u64,
}

/// What one process said and did.
struct Ended {
    /// It came to its own end.
    by_itself: bool,
    /// Of the samples, what it found done and what it had kept at its end, in percent.
    found: f64,
    kept: f64,
    /// Seconds that it rendered, and that it rendered after it had kept something.
    seconds: f64,
    lost: f64,
}

impl Soak {
    fn all(&mut self) -> Result<()> {
        let (stills, ranks, sequences) = (self.options.stills, self.options.ranks, self.options.sequences);
        for (number, still) in STILLS.into_iter().enumerate() {
            let kinds = STILLS.len() as u32;
            let share = |kills: u32| kills / kinds + u32::from(kills % kinds > number as u32);
            self.still(still, 0, share(stills))?;
            self.still(still, RANKS, share(ranks))?;
        }
        for number in 0..sequences {
            self.sequence(if number % 2 == 0 { 2 } else { 4 })?;
        }
        println!("nothing was lost");
        Ok(())
    }

    /// A number from 0 to 1.
    fn random(&mut self) -> f64 {
        self.random =
            self.random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.random >> 11) as f64 / (1u64 << 53) as f64
    }

    fn command(&self, ranks: u32, work: Work, more: &[&str]) -> Command {
        let program = &self.options.program;
        let mut command = match ranks {
            0 => Command::new(program),
            _ => {
                let mut command = Command::new("mpirun");
                // Open MPI asks for these where the user is root, and where there are more ranks than cores.
                command.env("OMPI_ALLOW_RUN_AS_ROOT", "1").env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1");
                command.env("OMPI_MCA_rmaps_base_oversubscribe", "1");
                command.args(["-n", &ranks.to_string()]).arg(program);
                command
            }
        };
        let (size, samples) = (format!("{}x{}", work.size.0, work.size.1), work.samples.to_string());
        command.arg("render").args(work.flags).args(["--size", &size, "--samples", &samples]).args(more);
        command.args(["--backend", &self.options.backend, "--no-metadata"]);
        command.current_dir(&self.folder).stdout(Stdio::null()).stderr(Stdio::piped());
        command
    }

    /// Kills a still so many times.
    fn still(&mut self, mut still: Work, ranks: u32, kills: u32) -> Result<()> {
        if kills == 0 {
            return Ok(());
        }
        let name = *still.flags.last().context("the name of the file")?;
        let path = self.folder.join(name);
        let mut seconds = self.follow(self.command(ranks, still, &[]), f64::INFINITY, ranks)?.seconds;
        while seconds < LONG_ENOUGH {
            // Fast machines get more to do.
            if still.samples <= MAX_SAMPLES / 4 {
                still.samples *= 4;
            } else {
                still.size = (2 * still.size.0, 2 * still.size.1);
            }
            seconds = self.follow(self.command(ranks, still, &[]), f64::INFINITY, ranks)?.seconds;
        }
        let whole = fs::read(&path)?;
        fs::remove_file(&path)?;
        let every = ["--checkpoint-every", "1", "--resume", "-v"];
        let (mut killed, mut ends, mut worst, mut kept) = (0, 0, 0.0f64, 0.0);
        while killed < kills || kept > 0.0 {
            let limit = match killed < kills {
                true => 0.2 + self.random() * (0.6 * seconds).clamp(1.0, 5.0),
                false => f64::INFINITY,
            };
            let ended = self.follow(self.command(ranks, still, &every), limit, ranks)?;
            let place = self.folder.display();
            // (What is printed has one digit after the point, rounded in two ways.)
            ensure!(
                ended.found >= kept - 0.11,
                "{name}: {kept} % were kept, {} % found: see {place}",
                ended.found
            );
            // What was killed may have been done before.
            let (is_done, is_kept) = (path.exists(), path.with_file_name(format!("{name}.part")).exists());
            killed += u32::from(!ended.by_itself);
            ensure!(ends < 10 + 3 * kills, "{name}: it ends before it can be killed: see {place}");
            if is_done {
                ensure!(fs::read(&path)? == whole, "{name} differs: see {place}");
                fs::remove_file(&path)?;
                ensure!(!(is_kept && ended.by_itself), "{name}.part is left");
                ends += 1;
            } else {
                worst = worst.max(ended.lost);
                ensure!(ended.lost <= INTERVAL + NOISE, "{name}: {:.2} s were lost: see {place}", ended.lost);
            }
            kept = if is_done && !is_kept { 0.0 } else { ended.kept.max(ended.found) };
        }
        let of_ranks = if ranks > 0 { format!(" by {ranks} ranks") } else { String::new() };
        println!(
            "{name}{of_ranks}: {}x{}, {} samples, {seconds:.1} s undisturbed; killed {killed} times, {ends} times at its end, the same bytes; \
             {worst:.2} s of work were lost at most, and none that was kept",
            still.size.0, still.size.1, still.samples
        );
        Ok(())
    }

    /// Lets a render go on for some seconds, then kills it, or one of its ranks.
    fn follow(&mut self, mut command: Command, limit: f64, ranks: u32) -> Result<Ended> {
        let mut child = command.spawn().context("cannot start the program")?;
        let stderr = child.stderr.take().context("no standard error")?;
        let (sender, lines) = channel();
        std::thread::spawn(move || {
            for line in BufReader::new(stderr).lines().map_while(Result::ok) {
                if sender.send(line).is_err() {
                    break;
                }
            }
        });
        let (mut found, mut kept, mut begin, mut last, mut said) = (0.0, 0.0, None, None, Vec::new());
        loop {
            while let Ok(line) = lines.try_recv() {
                let number = |text: &str| text.split(' ').next().unwrap_or_default().parse::<f64>();
                if let Some((before, _)) = line.split_once(" % of the samples are done already") {
                    found = number(before.rsplit(' ').next().unwrap_or_default())?;
                } else if let Some(rest) = line.strip_prefix("kept: ") {
                    (kept, last) = (number(rest)?, Some(Instant::now()));
                } else if line == "rendering" {
                    (begin, last) = (Some(Instant::now()), Some(Instant::now()));
                }
                said.push(line);
            }
            let since = |then: Option<Instant>| then.map_or(0.0, |then| then.elapsed().as_secs_f64());
            let (seconds, lost) = (since(begin), since(last));
            if let Some(status) = child.try_wait()? {
                ensure!(status.success(), "it failed: {}", said.join("\n"));
                return Ok(Ended { by_itself: true, found, kept, seconds, lost: 0.0 });
            }
            if seconds >= limit && self.kill(&mut child, ranks)? {
                child.wait()?;
                return Ok(Ended { by_itself: false, found, kept, seconds, lost });
            }
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    /// Kills a process, or any of the ranks that it launched. False: these are done, and what launched them is about to end.
    fn kill(&mut self, child: &mut Child, ranks: u32) -> Result<bool> {
        if ranks == 0 {
            child.kill()?;
            return Ok(true);
        }
        let all = descendants(child.id());
        let name = self.options.program.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let is_rank = |pid: &&u32| {
            fs::read_to_string(format!("/proc/{pid}/comm")).is_ok_and(|comm| comm.trim() == name)
        };
        let all: Vec<u32> = all.iter().filter(is_rank).copied().collect();
        if all.is_empty() {
            return Ok(false);
        }
        let one = all[(self.random() * all.len() as f64) as usize];
        Ok(Command::new("kill").args(["-9", &one.to_string()]).status()?.success())
    }

    /// Several processes at one sequence, killed at random moments.
    fn sequence(&mut self, processes: usize) -> Result<()> {
        let reference = self.folder.join("reference");
        if !reference.exists() {
            fs::create_dir(&reference)?;
            let output = ["-o", "reference/f_%02d.png"];
            ensure!(
                self.command(0, SEQUENCE, &output).output()?.status.success(),
                "the undisturbed render failed"
            );
        }
        let folder = self.folder.join("sequence");
        fs::create_dir(&folder)?;
        let (mut killed, mut refused) = (0, 0);
        let mut running: Vec<(Child, Instant, f64)> = Vec::new();
        loop {
            let whole = fs::read_dir(&folder)?.filter_map(Result::ok).map(|e| e.file_name());
            let whole = whole.filter(|name| name.to_string_lossy().ends_with("png")).count() as u32;
            let is_over = whole == FRAMES;
            if running.len() < processes && !is_over {
                let own = format!("{}..{}", self.range().0, FRAMES);
                let modes: [&[&str]; 3] = [&["--share"], &["--resume", "--frames", &own], &["--resume"]];
                let mode = modes[((self.random() * 4.0) as usize).saturating_sub(1)];
                let more = [&["-o", "sequence/f_%02d.png"], mode].concat();
                let limit = if self.random() < 0.8 { 0.05 + 3.0 * self.random() } else { f64::INFINITY };
                running.push((self.command(0, SEQUENCE, &more).spawn()?, Instant::now(), limit));
                std::thread::sleep(Duration::from_secs_f64(0.3 * self.random()));
            }
            let mut still_running = Vec::new();
            for (mut child, start, limit) in running {
                match child.try_wait()? {
                    Some(status) => {
                        let mut text = String::new();
                        child.stderr.take().context("no standard error")?.read_to_string(&mut text)?;
                        refused += u32::from(check_messages(&text, status.success())?);
                    }
                    None if start.elapsed().as_secs_f64() > limit => {
                        child.kill()?;
                        child.wait()?;
                        killed += 1;
                    }
                    None => still_running.push((child, start, limit)),
                }
            }
            running = still_running;
            if running.is_empty() && is_over {
                break;
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        // One more finds all of them done, and puts what is left in order.
        let more = ["-o", "sequence/f_%02d.png", "--resume"];
        let last = self.command(0, SEQUENCE, &more).output()?;
        let said = String::from_utf8_lossy(&last.stderr).into_owned();
        ensure!(last.status.success(), "{said}");
        let (expected, found) = (files(&reference)?, files(&folder)?);
        ensure!(expected == found, "frames differ, or something is left: see {}", folder.display());
        fs::remove_dir_all(&folder)?;
        println!(
            "a sequence of {FRAMES} frames by {processes} processes: {killed} killed, {refused} were told that others have the \
             frames; all files as of one process"
        );
        Ok(())
    }

    fn range(&mut self) -> (u32, u32) {
        ((self.random() * f64::from(FRAMES)) as u32, FRAMES)
    }
}

/// Whether a process was refused; fails where it said something else than it may.
fn check_messages(text: &str, succeeded: bool) -> Result<bool> {
    let is_allowed = |line: &&str| {
        let may = [
            "rendering",
            "frames are done already",
            "were done by others",
            "a second, ",
            "in work: wait for it",
        ];
        may.iter().any(|words| line.contains(words))
    };
    if let Some(line) = text.lines().find(|line| !is_allowed(line)) {
        bail!("a process said: {line}");
    }
    let refused = text.contains("in work: wait for it");
    ensure!(succeeded != refused, "a process ended with another exit code than it should: {text}");
    Ok(refused)
}

/// Names and contents of the files of a folder, but for what killed processes cannot take away themselves.
fn files(folder: &Path) -> Result<Vec<(String, Vec<u8>)>> {
    let mut all = Vec::new();
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        if !name.starts_with(".eosphor-") {
            all.push((name, fs::read(entry.path()).unwrap_or_default()));
        }
    }
    all.sort();
    Ok(all)
}

/// All processes that a process has started, and those that they have.
fn descendants(of: u32) -> Vec<u32> {
    let Ok(entries) = fs::read_dir("/proc") else { return Vec::new() };
    let parents: Vec<(u32, u32)> = entries
        .filter_map(|entry| {
            let pid: u32 = entry.ok()?.file_name().to_str()?.parse().ok()?;
            let stat = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
            // After the name, which may hold anything, in brackets: state, then parent.
            let parent = stat.rsplit_once(')')?.1.split_whitespace().nth(1)?.parse().ok()?;
            Some((pid, parent))
        })
        .collect();
    let mut found = HashSet::from([of]);
    loop {
        let before = found.len();
        for (pid, parent) in &parents {
            if found.contains(parent) {
                found.insert(*pid);
            }
        }
        if found.len() == before {
            found.remove(&of);
            return found.into_iter().collect();
        }
    }
}
