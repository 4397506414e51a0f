//! The program under the launchers of MPI: pictures are those of one process, and failures end all of them.

use crate::place::{Place, Run};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::{Mutex, PoisonError};

/// The launchers of this machine: Debian's MPICH and Open MPI, and MPICH 5 with the standard ABI. Says so where one is
/// missing; with REQUIRE_MPI=1 that is a failure.
fn launchers() -> Vec<PathBuf> {
    let on_path = |name: &str| {
        let path = std::env::var_os("PATH").unwrap_or_default();
        std::env::split_paths(&path).map(|folder| folder.join(name)).find(|program| program.is_file())
    };
    // target/debug/deps/program
    let this = std::env::current_exe().unwrap();
    let wheel = std::env::var_os("EOSPHOR_TEST_MPICH5").map(PathBuf::from);
    let wheel = wheel.unwrap_or_else(|| this.ancestors().nth(3).unwrap().join("mpich5")).join("bin/mpirun");
    let all = [
        ("MPICH", on_path("mpirun.mpich")),
        ("Open MPI", on_path("mpirun.openmpi")),
        ("MPICH 5", wheel.is_file().then_some(wheel)),
    ];
    for (name, _) in all.iter().filter(|(_, launcher)| launcher.is_none()) {
        let text = format!("SKIPPED: no {name} here: .ci/install-mpi installs it\n");
        assert!(std::env::var("REQUIRE_MPI").as_deref() != Ok("1"), "{text}");
        std::io::stderr().write_all(text.as_bytes()).unwrap();
    }
    all.into_iter().filter_map(|(_, launcher)| launcher).collect()
}

/// Runs the program as so many ranks.
fn run(place: &Place, launcher: &Path, ranks: u32, arguments: &[&str]) -> Run {
    // Two cores do not bear several jobs at a time.
    static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
    let _one = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
    let mut command = self::ranks(launcher, ranks);
    command.args(arguments).current_dir(place.path(""));
    command.output().unwrap().into()
}

/// The program as so many ranks.
fn ranks(launcher: &Path, ranks: u32) -> Command {
    let mut command = Command::new(launcher);
    command.args(["-n", &ranks.to_string(), env!("CARGO_BIN_EXE_eosphor")]);
    // Open MPI refuses to run as root, and more ranks than cores, unless it is told to.
    for name in
        ["OMPI_ALLOW_RUN_AS_ROOT", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "OMPI_MCA_rmaps_base_oversubscribe"]
    {
        command.env(name, "1");
    }
    command.env("PRTE_MCA_rmaps_default_mapping_policy", ":oversubscribe");
    command
}

const STILL: [&str; 8] =
    ["render", "builtin:cornell", "--size", "61x47", "--samples", "2", "--light-samples", "2"];

fn bytes(place: &Place, name: &str) -> Vec<u8> {
    fs::read(place.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// An object that moves.
const SCENE: &str = r#"{"eosphor": 2, "animation": {"frames": 7, "fps": 4},
    "camera": {"position": [0, 0, 5], "direction": [0, 0, -1]}, "meshes": [{"file": "tri.obj", "moves": [{"keys": [
    {"seconds": 0, "translate": [0, 0, 0]}, {"seconds": 2, "translate": [1, 0, 0], "scale": 2}]}]}]}"#;

#[test]
fn pictures_are_those_of_one_process() {
    let place = Place::new();
    fs::write(place.path("tri.obj"), "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    fs::write(place.path("scene.json"), SCENE).unwrap();
    let with = |output: &'static str, more: &[&'static str]| [&STILL[..], &["-o", output], more].concat();
    let frames = |output: &'static str| vec!["render", "scene.json", "--size", "32x24", "-o", output];
    place.run(&with("still.png", &["--no-metadata"])).succeeded();
    place.run(&with("layers.exr", &["--no-metadata", "--layers", "all"])).succeeded();
    place.run(&with("stats.ppm", &["--stats"])).succeeded();
    place.run(&frames("one_%d.ppm")).succeeded();
    #[cfg(feature = "video")]
    place.run(&frames("one.mp4")).succeeded();
    for launcher in launchers() {
        for ranks in [1, 2, 3, 4, 8] {
            let what = format!("{ranks} ranks of {}", launcher.display());
            let same = |arguments: &[&str], one: &str, many: &str| {
                run(&place, &launcher, ranks, arguments).succeeded();
                assert!(bytes(&place, one) == bytes(&place, many), "{one}: {what}");
                fs::remove_file(place.path(many)).unwrap();
            };
            same(&with("ranks.png", &["--no-metadata"]), "still.png", "ranks.png");
            let render = run(&place, &launcher, ranks, &frames("ranks_%d.ppm")).succeeded();
            assert!(ranks == 1 || render.stderr.contains(&format!("{ranks} ranks on 1 host")), "{what}");
            for frame in 0..7 {
                let (one, many) = (format!("one_{frame}.ppm"), format!("ranks_{frame}.ppm"));
                assert!(bytes(&place, &one) == bytes(&place, &many), "frame {frame}: {what}");
                fs::remove_file(place.path(&many)).unwrap();
            }
            if ranks == 3 {
                same(&with("ranks.exr", &["--no-metadata", "--layers", "all"]), "layers.exr", "ranks.exr");
                same(&with("ranks.ppm", &["--stats"]), "stats.ppm", "ranks.ppm");
                #[cfg(feature = "video")]
                same(&frames("ranks.mp4"), "one.mp4", "ranks.mp4");
            }
        }
    }
}

/// The course's lines come from one process, in order.
#[test]
fn the_course_has_one_log() {
    let place = Place::new();
    let input = place.run(&["course", "--default"]).succeeded().stdout;
    let course = |mut command: Command, name: &str| {
        let output = format!("{name}_%d.data");
        let mut lines: Vec<&str> = input.lines().collect();
        // Few and small.
        (lines[0], lines[1], lines[2]) = ("5", &output, "32 24 120");
        command.args(["course", "--cpu"]).current_dir(place.path(""));
        command.stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = command.spawn().unwrap();
        child.stdin.take().unwrap().write_all(lines.join("\n").as_bytes()).unwrap();
        let output = child.wait_with_output().unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        let frames: Vec<&str> = text.lines().map(|line| line.split('\t').next().unwrap()).collect();
        assert!(output.status.success() && frames == ["0", "1", "2", "3", "4"], "{name}: {text}");
    };
    course(Command::new(env!("CARGO_BIN_EXE_eosphor")), "one");
    for (number, launcher) in launchers().iter().enumerate() {
        let name = format!("many{number}");
        course(ranks(launcher, 3), &name);
        for frame in 0..5 {
            let (one, many) = (format!("one_{frame}.data"), format!("{name}_{frame}.data"));
            assert!(bytes(&place, &one) == bytes(&place, &many), "{}", launcher.display());
        }
    }
}

/// What one process does is done, and said, once.
#[test]
fn what_is_not_shared_out_is_said_once() {
    let place = Place::new();
    place.render("a.png", &[]).succeeded();
    let tiny = ["--size", "8x6", "--repeats", "1"];
    let commands: [(&[&str], &str); 8] = [
        (&["info", "builtin:cornell"], "triangles "),
        (&["devices"], "instructions "),
        (&["compare", "a.png", "a.png"], "identical"),
        (&["bench", "rays", "builtin:cornell", tiny[0], tiny[1], tiny[2], tiny[3]], "shuffled  any hit"),
        (&["bench", "render", "builtin:cornell", tiny[0], tiny[1], tiny[2], tiny[3]], "Mrays/s"),
        (&["--version"], "eosphor "),
        (&["--help"], "Commands:"),
        (&["render", "--help"], "Examples:"),
    ];
    for launcher in launchers() {
        for (command, words) in commands {
            let run = run(&place, &launcher, 3, command).succeeded();
            assert_eq!(
                run.stdout.matches(words).count(),
                1,
                "{}: {command:?}: {}",
                launcher.display(),
                run.stdout
            );
        }
    }
}

/// What is wrong is said once, by whom it concerns.
#[test]
fn failures_end_all_ranks_with_one_line() {
    let place = Place::new();
    for launcher in launchers() {
        let fails = |arguments: &[&str], code: Option<i32>, words: &[&str]| {
            let run = run(&place, &launcher, 3, arguments);
            let ours: Vec<&str> = run
                .stderr
                .lines()
                .filter(|line| line.starts_with("eosphor: ") || line.starts_with("error: "))
                .filter(|line| !line.starts_with("eosphor: note"))
                .collect();
            let shown = format!("{}: {arguments:?}: {:?}\n{}", launcher.display(), run.code, run.stderr);
            assert!(run.code != Some(0) && (code.is_none() || run.code == code), "{shown}");
            assert!(ours.len() == 1 && words.iter().all(|word| ours[0].contains(word)), "{shown}");
        };
        fails(&["render", "nothing.obj", "-o", "a.png"], None, &["nothing.obj", "No such file"]);
        // (Folders are made where they can be.)
        fails(&["render", "builtin:cornell", "-o", "/dev/null/a.png"], None, &["/dev/null"]);
        fails(&["render", "builtin:cornell", "-o", "a.png", "--backend", "cuda:9"], None, &["rank 0"]);

        assert!(place.names().is_empty(), "{:?}", place.names());
    }
}
