//! Shading normals that a surface does not have: directions stay on their side of it, and move no farther than they must.

use eosphor_core::bsdf::{Refracted, mirror_above, reflect, refract, through_surface, turned_up};
use eosphor_core::math::{Vec3, vec3};
use proptest::prelude::*;

/// Unit vectors, among them such as lie almost in the planes of the axes.
fn unit() -> impl Strategy<Value = Vec3> {
    let number = || prop_oneof![6 => -1.0..1.0f32, 1 => -1e-6..1e-6f32, 1 => Just(0.0f32)];
    (number(), number(), number())
        .prop_map(|(x, y, z)| vec3(x, y, z))
        .prop_filter("no direction", |v| v.length_squared() > 1e-9)
        .prop_map(Vec3::normalize)
}

fn sine_between(a: Vec3, b: Vec3) -> f64 {
    f64::from(a.cross(b).length())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20_000))]

    #[test]
    fn normals_are_turned_to_their_side_and_no_farther(n in unit(), above in unit()) {
        let turned = turned_up(n, above);
        prop_assert!((turned.length() - 1.0).abs() < 1e-6);
        prop_assert!((turned.dot(above) - n.dot(above).abs()).abs() < 1e-6);
        if n.dot(above) >= 0.0 {
            prop_assert_eq!(turned, n);
        }
        prop_assert!((turned_up(-above, above) - above).length() < 1e-6);
    }

    #[test]
    fn mirrored_rays_stay_above(d in unit(), n in unit(), above in unit()) {
        let d = turned_up(d, -above);
        let n = turned_up(n, above);
        let (mirrored, bent) = mirror_above(d, n, above);
        prop_assert!(mirrored.dot(above) > 0.0, "{}", mirrored.dot(above));
        prop_assert!((mirrored.length() - 1.0).abs() < 1e-6 && (bent.length() - 1.0).abs() < 1e-6);
        // The bent normal mirrors to where the ray goes; where that is nearly straight on it is ill-defined.
        let between = (mirrored - d).length();
        prop_assert!(bent.dot(above) > -1e-6 && -d.dot(bent) > -1e-6 / between.min(1.0));
        prop_assert!((reflect(d, bent) - mirrored).length() < 4e-6 / between.min(1.0));
        let plain = reflect(d, n);
        if plain.dot(above) > 1.0 / 128.0 {
            prop_assert_eq!(bent, n);
            prop_assert!((mirrored - plain).length() < 3e-6);
        } else if plain.dot(above) > -0.99 {
            // Straight up, to a tangent of no more than 1/128 over what it has along the surface.
            let (side, along) = (above.cross(plain), above.cross(plain).length());
            prop_assert!(mirrored.dot(side).abs() < 1e-6);
            prop_assert!(mirrored.dot(above) * along < 1.0 / 128.0 + 1e-6, "{} {along}", mirrored.dot(above));
            let up = mirrored.dot(above).asin() - plain.dot(above).asin();
            prop_assert!((f64::from(up.sin().abs()) - sine_between(plain, mirrored)).abs() < 1e-5);
        }
    }

    #[test]
    fn refracted_rays_go_through(d in unit(), n in unit(), above in unit(), eta in 0.4..2.5f32) {
        let d = turned_up(d, -above);
        let (_, n) = mirror_above(d, turned_up(n, above), above);
        let Refracted::Through(bent) = refract(d, n, eta) else { return Ok(()) };
        let through = through_surface(bent, above);
        prop_assert!(through.dot(above) < 0.0 && (through.length() - 1.0).abs() < 1e-6);
        if bent.dot(above) < 0.0 {
            prop_assert_eq!(through, bent);
        } else {
            prop_assert!((through.dot(above) + bent.dot(above).max(1.0 / 4096.0)).abs() < 2e-6);
        }
        // Into the denser medium Snell's law never bends a ray back.
        prop_assert!(eta > 1.0 || bent.dot(above) < 1e-6, "{}", bent.dot(above));
    }
}

#[test]
fn a_normal_of_the_surface_itself_changes_nothing() {
    for i in 0..=1000 {
        let angle = f64::from(i) / 1000.0 * std::f64::consts::FRAC_PI_2;
        let (d, n) = (vec3(angle.sin() as f32, -angle.cos() as f32, 0.0), vec3(0.0, 1.0, 0.0));
        let (mirrored, bent) = mirror_above(d, n, n);
        if i < 1000 {
            assert_eq!(bent, n);
        }
        assert!(
            (mirrored - reflect(d, n)).length() < if i < 1000 { 1e-6 } else { 3e-4 },
            "{i}: {mirrored:?}"
        );
    }
}

/// A facet of a sphere, seen from where the sphere's own normal turns away: the closed form is the sphere's mirror image,
/// which lies below the facet by the angle `b`. What is lifted errs by `b` and half a degree at most; mirrored up at the
/// facet it would err by `2 b`.
#[test]
fn silhouettes_of_facets_err_by_what_lies_below() {
    let above = vec3(0.0, 1.0, 0.0);
    for tilt in [5.0f64, 10.0, 20.0] {
        for view in [60.0f64, 70.0, 80.0, 85.0, 89.0] {
            let (t, v) = (tilt.to_radians(), view.to_radians());
            // The viewer is on the side of -x, the normal leans to +x.
            let d = vec3(v.sin() as f32, -v.cos() as f32, 0.0);
            let n = vec3(t.sin() as f32, t.cos() as f32, 0.0);
            let below = v + 2.0 * t - std::f64::consts::FRAC_PI_2;
            let (mirrored, bent) = mirror_above(d, n, above);
            let error = sine_between(mirrored, reflect(d, n)).asin();
            if below < 0.0 && -below > (1.0f64 / 128.0).asin() {
                assert!(error < 1e-6 && bent == n);
                continue;
            }
            // Lifted along the facet's normal to the sine `least`; the tangential part keeps its length.
            let least = (0.875 * v.cos()).min(1.0 / 128.0);
            let elevation = (least / below.cos()).atan();
            assert!((error - (below + elevation)).abs() < 1e-6, "{tilt} {view}: {error} {below}");
            // The bent normal lies half-way between the viewer and the lifted ray.
            let half = (v + std::f64::consts::FRAC_PI_2 - elevation) / 2.0;
            assert!((f64::from(-d.dot(bent)) - half.cos()).abs() < 1e-5, "{tilt} {view}: {bent:?}");
        }
    }
}
