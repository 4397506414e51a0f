//! Vectors of double precision, apart from the arithmetic that they judge.

use eosphor_core::math::{Vec3, vec3};

pub(crate) type V = [f64; 3];

pub(crate) fn double(v: Vec3) -> V {
    [v.x as f64, v.y as f64, v.z as f64]
}

pub(crate) fn single(v: V) -> Vec3 {
    vec3(v[0] as f32, v[1] as f32, v[2] as f32)
}

pub(crate) fn add(a: V, b: V) -> V {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(crate) fn sub(a: V, b: V) -> V {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn times(a: V, b: V) -> V {
    [a[0] * b[0], a[1] * b[1], a[2] * b[2]]
}

pub(crate) fn scaled(a: V, s: f64) -> V {
    a.map(|x| x * s)
}

/// `a + d t`.
pub(crate) fn along(a: V, d: V, t: f64) -> V {
    [a[0] + d[0] * t, a[1] + d[1] * t, a[2] + d[2] * t]
}

pub(crate) fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn length(v: V) -> f64 {
    dot(v, v).sqrt()
}

pub(crate) fn unit(v: V) -> V {
    scaled(v, 1.0 / length(v))
}

pub(crate) fn largest(v: V) -> f64 {
    v.iter().fold(0.0, |m: f64, x| m.max(x.abs()))
}

/// Two unit vectors that are perpendicular to `n` and to each other: with it they are right-handed.
pub(crate) fn beside(n: V) -> [V; 2] {
    let axis = if n[0].abs() < 0.6 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let a = unit(cross(axis, n));
    [a, cross(n, a)]
}
