//! PLATO's own most colourful configuration.

use super::{CourseBody, CourseFloor, CourseInput, CourseLight, CoursePattern};
use crate::model::Law;
use crate::solids::PARQUET;
use eosphor_core::math::{Vec3, vec3};

impl CourseInput {
    /// The most colourful configuration, which the course asks programs to print. It is PLATO's own, but runs as it is:
    /// frames go to the working folder, and the floor's texture is a built-in one.
    pub fn colourful() -> CourseInput {
        let body = |center, color, radius, reflection, transparency, lights_per_edge| CourseBody {
            center,
            color,
            radius,
            reflection,
            transparency,
            lights_per_edge,
        };
        CourseInput {
            frames: 104,
            output: CoursePattern::numbered("img_", ".data"),
            size: [720, 480],
            fov_x_degrees: 120.0,
            position: Law {
                r: 4.0,
                z: 3.0,
                r_amplitude: 2.0,
                z_amplitude: 1.0,
                r_frequency: 2.0,
                z_frequency: 6.0,
                phi_frequency: 1.0,
                ..Law::default()
            },
            look_at: Law {
                r: 1.0,
                r_amplitude: 0.5,
                z_amplitude: 0.1,
                r_frequency: 1.0,
                z_frequency: 4.0,
                phi_frequency: 1.0,
                ..Law::default()
            },
            bodies: [
                body(vec3(2.0, 0.0, 0.0), vec3(1.0, 0.0, 0.0), 1.25, 0.9, 0.5, 10),
                body(vec3(0.0, 2.0, 0.0), vec3(0.0, 1.0, 0.0), 1.0, 0.8, 0.5, 5),
                body(Vec3::ZERO, vec3(0.0, 0.7, 0.7), 0.85, 0.7, 0.3, 5),
            ],
            floor: CourseFloor {
                corners: [
                    vec3(-5.0, -5.0, -1.0),
                    vec3(-5.0, 5.0, -1.0),
                    vec3(5.0, 5.0, -1.0),
                    vec3(5.0, -5.0, -1.0),
                ],
                texture: PARQUET.into(),
                tint: vec3(0.0, 1.0, 0.0),
                reflection: 0.5,
            },
            lights: vec![
                CourseLight { position: vec3(-10.0, 0.0, 10.0), color: Vec3::ONE },
                CourseLight { position: vec3(1.0, 0.0, 10.0), color: vec3(1.0, 0.0, 1.0) },
            ],
            depth: 6,
            rays_root: 2,
        }
    }
}
