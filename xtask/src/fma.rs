//! `fma`: no code that runs under AVX2 or AVX-512 may call a library's fused multiply-add.
//!
//! The renderer is compiled once for each instruction set from code that is inlined into one function for each. What is
//! not inlined is compiled for the baseline, and there a fused multiply-add is a library call, ten times slower. This
//! command disassembles the binary and follows calls from those functions.

use crate::build_program;
use anyhow::{Context, Result, bail, ensure};
use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

/// Functions that the check starts from, as parts of their mangled names.
const ENTRIES: [&str; 6] = [
    "render_tile_avx2",
    "render_tile_avx512",
    "query_avx2",
    "query_avx512",
    "develop_row_avx2",
    "bent_row_avx2",
];

/// What is called on CPUs without vectors alone: at hand to all code, and never run by the code that is looked at.
const OF_OTHER_CPUS: [&str; 2] = ["with_portable", "without_fma"];

/// Functions of bvh8 that are compiled for the baseline, and known to call a library fma where they read a triangle. They decide
/// about hits that are not clear, in double precision, which is rare and takes far longer.
const RARE: [&str; 3] = ["5Found5offer", "5Found8is_after", "5found7rest_of"];

/// Library functions that do a fused multiply-add.
const LIBRARY_FMA: [&str; 6] = ["fmaf", "fma", "fmaf@plt", "fma@plt", "fmaf_with_fma", "fma_with_fma"];

pub(crate) fn run(arguments: &[String]) -> Result<()> {
    let binary = match arguments {
        [] => build_program()?.display().to_string(),
        [path] => path.clone(),
        _ => bail!("usage: cargo xtask fma [BINARY]"),
    };
    let calls = CallGraph::read(&binary)?;
    for entry in ENTRIES {
        let starts: Vec<&String> = calls.functions.keys().filter(|name| name.contains(entry)).collect();
        ensure!(!starts.is_empty(), "{binary} has no function {entry}");
        for start in starts {
            if let Some(path) = calls.path_to_fma(start) {
                bail!("{entry} calls a library fma: {}", path.join(" -> "));
            }
            let reached = calls.reachable(start).len();
            println!("{entry}: no library fma among {reached} functions it reaches");
        }
    }
    Ok(())
}

/// Who calls whom.
struct CallGraph {
    functions: BTreeMap<String, BTreeSet<String>>,
}

impl CallGraph {
    fn read(binary: &str) -> Result<CallGraph> {
        let code = objdump(&["-d", "--no-show-raw-insn", binary])?;
        let slots = got_slots(&objdump(&["-R", binary])?);
        let mut functions: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        let mut names_by_address = BTreeMap::new();
        let mut current = String::new();
        for line in code.lines() {
            if let Some((address, name)) = line.strip_suffix(">:").and_then(|l| l.split_once(" <")) {
                current = name.to_owned();
                names_by_address.insert(u64::from_str_radix(address, 16)?, current.clone());
                functions.entry(current.clone()).or_default();
            } else if let Some(callee) = callee(line, &slots) {
                functions.entry(current.clone()).or_default().insert(callee);
            }
        }
        // Calls through the global offset table to functions of the binary itself come as addresses.
        for callees in functions.values_mut() {
            *callees = callees
                .iter()
                .map(|callee| {
                    let address =
                        callee.strip_prefix("*ABS*+0x").and_then(|a| u64::from_str_radix(a, 16).ok());
                    address.and_then(|a| names_by_address.get(&a)).unwrap_or(callee).clone()
                })
                .collect();
        }
        Ok(CallGraph { functions })
    }

    /// A chain of calls from `start` to a library fma.
    fn path_to_fma(&self, start: &str) -> Option<Vec<String>> {
        let mut came_from: BTreeMap<&str, &str> = BTreeMap::new();
        let mut pending = vec![start];
        while let Some(name) = pending.pop() {
            // Mangled names carry the plain one between lengths: `4fmaf17h`.
            let is_fma =
                LIBRARY_FMA.iter().any(|f| name == *f || name.contains(&format!("{}{f}17h", f.len())));
            if is_fma {
                let mut path = vec![name.to_owned()];
                let mut at = name;
                while let Some(before) = came_from.get(at) {
                    path.insert(0, (*before).to_owned());
                    at = before;
                }
                return Some(path);
            }
            for callee in self.functions.get(name).into_iter().flatten() {
                let is_left_out = OF_OTHER_CPUS.iter().chain(&RARE).any(|name| callee.contains(name));
                if callee != start && !is_left_out && !came_from.contains_key(callee.as_str()) {
                    came_from.insert(callee, name);
                    pending.push(callee);
                }
            }
        }
        None
    }

    fn reachable<'a>(&'a self, start: &'a str) -> BTreeSet<&'a str> {
        let mut seen = BTreeSet::from([start]);
        let mut pending = vec![start];
        while let Some(name) = pending.pop() {
            let callees = self.functions.get(name).into_iter().flatten().map(String::as_str);
            let callees = callees.filter(|callee| !OF_OTHER_CPUS.iter().any(|name| callee.contains(name)));
            pending.extend(callees.filter(|callee| seen.insert(callee)));
        }
        seen
    }
}

fn objdump(arguments: &[&str]) -> Result<String> {
    let output = Command::new("objdump").args(arguments).output().context("cannot run objdump (binutils)")?;
    ensure!(output.status.success(), "objdump failed: {}", String::from_utf8_lossy(&output.stderr));
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// From the addresses of the global offset table to what they hold.
fn got_slots(relocations: &str) -> BTreeMap<u64, String> {
    let slot = |line: &str| {
        let mut words = line.split_whitespace();
        let address = u64::from_str_radix(words.next()?, 16).ok()?;
        let value = words.nth(1)?;
        Some((address, value.split('@').next()?.to_owned()))
    };
    relocations.lines().filter_map(slot).collect()
}

/// What a line of disassembly calls or jumps to outside its function. A function whose address is loaded counts as called:
/// what is called in a loop is held in a register.
fn callee(line: &str, slots: &BTreeMap<u64, String>) -> Option<String> {
    let (_, instruction) = line.split_once('\t')?;
    let (operation, operand) = instruction.split_once(' ')?;
    if let Some((_, comment)) = operand.split_once("# ") {
        let address = u64::from_str_radix(comment.split_whitespace().next()?, 16).ok()?;
        return slots.get(&address).cloned();
    }
    if !operation.starts_with("call") && !operation.starts_with('j') {
        return None;
    }
    let name = operand.split_once('<')?.1.strip_suffix('>')?;
    // An offset means a jump within a function.
    (!name.contains("+0x")).then(|| name.to_owned())
}
