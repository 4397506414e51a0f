//! White surfaces return all light.

use super::*;
use crate::sampling::{mix, sobol_2d};

const ROUGHNESSES: [f32; 7] = [0.0, 0.1, 0.2, 0.35, 0.5, 0.7, 1.0];
const COSINES: [f32; 5] = [0.05, 0.2, 0.5, 0.8, 1.0];
const INDICES: [f32; 10] = [1.1, 1.33, 1.5, 2.0, 2.5, 1.0 / 1.1, 1.0 / 1.33, 1.0 / 1.5, 0.5, 0.4];

/// The mean weight of paths that go on, per channel.
pub(super) fn sampled(closure: &Closure, to_viewer: Vec3, count: u32) -> [f64; 3] {
    let mixture = closure.towards(to_viewer);
    let mut sum = [0.0; 3];
    for i in 0..count {
        // Hammersley's points: the pick goes evenly, and the other numbers are spread evenly in every part of it.
        let (u, pick) =
            (sobol_2d(i).map(|x| (x >> 8) as f32 * (1.0 / 16_777_216.0)), (i as f32 + 0.5) / count as f32);
        if let Some(sample) = mixture.sample([pick, u[1]], || u[0]) {
            sum[0] += f64::from(sample.weight.x);
            sum[1] += f64::from(sample.weight.y);
            sum[2] += f64::from(sample.weight.z);
        }
    }
    sum.map(|s| s / f64::from(count))
}

/// The largest distance from 1 over roughnesses and cosines.
fn worst(make: impl Fn(f32) -> Closure, count: u32) -> (f64, f32, f32) {
    let mut worst = (0.0, 0.0, 0.0);
    for roughness in ROUGHNESSES {
        for cos in COSINES {
            let error = (sampled(&make(roughness * roughness), viewer(cos), count)[1] - 1.0).abs();
            worst = if error > worst.0 { (error, roughness, cos) } else { worst };
        }
    }
    worst
}

#[test]
fn metal_and_layers_return_all_light() {
    for metal in [0.0, 0.5, 1.0] {
        let (error, roughness, cos) = worst(|alpha| white(metal, 0.04, alpha), 1 << 16);
        println!("metal {metal}: {error:.5} at roughness {roughness}, cosine {cos}");
        assert!(error < 0.0005, "metal {metal}: {error} at roughness {roughness}, cosine {cos}");
    }
}

#[test]
fn layers_over_rough_bases_return_all_light() {
    for (diffuse_roughness, metal, f0) in [(0.3, 0.0, 0.04), (1.0, 0.0, 0.04), (1.0, 0.5, 0.3)] {
        let (error, roughness, cos) =
            worst(|alpha| Closure { diffuse_roughness, ..white(metal, f0, alpha) }, 1 << 15);
        println!("base {diffuse_roughness}: {error:.5} at roughness {roughness}, cosine {cos}");
        assert!(error < 0.001, "base {diffuse_roughness}: {error} at roughness {roughness}, cosine {cos}");
    }
}

/// A black layer that is not there leaves the base as it is by itself, and a faint one nearly so.
#[test]
fn rough_bases_under_faint_layers_are_those_without() {
    let alone = Closure { diffuse: vec3(0.9, 0.5, 0.1), diffuse_roughness: 0.7, alpha: 0.3, ..nothing() };
    let under = Closure { f90: Vec3::splat(1e-4), ..alone };
    for cos in COSINES {
        for to_light in [viewer(0.3), vec3(0.8, 0.0, 0.6), vec3(-0.6, 0.8, 0.0), vec3(0.0, 0.6, 0.8)] {
            let (a, b) = (alone.eval(viewer(cos), to_light).value, under.eval(viewer(cos), to_light).value);
            assert!((a + -b).abs().max_component() < 5e-4, "{a:?} {b:?}");
        }
    }
}

#[test]
fn glass_returns_all_light() {
    for is_thin in [false, true] {
        for eta in INDICES {
            let (error, roughness, cos) = worst(|alpha| glass(eta, is_thin, alpha), 1 << 16);
            println!("eta {eta} {is_thin}: {error:.5} at roughness {roughness}, cosine {cos}");
            let bound = match is_thin {
                true => 0.0005,
                false if eta > 1.0 => 0.001,
                // The table is coarser where light leaves glass at grazing angles.
                false => 0.002,
            };
            assert!(
                error < bound,
                "index {eta}, thin {is_thin}: {error} at roughness {roughness}, cosine {cos}"
            );
        }
    }
}

/// Tables have nodes at roughnesses and indices like those above, and are off the most between them.
#[test]
fn glass_between_nodes_returns_all_light() {
    let mut worst = (0.0, String::new());
    for i in 0..120 {
        let number = |k: u32| (mix(4 * i + k) >> 8) as f32 * (1.0 / 16_777_216.0);
        let index = 1.1 + 1.4 * number(0);
        let eta = if number(1) < 0.4 { index } else { 1.0 / index };
        // Rough glass has most to make up for.
        let (roughness, cos) = (1.0 - 0.6 * number(2) * number(2), 0.05 + 0.95 * number(3));
        let albedo = sampled(&glass(eta, false, roughness * roughness), viewer(cos), 1 << 14)[1];
        if (albedo - 1.0).abs() > worst.0 {
            worst =
                ((albedo - 1.0).abs(), format!("index {eta}, roughness {roughness}, cosine {cos}: {albedo}"));
        }
    }
    println!("off by {:.5}: {}", worst.0, worst.1);
    // Half of it is what so few points are off by.
    assert!(worst.0 < 0.002, "{worst:?}");
}
