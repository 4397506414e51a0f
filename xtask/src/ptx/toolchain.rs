//! Finding a compiler that can build `core` for the GPU: one with its library's sources.

use anyhow::{Context, Result, bail};
use std::env;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A compiler with the sources of its library.
pub(super) struct Toolchain {
    rustc: PathBuf,
    /// Where its shared libraries are, if not where it looks by itself.
    libraries: Option<OsString>,
    /// First line of `rustc --version`.
    pub(super) version: String,
}

impl Toolchain {
    /// `$PTX_RUSTC`; else rustup's toolchains that have rust-src; else, on Debian, the packages of its second compiler,
    /// unpacked to `$PTX_TOOLCHAIN` or `~/.cache/ptx-toolchain`.
    pub(super) fn find() -> Result<Toolchain> {
        if let Some(rustc) = env::var_os("PTX_RUSTC") {
            return Toolchain::at(rustc.into(), None);
        }
        if let Some(rustc) = from_rustup() {
            return Toolchain::at(rustc, None);
        }
        let folder = debian_folder()?;
        if !folder.join("usr/bin/rustc").exists() {
            unpack_debian_packages(&folder).context(
                "no compiler with its library's sources: `rustup component add rust-src` gets one (or set PTX_RUSTC)",
            )?;
        }
        let usr = folder.join("usr/lib");
        let libraries = env::join_paths([usr.join("x86_64-linux-gnu"), usr])?;
        Toolchain::at(folder.join("usr/bin/rustc"), Some(libraries))
    }

    fn at(rustc: PathBuf, libraries: Option<OsString>) -> Result<Toolchain> {
        let mut toolchain = Toolchain { rustc, libraries, version: String::new() };
        let rustc = toolchain.rustc.clone();
        let output = toolchain.command(&rustc).arg("--version").output();
        let output = output.with_context(|| format!("starting {}", rustc.display()))?;
        let text = String::from_utf8_lossy(&output.stdout);
        toolchain.version = text.lines().next().unwrap_or_default().to_string();
        Ok(toolchain)
    }

    /// cargo, told to use this compiler and its unstable features. It starts from a clean slate: flags and wrappers of
    /// the surrounding build would change the output.
    pub(super) fn cargo(&self) -> Command {
        let mut cargo = self.command(Path::new(&env::var_os("CARGO").unwrap_or("cargo".into())));
        cargo.env("RUSTC", &self.rustc).env("RUSTC_BOOTSTRAP", "1");
        for name in ["RUSTFLAGS", "RUSTC_WRAPPER", "RUSTC_WORKSPACE_WRAPPER"] {
            cargo.env_remove(name);
        }
        cargo
    }

    fn command(&self, program: &Path) -> Command {
        let mut command = Command::new(program);
        if let Some(libraries) = &self.libraries {
            command.env("LD_LIBRARY_PATH", libraries);
        }
        command
    }
}

/// The compiler of the first of rustup's toolchains, the default one before others, that has the sources.
fn from_rustup() -> Option<PathBuf> {
    let output = Command::new("rustup").args(["toolchain", "list"]).output().ok()?;
    let list = String::from_utf8(output.stdout).ok()?;
    let mut lines: Vec<&str> = list.lines().collect();
    lines.sort_by_key(|line| !line.contains("default"));
    lines.iter().find_map(|line| {
        let name = line.split_whitespace().next()?;
        let output = Command::new("rustup").args(["which", "--toolchain", name, "rustc"]).output().ok()?;
        let rustc = PathBuf::from(String::from_utf8(output.stdout).ok()?.trim_end());
        let library = rustc.parent()?.parent()?.join("lib/rustlib/src/rust/library");
        library.join("core/src/lib.rs").exists().then_some(rustc)
    })
}

fn debian_folder() -> Result<PathBuf> {
    match (env::var_os("PTX_TOOLCHAIN"), env::var_os("HOME")) {
        (Some(folder), _) => Ok(folder.into()),
        (None, Some(home)) => Ok(PathBuf::from(home).join(".cache/ptx-toolchain")),
        _ => bail!("neither PTX_TOOLCHAIN nor HOME is set"),
    }
}

/// Downloads Debian's rustc-web, which its security updates keep recent, and unpacks it beside the system (installed,
/// it would replace the ordinary compiler). `apt-get update` must have run.
fn unpack_debian_packages(folder: &Path) -> Result<()> {
    let depends = output_of(Command::new("apt-cache").args(["depends", "libstd-rust-web-dev"]))?;
    let library = depends.lines().find_map(|line| {
        let name = line.trim().strip_prefix("Depends: ")?;
        name.starts_with("libstd-rust-web-").then_some(name)
    });
    let library = library.context("no package libstd-rust-web-dev")?;
    let packages = folder.join("deb");
    fs::create_dir_all(&packages)?;
    let names = ["rustc-web", "rust-web-src", "libstd-rust-web-dev", "libllvm22", library];
    eprintln!("downloading {} into {}", names.join(", "), packages.display());
    output_of(Command::new("apt-get").arg("download").args(names).current_dir(&packages))
        .context("`apt-get update` may help")?;
    for package in fs::read_dir(&packages)? {
        output_of(Command::new("dpkg-deb").arg("-x").arg(package?.path()).arg(folder))?;
    }
    Ok(())
}

/// What a command prints; an error with its messages where it fails.
pub(super) fn output_of(command: &mut Command) -> Result<String> {
    let name = command.get_program().to_string_lossy().into_owned();
    let output = command.output().with_context(|| format!("starting {name}"))?;
    if !output.status.success() {
        bail!("{name} failed: {}", String::from_utf8_lossy(&output.stderr).trim());
    }
    Ok(String::from_utf8(output.stdout)?)
}
