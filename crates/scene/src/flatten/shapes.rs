//! Shapes of meshes whose vertices move: the last geometries of a scene, as they are in a frame.

use super::geometry::Flat;
use super::{SceneData, view};
use crate::error::{Problem, SceneError};
use crate::model::Scene;
use eosphor_core::geometry::{Bounds, Geometry, TriangleExtra, TriangleShading};
use eosphor_core::material::NONE;
use eosphor_core::math::Vec3;
use eosphor_core::view::SceneView;
use serde::{Deserialize, Serialize};

/// The ends of a scene's arrays as they are in a frame: those of the geometries whose vertices move
/// ([`SceneData::deforming_geometries`]).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Shapes {
    /// The geometries themselves; numbers in them are those of the whole arrays.
    pub geometries: Vec<Geometry>,
    /// Their triangles.
    pub triangles: Vec<[Vec3; 3]>,
    /// What shading needs of these.
    pub triangle_shading: Vec<TriangleShading>,
    /// What few of these have.
    pub triangle_extras: Vec<TriangleExtra>,
}

/// The arrays of a scene that shapes are the ends of, whole.
#[derive(Clone, Debug)]
pub struct ShapedArrays {
    geometries: Vec<Geometry>,
    triangles: Vec<[Vec3; 3]>,
    triangle_shading: Vec<TriangleShading>,
    triangle_extras: Vec<TriangleExtra>,
}

impl Shapes {
    /// Those of a frame, and the box around each, not padded.
    pub(super) fn of_frame(
        scene: &Scene,
        data: &SceneData,
        frame: u32,
    ) -> Result<(Shapes, Vec<Bounds>), SceneError> {
        let mut flat =
            Flat { first_sphere_object: data.geometries[0].first_sphere_object, ..Flat::default() };
        flat.deforming_meshes(scene, frame)?;
        view::order_corners(&mut flat.triangles, &mut flat.triangle_shading, &mut flat.triangle_extras);
        let first_triangle = (data.triangles.len() - flat.triangles.len()) as u32;
        let first_extra = (data.triangle_extras.len() - flat.triangle_extras.len()) as u32;
        for geometry in &mut flat.geometries {
            geometry.first_triangle += first_triangle;
            geometry.first_sphere = data.spheres.len() as u32;
        }
        for shading in flat.triangle_shading.iter_mut().filter(|shading| shading.extra != NONE) {
            shading.extra += first_extra;
        }
        let Flat { geometries, triangles, triangle_shading, triangle_extras, bounds, .. } = flat;
        Ok((Shapes { geometries, triangles, triangle_shading, triangle_extras }, bounds))
    }
}

impl SceneData {
    /// The number of the first geometry whose vertices move; as many as there are geometries where none does.
    pub fn first_deforming(&self) -> usize {
        self.geometries.len().saturating_sub(self.deforming_geometries as usize)
    }
}

impl ShapedArrays {
    /// Those of a scene as it was flattened.
    pub fn new(data: &SceneData) -> ShapedArrays {
        ShapedArrays {
            geometries: data.geometries.clone(),
            triangles: data.triangles.clone(),
            triangle_shading: data.triangle_shading.clone(),
            triangle_extras: data.triangle_extras.clone(),
        }
    }

    /// Those of a frame's own shapes.
    pub(super) fn of_frame(data: &SceneData, shapes: &Shapes) -> ShapedArrays {
        let mut arrays = ShapedArrays::new(data);
        arrays.put(shapes);
        arrays
    }

    /// Takes the shapes of another frame.
    ///
    /// # Errors
    /// Where they are not of this scene: their numbers or materials differ. Nothing is changed then.
    pub fn take(&mut self, shapes: &Shapes, data: &SceneData) -> Result<(), Problem> {
        let ranges = |g: &Geometry| (g.first_triangle, g.triangle_count, g.first_sphere, g.sphere_count);
        let links = |s: &TriangleShading| (s.material, s.extra, s.object);
        let first = data.first_deforming();
        let begin = data.geometries.get(first).map_or(data.triangles.len(), |g| g.first_triangle as usize);
        let (shading, extras) = (&data.triangle_shading[begin..], &shapes.triangle_extras);
        let linked = shading.iter().filter(|shading| shading.extra != NONE).count();
        let fits = shapes.geometries.iter().map(ranges).eq(data.geometries[first..].iter().map(ranges))
            && shapes.triangles.len() == shading.len()
            && shapes.triangle_shading.iter().map(links).eq(shading.iter().map(links))
            && extras.len() == linked;
        if !fits {
            return Err(Problem::new("shapes of a frame", "they are of another scene"));
        }
        self.put(shapes);
        Ok(())
    }

    fn put(&mut self, shapes: &Shapes) {
        fn put<T: Copy>(all: &mut [T], last: &[T]) {
            let first = all.len() - last.len();
            all[first..].copy_from_slice(last);
        }
        put(&mut self.geometries, &shapes.geometries);
        put(&mut self.triangles, &shapes.triangles);
        put(&mut self.triangle_shading, &shapes.triangle_shading);
        put(&mut self.triangle_extras, &shapes.triangle_extras);
    }

    /// Whether these are the shapes that were taken last, bit for bit.
    pub fn has(&self, shapes: &Shapes) -> bool {
        fn ends_with<T>(all: &[T], last: &[T], is_same: impl Fn(&T, &T) -> bool) -> bool {
            let first = all.len().checked_sub(last.len());
            first.is_some_and(|first| all[first..].iter().zip(last).all(|(a, b)| is_same(a, b)))
        }
        let same = |a: &[Vec3; 3], b: &[Vec3; 3]| bits(a) == bits(b);
        let same_shading = |a: &TriangleShading, b: &TriangleShading| {
            same(&a.normals, &b.normals) && a.uvs.map(float_bits) == b.uvs.map(float_bits)
        };
        let same_extra = |a: &TriangleExtra, b: &TriangleExtra| {
            a.colors.map(float_bits) == b.colors.map(float_bits)
                && a.uvs1.map(float_bits) == b.uvs1.map(float_bits)
        };
        ends_with(&self.triangles, &shapes.triangles, same)
            && ends_with(&self.triangle_shading, &shapes.triangle_shading, same_shading)
            && ends_with(&self.triangle_extras, &shapes.triangle_extras, same_extra)
    }

    /// The arrays that shading reads, borrowed; the others are the scene's.
    pub fn view<'a>(&'a self, data: &'a SceneData) -> SceneView<'a> {
        SceneView {
            geometries: &self.geometries,
            triangles: &self.triangles,
            triangle_shading: &self.triangle_shading,
            triangle_extras: &self.triangle_extras,
            ..data.view()
        }
    }
}

fn float_bits<const N: usize>(x: [f32; N]) -> [u32; N] {
    x.map(f32::to_bits)
}

fn bits(corners: &[Vec3; 3]) -> [[u32; 3]; 3] {
    corners.map(|p| float_bits(p.into()))
}
