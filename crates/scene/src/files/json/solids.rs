//! Platonic solids of a JSON scene.

use super::build::Builder;
use super::format::SolidEntry;
use super::tree::way;
use crate::error::{Problem, SceneError};
use crate::model::{Light, Transform, double};
use crate::solids::{Body, BodyLighting};
use eosphor_core::math::Vec3;

/// Most triangles of all solids of a file. A few bytes of text make tens of thousands: this is less than a GB in all.
const MAX_SOLID_TRIANGLES: usize = 2_000_000;

/// The lights in the middle of solids, each with the number of its solid.
pub(super) type MiddleLights = Vec<(usize, Light)>;

impl Builder<'_> {
    /// Places the solids; their lights are for [`Builder::add_middle_lights`].
    pub(super) fn add_solids(&mut self, entries: &[SolidEntry]) -> Result<MiddleLights, SceneError> {
        let (mut lights, mut triangles) = (Vec::new(), 0);
        for (i, entry) in entries.iter().enumerate() {
            let wrong =
                |key: &str, message: String| Err(self.document.error_in(&way!["solids", i, key], message));
            if entry.lit_by.is_some() && entry.lights_per_edge == 0 {
                let message = "\"lit-by\" does nothing without lights along the edges; give \"lights-per-edge\" or drop it";
                return wrong("lit-by", message.into());
            }
            triangles += entry.shape.triangle_count(entry.lights_per_edge);
            if triangles > MAX_SOLID_TRIANGLES {
                let message = format!(
                    "up to here solids have {triangles} triangles; they may have {MAX_SOLID_TRIANGLES}"
                );
                return wrong("lights-per-edge", message);
            }
            let center = self.exact(&way!["solids", i, "center"]).unwrap_or(double(entry.center));
            let is_apart = self.is_beyond(center, 2.0 * f64::from(entry.radius));
            let scene = &mut self.loader.scene;
            let before = scene.lights.len();
            let body = entry.body(if is_apart { Vec3::ZERO } else { entry.center });
            body.add_to(scene).map_err(|problem: Problem| {
                let key = problem.what.rsplit(' ').next().unwrap_or_default();
                self.document.error_in(&way!["solids", i, key], problem.to_string())
            })?;
            if let Some(instance) = scene.instances.last_mut().filter(|_| is_apart) {
                instance.world_from_object = Transform { offset: center, ..Transform::default() };
            }
            lights.extend(scene.lights.drain(before..).map(|light| (i, light)));
        }
        Ok(lights)
    }

    /// Puts the lights of solids before those of the file, where the course has them, and counts on: motions of lights name
    /// theirs by number.
    pub(super) fn add_middle_lights(&mut self, lights: MiddleLights) {
        let count = lights.len() as u32;
        let place = |(solid, light)| match (light, self.exact(&way!["solids", solid, "center"])) {
            (Light::Point { color, .. }, Some(center)) => {
                Light::Point { position: self.loader.scene.point_of_file(center), color }
            }
            _ => light,
        };
        let lights: Vec<Light> = lights.into_iter().map(place).collect();
        let scene = &mut self.loader.scene;
        scene.lights.splice(0..0, lights);
        for motion in scene.animation.iter_mut().flat_map(|animation| &mut animation.lights) {
            motion.light += count;
        }
    }
}

impl SolidEntry {
    fn body(&self, center: Vec3) -> Body {
        Body {
            shape: self.shape,
            center,
            radius: self.radius,
            color: Vec3::from(self.color),
            reflection: self.reflection,
            transparency: self.transparency,
            lights_per_edge: self.lights_per_edge,
            lighting: self.lit_by.unwrap_or(BodyLighting::PLATO),
        }
    }
}
