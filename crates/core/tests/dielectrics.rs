//! Fresnel and Snell against double precision and the textbook.

use eosphor_core::bsdf::{
    Refracted, fresnel_exact, fresnel_factor, fresnel_schlick, reflect, reflectance_at_normal_incidence,
    refract,
};
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::settings::FresnelMode;

/// Indices of one side over the other, from both sides.
const ETAS: [f32; 8] = [1.0 / 1.0002, 1.0 / 1.333, 1.0 / 1.5, 1.0 / 2.419, 1.0002, 1.333, 1.5, 2.419];

/// Cosines from grazing to normal.
fn cosines() -> impl Iterator<Item = f32> {
    (0..=1000).map(|i| i as f32 / 1000.0).chain((1..20).map(|i| 10f32.powi(-i)))
}

/// Fresnel's equations in double precision, by angles: sin and tan of sums and differences.
fn by_angles(cos_in: f64, eta: f64) -> f64 {
    let (i, sin_out) = (cos_in.acos(), eta * cos_in.acos().sin());
    if sin_out >= 1.0 {
        return 1.0;
    }
    let o = sin_out.asin();
    if i < 1e-4 {
        return ((eta - 1.0) / (eta + 1.0)).powi(2);
    }
    let (s, p) = ((i - o).sin() / (i + o).sin(), (i - o).tan() / (i + o).tan());
    0.5 * (s * s + p * p)
}

#[test]
fn exact_fresnel_is_that_of_double_precision() {
    let mut worst = 0f64;
    for eta in ETAS {
        for cos in cosines() {
            // At the critical angle the curve is vertical.
            let sin2_out = (eta * eta) as f64 * (1.0 - cos as f64 * cos as f64);
            if (sin2_out - 1.0).abs() > 1e-3 {
                let error = (fresnel_exact(cos, eta) as f64 - by_angles(cos as f64, eta as f64)).abs();
                worst = worst.max(error);
                assert!(error < 2e-5, "{eta} {cos}: {error}");
            }
        }
    }
    println!("exact Fresnel: largest error {worst:.2e}");
}

#[test]
fn normal_incidence_reflects_the_squared_ratio() {
    for mode in [FresnelMode::Exact, FresnelMode::Schlick, FresnelMode::Constant] {
        for eta in ETAS {
            let expected = ((eta as f64 - 1.0) / (eta as f64 + 1.0)).powi(2);
            let got = fresnel_factor(mode, 1.0, eta) as f64;
            assert!((got - expected).abs() < 1e-7, "{mode:?} {eta}: {got} instead of {expected}");
        }
        assert!((fresnel_factor(mode, 1.0, 1.0 / 1.5) - 0.04).abs() < 1e-7);
    }
}

#[test]
fn grazing_incidence_reflects_everything_but_in_the_constant_mode() {
    for eta in [1.0 / 1.333, 1.0 / 1.5, 1.0 / 2.419] {
        assert_eq!(fresnel_factor(FresnelMode::Exact, 0.0, eta), 1.0);
        assert_eq!(fresnel_factor(FresnelMode::Schlick, 0.0, eta), 1.0);
        let constant = fresnel_factor(FresnelMode::Constant, 0.0, eta);
        assert_eq!(constant, reflectance_at_normal_incidence(eta));
    }
}

#[test]
fn at_brewsters_angle_only_perpendicular_light_is_reflected() {
    for eta in ETAS {
        // tan = n2 / n1 = 1 / eta; then R = cos^2(2 angle) / 2.
        let angle = (1.0 / eta as f64).atan();
        let expected = 0.5 * (2.0 * angle).cos().powi(2);
        let got = fresnel_exact(angle.cos() as f32, eta) as f64;
        assert!((got - expected).abs() < 1e-6, "{eta}: {got} instead of {expected}");
    }
}

#[test]
fn schlick_is_its_polynomial_and_reaches_one_at_the_critical_angle() {
    for eta in ETAS {
        let f0 = ((eta as f64 - 1.0) / (eta as f64 + 1.0)).powi(2);
        for cos in cosines() {
            let sin2_out = (eta as f64).powi(2) * (1.0 - (cos as f64).powi(2));
            let outer = if eta > 1.0 { (1.0 - sin2_out).max(0.0).sqrt() } else { cos as f64 };
            let expected = if sin2_out >= 1.0 { 1.0 } else { f0 + (1.0 - f0) * (1.0 - outer).powi(5) };
            let got = fresnel_schlick(cos, eta) as f64;
            assert!(
                (got - expected).abs() < 1e-5 || (sin2_out - 1.0).abs() < 1e-3,
                "{eta} {cos}: {got} {expected}"
            );
        }
    }
}

#[test]
fn equal_media_reflect_nothing_and_bend_nothing() {
    let d = vec3(0.6, -0.8, 0.0);
    assert_eq!(fresnel_exact(0.8, 1.0), 0.0);
    match refract(d, vec3(0.0, 1.0, 0.0), 1.0) {
        Refracted::Through(out) => assert!((out - d).length() < 1e-6),
        Refracted::TotalReflection => panic!(),
    }
}

#[test]
fn reflection_beyond_the_critical_angle_is_total_in_every_mode() {
    for eta in ETAS.into_iter().filter(|eta| *eta > 1.0) {
        let critical = (1.0 / eta as f64).asin();
        for (factor, total) in [(0.999, false), (1.001, true), (1.01, true)] {
            let angle = (critical * factor).min(1.57);
            let (cos, d) = (angle.cos() as f32, vec3(angle.sin() as f32, -angle.cos() as f32, 0.0));
            let bent = refract(d, vec3(0.0, 1.0, 0.0), eta);
            assert_eq!(bent == Refracted::TotalReflection, total, "{eta} {factor}");
            for mode in [FresnelMode::Exact, FresnelMode::Schlick, FresnelMode::Constant] {
                assert_eq!(fresnel_factor(mode, cos, eta) == 1.0, total, "{mode:?} {eta} {factor}");
            }
        }
    }
}

#[test]
fn refraction_keeps_snells_law_and_the_plane_of_incidence() {
    let normals = [vec3(0.0, 1.0, 0.0), vec3(-0.36, 0.48, 0.8), vec3(1.0, 1.0, 1.0).normalize()];
    let mut worst = 0f64;
    for n in normals {
        for eta in ETAS {
            for i in 0..200 {
                let d =
                    vec3((i as f32 * 0.7).sin(), (i as f32 * 1.3).cos(), (i as f32 * 2.1).sin()).normalize();
                let d = if d.dot(n) > 0.0 { -d } else { d };
                let Refracted::Through(out) = refract(d, n, eta) else { continue };
                let cross = |a: Vec3, b: Vec3| a.cross(b);
                // n x out = eta n x d: sine and plane at once.
                let error = (cross(n, out) - cross(n, d) * eta).length() as f64;
                assert!(error < 1e-6 && out.dot(n) <= 0.0, "{d:?} {n:?} {eta}: {error}");
                assert!((out.length() - 1.0).abs() < 1e-6);
                worst = worst.max(error);
            }
        }
    }
    println!("Snell: largest error of n x out {worst:.2e}");
}

#[test]
fn refraction_there_and_back_is_the_way_back() {
    let n = vec3(0.0, 0.0, 1.0);
    for i in 1..90 {
        let angle = (i as f32).to_radians();
        let d = vec3(angle.sin(), 0.0, -angle.cos());
        let Refracted::Through(inside) = refract(d, n, 1.0 / 1.5) else { panic!() };
        let Refracted::Through(back) = refract(-inside, -n, 1.5) else { panic!() };
        // Near grazing the angle outside is ill-defined by that inside.
        assert!((back + d).length() < 2e-6 / angle.cos(), "{i}");
        // Reflectance is the same from both sides.
        let (outer, inner) = (fresnel_exact(-d.dot(n), 1.0 / 1.5), fresnel_exact(-inside.dot(n), 1.5));
        assert!((outer - inner).abs() < 2e-6 / angle.cos(), "{i}");
    }
}

#[test]
fn mirror_directions_turn_the_normal_part_alone() {
    let n = vec3(-0.36, 0.48, 0.8);
    let d = vec3(0.6, 0.0, -0.8);
    let r = reflect(d, n);
    assert!((r.dot(n) + d.dot(n)).abs() < 1e-6);
    assert!((r.cross(n) - d.cross(n)).length() < 1e-6);
}
