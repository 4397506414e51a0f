//! Small things on a ground of any size, level and tilted, cut into any triangles.

use super::bodies::Bodies;
use super::judge::judge;
use crate::double::{Double, Shape};
use crate::shapes::{Closed, icosphere, torus};
use crate::vector::*;
use eosphor_core::math::Vec3;
use eosphor_scene::{Instance, LoadOptions, Transform, load};

/// How a ground is cut.
#[derive(Clone, Copy, Debug)]
enum Cut {
    /// Into two triangles.
    Quad,
    /// Into so many triangles around a point beside the middle; of many, each is a sliver that runs under the things.
    Fan(usize),
    /// Into strips as narrow as the things, from one end to the other. A tilted one would not be a plane: rounding its far
    /// corners moves them by more than a strip is wide.
    Strips,
}

/// Every cut that is a plane, level (x, y and z as they are) or not.
fn grounds() -> [(&'static str, Cut, [V; 3]); 7] {
    let (level, cuts) =
        ([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [Cut::Quad, Cut::Fan(7), Cut::Fan(151)]);
    let [a, b, c] = cuts.map(|how| ("level", how, level));
    let [d, e, f] = cuts.map(|how| ("tilted", how, tilted()));
    [a, b, c, ("level", Cut::Strips, level), d, e, f]
}

/// Points of the plane, and triangles that face up.
fn cut(how: Cut, half: f64) -> (Vec<V>, Vec<[usize; 3]>) {
    let up = |[x, z]: [f64; 2]| [x, 0.0, z];
    match how {
        Cut::Quad => {
            let corners = [[-half, -half], [-half, half], [half, half], [half, -half]];
            (corners.map(up).to_vec(), vec![[0, 1, 2], [0, 2, 3]])
        }
        Cut::Fan(count) => {
            let on_rim = |k: usize| {
                let (s, c) = (k as f64 / count as f64 * std::f64::consts::TAU + 0.2).sin_cos();
                let reach = half / s.abs().max(c.abs());
                [reach * c, -reach * s]
            };
            let points = std::iter::once([0.11, -0.07]).chain((0..count).map(on_rim)).map(up).collect();
            (points, (0..count).map(|k| [0, 1 + k, 1 + (k + 1) % count]).collect())
        }
        Cut::Strips => {
            // From the things outwards, each is as wide as all within it.
            let mut xs = vec![-0.31, -0.12, 0.04, 0.17, 0.43];
            while xs[xs.len() - 1] < half {
                let end = xs[xs.len() - 1];
                xs.insert(0, (-2.2 * end).max(-half));
                xs.push((2.1 * end).min(half));
            }
            let points = xs.iter().flat_map(|&x| [up([x, -half]), up([x, half])]).collect();
            let strip = |k: usize| [[2 * k, 2 * k + 1, 2 * k + 3], [2 * k, 2 * k + 3, 2 * k + 2]];
            (points, (0..xs.len() - 1).flat_map(strip).collect())
        }
    }
}

/// A unit vector that no axis is near to, and two beside it.
fn tilted() -> [V; 3] {
    let up = unit([0.37, 0.83, -0.29]);
    let [x, z] = beside(up);
    // Right-handed as x, y, z are.
    if dot(cross(x, up), z) > 0.0 { [x, up, z] } else { [z, up, x] }
}

/// A shape that stands at 0: the torus, or a file's ([`load`]) named by the environment, as large as the other bodies.
fn body() -> Closed {
    let Some(file) = std::env::var_os("EOSPHOR_TEST_OBJ") else {
        return torus(48, 24).mapped(|p| along([0.0, 0.3, 0.0], p, 1.0));
    };
    let loaded = load(file.to_str().unwrap(), &LoadOptions::default()).unwrap().scene;
    let mesh = &loaded.meshes[0];
    let points: Vec<V> = mesh.positions.iter().map(|p| double(*p)).collect();
    let fold = |by: fn(f64, f64) -> f64, from: f64| {
        points.iter().fold([from; 3], |a, p| [0, 1, 2].map(|i| by(a[i], p[i])))
    };
    let (low, high) = (fold(f64::min, f64::MAX), fold(f64::max, f64::MIN));
    let middle = scaled(add(low, high), 0.5);
    let positions = points
        .iter()
        .map(|p| scaled(sub(*p, [middle[0], low[1], middle[2]]), 2.0 / (high[0] - low[0])))
        .collect();
    let triangles = mesh.triangles.iter().map(|t| t.positions.map(|v| v as usize)).collect();
    Closed { name: "file", positions, triangles }
}

/// Adds the ground; returns its points in the world and its triangles.
fn lay(bodies: &mut Bodies, how: Cut, half: f64, material: u32) -> (Vec<Vec3>, Vec<[usize; 3]>) {
    let (points, triangles) = cut(how, half);
    let points: Vec<Vec3> = points.into_iter().map(|p| single(bodies.point(p))).collect();
    let mesh = bodies.mesh(&points, &triangles, material);
    bodies.scene.instances.push(Instance::new(mesh, Transform::default()));
    (points, triangles)
}

/// The ground, and things on it that are told apart from it by less than 1/10.
fn things(half: f64, how: Cut, axes: [V; 3]) -> Bodies {
    let mut bodies = Bodies::turned(1.0, [0.0; 3], axes);
    let (ground, red) = (bodies.matte(0.7, 0.68, 0.6), bodies.matte(0.8, 0.25, 0.2));
    let (mirror, glass) = (bodies.mirror(), bodies.glass(1.5));
    let (points, triangles) = lay(&mut bodies, how, half, ground);
    // Corners are rounded: far ones of a tilted ground by so much that its plane is elsewhere.
    let shapes = triangles.iter().map(|t| Shape::Triangle(t.map(|v| double(points[v]))));
    let plane = Double::new(shapes.collect());
    let on = |x: f64, z: f64| {
        let down = bodies.direction([0.0, -1.0, 0.0]);
        let from = bodies.point([x, 10.0, z]);
        10.0 - plane.closest(from, down, f64::INFINITY, None).unwrap().t()
    };
    let heights = [on(-0.2, 0.1), on(0.1, -0.15), on(0.15, 0.25), on(0.42, 0.0), on(-0.05, 0.32)];
    bodies.sphere([-0.2, heights[0] + 0.1, 0.1], 0.1, red);
    bodies.closed(&body(), 0.15, [0.1, heights[1], -0.15], red);
    bodies.sphere([0.15, heights[2] + 0.08, 0.25], 0.08, glass);
    bodies.sphere([0.42, heights[3] + 0.12, 0.0], 0.12, mirror);
    // Not quite on it.
    bodies.closed(&icosphere(2), 0.05, [-0.05, heights[4] + 0.0505, 0.32], red);
    bodies.lamp([0.9, 1.4 + heights[0], 0.8], 0.5);
    bodies.sun([-0.5, -0.35, -0.4], 0.5);
    bodies.camera([0.35, 0.55 + heights[0], 1.15], [0.08, 0.02 + heights[0], 0.0], 46.0);
    bodies
}

#[test]
fn things_on_a_ground_look_the_same_however_large_it_is() {
    let mut failed = Vec::new();
    for half in [1.0, 1e2, 1e4, 1e7] {
        for (name, how, axes) in grounds() {
            let found = judge(&things(half, how, axes).scene, 1.0 / 255.0, 8);
            println!("{name} ground of ±{half:e}, {how:?}: {found:?}");
            if found.off > 0.001 {
                failed.push(format!("{name} ±{half:e} {how:?}: {:.4} off", found.off));
            }
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}

/// A plane that is seen and lit at this angle.
fn grazed(half: f64, how: Cut, axes: [V; 3], degrees: f64) -> Bodies {
    let mut bodies = Bodies::turned(1.0, [0.0; 3], axes);
    let ground = bodies.matte(0.9, 0.9, 0.9);
    lay(&mut bodies, how, half, ground);
    let (sin, cos) = degrees.to_radians().sin_cos();
    // As bright as a surface that faces it would be, so that what is in shadow by mistake is seen.
    bodies.sun([-0.8 * cos, -sin, -0.6 * cos], 1.0 / sin);
    let sight = 0.6 * half.min(1e4);
    bodies.camera([0.1, sight * sin, sight * cos], [0.0; 3], 30.0);
    bodies.scene.settings.background = single([0.0; 3]);
    bodies
}

#[test]
fn planes_at_grazing_angles_have_no_speckle() {
    let mut failed = Vec::new();
    for half in [1.0, 1e3, 1e7] {
        for (name, how, axes) in grounds() {
            // The tilted planes are as flat as their corners are exact.
            for degrees in [5.0, 0.5, 0.05] {
                let found = judge(&grazed(half, how, axes, degrees).scene, 1.0 / 255.0, 2);
                println!("{name} ground of ±{half:e}, {how:?}, {degrees}°: {found:?}");
                if found.off > 0.001 {
                    failed.push(format!("{name} ±{half:e} {how:?} {degrees}°: {:.4} off", found.off));
                }
            }
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}
