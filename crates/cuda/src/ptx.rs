//! The kernels, as a text that the driver compiles for its device. `cargo xtask ptx` makes it from `gpu/`.

/// PTX for compute capability 7.5, which loads on everything since Turing.
pub(crate) const PTX: &str = include_str!("../ptx/eosphor.ptx");

/// The oldest devices that [`PTX`] loads on.
pub(crate) const OLDEST_CAPABILITY: (i32, i32) = (7, 5);

/// The most threads of a block that the kernels are compiled for: with more, each would have fewer registers.
pub(crate) const MOST_THREADS: u32 = 128;

/// The text with these kernels alone, and the functions that they may call: the driver compiles all that it is given, which takes a second a kernel or so.
pub(crate) fn text(kernels: &[&str]) -> String {
    let mut out = String::new();
    let mut left_out = false;
    for line in PTX.lines() {
        if let Some(name) = entry_name(line) {
            left_out = !kernels.contains(&name);
        }
        if !left_out {
            out.push_str(line);
            out.push('\n');
        }
        // What is below belongs to no kernel.
        left_out &= line != "}";
    }
    out
}

/// The name of the kernel that starts on a line.
fn entry_name(line: &str) -> Option<&str> {
    line.strip_prefix(".visible .entry ")?.strip_suffix('(')
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::Traversal;
    use crate::parameters::Kind;
    use crate::rays::{RAY_KERNELS, bvh_parameters};
    use crate::scene::scene_parameters;
    use crate::structure::{Structure, kernel, pairs};
    use eosphor_render::{Accel, Builder, Hierarchy};
    use eosphor_scene::{LoadOptions, SceneData, load};

    /// The structures that have a kernel, and its names.
    fn kernels() -> impl Iterator<Item = (Accel, &'static str)> {
        let of = |accel| [kernel(accel, false), kernel(accel, true)].map(|name| Some((accel, name.ok()?)));
        let mut all: Vec<_> = Accel::ALL.iter().flat_map(|&accel| of(accel)).flatten().collect();
        all.dedup();
        all.into_iter()
    }

    /// The parameters that a kernel declares.
    fn declared(kernel: &str) -> Vec<Kind> {
        let kind = |line: &str| {
            let words: Vec<&str> = line.split_whitespace().collect();
            match words[..] {
                [".param", ".u64", ".ptr", ".align", align, _] => {
                    Kind::Array { align: align.parse().unwrap() }
                }
                [".param", ".u64", _] => Kind::Count,
                [".param", ".u32", _] => Kind::Number,
                [".param", ".f32", _] => Kind::Float,
                _ => panic!("{kernel}: {line}"),
            }
        };
        let start = PTX.find(&format!(".entry {kernel}(")).expect("the kernel is there");
        PTX[start..].lines().skip(1).take_while(|line| !line.starts_with(')')).map(kind).collect()
    }

    #[test]
    fn kernels_take_what_is_passed() {
        let scene = load("builtin:cornell", &LoadOptions::default()).unwrap().scene;
        let data = SceneData::flatten(&scene).unwrap().0;
        // What a launch adds: the rows, the film, which is a raw pointer, and the totals.
        let launch =
            [Kind::Number, Kind::Number, Kind::Array { align: 1 }, Kind::Array { align: align_of::<u64>() }];
        for (accel, name) in kernels() {
            let hierarchy = Hierarchy::build(accel, Builder::Binned, &data);
            let structure = Structure::new(&hierarchy, Traversal::Auto).unwrap();
            let parameters = scene_parameters(&data.view(), &structure).unwrap();
            assert_eq!(declared(name), [parameters.kinds(), &launch].concat(), "{name}");
        }
    }

    #[test]
    fn ray_kernels_take_what_is_passed() {
        let scene = load("builtin:cornell", &LoadOptions::default()).unwrap().scene;
        let data = SceneData::flatten(&scene).unwrap().0;
        let Hierarchy::Bvh(bvh) = Hierarchy::build(Accel::Bvh, Builder::Binned, &data) else {
            unreachable!()
        };
        let pairs = pairs(&bvh).unwrap();
        let parameters = bvh_parameters(&bvh, &pairs, Traversal::Auto);
        // What a launch adds: the rays, their number, and two arrays of answers, which are raw pointers.
        let rays = Kind::Array { align: align_of::<eosphor_core::ray::Ray>() };
        let answers = Kind::Array { align: 1 };
        let launch = [rays, Kind::Number, answers, answers];
        for name in RAY_KERNELS.concat() {
            assert_eq!(declared(name), [parameters.kinds(), &launch].concat(), "{name}");
        }
    }

    #[test]
    fn a_text_has_one_kernel_and_all_that_it_needs() {
        let entries = |text: &str| text.lines().filter_map(entry_name).map(str::to_owned).collect::<Vec<_>>();
        assert_eq!(entries(PTX).len(), kernels().count() + RAY_KERNELS.concat().len());
        // Tables of constants stand before the kernels.
        let tables = |text: &str| text.lines().filter(|line| line.starts_with(".global")).count();
        for (_, name) in kernels() {
            let text = text(&[name]);
            assert_eq!(entries(&text), [name]);
            assert_eq!(tables(&text), tables(PTX));
            assert!(text.contains(&format!("\n.maxntid {MOST_THREADS}\n")));
            // And all functions, declared at the top.
            for function in ["decide_triangle(", "decide_sphere(", "closest_hit_of_any_ray("] {
                assert_eq!(text.matches(function).count(), 1);
            }
            let functions =
                text.lines().filter(|line| line.starts_with(".visible .func") && line.ends_with('('));
            assert_eq!(text.lines().filter(|&line| line == "}").count(), 1 + functions.count());
            assert_eq!(text.matches('{').count(), text.matches('}').count());
        }
    }

    #[test]
    fn the_target_is_that_of_the_oldest_devices() {
        let (major, minor) = OLDEST_CAPABILITY;
        assert!(PTX.contains(&format!("\n.target sm_{major}{minor}\n")));
    }
}
