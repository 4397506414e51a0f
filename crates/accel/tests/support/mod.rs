//! Worlds to trace, as flattening a scene makes them.
#![allow(dead_code, reason = "every test binary takes what it needs")]

use eosphor_accel::{GeometryError, SceneGeometry};
use eosphor_core::geometry::{Bounds, Geometry, Instance, Sphere};
use eosphor_core::material::NONE;
use eosphor_core::math::{Affine, Vec3, vec3};

/// Owned arrays of a [`SceneGeometry`].
#[derive(Clone, Debug, Default)]
pub(crate) struct World {
    pub(crate) triangles: Vec<[Vec3; 3]>,
    pub(crate) spheres: Vec<Sphere>,
    pub(crate) geometries: Vec<Geometry>,
    pub(crate) instances: Vec<Instance>,
}

impl World {
    /// A world of these primitives, not yet with instances.
    pub(crate) fn new(triangles: Vec<[Vec3; 3]>, spheres: Vec<Sphere>) -> World {
        let mut world = World::default();
        let geometry = world.add_geometry(&triangles, &spheres);
        world.place(geometry, Affine::IDENTITY, Affine::IDENTITY);
        world
    }

    pub(crate) fn add_geometry(&mut self, triangles: &[[Vec3; 3]], spheres: &[Sphere]) -> u32 {
        let bounds = bounds_of(triangles, spheres);
        self.geometries.push(Geometry {
            first_triangle: self.triangles.len() as u32,
            triangle_count: triangles.len() as u32,
            first_sphere: self.spheres.len() as u32,
            sphere_count: spheres.len() as u32,
            extent: bounds.extent(),
            first_sphere_object: 0,
        });
        self.triangles.extend_from_slice(triangles);
        self.spheres.extend_from_slice(spheres);
        self.geometries.len() as u32 - 1
    }

    /// Places a geometry as `eosphor-scene` does; maps that cannot be inverted are left out.
    pub(crate) fn add_instance(&mut self, geometry: u32, world_from_object: Affine) {
        if let Some(object_from_world) = world_from_object.inverse() {
            self.place(geometry, world_from_object, object_from_world);
        }
    }

    fn place(&mut self, geometry: u32, world_from_object: Affine, object_from_world: Affine) {
        let object = self.bounds_of_geometry(geometry);
        let world_bounds = object.placed(&world_from_object, &object_from_world);
        self.instances.push(Instance {
            object_from_world,
            world_from_object,
            world_bounds,
            geometry,
            material: NONE,
            object: 0,
        });
    }

    fn bounds_of_geometry(&self, geometry: u32) -> Bounds {
        let g = &self.geometries[geometry as usize];
        bounds_of(
            &self.triangles[g.first_triangle as usize..][..g.triangle_count as usize],
            &self.spheres[g.first_sphere as usize..][..g.sphere_count as usize],
        )
    }

    pub(crate) fn geometry(&self) -> SceneGeometry<'_> {
        self.checked().expect("a world that holds together")
    }

    /// Whether all of it lies where rays are traced; such a world is refused otherwise.
    pub(crate) fn is_in_range(&self) -> bool {
        !matches!(self.checked(), Err(GeometryError::OutOfRange { .. }))
    }

    fn checked(&self) -> Result<SceneGeometry<'_>, GeometryError> {
        SceneGeometry::new(&self.triangles, &self.spheres, &self.geometries, &self.instances)
    }

    /// The largest absolute coordinate in world space.
    pub(crate) fn extent(&self) -> f32 {
        self.instances.iter().fold(0.0, |e, i| e.max(i.world_bounds.extent()))
    }
}

fn bounds_of(triangles: &[[Vec3; 3]], spheres: &[Sphere]) -> Bounds {
    let bounds = triangles.iter().flatten().fold(Bounds::EMPTY, |b, p| b.including(*p));
    spheres.iter().fold(bounds, |b, s| {
        let r = Vec3::splat(s.radius);
        b.including(s.center - r).including(s.center + r)
    })
}

/// Scale, rotation about all axes and translation.
pub(crate) fn affine(scale: Vec3, radians: [f64; 3], translation: Vec3) -> Affine {
    let mut columns = [vec3(scale.x, 0.0, 0.0), vec3(0.0, scale.y, 0.0), vec3(0.0, 0.0, scale.z)];
    for (axis, angle) in radians.into_iter().enumerate() {
        let (s, c) = (angle.sin() as f32, angle.cos() as f32);
        columns = columns.map(|v| match axis {
            0 => vec3(v.x, c * v.y - s * v.z, s * v.y + c * v.z),
            1 => vec3(c * v.x + s * v.z, v.y, c * v.z - s * v.x),
            _ => vec3(c * v.x - s * v.y, s * v.x + c * v.y, v.z),
        });
    }
    Affine { columns, translation }
}

/// SplitMix64 (Steele et al. 2014): numbers for tests.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// In [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// In [-1, 1) on every axis.
    pub(crate) fn in_cube(&mut self) -> Vec3 {
        let mut part = || (self.unit() * 2.0 - 1.0) as f32;
        vec3(part(), part(), part())
    }

    /// Uniform on the unit sphere.
    pub(crate) fn direction(&mut self) -> Vec3 {
        loop {
            let d = self.in_cube();
            if d.length_squared() <= 1.0 && d.length_squared() > 1e-4 {
                return d.normalize();
            }
        }
    }
}
