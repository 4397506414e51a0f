//! Stage 1: rays from the camera.

use super::{PathRay, RayKind};
use crate::camera::Projection;
use crate::math::{Vec3, fma};
use crate::ray::PrimitiveId;
use crate::sampling::{disk_point, hash_pair, point_2d};
use crate::settings::PixelSampling;
use crate::view::SceneView;

/// Keys of random numbers: which decision a number is for. Lights and children hash theirs from the path.
const PIXEL_DIMENSION: u32 = 0x1;
const LENS_DIMENSION: u32 = 0x2;

/// The key of all random numbers of a pixel.
#[inline(always)]
pub fn pixel_key(seed: u32, x: u32, y: u32) -> u32 {
    hash_pair(seed, (y << 16) | x)
}

/// The ray of one sample of a pixel; (0, 0) is the upper left one.
#[inline(always)]
pub fn camera_ray(view: &SceneView, x: u32, y: u32, sample: u32) -> PathRay {
    let (settings, camera) = (view.settings, view.camera);
    let key = pixel_key(settings.seed, x, y);
    let [dx, dy] = match settings.pixel_sampling {
        // One random sample would only be noise.
        PixelSampling::Random if settings.samples > 1 => point_2d(sample, hash_pair(key, PIXEL_DIMENSION)),
        PixelSampling::Grid => {
            // Never 0; said here so that the GPU code has no panic for the division.
            let side = settings.grid_side.max(1);
            let step = 1.0 / side as f32;
            [((sample % side) as f32 + 0.5) * step, ((sample / side) as f32 + 0.5) * step]
        }
        _ => [0.5, 0.5],
    };
    // From -1 to 1 over the picture.
    let across = fma(2.0, (x as f32 + dx) / settings.width as f32, -1.0);
    let down = fma(2.0, (y as f32 + dy) / settings.height as f32, -1.0);
    let aside = |from: Vec3| {
        from.plus_scaled(camera.right, across * camera.half_width)
            .plus_scaled(camera.up, -down * camera.half_height)
    };
    let on_plane = aside(camera.forward);
    let (origin, direction) = if camera.projection == Projection::Orthographic {
        (aside(camera.eye), camera.forward)
    } else if camera.aperture_radius > 0.0 {
        let [lens_x, lens_y] = disk_point(point_2d(sample, hash_pair(key, LENS_DIMENSION)));
        let (a, b) = (lens_x * camera.aperture_radius, lens_y * camera.aperture_radius);
        let off_axis = (camera.right * a).plus_scaled(camera.up, b);
        (camera.eye + off_axis, on_plane * camera.focus_distance - off_axis)
    } else {
        (camera.eye, on_plane)
    };
    PathRay {
        origin,
        path: 0,
        direction: direction.normalize(),
        depth: 0,
        weight: Vec3::ONE,
        kind: RayKind::Camera,
        start: PrimitiveId::NONE,
        inside: 0,
        holes: 0,
        travelled: 0.0,
        lobe_density: 0.0,
    }
}
