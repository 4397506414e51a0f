//! What only some files may do.

use super::Text;

/// A thing that only some files may do.
struct Rule {
    what: &'static str,
    /// Any of these in a line of code.
    words: &'static [&'static str],
    /// Beginnings of the paths that the rule is about,
    among: &'static [&'static str],
    /// and of those among them that may.
    allowed: &'static [&'static str],
}

const RULES: [Rule; 5] = [
    Rule {
        what: "what differs by target",
        words: &[
            "cfg(target_arch",
            "cfg(not(target_arch",
            "cfg_attr(target_arch",
            "cfg_attr(not(target_arch",
            "cfg!(target_arch",
            "cfg!(not(target_arch",
        ],
        among: &["crates/core/", "crates/scene/", "crates/eosphor/"],
        allowed: &[
            "crates/core/src/device/pairs.rs",
            "crates/core/src/device/warp.rs",
            "crates/core/src/device/wide.rs",
            "crates/core/src/lib.rs",
            // Hints that change no result.
            "crates/core/src/memory.rs",
            // Names by which hosts find the tables.
            "crates/core/src/bsdf/glass_tables.rs",
            // Ways to texels and sums that are quicker on CPUs.
            "crates/core/src/environment/index.rs",
            "crates/core/src/texture.rs",
            "crates/core/src/math/float.rs",
            "crates/core/src/out_of_line.rs",
            // Reads without a check that devices have no lengths for.
            "crates/core/src/view.rs",
        ],
    },
    Rule {
        what: "instructions of a device",
        words: &["asm!("],
        among: &["crates/", "gpu/"],
        allowed: &[
            "crates/core/src/device/pairs.rs",
            "crates/core/src/device/warp.rs",
            "crates/core/src/device/wide.rs",
            "gpu/src/",
        ],
    },
    Rule {
        what: "printing",
        words: &["println!(", "eprintln!(", "print!(", "eprint!(", "dbg!(", "stdout()", "stderr()"],
        among: &["crates/", "gpu/"],
        allowed: &["crates/cli/", "crates/cluster/src/abort.rs"],
    },
    Rule {
        what: "ending the process",
        words: &["process::exit(", "process::abort(", "_exit("],
        among: &["crates/", "gpu/"],
        allowed: &["crates/cli/", "crates/cluster/src/abort.rs"],
    },
    Rule {
        what: "files",
        words: &["fs::", "File::open", "File::create", "OpenOptions"],
        among: &["crates/", "gpu/"],
        allowed: &[
            "crates/cli/",
            "crates/cluster/src/launcher.rs",
            "crates/eosphor/src/job/files.rs",
            "crates/eosphor/src/job/memory.rs",
            "crates/lab/src/load.rs",
            "crates/lab/src/machine.rs",
            "crates/lab/src/pictures.rs",
            "crates/lab/src/program.rs",
            "crates/lab/src/records.rs",
            "crates/lab/src/report/files.rs",
            "crates/lab/src/run.rs",
            "crates/picture/src/frames/",
            "crates/picture/src/locked_file.rs",
            "crates/picture/src/output/",
            "crates/picture/src/still/",
            "crates/scene/src/files/",
            "crates/viewer/src/watch.rs",
        ],
    },
];

/// Columns of a line.
const WIDTH: usize = 132;

/// How SAFETY comments begin that a reader has to look up elsewhere.
const VAGUE: [&str; 5] = ["as above", "as in ", "as said", "as the function", "the caller"];

pub(super) fn check(text: &Text, found: &mut Vec<String>) {
    let begins = |beginnings: &[&str]| beginnings.iter().any(|beginning| text.path.starts_with(beginning));
    // Tests and examples of a crate may do all of it; what they are made for is a file of its own or the end of one.
    let is_apart = ["/tests/", "/examples/", "/benches/", "tests.rs", "build.rs"]
        .iter()
        .any(|name| text.path.contains(name));
    let mut in_tests = is_apart;
    for (number, line) in text.content.lines().enumerate() {
        let place = || format!("{}:{}", text.path, number + 1);
        // Rows of a table cannot be broken.
        let is_row = line.trim_start().trim_start_matches(['/', '!', ' ']).starts_with('|');
        if line.chars().count() > WIDTH && line.trim_start().starts_with("//") && !is_row {
            found.push(format!("{}: a comment of over {WIDTH} columns", place()));
        }
        if let Some(reason) = line.trim_start().strip_prefix("// SAFETY: ")
            && VAGUE.iter().any(|vague| reason.starts_with(vague))
        {
            found.push(format!("{}: a SAFETY comment that names no invariant", place()));
        }
        in_tests |= line.trim_start() == "#[cfg(test)]"
            && text
                .content
                .lines()
                .nth(number + 1)
                .is_some_and(|next| next.contains("mod ") && next.ends_with('{'));
        if in_tests || line.trim_start().starts_with("//") {
            continue;
        }
        for rule in &RULES {
            let does = rule.words.iter().any(|word| line.contains(word));
            if does && begins(rule.among) && !begins(rule.allowed) {
                found.push(format!("{}: {} is not for this file", place(), rule.what));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(path: &str, content: &str) -> Vec<String> {
        let mut found = Vec::new();
        check(&Text { path: path.into(), content: content.into() }, &mut found);
        found
    }

    #[test]
    fn libraries_do_not_print_and_tests_do() {
        let line = "    println!(\"a\");\n";
        assert_eq!(found("crates/core/src/ray.rs", line).len(), 1);
        assert!(found("crates/cli/src/text.rs", line).is_empty());
        assert!(found("crates/core/tests/ray.rs", line).is_empty());
        assert!(
            found("crates/core/src/ray.rs", &format!("#[cfg(test)]\nmod tests {{\n{line}}}\n")).is_empty()
        );
        assert!(found("crates/core/src/ray.rs", "/// As `println!(\"a\")` does.\n").is_empty());
    }

    #[test]
    fn safety_comments_name_what_they_rely_on() {
        let comment =
            |reason: &str| found("crates/core/src/ray.rs", &format!("        // SAFETY: {reason}\n")).len();
        assert_eq!(["as above.", "the caller's.", "closed views: the depth fits."].map(comment), [1, 1, 0]);
    }
}
