//! glTF 2.0 and GLB. What becomes what, the limits and what is left out: README.md in this folder.
//!
//! `document` has the objects of the JSON as the file has them. Every index, size and enumeration is checked where it is
//! used, so that only what the scene needs is refused.

mod accessors;
mod animations;
mod assembly;
mod buffers;
mod cameras;
mod channels;
mod container;
mod described;
mod document;
mod extensions;
mod images;
mod instancing;
mod lights;
mod materials;
mod meshes;
mod nodes;
mod skins;
mod textures;
mod topology;
mod uri;
mod vertices;
mod weights;

#[cfg(test)]
mod tests;

use super::loader::Loader;
use super::surroundings;
use crate::error::{Place, SceneError};
use crate::model::origin::is_apart;
use crate::model::{AlphaMode, CameraMotion, Instance, Interpolation, LightMotion, Material, MaterialKind};
use crate::model::{Move, RenderSettings, Scene, Transform};
use accessors::{Accessors, Budget};
use animations::Animations;
use buffers::Buffers;
use cameras::NamedCamera;
use container::Container;
use document::Document;
use eosphor_core::develop::ToneCurve;
use eosphor_core::math::Vec3;
use eosphor_core::settings::{Integrator, ShadowMode};
use lights::PlacedLight;
use meshes::Meshes;
use nodes::{ExactNode, Nodes};
use skins::Skins;
use std::fmt;
use std::path::Path;

/// Adds the meshes and materials of a file, placed and moved as it says; its cameras and lights are left out.
pub(super) fn read_model(loader: &mut Loader, path: &Path) -> Result<Vec<Instance>, SceneError> {
    Ok(read(loader, path)?.instances)
}

/// A scene that is one file: its meshes, its lights, one of its cameras, and settings that suit it. `camera` is a name
/// or number; the first camera is taken without.
pub(super) fn read_scene(loader: &mut Loader, path: &Path, camera: Option<&str>) -> Result<(), SceneError> {
    let mut file = read(loader, path)?;
    loader.scene.instances.append(&mut file.instances);
    loader.scene.settle_origin();
    let chosen = cameras::choose(&mut loader.warnings, path, &file.cameras, camera);
    let chosen = chosen.map_err(|message| SceneError::NoSuchCamera { path: path.to_path_buf(), message })?;
    let (camera_motion, light_motions) =
        motions(&file, chosen, &loader.scene).map_err(|message| invalid(path, message))?;
    let scene = &mut loader.scene;
    scene.camera = chosen.map(|chosen| chosen.in_scene(scene));
    let lights: Vec<_> = file.lights.iter().map(|placed| placed.in_scene(scene)).collect();
    scene.lights.extend(lights);
    loader.scene.animate(camera_motion, light_motions);

    let first = file.first_material as usize;
    let used = loader.scene.materials[first..].iter().zip(&file.used_materials).filter(|(_, used)| **used);
    let used: Vec<&Material> = used.map(|(material, _)| material).collect();
    let is_lit = used.iter().any(|material| surroundings::shines(material));
    match loader.integrator {
        Integrator::Whitted => {
            if used.iter().any(|m| lets_light_through(m)) {
                loader.scene.settings.shadows = ShadowMode::Coloured;
            }
            surroundings::add(&mut loader.scene, is_lit);
        }
        Integrator::Path => {
            let has_shining_textures = used.iter().any(|material| material.emission() != Vec3::ZERO);
            loader.scene.settings = settings_of_paths(loader.scene.settings.headlight);
            if surroundings::add_for_paths(&mut loader.scene, is_lit, has_shining_textures) {
                let radiance = RenderSettings::SURROUNDINGS;
                let message = format!("only textures shine: uniform surroundings of radiance {radiance}");
                loader.warnings.add(path, None, message);
            }
        }
    }
    Ok(())
}

/// How a file is rendered that says nothing about it, where its materials are to look as the format defines them: so many samples
/// that noise is faint, and a tone curve made for these materials, as punctual lights know no white.
fn settings_of_paths(headlight: bool) -> RenderSettings {
    RenderSettings {
        integrator: Integrator::Path,
        samples: 32,
        tone_curve: ToneCurve::Neutral,
        headlight,
        ..RenderSettings::default()
    }
}

/// How the camera and the lights move.
fn motions(
    file: &Contents,
    camera: Option<&NamedCamera>,
    scene: &Scene,
) -> Result<(Option<CameraMotion>, Vec<LightMotion>), String> {
    // From the coordinates of the file, where motions end, to those of the scene.
    let offset = scene.origin.map(|x| -x);
    let last = (scene.origin != [0.0; 3])
        .then(|| Move { transform: Transform { offset, ..Transform::default() }, ..Move::default() });
    let own = |moves| {
        let mut own = animations::own(moves, &file.budget)?;
        own.extend(last.clone());
        Ok::<_, String>(own)
    };
    let camera = camera.filter(|camera| !camera.moves.is_empty());
    let camera = camera.map(|camera| own(&camera.moves)).transpose()?.map(CameraMotion::Moves);
    let moving = file.lights.iter().enumerate().filter(|(_, placed)| !placed.moves.is_empty());
    let lights = moving.map(|(i, placed)| {
        let (light, interpolation) = (i as u32, Interpolation::default());
        Ok(LightMotion { light, keys: Vec::new(), interpolation, moves: own(&placed.moves)? })
    });
    Ok((camera, lights.collect::<Result<_, String>>()?))
}

fn lets_light_through(material: &Material) -> bool {
    material.alpha != AlphaMode::Opaque
        || matches!(material.kind, MaterialKind::Pbr(pbr) if pbr.transmission > 0.0)
}

/// What a file holds beside the meshes and materials that were added to the scene.
struct Contents {
    instances: Vec<Instance>,
    cameras: Vec<NamedCamera>,
    lights: Vec<PlacedLight>,
    /// What may still be stored.
    budget: Budget,
    /// Where in the scene the file's materials begin, and which of them something has.
    first_material: u32,
    used_materials: Vec<bool>,
}

fn read(loader: &mut Loader, path: &Path) -> Result<Contents, SceneError> {
    let bytes = loader.read(path)?;
    let container = container::split(&bytes).map_err(|message| invalid(path, message))?;
    let root = parse(path, &container)?;
    contents(loader, path, &root, &container).map_err(|message| invalid(path, message))
}

fn contents(
    loader: &mut Loader,
    path: &Path,
    root: &Document,
    container: &Container<'_>,
) -> Result<Contents, String> {
    let (json, binary) = (container.json, container.binary);
    extensions::check(root)?;
    extensions::warn(&mut loader.warnings, path, root);
    let buffers = Buffers::read(loader, path, root, binary);
    let accessors = Accessors::new(root, &buffers);
    let played = channels::played(&mut loader.warnings, path, root)?;
    let mut animations = Animations::new(&accessors, played);
    let mut nodes = nodes::placed(root, None, &mut animations)?;
    // What follows joints need not be near them in its file: their places have all digits from the start.
    let mut skins = match ExactNode::all(json).filter(|_| !root.skins.is_empty()) {
        Some(exact) => Skins::new(&accessors, &nodes::placed(root, Some(&exact), &mut animations)?),
        None => Skins::new(&accessors, &nodes),
    };

    let first_material = loader.scene.materials.len() as u32;
    let (warnings, built) = (&mut loader.warnings, &mut loader.scene.meshes);
    let mut meshes = Meshes::new(&accessors, path, warnings, built, first_material);
    let movers = (&mut animations, &mut skins);
    let mut objects = Objects::place(&accessors, &nodes, &mut meshes, movers, false)?;
    // Where digits count, they are those of the file.
    if objects.are_apart(&meshes)
        && let Some(exact) = ExactNode::all(json)
    {
        nodes = nodes::placed(root, Some(&exact), &mut animations)?;
        let movers = (&mut animations, &mut skins);
        objects = Objects::place(&accessors, &nodes, &mut meshes, movers, true)?;
    }
    let Objects { instances, flat } = objects;
    let used_materials = meshes.finish();
    let warn = &mut |message: String| loader.warnings.add(path, None, message);
    if let Some(name) = flat.first() {
        let message = match flat.len() {
            1 => format!("{name} is squashed flat by a scale of 0 and hidden"),
            n => format!("{name} and {} more nodes are squashed flat by a scale of 0 and hidden", n - 1),
        };
        warn(message);
    }
    let budget = accessors.budget;
    let cameras = cameras::placed(&mut loader.warnings, path, root, &nodes, &budget)?;
    let lights = lights::placed(root, &nodes, &budget)?;
    materials::add(loader, path, root, &buffers, &used_materials);
    if instances.is_empty() {
        loader.warnings.add(path, None, "there is nothing to see: the scene of the file has no triangles");
    }
    Ok(Contents { instances, cameras, lights, budget, first_material, used_materials })
}

/// What nodes place.
#[derive(Default)]
struct Objects {
    instances: Vec<Instance>,
    /// Nodes that are squashed flat.
    flat: Vec<String>,
}

impl Objects {
    /// `exact` says that the places of the nodes have all digits of the file.
    fn place(
        accessors: &Accessors<'_>,
        nodes: &Nodes,
        meshes: &mut Meshes<'_>,
        (animations, skins): (&mut Animations<'_>, &mut Skins<'_>),
        exact: bool,
    ) -> Result<Objects, String> {
        let mut objects = Objects::default();
        for placed in &nodes.placed {
            let node = &accessors.root.nodes[placed.node];
            let Some(mesh) = node.mesh else { continue };
            let shown = meshes.show(mesh.value(), placed.node, (animations, skins))?;
            let Some(shown) = shown else { continue };
            let name = || Part::new("node", placed.node, node.name.as_deref());
            if shown.is_skinned {
                // Joints alone say where it is.
                let (mesh, material) = (shown.mesh, shown.material);
                let world_from_object = Transform { offset: shown.origin, ..Transform::default() };
                objects.instances.push(Instance { mesh, material, world_from_object, moves: Vec::new() });
                continue;
            }
            let worlds = instancing::worlds(accessors, node, &placed.world);
            for world in worlds.map_err(|problem| format!("{}: {problem}", name()))? {
                let affine = world.affine();
                // A scale of 0 is a way to hide a node.
                if affine.is_finite() && affine.inverse().is_none() {
                    objects.flat.push(name().to_string());
                    continue;
                }
                let world_from_object = match exact || shown.origin != [0.0; 3] {
                    true => Transform::exactly(&affine, world.point(shown.origin)),
                    false => Transform::from_affine(&affine),
                };
                let moves = nodes.moves(placed, &accessors.budget);
                let moves = moves.map_err(|problem| format!("{}: {problem}", name()))?;
                let (mesh, material) = (shown.mesh, shown.material);
                objects.instances.push(Instance { mesh, material, world_from_object, moves });
            }
        }
        Ok(objects)
    }

    /// Whether a mesh, or where the first one is placed, lies far from 0 for its size.
    fn are_apart(&self, meshes: &Meshes<'_>) -> bool {
        self.instances.iter().any(|i| i.world_from_object.offset != [0.0; 3])
            || self.instances.first().is_some_and(|i| is_apart(meshes.built(i.mesh), i))
    }
}

/// Reads the JSON.
fn parse(path: &Path, container: &Container<'_>) -> Result<Document, SceneError> {
    let error = match Document::from_slice(container.json) {
        Ok(root) if root.asset.version.starts_with("2.") => return Ok(root),
        Ok(root) => return Err(invalid(path, wrong_version(&root.asset.version))),
        Err(error) => error,
    };
    // Files of glTF 1 fail in places that say nothing about the reason.
    if let Some(version) = version(container.json).filter(|version| !version.starts_with("2.")) {
        return Err(invalid(path, wrong_version(&version)));
    }
    if error.is_eof() {
        return Err(invalid(path, "the file ends within its JSON; get it again".into()));
    }
    let text = error.to_string();
    let reason = text.rsplit_once(" at line ").map_or(text.as_str(), |(reason, _)| reason);
    let reason: String = reason.replace('`', "\"").chars().filter(|c| !c.is_control()).take(200).collect();
    let (line, column) = (error.line() as u32, error.column() as u32);
    if container.is_glb || line == 0 {
        return Err(invalid(path, format!("its JSON is no glTF: {reason}; export it again")));
    }
    let place = Place { path: path.to_path_buf(), line: Some(line), column: Some(column) };
    Err(SceneError::invalid(place, format!("{reason}; this is no glTF, export it again")))
}

fn wrong_version(version: &str) -> String {
    format!("glTF version {} is not read, only 2.0; export it as glTF 2.0", quoted(version))
}

/// The version of a file that may be wrong otherwise.
fn version(json: &[u8]) -> Option<String> {
    #[derive(serde::Deserialize)]
    struct Head {
        asset: Asset,
    }
    #[derive(serde::Deserialize)]
    struct Asset {
        version: String,
    }
    serde_json::from_slice::<Head>(json).ok().map(|head| head.asset.version)
}

fn invalid(path: &Path, message: String) -> SceneError {
    SceneError::invalid(Place::file(path), message)
}

/// A part of a file for messages: by its name where it has one, else by its number.
struct Part {
    kind: &'static str,
    number: usize,
    name: Option<String>,
}

impl Part {
    fn new(kind: &'static str, number: usize, name: Option<&str>) -> Part {
        Part { kind, number, name: name.filter(|name| !name.is_empty()).map(quoted) }
    }
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.name {
            Some(name) => write!(f, "{} {name}", self.kind),
            None => write!(f, "{} {}", self.kind, self.number),
        }
    }
}

/// A name of a file in quotation marks: on one line, and not too long.
fn quoted(name: &str) -> String {
    const LONGEST: usize = 80;
    let short: String = clean(name).chars().take(LONGEST).collect();
    if short.len() < name.len() { format!("\"{short}...\"") } else { format!("\"{short}\"") }
}

/// A name that does not break a line of a message.
fn clean(name: &str) -> String {
    name.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// An entry of one of the file's arrays.
fn named<'a, T>(all: &'a [T], number: usize, kind: &str) -> Result<&'a T, String> {
    all.get(number).ok_or_else(|| format!("{kind} {number} does not exist; there are {}", all.len()))
}
