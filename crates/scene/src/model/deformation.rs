//! Meshes whose vertices move, as glTF 2.0 says it: morph targets are added first, then a skin follows its joints.
//!
//! All in double precision and a fixed order: the same bits on every machine.

use super::{Matrix, Mesh, Move, NO_INDEX};
use crate::model::transform::{double, single};
use eosphor_core::math::Vec3;
use std::collections::HashMap;
use std::sync::Arc;

/// What moves the vertices of a mesh. Readers of files make it.
#[derive(Clone, Debug, PartialEq)]
pub struct Deformation {
    /// Where vertices are before anything moves them; one for each position of the mesh.
    pub(crate) positions: Vec<Vec3>,
    /// Normals before anything turns them; one for each normal of the mesh.
    pub(crate) normals: Vec<Vec3>,
    /// For each normal of the mesh, the number of its vertex; [`NO_INDEX`] where it is that of a flat triangle.
    pub(crate) normal_vertices: Vec<u32>,
    /// Morph targets whose weights change.
    pub(crate) morph: Option<Morph>,
    pub(crate) skin: Option<SkinnedVertices>,
    /// Where the coordinates of the mesh are counted from, in those of the vertices when they have moved.
    pub(crate) origin: [f64; 3],
}

/// Morph targets and how much of each is added.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Morph {
    pub(crate) targets: Vec<MorphTarget>,
    /// One weight for each target.
    pub(crate) weights: Arc<WeightTrack>,
}

/// What a morph target adds, block of vertices by block; vertices in no block stay.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct MorphTarget {
    pub(crate) blocks: Vec<MorphBlock>,
}

/// What is added to the vertices from a number on.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MorphBlock {
    pub(crate) first_vertex: u32,
    /// Into the normals of the mesh.
    pub(crate) first_normal: u32,
    pub(crate) positions: Vec<Vec3>,
    pub(crate) normals: Vec<Vec3>,
}

/// Weights of morph targets by time.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct WeightTrack {
    pub(crate) interpolation: WeightInterpolation,
    /// Times of the keys, which increase.
    pub(crate) seconds: Vec<f32>,
    /// Key after key: a weight for each target; of curves three times as many: in-tangents, weights, out-tangents.
    pub(crate) values: Vec<f32>,
    /// How many weights a key has.
    pub(crate) count: usize,
}

/// How weights go from one key to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum WeightInterpolation {
    Step,
    Linear,
    /// Hermite splines (glTF 2.0, appendix C.5).
    Cubic,
}

/// Vertices that follow joints.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SkinnedVertices {
    /// Where the influences of each vertex begin; one more at the end.
    pub(crate) starts: Vec<u32>,
    /// Number of the joint, and its share; the shares of a vertex have the sum 1.
    pub(crate) influences: Vec<(u32, f64)>,
    pub(crate) skin: Arc<Skin>,
}

/// Joints of a skeleton, and where they take vertices.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Skin {
    pub(crate) skeleton: Arc<Skeleton>,
    pub(crate) joints: Vec<Joint>,
}

/// A joint: takes a vertex of the mesh by `bind`, and then as the link moves.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Joint {
    /// Into the links of the skeleton; `None` where nothing moves the joint.
    pub(crate) link: Option<u32>,
    pub(crate) bind: Matrix,
}

/// The motions of a tree of nodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Skeleton {
    /// Parents before children.
    pub(crate) links: Vec<SkeletonLink>,
}

/// A motion within what another one moves.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SkeletonLink {
    pub(crate) motion: Arc<Move>,
    /// Applied after the motion.
    pub(crate) fixed: Matrix,
    /// What moves all this; its number is lower.
    pub(crate) parent: Option<u32>,
}

impl Skeleton {
    /// For each link, the map of all up to the root.
    fn maps(&self, seconds: f64) -> Vec<Matrix> {
        let mut maps: Vec<Matrix> = Vec::with_capacity(self.links.len());
        for link in &self.links {
            let own = link.fixed.after(&link.motion.map(seconds));
            maps.push(link.parent.map_or(own, |parent| maps[parent as usize].after(&own)));
        }
        maps
    }
}

/// Skeletons at a time, each made once.
pub(crate) struct Poses {
    seconds: f64,
    made: HashMap<*const Skeleton, Vec<Matrix>>,
}

impl Poses {
    pub(crate) fn at(seconds: f64) -> Poses {
        Poses { seconds, made: HashMap::new() }
    }

    /// Where each joint of a skin takes vertices.
    fn joints(&mut self, skin: &Skin) -> Vec<Matrix> {
        let seconds = self.seconds;
        let maps =
            self.made.entry(Arc::as_ptr(&skin.skeleton)).or_insert_with(|| skin.skeleton.maps(seconds));
        let map =
            |joint: &Joint| joint.link.map_or(joint.bind, |link| maps[link as usize].after(&joint.bind));
        skin.joints.iter().map(map).collect()
    }
}

impl WeightTrack {
    /// The weights at a time. Before the first key and after the last they stay as they are there.
    fn at(&self, seconds: f64) -> Vec<f64> {
        let is_cubic = self.interpolation == WeightInterpolation::Cubic;
        let size = if is_cubic { 3 * self.count } else { self.count };
        let part = |key: usize, part: usize| {
            let first = key * size + part * self.count;
            self.values[first..first + self.count].iter().map(|&x| f64::from(x))
        };
        let weights = |key: usize| part(key, usize::from(is_cubic));
        let next = self.seconds.partition_point(|&time| f64::from(time) <= seconds);
        if next == 0 || next == self.seconds.len() || self.interpolation == WeightInterpolation::Step {
            return weights(next.saturating_sub(1)).collect();
        }
        let from = next - 1;
        let [t0, t1] = [from, next].map(|key| f64::from(self.seconds[key]));
        let (span, share) = (t1 - t0, (seconds - t0) / (t1 - t0));
        let ends = weights(from).zip(weights(next));
        if !is_cubic {
            return ends.map(|(a, b)| a + share * (b - a)).collect();
        }
        let (s, s2, s3) = (share, share * share, share * share * share);
        let curve = |((a, b), (out, into))| {
            (2.0 * s3 - 3.0 * s2 + 1.0) * a
                + span * (s3 - 2.0 * s2 + s) * out
                + (3.0 * s2 - 2.0 * s3) * b
                + span * (s3 - s2) * into
        };
        ends.zip(part(from, 2).zip(part(next, 0))).map(curve).collect()
    }
}

impl SkinnedVertices {
    fn of(&self, vertex: usize) -> &[(u32, f64)] {
        &self.influences[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
    }
}

impl Deformation {
    /// Whether anything moves from frame to frame.
    pub(crate) fn moves(&self) -> bool {
        let follows = |s: &SkinnedVertices| s.skin.joints.iter().any(|joint| joint.link.is_some());
        self.morph.is_some() || self.skin.as_ref().is_some_and(follows)
    }

    /// Whether there is one place and one normal for each of the mesh.
    pub(crate) fn fits(&self, mesh: &Mesh) -> bool {
        let (positions, normals) = (self.positions.len(), self.normals.len());
        (positions, normals) == (mesh.positions.len(), mesh.normals.len())
            && normals == self.normal_vertices.len()
            && self.skin.as_ref().is_none_or(|skinned| skinned.starts.len() == positions + 1)
    }

    /// The time of the last key of all that moves.
    pub(crate) fn last_seconds(&self) -> Option<f32> {
        let of_morph = self.morph.iter().filter_map(|morph| morph.weights.seconds.last().copied());
        let links = self.skin.iter().flat_map(|skinned| &skinned.skin.skeleton.links);
        let of_links = links.filter_map(|link| link.motion.keys.last().map(|key| key.seconds));
        of_morph.chain(of_links).reduce(f32::max)
    }

    /// The mesh, whose deformation this is, as its vertices are then. Positions may be out of range.
    pub(crate) fn shape(&self, mesh: &Mesh, poses: &mut Poses) -> Mesh {
        let (mut positions, mut normals): (Vec<[f64; 3]>, Vec<[f64; 3]>) = (
            self.positions.iter().map(|&p| double(p)).collect(),
            self.normals.iter().map(|&n| double(n)).collect(),
        );
        if let Some(morph) = &self.morph {
            for (target, weight) in morph.targets.iter().zip(morph.weights.at(poses.seconds)) {
                // What adds nothing may be far away.
                for block in target.blocks.iter().filter(|_| weight != 0.0) {
                    add(&mut positions[block.first_vertex as usize..], &block.positions, weight);
                    add(&mut normals[block.first_normal as usize..], &block.normals, weight);
                }
            }
        }
        if let Some(skinned) = &self.skin {
            let joints = poses.joints(&skinned.skin);
            let blended: Vec<Matrix> =
                (0..positions.len()).map(|vertex| blend(&joints, skinned.of(vertex))).collect();
            for (p, map) in positions.iter_mut().zip(&blended) {
                *p = map.point(*p);
            }
            for (n, &vertex) in normals.iter_mut().zip(&self.normal_vertices).filter(|(_, v)| **v != NO_INDEX)
            {
                *n = turned(&blended[vertex as usize], *n);
            }
        }
        let place = |p: [f64; 3]| single([0, 1, 2].map(|axis| p[axis] - self.origin[axis]));
        let positions: Vec<Vec3> = positions.into_iter().map(place).collect();
        let mut normals: Vec<Vec3> = normals.into_iter().map(finite).collect();
        for t in &mesh.triangles {
            let number = t.normals[0] as usize;
            if self.normal_vertices.get(number) == Some(&NO_INDEX) {
                normals[number] = face_normal(t.positions.map(|p| positions[p as usize]));
            }
        }
        Mesh { positions, normals, ..mesh.clone() }
    }

    /// A number that differs, as good as always, where anything of it does.
    pub fn fingerprint(&self) -> u64 {
        let mut print = Fingerprint(0xcbf2_9ce4_8422_2325);
        let vectors = |print: &mut Fingerprint, all: &[Vec3]| {
            print.word(all.len() as u64);
            all.iter().for_each(|&v| print.floats(<[f32; 3]>::from(v)));
        };
        vectors(&mut print, &self.positions);
        vectors(&mut print, &self.normals);
        self.origin.iter().for_each(|x| print.word(x.to_bits()));
        if let Some(Morph { targets, weights }) = &self.morph {
            for block in targets.iter().flat_map(|target| &target.blocks) {
                print.word(block.first_vertex.into());
                vectors(&mut print, &block.positions);
                vectors(&mut print, &block.normals);
            }
            print.word(weights.interpolation as u64);
            print.floats(weights.seconds.iter().chain(&weights.values).copied());
        }
        if let Some(SkinnedVertices { starts, influences, skin }) = &self.skin {
            starts.iter().for_each(|&start| print.word(start.into()));
            for &(joint, weight) in influences {
                print.word(joint.into());
                print.word(weight.to_bits());
            }
            for Joint { link, bind } in &skin.joints {
                print.word(link.map_or(u64::MAX, u64::from));
                print.matrix(bind);
            }
            for SkeletonLink { motion, fixed, parent } in &skin.skeleton.links {
                print.word(parent.map_or(u64::MAX, u64::from));
                print.matrix(fixed);
                print.motion(motion);
            }
        }
        print.0
    }
}

/// A hash of words in the manner of Fowler, Noll and Vo (FNV-1a).
struct Fingerprint(u64);

impl Fingerprint {
    fn word(&mut self, word: u64) {
        self.0 = (self.0 ^ word).wrapping_mul(0x0000_0100_0000_01b3).rotate_left(23);
    }

    fn floats(&mut self, all: impl IntoIterator<Item = f32>) {
        all.into_iter().for_each(|x| self.word(x.to_bits().into()));
    }

    fn matrix(&mut self, matrix: &Matrix) {
        matrix.0.iter().flatten().for_each(|x| self.word(x.to_bits()));
    }

    fn motion(&mut self, motion: &Move) {
        self.word(motion.interpolation as u64);
        for key in &motion.keys {
            let vectors = [key.scale, key.translate, key.rotate_degrees];
            vectors.into_iter().flatten().for_each(|v| self.floats(<[f32; 3]>::from(v)));
            self.floats(key.rotation.into_iter().flatten().chain([key.seconds]));
        }
    }
}

fn add(to: &mut [[f64; 3]], offsets: &[Vec3], weight: f64) {
    for (to, &offset) in to.iter_mut().zip(offsets) {
        let offset = double(offset);
        *to = [0, 1, 2].map(|axis| to[axis] + weight * offset[axis]);
    }
}

/// The sum of the maps of joints, each by its share.
fn blend(joints: &[Matrix], influences: &[(u32, f64)]) -> Matrix {
    let mut sum = Matrix([[0.0; 3]; 4]);
    for &(joint, share) in influences {
        for (sum, column) in sum.0.iter_mut().zip(&joints[joint as usize].0) {
            *sum = [0, 1, 2].map(|axis| sum[axis] + share * column[axis]);
        }
    }
    sum
}

/// A normal under a map: by the transpose of its inverse, times the size of its determinant.
fn turned(map: &Matrix, n: [f64; 3]) -> [f64; 3] {
    let [a, b, c, _] = &map.0;
    let cross = |u: &[f64; 3], v: &[f64; 3]| {
        [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
    };
    let [x, y, z] = [cross(b, c), cross(c, a), cross(a, b)];
    let determinant = a[0] * x[0] + a[1] * x[1] + a[2] * x[2];
    let side = if determinant < 0.0 { -1.0 } else { 1.0 };
    [0, 1, 2].map(|axis| side * (n[0] * x[axis] + n[1] * y[axis] + n[2] * z[axis]))
}

/// In single precision, shortened to a size that it can name; 0 where it is no number. Normals have any length.
fn finite(n: [f64; 3]) -> Vec3 {
    let most = n.iter().fold(0.0f64, |most, x| most.max(x.abs()));
    let is_usual = most > 0.0 && most.is_finite() && n.iter().all(|x| x.is_finite());
    if is_usual { single(n.map(|x| x / most)) } else { Vec3::ZERO }
}

/// A vector along the normal of a triangle on the side from which it runs counter-clockwise; 0 where it has no area.
fn face_normal(corners: [Vec3; 3]) -> Vec3 {
    let [a, b, c] = corners.map(double);
    let (e, f) = ([0, 1, 2].map(|k| b[k] - a[k]), [0, 1, 2].map(|k| c[k] - a[k]));
    finite([e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]])
}

impl Mesh {
    /// The mesh as it is when its skeletons are as these poses say.
    pub(crate) fn posed(&self, poses: &mut Poses) -> Option<Mesh> {
        Some(self.deformation.as_ref()?.shape(self, poses))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Interpolation, MoveKey, Triangle};
    use eosphor_core::math::vec3;
    use std::f32::consts::FRAC_1_SQRT_2;

    const STILL: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

    fn mesh(positions: &[Vec3], normals: &[Vec3]) -> Mesh {
        let triangle = Triangle { positions: [0, 1, 2], normals: [0, 1, 2], uvs: [NO_INDEX; 3], material: 0 };
        Mesh {
            positions: positions.to_vec(),
            normals: normals.to_vec(),
            triangles: vec![triangle],
            ..Mesh::default()
        }
    }

    fn still(mesh: &Mesh) -> Deformation {
        Deformation {
            positions: mesh.positions.clone(),
            normals: mesh.normals.clone(),
            normal_vertices: vec![0, 1, 2],
            morph: None,
            skin: None,
            origin: [0.0; 3],
        }
    }

    fn track(interpolation: WeightInterpolation, values: &[f32]) -> Arc<WeightTrack> {
        let seconds = vec![1.0, 3.0];
        Arc::new(WeightTrack { interpolation, seconds, values: values.to_vec(), count: 2 })
    }

    #[test]
    fn weights_are_those_of_the_specification() {
        let step = track(WeightInterpolation::Step, &[0.0, 1.0, 4.0, 3.0]);
        let linear = track(WeightInterpolation::Linear, &[0.0, 1.0, 4.0, 3.0]);
        for (seconds, by_step, by_line) in [
            (0.0, [0.0, 1.0], [0.0, 1.0]),
            (1.0, [0.0, 1.0], [0.0, 1.0]),
            (1.5, [0.0, 1.0], [1.0, 1.5]),
            (3.0, [4.0, 3.0], [4.0, 3.0]),
            (9.0, [4.0, 3.0], [4.0, 3.0]),
        ] {
            assert_eq!(step.at(seconds), by_step, "{seconds}");
            assert_eq!(linear.at(seconds), by_line, "{seconds}");
        }
        // Tangents of a parabola, t^2, and of a line: both are met exactly.
        let values = [9.0, 9.0, 1.0, 5.0, 2.0, -1.0, 6.0, -1.0, 9.0, 3.0, 9.0, 9.0];
        let cubic = track(WeightInterpolation::Cubic, &values);
        for t in [1.0, 1.5, 2.0, 2.75, 3.0] {
            assert_eq!(cubic.at(t), [t * t, 6.0 - t], "{t}");
        }
    }

    #[test]
    fn targets_are_added_and_flat_normals_follow() {
        let corners = [Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0)];
        let mesh = mesh(&corners, &[vec3(0.0, 0.0, 1.0); 3]);
        let block = MorphBlock {
            first_vertex: 2,
            first_normal: 2,
            positions: vec![vec3(0.0, -1.0, 4.0)],
            normals: vec![vec3(0.0, -2.0, 0.0)],
        };
        let targets = vec![MorphTarget::default(), MorphTarget { blocks: vec![block] }];
        let weights = track(WeightInterpolation::Linear, &[0.0, 0.0, 0.0, 1.0]);
        let mut deformation = Deformation { morph: Some(Morph { targets, weights }), ..still(&mesh) };
        let half = deformation.shape(&mesh, &mut Poses::at(2.0));
        assert_eq!(half.positions, [corners[0], corners[1], vec3(0.0, 0.5, 2.0)]);
        assert_eq!(half.normals[2], vec3(0.0, -1.0, 1.0));
        deformation.normal_vertices = vec![NO_INDEX, NO_INDEX, NO_INDEX];
        let flat = deformation.shape(&mesh, &mut Poses::at(3.0));
        // The triangle stands upright in the plane of y = 0.
        assert_eq!(flat.normals[0], vec3(0.0, -1.0, 0.0));
        assert_eq!(deformation.last_seconds(), Some(3.0));
    }

    /// A bar of two joints: the second is 2 above the first, and turns by a quarter about z; then it grows to twice its height.
    #[test]
    fn vertices_follow_their_joints_and_normals_the_inverse_transpose() {
        let vertices = [vec3(1.0, 0.0, 0.0), vec3(0.0, 3.0, 0.0), vec3(0.0, 2.0, 1.0)];
        let normals = [vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(1.0, 1.0, 0.0)];
        let mesh = mesh(&vertices, &normals);
        let key = |seconds, rotation, height| MoveKey {
            seconds,
            rotation: Some(rotation),
            scale: Some(vec3(1.0, height, 1.0)),
            ..MoveKey::default()
        };
        let quarter = [0.0, 0.0, FRAC_1_SQRT_2, FRAC_1_SQRT_2];
        let keys = vec![key(0.0, [0.0, 0.0, 0.0, 1.0], 1.0), key(1.0, quarter, 1.0), key(2.0, quarter, 2.0)];
        let motion = Arc::new(Move { keys, interpolation: Interpolation::Linear, ..Move::default() });
        let up = |y: f64| Matrix::of_parts([0.0, y, 0.0], STILL, [1.0; 3]);
        let skeleton = Skeleton { links: vec![SkeletonLink { motion, fixed: up(2.0), parent: None }] };
        let joints =
            vec![Joint { link: None, bind: Matrix::IDENTITY }, Joint { link: Some(0), bind: up(-2.0) }];
        let skin = Arc::new(Skin { skeleton: Arc::new(skeleton), joints });
        let influences = vec![(0, 1.0), (1, 1.0), (0, 0.5), (1, 0.5)];
        let skinned = SkinnedVertices { starts: vec![0, 1, 2, 4], influences, skin };
        let deformation = Deformation { skin: Some(skinned), ..still(&mesh) };
        assert!(deformation.moves());
        let near = |a: Vec3, b: Vec3| assert!((a - b).length() < 1e-6, "{a:?} {b:?}");
        let rest = deformation.shape(&mesh, &mut Poses::at(0.0));
        rest.positions.iter().zip(vertices).for_each(|(&a, b)| near(a, b));
        let turned = deformation.shape(&mesh, &mut Poses::at(1.0));
        // What hangs on the first joint stays; what is 1 above the second is 1 to its left; what is at it stays.
        [vertices[0], vec3(-1.0, 2.0, 0.0), vertices[2]]
            .into_iter()
            .zip(turned.positions)
            .for_each(|(a, b)| near(a, b));
        near(turned.normals[1], vec3(-1.0, 0.0, 0.0));
        let grown = deformation.shape(&mesh, &mut Poses::at(2.0));
        near(grown.positions[1], vec3(-2.0, 2.0, 0.0));
        // Half of the identity and half of (x, y) -> (-2 y, x): its matrix is (1/2, 1/2), (-1, 1/2), and its inverse transpose
        // takes (1, 1) to a multiple of (1/2 - 1/2, 1 + 1/2).
        near(grown.normals[2], vec3(0.0, 1.0, 0.0));
        assert_ne!(
            Deformation { skin: None, ..deformation.clone() }.fingerprint(),
            deformation.fingerprint()
        );
    }
}
