//! Writes down what the program is built from, for `eosphor lab`.

use std::env;
use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    // Where this is no checkout, as in a package of cargo, the commit is not known.
    let folder = env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
    let git = |arguments: &[&str]| said("git", &[&["-C", &folder], arguments].concat());
    let commit = git(&["ls-files", "--error-unmatch", "build.rs"])
        .and_then(|_| git(&["describe", "--always", "--abbrev=12", "--exclude=*", "--dirty=+changes"]));
    for name in ["HEAD", "logs/HEAD", "index"] {
        let path = git(&["rev-parse", "--path-format=absolute", "--git-path", name]);
        // Of a file that is not there, cargo thinks that it has changed.
        if let Some(path) = path.filter(|path| Path::new(path).exists()) {
            println!("cargo::rerun-if-changed={path}");
        }
    }
    let compiler = env::var("RUSTC").ok().and_then(|rustc| said(&rustc, &["--version"]));
    let value = |name: &str| env::var(name).unwrap_or_default();
    let features = ["VIDEO", "VIEW"]
        .map(|name| env::var_os(format!("CARGO_FEATURE_{name}")).map(|_| name.to_lowercase()));
    let features: Vec<String> = features.into_iter().flatten().collect();
    println!("cargo::rustc-env=EOSPHOR_COMMIT={}", commit.unwrap_or_default());
    println!("cargo::rustc-env=EOSPHOR_COMPILER={}", compiler.unwrap_or_default());
    println!(
        "cargo::rustc-env=EOSPHOR_PROFILE={}, opt-level {}, {}",
        value("PROFILE"),
        value("OPT_LEVEL"),
        value("TARGET")
    );
    println!("cargo::rustc-env=EOSPHOR_FEATURES={}", features.join(","));
}

/// What a program prints, if it ends well.
fn said(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}
