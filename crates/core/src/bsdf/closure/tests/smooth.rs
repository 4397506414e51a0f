//! Single directions: what can be computed by hand.

use super::*;

/// All that `sample` can give in single directions, by walking through the picks: (direction, weight, probability).
fn singles(closure: &Closure, to_viewer: Vec3) -> Vec<(ScatterSample, f32)> {
    const PICKS: u32 = 1 << 16;
    let mut found: Vec<(ScatterSample, f32)> = Vec::new();
    for i in 0..PICKS {
        let Some(sample) = closure.sample(to_viewer, i as f32 / PICKS as f32, [0.5, 0.25]) else { continue };
        if !sample.is_delta {
            continue;
        }
        match found.iter_mut().find(|(known, _)| known.to_light == sample.to_light) {
            Some((_, part)) => *part += 1.0 / PICKS as f32,
            None => found.push((sample, 1.0 / PICKS as f32)),
        }
    }
    found
}

fn assert_near(got: f32, want: f32) {
    assert!((got - want).abs() < 2e-5, "{got} instead of {want}");
}

#[test]
fn glass_reflects_and_refracts_as_computed_by_hand() {
    // Straight on: ((1.5 - 1) / (1.5 + 1))^2 = 0.04.
    let found = singles(&glass(1.5, false, 0.0), vec3(0.0, 0.0, 1.0));
    assert_eq!(found.len(), 2);
    let [up, down] = [1.0, -1.0].map(|z| found.iter().find(|(sample, _)| sample.to_light.z == z).unwrap());
    assert_near(up.1 * up.0.weight.x, 0.04);
    assert_near(down.1 * down.0.weight.x, 0.96);
    assert!(down.0.is_transmitted && !up.0.is_transmitted && !down.0.is_straight);

    // 60 degrees into water: sin = 0.8660254 / 1.333 = 0.6496815, cos = 0.7602076; s: ((0.5 - 1.333 * 0.7602076) /
    // (0.5 + 1.333 * 0.7602076))^2 = 0.1150682; p: ((1.333 * 0.5 - 0.7602076) / (1.333 * 0.5 + 0.7602076))^2 = 0.0043140.
    let found = singles(&glass(1.333, false, 0.0), vec3(0.8660254, 0.0, 0.5));
    let reflected = found.iter().find(|(sample, _)| !sample.is_transmitted).unwrap();
    let refracted = found.iter().find(|(sample, _)| sample.is_transmitted).unwrap();
    assert_near(reflected.1 * reflected.0.weight.y, 0.5 * (0.1150682 + 0.0043140));
    assert_near(refracted.0.to_light.x, -0.6496815);
    assert_near(refracted.0.to_light.z, -0.7602076);

    // From water beyond the critical angle of 48.6 degrees all is reflected.
    let found = singles(&glass(1.0 / 1.333, false, 0.0), vec3(0.8, 0.0, 0.6));
    assert_eq!(found.len(), 1);
    assert_eq!((found[0].0.to_light, found[0].0.weight), (vec3(-0.8, 0.0, 0.6), Vec3::ONE));
}

#[test]
fn panes_let_light_go_straight() {
    for eta in [1.5, 1.0 / 1.5] {
        // 2 R / (1 + R) with R = 0.04.
        let pane = Closure { glass: 0.5, glass_tint: vec3(1.0, 0.5, 0.25), ..glass(eta, true, 0.0) };
        let to_viewer = vec3(0.0, 0.0, 1.0);
        let straight = pane.straight(1.0);
        assert_near(straight.x, 0.5 * (1.0 - 0.08 / 1.04));
        let found = singles(&pane, to_viewer);
        let through = found.iter().find(|(sample, _)| sample.is_transmitted).unwrap();
        assert!(through.0.is_straight && through.0.to_light == -to_viewer);
        assert_near(through.1 * through.0.weight.x, straight.x);
        assert_near(through.1 * through.0.weight.z, straight.z);
        assert_eq!(straight.z, straight.x * 0.25);
    }
    assert_eq!(glass(1.5, false, 0.0).straight(0.5), Vec3::ZERO);
    assert_eq!(glass(1.5, true, 0.1).straight(0.5), Vec3::ZERO);
}

#[test]
fn glass_of_the_index_around_it_is_not_there() {
    for (is_thin, alpha) in [(false, 0.0), (true, 0.0), (false, 0.3), (true, 1.0)] {
        let closure = glass(1.0, is_thin, alpha);
        let to_viewer = viewer(0.3);
        let found = singles(&closure, to_viewer);
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].0.to_light, found[0].0.weight, found[0].1), (-to_viewer, Vec3::ONE, 1.0));
        // Shadow rays do not see through bodies, whose other side may be far away.
        assert_eq!(closure.straight(0.3), Vec3::splat(f32::from(u8::from(is_thin))));
        let scattered = closure.eval(to_viewer, viewer(0.7));
        assert_eq!((scattered.value, scattered.pdf), (Vec3::ZERO, 0.0));
    }
}

#[test]
fn mirrors_have_schlicks_reflectance() {
    let gold = Closure { metal_f0: vec3(1.0, 0.77, 0.34), metal: 1.0, ..nothing() };
    let found = singles(&gold, viewer(0.5));
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].0.to_light, vec3(-viewer(0.5).x, -viewer(0.5).y, 0.5));
    assert_near(found[0].0.weight.y, 0.77 + 0.23 / 32.0);
    assert_near(found[0].0.weight.z, 0.34 + 0.66 / 32.0);
    assert!(nothing().sample(viewer(0.5), 0.5, [0.5; 2]).is_none());
}
