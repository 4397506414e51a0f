use super::*;
use eosphor_core::light::{LightReceiver, LightTree, TreeTop};
use eosphor_core::sampling::mix;
use proptest::prelude::*;

/// Numbers in [0, 1).
struct Numbers(u32);

impl Numbers {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(1);
        (mix(self.0) >> 8) as f32 / 16_777_216.0
    }

    fn vector(&mut self) -> Vec3 {
        let mut next = || 2.0 * self.next() - 1.0;
        vec3(next(), next(), next())
    }
}

fn triangle(v0: Vec3, e1: Vec3, e2: Vec3, radiance: f32, primitive: u32) -> Light {
    let across = e1.cross(e2);
    Light::Triangle {
        v0,
        e1,
        e2,
        normal: across.normalize(),
        area: 0.5 * across.length(),
        color: Vec3::splat(radiance),
        texture: eosphor_core::material::NONE,
        is_two_sided: primitive % 5 == 4,
        samples: 1,
        instance: 0,
        primitive,
    }
}

/// Lights of all kinds, in groups, of very different strength.
fn lights(count: usize, seed: u32, scale: f32) -> Vec<Light> {
    let mut numbers = Numbers(seed);
    let mut middle = Vec3::ZERO;
    let light = |k: usize| {
        if k.is_multiple_of(7) {
            middle = numbers.vector() * (10.0 * scale);
        }
        let position = middle + numbers.vector() * scale;
        let color = Vec3::splat(2f32.powi((numbers.next() * 20.0) as i32 - 10));
        match k % 11 {
            0 => Light::Point { position, color },
            1 => Light::Spot {
                position,
                axis: numbers.vector().normalize(),
                color,
                cos_inner: 0.9,
                cos_outer: 0.9 - 1.4 * numbers.next(),
            },
            3 => Light::Sphere {
                center: position,
                radius: 0.05 * scale,
                color,
                instance: 0,
                primitive: k as u32,
            },
            2 if count < 50 => Light::Directional { to_light: numbers.vector().normalize(), color },
            _ => {
                let (e1, e2) = (numbers.vector() * (0.1 * scale), numbers.vector() * (0.1 * scale));
                triangle(position, e1, e2, color.x, k as u32)
            }
        }
    };
    (0..count).map(light).collect()
}

fn receiver(numbers: &mut Numbers, scale: f32) -> LightReceiver {
    let normal = if numbers.next() < 0.2 { Vec3::ZERO } else { numbers.vector().normalize() };
    LightReceiver { position: numbers.vector() * (12.0 * scale), normal }
}

fn built(lights: &[Light], selection: LightSelection) -> LightTreeArrays {
    build(lights, &Plan { selection, lamps_only: false }, |_| 1.0)
}

fn view(arrays: &LightTreeArrays) -> LightTree<'_> {
    LightTree { nodes: &arrays.nodes, places: &arrays.places }
}

/// What a receiver gets of a light where nothing is in the way.
fn received(light: &Light, from: &LightReceiver) -> f32 {
    let sample = light.sample_li(from.position, [0.3, 0.6], true);
    let cos = if from.normal == Vec3::ZERO { 1.0 } else { from.normal.dot(sample.to_light).max(0.0) };
    sample.weight * cos * light.le().x
}

#[test]
fn chances_add_up_and_lights_that_are_received_have_one() {
    for (count, scale) in [(1, 1.0), (2, 1.0), (12, 1.0), (400, 1.0), (400, 1e-4), (400, 1e4), (400, 1e9)] {
        let lights = lights(count, 3, scale);
        for selection in [LightSelection::Tree, LightSelection::Power, LightSelection::Uniform] {
            let arrays = built(&lights, selection);
            assert_eq!(arrays.nodes.len(), 2 * count - 1);
            let mut numbers = Numbers(9);
            for _ in 0..50 {
                let from = receiver(&mut numbers, scale);
                let chances: Vec<f32> =
                    (0..count as u32).map(|number| view(&arrays).chance(&from, number)).collect();
                let sum: f64 = chances.iter().map(|&chance| f64::from(chance)).sum();
                // What is lost is in branches whose lights turn out not to reach it.
                assert!(sum < 1.0 + 1e-5, "{count} {scale} {selection:?}: {sum}");
                assert!(selection == LightSelection::Tree || sum > 1.0 - 1e-5, "{selection:?}: {sum}");
                for (light, &chance) in lights.iter().zip(&chances) {
                    let got = received(light, &from);
                    assert!(chance > 0.0 || got <= 0.0, "{count} {scale} {selection:?}: {light:?} {got}");
                }
            }
        }
    }
}

#[test]
fn lights_are_chosen_as_often_as_is_said() {
    const CHOICES: u32 = 1 << 16;
    let lights = lights(300, 5, 1.0);
    let arrays = built(&lights, LightSelection::Tree);
    let mut numbers = Numbers(2);
    for _ in 0..5 {
        let from = receiver(&mut numbers, 1.0);
        let mut times = vec![0u32; lights.len()];
        for k in 0..CHOICES {
            let u = (f64::from(k) + 0.5) / f64::from(CHOICES);
            if let Some(chosen) = view(&arrays).choose(&from, u) {
                times[chosen.number as usize] += 1;
                assert_eq!(chosen.chance, view(&arrays).chance(&from, chosen.number));
            }
        }
        for (number, &times) in times.iter().enumerate() {
            let chance = f64::from(view(&arrays).chance(&from, number as u32));
            // Numbers are evenly spaced, and each light has one interval of them.
            assert!((f64::from(times) - chance * f64::from(CHOICES)).abs() < 1.01, "{number}");
        }
    }
}

/// What lights send out decides, or nothing.
/// One by one, several points at a time, and from the ways through the first levels: the same bits. Numbers are such at which ways
/// part, too.
#[test]
fn lanes_choose_as_one_point_does() {
    const W: usize = 16;
    let mut numbers = Numbers(5);
    let (mut chosen_ones, mut missed) = (0, 0);
    for (count, selection) in [1usize, 2, 3, 5, 17, 33, 64, 400]
        .into_iter()
        .flat_map(|count| [(count, LightSelection::Tree), (count, LightSelection::Power)])
    {
        // Of those that face one way many points get nothing.
        let mut lights = lights(count, count as u32, 1.0);
        if count == 33 {
            let lamp = |k: u32| {
                triangle(vec3(k as f32, 0.0, 0.0), vec3(0.3, 0.0, 0.0), vec3(0.0, 0.3, 0.0), 1.0, 5 * k)
            };
            lights = (0..33).map(lamp).collect();
        }
        let arrays = built(&lights, selection);
        let (tree, top) = (view(&arrays), TreeTop::new(&view(&arrays)));
        for _ in 0..40 {
            let from: [_; W] = std::array::from_fn(|_| receiver(&mut numbers, 1.0));
            let is_wanted: [_; W] = std::array::from_fn(|_| numbers.next() < 0.9);
            let ways = from.map(|from| top.ways(&from));
            for _ in 0..8 {
                let u: [_; W] = std::array::from_fn(|lane| {
                    if lane % 3 == 0 {
                        f64::from(numbers.next() * 32.0).floor() / 32.0
                    } else {
                        f64::from(numbers.next())
                    }
                });
                let of_lanes = tree.choose_lanes(&is_wanted, |lane| from[lane], &u);
                let of_ways = tree.choose_lanes_from(&top, &ways, &is_wanted, |lane| from[lane], &u);
                for lane in (0..W).filter(|&lane| is_wanted[lane]) {
                    let alone = tree.choose(&from[lane], u[lane]);
                    assert_eq!(of_lanes[lane], alone, "{count} {:?} {}", from[lane], u[lane]);
                    assert_eq!(of_ways[lane], alone, "{count} {:?} {}", from[lane], u[lane]);
                    chosen_ones += u32::from(alone.is_some());
                    missed += u32::from(alone.is_none());
                }
            }
        }
    }
    assert!(chosen_ones > 10_000 && missed > 1_000, "{chosen_ones} {missed}");
}

#[test]
fn other_ways_to_choose_have_the_chances_that_they_are_named_for() {
    let lights: Vec<Light> = (0..9)
        .map(|k| Light::Point { position: vec3(k as f32, 0.0, 0.0), color: Vec3::splat(k as f32) })
        .collect();
    let from = LightReceiver { position: vec3(3.0, 1.0, 0.0), normal: vec3(0.0, 1.0, 0.0) };
    let by_power = built(&lights, LightSelection::Power);
    let uniform = built(&lights, LightSelection::Uniform);
    for k in 0..9 {
        assert!((view(&by_power).chance(&from, k) - k as f32 / 36.0).abs() < 1e-6);
        assert!((view(&uniform).chance(&from, k) - 1.0 / 9.0).abs() < 1e-6);
    }
    let tree = built(&lights, LightSelection::Tree);
    // All are below the horizon.
    assert!(view(&tree).choose(&from, 0.5).is_none());
    assert_eq!(view(&tree).chance(&from, 4), 0.0);
}

/// Suns have the chance of all that is near together, each; where there are only suns they share it.
#[test]
fn what_shines_from_afar_is_beside_the_tree() {
    let sun = Light::Directional { to_light: vec3(0.0, 1.0, 0.0), color: Vec3::ONE };
    let lamp = triangle(vec3(0.0, 2.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 0.0, 1.0), 1.0, 0);
    let from = LightReceiver { position: Vec3::ZERO, normal: vec3(0.0, 1.0, 0.0) };
    let chances = |lights: &[Light]| {
        let arrays = built(lights, LightSelection::Tree);
        (0..lights.len() as u32).map(|k| view(&arrays).chance(&from, k)).collect::<Vec<_>>()
    };
    assert_eq!(chances(&[sun]), [1.0]);
    assert_eq!(chances(&[sun, sun, sun, sun]), [0.25; 4]);
    for (chance, expected) in chances(&[sun, lamp, lamp, lamp]).into_iter().zip([0.5, 1.0 / 6.0]) {
        assert!((chance - expected).abs() < 1e-6);
    }
    assert_eq!(chances(&[]), [0.0; 0]);
}

/// Lamps of no light, of too much, in one place, in a row of powers of ten.
#[test]
fn odd_lights_are_all_in_the_tree() {
    let at = |x: f32, color: f32| Light::Point { position: vec3(x, 0.0, 0.0), color: Vec3::splat(color) };
    let same: Vec<Light> = (0..1000).map(|_| at(1.0, 1.0)).collect();
    let dark: Vec<Light> = (0..100).map(|k| at(k as f32, 0.0)).collect();
    let bright: Vec<Light> = (0..100).map(|k| at(k as f32, if k == 50 { 3e38 } else { 1e-38 })).collect();
    let far: Vec<Light> = (0..1000).map(|k| at(2f32.powi(k / 16 - 30), 1.0)).collect();
    for lights in [same, dark, bright, far] {
        for selection in [LightSelection::Tree, LightSelection::Power, LightSelection::Uniform] {
            let arrays = built(&lights, selection);
            let from = LightReceiver { position: vec3(0.5, 3.0, 0.0), normal: Vec3::ZERO };
            for k in 0..lights.len() as u32 {
                assert!(view(&arrays).chance(&from, k) > 0.0, "{selection:?} {k}");
            }
        }
    }
}

#[test]
fn the_nodes_are_the_same_with_any_number_of_threads() {
    let lights = lights(20_000, 8, 1.0);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| built(&lights, LightSelection::Tree))
    };
    let one = with(1);
    assert!(one == with(2) && one == with(7));
}

proptest! {
    /// At a scale of a power of two all numbers have the same digits.
    #[test]
    fn chances_do_not_depend_on_the_scale(seed in 0u32..1000, power in -20i32..20) {
        let lamps = |scale: f32| lights(80, seed, scale).into_iter().filter(Light::is_lamp).collect::<Vec<_>>();
        let scale = 2f32.powi(power);
        let (small, large) = (lamps(1.0), lamps(scale));
        let (small, large) = (built(&small, LightSelection::Tree), built(&large, LightSelection::Tree));
        prop_assert_eq!(&small.places, &large.places);
        let from = receiver(&mut Numbers(seed), 1.0);
        let farther = LightReceiver { position: from.position * scale, ..from };
        for light in 0..small.places.len() as u32 {
            prop_assert_eq!(view(&small).chance(&from, light), view(&large).chance(&farther, light));
        }
    }
}
