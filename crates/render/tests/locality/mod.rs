//! Locality: what no ray of a picture meets changes no bit of it, in no structure, however far and huge it is.
//!
//! `EOSPHOR_TEST_SCENES` asks for other than the usual number of random scenes.

mod far;
mod random_scene;

use eosphor_render::{Accel, Backend, CpuBackend, CpuOptions, Film, RenderControl, SimdLevel};
use eosphor_scene::{Camera, LoadOptions, Scene, SceneData, load};
use far::{Queries, Random, add_far_things};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

fn render(data: &Arc<SceneData>, options: CpuOptions) -> Film {
    let prepared = CpuBackend::new(options).unwrap().prepare(Arc::clone(data)).unwrap();
    let cancel = AtomicBool::new(false);
    let control = RenderControl { on_progress: &|_| {}, cancel: &cancel, count_work: false, frame: None };
    prepared.render(&control).unwrap().film
}

/// Every structure, and the fastest at every SIMD level.
fn ways() -> Vec<CpuOptions> {
    let base = CpuOptions { threads: Some(2), ..CpuOptions::default() };
    let structures = Accel::ALL.iter().map(|&accel| CpuOptions { accel, ..base });
    let levels =
        SimdLevel::available().map(|simd| CpuOptions { accel: Accel::Bvh8, simd: Some(simd), ..base });
    structures.chain(levels).collect()
}

/// How many pixels differ in any bit.
fn different(a: &Film, b: &Film) -> usize {
    let bits =
        |film: &Film| film.pixels.iter().map(|p| [p.x, p.y, p.z].map(f32::to_bits)).collect::<Vec<_>>();
    bits(a).iter().zip(&bits(b)).filter(|(a, b)| a != b).count()
}

/// Says what is wrong with the pictures of a scene to which things were added, `times` its extent away.
fn check(name: &str, scene: &Scene, times: f32, random: &mut Random) -> Option<String> {
    let data = Arc::new(SceneData::flatten(scene).unwrap().0);
    let queries = Queries::of(&data);
    let Some(extended) = add_far_things(scene, &queries, data.world_bounds().extent(), times, random) else {
        return Some(format!("{name}, {times:e}: {} queries leave no room", queries.count()));
    };
    let ways = ways();
    let reference = render(&data, ways[1]);
    let more = Arc::new(SceneData::flatten(&extended.scene).unwrap().0);
    let met = Queries::of(&more).met(&extended.balls);
    let mut wrong: Vec<String> = ways
        .iter()
        .map(|way| (way, different(&render(&more, *way), &reference)))
        .filter(|(_, count)| *count > 0)
        .map(|(way, count)| format!("{}: {count} pixels", way.accel))
        .collect();
    if met > 0 {
        wrong.push(format!("{met} of its queries meet what none met before"));
    }
    let largest = extended.balls.iter().fold(0.0f32, |r, b| r.max(b.radius)) / data.world_bounds().extent();
    println!("{name}, {times:e} extents away, {largest:e} large: {} queries, {wrong:?}", queries.count());
    (!wrong.is_empty()).then(|| format!("{name}, {times:e}: {wrong:?}"))
}

/// Distances that are tried, in extents.
const TIMES: [f32; 5] = [1e1, 1e2, 1e4, 1e6, 1e7];

#[test]
fn far_things_change_no_bit_of_the_cornell_box() {
    let mut scene = load("builtin:cornell", &LoadOptions::default()).unwrap().scene;
    scene.settings.size = [20, 15];
    scene.settings.light_samples = 1;
    // The camera must not depend on what there is; nor may the distance that nothing was said about.
    scene.camera.get_or_insert_with(Camera::default);
    scene.settings.max_distance = Some(3.0);
    let mut random = Random(5);
    let failed: Vec<_> =
        [1e1, 1e7].into_iter().filter_map(|times| check("cornell", &scene, times, &mut random)).collect();
    assert!(failed.is_empty(), "{failed:#?}");
}

#[test]
fn far_things_change_no_bit_of_random_scenes() {
    let count = std::env::var("EOSPHOR_TEST_SCENES").map_or(10, |n| n.parse().expect("a number of scenes"));
    let failed: Vec<_> = (0..count)
        .filter_map(|seed| {
            let mut random = Random(seed);
            let scene = random_scene::random_scene(&mut random);
            check(&format!("random scene {seed}"), &scene, TIMES[seed as usize % TIMES.len()], &mut random)
        })
        .collect();
    assert!(failed.is_empty(), "{} of {count}: {failed:#?}", failed.len());
}
