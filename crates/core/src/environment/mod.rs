//! Light from infinitely far, in all directions: a picture of them, and a table by which bright ones are chosen. Where the picture
//! has a sun, its disk is chosen by itself: it is as small as a few cells of the table.
//!
//! The picture is equirectangular. Its upper border is one direction, up, and its lower border the opposite one. With +y up, the
//! middle of the picture lies towards +x, and +z a fourth of its width right of that, as in Blender and three.js.

mod cell;
mod index;
mod sun;
mod table;

pub use cell::corners_word;
pub use index::{TABLE_UNIT, for_index_words, index_length};
pub use table::{BANDS, DirectionLanes, DirectionSample};

use crate::material::NONE;
use crate::math::{Vec3, Vec3Lanes, elementary, floor, fma, sqrt, vec3};
use crate::texture::{Textures, color_at};

/// What surrounds the scene, besides the constant background. Its table stands in the scene's arrays.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Environment {
    /// Number of the texture, repeated along `u` and clamped along `v`; [`NONE`]: there is no picture.
    pub texture: u32,
    /// Radiance over what the picture says.
    pub strength: f32,
    /// Takes directions of the world into the picture's frame, whose y is up; rows of a rotation.
    pub picture_from_world: [Vec3; 3],
    /// Whether camera rays see it; where not, they see the background.
    pub is_seen: bool,
    /// The probability with which a light sample goes to the environment; 0 where it has no light.
    pub chance: f32,
    /// Columns of the table.
    pub columns: u32,
    /// Corners of cells a column; of cells there is one more.
    pub rows: u32,
    /// The first rows of cells of all bands but the first one.
    pub band_rows: [u32; BANDS - 1],
    /// Running sums of the weights of bands, up to [`TABLE_UNIT`].
    pub band_sums: [u32; BANDS],
    /// The probability with which a sample of the environment goes to the sun's disk; 0 where there is none.
    pub sun_chance: f32,
    /// The middle of that disk: a unit vector of the picture's frame.
    pub to_sun: Vec3,
    /// The sine of the angle from there to the disk's edge.
    pub sun_radius: f32,
}

impl Environment {
    /// There is no picture.
    pub const NOWHERE: Environment = Environment {
        texture: NONE,
        strength: 0.0,
        picture_from_world: [vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0)],
        is_seen: false,
        chance: 0.0,
        columns: 0,
        rows: 0,
        band_rows: [0; BANDS - 1],
        band_sums: [TABLE_UNIT; BANDS],
        sun_chance: 0.0,
        to_sun: vec3(0.0, 1.0, 0.0),
        sun_radius: 0.0,
    };

    /// The number of words in its table.
    pub fn table_length(&self) -> u64 {
        let columns = self.columns as usize;
        (BANDS * index_length(columns)) as u64 + (columns as u64).saturating_mul(self.column_length() as u64)
    }

    /// Of cells a column.
    #[inline(always)]
    fn cell_rows(&self) -> u32 {
        self.rows.wrapping_add(1)
    }

    /// Words a column of cells: running sums and the index into them, then the corners.
    #[inline(always)]
    fn column_length(&self) -> usize {
        index_length(self.cell_rows() as usize) + self.cell_rows() as usize
    }

    /// Whether there is a picture.
    #[inline(always)]
    pub fn is_there(&self) -> bool {
        self.texture != NONE
    }

    /// The radiance that comes from a direction, a unit vector of the world.
    #[inline(always)]
    pub fn radiance(&self, textures: &Textures, direction: Vec3) -> Vec3 {
        self.radiance_at(textures, &self.place(direction))
    }

    /// The same from a place of the picture.
    #[inline(always)]
    pub fn radiance_at(&self, textures: &Textures, place: &PicturePlace) -> Vec3 {
        let uv = place.uv();
        color_at(textures, self.texture, &[uv, uv]) * self.strength
    }

    /// The same from the places of those lanes that are wanted.
    #[inline(always)]
    pub fn radiance_lanes<const W: usize>(
        &self,
        textures: &Textures,
        places: &PlaceLanes<W>,
        is_wanted: &[bool; W],
    ) -> Vec3Lanes<W> {
        // As GPUs have it: by a function of its own there.
        if W == 1 {
            let mut radiance = Vec3Lanes::ZERO;
            if is_wanted[0] {
                radiance.set(0, self.radiance_at(textures, &places.get(0)));
            }
            return radiance;
        }
        let mut uv = [[0.0; W]; 2];
        for lane in 0..W {
            [uv[0][lane], uv[1][lane]] = places.get(lane).uv();
        }
        let mut radiance = textures.colors(self.texture, &uv, is_wanted);
        for lane in 0..W {
            radiance.set(lane, radiance.get(lane) * self.strength);
        }
        radiance
    }

    /// Where a direction, a unit vector of the world, lies.
    #[inline(always)]
    pub fn place(&self, direction: Vec3) -> PicturePlace {
        let direction = self.in_picture(direction);
        PicturePlace { direction, place: picture_place(direction) }
    }

    #[inline(always)]
    fn in_picture(&self, d: Vec3) -> Vec3 {
        let [x, y, z] = self.picture_from_world;
        vec3(x.dot(d), y.dot(d), z.dot(d))
    }

    #[inline(always)]
    fn in_world(&self, d: Vec3) -> Vec3 {
        let [x, y, z] = self.picture_from_world;
        (x * d.x).plus_scaled(y, d.y).plus_scaled(z, d.z).normalize_or(y)
    }
}

/// A direction and its place in the picture.
#[derive(Clone, Copy, Debug)]
pub struct PicturePlace {
    /// A unit vector of the picture's frame.
    direction: Vec3,
    /// Right and down, 0 to 1 each.
    place: [f32; 2],
}

impl PicturePlace {
    /// In texture coordinates.
    #[inline(always)]
    fn uv(&self) -> [f32; 2] {
        let [x, y] = self.place;
        [x, 1.0 - y]
    }
}

/// Directions and their places in several lanes.
#[derive(Clone, Copy, Debug)]
pub struct PlaceLanes<const W: usize> {
    direction: Vec3Lanes<W>,
    place: [[f32; W]; 2],
}

impl<const W: usize> PlaceLanes<W> {
    /// [`Environment::place`] of unit vectors of the world.
    #[inline(always)]
    pub fn new(environment: &Environment, direction: &Vec3Lanes<W>) -> PlaceLanes<W> {
        let mut lanes = PlaceLanes { direction: Vec3Lanes::ZERO, place: [[0.0; W]; 2] };
        for lane in 0..W {
            let PicturePlace { direction, place: [x, y] } = environment.place(direction.get(lane));
            lanes.direction.set(lane, direction);
            (lanes.place[0][lane], lanes.place[1][lane]) = (x, y);
        }
        lanes
    }

    /// Of a lane.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> PicturePlace {
        let [x, y] = self.place;
        PicturePlace { direction: self.direction.get(lane), place: [x[lane], y[lane]] }
    }
}

/// Where a direction of the picture's frame lies in the picture, right and down, 0 to 1 each.
#[inline(always)]
fn picture_place(d: Vec3) -> [f32; 2] {
    let around = elementary::atan2(d.z, d.x) * (0.5 * core::f32::consts::FRAC_1_PI);
    let from_up = elementary::atan2(sqrt(fma(d.x, d.x, d.z * d.z)), d.y) * core::f32::consts::FRAC_1_PI;
    let x = around + 0.5;
    [x - floor(x), from_up]
}
