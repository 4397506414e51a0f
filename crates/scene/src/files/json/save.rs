//! Writes a scene as a file with a base, and what differs from it.

use super::Document;
use super::build::Builder;
use super::file_of;
use super::reference::Inline;
use crate::error::{Problem, SceneError};
use crate::files::loader::Loader;
use crate::files::source::Source;
use crate::files::{LoadOptions, extension};
use crate::model::{
    Camera, CameraMotion, EnvironmentMap, EnvironmentSource, Light, PixelSampling, Scene, Sky,
};
use eosphor_core::math::Vec3;
use serde::Serialize;
use serde_json::{Map, Value, json};
use std::path::Path;

/// Settings that are written even where they are as the base has them: they are what people look for.
const ALWAYS: [&str; 3] = ["size", "samples", "seed"];

/// Why a scene cannot be written as a file with a base.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CannotSave {
    /// Something differs from the base that such a file cannot express.
    #[error("{what}; a scene file with a \"base\" cannot express that: change the base itself")]
    NotSaid {
        /// What differs, in words.
        what: &'static str,
    },
    /// A position so close to the origin of a scene far from 0 that no coordinates of the file round to it.
    #[error(
        "{what} is so close to the scene's origin that no coordinates in the file give exactly its position; move it a little"
    )]
    Digits {
        /// What it is.
        what: String,
    },
    /// The scene cannot be rendered.
    #[error(transparent)]
    Problem(#[from] Problem),
}

/// The text of a scene file with this `base`, which loads as `after` where the base alone loads as `before`. Camera, lights,
/// settings, environment, device, output and frame are written where they differ; size, samples and seed always.
/// `environment_file` is the picture of the environment, where that is the only picture of `after` that `before` has not, and its
/// last. Where the base is a glTF file, `before` is what it is with the integrator of `after` ([`LoadOptions::integrator`]), which
/// is written, too.
///
/// # Errors
/// Where something else differs, or `after` is no scene that can be rendered.
pub fn scene_over_base(
    base: &str,
    before: &Scene,
    after: &Scene,
    environment_file: Option<&str>,
) -> Result<String, CannotSave> {
    after.validate()?;
    let environment = new_environment(before, after, environment_file);
    check_contents(before, after, environment.is_some())?;
    let mut file = Map::new();
    file.insert("eosphor".into(), json!(2));
    file.insert("base".into(), base.into());
    if let Some(camera) = new_camera(before, after)? {
        file.insert("camera".into(), camera_keys(&camera, after)?);
    }
    // Without a headlight the base may be loaded with other surroundings and lights than it has alone.
    let is_emptied = before.lights != after.lights && after.lights.is_empty();
    let is_darkened = !after.settings.headlight && (before.settings.headlight || is_emptied);
    if before.lights != after.lights || is_darkened {
        let lights = after.lights.iter().enumerate().map(|(i, light)| light_keys(i, *light, after));
        file.insert("lights".into(), lights.collect::<Result<Vec<Value>, _>>()?.into());
    }
    // Samples alone would take the place of a grid.
    let has_grid = matches!(after.settings.pixel_sampling, PixelSampling::Grid(_));
    // A glTF file as a base has the settings of the integrator that is named.
    let is_over_gltf = matches!(extension(Path::new(base)).as_deref(), Some("gltf" | "glb"));
    let settings = changed_keys(&before.settings, &after.settings, |key| {
        ALWAYS.contains(&key)
            || is_over_gltf && key == "integrator"
            || has_grid && key == "pixel-sampling"
            || is_darkened && ["ambient", "background"].contains(&key)
    });
    file.insert("settings".into(), settings.into());
    if let Some(environment) = environment {
        file.insert("environment".into(), environment.into());
    }
    let device = changed_keys(&before.device, &after.device, |_| false);
    if !device.is_empty() {
        file.insert("device".into(), device.into());
    }
    if let Some(output) = after.output.as_ref().filter(|_| before.output != after.output) {
        file.insert("output".into(), output.as_str().into());
    }
    if after.frame != before.frame {
        file.insert("frame".into(), after.frame.into());
    }
    let text = pretty(&file);
    check_text(&text, before, after)?;
    Ok(text)
}

fn not_said<T>(what: &'static str) -> Result<T, CannotSave> {
    Err(CannotSave::NotSaid { what })
}

/// Fails where something differs that such a file cannot express.
fn check_contents(before: &Scene, after: &Scene, says_environment: bool) -> Result<(), CannotSave> {
    let is_placed_alike = before.origin == after.origin
        && before.instances == after.instances
        && before.spheres == after.spheres
        && before.parallelograms == after.parallelograms;
    let without_camera = |scene: &Scene| {
        let mut animation = scene.animation.clone();
        animation.iter_mut().for_each(|animation| animation.camera = None);
        animation
    };
    let takes_output = before.output.is_some() && after.output.is_none();
    let takes_lights = after.settings.headlight && after.lights.is_empty() && !before.lights.is_empty();
    // Its own picture is the last one.
    let own_image = before.images.len() as u32;
    let has_images = says_environment
        && after.environment.is_some_and(|map| map.source == EnvironmentSource::Image(own_image))
        && before.images == after.images[..before.images.len()];
    let differing = [
        (!is_placed_alike, "the geometry was moved or changed"),
        (before.materials != after.materials, "materials were changed"),
        (before.environment != after.environment && !says_environment, "the environment was changed"),
        (before.textures != after.textures, "textures were changed"),
        (without_camera(before) != without_camera(after), "the animation was changed"),
        (takes_output, "the name of the picture was taken away"),
        (takes_lights, "all lights were taken away, and there is a light at the camera instead"),
        (before.meshes != after.meshes, "meshes were changed"),
        (!has_images && before.images != after.images, "pictures of textures were changed"),
    ];
    differing.iter().find(|(differs, _)| *differs).map_or(Ok(()), |(_, what)| not_said(what))
}

/// The keys of an environment that is another one, as far as it can be said.
fn new_environment(before: &Scene, after: &Scene, file: Option<&str>) -> Option<Map<String, Value>> {
    let map = after.environment.filter(|_| before.environment != after.environment)?;
    let mut keys = Map::new();
    match map.source {
        EnvironmentSource::Sky(sky) => keys.insert("sky".into(), sky_keys(&sky).into()),
        EnvironmentSource::Image(image) => {
            let is_own =
                image as usize == before.images.len() && after.images.len() == before.images.len() + 1;
            keys.insert("file".into(), file.filter(|_| is_own)?.into())
        }
    };
    let default = EnvironmentMap::of_image(0);
    let [x, y, z] = <[f32; 3]>::from(map.up).map(short);
    for (key, value, differs) in [
        ("strength", short(map.strength), map.strength != default.strength),
        ("rotation-degrees", short(map.rotation_degrees), map.rotation_degrees != default.rotation_degrees),
        ("up", json!([x, y, z]), map.up != default.up),
        ("seen", map.is_seen.into(), map.is_seen != default.is_seen),
    ] {
        if differs {
            keys.insert(key.into(), value);
        }
    }
    Some(keys)
}

fn sky_keys(sky: &Sky) -> Map<String, Value> {
    let Sky { sun_elevation_degrees, sun_azimuth_degrees, turbidity, albedo, sun_strength } = *sky;
    let keys = [
        ("sun-elevation-degrees", sun_elevation_degrees),
        ("sun-azimuth-degrees", sun_azimuth_degrees),
        ("turbidity", turbidity),
        ("albedo", albedo),
        ("sun-strength", sun_strength),
    ];
    keys.map(|(key, value)| (key.into(), short(value))).into_iter().collect()
}

fn motion(scene: &Scene) -> Option<&CameraMotion> {
    scene.animation.as_ref().and_then(|animation| animation.camera.as_ref())
}

/// The camera, without what does not count.
fn seen(camera: &Camera) -> Camera {
    let default = Camera::default();
    let is_parallel = camera.orthographic_height.is_some();
    let fov_y_degrees = camera.fov_y_degrees.filter(|_| !is_parallel);
    Camera {
        direction: if camera.look_at.is_some() { default.direction } else { camera.direction },
        fov_x_degrees: match is_parallel || fov_y_degrees.is_some() {
            true => default.fov_x_degrees,
            false => camera.fov_x_degrees,
        },
        fov_y_degrees,
        ..*camera
    }
}

/// The camera that the file must say.
fn new_camera(before: &Scene, after: &Scene) -> Result<Option<Camera>, CannotSave> {
    let is_changed = before.camera.as_ref().map(seen) != after.camera.as_ref().map(seen);
    match (motion(before), motion(after)) {
        (_, Some(_)) if motion(before) != motion(after) => not_said("the motion of the camera was changed"),
        (_, Some(_)) if is_changed => not_said("the camera was changed, and it moves as before"),
        (Some(_), None) if after.camera.is_none() => not_said("the motion of the camera was taken away"),
        (None, None) if is_changed && after.camera.is_none() => not_said("the camera was taken away"),
        (Some(_), None) => Ok(after.camera),
        (None, None) if is_changed => Ok(after.camera),
        _ => Ok(None),
    }
}

fn camera_keys(camera: &Camera, scene: &Scene) -> Result<Value, CannotSave> {
    let place = |p| place(p, scene).ok_or_else(|| CannotSave::Digits { what: "the camera".into() });
    let mut keys = short_keys(&seen(camera));
    keys.insert("position".into(), place(camera.position)?);
    if let Some(point) = camera.look_at {
        keys.insert("look-at".into(), place(point)?);
        keys.shift_remove("direction");
    }
    if keys["fov-y-degrees"].is_number() || keys["orthographic-height"].is_number() {
        keys.shift_remove("fov-x-degrees");
    }
    keys.retain(|_, value| !value.is_null());
    if let Some(lens) = keys.get_mut("lens").and_then(Value::as_object_mut) {
        lens.retain(|_, value| !value.is_null());
    }
    Ok(keys.into())
}

fn light_keys(number: usize, mut light: Light, scene: &Scene) -> Result<Value, CannotSave> {
    let mut keys = short_keys(&light);
    let kind = light.key();
    if let Some(&mut position) = light.parts().position {
        let what = || format!("light {} of {}", number + 1, scene.lights.len());
        keys[kind]["position"] = place(position, scene).ok_or_else(|| CannotSave::Digits { what: what() })?;
    }
    Ok(keys.into())
}

/// The keys that differ, and some others.
fn changed_keys<T: Serialize>(before: &T, after: &T, also: impl Fn(&str) -> bool) -> Map<String, Value> {
    let before = short_keys(before);
    let mut keys = short_keys(after);
    keys.retain(|key, value| also(key) || before.get(key) != Some(value));
    keys
}

/// The keys of an object, with numbers of single precision in their fewest digits.
fn short_keys<T: Serialize>(object: &T) -> Map<String, Value> {
    fn shorten(value: &mut Value) {
        match value {
            Value::Array(items) => items.iter_mut().for_each(shorten),
            Value::Object(keys) => keys.iter_mut().for_each(|(_, value)| shorten(value)),
            Value::Number(number) if number.is_f64() => *value = short(number.as_f64().unwrap_or(0.0) as f32),
            _ => {}
        }
    }
    let mut value = serde_json::to_value(object).unwrap_or_default();
    shorten(&mut value);
    match value {
        Value::Object(keys) => keys,
        _ => Map::new(),
    }
}

/// A number of single precision in the fewest digits that are read as it.
fn short(x: f32) -> Value {
    let text = x.to_string();
    let is_read_back = |read: f32| read.to_bits() == x.to_bits();
    match text.parse::<f64>() {
        Ok(digits) if serde_json::from_str(&text).is_ok_and(is_read_back) => number(digits),
        _ => number(f64::from(x)),
    }
}

/// A number; whole ones without a point.
fn number(x: f64) -> Value {
    let is_whole = x.fract() == 0.0 && x.abs() < 1e15 && (x != 0.0 || x.is_sign_positive());
    if is_whole { json!(x as i64) } else { json!(x) }
}

/// A point in coordinates of the file that are read as it, where there are any.
fn place(p: Vec3, scene: &Scene) -> Option<Value> {
    let (whole, single) = (scene.point_in_file(p), <[f32; 3]>::from(p));
    let read = |axis: usize, x: f64| {
        let mut point = [0.0; 3];
        point[axis] = x;
        <[f32; 3]>::from(scene.point_of_file(point))[axis]
    };
    let coordinate = |axis: usize| {
        let fewest = short(whole[axis] as f32);
        let is_read_back = |value: &Value| read(axis, value.as_f64().unwrap_or(0.0)) == single[axis];
        [fewest, number(whole[axis])].into_iter().find(is_read_back)
    };
    Some([coordinate(0)?, coordinate(1)?, coordinate(2)?].to_vec().into())
}

/// Keys on lines of their own, those of objects too, and items of lists of objects. Everything deeper is in one line.
fn pretty(file: &Map<String, Value>) -> String {
    let entry = |(key, value): (&String, &Value)| format!("\"{key}\": {}", Inline(value));
    let whole = |(key, value): (&String, &Value)| {
        let (lines, [open, close]) = match value {
            Value::Object(keys) => (keys.iter().map(entry).collect::<Vec<_>>(), ["{", "}"]),
            Value::Array(items) => (items.iter().map(|item| Inline(item).to_string()).collect(), ["[", "]"]),
            _ => return format!("  {}", entry((key, value))),
        };
        match lines.is_empty() {
            true => format!("  \"{key}\": {open}{close}"),
            false => format!("  \"{key}\": {open}\n    {}\n  {close}", lines.join(",\n    ")),
        }
    };
    format!("{{\n{}\n}}\n", file.iter().map(whole).collect::<Vec<_>>().join(",\n"))
}

fn is_sky(environment: &EnvironmentMap) -> bool {
    matches!(environment.source, EnvironmentSource::Sky(_))
}

/// Reads the text over the base without its geometry, and compares.
fn check_text(text: &str, before: &Scene, after: &Scene) -> Result<(), CannotSave> {
    let options = LoadOptions::default();
    let mut loader = Loader::new(Source::Memory(Vec::new()), &options);
    let mut scene = Scene {
        origin: before.origin,
        camera: before.camera,
        lights: before.lights.clone(),
        settings: before.settings,
        animation: before.animation.clone(),
        environment: before.environment.filter(is_sky),
        device: before.device,
        output: before.output.clone(),
        frame: before.frame,
        ..Scene::default()
    };
    let read = Document::of(Path::new("the scene"), text).and_then(|document| {
        let mut file = file_of(&document)?;
        let mut builder = Builder { loader: &mut loader, document: &document };
        // A picture is not read again.
        if let Some(entry) = file.environment.take().filter(|entry| entry.file().is_none()) {
            scene.environment = builder.environment(Some(entry))?;
        }
        builder.put_over(&mut scene, file, true)
    });
    read.map_err(|error| match error {
        SceneError::Problem(problem) => problem,
        SceneError::Invalid { message, .. } => Problem::new("the scene", message),
        error => Problem::new("the scene", error.to_string()),
    })?;
    let is_same = scene.camera.as_ref().map(seen) == after.camera.as_ref().map(seen)
        && scene.lights == after.lights
        && scene.settings == after.settings
        && motion(&scene) == motion(after)
        && scene.environment.filter(is_sky) == after.environment.filter(is_sky)
        && scene.device == after.device
        && scene.output == after.output
        && scene.frame == after.frame;
    match is_same {
        true => Ok(()),
        false => Err(Problem::new("the scene", "not all of it can be said in a file over its base").into()),
    }
}
