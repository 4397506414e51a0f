//! Known answers about the solids and the bodies made of them.

use super::shell::{RIB, Shell};
use super::{Body, BodyLighting, MAX_LIGHTS_PER_EDGE, Solid};
use crate::double::{Vec3d, add, cross, dot, length, scale, sub, unit};
use crate::flatten::SceneData;
use crate::model::{MaterialKind, Scene};
use eosphor_core::light::Light;
use eosphor_core::light::triangle_sample;
use eosphor_core::math::{Vec3, vec3};

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-14
}

fn midpoint(a: Vec3d, b: Vec3d) -> Vec3d {
    scale(add(a, b), 0.5)
}

#[test]
fn names_round_trip() {
    for solid in Solid::ALL {
        assert_eq!(solid.to_string().parse(), Ok(solid));
    }
    assert!("ball".parse::<Solid>().unwrap_err().to_string().contains("there are tetrahedron, cube"));
}

#[test]
fn solids_are_platonic() {
    let sides = [3, 4, 3, 5, 3];
    for (solid, sides) in Solid::ALL.into_iter().zip(sides) {
        let (vertices, faces, edges) = (solid.vertices(), solid.faces(), solid.edges());
        assert_eq!([faces.len(), edges.len()], solid.faces_and_edges(), "{solid}");
        // Euler's formula.
        assert_eq!(vertices.len() + faces.len(), edges.len() + 2, "{solid}");
        assert!(vertices.iter().all(|&v| near(length(v), 1.0)), "{solid}");
        let edge_length = |[a, b]: [usize; 2]| length(sub(vertices[a], vertices[b]));
        let unit_edge = edge_length(edges[0].vertices);
        assert!(edges.iter().all(|e| near(edge_length(e.vertices), unit_edge)), "{solid}");
        for (face, &normal) in faces.iter().zip(&solid.normals()) {
            assert_eq!(face.len(), sides, "{solid}");
            let height = dot(vertices[face[0]], normal);
            assert!(near(length(normal), 1.0) && height > 0.0);
            assert!(face.iter().all(|&v| near(dot(vertices[v], normal), height)), "{solid} is not plane");
            // Regular: the corners are equally far from the middle, and sides turn to the left.
            for i in 0..sides {
                let [a, b, c] = [0, 1, 2].map(|k| vertices[face[(i + k) % sides]]);
                assert!(near(length(sub(a, b)), unit_edge), "{solid}");
                assert!(dot(cross(sub(b, a), sub(c, b)), normal) > 0.0, "{solid}");
            }
            // All others are below.
            assert!(vertices.iter().all(|&v| dot(v, normal) < height + 1e-14), "{solid}");
        }
        // Each edge lies between two faces, and they meet at the dihedral angle.
        for edge in &edges {
            let [left, right] = [edge.left, edge.right].map(|face| solid.normals()[face]);
            assert_ne!(edge.left, edge.right);
            assert!(
                edge.vertices.iter().all(|v| faces[edge.left].contains(v) && faces[edge.right].contains(v))
            );
            assert!(near(dot(left, right), -solid.cos_dihedral()), "{solid}");
        }
    }
}

#[test]
fn dihedral_angles_are_those_of_the_books() {
    let degrees = [70.528_779_365, 90.0, 109.471_220_634, 116.565_051_177, 138.189_685_104];
    for (solid, degrees) in Solid::ALL.into_iter().zip(degrees) {
        assert!((solid.cos_dihedral().acos().to_degrees() - degrees).abs() < 1e-8, "{solid}");
    }
}

#[test]
fn triangles_are_counted() {
    for n in [0, 1, 2, 5] {
        let expected = [16 + 6 * n, 36 + 12 * n, 32 + 12 * n, 96 + 30 * n, 80 + 30 * n];
        for (solid, expected) in Solid::ALL.into_iter().zip(expected) {
            let shell = Shell::new(solid, n);
            let triangles = shell.faces.len() + shell.ribs.len() + shell.diodes.len();
            assert_eq!(
                (triangles, solid.triangle_count(n)),
                (expected as usize, expected as usize),
                "{solid}"
            );
        }
    }
}

/// Faces lie in planes at the right distance, and ribs are rectangles of the right width whose long sides are sides of
/// faces: the same corners, by number.
#[test]
fn ribs_close_the_gaps_between_faces() {
    for solid in Solid::ALL {
        let shell = Shell::new(solid, 0);
        let corner = |i: u32| shell.corners[i as usize];
        let (vertices, edges) = (solid.vertices(), solid.edges());
        let half_exterior = (std::f64::consts::PI - solid.cos_dihedral().acos()) / 2.0;
        let out = RIB / half_exterior.sin();
        // Undoing the shift gives the vertices.
        let mut first = 0;
        for (face, normal) in solid.faces().into_iter().zip(solid.normals()) {
            for vertex in face {
                let undone = sub(corner(first), scale(normal, out));
                assert!(length(sub(undone, vertices[vertex])) < 1e-14, "{solid}");
                first += 1;
            }
        }
        assert_eq!(first as usize, shell.corners.len());
        for (edge, rib) in edges.iter().zip(shell.ribs.chunks(2)) {
            let [[la, ra, rb], [la2, rb2, lb]] = [rib[0], rib[1]];
            assert_eq!((la, rb), (la2, rb2));
            let [a, b] = edge.vertices.map(|v| vertices[v]);
            let outward = unit(add(a, b));
            // As far out as the rule says, and as wide.
            let middle = midpoint(midpoint(corner(la), corner(rb)), midpoint(corner(ra), corner(lb)));
            let expected = length(midpoint(a, b)) + RIB / half_exterior.tan();
            assert!(near(dot(middle, outward), expected) && near(length(middle), expected), "{solid}");
            for (l, r) in [(la, ra), (lb, rb)] {
                let across = sub(corner(l), corner(r));
                assert!(near(length(across), 2.0 * RIB) && near(dot(across, outward), 0.0), "{solid}");
                assert!(near(dot(across, sub(b, a)), 0.0), "{solid}");
            }
            // Both triangles face outward.
            for [p, q, r] in [rib[0], rib[1]].map(|t| t.map(corner)) {
                assert!(dot(cross(sub(q, p), sub(r, p)), outward) > 0.0, "{solid}");
            }
            // The sides are sides of faces.
            let is_side = |x: u32, y: u32| {
                let t = |t: &&[u32; 3]| t.contains(&x) && t.contains(&y);
                shell.faces.iter().filter(t).count() >= 1
            };
            assert!(is_side(la, lb) && is_side(ra, rb), "{solid}");
        }
    }
}

#[test]
fn diodes_are_inside_behind_their_ribs_and_face_the_middle() {
    for solid in Solid::ALL {
        for n in [1, 3, 10, 100, MAX_LIGHTS_PER_EDGE] {
            let shell = Shell::new(solid, n);
            let planes: Vec<(Vec3d, f64)> = planes(solid, &shell);
            let edges = solid.edges();
            for (i, diode) in shell.diodes.iter().enumerate() {
                let [a, b] = edges[i / n as usize].vertices.map(|v| solid.vertices()[v]);
                let outward = unit(add(a, b));
                let rib = shell.ribs[i / n as usize * 2].map(|c| shell.corners[c as usize]);
                for &p in diode {
                    assert!(planes.iter().all(|&(normal, height)| dot(p, normal) < height - 1e-3), "{solid}");
                    assert!(near(dot(rib[0], outward) - dot(p, outward), 0.005), "{solid}");
                }
                let [p, q, r] = *diode;
                let normal = cross(sub(q, p), sub(r, p));
                assert!(near(dot(unit(normal), outward), -1.0), "{solid} faces outward");
                // At i/(n+1).
                let middle = scale(add(p, add(q, r)), 1.0 / 3.0);
                let share = dot(sub(middle, a), sub(b, a)) / dot(sub(b, a), sub(b, a));
                let expected = f64::from((i as u32) % n + 1) / f64::from(n + 1);
                assert!((share - expected).abs() < 1e-12, "{solid}");
            }
        }
    }
}

/// Normals of the moved faces and their distances from the middle.
fn planes(solid: Solid, shell: &Shell) -> Vec<(Vec3d, f64)> {
    let mut first = 0;
    let place = |(face, normal): (Vec<usize>, Vec3d)| {
        let height = dot(shell.corners[first], normal);
        first += face.len();
        (normal, height)
    };
    solid.faces().into_iter().zip(solid.normals()).map(place).collect()
}

/// A body alone, flattened.
fn flat(body: &Body) -> SceneData {
    let mut scene = Scene::default();
    body.add_to(&mut scene).unwrap();
    SceneData::flatten(&scene).unwrap().0
}

#[test]
fn bodies_have_their_place_and_size() {
    let body = Body { center: vec3(2.0, -1.0, 0.5), radius: 1.25, ..Body::new(Solid::Octahedron) };
    let mut scene = Scene::default();
    body.add_to(&mut scene).unwrap();
    let mesh = &scene.meshes[0];
    let shell = Shell::new(body.shape, 0);
    for (p, unit) in mesh.positions.iter().zip(&shell.corners) {
        let [x, y, z] = [0, 1, 2].map(|k| (f64::from(body.center[k]) + 1.25 * unit[k]) as f32);
        assert_eq!(*p, vec3(x, y, z));
    }
    assert_eq!(mesh.positions.len(), 24);
    let MaterialKind::Transparent { color, diffuse, reflection, shininess, .. } = scene.materials[0].kind
    else {
        panic!()
    };
    assert_eq!((color, diffuse, reflection, shininess), (body.color, 0.5, body.reflection, 64.0));
    assert!(scene.lights.is_empty());
}

/// PLATO's way: one light in the middle, and lights along the edges that are only seen.
#[test]
fn the_light_in_the_middle_is_the_only_one() {
    let color = vec3(1.0, 0.0, 0.0);
    let body = Body { center: vec3(1.0, 2.0, 3.0), lights_per_edge: 2, color, ..Body::new(Solid::Cube) };
    let data = flat(&body);
    assert_eq!(data.triangles.len(), 36 + 24);
    let [Light::Point { position, color }] = data.lights[..] else { panic!("{:?}", data.lights) };
    let over_pi = (f64::from(0.7f32) / std::f64::consts::PI) as f32;
    assert_eq!((position, color), (body.center, Vec3::splat(over_pi)));
    let seen = data.materials.iter().filter(|m| m.emission == vec3(1.0, 0.5, 0.5)).count();
    assert_eq!(seen, 1);
}

/// All diodes together: the mean irradiance over a sphere of the body's radius is the power, by sums over points of the
/// sphere, whatever the solid, its size and the number of its lights.
#[test]
fn diodes_together_have_their_power() {
    for (shape, radius, n) in [(Solid::Tetrahedron, 1.0, 1), (Solid::Dodecahedron, 2.5, 3)] {
        let lighting = BodyLighting::Diodes { power: 0.7 };
        let data = flat(&Body { radius, lights_per_edge: n, lighting, ..Body::new(shape) });
        let [_, edges] = shape.faces_and_edges();
        assert_eq!(data.lights.len(), edges * n as usize);
        // Well inside the sphere on which the flux is measured the diodes are small, so one point each will do. On a sphere
        // of three radii all of the flux arrives too, over nine times the area.
        const POINTS: u32 = 20_000;
        let sphere = 3.0 * radius;
        let mut sum = 0.0;
        for i in 0..POINTS {
            let z = (2.0 * f64::from(i) + 1.0) / f64::from(POINTS) - 1.0;
            let phi = f64::from(i) * 2.399_963_229_728_653;
            let r = (1.0 - z * z).sqrt();
            let out = vec3((r * phi.cos()) as f32, (r * phi.sin()) as f32, z as f32);
            for light in &data.lights {
                let Light::Triangle { v0, e1, e2, normal, area, color, .. } = *light else { panic!() };
                let middle = v0 + (e1 + e2) * (1.0 / 3.0);
                let sample = triangle_sample(middle - out * sphere, normal, area);
                let cos = (-out).dot(sample.to_light).max(0.0);
                sum += std::f64::consts::PI * f64::from(sample.weight * cos * color.x);
            }
        }
        let mean = sum / f64::from(POINTS) * 9.0;
        assert!((mean - 0.7).abs() < 0.004, "{shape}: {mean}");
    }
}

#[test]
fn light_of_a_diode_falls_off_as_the_model_says() {
    let lighting = BodyLighting::Diodes { power: 1.0 };
    let data = flat(&Body { lights_per_edge: 1, lighting, ..Body::new(Solid::Octahedron) });
    let Light::Triangle { e1, normal, area, .. } = data.lights[0] else { panic!() };
    // On the axis: S / d^2; aside by 60 degrees, half of it; behind, nothing.
    let weight = |offset: Vec3| triangle_sample(-offset, normal, area).weight;
    let [near, far] = [0.5, 1.5].map(|d| weight(normal * d));
    assert!((near - area / 0.25).abs() < 1e-5 * near && (near / far - 9.0).abs() < 1e-4);
    let slanted = normal * 0.5 + e1.normalize() * 0.75_f32.sqrt();
    assert!((weight(slanted) - area * 0.5).abs() < 1e-5 * area);
    assert_eq!(weight(normal * -1.0), 0.0);
    // It is an equilateral triangle with a circumradius of 0.04.
    assert!((area - 0.75 * 3.0f32.sqrt() * 0.0016).abs() < 1e-8);
}

#[test]
fn what_is_out_of_range_is_said() {
    let ok = Body::new(Solid::Cube);
    let wrong = [
        (Body { radius: 0.0, ..ok }, "radius"),
        (Body { radius: f32::NAN, ..ok }, "radius"),
        (Body { center: Vec3::splat(f32::INFINITY), ..ok }, "radius"),
        (Body { color: vec3(0.0, 2.0, 0.0), ..ok }, "color"),
        (Body { transparency: -0.1, ..ok }, "transparency"),
        (Body { reflection: f32::NAN, ..ok }, "reflection"),
        (Body { lights_per_edge: 1001, ..ok }, "lights an edge"),
        (Body { lighting: BodyLighting::Centre { power: -1.0 }, ..ok }, "power"),
    ];
    for (body, field) in wrong {
        let error = body.add_to(&mut Scene::default()).unwrap_err().to_string();
        assert!(error.starts_with(&format!("cube: {field}: ")), "{error}");
    }
}
