//! What is done to the PTX as a text, and what must hold of it.

use super::ptx_text::table_name;
use std::collections::HashSet;

/// The names of the kernels in a PTX text, sorted. (That they are those which the program asks for is a test of crates/cuda.)
pub(super) fn entries(ptx: &str) -> Vec<&str> {
    let mut names: Vec<&str> = ptx.lines().filter_map(entry_name).collect();
    names.sort_unstable();
    names
}

/// rustc has no attribute for this: blocks have at most 128 threads, so each may have more registers.
const LAUNCH_BOUNDS: &str = ".maxntid 128";

/// Added for kernels that answer queries. On an H100 48 registers are up to 1.1 times as fast as 64, for all that is spilled
/// then, and 40 are slower.
const QUERY_BOUNDS: &str = ".maxnreg 48";

/// The same for rays from far away, which take more: the bunny at 1080p from 300 sizes away took 0.38 ms on an H200 with 48 of
/// them, 0.246 with 64, 0.236 with 72, 0.246 with 80, 0.252 with 96.
const FAR_QUERY_BOUNDS: &str = ".maxnreg 72";

/// Added for kernels that render through a `bvh`. With all 255 registers two blocks of 128 threads run on a processor. On an
/// H200 PG1's box at 10000 x 10000 took 1.21 s with 255, 0.96 with 168, 0.98 with 144, 0.84 with 128; glass spheres 95, 103, 104,
/// 102 ms. (Kernels for other structures would spill three times as much with it; they were not measured.)
const RENDER_BOUNDS: &str = ".maxnreg 128";

/// The same of kernels that shade paths: of 80, 128, 168 and 255 registers a thread, these take the least time on an H100.
const SHADE_BOUNDS: &str = ".maxnreg 168";

/// Of what Whitted's trees do beside tracing. `builtin:glass` with 8 samples takes 30.0 ms on an H200 with these (255 of the
/// first), 31.5 with 168, 168 and 128, and 33.1 with 128, 128 and 80; `builtin:solids` 175, 183 and 180.
const TREE_BOUNDS: [(&str, Option<&str>); 4] = [
    ("trees_shade", None),
    ("trees_shade_ends", Some(".maxnreg 80")),
    ("trees_ask", Some(".maxnreg 96")),
    ("trees_sum", Some(RENDER_BOUNDS)),
];

/// What the header says.
pub(super) struct Header<'a> {
    pub(super) hash: &'a str,
    pub(super) compiler: &'a str,
    pub(super) flags: &'a str,
}

impl<'a> Header<'a> {
    /// From a PTX text that starts with one.
    pub(super) fn read(ptx: &'a str) -> Option<Header<'a>> {
        let mut lines = ptx.lines().skip(1);
        let mut field =
            |name: &str| lines.next()?.strip_prefix("// ")?.strip_prefix(name)?.strip_prefix(": ");
        Some(Header { hash: field("sources sha256")?, compiler: field("compiler")?, flags: field("flags")? })
    }
}

/// The text with a header that [`Header::read`] reads.
pub(super) fn with_header(body: &str, hash: &str, compiler: &str, flags: &[&str]) -> String {
    let flags = flags.join(" ");
    format!(
        "// Made by `cargo xtask ptx` from gpu/ and crates/core: do not edit.\n\
         // sources sha256: {hash}\n// compiler: {compiler}\n// flags: {flags}\n{body}"
    )
}

/// The text with [`LAUNCH_BOUNDS`], and the bounds of its kind, after the parameter list of every kernel.
pub(super) fn with_launch_bounds(ptx: &str) -> String {
    let (mut in_parameters, mut bounds) = (false, None);
    let mut out = String::with_capacity(ptx.len() + 64);
    for line in ptx.lines() {
        if let Some(name) = entry_name(line) {
            in_parameters = true;
            bounds = if name.ends_with("_far") {
                Some(FAR_QUERY_BOUNDS)
            } else if name.starts_with("count_") {
                None
            } else if name.starts_with("paths_shade") {
                Some(SHADE_BOUNDS)
            } else if let Some((_, bounds)) = TREE_BOUNDS.iter().find(|(of, _)| *of == name) {
                *bounds
            } else if name.starts_with("crossed_") {
                Some(RENDER_BOUNDS)
            } else if name.ends_with("_generate") {
                // With the bound of queries they spill: they take 72 and 76.
                Some(RENDER_BOUNDS)
            } else if !name.starts_with("render_") {
                Some(QUERY_BOUNDS)
            } else {
                name.starts_with("render_bvh").then_some(RENDER_BOUNDS)
            };
        }
        out.push_str(line);
        out.push('\n');
        if in_parameters && line.starts_with(')') {
            out.push_str(LAUNCH_BOUNDS);
            out.push('\n');
            if let Some(bounds) = bounds {
                out.push_str(bounds);
                out.push('\n');
            }
            in_parameters = false;
        }
    }
    out
}

/// The text without the contents of tables that are exported: the program writes these to the device (`crates/cuda/src/device.rs`).
pub(super) fn without_exported_tables(ptx: &str) -> String {
    let emptied = |line: &str| match line.split_once(" = {") {
        Some((table, _)) if line.starts_with(".visible .global ") => format!("{table};\n"),
        _ => format!("{line}\n"),
    };
    ptx.lines().map(emptied).collect()
}

/// What is wrong with a PTX text. Every rule here keeps the GPU's bits equal to the CPU's, or keeps out panics, which
/// would cost registers and can only end a kernel.
pub(super) fn problems(ptx: &str) -> Vec<String> {
    let mut problems = Vec::new();
    let code = || ptx.lines().map(|line| line.split("//").next().unwrap_or_default());
    if !code().any(|line| line.trim() == ".target sm_75") {
        problems.push("the target is not sm_75".into());
    }
    let count = entries(ptx).len();
    if count == 0 {
        problems.push("there is no kernel".into());
    }
    if code().filter(|line| *line == LAUNCH_BOUNDS).count() != count {
        problems.push("launch bounds are missing".into());
    }
    let tables: HashSet<&str> = code().filter_map(table_name).collect();
    for (number, line) in (1..).zip(code()) {
        for word in line.split(|c: char| !(c.is_alphanumeric() || "_.$%".contains(c))) {
            if let Some(reason) = forbidden(word).filter(|_| !tables.contains(word)) {
                problems.push(format!("line {number}: {word}: {reason}"));
            }
        }
    }
    problems
}

fn entry_name(line: &str) -> Option<&str> {
    line.split_once(".entry ")?.1.split('(').next()
}

fn forbidden(word: &str) -> Option<&'static str> {
    if word.starts_with("_R") || word.starts_with("_ZN") {
        Some("a Rust function that was not inlined, such as a panic")
    } else if word == ".extern" {
        Some("a function that is not in the text")
    } else if word == "trap" {
        Some("a panic")
    } else if word.contains(".approx") || word.starts_with("div.full") {
        Some("not correctly rounded")
    } else if ["mul.f32", "add.f32", "sub.f32", "mul.f64", "add.f64", "sub.f64"].contains(&word) {
        Some("without .rn, so ptxas may fuse it")
    } else if word.contains(".ftz") {
        Some("denormals would be lost")
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sound() -> String {
        let kernel = |name: &str| format!(".visible .entry {name}(\n\t.param .u32 p\n)\n{{\n\tret;\n}}\n");
        let body: String = ["closest_hits_far", "render_bvh"].map(kernel).concat();
        with_launch_bounds(&format!(".version 6.3\n.target sm_75\n{body}"))
    }

    #[test]
    fn a_sound_text_has_no_problems() {
        assert_eq!(problems(&sound()), [""; 0]);
        assert_eq!(entries(&sound()), ["closest_hits_far", "render_bvh"]);
        assert_eq!(problems(".target sm_75\n").len(), 1);
        let table = ".global .align 4 .b8 _RNvCs_4core5table5TABLE[8] = {1, 2, 3, 4, 5, 6, 7, 8};\n";
        let reads = sound().replacen("ret;", "mov.u64 %rd1, _RNvCs_4core5table5TABLE;", 1);
        assert_eq!(problems(&(table.to_owned() + &reads)), [""; 0]);
        assert_eq!(problems(&with_header(&sound(), "00", "rustc _R", &["div.full"])), [""; 0]);
    }

    #[test]
    fn every_problem_is_found() {
        let changed = |from: &str, to: &str| problems(&sound().replacen(from, to, 1));
        for (from, to) in [
            ("sm_75", "sm_90"),
            (".maxntid 128\n", ""),
            ("ret;", "call.uni _RNvNtCs_4core9panicking9panic_fmt, ();"),
            ("ret;", "call.uni _ZN4core9panicking, ();"),
            (".visible", ".extern .func f;\n.visible"),
            ("ret;", "trap;"),
            ("ret;", "sqrt.approx.f32 %f1, %f2;"),
            ("ret;", "div.full.f32 %f1, %f2, %f3;"),
            ("ret;", "add.rn.ftz.f32 %f1, %f2, %f3;"),
        ] {
            assert_eq!(changed(from, to).len(), 1, "{to}: {:?}", changed(from, to));
        }
    }

    #[test]
    fn exported_tables_are_empty() {
        let (own, exported) =
            (".global .align 4 .b8 own[2] = {1, 2};\n", ".visible .global .align 4 .b8 large[2] = {1, 2};\n");
        let text = without_exported_tables(&format!("{own}{exported}.visible .entry f(\n"));
        assert_eq!(text, format!("{own}.visible .global .align 4 .b8 large[2];\n.visible .entry f(\n"));
    }

    #[test]
    fn headers_come_back() {
        let ptx = with_header(&sound(), "0123", "rustc 1.96.0", &["-a", "-b"]);
        let header = Header::read(&ptx).unwrap();
        assert_eq!((header.hash, header.compiler, header.flags), ("0123", "rustc 1.96.0", "-a -b"));
        assert!(Header::read(&sound()).is_none());
    }
}
