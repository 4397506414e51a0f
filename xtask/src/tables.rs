//! `tables`: the tables in READMEs are those of the runs that they name, and READMEs hold no other figures of speed.
//!
//! A table stands between `<!-- table: RUN -->` and `<!-- end of table -->`; RUN is a file of `eosphor lab run`, by its path in the
//! repository. `eosphor lab report --table RUN` prints it. All tables of a README are of one machine and program.

use crate::{build_program, root};
use anyhow::{Context, Result, bail, ensure};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const BEGIN: &str = "<!-- table: ";
const END: &str = "<!-- end of table -->";

/// What a figure of speed ends in.
const UNITS: [&str; 9] =
    ["ms", "us", "µs", "Mrays/s", "Grays/s", "frames/s", "times as fast", "times as long", "times faster"];

pub(crate) fn run(arguments: &[String]) -> Result<()> {
    let writes = match arguments {
        [] => false,
        [flag] if flag == "--write" => true,
        _ => bail!("usage: cargo xtask tables [--write]"),
    };
    let program = build_program()?;
    let mut wrong = Vec::new();
    for path in readmes(&root())? {
        let text = fs::read_to_string(&path)?;
        let name = path.strip_prefix(root()).unwrap_or(&path).display().to_string();
        wrong.extend(loose_figures(&text).into_iter().map(|(line, what)| {
            format!("{name}:{line}: {what}: figures of speed stand in tables of runs, or on pages of docs/")
        }));
        let fresh = with_tables(&text, |run| table(&program, run)).with_context(|| name.clone())?;
        if fresh == text {
            continue;
        }
        match writes {
            true => fs::write(&path, fresh)?,
            false => {
                wrong.push(format!("{name}: a table is not that of its run: cargo xtask tables --write"))
            }
        }
    }
    ensure!(wrong.is_empty(), "{}", wrong.join("\n"));
    Ok(())
}

/// All READMEs of the repository that people get with a crate or see first.
fn readmes(root: &Path) -> Result<Vec<PathBuf>> {
    let mut paths = vec![root.join("README.md")];
    for entry in fs::read_dir(root.join("crates"))? {
        paths.push(entry?.path().join("README.md"));
    }
    paths.retain(|path| path.exists());
    paths.sort();
    Ok(paths)
}

/// The table of a run, by the program.
fn table(program: &Path, run: &str) -> Result<String> {
    let path = root().join(run);
    let ended = Command::new(program).args(["lab", "report", "--table"]).arg(&path).output()?;
    ensure!(ended.status.success(), "{run}: {}", String::from_utf8_lossy(&ended.stderr).trim());
    Ok(String::from_utf8(ended.stdout)?)
}

/// A text with its tables made anew; they must be of one machine and program.
fn with_tables(text: &str, table: impl Fn(&str) -> Result<String>) -> Result<String> {
    let mut fresh = String::new();
    let mut rest = text;
    let mut ids: Vec<String> = Vec::new();
    while let Some((before, after)) = rest.split_once(BEGIN) {
        let (run, after) = after.split_once(" -->").context("a table without the name of its run")?;
        let (_, after) = after.split_once(END).context("a table without its end")?;
        let made = table(run)?;
        ids.extend(made.split("machine and program ").nth(1).map(|id| id.chars().take(8).collect()));
        fresh.extend([before, BEGIN, run, " -->\n\n", made.trim_end(), "\n", END]);
        rest = after;
    }
    fresh.push_str(rest);
    ids.dedup();
    ensure!(ids.len() <= 1, "its tables are of several machines or programs: {}", ids.join(", "));
    Ok(fresh)
}

/// Lines outside of tables of runs and of code that hold a figure of speed.
fn loose_figures(text: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    let [mut in_table, mut in_code] = [false; 2];
    for (number, line) in text.lines().enumerate() {
        in_table = (in_table || line.starts_with(BEGIN)) && !line.starts_with(END);
        in_code ^= line.starts_with("```");
        if !in_table && !in_code {
            found.extend(figure(line).map(|what| (number + 1, what)));
        }
    }
    found
}

/// The first number of a line with one of the units behind it.
fn figure(line: &str) -> Option<String> {
    let words: Vec<&str> =
        line.split([' ', '(', ')', '|', '`', ',', ';']).filter(|word| !word.is_empty()).collect();
    (0..words.len()).find_map(|at| {
        let is_number = words[at].chars().all(|c| c.is_ascii_digit() || c == '.');
        let behind = words[at + 1..].join(" ");
        let unit = UNITS.iter().find(|unit| {
            let rest = behind.strip_prefix(*unit);
            rest.is_some_and(|rest| !rest.starts_with(char::is_alphanumeric))
        });
        unit.filter(|_| is_number).map(|unit| format!("{} {unit}", words[at]))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str =
        "# A\n\n<!-- table: a.jsonl -->\n\n| old | 3 ms |\n<!-- end of table -->\n\nIt is so.\n";

    #[test]
    fn tables_are_replaced_and_the_rest_stays() {
        let made = |run: &str| Ok(format!("| {run} | 4 ms |\nmachine and program 01234567.\n"));
        let fresh = with_tables(TEXT, made).unwrap();
        assert!(fresh.starts_with("# A\n\n<!-- table: a.jsonl -->\n\n| a.jsonl | 4 ms |\n"), "{fresh}");
        assert!(fresh.ends_with("<!-- end of table -->\n\nIt is so.\n"), "{fresh}");
        assert_eq!(with_tables(&fresh, made).unwrap(), fresh);
        assert!(with_tables("<!-- table: a -->\n", made).is_err());
        let two = format!("{TEXT}{}", TEXT.replace("a.jsonl", "b.jsonl"));
        let differ = |run: &str| Ok(format!("machine and program {run:0<8}.\n"));
        assert!(with_tables(&two, made).is_ok() && with_tables(&two, differ).is_err());
    }

    #[test]
    fn figures_outside_of_tables_are_found() {
        assert!(loose_figures(TEXT).is_empty());
        assert!(loose_figures("```text\nin 3 ms\n```\n").is_empty());
        for (line, what) in [
            ("It takes 3.5 ms.", "3.5 ms"),
            ("| bvh8 | 12 Mrays/s |", "12 Mrays/s"),
            ("which take 1.2 to 1.8 times as long", "1.8 times as long"),
        ] {
            assert_eq!(loose_figures(line), [(1, what.to_owned())]);
        }
        for line in ["96 bytes", "3 msgs", "It reads ms files.", "version 3"] {
            assert!(loose_figures(line).is_empty(), "{line}");
        }
    }
}
