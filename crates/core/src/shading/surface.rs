//! A point of a surface, ready to be shaded.

use super::hit_point::HitPoint;
use crate::bsdf::turned_up;
use crate::material::{Material, NONE};
use crate::math::elementary::exp2;
use crate::math::{Vec3, fma, vec3};
use crate::ray::{Hit, PrimitiveId, Ray};
use crate::shading::{EvaluatedMaterial, MaterialTexels, MaterialValues, normal_map};
use crate::texture::Rgba;
use crate::view::{SceneView, item};

/// A point of a surface, as the ray that found it sees it.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint<M = EvaluatedMaterial> {
    /// World space.
    pub position: Vec3,
    /// Unit normal of the surface itself, on the viewer's side.
    pub geometric_normal: Vec3,
    /// Unit normal for shading, on the same side of the surface, whatever the file says: see [`turned_up`].
    pub normal: Vec3,
    /// Unit vector to the origin of the ray.
    pub to_viewer: Vec3,
    /// The ray met the front.
    pub front: bool,
    /// What it is made of, at this point.
    pub material_values: M,
    /// Number of its material.
    pub material: u32,
    /// The share of the surface that the ray sees: its opacity, or nothing of a single-sided one from behind.
    pub coverage: f32,
    /// Its primitive.
    pub id: PrimitiveId,
    /// How far off the surface new rays start.
    pub offset: f32,
}

/// What the primitive says of the point, in its own space.
struct Local {
    /// Along the surface's normal, to its front; any length.
    outward: Vec3,
    /// Along the shading normal; any length.
    smooth: Vec3,
    uvs: [[f32; 2]; 2],
    color: Rgba,
    material: u32,
    /// Of triangles: edges from the first corner to the others at some scale, and both texture coordinates of all.
    edges: [Vec3; 2],
    corner_uvs: [[[f32; 2]; 3]; 2],
}

/// Normals of a point.
pub(super) struct Normals {
    /// Unit normal of the surface's front.
    pub(super) outward: Vec3,
    pub(super) front: bool,
    /// As [`SurfacePoint::geometric_normal`].
    pub(super) geometric: Vec3,
    /// As [`SurfacePoint::normal`].
    pub(super) shading: Vec3,
}

impl Normals {
    /// From what a primitive says, in world space and of any length: its normal, and that for shading.
    #[inline(always)]
    pub(super) fn new(to_viewer: Vec3, outward: Vec3, smooth: Vec3) -> Normals {
        let outward = outward.normalize_or(to_viewer);
        let smooth = smooth.normalize_or(outward);
        let front = outward.dot(to_viewer) >= 0.0;
        let geometric = if front { outward } else { -outward };
        Normals {
            outward,
            front,
            geometric,
            shading: turned_up(if front { smooth } else { -smooth }, geometric),
        }
    }
}

impl<M: MaterialValues> SurfacePoint<M> {
    /// The point of a hit (not of a miss).
    #[inline(always)]
    pub fn new(view: &SceneView, ray: &Ray, hit: &Hit) -> SurfacePoint<M> {
        let instance = item(view.instances, hit.id.instance);
        let geometry = item(view.geometries, instance.geometry);
        let point;
        let mut local = if hit.id.primitive < geometry.triangle_count {
            let number = geometry.first_triangle + hit.id.primitive;
            point = HitPoint::on_triangle(ray, instance, item(view.triangles, number), hit);
            on_triangle(view, number, instance.material, hit)
        } else {
            let number = geometry.first_sphere + (hit.id.primitive - geometry.triangle_count);
            let outward;
            (point, outward) = HitPoint::on_sphere(ray, instance, item(view.spheres, number), hit);
            let own = *item(view.sphere_materials, number);
            let material = if instance.material == NONE { own } else { instance.material };
            Local {
                outward,
                smooth: outward,
                uvs: [[0.0; 2]; 2],
                color: Rgba::WHITE,
                material,
                edges: [Vec3::ZERO; 2],
                corner_uvs: [[[0.0; 2]; 3]; 2],
            }
        };
        let material = item(view.materials, local.material);
        let textures = view.textures();
        let texels = MaterialTexels::new(&textures, material, &local.uvs);
        if material.normal_texture != NONE {
            let Local { smooth, edges, corner_uvs, .. } = &local;
            local.smooth = normal_map(&textures, material, *smooth, edges, corner_uvs, texels.normal);
        }
        let to_world = |n: Vec3| {
            if hit.id.instance == 0 { n } else { instance.object_from_world.transposed_direction(n) }
        };
        let to_viewer = -ray.direction;
        let normals = Normals::new(to_viewer, to_world(local.outward), to_world(local.smooth));
        let Normals { outward, front, geometric, shading } = normals;
        let material_values = M::new(material, &texels, &local.color);
        SurfacePoint {
            position: point.position,
            geometric_normal: geometric,
            normal: shading,
            to_viewer,
            front,
            material_values,
            material: local.material,
            coverage: if front | !material.single_sided { material_values.opacity() } else { 0.0 },
            id: hit.id,
            offset: point.offset(outward),
        }
    }

    /// Where a ray starts that leaves to the side that `direction` points to.
    #[inline(always)]
    pub fn offset_origin(&self, direction: Vec3) -> Vec3 {
        let side = if direction.dot(self.geometric_normal) >= 0.0 { self.offset } else { -self.offset };
        self.position.plus_scaled(self.geometric_normal, side)
    }

    /// [`left_by_body`], the body behind the surface.
    #[inline(always)]
    pub fn left_by_body(&self, view: &SceneView, distance: f32) -> Vec3 {
        left_by_body(view, self.material, distance)
    }
}

/// What is left of light that went this far through a body of a material: `2^(-a d)`.
#[inline(always)]
pub fn left_by_body(view: &SceneView, material: u32, distance: f32) -> Vec3 {
    let a = item(view.materials, material).attenuation;
    if a.max_component() > 0.0 {
        vec3(exp2(-a.x * distance), exp2(-a.y * distance), exp2(-a.z * distance))
    } else {
        Vec3::ONE
    }
}

/// Texture coordinates between those of the corners.
#[inline(always)]
pub(super) fn blended([t0, t1, t2]: &[[f32; 2]; 3], u: f32, v: f32) -> [f32; 2] {
    let w = 1.0 - u - v;
    let blend = |x: f32, y: f32, z: f32| fma(z, v, fma(y, u, x * w));
    [blend(t0[0], t1[0], t2[0]), blend(t0[1], t1[1], t2[1])]
}

/// What a material is where the number-th triangle of the scene was hit, if it changes no normals.
#[inline(always)]
pub(super) fn material_of_triangle<M: MaterialValues>(
    view: &SceneView,
    number: u32,
    material: &Material,
    hit: &Hit,
) -> M {
    let local = on_triangle(view, number, NONE, hit);
    M::new(material, &MaterialTexels::new(&view.textures(), material, &local.uvs), &local.color)
}

/// What a material is on spheres, if it changes no normals.
#[inline(always)]
pub(super) fn material_of_sphere<M: MaterialValues>(view: &SceneView, material: &Material) -> M {
    M::new(material, &MaterialTexels::new(&view.textures(), material, &[[0.0; 2]; 2]), &Rgba::WHITE)
}

/// A vector between those of the corners.
#[inline(always)]
pub(super) fn between_corners([n0, n1, n2]: &[Vec3; 3], u: f32, v: f32) -> Vec3 {
    let w = 1.0 - u - v;
    (*n0 * w).plus_scaled(*n1, u).plus_scaled(*n2, v)
}

/// The edges from the first corner to the others, scaled up: the product of tiny ones would vanish.
#[inline(always)]
pub(super) fn scaled_edges([a, b, c]: [Vec3; 3]) -> (Vec3, Vec3) {
    let (e1, e2) = (b - a, c - a);
    let scale = 1.0 / e1.abs().max(e2.abs()).max_component();
    (e1 * scale, e2 * scale)
}

#[inline(always)]
fn on_triangle(view: &SceneView, number: u32, material: u32, hit: &Hit) -> Local {
    let [a, b, c] = *item(view.triangles, number);
    let shading = item(view.triangle_shading, number);
    let w = 1.0 - hit.u - hit.v;
    let blend = |x: f32, y: f32, z: f32| fma(z, hit.v, fma(y, hit.u, x * w));
    let uv = blended(&shading.uvs, hit.u, hit.v);
    let (e1, e2) = scaled_edges([a, b, c]);
    let material = if material == NONE { shading.material } else { material };
    let mut local = Local {
        outward: e1.cross(e2),
        smooth: between_corners(&shading.normals, hit.u, hit.v),
        uvs: [uv; 2],
        color: Rgba::WHITE,
        material,
        edges: [e1, e2],
        corner_uvs: [shading.uvs; 2],
    };
    if shading.extra != NONE {
        let extra = item(view.triangle_extras, shading.extra);
        local.corner_uvs[1] = extra.uvs1;
        local.uvs[1] = blended(&extra.uvs1, hit.u, hit.v);
        let [c0, c1, c2] = extra.colors;
        let channel = |k: usize| blend(c0[k], c1[k], c2[k]);
        local.color = Rgba { color: vec3(channel(0), channel(1), channel(2)), alpha: channel(3) };
    }
    local
}
