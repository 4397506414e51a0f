//! Measures closest hits and any hits of the peers' ray sets on a GPU, and compares each with the CPU's: development
//! only, `eosphor bench rays` is for users. `ray_bench SCENE eye_x,y,z at_x,y,z FOV_Y_DEGREES [WIDTH HEIGHT REPEATS]`
use eosphor_core::math::{Vec3, vec3};
use eosphor_cuda::CudaRays;
use eosphor_render::{Accel, Builder, CpuBackend, CpuOptions, Hierarchy, RaySets};
use eosphor_scene::{Camera, LoadOptions, SceneData, load};

fn triple(text: &str) -> Vec3 {
    let v: Vec<f32> = text.split(',').map(|x| x.parse().expect("a number")).collect();
    vec3(v[0], v[1], v[2])
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let a: Vec<String> = std::env::args().collect();
    let number = |k: usize, usual: f64| a.get(k).map_or(usual, |x| x.parse().expect("a number"));
    let (eye, at) = (triple(&a[2]), triple(&a[3]));
    let (width, height, repeats) =
        (number(5, 3840.0) as u32, number(6, 2160.0) as u32, number(7, 30.0) as usize);
    let mut scene = load(&a[1], &LoadOptions::default())?.scene;
    scene.settings.size = [width, height];
    scene.camera = Some(Camera {
        position: eye,
        look_at: Some(at),
        fov_y_degrees: Some(number(4, 40.0) as f32),
        ..Camera::default()
    });
    let data = SceneData::flatten(&scene)?.0;
    let cpu = CpuBackend::new(CpuOptions::default())?;
    let fast = Hierarchy::build(Accel::Bvh8, Builder::Binned, &data);
    let Hierarchy::Bvh(bvh) = Hierarchy::build(Accel::Bvh, Builder::Binned, &data) else { unreachable!() };
    let sets = RaySets::new(&data, |rays| cpu.closest_hits(&fast, rays));
    let gpu = CudaRays::new(0, &bvh)?;
    println!(
        "{}: {} triangles, {} nodes, {}",
        a[1],
        data.triangles.len(),
        bvh.nodes.len(),
        gpu.device_name()
    );
    for (name, rays) in [("primary", &sets.primary), ("bounce", &sets.bounce), ("shuffled", &sets.shuffled)] {
        let expected = cpu.closest_hits(&fast, rays);
        let timed = gpu.closest_hits(rays, repeats)?;
        let bits = |h: &eosphor_core::ray::Hit| (h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.id);
        let wrong = expected.iter().zip(&timed.answers).filter(|(a, b)| bits(a) != bits(b)).count();
        report(name, "closest", rays.len(), timed.milliseconds, wrong);
        let expected = cpu.occluded_rays(&fast, rays);
        let timed = gpu.occluded(rays, repeats)?;
        let wrong = expected.iter().zip(&timed.answers).filter(|(a, b)| a != b).count();
        report(name, "any", rays.len(), timed.milliseconds, wrong);
    }
    Ok(())
}

fn report(set: &str, query: &str, rays: usize, mut ms: Vec<f32>, wrong: usize) {
    ms.sort_by(f32::total_cmp);
    let median = ms[ms.len() / 2];
    println!(
        "{set:9} {query:8} {rays:8} rays {median:7.3} ms  {:7.2} Grays/s  (min {:.3}) {wrong} differ",
        rays as f64 / median as f64 * 1e-6,
        ms[0]
    );
}
