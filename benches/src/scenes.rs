//! Reading files, and flattening what is read.

use crate::{Case, ball};
use eosphor_accel::Vec3;
use eosphor_scene::{LoadOptions, Scene, SceneData, load, load_from_memory};
use std::fmt::Write;

/// The Cornell box, flattened.
pub struct Flatten(Scene);

impl Case for Flatten {
    const AT_LEAST: usize = 2188;

    fn new() -> Flatten {
        Flatten(load("builtin:cornell", &LoadOptions::default()).expect("it is built in").scene)
    }

    fn run(&self) -> usize {
        SceneData::flatten(&self.0).expect("the box is a scene").0.triangles.len()
    }
}

/// Triangles of a file in memory.
fn read(name: &str, bytes: &[u8]) -> usize {
    let files = vec![(name.into(), bytes.to_vec())];
    let loaded = load_from_memory(files, name, &LoadOptions::default()).expect("the file is right");
    loaded.scene.meshes.iter().map(|mesh| mesh.triangles.len()).sum()
}

/// Corners of all triangles, each a vertex of its own.
fn corners() -> Vec<Vec3> {
    ball::triangles().into_iter().flatten().collect()
}

/// An OBJ file of a megabyte, with texture coordinates and normals.
pub struct ReadObj(String);

impl Case for ReadObj {
    const AT_LEAST: usize = 6912;

    fn new() -> ReadObj {
        let mut text = String::from("# a bumpy ball\no ball\n");
        for corner in corners() {
            let (p, n) = (corner, corner.normalize());
            let (u, v) = (0.5 + 0.5 * n.x, 0.5 + 0.5 * n.y);
            writeln!(text, "v {:.6} {:.6} {:.6}\nvt {u:.6} {v:.6}", p.x, p.y, p.z)
                .expect("a string takes all");
            writeln!(text, "vn {:.4} {:.4} {:.4}", n.x, n.y, n.z).expect("a string takes all");
        }
        for a in (1..3 * ball::triangles().len()).step_by(3) {
            let [b, c] = [a + 1, a + 2];
            writeln!(text, "f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}").expect("a string takes all");
        }
        ReadObj(text)
    }

    fn run(&self) -> usize {
        read("ball.obj", self.0.as_bytes())
    }
}

/// A binary PLY file of the same triangles, without normals.
pub struct ReadPly(Vec<u8>);

impl Case for ReadPly {
    const AT_LEAST: usize = 6912;

    fn new() -> ReadPly {
        let corners = corners();
        let mut bytes = format!(
            "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
             property float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
            corners.len(),
            corners.len() / 3
        )
        .into_bytes();
        bytes.extend(corners.iter().flat_map(|p| [p.x, p.y, p.z]).flat_map(f32::to_le_bytes));
        for first in (0..corners.len() as u32).step_by(3) {
            bytes.push(3);
            bytes.extend([first, first + 1, first + 2].into_iter().flat_map(u32::to_le_bytes));
        }
        ReadPly(bytes)
    }

    fn run(&self) -> usize {
        read("ball.ply", &self.0)
    }
}
