//! The model against Mitsuba's emitter `sunsky`, and the picture against the model.

use super::hosek_wilkie::{SUN_RADIUS, SkyDome, SunDisk};
use super::picture::{Grid, SkyPicture};
use crate::model::{EnvironmentMap, Scene, Sky};
use crate::{RenderSettings, SceneData};
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::settings::Integrator;
use eosphor_core::texture::Textures;
use std::f64::consts::{PI, TAU};

/// cd/m² over Mitsuba's unit: lumens per watt, and the normalisation that Mitsuba takes out.
const FROM_MITSUBA: f64 = 683.0 * 106.750_259_399_414_06;

/// A picture that is made faster.
const SMALL: Grid = Grid { width: 1360 };

/// Directions, and what Mitsuba says of them (tests/data/sky/measure.py).
fn measured() -> impl Iterator<Item = (&'static str, Vec<f64>)> {
    let lines =
        include_str!("../../tests/data/sky/mitsuba.txt").lines().filter(|line| !line.starts_with('#'));
    lines.map(|line| {
        let (kind, numbers) = line.split_once(' ').unwrap();
        (kind, numbers.split(' ').map(|number| number.parse().unwrap()).collect())
    })
}

#[test]
fn the_sky_is_mitsubas() {
    let directions: Vec<Vec<f64>> =
        measured().filter(|(kind, _)| *kind == "direction").map(|(_, numbers)| numbers).collect();
    let (mut worst, mut count) = (0f64, 0);
    let mut sky = None;
    let mut place = 0;
    for (kind, n) in measured() {
        match kind {
            "sky" => {
                let elevation = n[2].to_radians();
                (sky, place) = (Some((SkyDome::new(n[0], n[1], elevation), elevation)), 0);
            }
            "radiance" => {
                let (dome, elevation) = sky.as_ref().unwrap();
                let d = &directions[place];
                let length = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
                let cosine = (d[0] * elevation.cos() + d[2] * elevation.sin()) / length;
                let got = dome.ring(d[2] / length).radiance(cosine.acos(), cosine).0;
                let brightest = got.into_iter().fold(0.0, f64::max);
                for (got, want) in got.into_iter().zip(n) {
                    let want = want * FROM_MITSUBA;
                    // Single precision leaves few digits of channels about 0.
                    worst = worst.max((got - want).abs() / want.abs().max(0.05 * brightest));
                    count += 1;
                }
                place += 1;
            }
            _ => {}
        }
    }
    println!("{count} values, at most {worst:.1e} off");
    assert_eq!(count, 16 * 200 * 3);
    assert!(worst < 1e-3, "{worst}");
}

/// The radiance of the sun's middle, and the irradiance by its disk. Mitsuba's default, without limb darkening, has a coarser
/// table.
#[test]
fn the_sun_is_mitsubas() {
    let mut count = 0;
    for (_, n) in measured().filter(|(kind, _)| *kind == "sun") {
        let (disk, elevation) = (SunDisk::new(n[0]), n[1].to_radians());
        let middle = disk.radiance(elevation.sin(), 0.0).0;
        let mut irradiance = [0.0; 3];
        for k in 0..200 {
            let from_middle = ((f64::from(k) + 0.5) / 200.0).sqrt();
            for spoke in 0..64 {
                let up = (TAU * (f64::from(spoke) + 0.5) / 64.0).sin() * from_middle * SUN_RADIUS;
                let radiance = disk.radiance((elevation + up).sin(), from_middle).0;
                irradiance.iter_mut().zip(radiance).for_each(|(sum, x)| *sum += x / (200.0 * 64.0));
            }
        }
        let angle = TAU * (1.0 - SUN_RADIUS.cos());
        for channel in 0..3 {
            let off = |got: f64, want: f64| (got / (want * FROM_MITSUBA) - 1.0).abs();
            let irradiance = irradiance[channel] * angle;
            assert!(off(middle[channel], n[2 + channel]) < 1e-3, "{n:?}: {middle:?}");
            assert!(off(irradiance, n[5 + channel]) < 1e-3, "{n:?}: {irradiance}");
            assert!(off(irradiance, n[8 + channel]) < 7e-3, "{n:?}: {irradiance}");
        }
        count += 1;
    }
    assert_eq!(count, 16);
}

/// A sky in arrays.
fn flat(sky: Sky) -> SceneData {
    let settings = RenderSettings { integrator: Integrator::Path, ..RenderSettings::default() };
    let environment = Some(EnvironmentMap::of_sky(sky));
    let scene = Scene { environment, settings, camera: Some(Default::default()), ..Scene::default() };
    SceneData::flatten(&scene).unwrap().0
}

/// The radiance from a unit vector, in cd/m².
fn seen(data: &SceneData, [x, y, z]: [f64; 3]) -> [f64; 3] {
    let textures =
        Textures { textures: &data.textures, words: &data.texture_words, srgb_decode: &data.srgb_decode };
    let direction = vec3(x as f32, y as f32, z as f32);
    let Vec3 { x, y, z } = data.environment.radiance(&textures, direction);
    [x, y, z].map(|x| f64::from(x) * Sky::UNIT)
}

/// The unit vector of a place of the sky, in degrees.
fn towards(elevation: f64, azimuth: f64) -> [f64; 3] {
    let ((s, c), (east, north)) = (elevation.to_radians().sin_cos(), azimuth.to_radians().sin_cos());
    [c * east, s, -c * north]
}

#[test]
fn pictures_show_the_model() {
    let sky =
        Sky { sun_elevation_degrees: 30.0, sun_azimuth_degrees: -70.0, sun_strength: 0.0, ..Sky::default() };
    let data = flat(sky);
    let sun = towards(30.0, -70.0);
    let dome = SkyDome::new(3.0, f64::from(0.3f32), 30f64.to_radians());
    let mut worst = 0f64;
    for elevation in 1..90 {
        for azimuth in (0..360).step_by(7) {
            let d = towards(f64::from(elevation) + 0.03, f64::from(azimuth));
            let cosine: f64 = (0..3).map(|k| d[k] * sun[k]).sum();
            let want = dome.ring(d[1]).radiance(cosine.acos(), cosine).0;
            for (got, want) in seen(&data, d).into_iter().zip(want) {
                worst = worst.max((got / want - 1.0).abs());
            }
        }
    }
    println!("at most {worst:.1e} off");
    assert!(worst < 1e-3, "{worst}");
    // Below the horizon all is ground.
    let ground = seen(&data, towards(-0.1, 0.0));
    assert_eq!(ground, seen(&data, towards(-90.0, 0.0)));
    assert_eq!(ground, seen(&data, towards(-40.0, 123.0)));
    assert!(ground[0] > 0.0 && data.check().is_ok());
}

/// A level surface gets from the picture what it gets from the model, and the ground reflects its share of that.
#[test]
fn grounds_are_lit_by_the_sky() {
    let (elevation, turbidity, albedo) = (12f32, 4f32, 0.5f32);
    let sky = Sky { sun_elevation_degrees: elevation, turbidity, albedo, ..Sky::default() };
    let (turbidity, elevation) = (f64::from(turbidity), f64::from(elevation).to_radians());
    let dome = SkyDome::new(turbidity, f64::from(albedo), elevation);
    let mut want = [0.0; 3];
    const STEPS: u32 = 500;
    for row in 0..STEPS {
        // Equal parts of the squared sine.
        let level = ((f64::from(row) + 0.5) / f64::from(STEPS)).sqrt();
        let up = (1.0 - level * level).sqrt();
        let ring = dome.ring(up);
        for column in 0..STEPS {
            let around = (PI * (f64::from(column) + 0.5) / f64::from(STEPS)).cos();
            let cosine: f64 = up * elevation.sin() + level * elevation.cos() * around;
            let radiance = ring.radiance(cosine.acos(), cosine).0;
            want.iter_mut().zip(radiance).for_each(|(sum, x)| *sum += x * PI / f64::from(STEPS * STEPS));
        }
    }
    // The sun's: rings of its disk, whose middle counts by its sine.
    let disk = SunDisk::new(turbidity);
    let angle = TAU * (1.0 - SUN_RADIUS.cos());
    for ring in 0..100 {
        let from_middle = ((f64::from(ring) + 0.5) / 100.0).sqrt();
        for spoke in 0..64 {
            let up = (TAU * (f64::from(spoke) + 0.5) / 64.0).sin() * from_middle * SUN_RADIUS;
            let sine = (elevation + up).sin();
            let radiance = disk.radiance(sine, from_middle).0;
            want.iter_mut().zip(radiance).for_each(|(sum, x)| *sum += x * sine * angle / 6400.0);
        }
    }
    let data = flat(sky);
    let ground = seen(&data, towards(-20.0, 0.0));
    for (ground, want) in ground.into_iter().zip(want) {
        let expected = f64::from(albedo) / PI * want;
        println!("{ground:.3} {expected:.3}");
        assert!((ground / expected - 1.0).abs() < 1e-3);
    }
}

/// The light of the disk, where it is, and how wide: what penumbras follow from.
#[test]
fn the_disk_has_its_light_and_width() {
    for (elevation, azimuth) in [(2.0, 135.0), (45.0, 180.0), (89.9, 33.0)] {
        // So strong a sun that the sky does not count.
        let strength = 1e5;
        let data = flat(Sky {
            sun_elevation_degrees: elevation,
            sun_azimuth_degrees: azimuth,
            turbidity: 2.0,
            sun_strength: strength as f32,
            ..Sky::default()
        });
        let (e, a) = (f64::from(elevation), f64::from(azimuth));
        let (middle, up, side) = (towards(e, a), towards(e + 90.0, a), towards(0.0, a + 90.0));
        // Moments of green over the tangent plane: light, place and squared places.
        let mut moments = [0.0; 5];
        const STEPS: i32 = 200;
        let half = 2.0 * SUN_RADIUS;
        for i in -STEPS..STEPS {
            for k in -STEPS..STEPS {
                let at = |k: i32| half * (f64::from(k) + 0.5) / f64::from(STEPS);
                let (x, y) = (at(i), at(k));
                let d = [0, 1, 2].map(|k| middle[k] + x * side[k] + y * up[k]);
                let squared: f64 = d.iter().map(|x| x * x).sum();
                let d = d.map(|x| x / squared.sqrt());
                let light = seen(&data, d)[1] / strength / squared.powf(1.5);
                [light, light * x, light * y, light * x * x, light * y * y]
                    .into_iter()
                    .zip(&mut moments)
                    .for_each(|(x, sum)| *sum += x * (half / f64::from(STEPS)).powi(2));
            }
        }
        // Those of the disk itself.
        let disk = SunDisk::new(2.0);
        let mut wanted = [0.0; 5];
        for ring in 0..200 {
            let from_middle = ((f64::from(ring) + 0.5) / 200.0).sqrt();
            for spoke in 0..200 {
                let (s, c) = (TAU * (f64::from(spoke) + 0.5) / 200.0).sin_cos();
                let (x, y) = (c * from_middle * SUN_RADIUS, s * from_middle * SUN_RADIUS);
                let sine = (e.to_radians() + y).sin();
                let light =
                    disk.radiance(sine, from_middle).0[1].max(0.0) * TAU * (1.0 - SUN_RADIUS.cos()) / 4e4;
                [light, light * x, light * y, light * x * x, light * y * y]
                    .into_iter()
                    .zip(&mut wanted)
                    .for_each(|(x, sum)| *sum += x);
            }
        }
        let described = |m: [f64; 5]| {
            let (x, y) = (m[1] / m[0], m[2] / m[0]);
            let degrees = |variance: f64| variance.max(0.0).sqrt().to_degrees();
            [m[0], x.to_degrees(), y.to_degrees(), degrees(m[3] / m[0] - x * x), degrees(m[4] / m[0] - y * y)]
        };
        let (got, want) = (described(moments), described(wanted));
        println!("{elevation}: lux, middle, deviations: {got:.4?}, of the disk {want:.4?}");
        // About the zenith rows are rings, and not all of what they add is taken off.
        let most = if elevation > 89.0 { 0.08 } else { 0.015 };
        assert!((got[0] / want[0] - 1.0).abs() < 1e-3);
        assert!((got[1] - want[1]).abs() < 1e-3 && (got[2] - want[2]).abs() < 1e-3);
        assert!((got[3] / want[3] - 1.0).abs() < most && (got[4] / want[4] - 1.0).abs() < most);
    }
}

#[test]
fn pictures_are_the_same_with_any_number_of_threads() {
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let many = rayon::ThreadPoolBuilder::new().num_threads(5).build().unwrap();
    let sky = Sky { sun_elevation_degrees: 0.1, ..Sky::default() };
    let words = |pool: &rayon::ThreadPool| pool.install(|| SkyPicture::of_grid(&sky, SMALL).words);
    assert!(words(&one) == words(&many));
}

/// At all ends of their ranges the numbers make light that is finite and not below 0.
#[test]
fn pictures_of_the_ends() {
    for bits in [0b0000, 0b0111, 0b1010, 0b1111u32] {
        let end = |bit: u32, low: f32, high: f32| if bits >> bit & 1 == 0 { low } else { high };
        let sky = Sky {
            sun_elevation_degrees: end(0, 0.0, 90.0),
            sun_azimuth_degrees: end(1, -360.0, 360.0),
            turbidity: end(2, 1.0, 10.0),
            albedo: end(3, 0.0, 1.0),
            sun_strength: 1e6,
        };
        let picture = SkyPicture::of_grid(&sky, SMALL);
        assert!(picture.words.iter().all(|&word| (0.0..1e12).contains(&f32::from_bits(word))), "{sky:?}");
    }
}
