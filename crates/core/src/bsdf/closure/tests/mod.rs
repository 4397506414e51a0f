//! Tests of all lobes together, by their values, their densities and the light that they lose.

mod chi_square;
mod density;
mod everything;
mod furnace;
mod mitsuba;
mod quadrature;
mod smooth;

use super::*;
use crate::math::{sqrt, vec3};

impl Closure {
    fn eval(&self, to_viewer: Vec3, to_light: Vec3) -> Scattered {
        self.towards(to_viewer).eval(to_light)
    }

    fn sample(&self, to_viewer: Vec3, pick: f32, u: [f32; 2]) -> Option<ScatterSample> {
        self.towards(to_viewer).sample([pick, u[1]], || u[0])
    }
}

/// Nothing at all, to be filled in.
fn nothing() -> Closure {
    Closure {
        diffuse: Vec3::ZERO,
        diffuse_roughness: 0.0,
        f0: Vec3::ZERO,
        f90: Vec3::ZERO,
        metal_f0: Vec3::ZERO,
        metal: 0.0,
        glass: 0.0,
        glass_tint: Vec3::ONE,
        eta: 1.5,
        is_thin: false,
        alpha: 0.0,
    }
}

/// White metal and a white layer over a white base, which share the surface.
fn white(metal: f32, f0: f32, alpha: f32) -> Closure {
    let base = Vec3::splat(1.0 - metal);
    Closure {
        diffuse: base,
        f0: base * f0,
        f90: base,
        metal_f0: Vec3::splat(metal),
        metal,
        alpha,
        ..nothing()
    }
}

fn glass(eta: f32, is_thin: bool, alpha: f32) -> Closure {
    Closure { glass: 1.0, eta, is_thin, alpha, ..nothing() }
}

/// A unit vector at a cosine to the normal.
fn viewer(cos: f32) -> Vec3 {
    let sine = sqrt((1.0 - cos) * (1.0 + cos));
    vec3(0.6 * sine, -0.8 * sine, cos)
}
