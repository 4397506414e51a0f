//! What is close before a light that is far away, and what is close behind it.

use super::bodies::Bodies;
use super::judge::{flatten, render};
use crate::vector::*;
use eosphor_render::Accel;
use eosphor_scene::MaterialKind;

/// The ground under a lamp at this place, and a plate of half side 1 at `gap` below the lamp (above it, where that is
/// negative): as the lamp's light goes.
fn under(lamp: V, gap: f64, from_mesh: bool) -> Bodies {
    let mut bodies = Bodies::new(1.0, [0.0; 3]);
    bodies.scene.settings.size = [16, 12];
    bodies.scene.settings.background = single([0.0; 3]);
    bodies.scene.settings.light_samples = 4;
    let (ground, plate) = (bodies.matte(0.8, 0.8, 0.8), bodies.matte(0.5, 0.5, 0.5));
    bodies.quad([[-9.0, 0.0, -9.0], [-9.0, 0.0, 9.0], [9.0, 0.0, 9.0], [9.0, 0.0, -9.0]], ground);
    let down = unit(scaled(lamp, -1.0));
    let [a, b] = beside(down);
    let about = |middle: V, half: f64| {
        let corner = |s: f64, t: f64| along(along(middle, a, s * half), b, t * half);
        [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]
    };
    bodies.quad(about(along(lamp, down, gap), 1.0), plate);
    if from_mesh {
        // It shines along `down`.
        let shining =
            bodies.material(MaterialKind::Emissive { radiance: single([0.5 * dot(lamp, lamp); 3]) });
        bodies.quad(about(lamp, 0.5), shining);
    } else {
        bodies.lamp(lamp, 1.0);
    }
    bodies.camera([3.0, 4.0, 5.0], [0.0; 3], 40.0);
    bodies
}

/// Share of the pixels that are lit.
fn lit(bodies: &Bodies) -> f64 {
    let pixels = render(&flatten(&bodies.scene), Accel::Bvh);
    pixels.iter().filter(|p| p.y > 0.01).count() as f64 / pixels.len() as f64
}

#[test]
fn a_shade_close_before_a_far_lamp_casts_its_shadow() {
    let mut failed = Vec::new();
    for direction in [[0.0, 1.0, 0.0], [0.31, 0.9, -0.22], [-0.6, 0.5, 0.45]].map(unit) {
        for (distance, gap) in [(10.0, 1e-5), (1e3, 2e-4), (1e4, 1e-3), (1e6, 0.1)] {
            for from_mesh in [false, true] {
                let lamp = scaled(direction, distance);
                // On an axis the gap is what numbers near the lamp are apart; elsewhere corners are rounded to either side.
                let gap = if direction[1] == 1.0 { gap } else { 4.0 * gap };
                let [before, behind] = [gap, -gap].map(|gap| lit(&under(lamp, gap, from_mesh)));
                println!("lamp {lamp:?} ({from_mesh}), {gap:e}: {before} lit; plate behind: {behind} lit");
                if before > 0.0 || behind < 0.99 {
                    failed.push(format!(
                        "{lamp:?} mesh {from_mesh} {gap:e}: {before:.3} lit, {behind:.3} behind"
                    ));
                }
            }
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}
