//! What a scene says of the surface that was hit.

use super::Scene;
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::ray::{Hit, PrimitiveId, Ray};

impl Scene {
    /// Barycentric weights of the corners of the triangle that was hit, in the order in which they were given.
    ///
    /// A scene may turn the corners of a triangle round, because the intersection test is at its best with the longest
    /// edge opposite the first; so a hit's own `u` and `v` may belong to other corners. For a sphere or a miss the
    /// weights mean nothing.
    pub fn weights(&self, hit: &Hit) -> [f32; 3] {
        let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
        let first = self.triangle_index(hit.id).map_or(0, |k| self.first_corners[k] as usize);
        // Corner k was given at place k + first.
        [0, 1, 2].map(|given| weights[(given + 3 - first) % 3])
    }

    /// The corners of a triangle in the order in which they were given, in its mesh's own space; `None` for what is no
    /// triangle.
    pub fn corners(&self, id: PrimitiveId) -> Option<[Vec3; 3]> {
        let k = self.triangle_index(id)?;
        let first = self.first_corners[k] as usize;
        Some([0, 1, 2].map(|given| self.triangles[k][(given + 3 - first) % 3]))
    }

    /// The unit geometric normal of what was hit, in world space: of a triangle on the side from which its corners run
    /// counter-clockwise, of a sphere at the point that `ray` hit, outwards. `None` for a miss, for what is not there, and where
    /// there is none (a triangle without area).
    pub fn normal(&self, ray: &Ray, hit: &Hit) -> Option<Vec3> {
        let instance = self.instances.get(hit.id.instance as usize)?;
        let geometry = &self.geometries[instance.geometry as usize];
        let object_normal = match self.corners(hit.id) {
            Some([a, b, c]) => (b - a).cross(c - a),
            None => {
                let number = hit.id.primitive.checked_sub(geometry.triangle_count)?;
                let of_geometry =
                    geometry.first_sphere as usize..(geometry.first_sphere + geometry.sphere_count) as usize;
                let sphere = self.spheres[of_geometry].get(number as usize)?;
                instance.object_from_world.point(hit.point(ray)) - sphere.center
            }
        };
        // Normals go by the transpose of the inverse: that of the map into the object's space.
        let [x, y, z] = instance.object_from_world.columns;
        let world = vec3(x.dot(object_normal), y.dot(object_normal), z.dot(object_normal));
        // Unit length first, so that no square overflows or vanishes.
        let largest = world.abs().max_component();
        let unit = (world * (1.0 / largest)).normalize_or(Vec3::ZERO);
        (unit.is_finite() && unit != Vec3::ZERO).then_some(unit)
    }

    fn triangle_index(&self, id: PrimitiveId) -> Option<usize> {
        let instance = self.instances.get(id.instance as usize)?;
        let geometry = &self.geometries[instance.geometry as usize];
        (id.primitive < geometry.triangle_count).then(|| (geometry.first_triangle + id.primitive) as usize)
    }
}
