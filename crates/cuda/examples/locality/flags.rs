//! What is asked: flags as `eosphor render` has them. Most are settings by the names that scene files use.

use eosphor_cuda::{CudaOptions, Traversal};
use eosphor_scene::{Lens, LoadOptions, RenderSettings, Scene, load};
use serde_json::{Map, Value, json};
use std::error::Error;

pub(crate) enum Subject {
    Scene(Box<Scene>),
    /// So many random ones.
    Random(u64),
}

pub(crate) struct Asked {
    pub(crate) subject: Subject,
    /// How far away things are, in extents.
    pub(crate) times: Vec<f32>,
    /// Where the GPU takes part.
    pub(crate) cuda: Option<CudaOptions>,
}

impl Asked {
    pub(crate) fn parse(arguments: impl Iterator<Item = String>) -> Result<Asked, Box<dyn Error>> {
        let mut arguments = arguments.peekable();
        let (mut name, mut random, mut device) = (None, None, "cpu".to_string());
        let mut times = vec![1e1, 1e4, 1e7];
        let mut options = CudaOptions::default();
        let (mut preset, mut settings, mut camera) = (None, Map::new(), Map::new());
        while let Some(argument) = arguments.next() {
            let Some(flag) = argument.strip_prefix("--") else {
                name = Some(argument);
                continue;
            };
            if let Some((key, value)) = switch(flag) {
                settings.insert(key.into(), value.into());
                continue;
            }
            if flag == "no-metadata" {
                continue;
            }
            let value = arguments.next().ok_or_else(|| format!("--{flag} needs a value"))?;
            match flag {
                "device" => device = value,
                "times" => times = vec![value.parse()?],
                "random" => random = Some(value.parse()?),
                "accel" => options.accel = value.parse()?,
                "builder" => options.hierarchy.builder = Some(value.parse()?),
                "block-size" => options.block_size = value.parse()?,
                "gpu-paths" => options.paths = Some(value.parse()?),
                "gpu-traversal" => {
                    let found = Traversal::ALL.into_iter().find(|t| t.name() == value);
                    options.traversal = found.ok_or_else(|| format!("there is no traversal {value}"))?;
                }
                "preset" => preset = Some(value.parse::<eosphor_scene::Preset>()?),
                "aperture" | "focus-distance" | "translate" => {
                    camera.insert(flag.into(), numbers(&value)?);
                }
                "ssaa" => {
                    settings.insert("pixel-sampling".into(), json!({ "grid": value.parse::<u32>()? }));
                }
                "crease" => {
                    settings.insert("crease-degrees".into(), numbers(&value)?);
                }
                _ => {
                    settings.insert(flag.into(), numbers(&value).unwrap_or_else(|_| json!(value)));
                }
            }
        }
        if let Some(devices) = device.strip_prefix("cuda:") {
            options.devices = devices.split(',').map(str::parse).collect::<Result<_, _>>()?;
        }
        let subject = match (random, name) {
            (Some(count), None) => Subject::Random(count),
            (None, Some(name)) => Subject::Scene(Box::new(scene(&name, preset, settings, &camera)?)),
            _ => return Err("a scene, or --random N".into()),
        };
        Ok(Asked { subject, times, cuda: device.starts_with("cuda").then_some(options) })
    }
}

/// Flags without a value.
fn switch(flag: &str) -> Option<(&'static str, bool)> {
    Some(match flag {
        "cull" => ("cull-back-faces", true),
        "light-from-behind" => ("light-from-behind", true),
        "no-light-from-behind" => ("light-from-behind", false),
        "light-falloff" => ("light-falloff", true),
        "no-light-falloff" => ("light-falloff", false),
        "linear-textures" => ("srgb-textures", false),
        _ => return None,
    })
}

/// `1.5`, `1,2,3` or `640x480`.
fn numbers(text: &str) -> Result<Value, Box<dyn Error>> {
    let parts: Vec<&str> = text.split([',', 'x']).collect();
    let parts: Vec<Value> = parts.iter().map(|part| serde_json::from_str(part)).collect::<Result<_, _>>()?;
    let all_numbers = parts.iter().all(Value::is_number);
    match (all_numbers, &parts[..]) {
        (true, [one]) => Ok(one.clone()),
        (true, _) => Ok(Value::Array(parts)),
        _ => Err("not a number".into()),
    }
}

/// The scene as the flags want it: the preset first, then settings, then camera and place.
fn scene(
    name: &str,
    preset: Option<eosphor_scene::Preset>,
    flags: Map<String, Value>,
    camera: &Map<String, Value>,
) -> Result<Scene, Box<dyn Error>> {
    let mut scene = load(name, &LoadOptions::default())?.scene;
    if let Some(preset) = preset {
        preset.apply(&mut scene);
    }
    let Value::Object(mut settings) = serde_json::to_value(scene.settings)? else {
        return Err("settings are an object".into());
    };
    // Samples by number make sense only where the scene's own grid goes.
    if flags.contains_key("samples") && settings["pixel-sampling"].is_object() {
        settings.insert("pixel-sampling".into(), json!("random"));
    }
    settings.extend(flags);
    scene.settings = serde_json::from_value::<RenderSettings>(Value::Object(settings))?;
    let number = |key: &str| camera.get(key).and_then(Value::as_f64).map(|x| x as f32);
    if let (Some(aperture_radius), Some(camera)) = (number("aperture"), &mut scene.camera) {
        camera.lens = Some(Lens { aperture_radius, focus_distance: number("focus-distance") });
    }
    if let Some(by) = camera.get("translate") {
        let by: [f32; 3] = serde_json::from_value(by.clone())?;
        scene.instances.iter_mut().for_each(|i| i.world_from_object.translate += by.into());
    }
    Ok(scene)
}
