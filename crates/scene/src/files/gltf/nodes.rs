//! The tree of nodes, laid out: every node of the scene with its place in the world.

use super::accessors::Budget;
use super::animations::Animations;
use super::channels::Target;
use super::document::{Document, Node};
use super::{Part, named};
use crate::model::{Matrix, Move, Skeleton, SkeletonLink, Transform};
use serde::Deserialize;
use std::sync::Arc;

/// A node of the scene.
pub(super) struct PlacedNode {
    /// Into the file's nodes.
    pub(super) node: usize,
    /// Takes it into the world; where it moves, before it does.
    pub(super) world: Matrix,
    /// The first of the motions that follow; `None` where it stays.
    motion: Option<usize>,
    /// The link of the skeleton that moves it, and its place within that, whatever its volume.
    pub(super) within: (Option<u32>, Matrix),
}

/// A motion of the nodes below. Those below share it.
struct Link {
    motion: Arc<Move>,
    /// What follows it and stays, up to the next motion.
    fixed: Option<Arc<Move>>,
    /// The same as a matrix.
    fixed_map: Matrix,
    /// The motion that follows then.
    next: Option<usize>,
}

/// The nodes of a scene, and how they move.
#[derive(Default)]
pub(super) struct Nodes {
    /// Parents before children, in the file's order.
    pub(super) placed: Vec<PlacedNode>,
    links: Vec<Link>,
}

impl Nodes {
    /// The motions of all nodes. Links have the numbers that [`PlacedNode::within`] says.
    pub(super) fn skeleton(&self) -> Skeleton {
        let link = |link: &Link| SkeletonLink {
            motion: Arc::clone(&link.motion),
            fixed: link.fixed_map,
            parent: link.next.map(|number| number as u32),
        };
        Skeleton { links: self.links.iter().map(link).collect() }
    }

    /// How a node moves: the motions one after the other.
    pub(super) fn moves(&self, placed: &PlacedNode, budget: &Budget) -> Result<Vec<Arc<Move>>, String> {
        let mut moves = Vec::new();
        let mut next = placed.motion;
        while let Some(number) = next {
            let link = &self.links[number];
            budget.spend(1 + u64::from(link.fixed.is_some()))?;
            moves.push(Arc::clone(&link.motion));
            moves.extend(link.fixed.clone());
            next = link.next;
        }
        Ok(moves)
    }
}

/// Where a node is.
#[derive(Clone, Copy)]
struct Pose {
    rest: Matrix,
    /// Its matrix up to the first motion.
    fixed: Matrix,
    motion: Option<usize>,
    /// Whether a fixed transform before one of its motions has no inverse. Such a node is flat and as good as hidden:
    /// it stays at rest.
    is_flat: bool,
}

impl Pose {
    const ROOT: Pose = Pose { rest: Matrix::IDENTITY, fixed: Matrix::IDENTITY, motion: None, is_flat: false };

    fn placed(&self, node: usize) -> PlacedNode {
        let within = (self.motion.map(|number| number as u32), self.fixed);
        match self.motion.filter(|_| !self.is_flat) {
            Some(motion) => PlacedNode { node, world: self.fixed, motion: Some(motion), within },
            None => PlacedNode { node, world: self.rest, motion: None, within },
        }
    }
}

/// The nodes of the default scene, else of the first, else of the whole file.
///
/// `exact` has the places of all nodes in double precision, where that matters.
pub(super) fn placed(
    root: &Document,
    exact: Option<&[ExactNode]>,
    animations: &mut Animations<'_>,
) -> Result<Nodes, String> {
    // A stack of its own: files may nest nodes deeper than the machine's stack. Nodes, and the place of the parent's pose.
    let mut waiting: Vec<(usize, usize)> = roots(root)?.into_iter().rev().map(|node| (node, 0)).collect();
    let mut poses = vec![Pose::ROOT];
    let mut seen = vec![false; root.nodes.len()];
    let mut nodes = Nodes::default();
    while let Some((number, parent)) = waiting.pop() {
        let Some(node) = root.nodes.get(number) else {
            return Err(format!("node {number} does not exist; there are {}", root.nodes.len()));
        };
        // A tree has no cycle, and no more places than nodes.
        if std::mem::replace(&mut seen[number], true) {
            let name = Part::new("node", number, node.name.as_deref());
            return Err(format!(
                "{name} is reached twice: nodes must be a tree, without cycles and with one parent each; mend the file"
            ));
        }
        let node = Local { node, exact: exact.and_then(|all| all.get(number)) };
        let pose = nodes.pose(&poses[parent], number, &node, animations)?;
        nodes.placed.push(pose.placed(number));
        poses.push(pose);
        let (children, parent) = (node.node.children.as_deref().unwrap_or_default(), poses.len() - 1);
        waiting.extend(children.iter().rev().map(|child| (child.value(), parent)));
    }
    Ok(nodes)
}

impl Nodes {
    /// A node below its parent.
    fn pose(
        &mut self,
        parent: &Pose,
        number: usize,
        node: &Local<'_>,
        animations: &mut Animations<'_>,
    ) -> Result<Pose, String> {
        let rest = parent.rest.after(&node.whole());
        let mut moving = false;
        let mut pose = Pose { rest, ..*parent };
        for target in Target::OF_TRANSFORM {
            let still = node.part(target);
            let Some(motion) = animations.motion(number, target)? else {
                pose.fixed = pose.fixed.after(&still);
                continue;
            };
            moving = true;
            let affine = pose.fixed.affine();
            pose.is_flat |= affine.is_finite() && affine.inverse().is_none();
            let fixed = (pose.fixed != Matrix::IDENTITY).then(|| {
                let transform = match node.exact {
                    None => Transform::from_affine(&affine),
                    Some(_) => Transform::exactly(&affine, pose.fixed.0[3]),
                };
                Arc::new(Move { transform, ..Move::default() })
            });
            let fixed_map = pose.fixed;
            self.links.push(Link { motion, fixed, fixed_map, next: pose.motion });
            (pose.motion, pose.fixed) = (Some(self.links.len() - 1), Matrix::IDENTITY);
        }
        if !moving {
            // In one step, for matrices have no parts.
            pose.fixed = parent.fixed.after(&node.whole());
        }
        Ok(pose)
    }
}

/// The nodes that have no parent in the scene that is shown.
fn roots(root: &Document) -> Result<Vec<usize>, String> {
    let scene = match root.scene {
        Some(index) => Some(named(&root.scenes, index.value(), "scene")?),
        None => root.scenes.first(),
    };
    if let Some(scene) = scene {
        return Ok(scene.nodes.iter().map(|node| node.value()).collect());
    }
    let mut is_child = vec![false; root.nodes.len()];
    for child in root.nodes.iter().flat_map(|node| node.children.as_deref().unwrap_or_default()) {
        if let Some(entry) = is_child.get_mut(child.value()) {
            *entry = true;
        }
    }
    Ok((0..root.nodes.len()).filter(|&node| !is_child[node]).collect())
}

/// Where the origin of a node is in its parent, in double precision: with all digits of the file, which `Node` rounds.
#[derive(Clone, Copy, Default, Deserialize)]
pub(super) struct ExactNode {
    translation: Option<[f64; 3]>,
    matrix: Option<[f64; 16]>,
}

impl ExactNode {
    /// Those of a file; none where it is not as it should be.
    pub(super) fn all(json: &[u8]) -> Option<Vec<ExactNode>> {
        #[derive(Deserialize)]
        struct Nodes {
            nodes: Vec<ExactNode>,
        }
        serde_json::from_slice(json).ok().map(|Nodes { nodes }| nodes)
    }
}

/// A node and where it is.
struct Local<'a> {
    node: &'a Node,
    exact: Option<&'a ExactNode>,
}

impl Local<'_> {
    fn translation(&self) -> [f64; 3] {
        let rounded = || self.node.translation.map(|t| t.map(f64::from));
        self.exact.and_then(|exact| exact.translation).or_else(rounded).unwrap_or([0.0; 3])
    }

    fn rotation(&self) -> [f64; 4] {
        self.node.rotation.map_or([0.0, 0.0, 0.0, 1.0], |q| q.map(f64::from))
    }

    fn scale(&self) -> [f64; 3] {
        self.node.scale.map_or([1.0; 3], |s| s.map(f64::from))
    }

    /// From a node to its parent: its matrix, or scale, then rotation, then translation.
    fn whole(&self) -> Matrix {
        let Some(m) = self.node.matrix else {
            return Matrix::of_parts(self.translation(), self.rotation(), self.scale());
        };
        // The fourth row is (0, 0, 0, 1) by the specification.
        let mut map = Matrix::of_columns(m);
        if let Some(m) = self.exact.and_then(|exact| exact.matrix) {
            map.0[3] = [m[12], m[13], m[14]];
        }
        map
    }

    /// A part of it, of a node without a matrix.
    fn part(&self, target: Target) -> Matrix {
        let (still, turned, one) = ([0.0; 3], [0.0, 0.0, 0.0, 1.0], [1.0; 3]);
        match target {
            Target::Translation => Matrix::of_parts(self.translation(), turned, one),
            Target::Rotation => Matrix::of_parts(still, self.rotation(), one),
            Target::Scale => Matrix::of_parts(still, turned, self.scale()),
            Target::Weights => Matrix::IDENTITY,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matrices_are_column_after_column() {
        let node = Node { matrix: Some(std::array::from_fn(|i| i as f32)), ..Node::default() };
        let map = Local { node: &node, exact: None }.whole();
        assert_eq!((map.0[3], map.0[1]), ([12.0, 13.0, 14.0], [4.0, 5.0, 6.0]));
    }
}
