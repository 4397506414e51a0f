//! What the camera rays of a pixel find first, unlit: for denoisers, compositing and tests.

use super::camera_ray;
use crate::hierarchy::{Tracer, item};
use crate::material::NONE;
use crate::math::Vec3;
use crate::ray::PrimitiveId;
use crate::shading::SurfacePoint;
use crate::view::SceneView;

/// What the camera rays of a pixel find first. Reflections and glass are not followed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct PixelFeatures {
    /// Diffuse colour, linear, textures included: mean over all samples. A sample that hits nothing counts as black.
    pub albedo: Vec3,
    /// Shading normal in world space, on the viewer's side: mean over all samples, so shorter than 1 at edges. A sample
    /// that hits nothing counts as 0.
    pub normal: Vec3,
    /// Distance along the ray in world units: mean over the samples that hit. Infinite where none does.
    pub depth: f32,
    /// Number of the instance that the first sample hits; 0 is the world, which holds all that is baked. `u32::MAX`
    /// where it hits nothing.
    pub object: u32,
    /// Number of the material that the first sample hits; `u32::MAX` where it hits nothing.
    pub material: u32,
}

impl PixelFeatures {
    /// Of a pixel that shows nothing.
    pub const NOTHING: PixelFeatures = PixelFeatures {
        albedo: Vec3::ZERO,
        normal: Vec3::ZERO,
        depth: f32::INFINITY,
        object: NONE,
        material: NONE,
    };
}

/// Traces the camera rays of a pixel: the same ones as [`super::render_pixel`]. Sums are taken in double precision, in
/// the order of the samples, so the result is the same bits for every tracer and device.
#[inline(always)]
pub fn pixel_features<T: Tracer>(view: &SceneView, tracer: &T, x: u32, y: u32) -> PixelFeatures {
    let mut features = PixelFeatures::NOTHING;
    let (mut albedo, mut normal) = (Sum::default(), Sum::default());
    let (mut depth, mut hits) = (0.0, 0u32);
    let mut sample = 0;
    while sample < view.settings.samples {
        let path_ray = camera_ray(view, x, y, sample);
        let ray = path_ray.ray();
        let hit = tracer.closest_hit(&ray, &path_ray.filter(view.settings));
        if !hit.is_miss() {
            let point = SurfacePoint::new(view, &ray, &hit);
            albedo.add(point.diffuse);
            normal.add(point.normal);
            depth += hit.t as f64;
            hits += 1;
            if sample == 0 {
                features.object = hit.id.instance;
                features.material = material_number(view, hit.id);
            }
        }
        sample += 1;
    }
    if hits > 0 {
        features.albedo = albedo.over(view.settings.samples);
        features.normal = normal.over(view.settings.samples);
        features.depth = (depth / hits as f64) as f32;
    }
    features
}

/// Three sums in double precision.
#[derive(Default)]
struct Sum([f64; 3]);

impl Sum {
    #[inline(always)]
    fn add(&mut self, v: Vec3) {
        self.0[0] += v.x as f64;
        self.0[1] += v.y as f64;
        self.0[2] += v.z as f64;
    }

    #[inline(always)]
    fn over(&self, count: u32) -> Vec3 {
        let count = count as f64;
        Vec3 { x: (self.0[0] / count) as f32, y: (self.0[1] / count) as f32, z: (self.0[2] / count) as f32 }
    }
}

/// The number of a primitive's material.
#[inline(always)]
fn material_number(view: &SceneView, id: PrimitiveId) -> u32 {
    let geometry = item(view.geometries, item(view.instances, id.instance).geometry);
    if id.primitive < geometry.triangle_count {
        item(view.triangle_shading, geometry.first_triangle + id.primitive).material
    } else {
        *item(view.sphere_materials, geometry.first_sphere + (id.primitive - geometry.triangle_count))
    }
}
