//! Primitives, geometries and instances.

use super::framing::Surfaces;
use super::places::{self, Maps};
use super::{normals, view};
use crate::error::{Problem, SceneError};
use crate::model::{
    Instance as ModelInstance, MAX_COORDINATE, Mesh, NO_INDEX, NormalMode, Parallelogram, Poses, Scene,
    Triangle,
};
use eosphor_core::geometry::{
    Bounds, Geometry, Instance, Sphere, TriangleExtra, TriangleShading, placed_normals,
};
use eosphor_core::material::NONE;
use eosphor_core::math::{Affine, Vec3};

/// Meshes of more triangles than this that are placed more than once are not baked.
const BAKE_AT_MOST: usize = 256;

/// The map that changes nothing, and its inverse.
const IDENTITY: Maps = (Affine::IDENTITY, Affine::IDENTITY);

/// What an instance is part of, and what it is made of.
#[derive(Clone, Copy)]
struct Part {
    /// Instead of the triangles' own.
    material: Option<u32>,
    /// Number of the object.
    object: u32,
}

impl Part {
    /// The world is no object; its triangles say what they are part of.
    const WORLD: Part = Part { material: None, object: 0 };

    fn of(instance: &ModelInstance, number: usize) -> Part {
        Part { material: instance.material, object: number as u32 }
    }
}

/// All primitives, and how they are placed.
#[derive(Default)]
pub(super) struct Flat {
    pub(super) triangles: Vec<[Vec3; 3]>,
    pub(super) triangle_shading: Vec<TriangleShading>,
    pub(super) triangle_extras: Vec<TriangleExtra>,
    pub(super) spheres: Vec<Sphere>,
    pub(super) sphere_materials: Vec<u32>,
    pub(super) geometries: Vec<Geometry>,
    pub(super) instances: Vec<Instance>,
    /// Number of the object that the first sphere is.
    pub(super) first_sphere_object: u32,
    /// Bounds of each geometry, not padded.
    pub(super) bounds: Vec<Bounds>,
    /// How many geometries, the last ones, are of meshes whose vertices move.
    pub(super) deforming: u32,
}

impl Flat {
    /// For framing.
    pub(super) fn surfaces(&self) -> Surfaces<'_> {
        Surfaces {
            triangles: &self.triangles,
            spheres: &self.spheres,
            geometries: &self.geometries,
            instances: &self.instances,
            bounds: &self.bounds,
        }
    }

    /// The number of the first geometry whose vertices move.
    pub(super) fn first_deforming(&self) -> usize {
        self.geometries.len() - self.deforming as usize
    }

    /// Closes a geometry that began at these numbers.
    fn close_geometry(&mut self, first_triangle: usize, first_sphere: usize) -> Result<(), SceneError> {
        let bounds = places::bounds_of(&self.triangles[first_triangle..], &self.spheres[first_sphere..]);
        // A hierarchy numbers up to two nodes a primitive in 32 bits.
        let count = self.triangles.len() as u64 + self.spheres.len() as u64;
        if count >= 1 << 31 {
            return Err(Problem::new(
                "scene",
                format!("{count} primitives are too many; the limit is 2^31 - 1"),
            )
            .into());
        }
        self.geometries.push(Geometry {
            first_triangle: first_triangle as u32,
            triangle_count: (self.triangles.len() - first_triangle) as u32,
            first_sphere: first_sphere as u32,
            sphere_count: (self.spheres.len() - first_sphere) as u32,
            extent: bounds.extent(),
            first_sphere_object: self.first_sphere_object,
        });
        self.bounds.push(bounds);
        Ok(())
    }

    fn place(&mut self, geometry: u32, (world_from_object, object_from_world): Maps, part: Part) {
        let world_bounds = self.bounds[geometry as usize].placed(&world_from_object, &object_from_world);
        let (material, object) = (part.material.unwrap_or(NONE), part.object);
        self.instances.push(Instance {
            object_from_world,
            world_from_object,
            world_bounds,
            geometry,
            material,
            object,
        });
    }

    /// Adds a mesh mapped by a transform.
    fn mesh(
        &mut self,
        scene: &Scene,
        mesh: &Mesh,
        (map, inverse): &Maps,
        part: Part,
    ) -> Result<(), SceneError> {
        let positions: Vec<Vec3> = mesh.positions.iter().map(|&p| map.point(p)).collect();
        if let Some(p) = positions.iter().find(|p| !p.is_finite() || p.abs().max_component() > MAX_COORDINATE)
        {
            let by = if mesh.deformation.is_some() { "skin or morph target" } else { "transform" };
            let message = format!("its {by} takes a vertex to ({}, {}, {}), out of range", p.x, p.y, p.z);
            return Err(Problem::new(format!("mesh \"{}\"", mesh.name), message).into());
        }
        let settings = &scene.settings;
        let corner_normals = normals::CornerNormals::new(mesh, settings.normals, settings.crease_degrees);
        let mirrored = map.determinant() < 0.0;
        let has_extras = !mesh.colors.is_empty() || !mesh.uvs1.is_empty();
        self.triangles.reserve(mesh.triangles.len());
        self.triangle_shading.reserve(mesh.triangles.len());
        for (i, t) in mesh.triangles.iter().enumerate() {
            let mut vertices = t.positions.map(|p| positions[p as usize]);
            let mut uvs = corner_uvs(mesh, t);
            let mut normals = match settings.normals {
                NormalMode::Flat => [Vec3::ZERO; 3],
                _ => corner_normals.of_triangle(i, t),
            };
            let mut extra = has_extras.then(|| corner_extra(mesh, t));
            // A mirrored triangle runs the other way round: its front would become its back.
            if mirrored {
                vertices.swap(1, 2);
                uvs.swap(1, 2);
                normals.swap(1, 2);
                if let Some(extra) = &mut extra {
                    extra.colors.swap(1, 2);
                    extra.uvs1.swap(1, 2);
                }
            }
            let flat = normals::of_triangle(&vertices).unwrap_or(normals::HARMLESS);
            let normals = placed_normals(inverse, &normals, flat);
            self.triangles.push(vertices);
            let (material, object) = (part.material.unwrap_or(t.material), part.object);
            let extra = extra.map_or(NONE, |extra| {
                self.triangle_extras.push(extra);
                self.triangle_extras.len() as u32 - 1
            });
            self.triangle_shading.push(TriangleShading { normals, uvs, material, extra, object });
        }
        Ok(())
    }

    /// Adds geometries of the meshes whose vertices move, as they are in a frame, in the order of their numbers.
    pub(super) fn deforming_meshes(&mut self, scene: &Scene, frame: u32) -> Result<(), SceneError> {
        let mut poses = Poses::at(scene.seconds(frame));
        for mesh in deforming(scene).map(|number| &scene.meshes[number as usize]) {
            let (triangle, sphere) = (self.triangles.len(), self.spheres.len());
            let posed = mesh.posed(&mut poses);
            self.mesh(scene, posed.as_ref().unwrap_or(mesh), &IDENTITY, Part::WORLD)?;
            self.close_geometry(triangle, sphere)?;
            self.deforming += 1;
        }
        Ok(())
    }

    /// Two triangles that share the diagonal.
    fn parallelogram(&mut self, p: &Parallelogram, object: u32) {
        let (a, b, d) = (p.corner, p.corner + p.edge_u, p.corner + p.edge_v);
        let c = b + p.edge_v;
        let halves = [
            ([a, b, c], [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]),
            ([a, c, d], [[0.0, 0.0], [1.0, 1.0], [0.0, 1.0]]),
        ];
        for (vertices, uvs) in halves {
            let normal = normals::of_triangle(&vertices).unwrap_or(normals::HARMLESS);
            self.triangles.push(vertices);
            let (normals, material) = ([normal; 3], p.material);
            self.triangle_shading.push(TriangleShading { normals, uvs, material, extra: NONE, object });
        }
    }
}

/// The numbers of the placed meshes whose vertices move, in order.
pub(super) fn deforming(scene: &Scene) -> impl Iterator<Item = u32> {
    let mut is_placed = vec![false; scene.meshes.len()];
    scene.instances.iter().for_each(|instance| is_placed[instance.mesh as usize] = true);
    let moves = |number: &u32| scene.meshes[*number as usize].deformation.is_some();
    (0..scene.meshes.len() as u32).filter(move |number| is_placed[*number as usize]).filter(moves)
}

/// Bakes and places everything as it is in a frame.
pub(super) fn build(scene: &Scene, frame: u32) -> Result<Flat, SceneError> {
    let mut placements = vec![0u32; scene.meshes.len()];
    for instance in &scene.instances {
        placements[instance.mesh as usize] += 1;
    }
    let mut moves = vec![false; scene.meshes.len()];
    for instance in scene.instances.iter().filter(|instance| !instance.moves.is_empty()) {
        moves[instance.mesh as usize] = true;
    }
    let own_geometry = |mesh: u32| {
        let mesh = mesh as usize;
        let deforms = scene.meshes[mesh].deformation.is_some();
        deforms || moves[mesh] || placements[mesh] > 1 && scene.meshes[mesh].triangles.len() > BAKE_AT_MOST
    };
    let mut flat = Flat::default();

    // The world: baked meshes, parallelograms, spheres.
    for (number, instance) in scene.instances.iter().enumerate() {
        if !own_geometry(instance.mesh) {
            let mesh = &scene.meshes[instance.mesh as usize];
            flat.mesh(scene, mesh, &places::maps(scene, number, frame)?, Part::of(instance, number))?;
        }
    }
    // Objects are numbered so: instances, parallelograms, spheres.
    let instances = scene.instances.len() as u32;
    for (number, p) in (instances..).zip(&scene.parallelograms) {
        flat.parallelogram(p, number);
    }
    flat.first_sphere_object = instances + scene.parallelograms.len() as u32;
    for s in &scene.spheres {
        flat.spheres.push(Sphere { center: s.center, radius: s.radius });
        flat.sphere_materials.push(s.material);
    }
    flat.close_geometry(0, 0)?;
    flat.place(0, IDENTITY, Part::WORLD);

    // Meshes with a geometry of their own; those that frames change come last.
    let mut geometry_of_mesh = vec![0u32; scene.meshes.len()];
    for (number, mesh) in scene.meshes.iter().enumerate() {
        if own_geometry(number as u32) && mesh.deformation.is_none() {
            geometry_of_mesh[number] = flat.geometries.len() as u32;
            let (triangle, sphere) = (flat.triangles.len(), flat.spheres.len());
            flat.mesh(scene, mesh, &IDENTITY, Part::WORLD)?;
            flat.close_geometry(triangle, sphere)?;
        }
    }
    for (geometry, number) in (flat.geometries.len() as u32..).zip(deforming(scene)) {
        geometry_of_mesh[number as usize] = geometry;
    }
    flat.deforming_meshes(scene, frame)?;
    for (number, instance) in scene.instances.iter().enumerate() {
        if own_geometry(instance.mesh) {
            let geometry = geometry_of_mesh[instance.mesh as usize];
            let maps = places::maps_of_geometry(scene, number, frame, &flat.bounds[geometry as usize])?;
            flat.place(geometry, maps, Part::of(instance, number));
        }
    }
    view::order_corners(&mut flat.triangles, &mut flat.triangle_shading, &mut flat.triangle_extras);
    Ok(flat)
}

fn corner_extra(mesh: &Mesh, t: &Triangle) -> TriangleExtra {
    TriangleExtra {
        colors: t.positions.map(|i| mesh.colors.get(i as usize).copied().unwrap_or([1.0; 4])),
        uvs1: t.positions.map(|i| mesh.uvs1.get(i as usize).copied().unwrap_or([0.0; 2])),
    }
}

fn corner_uvs(mesh: &Mesh, t: &Triangle) -> [[f32; 2]; 3] {
    t.uvs.map(|i| if i == NO_INDEX { [0.0; 2] } else { mesh.uvs[i as usize] })
}
