//! A point of a surface, ready to be shaded.

use crate::hierarchy::item;
use crate::material::{Material, NONE};
use crate::math::{Vec3, fma};
use crate::ray::{Hit, PrimitiveId, Ray};
use crate::view::SceneView;

/// Shadow and child rays start this times (scene extent + distance travelled) off the surface.
const OFFSET: f32 = 1.0 / 131_072.0;

/// A point of a surface, as the ray that found it sees it.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint<'a> {
    /// World space.
    pub position: Vec3,
    /// Unit normal of the surface itself, on the viewer's side.
    pub geometric_normal: Vec3,
    /// Unit normal for shading; on the viewer's side of the surface it was interpolated on.
    pub normal: Vec3,
    /// Unit vector to the origin of the ray.
    pub to_viewer: Vec3,
    /// The ray met the front.
    pub front: bool,
    /// What it is made of.
    pub material: &'a Material,
    /// Colour of the texture; white where there is none.
    pub texel: Vec3,
    /// Diffuse colour, texture included.
    pub diffuse: Vec3,
    /// Its primitive.
    pub id: PrimitiveId,
    /// How far off the surface new rays start.
    pub offset: f32,
}

impl<'a> SurfacePoint<'a> {
    /// The point of a hit (not of a miss).
    #[inline(always)]
    pub fn new(view: &SceneView<'a>, ray: &Ray, hit: &Hit) -> SurfacePoint<'a> {
        let instance = item(view.instances, hit.id.instance);
        let geometry = item(view.geometries, instance.geometry);
        let position = ray.origin.along(ray.direction, hit.t);
        let (outward, smooth, uv, material) = if hit.id.primitive < geometry.triangle_count {
            let number = geometry.first_triangle + hit.id.primitive;
            let [a, b, c] = *item(view.triangles, number);
            let shading = item(view.triangle_shading, number);
            let w = 1.0 - hit.u - hit.v;
            let [n0, n1, n2] = shading.normals;
            let blend = |x: f32, y: f32, z: f32| fma(z, hit.v, fma(y, hit.u, x * w));
            let [t0, t1, t2] = shading.uvs;
            let uv = [blend(t0[0], t1[0], t2[0]), blend(t0[1], t1[1], t2[1])];
            // Edges are scaled up first: the product of tiny ones would vanish.
            let (e1, e2) = (b - a, c - a);
            let scale = 1.0 / e1.abs().max(e2.abs()).max_component();
            ((e1 * scale).cross(e2 * scale), (n0 * w).along(n1, hit.u).along(n2, hit.v), uv, shading.material)
        } else {
            let number = geometry.first_sphere + (hit.id.primitive - geometry.triangle_count);
            let sphere = item(view.spheres, number);
            let local = instance.object_from_world.point(position);
            let outward = local - sphere.center;
            (outward, outward, [0.0; 2], *item(view.sphere_materials, number))
        };
        let to_world = |n: Vec3| {
            if hit.id.instance == 0 { n } else { instance.object_from_world.transposed_direction(n) }
        };
        let to_viewer = -ray.direction;
        let outward = to_world(outward).normalize_or(to_viewer);
        let smooth = to_world(smooth).normalize_or(outward);
        let front = outward.dot(to_viewer) >= 0.0;
        let material = item(view.materials, material);
        let texel = if material.diffuse_texture == NONE {
            Vec3::ONE
        } else {
            view.textures.sample(material.diffuse_texture, &[uv, uv]).color
        };
        SurfacePoint {
            position,
            geometric_normal: if front { outward } else { -outward },
            normal: if front { smooth } else { -smooth },
            to_viewer,
            front,
            material,
            texel,
            diffuse: material.diffuse * texel,
            id: hit.id,
            offset: OFFSET * (view.extent + hit.t),
        }
    }

    /// Where a ray starts that leaves to the side that `direction` points to.
    #[inline(always)]
    pub fn leave(&self, direction: Vec3) -> Vec3 {
        let side = if direction.dot(self.geometric_normal) >= 0.0 { self.offset } else { -self.offset };
        self.position.along(self.geometric_normal, side)
    }
}
