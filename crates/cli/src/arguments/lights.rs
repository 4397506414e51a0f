//! Flags that add lights to the scene's own.

use super::sky::SkyFlags;
use super::values::{number, place, within};
use super::{Need, check};
use crate::failure::Failure;
use clap::Args;
use eosphor::math::{Vec3, vec3};
use eosphor::settings::Integrator;
use eosphor::{EnvironmentMap, Light, Scene, load_image};
use std::path::{Path, PathBuf};

/// Irradiance of a sun that states none.
const SUN: f32 = 3.0;

/// Intensity of a light that states none.
const LIGHT: f32 = 10.0;

#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Lights")]
pub(crate) struct LightFlags {
    /// Add a directional light: the direction in which its light travels (0,-1,0 comes from above), and the irradiance of a
    /// surface that faces it, in W/m² (0 to 1e6) [default: 3]. May be given several times
    #[arg(long, value_name = "X,Y,Z[,STRENGTH]", value_parser = sun, allow_hyphen_values = true)]
    sun: Vec<Sun>,
    /// Add a point light: its position, and its radiant intensity in W/sr (0 to 1e6) [default: 10]. May be given several times
    #[arg(long, value_name = "X,Y,Z[,POWER]", value_parser = light, allow_hyphen_values = true)]
    light: Vec<PointLight>,
    /// Surround the scene with a picture of all directions, from which light comes (.hdr, .exr or another): equirectangular, its
    /// middle towards +x, and +z right of that, with +y up. builtin:studio is three lamps with soft edges. Needs --integrator path
    #[arg(long, value_name = "FILE")]
    environment: Option<PathBuf>,
    /// The environment's radiance over what its picture or the sky says, 0 to 1e6 [default: 1]
    #[arg(long, value_name = "X", value_parser = within(0.0..=1e6), allow_hyphen_values = true)]
    environment_strength: Option<f32>,
    /// Turn the environment counter-clockwise, seen from above: degrees, -360 to 360 [default: 0]
    #[arg(long, value_name = "DEGREES", value_parser = within(-360.0..=360.0), allow_hyphen_values = true)]
    environment_rotation: Option<f32>,
    /// Where the upper border of the environment's picture is, or the sky's zenith: a direction [default: 0,1,0]
    #[arg(long, value_name = "X,Y,Z", value_parser = up, allow_hyphen_values = true)]
    environment_up: Option<Vec3>,
    /// Cameras see the background instead of the environment
    #[arg(long)]
    hide_environment: bool,
    #[command(flatten)]
    sky: SkyFlags,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Sun {
    direction: Vec3,
    irradiance: f32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct PointLight {
    /// In coordinates of the file.
    position: [f64; 3],
    intensity: f32,
}

impl LightFlags {
    pub(crate) fn is_given(&self) -> bool {
        !self.sun.is_empty() || !self.light.is_empty() || self.environment.is_some() || self.sky.is_given()
    }

    /// The file of the environment, or the name of a built-in one.
    pub(crate) fn environment(&self) -> Option<&Path> {
        self.environment.as_deref()
    }

    /// The file of the environment, where it is one.
    pub(crate) fn environment_file(&self) -> Option<&Path> {
        self.environment().filter(|file| !is_builtin(file))
    }

    /// Adds them after the scene's own: suns, then points; puts an environment in place of the scene's. All textures together may
    /// take so many bytes.
    pub(crate) fn apply(&self, scene: &mut Scene, memory_bytes: Option<u64>) -> Result<(), Failure> {
        let is_lit = scene.settings.lighting.is_lit();
        let needs = "a --lighting that lights count in: lambert, phong or blinn-phong";
        let need = |flag, is_given| Need { flag, is_given, is_met: is_lit, needs };
        check(&[need("--sun", !self.sun.is_empty()), need("--light", !self.light.is_empty())])?;
        for &Sun { direction, irradiance } in &self.sun {
            scene.lights.push(Light::Directional { direction, color: Vec3::splat(irradiance) });
        }
        for &PointLight { position, intensity } in &self.light {
            let position = scene.point_of_file(position);
            scene.lights.push(Light::Point { position, color: Vec3::splat(intensity) });
        }
        self.surround(scene, memory_bytes)
    }

    fn surround(&self, scene: &mut Scene, memory_bytes: Option<u64>) -> Result<(), Failure> {
        let need = |flag, is_given, is_met, needs| Need { flag, is_given, is_met, needs };
        let is_path = scene.settings.integrator == Integrator::Path;
        check(&[
            need("--environment", self.environment.is_some(), is_path, "--integrator path"),
            need("--sky", self.sky.is_given(), is_path, "--integrator path"),
        ])?;
        if let Some(file) = &self.environment {
            let used: u64 = scene.images.iter().map(|image| image.texels.bytes()).sum();
            let left = memory_bytes.map(|limit| limit.saturating_sub(used));
            let image = load_image(file, left).map_err(|error| Failure::Failed(error.to_string()))?;
            scene.images.push(image);
            scene.environment = Some(EnvironmentMap::of_image(scene.images.len() as u32 - 1));
        }
        self.sky.apply(scene)?;
        let is_there = scene.environment.is_some();
        let of_environment =
            |flag, is_given| need(flag, is_given, is_there, "--environment, --sky, or a scene that has one");
        check(&[
            of_environment("--environment-strength", self.environment_strength.is_some()),
            of_environment("--environment-rotation", self.environment_rotation.is_some()),
            of_environment("--environment-up", self.environment_up.is_some()),
            of_environment("--hide-environment", self.hide_environment),
        ])?;
        if let Some(environment) = &mut scene.environment {
            environment.strength = self.environment_strength.unwrap_or(environment.strength);
            environment.rotation_degrees = self.environment_rotation.unwrap_or(environment.rotation_degrees);
            environment.up = self.environment_up.unwrap_or(environment.up);
            environment.is_seen &= !self.hide_environment;
        }
        Ok(())
    }
}

/// Whether a picture is made by the program.
pub(crate) fn is_builtin(file: &Path) -> bool {
    file.to_str().is_some_and(|name| name.starts_with("builtin:"))
}

/// `0,0,1`.
fn up(text: &str) -> Result<Vec3, String> {
    let [x, y, z] = place(text)?.map(|x| x as f32);
    let direction = vec3(x, y, z);
    if direction.normalize_or(Vec3::ZERO) == Vec3::ZERO {
        return Err("it has no length".into());
    }
    Ok(direction)
}

/// `0,-1,0` or `0,-1,0,2.5`.
fn sun(text: &str) -> Result<Sun, String> {
    let (direction, strength) = place_and_strength(text)?;
    let [x, y, z] = direction.map(|x| x as f32);
    let direction = vec3(x, y, z);
    if direction.normalize_or(Vec3::ZERO) == Vec3::ZERO {
        return Err("its direction has no length".into());
    }
    Ok(Sun { direction, irradiance: strength.unwrap_or(SUN) })
}

/// `1,2,3` or `1,2,3,50`.
fn light(text: &str) -> Result<PointLight, String> {
    let (position, strength) = place_and_strength(text)?;
    Ok(PointLight { position, intensity: strength.unwrap_or(LIGHT) })
}

fn place_and_strength(text: &str) -> Result<([f64; 3], Option<f32>), String> {
    match text.match_indices(',').nth(2) {
        None => Ok((
            place(text).map_err(|problem| match problem.starts_with("it must") {
                true => "it must be three numbers, or four, as 1,0,-2.5 or 1,0,-2.5,4".to_owned(),
                false => problem,
            })?,
            None,
        )),
        Some((comma, _)) => {
            let strength = number(&text[comma + 1..])?;
            match (0.0..=1e6).contains(&strength) {
                true => Ok((place(&text[..comma])?, Some(strength))),
                false => Err(format!("{strength} is out of range: how strong it is must be from 0 to 1e6")),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_have_three_numbers_or_four() {
        assert_eq!(sun("0,-2,1"), Ok(Sun { direction: vec3(0.0, -2.0, 1.0), irradiance: SUN }));
        assert_eq!(sun("0,-2,1,0.5").unwrap().irradiance, 0.5);
        assert_eq!(light("1e6,-2,1,7"), Ok(PointLight { position: [1e6, -2.0, 1.0], intensity: 7.0 }));
        for bad in
            ["", "1", "1,2", "1,2,3,", "1,2,3,4,5", "1,2,3,-1", "1,2,3,2e6", "1,2,3,nan", "a,2,3", "1,,3"]
        {
            assert!(sun(bad).is_err() && light(bad).is_err(), "{bad}");
        }
        assert_eq!(sun("0,0,0").unwrap_err(), "its direction has no length");
    }
}
