//! Light at a point in three steps, as GPUs take it by queues: the bits of `direct_light`.

use crate::surfaces;
use eosphor_core::hierarchy::{ExhaustiveTracer, IgnoreWork, Tracer};
use eosphor_core::integrator::whitted::{
    LampLobe, LightProgress, LightSample, LitPoint, add_light, branches_at, depth_limit, direct_light,
    ends_at, light_query, light_ray, light_rays_of_point, ray_behind, takes_light,
};
use eosphor_core::integrator::{MAX_DEPTH, camera_ray, transmittance};
use eosphor_core::math::Vec3;
use eosphor_core::settings::{Integrator, ShadowMode};
use eosphor_core::shading::SurfacePoint;
use eosphor_render::{Accel, Hierarchy, HierarchyOptions, build_hierarchy};
use eosphor_scene::{LightSelection, LoadOptions, Scene, SceneData, load};

/// Lights points that a camera sees, in windows of so many rays, and compares. Gives back how many there were, how many had light
/// on their far side, and on how many rays end whatever they are.
fn assert_same_light(scene: &Scene, window: u32) -> [u32; 3] {
    let data = SceneData::flatten(scene).unwrap().0;
    let view = data.view();
    let hierarchy = build_hierarchy(Accel::None, &HierarchyOptions::default(), &data).unwrap();
    let Hierarchy::Exhaustive(exhaustive) = &hierarchy else { unreachable!() };
    // SAFETY: the arrays are those of a SceneData, and go with each other.
    let tracer = unsafe { ExhaustiveTracer::new(exhaustive.primitives().view(), IgnoreWork) };
    let all = light_rays_of_point(view.lights, !view.light_nodes.is_empty(), view.settings);
    let mut points = [0; 3];
    for (x, y) in (0..view.settings.height).flat_map(|y| (0..view.settings.width).map(move |x| (x, y))) {
        let sample = (x + y) % 3;
        let ray = camera_ray(&view, x, y, sample);
        let hit = tracer.closest_hit(&ray.ray(), &ray.filter(view.settings));
        if hit.is_miss() {
            continue;
        }
        let point = SurfacePoint::new(&view, &ray.ray(), &hit);
        if ends_at(&view, &hit) {
            assert_eq!((branches_at(&point, 0, MAX_DEPTH), point.coverage), (0, 1.0), "{:?}", hit.id);
            assert!(ray_behind(&view, &point, &ray, hit.t).is_none());
            points[2] += 1;
        }
        let lobe = LampLobe::new(&view, &point, &ray, depth_limit(view.settings));
        if !takes_light(&point, &lobe) {
            continue;
        }
        let (point, at) = (LitPoint::new(&point, &lobe), (x, y, sample));
        let mut shadow_rays = 0;
        let expected = direct_light::<_, 1>(&view, &tracer, &point, ray.path, at, &mut shadow_rays);

        let rays: Vec<_> = (0..all).map(|number| light_ray(&view, &point, ray.path, at, number)).collect();
        if view.settings.shadow_mode != ShadowMode::None {
            assert_eq!(rays.iter().flatten().count() as u64, shadow_rays, "{at:?}");
        }
        let brought = |number: u32| {
            let nothing = LightSample { light: None, through: Vec3::ONE, diffuse: 0.0, specular: 0.0 };
            let Some(ray) = rays[number as usize] else { return nothing };
            let from = (point.position, point.offset, point.geometric_normal);
            let (light, direction) = ((ray.light, ray.side), (ray.direction, ray.t_max));
            let (query, filter) = light_query(&view, from, point.id, light, direction).unwrap();
            let light = Some(ray.light);
            let seen = LightSample { light, diffuse: ray.diffuse, specular: ray.specular, ..nothing };
            match view.settings.shadow_mode {
                ShadowMode::None => seen,
                // As devices note it.
                ShadowMode::Opaque if tracer.occluded(&query, &filter) => LightSample { light, ..nothing },
                ShadowMode::Opaque => seen,
                ShadowMode::Coloured => {
                    LightSample { through: transmittance(&view, &tracer, &query, &filter), ..seen }
                }
            }
        };
        let mut progress = LightProgress::default();
        for first in (0..all).step_by(window as usize) {
            let end = (first + window).min(all);
            add_light(&view, &point, (first, end), &mut progress, brought);
        }
        let bits = |v: Vec3| [v.x, v.y, v.z].map(f32::to_bits);
        assert_eq!(bits(progress.sum), bits(expected), "{at:?}, by {window}");
        points[0] += 1;
        points[1] += u32::from(rays.iter().flatten().any(|ray| ray.side == 1));
    }
    points
}

#[test]
fn light_in_steps_is_the_light_of_one_loop() {
    let load = |name: &str| load(name, &LoadOptions::default()).unwrap().scene;
    let scenes =
        [load("builtin:cornell-pg1"), load("builtin:glass"), surfaces::scene(), load("builtin:solids")];
    let mut all_ends = 0;
    for (number, scene) in scenes.into_iter().enumerate() {
        for (shadows, behind) in
            [(ShadowMode::None, true), (ShadowMode::Opaque, false), (ShadowMode::Coloured, true)]
        {
            let mut scene = scene.clone();
            scene.settings.size = [11, 7];
            (scene.settings.integrator, scene.settings.light_samples) = (Integrator::Whitted, 5);
            (scene.settings.shadows, scene.settings.light_from_behind) = (shadows, behind);
            for selection in [LightSelection::All, LightSelection::Tree] {
                scene.settings.lights = Some(selection);
                for window in [1, 3, 1000] {
                    let [points, behind, ends] = assert_same_light(&scene, window);
                    all_ends += ends;
                    assert!(points > 5, "scene {number}: {points}");
                    // Glass and panes are lit from behind.
                    assert!(number != 2 || shadows == ShadowMode::Opaque || behind > 0, "scene {number}");
                }
            }
        }
    }
    assert!(all_ends > 0);
}
