//! Any parameters in range: no NaN, nothing negative, no light made, no weight that is large.

use super::*;
use crate::sampling::{mix, sobol_2d};

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

#[test]
fn no_light_is_made() {
    const COUNT: u32 = 1 << 13;
    let mut numbers = Numbers(77);
    let mut most = 0f64;
    for _ in 0..400 {
        let (closure, to_viewer) = (numbers.closure(), viewer(numbers.part().max(0.05)));
        let mut sum = [0f64; 3];
        for i in 0..COUNT {
            let u = sobol_2d(i).map(|x| (x >> 8) as f32 * (1.0 / 16_777_216.0));
            if let Some(sample) = closure.sample(to_viewer, (i as f32 + 0.5) / COUNT as f32, u) {
                for channel in 0..3 {
                    sum[channel] += f64::from(sample.weight[channel]);
                }
            }
        }
        let albedo = sum.into_iter().fold(0.0, f64::max) / f64::from(COUNT);
        assert!(albedo < 1.003, "{albedo}: {closure:?} {to_viewer:?}");
        most = most.max(albedo);
    }
    println!("largest albedo {most:.5}");
}
