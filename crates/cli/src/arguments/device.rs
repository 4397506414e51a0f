//! Flags about the device. None of them changes a pixel.

use super::values::named;
use clap::{Args, value_parser};
use eosphor::{Accel, SimdLevel};

#[derive(Debug, Args)]
#[command(next_help_heading = "Device (none of these changes a pixel)")]
pub(crate) struct DeviceFlags {
    /// Where to render; auto takes the fastest there is
    #[arg(long, value_name = "DEVICE", default_value = "auto", value_parser = backends())]
    pub(crate) backend: BackendChoice,
    /// CPU threads; all cores otherwise
    #[arg(long, value_name = "N", value_parser = value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// Side of the squares that threads render, in pixels
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..=4096))]
    pub(crate) tile: Option<u32>,
    /// The hierarchy over the primitives
    #[arg(long, value_name = "NAME", default_value = "bvh", value_parser = accels())]
    pub(crate) accel: Accel,
    /// Instructions of the CPU; auto takes the widest there are
    #[arg(long, value_name = "LEVEL", default_value = "auto", value_parser = simd_levels())]
    pub(crate) simd: SimdFlag,
}

/// Where to render.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BackendChoice {
    /// The fastest there is.
    Auto,
    /// All cores.
    Cpu,
    /// NVIDIA GPUs.
    Cuda,
}

/// A level of instructions; `None` is the widest that the CPU has. (clap takes a bare `Option` to mean a flag that may
/// be absent.)
#[derive(Clone, Copy, Debug)]
pub(crate) struct SimdFlag(pub(crate) Option<SimdLevel>);

fn backends() -> impl clap::builder::TypedValueParser<Value = BackendChoice> {
    named([("auto", BackendChoice::Auto), ("cpu", BackendChoice::Cpu), ("cuda", BackendChoice::Cuda)])
}

fn accels() -> impl clap::builder::TypedValueParser<Value = Accel> {
    named([("bvh", Accel::Bvh), ("none", Accel::None)])
}

fn simd_levels() -> impl clap::builder::TypedValueParser<Value = SimdFlag> {
    named([
        ("auto", SimdFlag(None)),
        ("baseline", SimdFlag(Some(SimdLevel::Baseline))),
        ("avx2", SimdFlag(Some(SimdLevel::Avx2))),
        ("avx512", SimdFlag(Some(SimdLevel::Avx512))),
    ])
}
