//! Single scattering is that of Mitsuba 3.9.1's `diffuse`, `roughconductor`, `roughdielectric` and `thindielectric`
//! (mitsuba_values.py). `EOSPHOR_TEST_MITSUBA` names a larger file of values.

use super::super::super::ggx::Ggx;
use super::*;

/// Smith's masking, in double precision, of one direction.
fn lambda(cos: f32, alpha: f64) -> f64 {
    let c2 = f64::from(cos).powi(2);
    0.5 * ((1.0 + alpha * alpha * (1.0 / c2 - 1.0)).sqrt() - 1.0)
}

#[test]
fn single_scattering_is_mitsubas() {
    let mut worst = std::collections::BTreeMap::<&str, (f64, u32, &str)>::new();
    let larger = std::env::var("EOSPHOR_TEST_MITSUBA").map(|path| std::fs::read_to_string(path).unwrap());
    let values = larger.as_deref().unwrap_or(include_str!("mitsuba.txt"));
    for line in values.lines().filter(|line| !line.starts_with('#')) {
        let (kind, numbers) = line.split_once(' ').unwrap();
        let n: Vec<f64> = numbers.split(' ').map(|number| number.parse().unwrap()).collect();
        let direction = |i: usize| vec3(n[i] as f32, n[i + 1] as f32, n[i + 2] as f32);
        let (alpha, eta, to_viewer, to_light, want) = (n[0], n[1], direction(2), direction(5), n[8]);
        let closure = glass(eta as f32, false, alpha as f32);
        let ggx = Ggx { alpha: alpha as f32 };
        // Mitsuba's masking and shadowing are independent of each other; here they are correlated by height.
        let (masked, shadowed) = (lambda(to_viewer.z, alpha), lambda(to_light.z, alpha));
        let want_correlated = want * (1.0 + masked) * (1.0 + shadowed) / (1.0 + masked + shadowed);
        let (got, want) = match kind {
            "diffuse" => {
                let matte = Closure { diffuse: Vec3::splat(0.5), alpha: 0.0, ..nothing() };
                (matte.eval(to_viewer, to_light).value.x, want)
            }
            "metal" => (ggx.reflection(to_viewer, to_light).value, want_correlated),
            "glass" if to_light.z > 0.0 => {
                let facets = ggx.reflection(to_viewer, to_light);
                (facets.value * closure.glass_reflectance(facets.cos), want_correlated)
            }
            "glass" => {
                let facets = ggx.refraction(to_viewer, to_light, eta as f32);
                (facets.value * (1.0 - closure.glass_reflectance(facets.cos)), want_correlated)
            }
            "pane" => (glass(eta as f32, true, 0.0).glass_reflectance(to_viewer.z), want),
            _ => unreachable!("{kind}"),
        };
        let error = (f64::from(got) / want - 1.0).abs();
        let (most, count, at) = worst.entry(kind).or_default();
        (*most, *at) = if error > *most { (error, line) } else { (*most, *at) };
        *count += 1;
    }
    for (kind, (error, count, line)) in &worst {
        println!("{kind}: {count} pairs, off by {error:.1e}: {line}");
    }
    assert!(worst.len() == 4 && worst.values().map(|(_, count, _)| count).sum::<u32>() > 300);
    assert!(worst.values().all(|(error, ..)| *error < TOLERANCE));
}

/// Both sides are in single precision: in narrow lobes half vectors have fewer digits.
const TOLERANCE: f64 = 1e-4;
