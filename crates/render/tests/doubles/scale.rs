//! The same bodies at other sizes and places.

use super::bodies::Bodies;
use super::judge::{Difference, flatten, judge};
use super::picture::Picture;
use crate::shapes::{cube, icosphere, torus};
use crate::vector::*;

fn grounded(scale: f64, shift: V) -> Bodies {
    let mut bodies = Bodies::new(scale, shift);
    let [dark, light] = [bodies.matte(0.25, 0.2, 0.3), bodies.matte(0.8, 0.75, 0.6)];
    bodies.tiles(4.0, 0.0, 6, [dark, light]);
    bodies.lamp([3.0, 5.0, 2.5], 0.6);
    bodies.camera([0.7, 2.2, 5.5], [0.0, 0.8, 0.0], 42.0);
    bodies
}

fn glass_ball(scale: f64, shift: V) -> Bodies {
    let mut bodies = grounded(scale, shift);
    let (glass, red) = (bodies.glass(1.5), bodies.matte(0.8, 0.2, 0.1));
    bodies.sphere([0.0, 1.0, 0.0], 1.0, glass);
    bodies.sphere([-1.3, 0.5, -1.7], 0.5, red);
    bodies
}

fn nested_glass(scale: f64, shift: V) -> Bodies {
    let mut bodies = grounded(scale, shift);
    let (glass, denser) = (bodies.glass(1.5), bodies.glass(1.2));
    let (air, red) = (bodies.glass(1.0 / 1.5), bodies.matte(0.8, 0.2, 0.1));
    bodies.sphere([0.0, 1.0, 0.0], 1.0, glass);
    bodies.sphere([0.2, 1.1, 0.1], 0.7, denser);
    bodies.sphere([0.2, 1.0, 0.1], 0.25, red);
    bodies.closed(&cube(), 0.5, [-1.7, 0.6, 0.4], glass);
    bodies.sphere([-1.7, 0.6, 0.4], 0.3, air);
    bodies
}

fn mirror_box(scale: f64, shift: V) -> Bodies {
    let mut bodies = Bodies::new(scale, shift);
    let (mirror, red, grey) = (bodies.mirror(), bodies.matte(0.8, 0.3, 0.2), bodies.matte(0.6, 0.65, 0.7));
    bodies.closed(&cube(), 1.0, [0.0; 3], mirror);
    bodies.sphere([-0.3, -0.5, -0.4], 0.35, red);
    bodies.closed(&torus(24, 12), 0.4, [0.4, 0.1, -0.5], grey);
    bodies.lamp([0.3, 0.8, 0.5], 0.8);
    bodies.camera([0.6, 0.35, 0.85], [-0.2, -0.15, -0.4], 70.0);
    bodies.scene.settings.depth = 8;
    bodies
}

fn contact_shadows(scale: f64, shift: V) -> Bodies {
    let mut bodies = grounded(scale, shift);
    let (red, grey) = (bodies.matte(0.8, 0.3, 0.2), bodies.matte(0.6, 0.65, 0.7));
    bodies.sphere([-1.2, 0.5, 0.6], 0.5, red);
    bodies.closed(&cube(), 0.4, [0.9, 0.4, 0.9], grey);
    bodies.closed(&torus(32, 16), 0.8, [0.2, 0.24, -1.2], red);
    bodies.closed(&icosphere(3), 0.35, [0.0, 0.35, 1.9], grey);
    bodies.sun([-0.9, -0.2, -0.35], 0.5);
    bodies
}

type Make = fn(f64, V) -> Bodies;

const SCENES: [(&str, Make); 4] = [
    ("glass ball", glass_ball),
    ("nested glass", nested_glass),
    ("mirror box", mirror_box),
    ("contact shadows", contact_shadows),
];

/// What coordinates of single precision cannot tell apart at this many sizes from the origin, in sizes.
fn resolution(shift: f64) -> f64 {
    shift * 2f64.powi(-23)
}

/// The bound: all pixels but 1 in 1,000, and those at the edges of things, which lie elsewhere by the resolution...
const EDGES: f64 = 24.0;
/// ... are within 1/255 and what the resolution makes of smooth shading...
const SMOOTH: f64 = 1.0;
/// ... and these within so much on average: what the arithmetic of the shading may take, and a share of the resolution.
const MEAN: f64 = 5e-6;
const MEAN_SHARE: f64 = 0.25;

fn check(size: f64, shift: f64) -> Vec<String> {
    let toward = unit([0.61, -0.52, 0.6]);
    let (tolerance, allowed) = (1.0 / 255.0 + SMOOTH * resolution(shift), 0.001 + EDGES * resolution(shift));
    let failed = |(name, make): (&str, Make)| {
        let scene = make(size, scaled(toward, size * shift)).scene;
        let found = judge(&scene, tolerance, 8);
        println!("{name} of size {size:e}, {shift:e} sizes away: {found:?}, {allowed:.4} allowed");
        let within = found.off <= allowed && found.mean <= MEAN + MEAN_SHARE * resolution(shift);
        (!within).then(|| {
            format!("{name}, size {size:e}, {shift:e} away: {:.4} off, {:.1e}", found.off, found.mean)
        })
    };
    SCENES.into_iter().filter_map(failed).collect()
}

#[test]
fn bodies_of_any_size_look_the_same() {
    let failed: Vec<_> = (-6..=6).step_by(2).flat_map(|exponent| check(10f64.powi(exponent), 0.0)).collect();
    assert!(failed.is_empty(), "{failed:#?}");
}

#[test]
fn bodies_far_from_the_origin_err_by_what_coordinates_resolve() {
    let places = [(1.0, 1e1), (1.0, 1e2), (1.0, 1e3), (1.0, 1e4), (1.0, 1e5), (1e-6, 1e4), (1e6, 1e5)];
    let failed: Vec<_> = places.into_iter().flat_map(|(size, shift)| check(size, shift)).collect();
    assert!(failed.is_empty(), "{failed:#?}");
}

/// Rounding the positions of hits alone, with all else in double precision, takes up to a sixth of the bound above.
#[test]
fn rounding_positions_alone_stays_within_the_bound() {
    for shift in [0.0, 1e3, 1e5] {
        for (name, make) in SCENES {
            let scene = make(1.0, scaled(unit([0.61, -0.52, 0.6]), shift)).scene;
            let data = flatten(&scene);
            let mut picture = Picture::new(&scene, &data);
            let truth = picture.pixels();
            picture.rounds_positions = true;
            let tolerance = 1.0 / 255.0 + SMOOTH * resolution(shift);
            let found = Difference::of(&picture.pixels(), &truth, tolerance);
            println!("{name}, {shift:e} away, by rounding alone: {found:?}");
            assert!(found.off <= 0.001 + EDGES / 4.0 * resolution(shift), "{name}, {shift:e}: {found:?}");
        }
    }
}
