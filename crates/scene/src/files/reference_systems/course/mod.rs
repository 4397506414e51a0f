//! The input text of PLATO's course: a flight around three Platonic solids ("Backward ray tracing with MPI, CUDA and
//! OpenMP", MAI).
//!
//! Words between white space, in this order: number of frames; output path with `%d`; width, height and horizontal
//! angle in degrees; the camera's law (`r0 z0 phi0 A_r A_z w_r w_z w_phi p_r p_z`), then that of the point it looks at; for
//! each of three bodies centre, colour, radius, reflection, transparency and lights an edge; the floor's four corners,
//! texture path, tint and reflection; the number of lights (at most 4), each position and colour; depth and the square root
//! of the rays a pixel. z is up.

mod colourful;
mod parse;
mod pattern;
mod scene;
#[cfg(test)]
mod tests;
mod words;
mod write;

use crate::model::Law;
use crate::solids::Solid;
use eosphor_core::math::Vec3;
use std::path::PathBuf;

pub use pattern::{CoursePattern, WrongCoursePattern};

/// The most lights besides those of the bodies.
pub const MAX_COURSE_LIGHTS: usize = 4;

/// What the text says.
///
/// ```
/// use eosphor_scene::{CourseInput, CourseOptions};
///
/// let input = CourseInput::colourful();
/// assert_eq!(CourseInput::parse(input.to_string().as_bytes(), "standard input".as_ref())?, input);
/// let scene = input.scene(&CourseOptions::default())?.scene;
/// assert_eq!(scene.animation.unwrap().frames, 104);
/// # Ok::<(), eosphor_scene::SceneError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct CourseInput {
    /// How many frames there are.
    pub frames: u32,
    /// Paths of the frames.
    pub output: CoursePattern,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Horizontal angle of view in degrees.
    pub fov_x_degrees: f32,
    /// How the camera moves, in cylindrical coordinates about z.
    pub position: Law,
    /// How the point that the camera looks at moves, in cylindrical coordinates about z.
    pub look_at: Law,
    /// The bodies; [`CourseOptions::shapes`] has their shapes.
    pub bodies: [CourseBody; 3],
    /// The floor.
    pub floor: CourseFloor,
    /// Lights besides those of the bodies, at most [`MAX_COURSE_LIGHTS`].
    pub lights: Vec<CourseLight>,
    /// Bounces after the camera ray.
    pub depth: u32,
    /// Square root of the rays a pixel.
    pub rays_root: u32,
}

/// Lines of the text, from 1, of what is looked at only after it was read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CourseLines {
    /// Line of [`CourseInput::output`].
    pub output: u32,
    /// Line of [`CourseFloor::texture`].
    pub texture: u32,
}

/// A body of the text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CourseBody {
    /// Middle of the body, in world units.
    pub center: Vec3,
    /// Colour of the faces, 0 to 1.
    pub color: Vec3,
    /// Circumradius in world units.
    pub radius: f32,
    /// Share of light that is reflected, 0 to 1.
    pub reflection: f32,
    /// Share of light that passes straight through a face, 0 to 1.
    pub transparency: f32,
    /// Number of lights along each edge.
    pub lights_per_edge: u32,
}

/// The floor of the text.
#[derive(Clone, Debug, PartialEq)]
pub struct CourseFloor {
    /// One after the other around it. The picture's lower left corner is at the first, the upper left at the second.
    pub corners: [Vec3; 4],
    /// A picture's path, or `builtin:parquet`.
    pub texture: String,
    /// Colour that multiplies the picture.
    pub tint: Vec3,
    /// Share of light that is reflected, 0 to 1.
    pub reflection: f32,
}

/// A light of the text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CourseLight {
    /// Position in world units.
    pub position: Vec3,
    /// Colour of its light, the same at any distance.
    pub color: Vec3,
}

/// What the text does not say.
#[derive(Clone, Debug)]
pub struct CourseOptions {
    /// Shapes of the three bodies; `None` leaves one out.
    pub shapes: [Option<Solid>; 3],
    /// The lights along the edges light the scene themselves, instead of PLATO's one light in the middle of each body.
    /// Much slower: each is a light with a shadow ray of its own.
    pub diodes: bool,
    /// Folder that the texture's path is relative to; empty: the working folder.
    pub folder: PathBuf,
    /// Most bytes of the texels of the floor; see [`crate::LoadOptions::texture_memory_bytes`].
    pub texture_memory_bytes: Option<u64>,
}

impl Default for CourseOptions {
    fn default() -> CourseOptions {
        CourseOptions {
            shapes: [Solid::Tetrahedron, Solid::Octahedron, Solid::Dodecahedron].map(Some),
            diodes: false,
            folder: PathBuf::new(),
            texture_memory_bytes: None,
        }
    }
}
