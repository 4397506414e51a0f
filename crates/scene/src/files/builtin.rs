//! Scenes that are part of the program.

use super::budget::Budget;
use super::reference_systems::pg1::cornell_pg1;
use super::reference_systems::pg1_camera;
use super::source::Source;
use super::{LoadOptions, LoadedScene, load_from};
use crate::error::{Place, SceneError};
use crate::hare::hare;
use crate::hills::{COUNTS, DEFAULT_COUNT, hills};
use crate::lamps::lamps;
use crate::model::{Camera, MaterialKind, MaterialTextures, PixelSampling, RenderSettings, Scene};
use crate::solids::gallery;
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::settings::ShadowMode;
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// Name and description of a built-in scene.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Builtin {
    /// The name; the scene is loaded as `builtin:NAME`.
    pub name: &'static str,
    /// One line about it.
    pub description: &'static str,
}

/// All built-in scenes.
pub const BUILTINS: &[Builtin] = &[
    Builtin {
        name: "cornell",
        description: "the Cornell box with a mirror ball and a glass ball (CC BY 3.0, Cardenas and McGuire)",
    },
    Builtin {
        name: "cornell-pg1",
        description: "the Cornell box of PG1 with its camera and settings: a higher room, three walls of half mirrors (CC BY 3.0, as above)",
    },
    Builtin {
        name: "glass",
        description: "five balls on a table under a square lamp: mirror, glass, water, brushed metal and plastic",
    },
    Builtin { name: "hare", description: "an animal of 100,000 triangles, made from code, in daylight" },
    Builtin {
        name: "hills",
        description: "a landscape of 100,000 triangles, made from code; of about N, 2 to 50000000, as builtin:hills:N",
    },
    Builtin { name: "lamps", description: "four balls of 2,900 lamps each over plates, made from code" },
    Builtin {
        name: "solids",
        description: "a flight around three Platonic solids of mirrors, lit from within by diodes along their edges",
    },
];

/// The name of a built-in scene, where a path is one.
pub(super) fn name_of(path: &Path) -> Option<&str> {
    path.to_str()?.strip_prefix("builtin:")
}

pub(super) fn load(name: &str, options: &LoadOptions) -> Result<LoadedScene, SceneError> {
    match name {
        "cornell" => cornell(options),
        "cornell-pg1" => cornell_pg1(options),
        "glass" => glass(options),
        "hare" => made("hare", hare(), options),
        "hills" => made("hills", hills(DEFAULT_COUNT), options),
        "lamps" => made("lamps", lamps(), options),
        "solids" => made("solids", gallery()?, options),
        _ => {
            let count = name.strip_prefix("hills:").and_then(|count| count.parse().ok());
            if let Some(count) = count.filter(|count| COUNTS.contains(count)) {
                return made("hills", hills(count), options);
            }
            let known = BUILTINS.iter().map(|b| b.name).collect::<Vec<_>>().join(", ");
            Err(SceneError::UnknownBuiltin { name: name.to_string(), known })
        }
    }
}

const CORNELL_OBJ: &[u8] = include_bytes!("../../builtin/cornell/CornellBox-Sphere.obj");
const CORNELL_MTL: &[u8] = include_bytes!("../../builtin/cornell/CornellBox-Sphere.mtl");

/// The Cornell box with spheres of the McGuire Computer Graphics Archive, from PG1's camera. The files are unchanged;
/// two materials are set here (see [`dress_cornell`]).
fn cornell(options: &LoadOptions) -> Result<LoadedScene, SceneError> {
    let mut loaded = load_cornell("builtin:cornell", CORNELL_OBJ, CORNELL_MTL, options)?;
    dress_cornell(&mut loaded.scene);
    Ok(loaded)
}

pub(super) fn load_cornell(
    folder: &str,
    obj: &'static [u8],
    mtl: &'static [u8],
    options: &LoadOptions,
) -> Result<LoadedScene, SceneError> {
    let path = |name: &str| PathBuf::from(format!("{folder}/{name}"));
    let model = path("CornellBox-Sphere.obj");
    let files =
        vec![(model.clone(), Cow::Borrowed(obj)), (path("CornellBox-Sphere.mtl"), Cow::Borrowed(mtl))];
    load_from(Source::Memory(files), &model, options)
}

/// A scene of ours.
fn glass(options: &LoadOptions) -> Result<LoadedScene, SceneError> {
    let path = PathBuf::from("builtin:glass/glass.json");
    let file = include_bytes!("../../builtin/glass.json");
    load_from(Source::Memory(vec![(path.clone(), Cow::Borrowed(file))]), &path, options)
}

/// A scene that is made from code.
fn made(name: &str, mut scene: Scene, options: &LoadOptions) -> Result<LoadedScene, SceneError> {
    if options.camera.is_some() {
        let message = "it has one camera; leave the choice out";
        return Err(SceneError::invalid(Place::file(Path::new(&format!("builtin:{name}"))), message));
    }
    let mut budget = Budget::new(options.texture_memory_bytes);
    for image in &scene.images {
        budget.admits(image.texels.bytes(), || format!("builtin:{name}: {}", image.name));
    }
    budget.check()?;
    if !options.textures {
        scene.materials.iter_mut().for_each(|m| m.textures = MaterialTextures::NONE);
    }
    Ok(LoadedScene { scene, warnings: Vec::new(), files_read: Vec::new() })
}

/// Camera, settings and two materials. The file's mirror keeps its colour but loses its highlight (it already shows
/// the light itself), and its glass, nearly black (Tf 0.1) and as dense as diamond (Ni 2.5), becomes clear crown glass.
fn dress_cornell(scene: &mut Scene) {
    for material in &mut scene.materials {
        match material.name.as_str() {
            "leftSphere" => material.kind = MaterialKind::Mirror { reflectance: Vec3::splat(0.95) },
            "rightSphere" => {
                material.kind = MaterialKind::Dielectric { ior: 1.52, tint: vec3(0.93, 0.96, 0.95) };
            }
            _ => {}
        }
    }
    // PG1's camera, at half the height of this lower room.
    scene.camera = Some(Camera { position: vec3(0.0, 0.795, 4.42), ..pg1_camera() });
    scene.settings = RenderSettings {
        size: [800, 640],
        samples: 8,
        pixel_sampling: PixelSampling::Random,
        light_samples: 16,
        depth: 10,
        shadows: ShadowMode::Coloured,
        // What the walls throw at each other, which Whitted's model leaves out.
        ambient: 0.051,
        exposure: 1.9,
        ..RenderSettings::default()
    };
}
