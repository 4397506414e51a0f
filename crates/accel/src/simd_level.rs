//! Instruction sets that traversals and the renderer are compiled for.

use std::fmt;
use std::str::FromStr;

/// An instruction set that traversals are compiled for, and chosen at run time. It changes times, and no hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "kebab-case"))]
pub enum SimdLevel {
    /// Whatever the target guarantees (SSE2 on x86-64). Fused multiply-adds are library calls: slow, and equal.
    Baseline,
    /// AVX2 and FMA.
    Avx2,
    /// AVX-512 F, BW, DQ and VL.
    Avx512,
}

impl SimdLevel {
    /// All levels, lowest first.
    pub const ALL: [SimdLevel; 3] = [SimdLevel::Baseline, SimdLevel::Avx2, SimdLevel::Avx512];

    /// Whether traversals are compiled for this level (features `avx2` and `avx512` of the crate) and this CPU has it.
    pub fn is_available(self) -> bool {
        match self {
            SimdLevel::Baseline => true,
            SimdLevel::Avx2 => cfg!(feature = "avx2") && has_avx2(),
            SimdLevel::Avx512 => cfg!(feature = "avx512") && has_avx512(),
        }
    }

    /// The levels that are available, lowest first.
    pub fn available() -> impl Iterator<Item = SimdLevel> {
        SimdLevel::ALL.into_iter().filter(|l| l.is_available())
    }

    /// The highest level that is available.
    pub fn best() -> SimdLevel {
        SimdLevel::available().last().unwrap_or(SimdLevel::Baseline)
    }
}

/// Whether this CPU has what code for AVX2 is compiled with. Builders ask for no more, whatever the features of the crate.
pub(crate) fn has_avx2() -> bool {
    #[cfg(target_arch = "x86_64")]
    return is_x86_feature_detected!("avx2")
        && is_x86_feature_detected!("fma")
        && is_x86_feature_detected!("bmi1")
        && is_x86_feature_detected!("bmi2")
        && is_x86_feature_detected!("popcnt")
        && is_x86_feature_detected!("lzcnt");
    #[cfg(not(target_arch = "x86_64"))]
    false
}

fn has_avx512() -> bool {
    #[cfg(target_arch = "x86_64")]
    return has_avx2()
        && is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512bw")
        && is_x86_feature_detected!("avx512dq")
        && is_x86_feature_detected!("avx512vl");
    #[cfg(not(target_arch = "x86_64"))]
    false
}

impl fmt::Display for SimdLevel {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            SimdLevel::Baseline => "baseline",
            SimdLevel::Avx2 => "avx2",
            SimdLevel::Avx512 => "avx512",
        })
    }
}

impl FromStr for SimdLevel {
    type Err = String;
    fn from_str(s: &str) -> Result<SimdLevel, String> {
        SimdLevel::ALL.into_iter().find(|l| l.to_string() == s).ok_or_else(|| {
            let names: Vec<String> = SimdLevel::ALL.iter().map(SimdLevel::to_string).collect();
            format!("unknown SIMD level '{s}': choose one of {}", names.join(", "))
        })
    }
}
