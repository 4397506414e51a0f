//! Whitted's ray tracing in double precision: matte surfaces, mirrors and glass under point and directional lights.
//!
//! It reads what reaches the renderer (the flattened vertices, spheres, maps and camera rays of single precision, which
//! it takes as exact), and does everything else by itself.

use crate::double::{Double, Meeting, Shape};
use crate::vector::*;
use eosphor_core::integrator::camera_ray;
use eosphor_core::material::NONE;
use eosphor_scene::{Light, MaterialKind, Scene, SceneData};

/// What a matte surface of colour 1 sends of an irradiance of 1.
const MATTE: f64 = std::f64::consts::FRAC_1_PI;

#[derive(Clone, Copy)]
enum Surface {
    Matte(V),
    Mirror(V),
    Glass { ior: f64, tint: V },
}

/// A scene, ready to be traced.
pub(crate) struct Picture<'a> {
    data: &'a SceneData,
    pub(crate) tracer: Double,
    /// Of each primitive: its surface, and whether its winding is turned round by a mirroring map.
    surfaces: Vec<(Surface, bool)>,
    lights: &'a [Light],
    /// Positions are rounded to single precision before anything starts from them: what the best arithmetic in the shading
    /// could not do without.
    pub(crate) rounds_positions: bool,
}

impl<'a> Picture<'a> {
    /// Panics where the scene has what it does not know.
    pub(crate) fn new(scene: &'a Scene, data: &'a SceneData) -> Picture<'a> {
        let surface = |material: u32| match scene.materials[material as usize].kind {
            MaterialKind::Matte { color } => Surface::Matte(double(color)),
            MaterialKind::Mirror { reflectance } => Surface::Mirror(double(reflectance)),
            MaterialKind::Dielectric { ior, tint } => Surface::Glass { ior: ior as f64, tint: double(tint) },
            kind => panic!("{kind:?} has no counterpart in double precision"),
        };
        let (mut shapes, mut surfaces) = (Vec::new(), Vec::new());
        for instance in &data.instances {
            let geometry = data.geometries[instance.geometry as usize];
            let own =
                |material: u32| surface(if instance.material == NONE { material } else { instance.material });
            let [x, y, z] = instance.world_from_object.columns.map(double);
            let origin = double(instance.world_from_object.translation);
            let place = |p: V| along(along(along(origin, x, p[0]), y, p[1]), z, p[2]);
            let turned = dot(cross(x, y), z) < 0.0;
            for k in (geometry.first_triangle..).take(geometry.triangle_count as usize) {
                shapes.push(Shape::Triangle(data.triangles[k as usize].map(|p| place(double(p)))));
                surfaces.push((own(data.triangle_shading[k as usize].material), turned));
            }
            for k in (geometry.first_sphere..).take(geometry.sphere_count as usize) {
                let sphere = data.spheres[k as usize];
                shapes.push(Shape::Sphere { center: double(sphere.center), radius: sphere.radius as f64 });
                surfaces.push((own(data.sphere_materials[k as usize]), false));
            }
        }
        let tracer = Double::new(shapes);
        Picture { data, tracer, surfaces, lights: &scene.lights, rounds_positions: false }
    }

    /// Linear colours, row after row from the top.
    pub(crate) fn pixels(&self) -> Vec<V> {
        let [width, height] = [self.data.settings.width, self.data.settings.height];
        let view = self.data.view();
        (0..width * height)
            .map(|k| {
                let ray = camera_ray(&view, k % width, k / width, 0);
                self.radiance(double(ray.origin), double(ray.direction), None, 0)
            })
            .collect()
    }

    fn radiance(&self, o: V, d: V, start: Option<usize>, depth: u32) -> V {
        match self.tracer.closest(o, d, f64::INFINITY, start) {
            Some(met) => self.leaving(&met, unit(d), depth),
            None => double(self.data.settings.background),
        }
    }

    /// What a surface sends back along a ray.
    fn leaving(&self, met: &Meeting, d: V, depth: u32) -> V {
        let (surface, turned) = self.surfaces[met.primitive];
        let point = if self.rounds_positions { double(single(met.point)) } else { met.point };
        let outward = match *self.tracer.shape(met.primitive) {
            Shape::Triangle([a, b, c]) => {
                scaled(cross(sub(b, a), sub(c, a)), if turned { -1.0 } else { 1.0 })
            }
            Shape::Sphere { center, .. } => sub(point, center),
        };
        let front = dot(outward, d) <= 0.0;
        let normal = unit(if front { outward } else { scaled(outward, -1.0) });
        let start = Some(met.primitive);
        let onward =
            |direction: V, share: V| match depth < self.data.settings.max_depth && largest(share) > 0.0 {
                true => times(share, self.radiance(point, direction, start, depth + 1)),
                false => [0.0; 3],
            };
        let cos = -dot(d, normal);
        let mirrored = along(d, normal, 2.0 * cos);
        match surface {
            Surface::Matte(color) => times(scaled(color, MATTE), self.irradiance(point, normal, start)),
            Surface::Mirror(share) => onward(mirrored, share),
            Surface::Glass { ior, tint } => {
                let eta = if front { 1.0 / ior } else { ior };
                let sin2_beyond = eta * eta * (1.0 - cos * cos);
                if sin2_beyond >= 1.0 {
                    return onward(mirrored, [1.0; 3]);
                }
                let beyond = (1.0 - sin2_beyond).sqrt();
                let s = (eta * cos - beyond) / (eta * cos + beyond);
                let p = (cos - eta * beyond) / (cos + eta * beyond);
                let reflected = 0.5 * (s * s + p * p);
                let through = unit(along(scaled(d, eta), normal, eta * cos - beyond));
                add(onward(mirrored, [reflected; 3]), onward(through, scaled(tint, 1.0 - reflected)))
            }
        }
    }

    /// Of all lights, at a surface that faces along `normal`.
    fn irradiance(&self, point: V, normal: V, start: Option<usize>) -> V {
        let mut sum = [0.0; 3];
        for light in self.lights {
            let (to_light, distance, color) = match *light {
                Light::Point { position, color } => {
                    let offset = sub(double(position), point);
                    let distance = length(offset);
                    let falloff = if self.data.settings.light_falloff { distance * distance } else { 1.0 };
                    (unit(offset), distance, scaled(double(color), 1.0 / falloff))
                }
                Light::Directional { direction, color } => {
                    (unit(scaled(double(direction), -1.0)), f64::INFINITY, double(color))
                }
                light => panic!("{light:?} has no counterpart in double precision"),
            };
            let cos = dot(normal, to_light);
            if cos > 0.0 && !self.tracer.any(point, to_light, distance, start) {
                sum = along(sum, color, cos);
            }
        }
        sum
    }
}
