//! Flags about the device. None of them changes a pixel.

use super::needs::{Need, check};
use super::values::{named, whole};
use crate::failure::Failure;
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use eosphor::{Accel, Builder, GpuScheduler, Quality, SahCosts, Scheduler, SimdLevel, Traversal};

#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Device (none of these changes a pixel)")]
pub(crate) struct DeviceFlags {
    /// The device to render on: auto (the first GPU, or the CPU if there is none), cpu, cuda (a GPU), or cuda:0,1 (several GPUs
    /// by number, 0 to 255) [default: auto]
    #[arg(long, value_name = "DEVICE", value_parser = backend)]
    pub(crate) backend: Option<BackendChoice>,
    /// Number of CPU threads, 1 to 1024 [default: all cores]
    #[arg(long, value_name = "N", value_parser = whole::<u16>(1..=1024), allow_hyphen_values = true)]
    pub(crate) threads: Option<u16>,
    /// Side of the square tiles that threads render, in pixels, 1 to 4096 [default: 32, less where threads would be idle]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=4096), allow_hyphen_values = true)]
    pub(crate) tile: Option<u32>,
    /// How to build a bvh or bvh8: morton, median, sweep, binned, hybrid or spatial; low, medium and high quality are morton,
    /// binned and spatial [default: binned; spatial for path tracing of 8 samples a triangle or more with bvh8 on CPUs, of 256
    /// with bvh on GPUs]
    #[arg(long, value_name = "NAME", value_parser = builder())]
    pub(crate) builder: Option<Builder>,
    /// Maximum number of primitives in a leaf: 1 to 255 with --accel bvh; 1 to 4294967295 with an octree, which keeps a larger
    /// cell whole if dividing it would not make it cheaper to search [default: 4 for a bvh, 16 for an octree]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=u32::MAX), allow_hyphen_values = true)]
    pub(crate) leaf_size: Option<u32>,
    /// Maximum depth of a leaf: 1 to 64 with --accel bvh, 1 to 16 with an octree, 1 to 46 with kdtree [default: 64 for a bvh,
    /// 10 for an octree, chosen by the number of primitives for a kd-tree]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=64), allow_hyphen_values = true)]
    pub(crate) tree_depth: Option<u32>,
    /// Costs for the surface area heuristic of a bvh, an octree or a kd-tree: of visiting a node, 0 or more, and of testing a
    /// primitive, over 0 [default: 1,1 for a bvh, 0,1 for an octree, 1.5,1 for a kd-tree]
    #[arg(long, value_name = "NODE,TEST", value_parser = sah_costs, allow_hyphen_values = true)]
    pub(crate) sah_costs: Option<SahCosts>,
    /// Instruction set of the CPU to use; auto is the widest that it has
    #[arg(long, value_name = "LEVEL", default_value = "auto", value_parser = simd_levels())]
    pub(crate) simd: SimdFlag,
    /// Threads per block on GPUs: a multiple of 32, 32 to 512 [default: 128]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(32..=512), allow_hyphen_values = true)]
    pub(crate) block_size: Option<u32>,
    /// Paths or nodes of Whitted's trees that a GPU has under way at a time, 4096 to 16777216 (not with --gpu-scheduler
    /// megakernel); fewer where memory is short [default: of path tracing 1048576, and up to 8388608 in an eighth of its
    /// memory; of trees 32768 to 1048576, by the shadow rays of a point]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1 << 12..=1 << 24), allow_hyphen_values = true)]
    pub(crate) gpu_paths: Option<u32>,
    /// The most memory that a scene takes on a GPU, such as 6G or 512M (K, M, G and T are powers of 1024): queues get smaller
    /// where it is short, and what does not fit is refused, or rendered by the CPU [default: what is free]
    #[arg(long, value_name = "SIZE", value_parser = super::values::bytes, allow_hyphen_values = true)]
    pub(crate) gpu_memory: Option<u64>,
    /// In which order a GPU traces rays. megakernel: each thread follows a sample to its end; queues: rays of all samples in
    /// rounds, as path tracing always has it; auto: queues, which were faster wherever that was measured
    #[arg(long, value_name = "NAME", default_value = "auto", value_parser = gpu_schedulers())]
    pub(crate) gpu_scheduler: GpuScheduler,
    /// How the threads of a warp traverse a bvh on GPUs. single: independently; vote: together, through every node that any
    /// of them needs; auto: vote for rays that start in one point and have similar directions, else single; reconverge:
    /// independently, but they wait for each other at every node and leaf; wide: as reconverge, through eight-child nodes
    #[arg(long, value_name = "NAME", default_value = "auto", value_parser = traversals())]
    pub(crate) gpu_traversal: Traversal,
    /// The order in which the CPU traces rays: batched, or scalar, the reference [default: batched]
    #[arg(long, value_name = "NAME", value_parser = schedulers(), hide = true)]
    pub(crate) scheduler: Option<Scheduler>,
}

impl DeviceFlags {
    /// Fails where paths are asked for that are in no queue.
    pub(crate) fn check_paths(&self) -> Result<(), Failure> {
        check(&[Need {
            flag: "--gpu-paths",
            is_given: self.gpu_paths.is_some(),
            is_met: self.gpu_scheduler != GpuScheduler::Megakernel,
            needs: "--gpu-scheduler queues or auto",
        }])
    }

    /// Where to render.
    pub(crate) fn backend(&self) -> &BackendChoice {
        self.backend.as_ref().unwrap_or(&BackendChoice::Auto)
    }
}

/// Where to render.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum BackendChoice {
    /// The program's choice.
    Auto,
    /// All cores.
    Cpu,
    /// NVIDIA GPUs with these numbers; the first one where there are none.
    Cuda(Vec<usize>),
}

/// What `eosphor info` looks at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AccelChoice {
    /// One structure.
    One(Accel),
    /// Every structure, in one table.
    All,
    /// Bounding volume hierarchies by every builder, in one table.
    Builders,
}

/// A level of instructions; `None` is the widest that the CPU has. (clap takes a bare `Option` to mean a flag that may
/// be absent.)
#[derive(Clone, Copy, Debug)]
pub(crate) struct SimdFlag(pub(crate) Option<SimdLevel>);

/// `auto`, `cpu`, `cuda` or `cuda:0,1`.
fn backend(text: &str) -> Result<BackendChoice, String> {
    match text {
        "auto" => return Ok(BackendChoice::Auto),
        "cpu" => return Ok(BackendChoice::Cpu),
        "cuda" => return Ok(BackendChoice::Cuda(Vec::new())),
        _ => {}
    }
    let numbers = text.strip_prefix("cuda:").and_then(|list| {
        list.split(',').map(|number| number.parse::<u8>().ok().map(usize::from)).collect::<Option<Vec<_>>>()
    });
    let mut numbers =
        numbers.ok_or("it must be auto, cpu, cuda, or cuda: and device numbers, as cuda:0,1")?;
    numbers.sort_unstable();
    numbers.dedup();
    Ok(BackendChoice::Cuda(numbers))
}

/// `1,2`.
fn sah_costs(text: &str) -> Result<SahCosts, String> {
    let numbers =
        text.split_once(',').and_then(|(a, b)| Some((a.trim().parse().ok()?, b.trim().parse().ok()?)));
    numbers.map(|(node, primitive)| SahCosts { node, primitive }).ok_or_else(|| {
        "it must be the cost of a node, a comma and the cost of a primitive's test, as in 1,2".to_owned()
    })
}

/// The name of a structure.
pub(super) fn accel() -> impl TypedValueParser<Value = Accel> {
    PossibleValuesParser::new(Accel::ALL.iter().map(|accel| accel.name())).try_map(|name| name.parse())
}

/// The name of a builder, or a quality.
fn builder() -> impl TypedValueParser<Value = Builder> {
    let builders = Builder::ALL.map(|b| (b.name(), b));
    let qualities = Quality::ALL.map(|q| (q.name(), q.options().builder));
    let named = [&qualities[..], &builders[..]].concat();
    PossibleValuesParser::new(named.iter().map(|n| n.0))
        .try_map(move |name| named.iter().find(|n| n.0 == name).map(|n| n.1).ok_or("no such builder"))
}

/// The name of a structure, or all.
pub(super) fn accels() -> impl TypedValueParser<Value = AccelChoice> {
    let names = ["all", "builders"].into_iter().chain(Accel::ALL.iter().map(|accel| accel.name()));
    PossibleValuesParser::new(names).try_map(|name| match name.as_str() {
        "all" => Ok(AccelChoice::All),
        "builders" => Ok(AccelChoice::Builders),
        name => name.parse().map(AccelChoice::One),
    })
}

fn traversals() -> impl TypedValueParser<Value = Traversal> {
    named(Traversal::ALL.map(|traversal| (traversal.name(), traversal)))
}

fn gpu_schedulers() -> impl TypedValueParser<Value = GpuScheduler> {
    named(GpuScheduler::ALL.map(|scheduler| (scheduler.name(), scheduler)))
}

fn schedulers() -> impl TypedValueParser<Value = Scheduler> {
    named([("batched", Scheduler::Batched), ("scalar", Scheduler::Scalar)])
}

fn simd_levels() -> impl TypedValueParser<Value = SimdFlag> {
    named([
        ("auto", SimdFlag(None)),
        ("baseline", SimdFlag(Some(SimdLevel::Baseline))),
        ("avx2", SimdFlag(Some(SimdLevel::Avx2))),
        ("avx512", SimdFlag(Some(SimdLevel::Avx512))),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn backends() {
        assert_eq!(backend("cpu"), Ok(BackendChoice::Cpu));
        assert_eq!(backend("cuda"), Ok(BackendChoice::Cuda(Vec::new())));
        assert_eq!(backend("cuda:3,1,3"), Ok(BackendChoice::Cuda(vec![1, 3])));
        for bad in ["", "gpu", "cuda:", "cuda:x", "cuda:-1", "cuda:0,", "cuda:999"] {
            assert!(backend(bad).is_err(), "{bad}");
        }
    }
}
