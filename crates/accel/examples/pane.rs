//! What the README says: a square placed twice, as the ground and as a pane of glass, and rays that see it or see through it.
//!
//! `cargo run --release -p eosphor-accel --example pane`

use eosphor_accel::{Affine, BuildOptions, Bvh8, Ray, RayFilter, Scene, SceneError, Tracer, indexed, vec3};

fn main() -> Result<(), SceneError> {
    let corners = [vec3(-1.0, -1.0, 0.0), vec3(1.0, -1.0, 0.0), vec3(1.0, 1.0, 0.0), vec3(-1.0, 1.0, 0.0)];
    let mut scene = Scene::default();
    let square = scene.mesh(&indexed(&corners, &[[0, 1, 2], [0, 2, 3]])?, &[])?;
    let ground = scene.place(square, Affine::IDENTITY)?;
    let pane = scene.place(square, Affine { translation: vec3(0.0, 0.0, 1.0), ..Affine::IDENTITY })?;
    scene.set_mask(ground, 0b01)?;
    scene.set_mask(pane, 0b10)?;
    let bvh = Bvh8::build(&scene.geometry(), &BuildOptions::default());

    let down = Ray::new(vec3(0.5, 0.25, 5.0), vec3(0.0, 0.0, -1.0));
    let hit = bvh.closest_hit(&down).expect("the pane is in the way");
    println!("instance {}, triangle {}, {} away", hit.id.instance, hit.id.primitive, hit.t);
    println!("point {:?}, normal {:?}", hit.point(&down), scene.normal(&down, &hit));

    let behind =
        bvh.closest_hit_where(&down, |hit| hit.id.instance != pane).expect("the ground is behind it");
    println!("behind the pane: instance {}, {} away", behind.id.instance, behind.t);
    let up = Ray::new(behind.point(&down) + vec3(0.0, 0.0, 1e-3), vec3(0.0, 0.0, 1.0));
    let opaque = bvh.tracer().with_masks(scene.masks(), 0b01);
    println!(
        "in the shade: {}, but the pane is clear: {}",
        bvh.occluded(&up),
        !opaque.occluded(&up, &RayFilter::ALL)
    );
    Ok(())
}
