//! The same by path tracing.

use super::{assert_identical, cornell, instances, moved, spheres};
use eosphor_core::math::vec3;
use eosphor_core::settings::Integrator;
use eosphor_scene::{EnvironmentMap, Lens, Scene};

/// The scene by path tracing.
fn by_paths(mut scene: Scene) -> Scene {
    scene.settings.integrator = Integrator::Path;
    scene.settings.depth = 12;
    scene.settings.roulette = 2;
    scene
}

#[test]
fn paths() {
    assert_identical("cornell by paths", &by_paths(cornell(|_| {})));
    assert_identical("spheres by paths", &by_paths(spheres()));
    assert_identical("instances by paths", &by_paths(instances()));
    assert_identical("surfaces by paths", &by_paths(crate::surfaces::scene()));
    let mut sky = by_paths(crate::surfaces::scene());
    sky.environment = Some(EnvironmentMap {
        rotation_degrees: 40.0,
        up: vec3(0.3, 1.0, -0.2),
        ..EnvironmentMap::of_image(0)
    });
    assert_identical("an environment by paths", &sky);
    let mut clay = by_paths(crate::surfaces::scene());
    for material in &mut clay.materials {
        material.diffuse_roughness = 0.8;
    }
    assert_identical("rough grounds by paths", &clay);
    let mut rooms = crate::closed_form::many_lights::rooms(3, 40);
    rooms.settings.samples = 2;
    assert_identical("many lamps by paths", &by_paths(rooms));
    let far = moved(instances(), vec3(10_000.0, -10_000.0, 20_000.0));
    assert_identical("far away by paths", &by_paths(far));
    let mut bright = by_paths(spheres());
    bright.settings.background = vec3(0.5, 0.6, 0.9);
    bright.settings.clamp_indirect = Some(2.0);
    bright.camera.as_mut().unwrap().lens = Some(Lens { aperture_radius: 0.2, focus_distance: None });
    assert_identical("a lens by paths", &bright);
}
