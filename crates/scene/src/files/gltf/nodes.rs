//! The tree of nodes, laid out: every node of the scene with its place in the world.

use super::{Part, named};
use crate::model::Matrix;
use gltf::json::Root;
use gltf::json::scene::Node;

/// A node of the scene.
pub(super) struct PlacedNode {
    /// Into the file's nodes.
    pub(super) node: usize,
    pub(super) world: Matrix,
}

/// The nodes of the default scene, else of the first, else of the whole file; parents before children, in the
/// file's order.
pub(super) fn placed(root: &Root) -> Result<Vec<PlacedNode>, String> {
    // A stack of its own: files may nest nodes deeper than the machine's stack.
    let mut waiting: Vec<(usize, Matrix)> =
        roots(root)?.into_iter().rev().map(|node| (node, Matrix::IDENTITY)).collect();
    let mut seen = vec![false; root.nodes.len()];
    let mut placed = Vec::new();
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
        let world = parent.after(&local(node));
        placed.push(PlacedNode { node: number, world });
        let children = node.children.as_deref().unwrap_or_default();
        waiting.extend(children.iter().rev().map(|child| (child.value(), world)));
    }
    Ok(placed)
}

/// The nodes that have no parent in the scene that is shown.
fn roots(root: &Root) -> Result<Vec<usize>, String> {
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

/// From a node to its parent: its matrix, or scale, then rotation, then translation.
fn local(node: &Node) -> Matrix {
    if let Some(m) = node.matrix {
        // Column after column; the fourth row is (0, 0, 0, 1) by the specification.
        return Matrix([0, 4, 8, 12].map(|c| [m[c], m[c + 1], m[c + 2]].map(f64::from)));
    }
    let rotation = node.rotation.map_or([0.0, 0.0, 0.0, 1.0], |q| q.0);
    let (translation, scale) = (node.translation.unwrap_or([0.0; 3]), node.scale.unwrap_or([1.0; 3]));
    Matrix::of_parts(translation.map(f64::from), rotation.map(f64::from), scale.map(f64::from))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matrices_are_column_after_column() {
        let node = Node { matrix: Some(std::array::from_fn(|i| i as f32)), ..Node::default() };
        assert_eq!(local(&node).0[3], [12.0, 13.0, 14.0]);
        assert_eq!(local(&node).0[1], [4.0, 5.0, 6.0]);
    }
}
