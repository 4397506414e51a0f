//! NVIDIA's assembler, which says what a kernel takes of a processor without one being there.

use super::toolchain::output_of;
use anyhow::{Context, Result, bail, ensure};
use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A wheel on PyPI that holds it. Fixed, because each version allocates registers in its own way; drivers of this CUDA
/// version (580) compile PTX alike.
const WHEEL: &str = "nvidia-cuda-nvcc==13.0.88";

/// Where it lies in the wheel.
const IN_WHEEL: &str = "nvidia/cu13/bin/ptxas";

/// What a kernel takes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Usage {
    pub(super) kernel: String,
    /// Of a thread.
    pub(super) registers: u32,
    /// Bytes written and read because there were no registers left.
    pub(super) spilled: u32,
    /// Local memory of a thread in bytes: arrays that are indexed, and what is spilled.
    pub(super) stack: u32,
}

/// `$PTXAS`; else that of the wheel, which is downloaded once, into `~/.cache/eosphor-ptxas`.
pub(super) fn find() -> Result<PathBuf> {
    if let Some(ptxas) = env::var_os("PTXAS") {
        return Ok(ptxas.into());
    }
    let home = env::var_os("HOME").context("neither PTXAS nor HOME is set")?;
    let folder = PathBuf::from(home).join(".cache/eosphor-ptxas");
    let ptxas = folder.join(IN_WHEEL);
    if !ptxas.exists() {
        eprintln!("downloading {WHEEL} (37 MB) from PyPI into {}", folder.display());
        let mut pip = Command::new("python3");
        pip.args(["-m", "pip", "install", "--quiet", "--no-deps", "--target"]).arg(&folder).arg(WHEEL);
        output_of(&mut pip)
            .context("no ptxas: set PTXAS to that of a CUDA toolkit, or get pip and a network")?;
        ensure!(ptxas.exists(), "{WHEEL} holds no {IN_WHEEL}: set PTXAS to that of a CUDA toolkit");
    }
    Ok(ptxas)
}

/// What each kernel of a PTX text takes on an architecture, sorted by name.
pub(super) fn usage(ptxas: &Path, ptx: &str, architecture: &str) -> Result<Vec<Usage>> {
    let file = env::temp_dir().join(format!("eosphor-{}-{architecture}.ptx", std::process::id()));
    fs::write(&file, ptx).with_context(|| format!("writing {}", file.display()))?;
    let mut command = Command::new(ptxas);
    command.args(["-v", &format!("-arch={architecture}"), "-o", "/dev/null"]).arg(&file);
    let output = command.output().with_context(|| format!("starting {}", ptxas.display()));
    fs::remove_file(&file)?;
    let output = output?;
    // It says everything on stderr.
    let text = String::from_utf8_lossy(&output.stderr);
    if !output.status.success() {
        bail!("ptxas -arch={architecture} failed: {}", text.trim());
    }
    let mut kernels =
        read(&text).with_context(|| format!("ptxas says something else than expected:\n{text}"))?;
    kernels.sort_by(|a, b| a.kernel.cmp(&b.kernel));
    Ok(kernels)
}

/// Reads what `ptxas -v` prints: for each kernel four lines, in this order. What it says of functions is left out: they are
/// there for what is rare.
fn read(text: &str) -> Option<Vec<Usage>> {
    let mut kernels = Vec::new();
    let mut lines = text.lines();
    while lines.any(|line| line.contains("Compiling entry function ")) {
        let (_, kernel) = lines.next()?.split_once("Function properties for ")?;
        let kernel = kernel.to_string();
        // "7544 bytes stack frame, 856 bytes spill stores, 1036 bytes spill loads"
        let [stack, stores, loads] = numbers(lines.next()?)[..] else { return None };
        // "ptxas info    : Used 255 registers, used 0 barriers, ..."
        let registers = *numbers(lines.next()?.split_once("Used ")?.1).first()?;
        kernels.push(Usage { kernel, registers, spilled: stores + loads, stack });
    }
    Some(kernels)
}

/// The words of a line that are numbers.
fn numbers(line: &str) -> Vec<u32> {
    line.split_whitespace().filter_map(|word| word.parse().ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn its_words_are_understood() {
        let text = "ptxas info    : 208 bytes gmem\n\
            ptxas info    : Compiling entry function 'render_bvh' for 'sm_90'\n\
            ptxas info    : Function properties for render_bvh\n    \
            7544 bytes stack frame, 856 bytes spill stores, 1036 bytes spill loads\n\
            ptxas info    : Used 255 registers, used 0 barriers, 7544 bytes cumulative stack size\n\
            ptxas info    : Compile time = 30009.752 ms\n\
            ptxas info    : Function properties for decide_triangle\n    \
            0 bytes stack frame, 248 bytes spill stores, 316 bytes spill loads\n";
        let bvh = Usage { kernel: "render_bvh".into(), registers: 255, spilled: 1892, stack: 7544 };
        assert_eq!(read(text), Some(vec![bvh]));
        assert_eq!(read(&text.replace("1036 bytes", "no bytes")), None);
        assert_eq!(read(""), Some(Vec::new()));
    }
}
