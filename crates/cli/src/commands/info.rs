//! `eosphor info SCENE`.

use super::structures::structures;
use crate::arguments::{AccelChoice, InfoFlags};
use crate::backend::{backend_for, limit_threads};
use crate::failure::Failure;
use crate::report::hierarchy_rows;
use crate::streams::{self, Verbosity};
use crate::text::grouped;
use eosphor::math::Vec3;
use eosphor::{HierarchyStatistics, LoadOptions, Scene, SceneData, load};
use serde::Serialize;
use std::fmt::{self, Write};
use std::sync::Arc;

#[derive(Serialize)]
struct Info {
    /// As the scene places them: a mesh with two instances counts twice.
    triangles: u64,
    spheres: usize,
    parallelograms: usize,
    meshes: usize,
    instances: usize,
    materials: usize,
    textures: usize,
    /// Emissive triangles included.
    lights: usize,
    /// `None` for an empty scene. Places are in coordinates of the file.
    bounds: Option<[Place; 2]>,
    camera: CameraInfo,
    hierarchy: HierarchyStatistics,
    files: Vec<String>,
    /// Notes of loading and of preparing the scene.
    notes: Vec<String>,
}

#[derive(Serialize)]
struct CameraInfo {
    /// Whether the scene says it; otherwise it is chosen to show what is there.
    given: bool,
    eye: Place,
    direction: Vec3,
    up: Vec3,
    fov_x_degrees: f32,
    aperture_radius: f32,
    focus_distance: f32,
}

/// A place in coordinates of the file, with the digits that it has.
#[derive(Serialize)]
#[serde(untagged)]
enum Place {
    Near(Vec3),
    Far([f64; 3]),
}

impl Place {
    fn new(scene: &Scene, p: Vec3) -> Place {
        match scene.origin == [0.0; 3] {
            true => Place::Near(p),
            false => Place::Far(scene.point_in_file(p)),
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::Near(p) => f.write_str(&point(*p)),
            Place::Far([x, y, z]) => write!(f, "({x}, {y}, {z})"),
        }
    }
}

pub(crate) fn info(flags: &InfoFlags) -> Result<(), Failure> {
    flags.check()?;
    limit_threads(&flags.device)?;
    let mut options = LoadOptions::default();
    options.texture_memory_bytes = flags.textures.memory_bytes();
    let loaded = load(&flags.scene, &options)?;
    let (data, notes) = SceneData::flatten(&loaded.scene)?;
    if flags.is_table() {
        return structures(flags, &data, flags.accel == Some(AccelChoice::Builders));
    }
    let warnings = loaded.warnings.iter().map(ToString::to_string);
    let notes = warnings.chain(notes.iter().map(ToString::to_string)).collect();
    let files = loaded.files_read.iter().map(|path| path.display().to_string()).collect();
    let scene = &loaded.scene;
    let info = Info {
        triangles: scene.instances.iter().map(|i| scene.meshes[i.mesh as usize].triangles.len() as u64).sum(),
        spheres: scene.spheres.len(),
        parallelograms: scene.parallelograms.len(),
        meshes: scene.meshes.len(),
        instances: scene.instances.len(),
        materials: scene.materials.len(),
        textures: scene.textures.len(),
        lights: data.lights.len(),
        bounds: bounds(scene).map(|corners| corners.map(|p| Place::new(scene, p))),
        camera: camera_info(scene, &data),
        hierarchy: backend_for(&flags.device, flags.one(), true, Verbosity::Normal)?
            .prepare(Arc::new(data))?
            .hierarchy_statistics(),
        files,
        notes,
    };
    if flags.json { streams::json(&info) } else { streams::result(&describe(&info)) }
}

fn camera_info(scene: &Scene, data: &SceneData) -> CameraInfo {
    let camera = &data.camera;
    CameraInfo {
        given: scene.camera.is_some(),
        eye: Place::new(scene, camera.eye),
        direction: camera.forward,
        up: camera.up,
        fov_x_degrees: 2.0 * camera.half_width.atan().to_degrees(),
        aperture_radius: camera.aperture_radius,
        focus_distance: camera.focus_distance,
    }
}

/// Corners of the box around everything that is placed.
fn bounds(scene: &Scene) -> Option<[Vec3; 2]> {
    let placed = scene.instances.iter().flat_map(|instance| {
        let world_from_object = instance.world_from_object.affine();
        let mesh = &scene.meshes[instance.mesh as usize];
        // Vertices that no triangle uses are not seen.
        let corners = mesh.triangles.iter().flat_map(|triangle| triangle.positions);
        corners.map(move |corner| world_from_object.point(mesh.positions[corner as usize]))
    });
    let spheres = scene.spheres.iter().flat_map(|sphere| {
        let radius = Vec3::splat(sphere.radius);
        [sphere.center - radius, sphere.center + radius]
    });
    let parallelograms = scene.parallelograms.iter().flat_map(|p| {
        let opposite = p.corner + p.edge_u + p.edge_v;
        [p.corner, p.corner + p.edge_u, p.corner + p.edge_v, opposite]
    });
    let points = placed.chain(spheres).chain(parallelograms);
    points.map(|p| [p, p]).reduce(|[low, high], [p, _]| [low.min(p), high.max(p)])
}

fn describe(info: &Info) -> String {
    let mut text = String::new();
    let mut row = |name: &str, value: String| {
        let _ = writeln!(text, "{name:<16} {value}");
    };
    row("triangles", grouped(info.triangles));
    row("spheres", grouped(info.spheres as u64));
    row("parallelograms", grouped(info.parallelograms as u64));
    row("meshes", grouped(info.meshes as u64));
    row("instances", grouped(info.instances as u64));
    row("materials", grouped(info.materials as u64));
    row("textures", grouped(info.textures as u64));
    row("lights", grouped(info.lights as u64));
    match &info.bounds {
        Some([low, high]) => row("bounds", format!("{low} to {high}")),
        None => row("bounds", "none: the scene is empty".into()),
    }
    let camera = &info.camera;
    let given = if camera.given { "" } else { " (framed; the scene has none)" };
    let (eye, direction) = (&camera.eye, point(camera.direction));
    row("camera", format!("{eye} looking {direction}, {:.2} degrees wide{given}", camera.fov_x_degrees));
    if camera.aperture_radius > 0.0 {
        let (radius, distance) = (camera.aperture_radius, camera.focus_distance);
        row("lens", format!("radius {radius}, sharp at {distance}"));
    }
    for (name, value) in hierarchy_rows(&info.hierarchy) {
        row(name, value);
    }
    for note in &info.notes {
        row("note", note.clone());
    }
    text
}

fn point(p: Vec3) -> String {
    format!("({}, {}, {})", p.x, p.y, p.z)
}
