//! What do rays meet first? A triangle soup, a hierarchy, a batch of rays, and a picture of letters.
//!
//! `cargo run --release -p eosphor-accel --example closest_hit`

use eosphor_accel::{
    BatchTracer, BuildOptions, Bvh8, Coherence, Filters, Hit, Ray, RayFilter, Scene, SceneError, Sphere, vec3,
};

const WIDTH: usize = 64;
const HEIGHT: usize = 28;

fn main() -> Result<(), SceneError> {
    // A pyramid without a floor, and a ball beside it. Any triangles will do, in any order.
    let (top, y) = (vec3(0.0, 2.0, 0.0), 0.0);
    let corners = [vec3(-1.0, y, 1.0), vec3(1.0, y, 1.0), vec3(1.0, y, -1.0), vec3(-1.0, y, -1.0)];
    let soup: Vec<_> = (0..4).map(|k| [corners[k], corners[(k + 1) % 4], top]).collect();
    let ball = Sphere { center: vec3(1.8, 0.7, 0.0), radius: 0.7 };

    let scene = Scene::new(&soup, &[ball])?;
    let bvh = Bvh8::build(&scene.geometry(), &BuildOptions::default());

    // Parallel rays along -z, row by row from the top.
    let ray = |k: usize| {
        let (x, y) = ((k % WIDTH) as f32 / WIDTH as f32, (k / WIDTH) as f32 / HEIGHT as f32);
        Ray::new(vec3(-1.5 + 4.5 * x, 2.2 - 2.4 * y, 10.0), vec3(0.0, 0.0, -1.0))
    };
    let rays: Vec<Ray> = (0..WIDTH * HEIGHT).map(ray).collect();

    // The tracer takes the widest SIMD instructions that the processor has. Neighbours in the batch go nearly the same
    // way, which is said to it; whatever is said, the hits are the same.
    let mut hits = vec![Hit::miss(f32::INFINITY); rays.len()];
    let everything = Filters::Shared(&RayFilter::ALL);
    bvh.tracer().closest_hits(&rays, everything, Coherence::Coherent, &mut hits);

    for row in hits.chunks(WIDTH) {
        // Triangles are numbered as they were given, spheres after them.
        let letter = |hit: &Hit| match hit.id.primitive {
            _ if hit.is_miss() => ' ',
            4 => 'o',
            triangle => char::from(b'a' + triangle as u8),
        };
        println!("{}", row.iter().map(letter).collect::<String>().trim_end());
    }
    let middle = hits[HEIGHT / 2 * WIDTH + 20];
    println!("triangle {} at t = {}, weights {:?}", middle.id.primitive, middle.t, scene.weights(&middle));
    Ok(())
}
