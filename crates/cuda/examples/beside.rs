//! How fast our search for closest hits is beside a kernel of another compiler, on the same tree and rays.
//!
//! ```text
//! beside KERNEL.ptx FUNCTION SCENE EYE LOOK_AT FOV WIDTHxHEIGHT [BUILDER]
//! ```
//!
//! The function is called as `f(nodes, triangles, rays, hits, count)` with blocks of 128 threads, a ray a thread: nodes of 64
//! bytes as in Aila and Laine 2009 (x and y of the first child's box as min, max, min, max; those of the second one's; z of
//! both; two links), where a link is the number of a node or, with the highest bit, triangles less one in bits 27 to 30 and the
//! first one below; triangles of 48 bytes (corner, two edges, a float of anything after each); rays of 32 (origin, t_min,
//! direction, t_max); hits of 16 (t, triangle, u, v). The two take turns; it prints medians in milliseconds.

use cudarc::driver::sys::CUevent_flags;
use cudarc::driver::{CudaContext, LaunchConfig, PushKernelArg};
use cudarc::nvrtc::Ptx;
use eosphor_accel::{BatchTracer, Builder, Bvh, Coherence, Filters, OneByOne};
use eosphor_core::hierarchy::{BvhNode, IgnoreWork};
use eosphor_core::math::vec3;
use eosphor_core::ray::{Hit, Ray, RayFilter};
use eosphor_cuda::{CudaRays, Traversal};
use eosphor_render::{Accel, Hierarchy, HierarchyOptions, RaySets, build_hierarchy};
use eosphor_scene::{LoadOptions, SceneData, load};
use std::error::Error;

const ROUNDS: usize = 30;
const THREADS: u32 = 128;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [ptx, function, scene, eye, look_at, fov, size, rest @ ..] = &arguments[..] else {
        return Err("beside KERNEL.ptx FUNCTION SCENE EYE LOOK_AT FOV WIDTHxHEIGHT [BUILDER]".into());
    };
    let builder = match rest.first().map(String::as_str) {
        None | Some("binned") => Builder::Binned,
        Some("sweep") => Builder::Sweep,
        Some("spatial") => Builder::Spatial,
        Some(other) => return Err(format!("no builder {other}: binned, sweep or spatial").into()),
    };
    let mut scene = load(scene, &LoadOptions::default())?.scene;
    let (width, height) = size.split_once('x').ok_or("the size is WIDTHxHEIGHT")?;
    scene.settings.size = [width.parse()?, height.parse()?];
    let mut camera = scene.camera.unwrap_or_default();
    camera.position = point(eye)?;
    camera.look_at = Some(point(look_at)?);
    (camera.fov_x_degrees, camera.fov_y_degrees) = (fov.parse()?, None);
    scene.camera = Some(camera);
    let (data, _) = SceneData::flatten(&scene)?;

    let Hierarchy::Bvh(bvh) = build_hierarchy(Accel::Bvh, &HierarchyOptions::with_builder(builder), &data)?
    else {
        unreachable!("asked for")
    };
    let tracer = OneByOne(bvh.tracer(IgnoreWork));
    let sets = RaySets::new(&data, |rays| {
        let mut hits = vec![Hit::miss(0.0); rays.len()];
        tracer.closest_hits(rays, Filters::Shared(&RayFilter::ALL), Coherence::Auto, &mut hits);
        hits
    });
    let ours = CudaRays::new(0, &bvh, Traversal::Auto)?;
    let theirs = Theirs::new(&std::fs::read_to_string(ptx)?, function, &bvh)?;
    println!("{}; {} triangles, {builder}", ours.device_name(), bvh.primitives().triangles().len());
    println!("{:9} {:>10} {:>9} {:>9} {:>7}", "rays", "number", "ours", "theirs", "ratio");
    for (name, rays) in [("primary", &sets.primary), ("bounce", &sets.bounce), ("shuffled", &sets.shuffled)] {
        let (mut our_times, mut their_times) = (Vec::new(), Vec::new());
        for _ in 0..ROUNDS {
            our_times.extend(ours.closest_hits(rays, 1)?.milliseconds);
            their_times.push(theirs.closest_hits(rays)?);
        }
        let (our_time, their_time) = (median(our_times), median(their_times));
        let ratio = their_time / our_time;
        println!("{name:9} {:>10} {our_time:9.3} {their_time:9.3} {ratio:7.3}", rays.len());
    }
    Ok(())
}

fn point(text: &str) -> Result<eosphor_core::math::Vec3, Box<dyn Error>> {
    let numbers: Vec<f32> = text.split(',').map(str::parse).collect::<Result<_, _>>()?;
    let [x, y, z] = numbers[..] else { return Err(format!("{text} is not X,Y,Z").into()) };
    Ok(vec3(x, y, z))
}

fn median(mut times: Vec<f32>) -> f32 {
    times.sort_by(f32::total_cmp);
    times[times.len() / 2]
}

/// The other kernel, and what it reads.
struct Theirs {
    stream: std::sync::Arc<cudarc::driver::CudaStream>,
    function: cudarc::driver::CudaFunction,
    nodes: cudarc::driver::CudaSlice<u32>,
    triangles: cudarc::driver::CudaSlice<u32>,
}

impl Theirs {
    fn new(ptx: &str, function: &str, bvh: &Bvh) -> Result<Theirs, Box<dyn Error>> {
        let context = CudaContext::new(0)?;
        let stream = context.default_stream();
        let function = context.load_module(Ptx::from_src(ptx))?.load_function(function)?;
        let triangles: Vec<u32> = bvh
            .primitives()
            .triangles()
            .iter()
            .flat_map(|t| {
                let (e1, e2) = (t.e1(), t.e2());
                let corner = [t.v0.x, t.v0.y, t.v0.z, 0.0, e1.x, e1.y, e1.z, 0.0];
                corner.into_iter().chain([e2.x, e2.y, e2.z, 0.0]).map(f32::to_bits).collect::<Vec<_>>()
            })
            .collect();
        let (nodes, triangles) = (stream.clone_htod(&aila_laine(bvh))?, stream.clone_htod(&triangles)?);
        Ok(Theirs { stream, function, nodes, triangles })
    }

    /// Milliseconds, after once to warm up.
    fn closest_hits(&self, rays: &[Ray]) -> Result<f32, Box<dyn Error>> {
        let number = |r: &Ray| {
            let (o, d) = (r.origin, r.direction);
            [o.x, o.y, o.z, r.t_min, d.x, d.y, d.z, r.t_max]
        };
        let numbers: Vec<f32> = rays.iter().flat_map(number).collect();
        let rays_there = self.stream.clone_htod(&numbers)?;
        let mut hits = self.stream.alloc_zeros::<u32>(4 * rays.len())?;
        let count = rays.len() as u32;
        let shape = LaunchConfig {
            grid_dim: (count.div_ceil(THREADS), 1, 1),
            block_dim: (THREADS, 1, 1),
            shared_mem_bytes: 0,
        };
        let mut time = 0.0;
        for _ in 0..2 {
            let mut launch = self.stream.launch_builder(&self.function);
            launch.arg(&self.nodes).arg(&self.triangles).arg(&rays_there).arg(&mut hits).arg(&count);
            let start = self.stream.record_event(Some(CUevent_flags::CU_EVENT_DEFAULT))?;
            // SAFETY: the arguments are those of the kernel; arrays are as long as it takes them to be.
            unsafe { launch.launch(shape) }?;
            let end = self.stream.record_event(Some(CUevent_flags::CU_EVENT_DEFAULT))?;
            time = start.elapsed_ms(&end)?;
        }
        Ok(time)
    }
}

/// The world's tree with the boxes of two children in a node, in the order of its pairs of nodes.
fn aila_laine(bvh: &Bvh) -> Vec<u32> {
    let root = bvh.roots()[0];
    assert!(bvh.nodes()[root as usize].is_inner(), "a tree of one leaf");
    let mut out: Vec<u32> = Vec::new();
    // Nodes to be written, and where their number goes.
    let mut waiting = vec![(bvh.nodes()[root as usize], None::<usize>)];
    while let Some((node, from)) = waiting.pop() {
        let here = out.len();
        if let Some(from) = from {
            out[from] = here as u32 / 16;
        }
        let [a, b] = [0, 1].map(|k| bvh.nodes()[(node.first + k) as usize]);
        let plane = |n: &BvhNode| [n.min.x, n.max.x, n.min.y, n.max.y].map(f32::to_bits);
        out.extend(plane(&a));
        out.extend(plane(&b));
        out.extend([a.min.z, a.max.z, b.min.z, b.max.z].map(f32::to_bits));
        out.extend([0; 4]);
        for (k, child) in [b, a].into_iter().enumerate() {
            let place = here + 12 + (1 - k);
            if child.is_inner() {
                waiting.push((child, Some(place)));
            } else {
                assert!((1..=16).contains(&child.count), "leaves of up to 16 triangles");
                out[place] = 1 << 31 | (child.count - 1) << 27 | child.first;
            }
        }
    }
    out
}
