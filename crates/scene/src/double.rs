//! Vectors in double precision: plain operations and square roots, so the same bits on every machine.

use eosphor_core::math::{Vec3, sqrt64, vec3};

pub(crate) type Vec3d = [f64; 3];

pub(crate) fn dot(a: Vec3d, b: Vec3d) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: Vec3d, b: Vec3d) -> Vec3d {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn add(a: Vec3d, b: Vec3d) -> Vec3d {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(crate) fn sub(a: Vec3d, b: Vec3d) -> Vec3d {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn scale(a: Vec3d, s: f64) -> Vec3d {
    a.map(|x| x * s)
}

pub(crate) fn length(a: Vec3d) -> f64 {
    sqrt64(dot(a, a))
}

/// A vector of some length as one of length 1.
pub(crate) fn unit(a: Vec3d) -> Vec3d {
    let length = length(a);
    a.map(|x| x / length)
}

pub(crate) fn single(a: Vec3d) -> Vec3 {
    vec3(a[0] as f32, a[1] as f32, a[2] as f32)
}

pub(crate) fn double(a: Vec3) -> Vec3d {
    [f64::from(a.x), f64::from(a.y), f64::from(a.z)]
}
