//! Skins.

use super::Index;
use serde::Deserialize;

/// Joints that vertices follow.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Skin {
    pub name: Option<String>,
    /// The accessor of the matrices that take the mesh to each joint; all are the identity where there is none.
    pub inverse_bind_matrices: Option<Index>,
    /// Nodes, in the order in which vertices number them.
    pub joints: Vec<Index>,
}
