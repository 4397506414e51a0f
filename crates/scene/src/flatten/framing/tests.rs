use super::*;
use crate::model::{Animation, Interpolation, Move, MoveKey};
use crate::{FrameStates, LoadOptions, Note, Scene, SceneData, ShapedArrays, Sphere, load, load_from_memory};
use eosphor_core::math::{Vec3, vec3};
use std::fmt::Write;
use std::sync::Arc;

/// An OBJ in the making.
#[derive(Default)]
struct Model {
    text: String,
}

impl Model {
    fn face(mut self, corners: &[[f64; 3]]) -> Model {
        for [x, y, z] in corners {
            writeln!(self.text, "v {x} {y} {z}").unwrap();
        }
        let numbers: Vec<String> = (1..=corners.len()).rev().map(|n| format!("-{n}")).collect();
        writeln!(self.text, "f {}", numbers.join(" ")).unwrap();
        self
    }

    /// A box; its faces look outwards, or inwards. `open` leaves a side out: axis and whether the upper one.
    fn block(mut self, min: [f64; 3], max: [f64; 3], inwards: bool, open: Option<(usize, bool)>) -> Model {
        for axis in 0..3 {
            for up in [false, true] {
                let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                let corner = |a: bool, b: bool| {
                    let mut p = min;
                    for (k, is_up) in [(axis, up), (u, a), (v, b)] {
                        p[k] = if is_up { max[k] } else { min[k] };
                    }
                    p
                };
                let mut corners =
                    [corner(false, false), corner(true, false), corner(true, true), corner(false, true)];
                if up == inwards {
                    corners.reverse();
                }
                if open != Some((axis, up)) {
                    self = self.face(&corners);
                }
            }
        }
        self
    }

    fn ground(self, half: f64, y: f64) -> Model {
        self.face(&[[-half, y, -half], [-half, y, half], [half, y, half], [half, y, -half]])
    }

    fn scene(self) -> Scene {
        let files = vec![("m.obj".into(), self.text.into_bytes())];
        load_from_memory(files, "m.obj", &LoadOptions::default()).unwrap().scene
    }

    fn seen(self) -> Seen {
        Seen::of(&self.scene())
    }
}

/// What a camera shows.
struct Seen {
    view: View,
    left_out: LeftOut,
    camera: Camera,
    data: SceneData,
}

impl Seen {
    fn of(scene: &Scene) -> Seen {
        let (data, notes) = SceneData::flatten(scene).unwrap();
        let found = notes.iter().find_map(|note| match *note {
            Note::FramedCamera { camera, view, left_out, .. } => Some((camera, view, left_out)),
            _ => None,
        });
        let (camera, view, left_out) = found.unwrap();
        Seen { view, left_out, camera, data }
    }

    /// The share of the picture where a triangle is met that `counts`, and nothing before it.
    fn share(&self, counts: impl Fn(&[Vec3; 3]) -> bool) -> f64 {
        const COLUMNS: u32 = 60;
        const ROWS: u32 = 45;
        let mut count = 0;
        for n in 0..COLUMNS * ROWS {
            let at = |n: u32, count: u32| (n as f32 + 0.513) / count as f32 * 2.0 - 1.0;
            let (x, y) = (at(n % COLUMNS, COLUMNS), at(n / COLUMNS, ROWS));
            let c = &self.data.camera;
            let way = c.forward + c.right * (x * c.half_width) + c.up * (y * c.half_height);
            let hits = self.data.triangles.iter().filter_map(|t| Some((distance(t, c.eye, way)?, t)));
            let nearest = hits.min_by(|a, b| a.0.total_cmp(&b.0));
            count += u32::from(nearest.is_some_and(|(_, t)| counts(t)));
        }
        f64::from(count) / f64::from(COLUMNS * ROWS)
    }

    /// The share that is not background.
    fn filled(&self) -> f64 {
        self.share(|_| true)
    }
}

fn distance(t: &[Vec3; 3], eye: Vec3, way: Vec3) -> Option<f64> {
    use crate::double::double;
    let [a, b, c] = t.map(double);
    let (e1, e2, way) = (sub(b, a), sub(c, a), double(way));
    let p = cross(way, e2);
    let determinant = dot(e1, p);
    let s = sub(double(eye), a);
    let q = cross(s, e1);
    let (u, v, d) = (dot(s, p) / determinant, dot(way, q) / determinant, dot(e2, q) / determinant);
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && d > 0.0).then_some(d)
}

fn cube(size: f64) -> Model {
    Model::default().block([-size; 3], [size; 3], false, None)
}

#[test]
fn a_thing_on_a_huge_ground_is_framed_without_it() {
    for half in [8.0, 100.0, 1e4, 1e6] {
        let seen =
            Model::default().ground(half, 0.0).block([-1.0, 0.0, -1.0], [1.0, 2.0, 1.0], false, None).seen();
        assert_eq!((seen.left_out.sheets, seen.left_out.far), (1, false), "{half}");
        assert!(seen.camera.position.y > 0.5 && matches!(seen.view, View::Outside { .. }));
        let is_thing = |t: &[Vec3; 3]| t.iter().any(|p| p.y > 0.5) || t.iter().all(|p| p.x.abs() <= 1.0);
        let share = seen.share(is_thing);
        assert!(share > 0.2, "{half}: {share}");
    }
    // A ground with a thickness is one, too.
    let slab = Model::default().block([-50.0, -0.1, -50.0], [50.0, 0.0, 50.0], false, None);
    let seen = slab.block([-1.0, 0.0, -1.0], [1.0, 2.0, 1.0], false, None).seen();
    assert_eq!(seen.left_out.sheets, 1);
    assert!(seen.share(|t| t.iter().all(|p| p.x.abs() <= 1.0)) > 0.2);
}

#[test]
fn a_thing_before_backdrops_is_framed_from_the_other_side() {
    let thing = || Model::default().ground(40.0, 0.0).block([-1.0, 0.0, -1.0], [1.0, 2.0, 1.0], false, None);
    for (wall, axis, sign) in [(-5.0, 2, 1.0), (5.0, 2, -1.0), (-5.0, 0, 1.0), (5.0, 0, -1.0)] {
        let at = |a: f64, b: f64| if axis == 2 { [a, b, wall] } else { [wall, b, a] };
        let seen = thing().face(&[at(-40.0, 0.0), at(40.0, 0.0), at(40.0, 60.0), at(-40.0, 60.0)]).seen();
        assert_eq!(seen.left_out.sheets, 2, "{axis} {wall}");
        let place = if axis == 2 { seen.camera.position.z } else { seen.camera.position.x };
        assert!(place * sign > 0.0 || place.abs() < 5.0, "{axis} {wall}: {place}");
        let share = seen.share(|t| t.iter().all(|p| p.x.abs() <= 1.0 && p.z.abs() <= 1.0));
        assert!(share > 0.2, "{axis} {wall}: {share}");
    }
    // Hanging from a ceiling: from below.
    let hanging =
        Model::default().ground(50.0, 2.0).block([-1.0, 0.0, -1.0], [1.0, 2.0, 1.0], false, None).seen();
    assert!(hanging.camera.position.y < 2.0);
    assert!(hanging.share(|t| t.iter().all(|p| p.x.abs() <= 1.0)) > 0.2);
}

#[test]
fn closed_rooms_are_seen_from_within_and_bodies_are_not() {
    let room = |open| Model::default().block([-4.0, 0.0, -3.0], [4.0, 3.0, 3.0], true, open);
    let furnished = room(None).block([-0.7, 0.0, -0.7], [0.6, 0.8, 0.7], false, None).seen();
    assert_eq!((furnished.view, room(None).seen().view), (View::Inside, View::Inside));
    let p = furnished.camera.position;
    assert!(p.x.abs() < 4.0 && p.y > 0.0 && p.y < 3.0 && p.z.abs() < 3.0);
    assert_eq!(furnished.filled(), 1.0);
    // From far away: some of the room's length is before the camera.
    assert!(p.x.abs() > 1.0 && furnished.data.camera.forward.x * p.x < 0.0);
    for (axis, up) in [(2, true), (0, true), (0, false)] {
        let open = room(Some((axis, up))).seen();
        assert_eq!(open.view, View::OpenSide);
        let place = if axis == 2 { open.camera.position.z } else { open.camera.position.x };
        assert!(if up { place > 3.0 } else { place < -3.0 }, "{axis} {up}: {place}");
        assert!(open.filled() > 0.3);
    }
    assert!(matches!(cube(1.0).seen().view, View::Outside { .. }));
    // A house has walls of two sides.
    let house = room(None).block([-4.2, -0.2, -3.2], [4.2, 3.2, 3.2], false, None).seen();
    assert_eq!(house.view, View::Inside);
}

#[test]
fn flat_things_are_seen_from_their_front() {
    let quad = |a: [f64; 3], b: [f64; 3]| {
        let c = [0, 1, 2].map(|k| a[k] + b[k]);
        Model::default().face(&[[0.0; 3], a, c, b]).seen()
    };
    let front = quad([2.0, 0.0, 0.0], [0.0, 1.5, 0.0]);
    assert_eq!(front.view, View::Outside { side: "the front (+z)" });
    assert_eq!(front.data.camera.forward, vec3(0.0, 0.0, -1.0));
    assert!(front.filled() > 0.85);
    assert_eq!(quad([0.0, 1.5, 0.0], [2.0, 0.0, 0.0]).view, View::Outside { side: "the back (-z)" });
    assert_eq!(quad([0.0, 1.5, 0.0], [0.0, 0.0, 2.0]).view, View::Outside { side: "the right (+x)" });
    // Lying, and sloping so that the usual view is along it.
    for b in [[0.0, 0.0, 2.0], [0.0, 0.8, 2.0], [0.0, -0.8, 2.0], [0.0, 2.0, 2.0]] {
        let seen = quad(b, [2.0, 0.0, 0.0]);
        assert!(seen.filled() > 0.2, "{b:?}: {}", seen.filled());
    }
}

#[test]
fn no_picture_is_empty_whatever_the_scale() {
    for exponent in [-30, -12, -4, 0, 4, 8, 11] {
        let size = 10f64.powi(exponent);
        let seen = cube(size).seen();
        assert!(seen.filled() > 0.25, "1e{exponent}: {}", seen.filled());
    }
    // Far from 0: what single precision knows of it.
    for size in [1e-3, 1.0, 1e3] {
        let seen = Model::default().block([1e6; 3], [1e6 + size; 3], false, None).seen();
        assert!(seen.filled() > 0.25, "{size}: {}", seen.filled());
    }
    // Thin things: a needle and a sheet seen from its edge.
    for width in [1e-2, 1e-4, 1e-6] {
        let needle = Model::default().face(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, width, 0.0]]).seen();
        assert!(needle.filled() > 0.0005, "{width}");
        let wire = Model::default().block([0.0; 3], [1.0, width, width], false, None).seen();
        assert!(wire.filled() > 0.0005, "{width}");
    }
}

#[test]
fn what_is_lost_far_away_is_left_out() {
    let pair = cube(1.0).block([1e5, 0.0, 0.0], [1e5 + 0.1, 0.1, 0.1], false, None).seen();
    assert!(pair.left_out.far);
    assert!(pair.share(|t| t.iter().all(|p| p.x.abs() <= 1.0)) > 0.25);
    // But not what can be seen.
    let near = cube(1.0).block([6.0, 0.0, 0.0], [7.0, 1.0, 1.0], false, None).seen();
    assert_eq!(near.left_out, LeftOut::default());
}

#[test]
fn spheres_around_and_below_are_left_out() {
    for (center, radius) in [(vec3(0.0, -1001.0, 0.0), 1000.0), (Vec3::ZERO, 900.0)] {
        let mut scene = cube(1.0).scene();
        scene.spheres.push(Sphere { center, radius, material: 0 });
        let seen = Seen::of(&scene);
        assert_eq!(seen.left_out.skies, 1);
        assert!(seen.filled() > 0.25);
        let height = (seen.camera.position - center).length();
        assert!(if center == Vec3::ZERO { height < radius } else { height > radius });
    }
}

#[test]
fn nothing_and_points_have_a_camera() {
    let point = Model::default().face(&[[3.0, 4.0, 5.0]; 3]).scene();
    let (data, _) = SceneData::flatten(&point).unwrap();
    assert!(data.camera.eye.is_finite());
    let (data, notes) = SceneData::flatten(&Scene::default()).unwrap();
    assert!(data.camera.eye.is_finite() && notes == [Note::Empty]);
}

/// How far the corners of what moves come towards the picture's edges in each frame: 1 is at an edge.
fn reach(scene: &Scene, frames: u32) -> Vec<f32> {
    let (data, _) = SceneData::flatten(scene).unwrap();
    let states = FrameStates::new(scene, &data);
    let of_frame = |frame: u32| {
        let state = states.at(frame).unwrap();
        assert_eq!(state.camera, data.camera, "{frame}");
        let arrays = state.shapes.as_ref().map(|shapes| {
            let mut arrays = ShapedArrays::new(&data);
            arrays.take(shapes, &data).unwrap();
            arrays
        });
        let view = data.view_at(Some(&state), arrays.as_ref());
        let c = view.camera;
        let edge = |p: Vec3| {
            let way = p - c.eye;
            let depth = way.dot(c.forward);
            let (x, y) = (way.dot(c.right) / c.half_width, way.dot(c.up) / c.half_height);
            if depth > 0.0 { x.abs().max(y.abs()) / depth } else { f32::INFINITY }
        };
        let corners = view.instances.iter().skip(1).flat_map(|instance| {
            let g = &view.geometries[instance.geometry as usize];
            let triangles = &view.triangles[g.first_triangle as usize..][..g.triangle_count as usize];
            triangles.iter().flatten().map(|&p| instance.world_from_object.point(p))
        });
        corners.map(edge).fold(0.0, f32::max)
    };
    (0..frames).map(of_frame).collect()
}

/// The same scene with its only instance on a way of ten seconds, in so many frames.
fn moving(mut scene: Scene, frames: u32, to: Vec3) -> Scene {
    let key = |seconds: f32, translate: Vec3| MoveKey {
        seconds,
        translate: Some(translate),
        rotate_degrees: Some(vec3(0.0, 9.0 * seconds, 0.0)),
        ..MoveKey::default()
    };
    let keys = vec![key(0.0, Vec3::ZERO), key(10.0, to)];
    let motion = Move { keys, interpolation: Interpolation::Linear, ..Move::default() };
    scene.instances[0].moves = vec![Arc::new(motion)];
    scene.animation = Some(Animation { fps: frames as f32 / 10.0, ..Animation::of_frames(frames) });
    scene
}

#[test]
fn all_frames_of_what_moves_are_in_the_picture() {
    let still = Seen::of(&cube(1.0).scene());
    for (frames, to) in [(7, vec3(6.0, 1.0, 0.0)), (240, vec3(0.0, 5.0, 3.0))] {
        let scene = moving(cube(1.0).scene(), frames, to);
        let (_, notes) = SceneData::flatten(&scene).unwrap();
        assert!(
            notes[0].to_string().ends_with(&format!("; all {frames} frames are in view")),
            "{}",
            notes[0]
        );
        let reach = reach(&scene, frames);
        let most = reach.iter().copied().fold(0.0, f32::max);
        assert!((0.9..=0.95).contains(&most), "{reach:?}");
        // By the first frame alone some would be outside.
        let mut first_alone = scene.clone();
        first_alone.camera = Some(still.camera);
        assert!(self::reach(&first_alone, frames).iter().any(|&reach| reach > 1.0));
    }
    // One that flies away is seen where it starts.
    let far = Seen::of(&moving(cube(1.0).scene(), 50, vec3(4000.0, 0.0, 0.0)));
    assert_eq!(far.camera, still.camera);
    // An animation in which nothing moves changes nothing, nor does one of a single frame.
    let mut scene = cube(1.0).scene();
    scene.animation = Some(Animation::of_frames(9));
    assert_eq!(Seen::of(&scene).camera, still.camera);
    assert_eq!(Seen::of(&moving(scene, 1, vec3(6.0, 1.0, 0.0))).camera, still.camera);
}

/// A body of too many triangles counts as its box, which holds it.
#[test]
fn large_bodies_that_move_are_in_the_picture_too() {
    let mut model = Model::default();
    for n in 0..1200 {
        let x = f64::from(n % 40) / 40.0;
        let y = f64::from(n / 40) / 30.0;
        model = model.block([x, y, 0.0], [x + 0.02, y + 0.02, x * y], false, None);
    }
    let scene = moving(model.scene(), 60, vec3(2.0, 0.5, 0.0));
    let most = reach(&scene, 60).into_iter().fold(0.0, f32::max);
    assert!((0.8..=0.95).contains(&most), "{most}");
}

/// `scenes/reed.glb` bends and swells: a skin and morph targets.
#[test]
fn moving_vertices_are_in_the_picture() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/reed.glb");
    let mut scene = load(path, &LoadOptions::default()).unwrap().scene;
    scene.camera = None;
    assert!(scene.has_moving_vertices());
    let frames = scene.animation.as_ref().unwrap().frames;
    let most = reach(&scene, frames).into_iter().fold(0.0, f32::max);
    assert!((0.9..=0.95).contains(&most), "{most}");
    // A still of another frame has the same camera, and what the frame has.
    let (first, _) = SceneData::flatten(&scene).unwrap();
    let (later, _) = SceneData::flatten(&Scene { frame: 7, ..scene.clone() }).unwrap();
    assert_eq!(first.camera, later.camera);
    let mut arrays = ShapedArrays::new(&first);
    arrays.take(&FrameStates::new(&scene, &first).at(7).unwrap().shapes.unwrap(), &first).unwrap();
    assert!(first.triangles != later.triangles && arrays.view(&first).triangles == later.triangles);
    // A turntable keeps it about the middle of all frames.
    scene.turntable(8).unwrap();
    assert_ne!(scene.camera.unwrap().look_at, None);
}
