//! Stage 1: rays from the camera.

use super::{PathRay, RayKind};
use crate::camera::Projection;
use crate::math::{Vec3, Vec3Lanes, fma};
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
    CameraRayLanes::<1>::new(view, &[x], &[y], &[sample]).get(0)
}

/// Rays of several samples.
#[derive(Clone, Copy, Debug)]
pub struct CameraRayLanes<const W: usize> {
    origin: Vec3Lanes<W>,
    direction: Vec3Lanes<W>,
}

impl<const W: usize> CameraRayLanes<W> {
    /// [`camera_ray`] of these samples of pixels: loops over arrays, free of branches.
    #[inline(always)]
    pub fn new(view: &SceneView, x: &[u32; W], y: &[u32; W], sample: &[u32; W]) -> CameraRayLanes<W> {
        let (settings, camera) = (view.settings, view.camera);
        let mut place = [[0.5; W]; 2];
        let (mut origin, mut direction) = (Vec3Lanes::ZERO, Vec3Lanes::ZERO);
        let key = |lane: usize| pixel_key(settings.seed, x[lane], y[lane]);
        match settings.pixel_sampling {
            // One random sample would only be noise.
            PixelSampling::Random if settings.samples > 1 => {
                for lane in 0..W {
                    [place[0][lane], place[1][lane]] =
                        point_2d(sample[lane], hash_pair(key(lane), PIXEL_DIMENSION));
                }
            }
            PixelSampling::Grid => {
                // Never 0; said here so that the GPU code has no panic for the division.
                let side = settings.grid_side.max(1);
                let step = 1.0 / side as f32;
                for lane in 0..W {
                    place[0][lane] = ((sample[lane] % side) as f32 + 0.5) * step;
                    place[1][lane] = ((sample[lane] / side) as f32 + 0.5) * step;
                }
            }
            _ => {}
        }
        let aside = |lane: usize, from: Vec3| {
            // From -1 to 1 over the picture.
            let across = fma(2.0, (x[lane] as f32 + place[0][lane]) / settings.width as f32, -1.0);
            let down = fma(2.0, (y[lane] as f32 + place[1][lane]) / settings.height as f32, -1.0);
            from.plus_scaled(camera.right, across * camera.half_width)
                .plus_scaled(camera.up, -down * camera.half_height)
        };
        if camera.projection == Projection::Orthographic {
            for lane in 0..W {
                origin.set(lane, aside(lane, camera.eye));
                direction.set(lane, camera.forward.normalize());
            }
        } else if camera.aperture_radius > 0.0 {
            for lane in 0..W {
                let [lens_x, lens_y] =
                    disk_point(point_2d(sample[lane], hash_pair(key(lane), LENS_DIMENSION)));
                let (a, b) = (lens_x * camera.aperture_radius, lens_y * camera.aperture_radius);
                let off_axis = (camera.right * a).plus_scaled(camera.up, b);
                origin.set(lane, camera.eye + off_axis);
                let on_plane = aside(lane, camera.forward);
                direction.set(lane, (on_plane * camera.focus_distance - off_axis).normalize());
            }
        } else {
            for lane in 0..W {
                origin.set(lane, camera.eye);
                direction.set(lane, aside(lane, camera.forward).normalize());
            }
        }
        CameraRayLanes { origin, direction }
    }

    /// The ray of a lane.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> PathRay {
        PathRay {
            origin: self.origin.get(lane),
            path: 0,
            direction: self.direction.get(lane),
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
}
