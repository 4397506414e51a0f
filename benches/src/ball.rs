//! A bumpy ball, and rays around it.

use eosphor_accel::{Ray, Scene, Vec3, vec3};

/// Squares along an edge of the cube that the ball is blown up from.
const SIDE: u32 = 24;

/// Camera rays along a side of their picture; they come in blocks, as tiles of a picture have them.
const PICTURE: u32 = 48;
const BLOCK: u32 = 8;

/// Triangles of the ball: 6912.
pub(crate) fn triangles() -> Vec<[Vec3; 3]> {
    let mut triangles = Vec::new();
    for face in 0..6 {
        for (i, j) in (0..SIDE).flat_map(|i| (0..SIDE).map(move |j| (i, j))) {
            let [a, b, c, d] =
                [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| vertex(face, i, j));
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    triangles
}

/// The ball as a scene of its own.
pub(crate) fn scene() -> Scene {
    Scene::new(&triangles(), &[]).expect("the ball is small")
}

/// A point of the cube's face, moved onto the ball. Neighbours on two faces are the same point: bumps follow from the place.
fn vertex(face: u32, i: u32, j: u32) -> Vec3 {
    let [u, v] = [i, j].map(|k| 2.0 * k as f32 / SIDE as f32 - 1.0);
    let side = if face.is_multiple_of(2) { 1.0 } else { -1.0 };
    let on_cube = match face / 2 {
        0 => vec3(side, u, v),
        1 => vec3(v, side, u),
        _ => vec3(u, v, side),
    };
    let cell = [on_cube.x, on_cube.y, on_cube.z].map(|x| ((x + 1.0) * 64.0) as u64);
    let bump = Random(cell[0] << 40 | cell[1] << 20 | cell[2]).unit();
    on_cube.normalize() * (1.0 + 0.08 * bump)
}

/// Rays from one place through the pixels of a picture, block after block. Most meet the ball.
pub(crate) fn camera_rays() -> Vec<Ray> {
    let eye = vec3(0.7, 1.1, 3.0);
    let (right, up, forward) = (vec3(1.0, 0.0, -0.2), vec3(0.0, 1.0, -0.35), vec3(-0.2, -0.35, -1.0));
    let blocks = PICTURE / BLOCK;
    let corners = (0..blocks).flat_map(|y| (0..blocks).map(move |x| (x * BLOCK, y * BLOCK)));
    let pixels = corners.flat_map(|(x, y)| (0..BLOCK * BLOCK).map(move |k| (x + k % BLOCK, y + k / BLOCK)));
    let ray = |(x, y): (u32, u32)| {
        let [u, v] = [x, y].map(|k| 0.7 * ((k as f32 + 0.5) / PICTURE as f32 - 0.5));
        Ray::new(eye, (forward + right * u + up * v).normalize())
    };
    pixels.map(ray).collect()
}

/// Rays from anywhere around the ball to anywhere in the box around it.
pub(crate) fn scattered_rays() -> Vec<Ray> {
    let mut random = Random(1);
    let ray = |_| {
        let (from, to) = (random.in_cube().normalize() * 2.0, random.in_cube());
        Ray::new(from, (to - from).normalize())
    };
    (0..1500).map(ray).collect()
}

/// SplitMix64 (Steele et al. 2014).
struct Random(u64);

impl Random {
    /// In [0, 1).
    fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1 << 24) as f32
    }

    /// In [-1, 1) on every axis.
    fn in_cube(&mut self) -> Vec3 {
        let mut part = || 2.0 * self.unit() - 1.0;
        vec3(part(), part(), part())
    }
}
