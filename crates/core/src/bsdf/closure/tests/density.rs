//! Samples are as dense as is said, and weigh what their value says.

use super::chi_square::{chance_of_more, chi_square};
use super::quadrature::Cell;
use super::*;
use crate::sampling::{mix, sobol_2d};

fn closures(alpha: f32) -> [(&'static str, Closure); 12] {
    let half = Vec3::splat(0.5);
    let mixed =
        Closure { metal: 0.25, metal_f0: vec3(0.2, 0.1, 0.05), glass: 0.25, ..white(0.5, 0.04, alpha) };
    [
        ("rough base", Closure { diffuse: half, diffuse_roughness: 1.0, alpha, ..nothing() }),
        ("layer over rough base", Closure { diffuse_roughness: 0.8, ..white(0.0, 0.04, alpha) }),
        ("metal", white(1.0, 0.0, alpha)),
        ("layer over base", white(0.0, 0.04, alpha)),
        ("layer over black", Closure { diffuse: Vec3::ZERO, ..white(0.0, 0.04, alpha) }),
        ("entering glass", glass(1.5, false, alpha)),
        ("leaving glass", Closure { glass_tint: half, ..glass(1.0 / 1.5, false, alpha) }),
        ("entering diamond", glass(2.5, false, alpha)),
        ("leaving ice to air", glass(1.0 / 1.1, false, alpha)),
        ("pane", glass(1.5, true, alpha)),
        ("all", mixed),
        ("all, with a tinted pane", Closure { is_thin: true, glass_tint: vec3(0.3, 0.6, 0.1), ..mixed }),
    ]
}

fn random(i: u32) -> f32 {
    (mix(i) >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// The shares of samples that come to nothing and that are single directions, by points that are spread evenly.
fn gone_and_single(closure: &Closure, to_viewer: Vec3, count: u32) -> [f64; 2] {
    let mixture = closure.towards(to_viewer);
    let mut found = [0u32; 2];
    for i in 0..count {
        let u = sobol_2d(i).map(|x| (x >> 8) as f32 * (1.0 / 16_777_216.0));
        match mixture.sample([(i as f32 + 0.5) / count as f32, u[1]], || u[0]) {
            None => found[0] += 1,
            Some(sample) => found[1] += u32::from(sample.is_delta),
        }
    }
    found.map(|n| f64::from(n) / f64::from(count))
}

/// Boxes of the sphere, none of which is expected to have much of the samples, each with its integral of the density.
struct Boxes {
    /// A box, or the first of its four parts.
    nodes: Vec<(Cell, Option<usize>, f64)>,
    roots: usize,
}

impl Boxes {
    fn new(mixture: &Mixture, error: f64) -> Boxes {
        let pdf = |d: Vec3| f64::from(mixture.eval(d).pdf);
        let integral = |cell: Cell| (cell, None, cell.integral(&pdf, error));
        let mut nodes: Vec<_> = Cell::grid(8, 8).into_iter().map(integral).collect();
        let roots = nodes.len();
        let mut next = 0;
        while next < nodes.len() {
            if nodes[next].2 > 1.0 / 48.0 {
                nodes[next].1 = Some(nodes.len());
                let parts = nodes[next].0.quarters();
                nodes.extend(parts.map(integral));
            }
            next += 1;
        }
        Boxes { nodes, roots }
    }

    fn at(&self, d: Vec3) -> usize {
        let find = |range: std::ops::Range<usize>| {
            range.clone().find(|&i| self.nodes[i].0.contains(d)).unwrap_or(range.start)
        };
        let mut node = find(0..self.roots);
        while let Some(first) = self.nodes[node].1 {
            node = find(first..first + 4);
        }
        node
    }

    /// Of what has no parts.
    fn shares(&self) -> Vec<f64> {
        self.nodes.iter().map(|node| if node.1.is_none() { node.2 } else { 0.0 }).collect()
    }
}

/// The number of samples of each case that is asked for.
fn asked_for() -> Option<u32> {
    let count = std::env::var("EOSPHOR_TEST_SCATTER").ok()?;
    Some(count.parse::<f64>().unwrap() as u32)
}

/// If it is made larger there are more cases, too, and integrals are compared to 1e-4.
#[test]
fn samples_are_as_dense_as_is_said() {
    let asked = asked_for();
    let count = asked.unwrap_or(1 << 14);
    let (alphas, cosines): (&[f32], &[f32]) = match asked.is_some() {
        true => (&[0.0, 0.02, 0.1, 0.3, 1.0], &[0.05, 0.5, 1.0]),
        false => (&[0.0, 0.1, 0.7], &[0.2, 0.9]),
    };
    // Half the small one is what so few points of `gone_and_single` are off by.
    let allowed_error = if asked.is_some() { 1e-4 } else { 2e-4 };
    let mut cases = Vec::new();
    for alpha in alphas {
        for (name, closure) in closures(*alpha) {
            for cos in cosines {
                cases.push((format!("{name}, alpha {alpha}, cosine {cos}"), closure, viewer(*cos)));
            }
        }
    }
    // Sidak: all cases together fail once in a thousand times.
    let least = 1.0 - 0.999f64.powf(1.0 / cases.len() as f64);
    let (mut worst_integral, mut least_chance, mut boxes_in_all) = (0f64, 1f64, 0.0);
    for (name, closure, to_viewer) in &cases {
        let mixture = closure.towards(*to_viewer);
        let boxes = Boxes::new(&mixture, 1e-3 * allowed_error);
        let [gone, single] = gone_and_single(closure, *to_viewer, 4 * count.max(1 << 14));
        let mut shares = boxes.shares();
        let spread: f64 = shares.iter().sum();
        let error = (spread + gone + single - 1.0).abs();
        worst_integral = worst_integral.max(error);
        assert!(
            error < allowed_error,
            "{name}: density {spread}, nothing {gone}, single directions {single}"
        );

        // Nothing and single directions are boxes, too. What comes to nothing is what is left.
        shares.extend([1.0 - spread - single, single]);
        let mut counted = vec![0u32; shares.len()];
        for i in 0..count {
            let number = |k: u32| random(i * 3 + k);
            let place = match mixture.sample([number(0), number(2)], || number(1)) {
                None => shares.len() - 2,
                Some(sample) if sample.is_delta => shares.len() - 1,
                Some(sample) => boxes.at(sample.to_light),
            };
            counted[place] += 1;
        }
        let (square, freedom) = chi_square(&shares, &counted, count);
        boxes_in_all += freedom;
        if freedom > 0.0 {
            let chance = chance_of_more(square, freedom);
            least_chance = least_chance.min(chance);
            assert!(chance > least, "{name}: chi^2 {square:.1} of {freedom}, chance {chance:e}");
        }
    }
    println!(
        "{} cases, {boxes_in_all} boxes: integrals off by {worst_integral:.6}; least chance {least_chance:.2e}, allowed {least:.2e}",
        cases.len()
    );
}

#[test]
fn weights_are_values_over_densities() {
    for alpha in [0.002, 0.05, 0.4, 1.0] {
        for (name, closure) in closures(alpha) {
            for i in 0..2000 {
                let number = |k: u32| random(i * 4 + k);
                let to_viewer = viewer(number(3).max(1e-3));
                let Some(sample) = closure.sample(to_viewer, number(0), [number(1), number(2)]) else {
                    continue;
                };
                let scattered = closure.eval(to_viewer, sample.to_light);
                let error = (sample.weight * scattered.pdf + -scattered.value).abs().max_component();
                assert!(error <= 1e-5 * scattered.value.max_component(), "{name}: {sample:?} {scattered:?}");
                assert_eq!(sample.pdf, scattered.pdf);
                assert_eq!(sample.is_transmitted, sample.to_light.z < 0.0);
                assert!((sample.to_light.length() - 1.0).abs() < 1e-5, "{sample:?}");
            }
        }
    }
}

#[test]
fn metal_and_layers_are_reciprocal() {
    let mut worst = 0f32;
    for i in 0..asked_for().unwrap_or(20_000) {
        let number = |k: u32| random(i * 8 + k);
        let alpha = [0.0, 0.01, 0.1, 0.5, 1.0][i as usize % 5];
        let closure = Closure {
            diffuse: vec3(0.4, 0.2, 0.1),
            diffuse_roughness: [0.0, 0.3, 1.0][i as usize % 3],
            metal_f0: vec3(0.3, 0.2, 0.5),
            ..white(0.5, 0.1, alpha)
        };
        let direction = |k: u32| {
            let z = number(k).max(0.01);
            let (s, c) = (std::f32::consts::TAU * number(k + 1)).sin_cos();
            let sine = sqrt((1.0 - z) * (1.0 + z));
            vec3(sine * c, sine * s, z).normalize()
        };
        let (a, b) = (direction(0), direction(2));
        let (there, back) = (closure.eval(a, b).value * (1.0 / b.z), closure.eval(b, a).value * (1.0 / a.z));
        worst = worst.max((there + -back).abs().max_component() / there.max_component());
    }
    println!("reciprocal to {worst:e}");
    assert!(worst < 1e-5);
}
