//! `cargo xtask tour [DOCUMENT...]`: runs the commands that README.md and the pages in docs/ show in blocks of `sh`, as they stand
//! there. Each document has a folder of its own with what a clean clone has: the folder `scenes`. Commands of cargo are left out;
//! tests and installations are for CI. Blocks of another kind (`bash`) are shown and not run: scripts for other machines.

use crate::{build_program, root};
use anyhow::{Context, Result, bail, ensure};
use std::ffi::OsStr;
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
        [] => pages()?,
        paths => paths.iter().map(PathBuf::from).collect(),
    };
    let program = build_program()?.canonicalize()?;
    let folder = std::env::temp_dir().join(format!("eosphor-tour-{}", std::process::id()));
    fs::create_dir(&folder)?;
    // The program by its own name.
    let programs = folder.join("bin");
    fs::create_dir(&programs)?;
    std::os::unix::fs::symlink(&program, programs.join("eosphor"))?;
    let path = std::env::join_paths(
        std::iter::once(programs).chain(std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default())),
    )?;
    let mut number = 0;
    for (document, place) in documents.iter().zip(0..) {
        let text = fs::read_to_string(document).with_context(|| document.display().to_string())?;
        let place = folder.join(place.to_string());
        fs::create_dir(&place)?;
        link(&root().join("scenes"), &place.join("scenes"))?;
        number += run_blocks(document, blocks(&text), &place, &path)?;
    }
    ensure!(number > 0, "there is no command");
    fs::remove_dir_all(&folder)?;
    println!("{number} commands did what they say");
    Ok(())
}

/// README.md, then the pages in docs/ by name.
fn pages() -> Result<Vec<PathBuf>> {
    let folder = root().join("docs");
    let listed = fs::read_dir(&folder).with_context(|| folder.display().to_string())?;
    let mut pages = listed.map(|entry| Ok(entry?.path())).collect::<Result<Vec<PathBuf>>>()?;
    pages.retain(|page| page.extension().is_some_and(|ending| ending == "md"));
    pages.sort();
    pages.insert(0, root().join("README.md"));
    Ok(pages)
}

/// Runs the blocks of a document in a folder, and says how many commands there were.
fn run_blocks(document: &Path, blocks: Vec<Block>, folder: &Path, path: &OsStr) -> Result<usize> {
    let mut number = 0;
    for block in blocks {
        match block {
            Block::File(name, contents) => fs::write(folder.join(name), contents)?,
            Block::Run(line) => {
                println!("{line}");
                let mut shell = Command::new("timeout");
                shell.args([PATIENCE, "bash", "-c", &line]).env("PATH", path).current_dir(folder);
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
    Ok(number)
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

    /// What is run is the program itself, and not a launcher or a script; and no page is forgotten.
    #[test]
    fn the_pages_have_commands_of_the_program() {
        let mut with_commands = Vec::new();
        for page in pages().unwrap() {
            let found = blocks(&fs::read_to_string(&page).unwrap());
            for block in &found {
                let Block::Run(line) = block else { continue };
                assert!(line.starts_with("eosphor "), "{}: {line}", page.display());
            }
            if found.iter().any(|block| matches!(block, Block::Run(_))) {
                with_commands.push(page.file_name().unwrap().to_string_lossy().into_owned());
            }
        }
        for page in ["README.md", "animation.md", "gpu.md", "output.md", "rendering.md"] {
            assert!(with_commands.iter().any(|name| name == page), "{page}: {with_commands:?}");
        }
    }
}
