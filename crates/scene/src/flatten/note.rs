//! What flattening has to say.

use super::framing::{LeftOut, View};
use crate::model::Camera;
use std::fmt;

/// Something that the scene left open, and what was done about it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Note {
    /// There is no camera.
    FramedCamera {
        /// Where it was put, in coordinates of the file.
        position: [f64; 3],
        /// The camera, as a scene would state it.
        camera: Camera,
        /// What it shows.
        view: View,
        /// What it does not frame.
        left_out: LeftOut,
        /// How many frames of an animation are in the picture; 1 where it is chosen for a single one.
        frames: u32,
    },
    /// The scene lies far from 0.
    FarOrigin {
        /// From where its coordinates are counted.
        origin: [f64; 3],
    },
    /// There is nothing to see.
    Empty,
    /// There is no light.
    Headlight {
        /// Where it was put, in coordinates of the file: at the camera.
        position: [f64; 3],
    },
    /// There is no light, and path tracing has surroundings.
    Surroundings {
        /// Their radiance.
        radiance: f32,
    },
    /// The environment's picture has no light.
    DarkEnvironment,
    /// Spheres shine but are no lights.
    EmissiveSpheres {
        /// How many.
        count: u32,
    },
    /// So many triangles are lights that the picture will take long.
    ManyLights {
        /// How many.
        count: u32,
        /// Shadow rays a shading point sends.
        rays: u64,
    },
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Note::FramedCamera { position: [x, y, z], view, left_out, frames, .. } => {
                write!(f, "no camera: {view}, at ({x:.4}, {y:.4}, {z:.4}){left_out}")?;
                match frames {
                    1 => Ok(()),
                    _ => write!(f, "; all {frames} frames are in view"),
                }
            }
            Note::FarOrigin { origin: [x, y, z] } => {
                write!(
                    f,
                    "the scene lies far from 0: it is rendered about ({x}, {y}, {z}); camera, lights and flags keep the \
                     coordinates of the file"
                )
            }
            Note::Empty => f.write_str("the scene is empty: there is nothing to see"),
            Note::Headlight { position: [x, y, z] } => {
                write!(f, "no light: a headlight without falloff at the camera ({x:.4}, {y:.4}, {z:.4})")
            }
            Note::Surroundings { radiance } => {
                write!(f, "no light: uniform surroundings of radiance {radiance}")
            }
            Note::DarkEnvironment => f.write_str("the environment is black: it lights nothing"),
            Note::EmissiveSpheres { count } => {
                write!(
                    f,
                    "emissive spheres ({count}) are seen but light nothing; use triangles or point lights"
                )
            }
            Note::ManyLights { count, rays } => {
                write!(
                    f,
                    "{count} triangles are lights: {rays} shadow rays a shading point; fewer light samples are faster"
                )
            }
        }
    }
}
