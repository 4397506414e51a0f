//! Thousands of lamps of which one is chosen at a time: the mean is that of all of them, and a good choice has less noise.

use super::support::*;
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::sampling::mix;
use eosphor_core::settings::Integrator;
use eosphor_render::Film;
use eosphor_scene::{LightSelection, Material, MaterialKind, Pbr, PixelSampling, Scene};

/// Numbers in [0, 1).
struct Numbers(u32);

impl Numbers {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(1);
        (mix(self.0) >> 8) as f32 / 16_777_216.0
    }
}

/// Rooms in a square, `side` by `side`, with so many lamps of two triangles each: half of them panels below the ceiling, half small
/// ones anywhere that face anywhere. The camera sees the middle one.
pub(crate) fn rooms(side: u32, lamps: u32) -> Scene {
    let mut scene = scene();
    let mut numbers = Numbers(5);
    let white = matte(&mut scene, Vec3::splat(0.7));
    let strengths = [100.0, 400.0, 1600.0, 6400.0].map(|s| emissive(&mut scene, vec3(s, 0.9 * s, 0.7 * s)));
    let (width, height) = (4.0, 3.0);
    let half = vec3(width / 2.0, height / 2.0, width / 2.0);
    let axes = |x: f32, y: f32, z: f32| [vec3(x, 0.0, 0.0), vec3(0.0, y, 0.0), vec3(0.0, 0.0, z)];
    for room in 0..side * side {
        let place = |k: u32| (k as f32 - (side / 2) as f32) * (width + 0.25);
        let center = vec3(place(room % side), 0.0, place(room / side));
        let [x, y, z] = axes(half.x, half.y, half.z);
        for (offset, u, v) in [(x, y, z), (y, z, x), (z, x, y)] {
            rectangle(&mut scene, center - offset, u, v, white);
            rectangle(&mut scene, center + offset, v, u, white);
        }
        // Something in the way.
        let box_center = center + vec3(0.6, -1.0, 0.4);
        let [x, y, z] = axes(0.5, 0.5, 0.4);
        for (offset, u, v) in [(x, y, z), (y, z, x), (z, x, y)] {
            rectangle(&mut scene, box_center + offset, u, v, white);
            rectangle(&mut scene, box_center - offset, v, u, white);
        }
        for lamp in 0..lamps {
            let mut within = |reach: f32| (2.0 * numbers.next() - 1.0) * reach;
            let strength = strengths[(lamp % 4) as usize];
            if lamp % 2 == 0 {
                let at = center + vec3(within(half.x - 0.1), half.y - 0.05, within(half.z - 0.1));
                rectangle(&mut scene, at, vec3(0.03, 0.0, 0.0), vec3(0.0, 0.0, 0.02), strength);
            } else {
                let at = center + vec3(within(half.x - 0.1), within(half.y - 0.1), within(half.z - 0.1));
                let u = vec3(within(1.0), within(1.0), within(1.0)).normalize();
                let v = u.cross(vec3(within(1.0), within(1.0), within(1.0))).normalize();
                rectangle(&mut scene, at, u * 0.02, v * 0.02, strength);
            }
        }
    }
    scene.camera = Some(looking(vec3(-1.8, 0.6, 1.9), vec3(0.4, -0.4, -0.2), 75.0));
    let settings = &mut scene.settings;
    settings.integrator = Integrator::Path;
    // Small lamps that the camera sees would be noise of their own.
    settings.pixel_sampling = PixelSampling::Center;
    (settings.size, settings.depth) = ([32, 24], 1);
    scene
}

fn rendered(scene: &Scene, selection: LightSelection, samples: u32, seed: u32) -> Film {
    let mut scene = scene.clone();
    (scene.settings.lights, scene.settings.samples, scene.settings.seed) = (Some(selection), samples, seed);
    render(&scene)
}

/// The mean of squared errors over squared values.
fn relative_error(film: &Film, truth: &Film) -> f64 {
    let of = |(got, true_value): (&Vec3, &Vec3)| {
        let (got, true_value) = (f64::from(got.y), f64::from(true_value.y));
        (got - true_value).powi(2) / (true_value * true_value + 0.01)
    };
    film.pixels.iter().zip(&truth.pixels).map(of).sum::<f64>() / film.pixels.len() as f64
}

fn mean(film: &Film) -> f64 {
    film.pixels.iter().map(|c| f64::from(c.y)).sum::<f64>() / film.pixels.len() as f64
}

/// The tree, power and chance alone choose lights with one mean, that of sampling all of them: in path tracing and by Whitted.
#[test]
fn any_choice_has_the_mean_of_all_lamps() {
    let mut scene = rooms(3, 14);
    (scene.settings.integrator, scene.settings.light_samples) = (Integrator::Whitted, 16);
    scene.settings.size = [16, 12];
    let all = rendered(&scene, LightSelection::All, 16, 1);
    for (selection, most, most_error) in [
        (LightSelection::Tree, 3e-3, 5e-4),
        (LightSelection::Power, 0.01, 0.01),
        (LightSelection::Uniform, 0.04, 0.01),
    ] {
        for (integrator, samples) in [(Integrator::Whitted, 64), (Integrator::Path, 1024)] {
            scene.settings.integrator = integrator;
            let one = rendered(&scene, selection, samples, 1);
            let (ratio, error) = (mean(&one) / mean(&all), relative_error(&one, &all));
            println!("{selection:?}, {integrator:?}: mean {ratio:.5} of that of all, relMSE {error:.6}");
            assert!((ratio - 1.0).abs() < most && error < most_error);
        }
    }
}

/// The same where rays of glossy lobes find the lamps that are drawn; they are the same rays.
#[test]
fn glossy_lobes_have_their_share_of_lamps_that_are_drawn() {
    let mut scene = rooms(1, 40);
    (scene.settings.integrator, scene.settings.light_samples) = (Integrator::Whitted, 16);
    scene.settings.size = [16, 12];
    let kind = MaterialKind::Pbr(Pbr { metallic: 1.0, roughness: 0.35, ..Pbr::default() });
    scene.materials[0] = Material::new("metal", kind);
    let all = rendered(&scene, LightSelection::All, 64, 1);
    let tree = rendered(&scene, LightSelection::Tree, 64, 1);
    let ratio = mean(&tree) / mean(&all);
    println!("mean {ratio:.5} of that of all");
    assert!((ratio - 1.0).abs() < 5e-3);
}

#[test]
fn the_tree_has_less_noise() {
    let scene = rooms(5, 200);
    let truth = rendered(&scene, LightSelection::Tree, 1 << 13, 1);
    let error = |selection| relative_error(&rendered(&scene, selection, 64, 2), &truth);
    let [tree, power, uniform] =
        [LightSelection::Tree, LightSelection::Power, LightSelection::Uniform].map(error);
    println!(
        "relMSE: tree {tree:.5}, power {power:.5} ({:.1}), uniform {uniform:.5} ({:.1})",
        power / tree,
        uniform / tree
    );
    assert!(2.0 * tree <= power && 10.0 * tree <= uniform);
}
