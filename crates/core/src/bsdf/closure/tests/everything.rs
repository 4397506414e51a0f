//! Any parameters in range: no NaN, nothing negative, no light made, no weight that is large.

use super::furnace::sampled;
use super::*;
use crate::sampling::mix;

/// Random numbers, with a good part of them at the ends of their range.
struct Numbers(u32);

impl Numbers {
    fn even(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(1);
        (mix(self.0) >> 8) as f32 * (1.0 / 16_777_216.0)
    }

    fn part(&mut self) -> f32 {
        let x = 1.5 * self.even() - 0.25;
        x.clamp(0.0, 1.0)
    }

    fn color(&mut self) -> Vec3 {
        vec3(self.part(), self.part(), self.part())
    }

    fn closure(&mut self) -> Closure {
        let (metal, transmission) = (self.part(), self.part());
        let (glass, base) = ((1.0 - metal) * transmission, (1.0 - metal) * (1.0 - transmission));
        let f90 = self.color();
        let choice = self.even();
        let alpha = self.part().powi(2);
        let eta = 0.4 + 0.6 * self.part();
        Closure {
            diffuse: self.color() * base,
            diffuse_roughness: self.part(),
            f0: f90 * self.color() * base,
            f90: f90 * base,
            metal_f0: self.color() * metal,
            metal,
            glass,
            glass_tint: self.color(),
            eta: if choice < 0.5 { eta } else { 1.0 / eta },
            is_thin: self.even() < 0.3,
            alpha: if choice > 0.9 { SMOOTH } else { alpha },
        }
    }

    fn any_viewer(&mut self) -> Vec3 {
        let cos = self.part();
        viewer(if cos == 0.0 { 1e-4 } else { cos.max(1e-6) })
    }
}

#[test]
fn nothing_is_negative_or_large() {
    let mut numbers = Numbers(0);
    let (mut largest, mut above_4, mut count) = (0f32, 0u32, 0u32);
    let mut where_largest = String::new();
    for _ in 0..100_000 {
        let (closure, to_viewer) = (numbers.closure(), numbers.any_viewer());
        for _ in 0..4 {
            let sample = closure.sample(to_viewer, numbers.even(), [numbers.even(), numbers.even()]);
            let Some(sample) = sample else { continue };
            let weight = sample.weight;
            assert!(
                weight.is_finite() && weight.min_component() >= 0.0,
                "{closure:?} {to_viewer:?} {sample:?}"
            );
            assert!(
                sample.pdf >= 0.0 && sample.pdf.is_finite() && sample.to_light.is_finite(),
                "{closure:?} {sample:?}"
            );
            assert!(sample.is_delta == (sample.pdf == 0.0));
            count += 1;
            above_4 += u32::from(weight.max_component() > 4.0);
            if weight.max_component() > largest {
                largest = weight.max_component();
                where_largest = format!("{closure:?} {to_viewer:?} {sample:?}");
            }
        }
        let z = 2.0 * numbers.even() - 1.0;
        let to_light = vec3(-sqrt(1.0 - z * z), 0.0, z).normalize();
        let scattered = closure.eval(to_viewer, to_light);
        assert!(
            scattered.value.is_finite() && scattered.value.min_component() >= 0.0,
            "{closure:?} {to_viewer:?} {to_light:?}"
        );
        assert!(scattered.pdf.is_finite() && scattered.pdf >= 0.0, "{closure:?} {to_viewer:?} {to_light:?}");
    }
    println!("largest weight {largest}; {above_4} of {count} above 4; {where_largest}");
    assert!(largest < 30.0 && above_4 < count / 1000);
}

/// The largest albedo of a channel, from so many points.
fn albedo(closure: &Closure, to_viewer: Vec3, count: u32) -> f64 {
    sampled(closure, to_viewer, count).into_iter().fold(0.0, f64::max)
}

/// The largest albedo of sets of parameters, each seen at five angles, and whose it is. More points are taken where fewer cannot
/// tell: of as many as are taken where it counts, the mean is off by less than 0.0001.
fn most_of(sets: impl Iterator<Item = u32>, enough: &[(u32, f64)]) -> (f64, String) {
    let mut most = (0.0, String::new());
    for set in sets {
        let mut numbers = Numbers(mix(set) ^ 0x5bd1_e995);
        let closure = numbers.closure();
        for _ in 0..5 {
            let to_viewer = viewer(numbers.part().max(0.05));
            let mut got = 0.0;
            for &(bits, enough) in enough {
                got = albedo(&closure, to_viewer, 1 << bits);
                assert!(got >= 0.0, "{got} {closure:?} {to_viewer:?}");
                if got < enough {
                    break;
                }
            }
            if got > most.0 {
                most = (got, format!("{closure:?} {to_viewer:?}"));
            }
        }
    }
    most
}

/// Long: it needs the machine's own fma, as without that it does not end within eight minutes.
/// `RUSTFLAGS=-Ctarget-cpu=native cargo test --release -p eosphor-core -- --ignored --nocapture a_million`
#[test]
#[ignore = "it takes minutes"]
fn a_million_sets_and_angles_make_no_light() {
    let threads = std::thread::available_parallelism().map_or(2, |count| count.get() as u32);
    let stages = [(7, 0.9), (11, 0.98), (14, 0.998), (16, 1.0003), (20, 2.0)];
    let sets = std::env::var("EOSPHOR_TEST_SETS").map_or(200_000, |sets| sets.parse().unwrap());
    let of = |thread: u32| most_of((thread..sets).step_by(threads as usize), &stages);
    let worst = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..threads).map(|thread| scope.spawn(move || of(thread))).collect();
        let mut found: Vec<_> = threads.into_iter().map(|thread| thread.join().unwrap()).collect();
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        found
    });
    for (albedo, what) in &worst {
        println!("largest albedo {albedo:.5}: {what}");
    }
    assert!(worst[0].0 < 1.001, "{:?}", worst[0]);
}

#[test]
fn no_light_is_made() {
    const COUNT: u32 = 1 << 13;
    let mut numbers = Numbers(77);
    let mut most = 0f64;
    for _ in 0..400 {
        let (closure, to_viewer) = (numbers.closure(), viewer(numbers.part().max(0.05)));
        let albedo = albedo(&closure, to_viewer, COUNT);
        assert!(albedo < 1.003, "{albedo}: {closure:?} {to_viewer:?}");
        most = most.max(albedo);
    }
    println!("largest albedo {most:.5}");
}
