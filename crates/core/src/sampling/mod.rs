//! Counter-based random numbers and well-distributed points: a number is a function of (seed, pixel, sample, path,
//! dimension) alone, so it is the same on every device, thread and rank.

mod hash;
mod sobol;
mod sobol_8d;
mod warp;

pub use hash::{hash_pair, mix};
pub use sobol::{owen_scramble, place_within, point_2d, sobol_2d, with_digits};
pub use sobol_8d::{point_8d, points_8d};
pub use warp::{
    cosine_direction, cosine_lobe, disk_point, hemisphere_direction, onto_axis, orthonormal_basis,
    triangle_point,
};
