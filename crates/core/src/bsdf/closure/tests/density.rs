//! Samples are as dense as is said, and weigh what their value says.

use super::*;
use crate::sampling::{mix, sobol_2d};

/// Rows and columns of the sphere for quadrature, and how many of them a box has in which samples are counted.
const ROWS: usize = 1024;
const BOX: [usize; 2] = [64, 128];

fn closures(alpha: f32) -> [(&'static str, Closure); 6] {
    let half = Vec3::splat(0.5);
    let mixed =
        Closure { metal: 0.25, metal_f0: vec3(0.2, 0.1, 0.05), glass: 0.25, ..white(0.5, 0.04, alpha) };
    [
        ("metal", white(1.0, 0.0, alpha)),
        ("layer over base", white(0.0, 0.04, alpha)),
        ("entering glass", glass(1.5, false, alpha)),
        ("leaving glass", Closure { glass_tint: half, ..glass(1.0 / 1.5, false, alpha) }),
        ("pane", glass(1.5, true, alpha)),
        ("all", mixed),
    ]
}

fn random(i: u32) -> f32 {
    (mix(i) >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// The density in each box, by the midpoint rule over the sphere.
fn integrals(closure: &Closure, to_viewer: Vec3) -> Vec<f64> {
    let mut boxes = vec![0.0; (ROWS / BOX[0]) * (ROWS / BOX[1])];
    let area = 4.0 * std::f64::consts::PI / (ROWS * ROWS) as f64;
    for row in 0..ROWS {
        let z = 2.0 * (row as f64 + 0.5) / ROWS as f64 - 1.0;
        for column in 0..ROWS {
            let (s, c) = (std::f64::consts::TAU * (column as f64 + 0.5) / ROWS as f64).sin_cos();
            let sine = (1.0 - z * z).sqrt();
            let to_light = vec3((sine * c) as f32, (sine * s) as f32, z as f32);
            boxes[box_of(row, column)] += f64::from(closure.eval(to_viewer, to_light).pdf) * area;
        }
    }
    boxes
}

/// The share of samples that come to nothing, by points that are spread evenly.
fn gone(closure: &Closure, to_viewer: Vec3) -> f64 {
    const COUNT: u32 = 1 << 16;
    let is_none = |i: u32| {
        let u = sobol_2d(i).map(|x| (x >> 8) as f32 * (1.0 / 16_777_216.0));
        closure.sample(to_viewer, (i as f32 + 0.5) / COUNT as f32, u).is_none()
    };
    (0..COUNT).filter(|&i| is_none(i)).count() as f64 / f64::from(COUNT)
}

fn box_of(row: usize, column: usize) -> usize {
    row / BOX[0] * (ROWS / BOX[1]) + column / BOX[1]
}

fn box_at(d: Vec3) -> usize {
    let turn = f64::from(d.y).atan2(f64::from(d.x)) / std::f64::consts::TAU;
    let at = |x: f64| ((x * ROWS as f64) as usize).min(ROWS - 1);
    box_of(at(0.5 * (f64::from(d.z) + 1.0)), at(turn - turn.floor()))
}

#[test]
fn samples_are_as_dense_as_is_said() {
    const COUNT: u32 = 1 << 17;
    let (mut worst_integral, mut worst_z) = (0f64, f64::MIN);
    for alpha in [0.1, 0.3, 1.0] {
        for (name, closure) in closures(alpha) {
            for cos in [0.2, 0.9] {
                let to_viewer = viewer(cos);
                let expected = integrals(&closure, to_viewer);
                let mut counted = vec![0u32; expected.len()];
                for i in 0..COUNT {
                    let number = |k: u32| random(i * 3 + k);
                    if let Some(sample) = closure.sample(to_viewer, number(0), [number(1), number(2)]) {
                        counted[box_at(sample.to_light)] += 1;
                    }
                }
                let whole = expected.iter().sum::<f64>() + gone(&closure, to_viewer);
                // Quadrature's error: refracted light ends at an edge. Of four times as many rows 0.0002 is left.
                assert!((whole - 1.0).abs() < 0.003, "{name}, alpha {alpha}, cosine {cos}: {whole}");
                worst_integral = worst_integral.max((whole - 1.0).abs());

                // Boxes with few samples are one box.
                let (mut square, mut freedom, mut few) = (0.0, 0.0, [0.0; 2]);
                for (&part, &count) in expected.iter().zip(&counted) {
                    let want = part * f64::from(COUNT);
                    if want < 10.0 {
                        few = [few[0] + want, few[1] + f64::from(count)];
                    } else {
                        square += (f64::from(count) - want).powi(2) / want;
                        freedom += 1.0;
                    }
                }
                if few[0] > 1.0 {
                    square += (few[1] - few[0]).powi(2) / few[0];
                }
                // Wilson and Hilferty: the cube root is nearly normal. 4.1 is 0.001 for all 36 cases together.
                let spread = 2.0 / (9.0 * freedom);
                let z = ((square / freedom).cbrt() - (1.0 - spread)) / f64::sqrt(spread);
                worst_z = worst_z.max(z);
                assert!(
                    z < 4.1,
                    "{name}, alpha {alpha}, cosine {cos}: chi^2 {square:.1} of {freedom}, {z:.1} sigma"
                );
            }
        }
    }
    println!("integrals off by {worst_integral:.5}, chi^2 by {worst_z:.2} sigma");
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
    for i in 0..20_000 {
        let number = |k: u32| random(i * 8 + k);
        let alpha = [0.0, 0.01, 0.1, 0.5, 1.0][i as usize % 5];
        let closure =
            Closure { diffuse: vec3(0.4, 0.2, 0.1), metal_f0: vec3(0.3, 0.2, 0.5), ..white(0.5, 0.1, alpha) };
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
