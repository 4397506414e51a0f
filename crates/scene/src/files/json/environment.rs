//! The environment in JSON: a file name, or a file or a sky with how it is turned and how bright it is.

use super::document::Document;
use super::tree::way;
use crate::error::SceneError;
use crate::model::{EnvironmentMap, EnvironmentSource, Sky, Vector};
use crate::sky::sun_position;
use eosphor_core::math::{Vec3, vec3};
use schemars::JsonSchema;
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// A file name, or a file or a sky and how it surrounds the scene. A file's picture is equirectangular: with +y up its middle lies
/// towards +x, and +z right of that, as in Blender and three.js.
#[derive(Deserialize, JsonSchema)]
#[serde(untagged)]
#[schemars(rename = "Environment", extend("examples" = [
    "sky.hdr",
    { "file": "sky.hdr", "strength": 2, "rotation-degrees": 90, "seen": false },
    { "sky": { "sun-elevation-degrees": 20, "turbidity": 5 } }
]))]
pub(super) enum EnvironmentEntry {
    File(PathBuf),
    Fields(EnvironmentFields),
}

/// An environment by file, or a sky.
#[derive(Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(inline, extend("oneOf" = [{ "required": ["file"] }, { "required": ["sky"] }]))]
pub(super) struct EnvironmentFields {
    /// HDR, EXR or another picture, beside the scene file; or `builtin:studio`, three lamps with soft edges.
    #[serde(default)]
    #[schemars(with = "PathBuf", extend("examples" = ["sky.hdr"]))]
    file: Option<PathBuf>,
    /// A clear sky with its sun and the ground, instead of a file: Sky.
    #[serde(default)]
    #[schemars(with = "SkyEntry")]
    sky: Option<SkyEntry>,
    /// The radiance is the picture's colour, or the sky's, times this.
    #[serde(default = "one")]
    #[schemars(range(min = 0, max = 1_000_000))]
    strength: f32,
    /// Turns it counter-clockwise, seen from above.
    #[serde(default)]
    rotation_degrees: f32,
    /// Where the picture's upper border is, or the zenith.
    #[serde(default = "up")]
    #[schemars(with = "Vector")]
    up: Vec3,
    /// Whether cameras see it; where not, they see the background.
    #[serde(default = "yes")]
    seen: bool,
}

/// A clear sky with its sun, by the model of Hosek and Wilkie; below the horizon there is ground that it lights. The sun stands
/// where the angles say, or where it is at a time and a place. A radiance of 1 stands for 30,000 cd/m².
#[derive(Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(
    rename = "Sky",
    extend("allOf" = [
        { "not": { "required": ["sun-elevation-degrees", "sun-at"] } },
        { "not": { "required": ["sun-azimuth-degrees", "sun-at"] } },
    ]),
    extend("examples" = [
        { "sun-elevation-degrees": 20, "sun-azimuth-degrees": 250, "turbidity": 5 },
        { "sun-at": { "time": "2026-06-21T15:30+02:00", "latitude-degrees": 50.1, "longitude-degrees": 14.4 } }
    ])
)]
pub(super) struct SkyEntry {
    /// How high the sun stands over the horizon; 45 where nothing says it.
    #[serde(default)]
    #[schemars(with = "f32", range(min = 0, max = 90))]
    sun_elevation_degrees: Option<f32>,
    /// Where the sun stands, clockwise from north; 135 where nothing says it. With +y up, north is -z and east +x; with +z up,
    /// north is +y.
    #[serde(default)]
    #[schemars(with = "f32", range(min = -360, max = 360))]
    sun_azimuth_degrees: Option<f32>,
    /// Where the sun stands by a time, instead of its angles.
    #[serde(default)]
    #[schemars(with = "SunAt")]
    sun_at: Option<SunAt>,
    /// How hazy the air is: 2 is very clear, 3 clear, 6 hazy.
    #[serde(default = "turbidity")]
    #[schemars(range(min = 1, max = 10))]
    turbidity: f32,
    /// The share of light that the ground reflects.
    #[serde(default = "albedo")]
    #[schemars(range(min = 0, max = 1))]
    albedo: f32,
    /// The radiance of the sun's disk over what the model says; 0: no disk.
    #[serde(default = "one")]
    #[schemars(range(min = 0, max = 1_000_000))]
    sun_strength: f32,
}

/// A time and a place on Earth.
#[derive(Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(extend("examples" = [
    { "time": "2026-06-21T15:30+02:00", "latitude-degrees": 50.1, "longitude-degrees": 14.4 }
]))]
pub(super) struct SunAt {
    /// Date, time and zone (or Z for universal time).
    #[schemars(extend("examples" = ["2026-06-21T15:30+02:00", "2026-06-21T13:30:00Z"]))]
    time: String,
    /// North counts up.
    #[schemars(range(min = -90, max = 90), extend("examples" = [50.1]))]
    latitude_degrees: f64,
    /// East counts up.
    #[schemars(range(min = -180, max = 180), extend("examples" = [14.4]))]
    longitude_degrees: f64,
}

fn turbidity() -> f32 {
    Sky::default().turbidity
}

fn albedo() -> f32 {
    Sky::default().albedo
}

fn one() -> f32 {
    1.0
}

fn up() -> Vec3 {
    vec3(0.0, 1.0, 0.0)
}

fn yes() -> bool {
    true
}

impl EnvironmentEntry {
    /// The file, unless it is a sky.
    pub(super) fn file(&self) -> Option<&Path> {
        match self {
            EnvironmentEntry::File(file) => Some(file),
            EnvironmentEntry::Fields(fields) => fields.file.as_deref(),
        }
    }

    /// The environment, where its file is this image.
    pub(super) fn build(
        &self,
        image: Option<u32>,
        document: &Document,
    ) -> Result<EnvironmentMap, SceneError> {
        let fields = match self {
            EnvironmentEntry::File(_) => return Ok(EnvironmentMap::of_image(image.unwrap_or(0))),
            EnvironmentEntry::Fields(fields) => fields,
        };
        let source = match (image, &fields.sky) {
            (Some(image), None) => EnvironmentSource::Image(image),
            (None, Some(sky)) => EnvironmentSource::Sky(sky.build().map_err(|message| {
                let way = way!["environment", "sky", "sun-at"];
                document.error_in(&way, format!("environment.sky.sun-at: {message}"))
            })?),
            // The schema says so.
            _ => {
                let message = "environment: it needs either a \"file\" or a \"sky\"";
                return Err(document.error_in(&way!["environment"], message));
            }
        };
        Ok(EnvironmentMap {
            source,
            strength: fields.strength,
            rotation_degrees: fields.rotation_degrees,
            up: fields.up,
            is_seen: fields.seen,
        })
    }
}

impl SkyEntry {
    fn build(&self) -> Result<Sky, String> {
        let mut sky = Sky {
            turbidity: self.turbidity,
            albedo: self.albedo,
            sun_strength: self.sun_strength,
            ..Sky::default()
        };
        sky.sun_elevation_degrees = self.sun_elevation_degrees.unwrap_or(sky.sun_elevation_degrees);
        sky.sun_azimuth_degrees = self.sun_azimuth_degrees.unwrap_or(sky.sun_azimuth_degrees);
        if let Some(SunAt { time, latitude_degrees, longitude_degrees }) = &self.sun_at {
            sky.put_sun(sun_position(time, *latitude_degrees, *longitude_degrees)?)?;
        }
        Ok(sky)
    }
}
