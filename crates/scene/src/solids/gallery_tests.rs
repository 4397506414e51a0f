//! The built-in scene: it flattens without a word, and the camera keeps clear.

use super::gallery::{bodies, gallery};
use crate::flatten::SceneData;

#[test]
fn it_flattens_without_a_note() {
    let scene = gallery().unwrap();
    let (data, notes) = SceneData::flatten(&scene).unwrap();
    assert!(notes.is_empty(), "{notes:?}");
    let expected: usize = bodies().iter().map(|b| b.shape.triangle_count(b.lights_per_edge)).sum();
    assert_eq!(data.triangles.len(), expected + 2);
    assert!(data.lights.len() <= 100, "each is a shadow ray a point: {}", data.lights.len());
}

#[test]
fn bodies_hover_over_the_floor_and_apart() {
    let bodies = bodies();
    for (i, a) in bodies.iter().enumerate() {
        let mut scene = crate::model::Scene::default();
        a.add_to(&mut scene).unwrap();
        assert!(scene.meshes[0].positions.iter().all(|p| p.z > 0.0), "{}", a.shape);
        for b in &bodies[..i] {
            assert!((a.center - b.center).length() > 0.9 * (a.radius + b.radius));
        }
    }
}

#[test]
fn the_camera_keeps_clear_of_bodies_and_floor_and_looks_at_them() {
    let scene = gallery().unwrap();
    for frame in 0..scene.animation.as_ref().unwrap().frames {
        let camera = scene.camera_at(frame).unwrap();
        assert!(camera.position.z > 1.0);
        let forward = (camera.look_at.unwrap() - camera.position).normalize();
        for body in bodies() {
            let way = body.center - camera.position;
            assert!(way.length() > 1.5 * body.radius, "frame {frame}");
            // Its middle is within the horizontal field of view.
            let cos = (scene.camera.unwrap().fov_x_degrees.to_radians() / 2.0).cos();
            assert!(forward.dot(way.normalize()) > cos, "frame {frame}: {}", body.shape);
        }
    }
}
