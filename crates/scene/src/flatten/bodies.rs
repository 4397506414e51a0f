//! Which refracting materials enclose what they refract into.
//!
//! A surface is closed if each edge is run through as often one way as the other: the sum over all edges of a hash, with the sign
//! of the way, is 0. Corners at one place are one corner, whichever mesh they are of.

use super::geometry::Flat;
use eosphor_core::material::{AlphaUse, FresnelUse, Material, NONE, Refraction, SurfaceModel};
use eosphor_core::math::Vec3;
use std::collections::HashMap;

/// Paths keep numbers of bodies in 16 bits, 0 for none.
const MOST: usize = 65_535;

/// Sets [`Material::is_body`].
pub(super) fn mark(materials: &mut [Material], flat: &Flat) {
    let may_be = |m: &Material| m.refraction == Refraction::Snell && is_glass(m) && has_both_sides(m);
    let is_asked: Vec<bool> = materials.iter().enumerate().map(|(k, m)| k < MOST && may_be(m)).collect();
    if !is_asked.contains(&true) {
        return;
    }
    let mut is_open = vec![false; materials.len()];
    for (number, geometry) in flat.geometries.iter().enumerate() {
        let first = geometry.first_triangle as usize;
        let range = first..first + geometry.triangle_count as usize;
        let triangles = flat.triangles[range.clone()].iter().zip(&flat.triangle_shading[range]);
        let mut parts = HashMap::<u32, Surface>::new();
        for (corners, shading) in triangles.clone() {
            if is_asked[shading.material as usize] {
                parts.entry(shading.material).or_default().add(corners);
            }
        }
        let others = flat.instances.iter().filter(|i| i.geometry as usize == number && i.material != NONE);
        let others = others.map(|instance| instance.material).filter(|&m| is_asked[m as usize]);
        for material in others {
            parts.entry(material).or_insert_with(|| {
                let mut whole = Surface::default();
                triangles.clone().for_each(|(corners, _)| whole.add(corners));
                whole
            });
        }
        for (material, surface) in parts {
            is_open[material as usize] |= !surface.is_closed();
        }
    }
    for ((material, is_asked), is_open) in materials.iter_mut().zip(is_asked).zip(is_open) {
        material.is_body = is_asked && !is_open;
    }
}

/// Whether path tracing lets light through its inside.
fn is_glass(m: &Material) -> bool {
    match m.model {
        SurfaceModel::MetallicRoughness => m.transmission.x > 0.0,
        SurfaceModel::Composed => m.fresnel == FresnelUse::Both,
    }
}

/// Whether rays meet it wherever they go in or out.
fn has_both_sides(m: &Material) -> bool {
    m.alpha == AlphaUse::Ignore && !m.single_sided
}

/// Triangles that may enclose something.
#[derive(Default)]
struct Surface {
    edges: [u64; 2],
    /// Six times what is inside, seen from the first corner.
    volume: f64,
    origin: Option<[f64; 3]>,
}

impl Surface {
    fn add(&mut self, &[a, b, c]: &[Vec3; 3]) {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            self.add_edge(place(from), place(to));
        }
        let origin = *self.origin.get_or_insert(double(a));
        let [a, b, c] = [a, b, c].map(|corner| {
            let p = double(corner);
            [p[0] - origin[0], p[1] - origin[1], p[2] - origin[2]]
        });
        let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
        self.volume += a[0] * cross[0] + a[1] * cross[1] + a[2] * cross[2];
    }

    fn add_edge(&mut self, from: [u32; 3], to: [u32; 3]) {
        if from == to {
            return;
        }
        let (low, high) = if from < to { (from, to) } else { (to, from) };
        for (seed, sum) in self.edges.iter_mut().enumerate() {
            let hash = low.iter().chain(&high).fold(seed as u64 + 1, |h, &x| mixed(h ^ u64::from(x)));
            *sum = if from < to { sum.wrapping_add(hash) } else { sum.wrapping_sub(hash) };
        }
    }

    /// With its fronts outside.
    fn is_closed(&self) -> bool {
        self.edges == [0; 2] && self.volume > 0.0
    }
}

/// The bits of a point; 0 has one sign.
fn place(p: Vec3) -> [u32; 3] {
    [p.x, p.y, p.z].map(|x| (x + 0.0).to_bits())
}

fn double(p: Vec3) -> [f64; 3] {
    [p.x, p.y, p.z].map(f64::from)
}

/// The finaliser of SplitMix64 (Steele, Lea and Flood 2014).
fn mixed(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}
