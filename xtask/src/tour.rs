//! `cargo xtask tour [README.md...]`: runs the commands that the documents show, as they stand there, in a folder that has what a
//! clean clone has beside them: the folder `scenes`. Commands of cargo are left out; tests and installations are for CI.

use crate::{build_program, root};
use anyhow::{Context, Result, bail, ensure};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What a command may take, in seconds, on a machine of two cores.
const PATIENCE: &str = "600";

/// A part of a document that is no prose.
#[derive(Debug, PartialEq)]
enum Block {
    /// A command.
    Run(String),
    /// A file by name, and its contents.
    File(String, String),
}

pub(crate) fn run(arguments: &[String]) -> Result<()> {
    let documents: Vec<PathBuf> = match arguments {
        [] => vec![root().join("README.md")],
        paths => paths.iter().map(PathBuf::from).collect(),
    };
    let program = build_program()?.canonicalize()?;
    let folder = std::env::temp_dir().join(format!("eosphor-tour-{}", std::process::id()));
    fs::create_dir(&folder)?;
    link(&root().join("scenes"), &folder.join("scenes"))?;
    // The program by its own name.
    let programs = folder.join("bin");
    fs::create_dir(&programs)?;
    std::os::unix::fs::symlink(&program, programs.join("eosphor"))?;
    let path = std::env::join_paths(
        std::iter::once(programs).chain(std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default())),
    )?;
    let mut number = 0;
    for document in documents {
        let text = fs::read_to_string(&document).with_context(|| document.display().to_string())?;
        for block in blocks(&text) {
            match block {
                Block::File(name, contents) => fs::write(folder.join(name), contents)?,
                Block::Run(line) => {
                    println!("{line}");
                    let mut shell = Command::new("timeout");
                    shell.args([PATIENCE, "bash", "-c", &line]).env("PATH", &path).current_dir(&folder);
                    let done = shell.output().context("cannot run bash")?;
                    let said = String::from_utf8_lossy(&done.stderr);
                    // Pictures that differ are what the comparison is about.
                    let may_differ = line.contains(" compare ") && line.contains("--diff");
                    let as_told = done.status.success() || (may_differ && done.status.code() == Some(1));
                    ensure!(as_told, "{}: {line}: {}: {said}", document.display(), done.status);
                    for name in outputs(&line) {
                        let length = fs::metadata(folder.join(&name)).map(|file| file.len());
                        ensure!(length.is_ok_and(|length| length > 0), "{line}: {name} is not there");
                    }
                    number += 1;
                }
            }
        }
    }
    ensure!(number > 0, "there is no command");
    fs::remove_dir_all(&folder)?;
    println!("{number} commands did what they say");
    Ok(())
}

/// The commands and files of a document, in its order. A file is a block after a line that is its name alone.
fn blocks(text: &str) -> Vec<Block> {
    let mut found = Vec::new();
    let mut lines = text.lines();
    let mut name = None;
    while let Some(line) = lines.next() {
        if let Some(kind) = line.strip_prefix("```") {
            let inner: Vec<&str> = lines.by_ref().take_while(|line| *line != "```").collect();
            match (kind, name.take()) {
                ("sh", _) => found.extend(commands(&inner).into_iter().map(Block::Run)),
                (_, Some(name)) => found.push(Block::File(name, inner.join("\n") + "\n")),
                _ => {}
            }
        } else if !line.trim().is_empty() {
            let file = line.strip_prefix('`').and_then(|rest| rest.strip_suffix("`:"));
            name = file.filter(|name| !name.contains('/')).map(str::to_owned);
        }
    }
    found
}

/// Lines of a shell, joined where they end in a backslash; but for those of other programs.
fn commands(lines: &[&str]) -> Vec<String> {
    let joined = lines.join("\n").replace("\\\n", " ");
    let own = |line: &&str| line.split_whitespace().any(|word| word == "eosphor");
    joined
        .lines()
        .filter(|line| !line.trim_start().starts_with("cargo"))
        .filter(own)
        .map(str::to_owned)
        .collect()
}

/// The files that a command names by `-o` and `>`. Of frames, the first one with the number 0 or 1 is not known: they are left out.
fn outputs(line: &str) -> Vec<String> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let named = words.windows(2).filter(|pair| ["-o", "--output", ">", "--diff"].contains(&pair[0]));
    named.map(|pair| pair[1].to_owned()).filter(|name| name != "-" && !name.contains('%')).collect()
}

/// Copies a folder's files; folders in it, too.
fn link(from: &Path, to: &Path) -> Result<()> {
    if !from.is_dir() {
        bail!("{}: no such folder", from.display());
    }
    fs::create_dir(to)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        let target = to.join(entry.file_name());
        match entry.file_type()?.is_dir() {
            true => link(&entry.path(), &target)?,
            false => drop(fs::copy(entry.path(), target)?),
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_and_files_of_a_document() {
        let text = "# A\n```sh\ncargo run\neosphor a -o b.png\neosphor c \\\n  -o d_%02d.png > e\n```\n`s.json`:\n\n```json\n{}\n```\n```rust\nfn\n```\n";
        let run = |line: &str| Block::Run(line.to_owned());
        let file = Block::File("s.json".into(), "{}\n".into());
        assert_eq!(blocks(text), [run("eosphor a -o b.png"), run("eosphor c    -o d_%02d.png > e"), file]);
        assert_eq!(outputs("eosphor c -o d_%02d.png -o f.exr > e -o -"), ["f.exr", "e"]);
    }
}
