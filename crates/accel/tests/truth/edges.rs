//! No ray is lost between the triangles of a closed mesh, where its exact line meets an edge or a vertex.

use crate::dyadic::Mesh;
use crate::random::{Random, rays};
use crate::shapes::{blade, cube, icosphere, torus};
use eosphor_accel::{BuildOptions, Bvh, Bvh8, IgnoreWork, Ray, RayFilter, Scene, Tracer};
use rayon::prelude::*;

/// What became of rays.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Fates {
    rays: u64,
    /// They hit nothing.
    missed: u64,
    /// They hit what their line does not meet, or meets from behind: the mesh's inside.
    elsewhere: u64,
    /// A query for any hit, or one for the next, says otherwise.
    denied: u64,
    /// `t` is further from the truth than single precision explains.
    t_off: u64,
}

impl Fates {
    fn plus(self, o: Fates) -> Fates {
        Fates {
            rays: self.rays + o.rays,
            missed: self.missed + o.missed,
            elsewhere: self.elsewhere + o.elsewhere,
            denied: self.denied + o.denied,
            t_off: self.t_off + o.t_off,
        }
    }

    fn of(mesh: &Mesh, scene: &Scene, tracer: &impl Tracer, random: &mut Random, far: bool) -> Fates {
        let Some(aimed) = mesh.aim(random, far) else { return Fates::default() };
        let hit = tracer.closest_hit(&aimed.ray, &RayFilter::ALL);
        let mut fates = Fates { rays: 1, ..Fates::default() };
        if hit.is_miss() {
            return Fates { missed: 1, ..fates };
        }
        let numbers = scene.corners(hit.id).map(|_| hit.id.primitive as usize);
        fates.elsewhere = u64::from(!numbers.is_some_and(|n| mesh.is_met(n, &aimed.ray)));
        let reach = [aimed.ray.origin, aimed.ray.direction * aimed.t].map(|v| v.abs().max_component());
        let slack = 4.0 * f32::EPSILON * (reach[0] + reach[1]) / aimed.ray.direction.length();
        let at_target = aimed.there.contains(&(hit.id.primitive as usize));
        fates.t_off = u64::from(hit.t > aimed.t + slack || (at_target && (hit.t - aimed.t).abs() > slack));
        // All of these ends lie behind the target.
        let ended = Ray { t_max: aimed.t + slack, ..aimed.ray };
        let next = tracer.next_hit(&ended, &RayFilter::ALL, &eosphor_accel::Hit::miss(f32::NEG_INFINITY));
        fates.denied = u64::from(!tracer.occluded(&ended, &RayFilter::ALL) || next.id != hit.id);
        fates
    }
}

fn trace(far: bool, usual: u64) {
    let shapes = [icosphere(2), torus(24, 12), cube(), blade().mapped(|p| [p[0], 16.0 * p[1], p[2]])];
    let mut failed = Vec::new();
    for shape in &shapes {
        let mesh = Mesh::new(shape);
        let scene = Scene::new(&mesh.corners(), &[]).unwrap();
        let (bvh, bvh8) = (
            Bvh::build(&scene.geometry(), &BuildOptions::default()),
            Bvh8::build(&scene.geometry(), &BuildOptions::default()),
        );
        let blocks = (rays(usual) / shapes.len() as u64).div_ceil(1024);
        let run = |block: u64| {
            let mut random = Random(block.wrapping_mul(0x2545_f491_4f6c_dd1d));
            let mut sums = [Fates::default(); 2];
            // Dice often give no ray.
            for _ in 0..1 << 20 {
                if sums[0].rays + sums[1].rays >= 1024 {
                    break;
                }
                let one = Fates::of(&mesh, &scene, &bvh.tracer(IgnoreWork), &mut random, far);
                let other = Fates::of(&mesh, &scene, &bvh8.tracer(), &mut random, far);
                sums = [sums[0].plus(one), sums[1].plus(other)];
            }
            sums
        };
        let add = |a: [Fates; 2], b: [Fates; 2]| [a[0].plus(b[0]), a[1].plus(b[1])];
        let found = (0..blocks).into_par_iter().map(run).reduce(Default::default, add);
        for (name, fates) in [("bvh", found[0]), ("bvh8", found[1])] {
            println!("{}, {name}: {fates:?}", mesh.name);
            assert!(fates.rays > 100 * blocks, "{}: {} rays", mesh.name, fates.rays);
            if fates != (Fates { rays: fates.rays, ..Fates::default() }) {
                failed.push(format!("{}, {name}: {fates:?}", mesh.name));
            }
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}

#[test]
fn no_ray_at_an_edge_or_vertex_is_lost_from_near() {
    trace(false, 100_000);
}

#[test]
fn no_ray_at_an_edge_or_vertex_is_lost_from_a_million_radii() {
    trace(true, 100_000);
}
