//! Vectors of several lanes.

use super::{Vec3, vec3};

/// A vector in each of several lanes: their x, y and z, each together. Short loops over these, free of branches, become SIMD code.
#[derive(Clone, Copy, Debug)]
pub struct Vec3Lanes<const W: usize> {
    x: [f32; W],
    y: [f32; W],
    z: [f32; W],
}

impl<const W: usize> Vec3Lanes<W> {
    /// Null vectors.
    pub const ZERO: Vec3Lanes<W> = Vec3Lanes { x: [0.0; W], y: [0.0; W], z: [0.0; W] };

    /// Of these components.
    #[inline(always)]
    pub fn from_components([x, y, z]: [[f32; W]; 3]) -> Vec3Lanes<W> {
        Vec3Lanes { x, y, z }
    }

    /// The vector of a lane.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> Vec3 {
        vec3(self.x[lane], self.y[lane], self.z[lane])
    }

    /// Sets the vector of a lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, v: Vec3) {
        self.x[lane] = v.x;
        self.y[lane] = v.y;
        self.z[lane] = v.z;
    }
}
