//! KHR_lights_punctual.

use super::accessors::Budget;
use super::document::{self, Document, LightType};
use super::nodes::{Nodes, PlacedNode};
use super::{Part, named};
use crate::model::{Light, Move, Scene};
use eosphor_core::math::Vec3;
use std::sync::Arc;

/// Brighter lights are cut to this.
const MAX_INTENSITY: f64 = 1e12;

/// A light of a node.
pub(super) struct PlacedLight {
    /// Before it moves, in coordinates of the file.
    light: Light,
    position: [f64; 3],
    pub(super) moves: Vec<Arc<Move>>,
}

impl PlacedLight {
    /// The light of a scene, before it moves; motions begin in coordinates of the file.
    pub(super) fn in_scene(&self, scene: &Scene) -> Light {
        let mut light = self.light;
        if let Some(position) = light.parts().position
            && self.moves.is_empty()
        {
            *position = scene.point_of_file(self.position);
        }
        light
    }
}

/// The lights of the placed nodes. Ranges, which are no physics, are ignored.
pub(super) fn placed(root: &Document, nodes: &Nodes, budget: &Budget) -> Result<Vec<PlacedLight>, String> {
    let mut lights = Vec::new();
    for placed in &nodes.placed {
        let Some(index) = root.nodes[placed.node].light() else { continue };
        let number = index.value();
        let file = named(root.lights(), number, "light")?;
        let placed = light(file, placed).and_then(|light| {
            let moves = nodes.moves(placed, budget)?;
            Ok(PlacedLight { light, position: placed.world.0[3], moves })
        });
        let name = || Part::new("light", number, file.name.as_deref());
        lights.push(placed.map_err(|e| format!("{}: {e}", name()))?);
    }
    Ok(lights)
}

fn light(file: &document::Light, placed: &PlacedNode) -> Result<Light, String> {
    // Candela and lux, which stand for W/sr and W/m^2: they are as they are.
    let scale = f64::from(file.intensity);
    let color = Vec3::from(file.color.map(|x| (f64::from(x) * scale).clamp(0.0, MAX_INTENSITY) as f32));
    let position = placed.world.position();
    // It shines along its own -z.
    let direction = || match placed.world.unit_axis(2) {
        Some(backward) => Ok(-backward),
        None => Err("its node squashes it: no scale may be 0".to_string()),
    };
    match file.light_type {
        Some(LightType::Point) => Ok(Light::Point { position, color }),
        Some(LightType::Directional) => Ok(Light::Directional { direction: direction()?, color }),
        Some(LightType::Spot) => {
            // Half angles, as ours.
            let (inner, outer) = file.spot.as_ref().map_or((0.0, std::f32::consts::FRAC_PI_4), |spot| {
                (spot.inner_cone_angle, spot.outer_cone_angle)
            });
            let degrees = |radians: f32| (f64::from(radians) * (180.0 / std::f64::consts::PI)) as f32;
            let outer_degrees = degrees(outer).clamp(0.0, 180.0);
            let inner_degrees = degrees(inner).clamp(0.0, outer_degrees);
            Ok(Light::Spot { position, direction: direction()?, inner_degrees, outer_degrees, color })
        }
        None => Err("its type is unknown; it must be point, spot or directional".into()),
    }
}
