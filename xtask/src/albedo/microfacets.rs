//! Integrals over the microfacets of GGX that a viewer sees (Dupuy and Benyoub 2023): white light is lost where a microfacet
//! sends it to others.

/// What a white mirror loses, and what it reflects of Schlick's `(1 - cos)^5`.
#[derive(Clone, Copy)]
pub struct Loss {
    pub lost: f64,
    pub grazing: f64,
}

/// Goes through visible microfacets: `f(weight, cosine to the viewer, z of the normal)`; weights add up to 1.
fn for_each_facet(cosine: f64, alpha: f64, steps: [usize; 2], mut f: impl FnMut(f64, f64, f64)) {
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let length = (alpha * sine).hypot(cosine);
    let (x, z) = (alpha * sine / length, cosine / length);
    for i in 0..steps[0] {
        // Smooth steps: many at the edge of the cap, where the few facets are that stand far off the mean.
        let s = (i as f64 + 0.5) / steps[0] as f64;
        let u = s * s * (3.0 - 2.0 * s);
        let weight = 6.0 * s * (1.0 - s) / (steps[0] * steps[1]) as f64;
        let cap = (1.0 - u) * (1.0 + z) - z;
        let ring = (1.0 - cap * cap).max(0.0).sqrt();
        for j in 0..steps[1] {
            // By symmetry half a turn is enough.
            let angle = (j as f64 + 0.5) / steps[1] as f64 * std::f64::consts::PI;
            let h = [alpha * (ring * angle.cos() + x), alpha * ring * angle.sin(), (cap + z).max(0.0)];
            let scale = 1.0 / (h[0] * h[0] + h[1] * h[1] + h[2] * h[2]).sqrt();
            let to_viewer = ((h[0] * sine + h[2] * cosine) * scale).clamp(0.0, 1.0);
            f(weight, to_viewer, h[2] * scale);
        }
    }
}

/// `G2 / G1`: the part of the light that a visible microfacet sends at a cosine that leaves the surface.
fn escaping(to_viewer: f64, to_light: f64, alpha: f64) -> f64 {
    if to_light <= 0.0 {
        return 0.0;
    }
    let slant = |cosine: f64| (alpha * alpha + (1.0 - alpha * alpha) * cosine * cosine).sqrt();
    let (viewer, light) = (slant(to_viewer), slant(to_light));
    to_light * (to_viewer + viewer) / (to_viewer * light + to_light * viewer)
}

pub fn mirror_loss(cosine: f64, alpha: f64) -> Loss {
    let mut sum = Loss { lost: 1.0, grazing: 0.0 };
    for_each_facet(cosine, alpha, [256, 96], |weight, to_viewer, z| {
        let kept = weight * escaping(cosine, 2.0 * to_viewer * z - cosine, alpha);
        sum.lost -= kept;
        sum.grazing += kept * (1.0 - to_viewer).powi(5);
    });
    Loss { lost: sum.lost.max(0.0), ..sum }
}

/// What glass loses, and what of that a white mirror would lose; `eta` is the index beyond over that on the viewer's side.
pub fn glass_loss(cosine: f64, alpha: f64, eta: f64, steps: [usize; 2]) -> [f64; 2] {
    let mut lost = [1.0, 1.0];
    for_each_facet(cosine, alpha, steps, |weight, to_viewer, z| {
        let beyond = 1.0 - (1.0 - to_viewer * to_viewer) / (eta * eta);
        let reflected = escaping(cosine, 2.0 * to_viewer * z - cosine, alpha);
        lost[1] -= weight * reflected;
        if beyond <= 0.0 {
            lost[0] -= weight * reflected;
            return;
        }
        let beyond = beyond.sqrt();
        let s = (to_viewer - eta * beyond) / (to_viewer + eta * beyond);
        let p = (eta * to_viewer - beyond) / (eta * to_viewer + beyond);
        let reflectance = 0.5 * (s * s + p * p);
        // The light's cosine below the surface.
        let refracted = escaping(cosine, cosine / eta - (to_viewer / eta - beyond) * z, alpha);
        lost[0] -= weight * (reflectance * reflected + (1.0 - reflectance) * refracted);
    });
    lost.map(|lost| lost.max(0.0))
}
