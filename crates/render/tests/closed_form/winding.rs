//! Files whose winding and normals disagree look like files where they agree.

use super::support::*;
use eosphor_core::math::{Vec3, vec3};
use eosphor_render::Film;
use eosphor_scene::{Light, LoadOptions, NormalMode, Scene, load_from_memory};
use std::fmt::Write;
use std::path::PathBuf;

/// Faces of the file in the making: material, and of each corner position and normal.
#[derive(Clone, Default)]
struct File(Vec<(&'static str, Vec<[V; 2]>)>);

const MTL: &str = "newmtl white\nKd 0.7 0.6 0.5\nKs 0.2 0.2 0.2\nNs 30\nnewmtl lamp\nKe 8 7 5\n\
                   newmtl glass\nillum 7\nNi 1.5\nTf 0.9 0.95 1\nKd 0 0 0\nKs 1 1 1\n";

impl File {
    fn square(&mut self, material: &'static str, [center, u, v]: [V; 3]) {
        let normal = unit(cross(u, v));
        let at = |s, t| [along(along(center, u, s), v, t), normal];
        self.0.push((material, vec![at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)]));
    }

    /// A smooth ball of squares and, at the poles, triangles.
    fn ball(&mut self, material: &'static str, center: V, n: u32) {
        let on_sphere = |i: u32, j: u32| {
            let (theta, phi) = (f64::from(i) / f64::from(n), f64::from(j % (2 * n)) / f64::from(n));
            let (st, ct) = (theta * std::f64::consts::PI).sin_cos();
            let (sp, cp) = (phi * std::f64::consts::PI).sin_cos();
            let st = if i == 0 || i == n { 0.0 } else { st };
            let normal = [st * cp, ct, -st * sp];
            [along(center, normal, 0.8), normal]
        };
        for i in 0..n {
            for j in 0..2 * n {
                let mut ring =
                    vec![on_sphere(i, j), on_sphere(i + 1, j), on_sphere(i + 1, j + 1), on_sphere(i, j + 1)];
                if i == 0 {
                    ring.remove(3);
                } else if i == n - 1 {
                    ring.remove(2);
                }
                self.0.push((material, ring));
            }
        }
    }

    /// Loaded, with what the file's notes say.
    fn load(&self) -> (Scene, Vec<String>) {
        let mut text = String::from("mtllib m.mtl\n");
        let mut known: Vec<V> = Vec::new();
        let mut normals = 0;
        for (material, ring) in &self.0 {
            let mut line = format!("usemtl {material}\nf");
            for [p, n] in ring {
                let number = known.iter().position(|k| k == p).unwrap_or(known.len());
                if number == known.len() {
                    known.push(*p);
                    writeln!(text, "v {} {} {}", p[0], p[1], p[2]).unwrap();
                }
                normals += 1;
                writeln!(text, "vn {} {} {}", n[0], n[1], n[2]).unwrap();
                write!(line, " {}//{normals}", number + 1).unwrap();
            }
            writeln!(text, "{line}").unwrap();
        }
        let files = vec![(PathBuf::from("a.obj"), text.into_bytes()), (PathBuf::from("m.mtl"), MTL.into())];
        let loaded = load_from_memory(files, "a.obj", &LoadOptions::default()).unwrap();
        let notes = loaded.warnings.iter().map(|w| w.to_string()).collect();
        (Scene { settings: scene().settings, ..loaded.scene }, notes)
    }

    /// The share of the faces, scattered over the file, that run the other way round.
    fn reversed(&self, percent: usize) -> File {
        let mut file = self.clone();
        let count = file.0.len();
        for (i, (_, ring)) in file.0.iter_mut().enumerate() {
            if (i * 7919 + 1) % count * 100 < percent * count {
                ring[1..].reverse();
            }
        }
        file
    }
}

fn picture(mut scene: Scene, normals: NormalMode) -> Film {
    scene.settings.normals = normals;
    scene.settings.size = [80, 60];
    scene.settings.depth = 8;
    scene.settings.light_samples = 2;
    scene.settings.lighting = eosphor_core::settings::LightingModel::Phong;
    scene.camera = Some(looking(vec3(0.4, 1.6, 4.2), vec3(0.0, 0.7, 0.0), 50.0));
    render(&scene)
}

fn room() -> File {
    let mut file = File::default();
    file.square("white", [[0.0; 3], [0.0, 0.0, 3.0], [3.0, 0.0, 0.0]]);
    file.square("lamp", [[0.2, 2.9, 0.1], [0.5, 0.0, 0.0], [0.0, 0.0, 0.4]]);
    file.square("lamp", [[-1.9, 1.9, 0.1], [0.2, -0.3, 0.0], [0.0, 0.0, -0.4]]);
    file.ball("white", [-0.9, 0.8, 0.0], 8);
    file.ball("glass", [0.9, 0.8, 0.3], 9);
    file
}

#[test]
fn opposed_faces_look_like_faces_that_were_wound_rightly() {
    let file = room();
    let (right, notes) = file.load();
    assert_eq!(notes, [""; 0]);
    let total = file.0.len();
    for normals in [NormalMode::Smooth, NormalMode::Flat, NormalMode::Generated] {
        let expected = picture(right.clone(), normals);
        let lit = expected.pixels.iter().filter(|p| p.max_component() > 0.01).count();
        assert!(lit > 1500, "{lit}");
        for percent in [1, 50, 100] {
            let (scene, notes) = file.reversed(percent).load();
            let turned = (total * percent).div_ceil(100);
            assert_eq!(
                notes,
                [format!("a.obj: {turned} faces turned round to face where their normals point")]
            );
            assert_eq!(picture(scene, normals).pixels, expected.pixels, "{normals:?} {percent} %");
        }
    }
}

#[test]
fn glass_with_odd_slivers_keeps_its_inside() {
    // Slivers between two rows of a ball of glass: on each edge of its equator lie two more triangles without much width,
    // whose normals point into the ball.
    let ball = || {
        let mut file = File::default();
        file.square("white", [[0.0, -0.3, 0.0], [0.0, 0.0, 3.0], [3.0, 0.0, 0.0]]);
        file.ball("glass", [0.0, 0.8, 0.0], 8);
        file
    };
    let slivers = |sign: f64| {
        let mut file = ball();
        let mut more = Vec::new();
        for (material, ring) in &mut file.0[1..] {
            // The upper side of a face below the equator moves down a little; a sliver fills the gap.
            let on_equator: Vec<usize> =
                (0..ring.len()).filter(|&k| (ring[k][0][1] - 0.8).abs() < 1e-9).collect();
            if ring.iter().all(|[p, _]| p[1] < 0.8 + 1e-9) && on_equator == [0, 3] {
                let [a, d] = [ring[0], ring[3]];
                for k in [0, 3] {
                    ring[k][0][1] -= 1e-5;
                }
                let normal = |[_, n]: [V; 2]| n.map(|x| x * sign);
                let sliver = [a, ring[0], ring[3], d].map(|corner| [corner[0], normal(corner)]);
                more.push((*material, sliver.to_vec()));
            }
        }
        assert_eq!(more.len(), 16);
        file.0.extend(more);
        file.load()
    };
    let ((right, none), (odd, notes)) = (slivers(1.0), slivers(-1.0));
    assert_eq!(none, [""; 0]);
    assert_eq!(notes, ["a.obj: the normals of 16 faces negated, which pointed behind them"]);
    for normals in [NormalMode::Smooth, NormalMode::Flat] {
        let lit = |mut scene: Scene, cull: bool| {
            scene.lights.push(Light::Point { position: vec3(2.0, 3.0, 2.0), color: Vec3::splat(9.0) });
            scene.settings.background = vec3(0.2, 0.3, 0.4);
            scene.settings.cull_back_faces = cull;
            picture(scene, normals).pixels
        };
        let expected = lit(right.clone(), false);
        assert_eq!(lit(odd.clone(), false), expected);
        // Back faces are met from inside alone.
        assert_eq!(lit(odd.clone(), true), expected);
    }
}
