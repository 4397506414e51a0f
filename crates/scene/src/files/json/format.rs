//! The keys of a JSON scene. The comments of the keys are their documentation, in the schema and in
//! scenes/REFERENCE.md.

use super::environment::EnvironmentEntry;
use super::material::{Entries, MaterialEntry};
use crate::model::{Animation, Camera, DeviceSettings, Light, Move, RenderSettings, Transform, Vector};
use crate::solids::{BodyLighting, Solid};
use eosphor_core::math::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// A scene of the Eosphor ray tracer. Lengths are in the scene's own unit, angles in degrees, colours linear; numbers
/// lie within 1e12.
#[derive(Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(rename = "Scene", extend("examples" = [{
    "eosphor": 2,
    "materials": { "red": { "matte": { "color": [0.8, 0.1, 0.1] } } },
    "spheres": [{ "center": [0, 0, 0], "radius": 1, "material": "red" }]
}]))]
pub(super) struct SceneFile {
    /// The version of the format: 2. Files of version 1 are read too; their `light-units` are `plain` unless they say so.
    #[serde(rename = "eosphor")]
    #[schemars(range(min = 1, max = 2))]
    pub(super) version: u32,
    /// The schema of this format, for editors: `"schema.json"`.
    #[serde(rename = "$schema", default)]
    #[schemars(with = "String")]
    pub(super) _schema: Option<String>,
    /// For readers.
    #[serde(rename = "description", default)]
    #[schemars(with = "String")]
    pub(super) _description: Option<String>,
    /// The scene to start from: a file of any kind that can be rendered, relative to this file or absolute, or `builtin:NAME`. Keys
    /// of `settings` and `device` given here override those of the base one by one; `camera` (which then does not move), `lights`,
    /// `environment`, `output` and `frame` replace the base's. No other keys may stand beside it. A glTF file, which alone is
    /// path-traced, has here the settings of the integrator that this file names, and those of `whitted` where it names none.
    #[serde(default)]
    #[schemars(extend("examples" = ["builtin:glass"]))]
    pub(super) base: Option<PathBuf>,
    /// Where the picture is taken from. Without a camera one is chosen that shows what is there: see Camera.
    #[serde(default)]
    pub(super) camera: Option<Camera>,
    /// Lights. Triangles that shine are lights by themselves; without any light there is a headlight at the camera, but not
    /// where this list is given and empty, or `settings` say `"headlight": false`.
    #[serde(default)]
    #[schemars(with = "Vec<Light>")]
    pub(super) lights: Option<Vec<Light>>,
    /// What surrounds everything and lights it: a picture of all directions, or a sky. Needs `"integrator": "path"`; cameras see it
    /// instead of `background`.
    #[serde(default)]
    #[schemars(with = "EnvironmentEntry")]
    pub(super) environment: Option<EnvironmentEntry>,
    /// Materials by name.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, MaterialEntry>")]
    pub(super) materials: Entries<MaterialEntry>,
    /// Meshes by file.
    #[serde(default)]
    pub(super) meshes: Vec<MeshEntry>,
    /// Meshes placed.
    #[serde(default)]
    pub(super) instances: Vec<InstanceEntry>,
    /// Spheres.
    #[serde(default)]
    pub(super) spheres: Vec<SphereEntry>,
    /// Parallelograms.
    #[serde(default)]
    pub(super) parallelograms: Vec<ParallelogramEntry>,
    /// Surfaces of four corners.
    #[serde(default)]
    pub(super) quadrilaterals: Vec<QuadrilateralEntry>,
    /// Platonic solids of mirrors with ribs and lights along their edges.
    #[serde(default)]
    pub(super) solids: Vec<SolidEntry>,
    /// How to render it. Flags of the command line win.
    #[serde(default)]
    pub(super) settings: RenderSettings,
    /// On what to render it, and through which hierarchy.
    #[serde(default)]
    #[schemars(extend("examples" = [{ "backend": "cpu", "accel": "octree", "leaf-size": 16, "tree-depth": 10 }]))]
    pub(super) device: DeviceSettings,
    /// The picture's file, where the command line names none; relative to where the program is started.
    #[serde(default)]
    #[schemars(extend("examples" = ["picture.png"]))]
    pub(super) output: Option<String>,
    /// What moves.
    #[serde(default)]
    pub(super) animation: Option<Animation>,
    /// The frame of the animation that a single picture shows; 0 where not given, the first one.
    #[serde(default)]
    #[schemars(with = "u32", range(min = 0, max = 5_999_999), extend("examples" = [0]))]
    pub(super) frame: Option<u32>,
    /// Where single precision counts coordinates from; all keys stay in the coordinates of the file. Where not given, 0,
    /// or, if the first placed vertex is farther from there than 65,536 sizes of its mesh, a point near that vertex.
    #[serde(default)]
    #[schemars(with = "Option<Vector>", extend("examples" = [[500_000, 5_000_000, 0]]))]
    pub(super) origin: Option<[f64; 3]>,
}

/// A mesh by file. It is placed once, or, where instances name it, by them alone. A file with several meshes (glTF) is
/// placed as one; its cameras and lights are left out.
#[derive(Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(rename = "Mesh", extend("examples" = [
    { "file": "chair.glb", "name": "chair", "transform": { "translate": [0, 0, -2] } }
]))]
pub(super) struct MeshEntry {
    /// OBJ, glTF or PLY, beside the scene file.
    #[schemars(extend("examples" = ["chair.obj"]))]
    pub(super) file: PathBuf,
    /// Instances name the mesh by this; the file's name without its ending where it is not given.
    #[serde(default)]
    pub(super) name: Option<String>,
    /// One of `materials`, for the whole mesh; else those of the file.
    #[serde(default)]
    #[schemars(extend("examples" = ["red"]))]
    pub(super) material: Option<String>,
    /// Applied before that of an instance.
    #[serde(default)]
    pub(super) transform: Transform,
    /// How it moves: one after the other, the first one first, after the transform and before that of an instance.
    #[serde(default)]
    pub(super) moves: Vec<Move>,
}

/// A mesh placed once more.
#[derive(Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(rename = "Instance", extend("examples" = [
    { "mesh": "chair", "material": "red", "transform": { "rotate-degrees": [0, 90, 0] } }
]))]
pub(super) struct InstanceEntry {
    /// The name of a mesh.
    #[schemars(extend("examples" = ["chair"]))]
    pub(super) mesh: String,
    /// One of `materials`, instead of the mesh's.
    #[serde(default)]
    #[schemars(extend("examples" = ["red"]))]
    pub(super) material: Option<String>,
    /// Applied after that of the mesh.
    #[serde(default)]
    pub(super) transform: Transform,
    /// How it moves: one after the other, the first one first, after the transform.
    #[serde(default)]
    pub(super) moves: Vec<Move>,
}

/// A sphere.
#[derive(Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(rename = "Sphere", extend("examples" = [{ "center": [0, 1, 0], "radius": 1, "material": "red" }]))]
pub(super) struct SphereEntry {
    /// Its middle.
    #[schemars(with = "Vector")]
    pub(super) center: Vec3,
    /// Over 0.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub(super) radius: f32,
    /// One of `materials`; grey where not given.
    #[serde(default)]
    #[schemars(extend("examples" = ["red"]))]
    pub(super) material: Option<String>,
}

/// A parallelogram. Its front is where the edges run counter-clockwise. Texture coordinates are (0, 0) at the corner and
/// grow to 1 along the edges.
#[derive(Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(rename = "Parallelogram", extend("examples" = [
    { "corner": [-5, 0, 5], "edge-u": [10, 0, 0], "edge-v": [0, 0, -10], "material": "red" }
]))]
pub(super) struct ParallelogramEntry {
    /// One corner.
    #[schemars(with = "Vector")]
    pub(super) corner: Vec3,
    /// From the corner along u.
    #[schemars(with = "Vector")]
    pub(super) edge_u: Vec3,
    /// From the corner along v.
    #[schemars(with = "Vector")]
    pub(super) edge_v: Vec3,
    /// One of `materials`; grey where not given.
    #[serde(default)]
    #[schemars(extend("examples" = ["red"]))]
    pub(super) material: Option<String>,
}

/// A surface of four corners: a parallelogram where they make one, else two triangles, which meet between the first corner
/// and the third. Texture coordinates are (0, 0) at the first corner, (0, 1) at the second, (1, 1) at the third and (1, 0) at
/// the fourth.
#[derive(Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(rename = "Quadrilateral", extend("examples" = [
    { "corners": [[-5, -5, 0], [-5, 5, 0], [5, 5, 0], [4, -5, 0]], "material": "red" }
]))]
pub(super) struct QuadrilateralEntry {
    /// One after the other around it; clockwise where it is seen from the front.
    #[schemars(with = "[Vector; 4]", extend("examples" = [[[-5, -5, 0], [-5, 5, 0], [5, 5, 0], [5, -5, 0]]]))]
    pub(super) corners: [Vec3; 4],
    /// One of `materials`; grey where not given.
    #[serde(default)]
    #[schemars(extend("examples" = ["red"]))]
    pub(super) material: Option<String>,
}

/// A Platonic solid as PLATO's course has it: faces that mirror and let light through, dark ribs along the edges with lights on
/// their inner side, and corners that stay open. `settings` of the course are in scenes/solids.json.
#[derive(Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(rename = "Solid", extend("examples" = [
    { "shape": "octahedron", "center": [0, 2, 0], "radius": 1, "color": [0, 1, 0], "lights-per-edge": 5 }
]))]
pub(super) struct SolidEntry {
    /// Which solid.
    pub(super) shape: Solid,
    /// Its middle.
    #[schemars(with = "Vector")]
    pub(super) center: Vec3,
    /// Circumradius, before faces and ribs are moved outward by some 0.1 of it; over 0.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub(super) radius: f32,
    /// Red, green and blue of faces, lights and shadow, 0 to 1 each; white where not given.
    #[serde(default = "white", alias = "colour")]
    #[schemars(inner(range(min = 0, max = 1)))]
    pub(super) color: [f32; 3],
    /// Share of light that faces mirror; also the weight of their highlight.
    #[serde(default = "half")]
    #[schemars(range(min = 0, max = 1))]
    pub(super) reflection: f32,
    /// Share of light that passes a face.
    #[serde(default = "half")]
    #[schemars(range(min = 0, max = 1))]
    pub(super) transparency: f32,
    /// Lights, evenly spaced along each edge.
    #[serde(default)]
    #[schemars(range(min = 0, max = 1000))]
    pub(super) lights_per_edge: u32,
    /// What the lights along the edges do; where not given, `{"center": {}}`. These lights are besides those of `lights`, and no
    /// animation changes them.
    #[serde(default)]
    pub(super) lit_by: Option<BodyLighting>,
}

fn white() -> [f32; 3] {
    [1.0; 3]
}

fn half() -> f32 {
    0.5
}
