//! Meshes some of whose faces run against their normals load as the same mesh wound rightly.

use super::source::Source;
use super::{LoadOptions, LoadedScene, load_from};
use crate::model::{Mesh, NO_INDEX};
use crate::{NormalMode, SceneData};
use eosphor_core::light::Light;
use eosphor_core::math::Vec3;
use proptest::prelude::*;
use std::fmt::Write;
use std::path::{Path, PathBuf};

fn load_files(files: &[(&str, &str)]) -> LoadedScene {
    let memory = files.iter().map(|(name, text)| (PathBuf::from(name), text.as_bytes().to_vec().into()));
    load_from(Source::Memory(memory.collect()), Path::new(files[0].0), &LoadOptions::default()).unwrap()
}

fn load(name: &str, text: &str) -> LoadedScene {
    load_files(&[(name, text)])
}

fn notes(loaded: &LoadedScene) -> Vec<String> {
    loaded.warnings.iter().map(|w| w.to_string()).collect()
}

/// Position, texture coordinates and normal.
type Corner = (Vec3, Option<[f32; 2]>, Option<Vec3>);

/// Of all triangles: numbers of vertices may differ.
fn corners(mesh: &Mesh) -> Vec<[Corner; 3]> {
    let some = |n: u32| (n != NO_INDEX).then_some(n as usize);
    let of = |t: &crate::Triangle| {
        [0, 1, 2].map(|k| {
            let uv = some(t.uvs[k]).map(|n| mesh.uvs[n]);
            (mesh.positions[t.positions[k] as usize], uv, some(t.normals[k]).map(|n| mesh.normals[n]))
        })
    };
    mesh.triangles.iter().map(of).collect()
}

/// Faces of a body in the making, each with its corners: indices of vertex, texture coordinate and normal, from 1.
#[derive(Clone, Default)]
struct Body {
    vertices: String,
    faces: Vec<Vec<[usize; 3]>>,
}

impl Body {
    /// A torus of squares, every third of which is two triangles, with exact normals. At the seams vertices are shared,
    /// texture coordinates are not.
    fn torus(rings: usize, segments: usize) -> Body {
        let mut body = Body::default();
        for i in 0..rings {
            for j in 0..segments {
                let turn = |k: usize, n: usize| k as f64 / n as f64 * std::f64::consts::TAU;
                let ((sp, cp), (st, ct)) = (turn(i, rings).sin_cos(), turn(j, segments).sin_cos());
                let (nx, ny, nz) = (ct * cp, ct * sp, st);
                let (x, y) = (2.0 * cp + 0.7 * nx, 2.0 * sp + 0.7 * ny);
                writeln!(body.vertices, "v {x} {y} {}\nvn {nx} {ny} {nz}", 0.7 * nz).unwrap();
            }
        }
        for i in 0..=rings {
            (0..=segments).for_each(|j| writeln!(body.vertices, "vt 0.{i:03} 0.{j:03}").unwrap());
        }
        for i in 0..rings {
            for j in 0..segments {
                let corner = |di: usize, dj: usize| {
                    let v = (i + di) % rings * segments + (j + dj) % segments + 1;
                    [v, (i + di) * (segments + 1) + j + dj + 1, v]
                };
                let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                match (i + j) % 3 {
                    0 => body.faces.extend([vec![a, b, c], vec![a, c, d]]),
                    _ => body.faces.push(vec![a, b, c, d]),
                }
            }
        }
        body
    }

    /// As a file. Faces are written as they are, or with all corners but the first in reverse.
    fn obj(&self, is_reversed: impl Fn(usize) -> bool) -> String {
        let mut text = self.vertices.clone();
        for (number, face) in self.faces.iter().enumerate() {
            let mut face = face.clone();
            if is_reversed(number) {
                face[1..].reverse();
            }
            text += "f";
            face.iter().for_each(|[v, t, n]| write!(text, " {v}/{t}/{n}").unwrap());
            text += "\n";
        }
        text
    }
}

#[test]
fn any_share_of_the_faces_may_run_the_wrong_way() {
    let body = Body::torus(24, 16);
    let right = load("a.obj", &body.obj(|_| false));
    assert_eq!(notes(&right), [""; 0]);
    for (percent, turned) in [(1, 6), (50, 256), (100, 512)] {
        // Scattered over the body.
        let wrong = load("a.obj", &body.obj(|face| face * 7919 % 512 * 100 / 512 < percent));
        assert_eq!(corners(&wrong.scene.meshes[0]), corners(&right.scene.meshes[0]));
        assert_eq!(
            notes(&wrong),
            [format!("a.obj: {turned} faces turned round to face where their normals point")]
        );
    }
}

proptest! {
    #[test]
    fn whichever_faces_run_the_wrong_way(
        rings in 3..8usize, segments in 3..8usize, reversed in proptest::collection::vec(any::<bool>(), 100)
    ) {
        let body = Body::torus(rings, segments);
        let right = load("a.obj", &body.obj(|_| false));
        let wrong = load("a.obj", &body.obj(|face| reversed[face]));
        prop_assert_eq!(corners(&wrong.scene.meshes[0]), corners(&right.scene.meshes[0]));
    }
}

#[test]
fn where_most_normals_are_right_the_others_are_negated() {
    let body = Body::torus(24, 16);
    let right = load("a.obj", &body.obj(|_| false));
    // The normals of 5 faces lie opposite in the file: those of the first vertices, negated, come at its end.
    let mut bad = body.clone();
    let normals = body.vertices.lines().filter_map(|line| line.strip_prefix("vn "));
    for line in normals {
        let negative = line.split(' ').map(|x| format!("{}", 0.0 - x.parse::<f64>().unwrap()));
        writeln!(bad.vertices, "vn {}", negative.collect::<Vec<_>>().join(" ")).unwrap();
    }
    for face in [3, 77, 78, 200, 501] {
        bad.faces[face].iter_mut().for_each(|corner| corner[2] += 24 * 16);
    }
    let mended = load("a.obj", &bad.obj(|_| false));
    assert_eq!(notes(&mended), ["a.obj: the normals of 5 faces negated, which pointed behind them"]);
    assert_eq!(corners(&mended.scene.meshes[0]), corners(&right.scene.meshes[0]));
    // The same body with all faces reversed: turned as a whole, and the same 5 negated.
    let mended = load("a.obj", &bad.obj(|_| true));
    let note = "512 faces turned round to face where their normals point, the normals of 5 faces negated, which pointed \
                behind them";
    assert_eq!(notes(&mended), [format!("a.obj: {note}")]);
    assert_eq!(corners(&mended.scene.meshes[0]), corners(&right.scene.meshes[0]));
}

/// A box between two corners, wound outwards: 8 vertices, 6 normals, 6 squares, with numbers after those before. Where
/// `repeated`, each face has vertices of its own.
fn add_box(
    text: &mut String,
    [low, high]: [[f64; 3]; 2],
    before: [usize; 2],
    reversed: bool,
    repeated: bool,
) {
    let at = |k: usize| [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { high[axis] } else { low[axis] });
    let squares = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let vertices = if repeated { squares.concat() } else { (0..8).collect() };
    for [x, y, z] in vertices.into_iter().map(at) {
        writeln!(text, "v {x} {y} {z}").unwrap();
    }
    *text += "vn -1 0 0\nvn 1 0 0\nvn 0 -1 0\nvn 0 1 0\nvn 0 0 -1\nvn 0 0 1\n";
    for (i, square) in squares.into_iter().enumerate() {
        let mut corners = if repeated { [0, 1, 2, 3].map(|k| 4 * i + k) } else { square };
        if reversed {
            corners[1..].reverse();
        }
        *text += "f";
        corners.iter().for_each(|k| write!(text, " {}//{}", before[0] + k + 1, before[1] + i + 1).unwrap());
        *text += "\n";
    }
}

const UNIT: [[f64; 3]; 2] = [[0.0; 3], [1.0; 3]];

#[test]
fn components_that_touch_are_turned_apart() {
    // Two boxes that share an edge, one of them inside out, and a third one elsewhere.
    let scene = |reversed| {
        let mut text = String::new();
        add_box(&mut text, UNIT, [0, 0], false, false);
        add_box(&mut text, [[1.0, 1.0, 0.0], [3.0, 2.0, 1.0]], [8, 6], reversed, false);
        add_box(&mut text, [[5.0, 1.0, 0.0], [6.0, 2.0, 1.0]], [16, 12], reversed, true);
        load("a.obj", &text)
    };
    let (right, wrong) = (scene(false), scene(true));
    assert_eq!(notes(&wrong), ["a.obj: 12 faces turned round to face where their normals point"]);
    assert_eq!(corners(&wrong.scene.meshes[0]), corners(&right.scene.meshes[0]));
}

#[test]
fn bodies_are_judged_one_by_one() {
    // Of 40 boxes with vertices of their own the first has 2 faces with normals that point inwards, the second 4.
    let mut text = String::new();
    for k in 0..40 {
        let at = 2.0 * f64::from(k);
        add_box(
            &mut text,
            [[at, 0.0, 0.0], [at + 1.0, 1.0, 1.0]],
            [8 * k as usize, 6 * k as usize],
            false,
            false,
        );
    }
    let first: String = text
        .lines()
        .take(14)
        .map(|line| line.replace("vn 1", "vn -1").replace("vn 0 1", "vn 0 -1") + "\n")
        .collect();
    let second: String = text
        .lines()
        .skip(20)
        .take(14)
        .map(|line| match line.strip_prefix("vn ") {
            Some(n) if !n.starts_with('0') || n.starts_with("0 0") => {
                format!("vn {}\n", if n.contains('-') { n.replace('-', "") } else { n.replace('1', "-1") })
            }
            _ => line.to_string() + "\n",
        })
        .collect();
    let rest = |from: usize, count: usize| -> String {
        text.lines().skip(from).take(count).map(|line| line.to_string() + "\n").collect()
    };
    let loaded = load("a.obj", &(first + &rest(14, 6) + &second + &rest(34, 10_000)));
    let note = "6 faces turned round to face where their normals point, the normals of 4 faces negated, which pointed behind \
                them";
    assert_eq!(notes(&loaded), [format!("a.obj: {note}")]);
    // The second box is inside out as a whole, its two other faces too; all others are as they were.
    let right = load("a.obj", &text);
    let (all, plain) = (corners(&loaded.scene.meshes[0]), corners(&right.scene.meshes[0]));
    assert_eq!(all[..12], plain[..12]);
    assert_eq!(all[24..], plain[24..]);
    let outward = |t: &[Corner; 3]| {
        let area = (t[1].0 - t[0].0).cross(t[2].0 - t[0].0);
        (area.dot(t[0].2.unwrap()) > 0.0, area.dot(t[0].0 - Vec3 { x: 2.5, y: 0.5, z: 0.5 }) > 0.0)
    };
    assert!(all[12..24].iter().all(|t| outward(t) == (true, false)));
}

/// Faces run the same way all over a closed body where each edge is run both ways.
fn is_closed(mesh: &Mesh) -> bool {
    let at = |v: u32| <[f32; 3]>::from(mesh.positions[v as usize]).map(f32::to_bits);
    let mut edges: Vec<_> = mesh
        .triangles
        .iter()
        .flat_map(|t| [[0, 1], [1, 2], [2, 0]].map(|e| e.map(|k| at(t.positions[k]))))
        .filter(|[a, b]| a != b)
        .collect();
    edges.sort_unstable();
    let unique = edges.windows(2).all(|pair| pair[0] != pair[1]);
    unique && edges.iter().all(|&[a, b]| edges.binary_search(&[b, a]).is_ok())
}

/// The unit box as a file. Most of its top are 40 slivers, whose normals point down into the body.
fn box_with_slivers(reversed: bool, repeated: bool) -> String {
    let mut text = String::from("vn -1 0 0\nvn 1 0 0\nvn 0 -1 0\nvn 0 1 0\nvn 0 0 -1\nvn 0 0 1\n");
    let mut vertices: Vec<[f64; 3]> = Vec::new();
    let mut face = |mut corners: Vec<[f64; 3]>, normal: u32| {
        if reversed {
            corners[1..].reverse();
        }
        let mut line = String::from("f");
        for corner in corners {
            let known = vertices.iter().position(|v| *v == corner && !repeated);
            let number = known.unwrap_or(vertices.len());
            if known.is_none() {
                writeln!(text, "v {} {} {}", corner[0], corner[1], corner[2]).unwrap();
                vertices.push(corner);
            }
            write!(line, " {}//{normal}", number + 1).unwrap();
        }
        text += &line;
        text += "\n";
    };
    let top = |k: u32, y: f64| [if k == 41 { 1.0 } else { f64::from(k) * 1e-6 }, y, 1.0];
    for k in 0..=40 {
        let ring = vec![top(k, 0.0), top(k + 1, 0.0), top(k + 1, 1.0), top(k, 1.0)];
        face(ring, if k < 40 { 5 } else { 6 });
    }
    // Front and back have the ends of all slivers as corners.
    let front = (0..=41).rev().map(|k| top(k, 0.0));
    face([[0.0; 3], [1.0, 0.0, 0.0]].into_iter().chain(front).collect(), 3);
    let back = (0..=41).map(|k| top(k, 1.0));
    face([[1.0, 1.0, 0.0], [0.0, 1.0, 0.0]].into_iter().chain(back).collect(), 4);
    face(vec![[0.0; 3], [0.0, 0.0, 1.0], [0.0, 1.0, 1.0], [0.0, 1.0, 0.0]], 1);
    face(vec![[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0; 3], [1.0, 0.0, 1.0]], 2);
    face(vec![[0.0; 3], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0]], 5);
    text
}

#[test]
fn slivers_do_not_turn_a_closed_body_or_tear_it() {
    for (reversed, repeated) in [(false, false), (false, true), (true, false), (true, true)] {
        let loaded = load("a.obj", &box_with_slivers(reversed, repeated));
        let mesh = &loaded.scene.meshes[0];
        assert!(is_closed(mesh), "{repeated} {reversed}");
        let volume: f32 = corners(mesh).iter().map(|[a, b, c]| a.0.dot(b.0.cross(c.0)) / 6.0).sum();
        assert!((volume - 1.0).abs() < 1e-5, "{volume}");
        let turned = if reversed { "46 faces turned round to face where their normals point, " } else { "" };
        let negated = "the normals of 40 faces negated, which pointed behind them";
        assert_eq!(notes(&loaded), [format!("a.obj: {turned}{negated}")]);
        let upward = |[a, ..]: &&[Corner; 3]| a.2.unwrap().z == 1.0;
        assert_eq!(corners(mesh).iter().filter(upward).count(), 82);
    }
}

#[test]
fn lamps_shine_where_their_normals_point() {
    let mtl = "newmtl white\nKd 1 1 1\nnewmtl lamp\nKe 1 1 1\n";
    // A small lamp in a ceiling that faces down, both in one plane and over one edge: the ceiling is wound rightly.
    let shared = "mtllib m.mtl\nv 0 2 0\nv 9 2 0\nv 9 2 9\nv 0 2 9\nv -1 2 0\nv -1 2 9\nvn 0 -1 0\nusemtl white\n\
                  f 1//1 2//1 3//1 4//1\nusemtl lamp\n";
    let file = |lamp: &str| load_files(&[("a.obj", &format!("{shared}{lamp}")), ("m.mtl", mtl)]);
    let right = file("f 1//1 4//1 6//1 5//1\n");
    let wrong = file("f 1//1 5//1 6//1 4//1\n");
    assert_eq!(notes(&wrong), ["a.obj: 1 face turned round to face where their normals point"]);
    // Wound as the ceiling, but its normals point up: it shines up.
    let up = file("vn 0 1 0\nf 1//2 4//2 6//2 5//2\n");
    assert_eq!(notes(&up), notes(&wrong));
    for mode in [NormalMode::Auto, NormalMode::Flat, NormalMode::Smooth] {
        let lights = |loaded: &LoadedScene| {
            let mut scene = loaded.scene.clone();
            scene.settings.normals = mode;
            SceneData::flatten(&scene).unwrap().0.lights
        };
        assert_eq!(format!("{:?}", lights(&wrong)), format!("{:?}", lights(&right)));
        for (loaded, y) in [(&right, -1.0), (&wrong, -1.0), (&up, 1.0)] {
            let normals = lights(loaded).into_iter().map(|light| match light {
                Light::Triangle { normal, .. } => normal.y,
                _ => f32::NAN,
            });
            assert_eq!(normals.collect::<Vec<_>>(), [y; 2]);
        }
    }
}

#[test]
fn normals_of_smoothing_groups_follow_the_turned_faces() {
    let body = |order: &str| {
        let vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvn 0 0 -1\ns 1\n";
        load("a.obj", &format!("{vertices}{order}"))
    };
    // Only the floor has normals of its own; they turn the whole.
    let right = body("f 1//1 3//1 2//1\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
    let wrong = body("f 1//1 2//1 3//1\nf 1 4 2\nf 2 4 3\nf 3 4 1\n");
    assert_eq!(corners(&wrong.scene.meshes[0]), corners(&right.scene.meshes[0]));
    assert!(notes(&right).is_empty() && notes(&wrong).len() == 1);
}

#[test]
fn without_normals_nothing_changes() {
    // One face against the other.
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 0\nf 1 2 3\nf 1 4 3\nf 1//1 2//1 4//1\n";
    let loaded = load("a.obj", text);
    assert!(loaded.warnings.is_empty());
    let t = &loaded.scene.meshes[0].triangles;
    assert_eq!([t[0].positions, t[1].positions, t[2].positions], [[0, 1, 2], [0, 3, 2], [0, 1, 3]]);
}

#[test]
fn faces_of_ply_are_turned_as_they_are_written() {
    // A pyramid over a square, with uvs at the corners of faces; the normals of its vertices point outwards.
    let text = |order: [&str; 5]| {
        let header = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n\
                      property float nx\nproperty float ny\nproperty float nz\nelement face 5\n\
                      property list uchar int vertex_indices\nproperty list uchar float texcoord\nend_header\n";
        let vertices = "-1 -1 0 -1 -1 -.5\n1 -1 0 1 -1 -.5\n1 1 0 1 1 -.5\n-1 1 0 -1 1 -.5\n0 0 2 0 0 1\n";
        order.iter().fold(format!("{header}{vertices}"), |text, face| {
            let uv = face.split(' ').skip(1).map(|v| format!("0.{v} 0.5"));
            let uvs: Vec<String> = uv.collect();
            format!("{text}{face} {} {}\n", 2 * uvs.len(), uvs.join(" "))
        })
    };
    let right = load("a.ply", &text(["4 0 3 2 1", "3 0 1 4", "3 1 2 4", "3 2 3 4", "3 3 0 4"]));
    assert_eq!(notes(&right), [""; 0]);
    for (wrong, note) in [
        (["4 0 1 2 3", "3 0 4 1", "3 1 4 2", "3 2 4 3", "3 3 4 0"], "5 faces turned"),
        (["4 0 1 2 3", "3 0 1 4", "3 1 4 2", "3 2 3 4", "3 3 0 4"], "2 faces turned"),
    ] {
        let wrong = load("a.ply", &text(wrong));
        assert_eq!(corners(&wrong.scene.meshes[0]), corners(&right.scene.meshes[0]));
        assert!(notes(&wrong)[0].starts_with(&format!("a.ply: {note}")), "{:?}", notes(&wrong));
    }
}
