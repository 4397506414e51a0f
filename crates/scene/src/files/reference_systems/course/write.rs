//! [`CourseInput`] → the text.

use super::CourseInput;
use crate::model::Law;
use eosphor_core::math::Vec3;
use std::fmt;

/// The text that reads as this, a line for each part. Numbers are the shortest that read as the same.
impl fmt::Display for CourseInput {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.frames)?;
        writeln!(f, "{}", self.output)?;
        let [width, height] = self.size;
        writeln!(f, "{width} {height} {}", self.fov_x_degrees)?;
        for law in [&self.position, &self.look_at] {
            writeln!(f, "{}", LawText(law))?;
        }
        for b in &self.bodies {
            let (center, color) = (Three(b.center), Three(b.color));
            writeln!(
                f,
                "{center}  {color}  {:?}  {:?} {:?} {}",
                b.radius, b.reflection, b.transparency, b.lights_per_edge
            )?;
        }
        let floor = &self.floor;
        for corner in floor.corners {
            write!(f, "{}  ", Three(corner))?;
        }
        writeln!(f, "{}  {}  {:?}", floor.texture, Three(floor.tint), floor.reflection)?;
        writeln!(f, "{}", self.lights.len())?;
        for light in &self.lights {
            writeln!(f, "{}  {}", Three(light.position), Three(light.color))?;
        }
        writeln!(f, "{} {}", self.depth, self.rays_root)
    }
}

struct Three(Vec3);

impl fmt::Display for Three {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Vec3 { x, y, z } = self.0;
        write!(f, "{x:?} {y:?} {z:?}")
    }
}

struct LawText<'a>(&'a Law);

impl fmt::Display for LawText<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Law {
            r,
            z,
            phi,
            r_amplitude,
            z_amplitude,
            r_frequency,
            z_frequency,
            phi_frequency,
            r_phase,
            z_phase,
        } = self.0;
        write!(f, "{r:?} {z:?} {phi:?}  {r_amplitude:?} {z_amplitude:?}  ")?;
        write!(f, "{r_frequency:?} {z_frequency:?} {phi_frequency:?}  {r_phase:?} {z_phase:?}")
    }
}
