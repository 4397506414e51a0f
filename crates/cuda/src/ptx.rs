//! The kernels, as a text that the driver compiles for its device. `cargo xtask ptx` makes it from `gpu/`.

use crate::ptx_text::Parts;
use std::sync::OnceLock;

/// PTX for compute capability 7.5, which loads on everything since Turing.
pub(crate) const PTX: &str = include_str!("../ptx/eosphor.ptx");

/// The oldest devices that [`PTX`] loads on.
pub(crate) const OLDEST_CAPABILITY: (i32, i32) = (7, 5);

/// The threads of a block that [`PTX`] is for. With more, each may have fewer registers.
pub(crate) const USUAL_THREADS: u32 = 128;

/// The most threads of a block. A processor has 65,536 registers: each thread of so many may have 128, the bound of kernels that
/// render through a `bvh`; others then keep more in memory.
pub(crate) const MOST_THREADS: u32 = 512;

/// Registers of a processor, of which a block must have enough; threads get a multiple of the second number.
const REGISTERS: u32 = 65_536;
const REGISTERS_STEP: u32 = 8;

/// The text with these kernels alone, and the functions that they call, for blocks of up to so many threads.
pub(crate) fn text(kernels: &[&str], threads: u32) -> String {
    static PARTS: OnceLock<Parts<'static>> = OnceLock::new();
    let text = PARTS.get_or_init(|| Parts::of(PTX)).with_kernels(kernels);
    if threads <= USUAL_THREADS {
        return text;
    }
    let text = text.replace(&launch_bounds(USUAL_THREADS), &launch_bounds(threads));
    let most = REGISTERS / threads / REGISTERS_STEP * REGISTERS_STEP;
    let fewer = |line: &str| match line.strip_prefix(".maxnreg ").and_then(|n| n.trim().parse::<u32>().ok()) {
        Some(registers) if registers > most => format!(".maxnreg {most}\n"),
        _ => line.into(),
    };
    text.split_inclusive('\n').map(fewer).collect()
}

/// The line that tells the driver how large blocks are.
fn launch_bounds(threads: u32) -> String {
    format!("\n.maxntid {threads}\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::develop_launch;
    use crate::parameters::Kind;
    use crate::ptx_text::{kernel_name, table_name};
    use crate::queue_launch::SharedNames;
    use crate::queue_room::Queued;
    use crate::rays::{bvh_parameters, far_ray_kernels, ray_kernels};
    use crate::scene::scene_parameters;
    use crate::scheduler::GpuScheduler;
    use crate::structure::{KernelNames, Structure, Trees, WalkNames, kernels};
    use crate::traversal::Traversal;
    use eosphor_core::device::{BandLaunch, DevelopLaunch, PathLaunch};
    use eosphor_core::settings::Integrator;
    use eosphor_core::view::SceneArray;
    use eosphor_render::{Accel, Hierarchy, HierarchyOptions, build_hierarchy};
    use eosphor_scene::{LoadOptions, SceneData, load};

    /// The structures that have a kernel, the ways through them, and whether it counts.
    fn structure_kernels() -> Vec<(Accel, Traversal, bool, &'static str)> {
        let mut all: Vec<(Accel, Traversal, bool, &'static str)> = Vec::new();
        let ways = || Traversal::ALL.into_iter().flat_map(|t| [(t, false, false), (t, true, false)]);
        for &accel in Accel::ALL {
            for (traversal, placed, counts) in ways().chain([(Traversal::Auto, true, true)]) {
                for (integrator, scheduler) in [
                    (Integrator::Whitted, GpuScheduler::Megakernel),
                    (Integrator::Whitted, GpuScheduler::Queues),
                    (Integrator::Path, GpuScheduler::Queues),
                ] {
                    let names = match kernels(accel, traversal, placed, counts, integrator, scheduler) {
                        Ok(KernelNames::Whole(name)) => vec![name],
                        Ok(KernelNames::Queues(WalkNames { hits, seen, crossed })) => {
                            vec![hits, seen, crossed]
                        }
                        Err(_) => continue,
                    };
                    for name in names {
                        if !all.iter().any(|&(.., other)| other == name) {
                            all.push((accel, traversal, counts, name));
                        }
                    }
                }
            }
        }
        all
    }

    /// Those that every structure shares.
    fn shared_kernels() -> Vec<&'static str> {
        let mut all: Vec<&'static str> = Vec::new();
        for of in [Queued::Paths, Queued::Trees] {
            let SharedNames { prepare, begin, generate, shading, lighting, settle } = SharedNames::of(of);
            all.extend(prepare.into_iter().chain([begin, generate, settle]).chain(shading.iter().copied()));
            all.extend(lighting.into_iter().flatten());
        }
        all.push(develop_launch::KERNEL);
        all.sort_unstable();
        all.dedup();
        all
    }

    /// The kernels that answer queries, and the ways that they go.
    fn query_kernels() -> Vec<(Traversal, &'static str)> {
        let of = |traversal| ray_kernels(traversal).concat().into_iter().map(move |name| (traversal, name));
        let far = far_ray_kernels(Traversal::Auto).expect("there are some").concat();
        let all = [Traversal::Auto, Traversal::Reconverge, Traversal::Wide].into_iter().flat_map(of);
        all.chain(far.into_iter().map(|name| (Traversal::Auto, name))).collect()
    }

    /// What a kernel declares.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    enum Declared {
        Parameter(Kind),
        /// A structure, passed by value.
        Structure {
            align: usize,
            bytes: usize,
        },
    }

    /// The parameters that a kernel declares.
    fn declared(kernel: &str) -> Vec<Declared> {
        let kind = |line: &str| {
            let words: Vec<&str> = line.split_whitespace().collect();
            match words[..] {
                [".param", ".u64", ".ptr", ".align", align, _] => {
                    Declared::Parameter(Kind::Array { align: align.parse().unwrap() })
                }
                [".param", ".u64", _] => Declared::Parameter(Kind::Count),
                [".param", ".u32", _] => Declared::Parameter(Kind::Number),
                [".param", ".align", align, ".b8", name] => {
                    let (_, bytes) = name.trim_end_matches([']', ',']).split_once('[').unwrap();
                    Declared::Structure { align: align.parse().unwrap(), bytes: bytes.parse().unwrap() }
                }
                _ => panic!("{kernel}: {line}"),
            }
        };
        let start = PTX.find(&format!(".entry {kernel}(")).expect("the kernel is there");
        PTX[start..].lines().skip(1).take_while(|line| !line.starts_with(')')).map(kind).collect()
    }

    fn passed(kinds: &[Kind]) -> Vec<Declared> {
        kinds.iter().copied().map(Declared::Parameter).collect()
    }

    #[test]
    fn kernels_take_what_is_passed() {
        let scene = load("builtin:cornell", &LoadOptions::default()).unwrap().scene;
        let data = SceneData::flatten(&scene).unwrap().0;
        let band = Declared::Structure { align: align_of::<BandLaunch>(), bytes: size_of::<BandLaunch>() };
        let paths = Declared::Structure { align: align_of::<PathLaunch>(), bytes: size_of::<PathLaunch>() };
        let develop =
            Declared::Structure { align: align_of::<DevelopLaunch>(), bytes: size_of::<DevelopLaunch>() };
        for (accel, traversal, counts, name) in structure_kernels() {
            let hierarchy = build_hierarchy(accel, &HierarchyOptions::default(), &data).unwrap();
            let structure = match counts {
                true => Structure::for_counting(&hierarchy),
                false => Structure::new(&hierarchy, traversal, 0).unwrap(),
            };
            let parameters = scene_parameters(&data.view(), &structure).unwrap();
            let launch = if name.starts_with("render_") { band } else { paths };
            assert_eq!(declared(name), [passed(parameters.kinds()), vec![launch]].concat(), "{name}");
            let of_scene = parameters.kinds().len() - SceneArray::ALL.len();
            for shared in shared_kernels() {
                let develops = shared == develop_launch::KERNEL;
                let is_alone = develops || ["paths_begin", "trees_begin", "trees_prepare"].contains(&shared);
                let own = if is_alone { &[] } else { &parameters.kinds()[of_scene..] };
                let launch = if develops { develop } else { paths };
                assert_eq!(declared(shared), [passed(own), vec![launch]].concat(), "{shared}");
            }
        }
    }

    #[test]
    fn ray_kernels_take_what_is_passed() {
        let scene = load("builtin:cornell", &LoadOptions::default()).unwrap().scene;
        let data = SceneData::flatten(&scene).unwrap().0;
        let Hierarchy::Bvh(bvh) = build_hierarchy(Accel::Bvh, &HierarchyOptions::default(), &data).unwrap()
        else {
            unreachable!()
        };
        // What a launch adds: the rays, their number, and two arrays of answers, which are raw pointers.
        let rays = Kind::Array { align: align_of::<eosphor_core::ray::Ray>() };
        let answers = Kind::Array { align: 1 };
        let launch = [rays, Kind::Number, answers, answers];
        for (traversal, name) in query_kernels() {
            let trees = Trees::new(&bvh, traversal, 0).unwrap();
            let parameters = bvh_parameters(&bvh, &trees);
            assert_eq!(declared(name), passed(&[parameters.kinds(), &launch].concat()), "{name}");
        }
    }

    #[test]
    fn a_text_has_one_kernel_and_what_it_needs() {
        let entries =
            |text: &str| text.lines().filter_map(kernel_name).map(str::to_owned).collect::<Vec<_>>();
        let shared = shared_kernels();
        assert_eq!(entries(PTX).len(), structure_kernels().len() + shared.len() + query_kernels().len());
        // Tables of constants stand before the kernels.
        let tables = |text: &str| text.lines().filter_map(table_name).map(str::to_owned).collect::<Vec<_>>();
        let all_tables = tables(PTX);
        let of_structures = structure_kernels().into_iter().map(|(.., name)| name);
        for name in of_structures.chain(shared.iter().copied()) {
            let traces = !shared.contains(&name);
            let larger = text(&[name], MOST_THREADS);
            let text = text(&[name], USUAL_THREADS);
            assert_eq!(entries(&text), [name]);
            let of_text = tables(&text);
            for table in &all_tables {
                let is_read = text.lines().any(|line| table_name(line).is_none() && line.contains(table));
                assert_eq!(of_text.contains(table), is_read, "{name} {table}");
            }
            assert_eq!(text.matches(&launch_bounds(USUAL_THREADS)).count(), 1);
            let fewer = text.replace(".maxntid 128", ".maxntid 512").replace(".maxnreg 168", ".maxnreg 128");
            assert_eq!(larger, fewer);
            // All functions that it calls, declared at the top and defined, and no others.
            for function in ["intersect_triangle(", "intersect_sphere("] {
                assert_eq!(text.matches(function).count(), usize::from(traces), "{name}");
            }
            let is_wide = name == "hits_bvh_wide";
            assert_eq!(text.matches("closest_hit_of_any_ray_wide(").count(), is_wide as usize);
            let (mut called, mut defined) = (Vec::new(), Vec::new());
            for line in text.lines() {
                if let Some(call) = line.trim_start().strip_prefix("call.uni ") {
                    called.push(call.trim_start_matches("(retval0), ").split(',').next().unwrap());
                }
                if line.starts_with(".visible .func") && line.ends_with('(') {
                    defined.push(line.split_whitespace().last().unwrap().trim_end_matches('('));
                }
            }
            for names in [&mut called, &mut defined] {
                names.sort_unstable();
                names.dedup();
            }
            assert_eq!(called, defined, "{name}");
            assert_eq!(text.lines().filter(|&line| line == "}").count(), 1 + defined.len());
            assert_eq!(text.matches('{').count(), text.matches('}').count());
        }
    }

    #[test]
    fn the_target_is_that_of_the_oldest_devices() {
        let (major, minor) = OLDEST_CAPABILITY;
        assert!(PTX.contains(&format!("\n.target sm_{major}{minor}\n")));
    }
}
