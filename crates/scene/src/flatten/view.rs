//! SceneData, borrowed for shading.

use super::{SceneData, places};
use eosphor_core::geometry::{Bounds, Geometry, TriangleExtra, TriangleShading};
use eosphor_core::intersect::longest_edge_last;
use eosphor_core::material::NONE;
use eosphor_core::math::Vec3;
use eosphor_core::view::SceneView;

impl SceneData {
    /// The arrays that shading reads, borrowed.
    pub fn view(&self) -> SceneView<'_> {
        SceneView {
            triangles: &self.triangles,
            spheres: &self.spheres,
            geometries: &self.geometries,
            instances: &self.instances,
            triangle_shading: &self.triangle_shading,
            triangle_extras: &self.triangle_extras,
            sphere_materials: &self.sphere_materials,
            materials: &self.materials,
            textures: &self.textures,
            texture_words: &self.texture_words,
            srgb_decode: &self.srgb_decode,
            lights: &self.lights,
            light_nodes: &self.light_nodes,
            light_places: &self.light_places,
            environment: &self.environment,
            environment_table: &self.environment_table,
            camera: &self.camera,
            settings: &self.settings,
        }
    }

    /// The box around each geometry in its own space, not padded.
    pub(super) fn bounds_of_geometries(&self) -> Vec<Bounds> {
        let part = |first: u32, count: u32| first as usize..first as usize + count as usize;
        let bounds_of = |g: &Geometry| {
            let triangles = &self.triangles[part(g.first_triangle, g.triangle_count)];
            places::bounds_of(triangles, &self.spheres[part(g.first_sphere, g.sphere_count)])
        };
        self.geometries.iter().map(bounds_of).collect()
    }

    /// The box around everything in world space; empty where there is nothing.
    pub fn world_bounds(&self) -> Bounds {
        let Some(world) = self.geometries.first() else { return Bounds::EMPTY };
        let triangles = &self.triangles[world.first_triangle as usize..][..world.triangle_count as usize];
        let spheres = &self.spheres[world.first_sphere as usize..][..world.sphere_count as usize];
        let bounds = places::bounds_of(triangles, spheres);
        self.instances.iter().skip(1).fold(bounds, |b, i| b.union(&i.world_bounds))
    }
}

/// Rotates the corners of each triangle so that the intersection test is at its best
/// ([`longest_edge_last`]); which side is the front does not change.
pub(super) fn order_corners(
    triangles: &mut [[Vec3; 3]],
    shading: &mut [TriangleShading],
    extras: &mut [TriangleExtra],
) {
    for (vertices, shading) in triangles.iter_mut().zip(shading) {
        let k = longest_edge_last(vertices);
        vertices.rotate_left(k);
        shading.normals.rotate_left(k);
        shading.uvs.rotate_left(k);
        if shading.extra != NONE {
            let extra = &mut extras[shading.extra as usize];
            extra.colors.rotate_left(k);
            extra.uvs1.rotate_left(k);
        }
    }
}
