//! Vertices, vectors and rays in the form in which other programs have them.

use bytemuck::TransparentWrapper;
use eosphor_accel::{
    Affine, BatchTracer, Bvh8, Coherence, Filters, FromGlam, Hit, PrimitiveId, Raw, Ray, RayFilter,
    SceneError, Sphere, ToGlam, Vec3, vec3,
};

const POSITIONS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
const FACES: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

#[test]
fn vertices_of_any_type_make_the_same_tree() {
    let expected = Bvh8::from_mesh(&POSITIONS, &FACES).unwrap();
    let same = |bvh: Bvh8| bvh.blocks() == expected.blocks() && bvh.nodes() == expected.nodes();
    let with_normals: Vec<[f32; 6]> = POSITIONS.map(|[x, y, z]| [x, y, z, 0.0, 0.0, 1.0]).to_vec();
    assert!(same(Bvh8::from_vertices(&with_normals, |v| [v[0], v[1], v[2]], &FACES).unwrap()));
    let of_glam = POSITIONS.map(glam::Vec3::from_array);
    assert!(same(Bvh8::from_vertices(&of_glam, |v| v.to_array(), &FACES).unwrap()));
    let flat = POSITIONS.as_flattened();
    assert!(same(Bvh8::from_mesh(bytemuck::cast_slice(flat), &FACES).unwrap()));
    let missing = Bvh8::from_vertices(&of_glam, |v| v.to_array(), &[[0, 1, 2], [0, 1, 4]]);
    assert_eq!(missing.err(), Some(SceneError::Face(1)));
}

#[test]
fn numbers_of_glam_stay_as_they_are() {
    let v = glam::vec3(1.5, -0.0, f32::MIN_POSITIVE);
    assert_eq!(Vec3::from_glam(v), vec3(v.x, v.y, v.z));
    assert_eq!(
        Vec3::from_glam(v.to_vec3a()).to_glam().to_array().map(f32::to_bits),
        v.to_array().map(f32::to_bits)
    );

    let axis = glam::vec3(1.0, 2.0, 3.0).normalize();
    let (scale, turn) = (glam::vec3(2.0, 3.0, 4.0), glam::Quat::from_axis_angle(axis, 0.7));
    let map = glam::Affine3A::from_scale_rotation_translation(scale, turn, glam::vec3(5.0, 6.0, 7.0));
    let ours = Affine::from_glam(map);
    assert_eq!(ours.to_glam(), map);
    let point = glam::vec3(0.3, -0.4, 0.5);
    let moved = ours.point(Vec3::from_glam(point)).to_glam();
    assert!((moved - map.transform_point3(point)).length() < 1e-5);
}

#[test]
fn rays_and_hits_are_plain_numbers() {
    let ray = Ray { origin: vec3(0.25, 0.5, 2.0), t_min: 0.125, direction: vec3(0.0, 0.0, -1.0), t_max: 9.0 };
    let expected = [0.25, 0.5, 2.0, 0.125, 0.0, 0.0, -1.0, 9.0];
    let mut rays = vec![ray; 3];
    let floats: &[f32] = bytemuck::cast_slice(Raw::wrap_slice(&rays));
    assert_eq!(floats, [expected; 3].as_flattened());
    let floats: &mut [f32] = bytemuck::cast_slice_mut(Raw::wrap_slice_mut(&mut rays));
    floats[16] = 40.0;

    let bvh = Bvh8::from_mesh(&POSITIONS, &FACES).unwrap();
    let mut hits = vec![Raw(Hit::miss(0.0)); 3];
    let everything = Filters::Shared(&RayFilter::ALL);
    bvh.tracer().closest_hits(&rays, everything, Coherence::Auto, Raw::peel_slice_mut(&mut hits));
    let words: &[[u32; 6]] = bytemuck::cast_slice(&hits);
    let [t, _, u, v, instance, primitive] = words[0];
    assert_eq!([t, u, v].map(f32::from_bits), [2.0, 0.25, 0.25]);
    assert_eq!([instance, primitive], [0, 1]);
    assert!(hits[2].0.is_miss() && words[2][5] == PrimitiveId::NONE.primitive);

    let sphere: Sphere = Raw::peel(bytemuck::cast([1.0f32, 2.0, 3.0, 0.5]));
    assert_eq!((sphere.center, sphere.radius), (vec3(1.0, 2.0, 3.0), 0.5));
    let map: [f32; 12] = bytemuck::cast(Raw(Affine::IDENTITY));
    assert_eq!(map, [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
}

#[test]
fn rays_that_are_not_aligned_are_refused() {
    let floats = [Raw(Ray::new(Vec3::ZERO, Vec3::ONE)); 2];
    let floats: &[f32] = bytemuck::cast_slice(&floats);
    assert!(bytemuck::try_cast_slice::<f32, Raw<Ray>>(&floats[..8]).is_ok());
    assert!(bytemuck::try_cast_slice::<f32, Raw<Ray>>(&floats[4..12]).is_ok());
    assert!(bytemuck::try_cast_slice::<f32, Raw<Ray>>(&floats[1..9]).is_err());
}
