//! What the camera rays of a pixel find first, unlit: for denoisers, compositing and tests.

use super::coverage::{MAX_HOLES, ray_through_hole, weight_at};
use super::{PathRay, camera_ray};
use crate::hierarchy::Tracer;
use crate::material::NONE;
use crate::math::Vec3;
use crate::ray::PrimitiveId;
use crate::shading::SurfacePoint;
use crate::sums::ExactSum;
use crate::view::{SceneView, item};

/// What the camera rays of a pixel find first. Reflections and glass are not followed; holes are looked through, but where
/// a surface is there in part it counts as a whole.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct PixelFeatures {
    /// Diffuse colour, and that of metal, linear, textures included: mean over all samples. A sample that hits nothing
    /// counts as black.
    pub albedo: Vec3,
    /// Shading normal in world space, on the viewer's side: mean over all samples, so shorter than 1 at edges. A sample
    /// that hits nothing counts as 0.
    pub normal: Vec3,
    /// Distance along the ray in world units: mean over the samples that hit. Infinite where none does.
    pub depth: f32,
    /// Number of the object that the first sample hits: the scene's instances of meshes come first, then its
    /// parallelograms, then its spheres. `u32::MAX` where it hits nothing.
    pub object: u32,
    /// Number of the material that the first sample hits; `u32::MAX` where it hits nothing.
    pub material: u32,
    /// The weight with which the background is seen past all surfaces, through holes and surfaces that are there in part, but
    /// not in glass or mirrors: mean over all samples, of an exact sum. 1 where nothing is before it, 0 where something hides it.
    pub background: Vec3,
}

impl PixelFeatures {
    /// Of a pixel that shows nothing.
    pub const NOTHING: PixelFeatures = PixelFeatures {
        albedo: Vec3::ZERO,
        normal: Vec3::ZERO,
        depth: f32::INFINITY,
        object: NONE,
        material: NONE,
        background: Vec3::ONE,
    };
}

/// Traces the camera rays of a pixel: the same ones as [`super::render_pixel`]. Sums are taken in double precision, in
/// the order of the samples, so the result is the same bits for every tracer and device.
#[inline(always)]
pub fn pixel_features<T: Tracer>(view: &SceneView, tracer: &T, x: u32, y: u32) -> PixelFeatures {
    let mut features = PixelFeatures::NOTHING;
    let (mut albedo, mut normal) = (Sum::default(), Sum::default());
    let (mut depth, mut hits) = (0.0, 0u32);
    let mut background = ExactSum::default();
    let mut sample = 0;
    while sample < view.settings.samples {
        let mut path_ray = camera_ray(view, x, y, sample);
        let mut is_found = false;
        loop {
            let ray = path_ray.ray();
            let hit = tracer.closest_hit(&ray, &path_ray.filter(view.settings));
            if hit.is_miss() {
                background.add(path_ray.weight);
                break;
            }
            let point: SurfacePoint = SurfacePoint::new(view, &ray, &hit);
            let is_there = point.coverage > 0.0 || path_ray.holes >= MAX_HOLES;
            if is_there && !is_found {
                is_found = true;
                albedo.add(point.material_values.diffuse + point.material_values.metal_color);
                normal.add(point.normal);
                depth += (path_ray.travelled + hit.t) as f64;
                hits += 1;
                if sample == 0 {
                    features.object = object_number(view, hit.id);
                    features.material = point.material;
                }
            }
            // As the picture's own rays go on.
            let arrived = PathRay { weight: weight_at(view, &point, &path_ray, hit.t), ..path_ray };
            match ray_through_hole(view, &point, &arrived, hit.t) {
                Some(behind) => path_ray = behind,
                None => break,
            }
        }
        sample += 1;
    }
    features.background = background.mean(view.settings.samples);
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

/// The number of the object that a primitive is part of.
#[inline(always)]
fn object_number(view: &SceneView, id: PrimitiveId) -> u32 {
    let instance = item(view.instances, id.instance);
    let geometry = item(view.geometries, instance.geometry);
    if id.instance != 0 {
        instance.object
    } else if id.primitive < geometry.triangle_count {
        item(view.triangle_shading, geometry.first_triangle + id.primitive).object
    } else {
        geometry.first_sphere_object + (id.primitive - geometry.triangle_count)
    }
}
