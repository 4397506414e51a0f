//! Thousands of lamps of which one is chosen at a time: the mean is that of all of them, and a good choice has less noise.

use super::support::*;
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::sampling::mix;
use eosphor_core::settings::Integrator;
use eosphor_render::Film;
use eosphor_scene::{
    AlphaMode, Image, Instance, LightSelection, Material, MaterialKind, Mesh, NO_INDEX, Pbr, PixelSampling,
    Scene, Texels, Texture, Transform, Triangle,
};

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

/// Where the light of a lamp of this kind falls on a matte floor: by light samples and rays, and by rays alone (the lamp has a
/// hole somewhere, which light samples do not know).
fn by_both_ways(lamp: impl Fn(&mut Scene)) -> [f64; 2] {
    [false, true].map(|by_rays_alone| {
        let mut scene = scene();
        let settings = &mut scene.settings;
        settings.integrator = Integrator::Path;
        (settings.samples, settings.depth) = (if by_rays_alone { 1 << 16 } else { 1 << 14 }, 1);
        let white = matte(&mut scene, Vec3::splat(0.5));
        floor(&mut scene, 0.0, 4.0, white);
        lamp(&mut scene);
        if by_rays_alone {
            // A mask that hides nothing.
            for material in &mut scene.materials[1..] {
                material.alpha = AlphaMode::Mask { cutoff: 0.5 };
            }
        }
        f64::from(probe(&scene, vec3(0.3, 3.0, 0.2), vec3(0.3, 0.0, 0.2)).y)
    })
}

fn glowing(scene: &mut Scene, emission: f32) -> u32 {
    material(
        scene,
        MaterialKind::Pbr(Pbr { color: Vec3::ZERO, emission: Vec3::splat(emission), ..Pbr::default() }),
    )
}

/// A sphere over a floor: pi L r^2 / d^2 times the cosine is its irradiance (that of a disk of its size, seen from far enough or
/// near: the floor sees all of it).
#[test]
fn spheres_light_floors() {
    let (center, radius) = (vec3(-0.5, 1.5, 0.9), 0.4);
    let got = by_both_ways(|scene| {
        let lamp = glowing(scene, 20.0);
        sphere(scene, center, radius, lamp);
    });
    let way = center - vec3(0.3, 0.0, 0.2);
    let (squared, height) = (f64::from(way.length_squared()), f64::from(way.y));
    let irradiance = std::f64::consts::PI * 20.0 * f64::from(radius).powi(2) * height / squared.powf(1.5);
    let expected = irradiance * 0.5 / std::f64::consts::PI;
    println!("{got:?} of {expected}");
    assert!((got[0] / expected - 1.0).abs() < 1e-3 && (got[1] / expected - 1.0).abs() < 0.03);
}

/// A floor within a sphere that shines gets its radiance from everywhere, as before: its light is found by rays.
#[test]
fn spheres_shine_inwards() {
    let got = by_both_ways(|scene| {
        let lamp = glowing(scene, 2.0);
        sphere(scene, vec3(0.0, 0.0, 0.0), 20.0, lamp);
    });
    assert!(got.iter().all(|x| (x - 1.0).abs() < 0.01), "{got:?}");
}

/// A double-sided lamp of glTF lights the floor with its back.
#[test]
fn double_sided_lamps_shine_to_both_sides() {
    let lamp = |up: bool| {
        by_both_ways(|scene| {
            let lamp = glowing(scene, 20.0);
            let (u, v) = (vec3(0.4, 0.0, 0.0), vec3(0.0, 0.1, 0.3));
            let (u, v) = if up { (v, u) } else { (u, v) };
            rectangle(scene, vec3(-0.4, 1.2, 0.5), u, v, lamp);
        })
    };
    let (front, back) = (lamp(false), lamp(true));
    println!("{front:?} {back:?}");
    for other in [front[1], back[0], back[1]] {
        assert!((other / front[0] - 1.0).abs() < 0.03);
    }
}

/// A square of 512 triangles.
fn textured_square(material: u32) -> Mesh {
    const SIDE: u32 = 16;
    let corner = |k: u32| [k % (SIDE + 1), k / (SIDE + 1)].map(|x| x as f32 / SIDE as f32);
    let uvs: Vec<[f32; 2]> = (0..(SIDE + 1) * (SIDE + 1)).map(corner).collect();
    let positions = uvs.iter().map(|[u, v]| vec3(2.0 * u - 1.0, 0.0, 2.0 * v - 1.0)).collect();
    let triangle =
        |corners: [u32; 3]| Triangle { positions: corners, normals: [NO_INDEX; 3], uvs: corners, material };
    let square = |k: u32| {
        let a = k / SIDE * (SIDE + 1) + k % SIDE;
        let b = a + SIDE + 1;
        [triangle([a, a + 1, b + 1]), triangle([a, b + 1, b])]
    };
    let triangles = (0..SIDE * SIDE).flat_map(square).collect();
    Mesh { name: "square".into(), positions, uvs, triangles, ..Mesh::default() }
}

/// A lamp with a texture, half of it black: light samples and rays agree, also where a mirrored instance turns it.
#[test]
fn textured_lamps_light_floors() {
    for mirrored in [false, true] {
        let got = by_both_ways(|scene| {
            let texels =
                [[0.0, 0.0, 0.0, 1.0], [4.0, 4.0, 4.0, 1.0], [0.0, 0.0, 0.0, 1.0], [1.0, 1.0, 1.0, 1.0]];
            scene.images.push(Image {
                name: "stripes".into(),
                width: 4,
                height: 1,
                texels: Texels::rgba_floats(&texels),
            });
            scene.textures.push(Texture::of_image(0));
            let lamp = glowing(scene, 20.0);
            scene.materials[lamp as usize].textures.emission = Some(0);
            scene.meshes.push(textured_square(lamp));
            // Twice, so that it is an instance.
            for x in [-0.4, 1.3] {
                let scale = vec3(if mirrored { -0.4 } else { 0.4 }, 0.5, 0.5);
                let transform = Transform { scale, translate: vec3(x, 1.4, 0.4), ..Transform::default() };
                scene.instances.push(Instance::new(0, transform));
            }
        });
        println!("{got:?}");
        assert!((got[1] / got[0] - 1.0).abs() < 0.03 && got[0] > 0.0, "{mirrored}");
    }
}
