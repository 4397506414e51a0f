//! Skins: the joints of the file's nodes, and which of them vertices follow.

use super::accessors::Accessors;
use super::nodes::Nodes;
use super::{Part, named};
use crate::model::{Joint, Matrix, Skeleton, Skin};
use std::collections::HashMap;
use std::sync::Arc;

/// What a joint takes of the memory, in elements of accessors.
const ELEMENTS_A_JOINT: u64 = 16;

/// Skins over the nodes of a scene, each made when it is needed, and once.
pub(super) struct Skins<'a> {
    accessors: &'a Accessors<'a>,
    skeleton: Arc<Skeleton>,
    /// By node: the link that moves it, and its place before that.
    places: HashMap<usize, (Option<u32>, Matrix)>,
    made: HashMap<usize, Arc<Skin>>,
}

impl<'a> Skins<'a> {
    pub(super) fn new(accessors: &'a Accessors<'a>, nodes: &Nodes) -> Skins<'a> {
        let places = nodes.placed.iter().map(|placed| (placed.node, placed.within)).collect();
        Skins { accessors, skeleton: Arc::new(nodes.skeleton()), places, made: HashMap::new() }
    }

    /// A skin of the file.
    pub(super) fn skin(&mut self, number: usize) -> Result<Arc<Skin>, String> {
        if let Some(skin) = self.made.get(&number) {
            return Ok(Arc::clone(skin));
        }
        let skin = named(&self.accessors.root.skins, number, "skin")?;
        let name = Part::new("skin", number, skin.name.as_deref());
        let joints = self.joints(skin).map_err(|problem| format!("{name}: {problem}"))?;
        let skin = Arc::new(Skin { skeleton: Arc::clone(&self.skeleton), joints });
        self.made.insert(number, Arc::clone(&skin));
        Ok(skin)
    }

    fn joints(&self, skin: &super::document::Skin) -> Result<Vec<Joint>, String> {
        if skin.joints.is_empty() {
            return Err("it has no joints; export it again".into());
        }
        self.accessors.budget.spend(ELEMENTS_A_JOINT.saturating_mul(skin.joints.len() as u64))?;
        let matrices = match skin.inverse_bind_matrices {
            None => vec![Matrix::IDENTITY; skin.joints.len()],
            Some(accessor) => {
                let read = self.accessors.read(accessor.value(), Matrix::of_columns);
                read.map_err(|problem| format!("inverseBindMatrices: {problem}"))?
            }
        };
        if matrices.len() < skin.joints.len() {
            return Err(format!(
                "there are {} inverseBindMatrices for {} joints; export it again",
                matrices.len(),
                skin.joints.len()
            ));
        }
        if let Some(k) = matrices.iter().position(|m| m.0.iter().flatten().any(|x| !x.is_finite())) {
            return Err(format!("matrix {k} of its inverseBindMatrices is not finite; export it again"));
        }
        let joint = |(joint, inverse_bind): (&super::document::Index, Matrix)| {
            let node = joint.value();
            let (link, place) = self.places.get(&node).copied().ok_or_else(|| {
                format!("its joint, node {node}, is not in the scene that is shown; mend the file")
            })?;
            Ok(Joint { link, bind: place.after(&inverse_bind) })
        };
        skin.joints.iter().zip(matrices).map(joint).collect()
    }
}

/// The joints that vertices follow, and the share of each.
#[derive(Clone, Debug, Default)]
pub(super) struct Influences {
    /// Where those of each vertex begin; one more at the end.
    pub(super) starts: Vec<u32>,
    pub(super) list: Vec<(u32, f64)>,
}

impl Influences {
    /// Reads the sets of JOINTS_n and WEIGHTS_n of so many vertices. Shares are made to have the sum 1; where all weights are 0,
    /// the first joint has all.
    pub(super) fn read(
        accessors: &Accessors<'_>,
        sets: &[(usize, usize)],
        count: usize,
    ) -> Result<Influences, String> {
        let mut read = Vec::with_capacity(sets.len());
        for (n, &(joints, weights)) in sets.iter().enumerate() {
            let joints = accessors.read(joints, |x: [f32; 4]| x);
            let joints = joints.map_err(|problem| format!("JOINTS_{n}: {problem}"))?;
            let weights = accessors.read(weights, |x: [f32; 4]| x);
            let weights = weights.map_err(|problem| format!("WEIGHTS_{n}: {problem}"))?;
            for (name, found) in [("JOINTS", joints.len()), ("WEIGHTS", weights.len())] {
                if found != count {
                    return Err(format!(
                        "{name}_{n} has {found} elements for {count} vertices; export it again"
                    ));
                }
            }
            read.push((joints, weights));
        }
        let mut influences = Influences { starts: vec![0], list: Vec::with_capacity(count) };
        for vertex in 0..count {
            let of_vertex =
                read.iter().flat_map(|(joints, weights)| joints[vertex].into_iter().zip(weights[vertex]));
            influences
                .push(of_vertex)
                .map_err(|problem| format!("vertex {vertex}: {problem}; export it again"))?;
        }
        Ok(influences)
    }

    /// Adds a vertex.
    fn push(&mut self, weighted: impl Iterator<Item = (f32, f32)> + Clone) -> Result<(), String> {
        let first = self.list.len();
        let mut sum = 0.0;
        for (joint, weight) in weighted.clone() {
            if !weight.is_finite() {
                return Err("a weight of a joint is not finite".into());
            }
            // Rounding may leave a little less than nothing.
            if weight > 0.0 {
                self.list.push((whole(joint)?, f64::from(weight)));
                sum += f64::from(weight);
            }
        }
        self.list[first..].iter_mut().for_each(|(_, share)| *share /= sum);
        if self.list.len() == first
            && let Some((joint, _)) = weighted.clone().next()
        {
            self.list.push((whole(joint)?, 1.0));
        }
        let end = u32::try_from(self.list.len()).map_err(|_| "there are too many weights")?;
        self.starts.push(end);
        Ok(())
    }

    /// The largest number of a joint, and that of the vertex that follows it.
    pub(super) fn last_joint(&self) -> Option<u32> {
        self.list.iter().map(|(joint, _)| *joint).max()
    }

    fn of(&self, vertex: usize) -> &[(u32, f64)] {
        &self.list[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
    }

    /// Those of the vertices of these numbers, in this order.
    pub(super) fn gathered(&self, numbers: &[u32]) -> Influences {
        let mut all = Influences { starts: vec![0], list: Vec::new() };
        for &number in numbers {
            all.list.extend_from_slice(self.of(number as usize));
            all.starts.push(all.list.len() as u32);
        }
        all
    }

    /// Adds those of more vertices.
    pub(super) fn append(&mut self, more: &Influences) -> Result<(), String> {
        let before = self.list.len();
        if u32::try_from(before + more.list.len()).is_err() {
            return Err("the mesh has too many weights for 32-bit numbers".into());
        }
        if self.starts.is_empty() {
            self.starts.push(0);
        }
        self.starts.extend(more.starts.iter().skip(1).map(|start| start + before as u32));
        self.list.extend_from_slice(&more.list);
        Ok(())
    }
}

/// The number of a joint, which was read as a float.
fn whole(joint: f32) -> Result<u32, String> {
    // Of types that hold fractions, numbers below 2^24 are exact.
    match (0.0..16_777_216.0).contains(&joint) && joint.fract() == 0.0 {
        true => Ok(joint as u32),
        false => Err(format!("{joint} is no number of a joint")),
    }
}
