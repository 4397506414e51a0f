//! `cargo xtask ptx --registers`: what the kernels take of a processor, and whether that is within their budgets.
//!
//! Registers decide how many threads run at a time, what is spilled goes through memory, and the driver sets aside a
//! stack for every thread that can run. A change in core may raise any of them without a test's noticing.

use super::ptx_text::Parts;
use super::ptxas::{self, Usage};
use super::text::entries;
use anyhow::{Context, Result, bail};
use std::fs;
use std::path::Path;

/// Turing, the oldest that is supported, and Hopper, which is measured.
const ARCHITECTURES: [&str; 2] = ["sm_75", "sm_90"];

/// The most that a kernel may take on any architecture.
struct Budget {
    kernel: &'static str,
    registers: u32,
    /// Bytes written and read, together.
    spilled: u32,
    stack: u32,
}

const fn budget(kernel: &'static str, registers: u32, spilled: u32, stack: u32) -> Budget {
    Budget { kernel, registers, spilled, stack }
}

/// What they take now and a little more, so that growth is noticed. 255 registers are all that a thread can have; ptxas gives
/// fewer to some kernels that call functions for what is rare, and spills around the calls. Since picture version 4 more is
/// decided in double precision, in functions: that is most of the spills and of the stack. Since version 5 lamps in glossy
/// lobes are weighted, and textures have the channels of their files: 2 to 5 percent more spills. Tables of rough glass that the
/// host writes cost kernels that shade paths 10 percent more of them, and no time.
const BUDGETS: [Budget; 41] = [
    budget("closest_hits_bvh", 48, 1800, 2700),
    budget("closest_hits_far", 72, 3700, 2700),
    budget("closest_hits_in_step", 48, 1800, 2700),
    budget("closest_hits_wide", 48, 2000, 2200),
    budget("closest_hits_world", 48, 1400, 2700),
    budget("closest_hits_world_far", 72, 1600, 2700),
    budget("closest_hits_world_in_step", 48, 1200, 2700),
    budget("closest_hits_world_wide", 48, 1500, 2200),
    budget("crossed_bvh", 128, 700, 3100),
    budget("crossed_bvh_in_step", 128, 800, 3100),
    budget("crossed_bvh_wide", 128, 700, 2500),
    budget("crossed_bvh_world", 128, 1100, 3100),
    budget("develop_film", 48, 0, 16),
    budget("hits_bvh", 48, 2000, 3100),
    budget("hits_bvh_in_step", 48, 2100, 3100),
    budget("hits_bvh_wide", 48, 2200, 2500),
    budget("hits_bvh_world", 48, 1800, 3100),
    budget("occluded_bvh", 48, 900, 2400),
    budget("occluded_far", 72, 2300, 2500),
    budget("occluded_in_step", 48, 900, 2400),
    budget("occluded_wide", 48, 900, 1900),
    budget("occluded_world", 48, 600, 2400),
    budget("occluded_world_far", 72, 500, 2500),
    budget("occluded_world_in_step", 48, 600, 2400),
    budget("occluded_world_wide", 48, 600, 1900),
    budget("paths_begin", 16, 0, 0),
    budget("paths_generate", 80, 50, 50),
    budget("paths_settle", 48, 0, 0),
    budget("paths_shade", 168, 3700, 1200),
    budget("paths_shade_matte", 168, 1600, 700),
    budget("render_bvh", 128, 6300, 12100),
    budget("render_bvh_world", 128, 6100, 12100),
    budget("seen_bvh", 48, 800, 2900),
    budget("seen_bvh_in_step", 48, 800, 2900),
    budget("seen_bvh_wide", 48, 800, 2300),
    budget("seen_bvh_world", 48, 500, 2900),
    budget("trees_ask", 96, 400, 300),
    budget("trees_generate", 80, 50, 50),
    budget("trees_shade", 255, 200, 400),
    budget("trees_shade_ends", 80, 700, 500),
    budget("trees_sum", 80, 50, 50),
];

/// The budget of kernels that are not in the table: those that count, and new ones until they are measured.
const OTHERS: Budget = budget("others", 255, 9999, 12000);

/// Prints the table of the PTX in a file.
pub(super) fn check(ptx: &Path) -> Result<()> {
    let ptxas = ptxas::find()?;
    // Each takes half a minute or more.
    let ptx = &fs::read_to_string(ptx).with_context(|| format!("reading {}", ptx.display()))?;
    let kernels = &entries(ptx);
    let parts = &Parts::of(ptx);
    let all: Vec<Vec<Usage>> = std::thread::scope(|scope| {
        let ptxas = &ptxas;
        // Each by itself, as the driver gets it.
        let usage = move |kernel, architecture| {
            ptxas::usage(ptxas, &parts.with_kernels(&[kernel]), architecture)?
                .pop()
                .with_context(|| format!("ptxas does not find {kernel}"))
        };
        let start = |architecture| {
            scope.spawn(move || {
                kernels.iter().map(|kernel| usage(kernel, architecture)).collect::<Result<_>>()
            })
        };
        let workers: Vec<_> = ARCHITECTURES.map(start).into();
        workers.into_iter().map(|worker| worker.join().expect("it does not panic")).collect::<Result<_>>()
    })?;
    println!("| kernel | architecture | registers | spilled bytes | stack bytes |\n|---|---|--:|--:|--:|");
    let mut problems = Vec::new();
    for (architecture, kernels) in ARCHITECTURES.iter().zip(&all) {
        for Usage { kernel, registers, spilled, stack } in kernels {
            println!("| `{kernel}` | {architecture} | {registers} | {spilled} | {stack} |");
        }
        problems.extend(over_budget(kernels).into_iter().map(|problem| format!("{architecture}: {problem}")));
    }
    if problems.is_empty() {
        return Ok(());
    }
    bail!("{}; make it less, or raise BUDGETS in xtask/src/ptx/registers.rs and say why", problems.join("; "))
}

/// What exceeds its budget, and kernels of the table that are not there.
fn over_budget(kernels: &[Usage]) -> Vec<String> {
    let is_missing = |budget: &&Budget| !kernels.iter().any(|usage| usage.kernel == budget.kernel);
    let missing = BUDGETS.iter().filter(is_missing).map(|budget| format!("there is no {}", budget.kernel));
    let mut problems: Vec<String> = missing.collect();
    for usage in kernels {
        let budget = BUDGETS.iter().find(|budget| usage.kernel == budget.kernel).unwrap_or(&OTHERS);
        for (what, has, may) in [
            ("registers", usage.registers, budget.registers),
            ("bytes spilled", usage.spilled, budget.spilled),
            ("bytes of stack", usage.stack, budget.stack),
        ] {
            if has > may {
                problems.push(format!("{} has {has} {what}, and may have {may}", usage.kernel));
            }
        }
    }
    problems
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_exceeds_its_budget_is_named() {
        let usage = |b: &Budget| Usage {
            kernel: b.kernel.into(),
            registers: b.registers,
            spilled: b.spilled,
            stack: b.stack,
        };
        let mut kernels: Vec<Usage> = BUDGETS.iter().map(usage).collect();
        assert_eq!(over_budget(&kernels), [""; 0]);
        kernels[1].spilled += 1;
        let problems = over_budget(&kernels);
        assert!(problems.len() == 1 && problems[0].starts_with("closest_hits_far has"), "{problems:?}");
        assert_eq!(over_budget(&kernels[2..]).len(), 2);
    }
}
