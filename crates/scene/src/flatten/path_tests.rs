//! Known answers of flattening for path tracing.

use super::Note;
use super::tests::{cube, flatten, placed};
use crate::model::{AlphaMode, MaterialKind, Transform};
use eosphor_core::math::Vec3;
use eosphor_core::settings::{Integrator, ShadowMode};

/// Path tracing has surroundings in place of a headlight, and lamps that light samples can know.
#[test]
fn lights_of_path_tracing() {
    let mut scene = placed(cube(), &[Transform::default()]);
    scene.settings.integrator = Integrator::Path;
    let (data, notes) = flatten(&scene);
    assert!(notes.contains(&Note::Surroundings { radiance: 0.5 }), "{notes:?}");
    assert_eq!((data.lights.len(), data.settings.background), (0, Vec3::splat(0.5)));
    assert_eq!(data.settings.shadow_mode, ShadowMode::Opaque);
    scene.settings.ambient = 0.1;
    let (data, notes) = flatten(&scene);
    assert_eq!((data.settings.background, notes.len()), (Vec3::ZERO, 1));
    scene.materials[0].kind = MaterialKind::Emissive { radiance: Vec3::ONE };
    let (data, _) = flatten(&scene);
    assert_eq!(data.lights.len(), 12);
    assert!(data.lights.iter().all(|light| light.samples() == 1));
    // What has holes is found by rays alone.
    scene.materials[0].alpha = AlphaMode::Blend;
    let (data, _) = flatten(&scene);
    assert_eq!((data.lights.len(), data.settings.shadow_mode), (0, ShadowMode::Coloured));
}
