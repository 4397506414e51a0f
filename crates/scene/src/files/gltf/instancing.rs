//! EXT_mesh_gpu_instancing: one node that places its mesh many times.

use super::accessors::Accessors;
use super::document::{Index, Node};
use crate::model::Matrix;

/// Where a node places its mesh: once, or as the extension says.
pub(super) fn worlds(accessors: &Accessors<'_>, node: &Node, world: &Matrix) -> Result<Vec<Matrix>, String> {
    const NAME: &str = "EXT_mesh_gpu_instancing";
    let Some(instancing) = node.instancing() else { return Ok(vec![*world]) };
    let attributes = &instancing.attributes;
    let attributes =
        attributes.as_ref().ok_or_else(|| format!("{NAME} without attributes; mend the file"))?;
    let vectors = |index: Index| accessors.read(index.value(), |x: [f32; 3]| x);
    let quaternions = |index: Index| accessors.read(index.value(), |q: [f32; 4]| q);
    let translations = attributes.translation.map(vectors).transpose()?;
    let rotations = attributes.rotation.map(quaternions).transpose()?;
    let scales = attributes.scale.map(vectors).transpose()?;

    let counts = [
        translations.as_ref().map(Vec::len),
        rotations.as_ref().map(Vec::len),
        scales.as_ref().map(Vec::len),
    ];
    let count = counts.into_iter().flatten().next().unwrap_or(1);
    if counts.into_iter().flatten().any(|other| other != count) {
        return Err(format!("the attributes of {NAME} have different lengths; export it again"));
    }
    let place = |i: usize| {
        let translation = translations.as_ref().map_or([0.0; 3], |all| all[i]);
        let rotation = rotations.as_ref().map_or([0.0, 0.0, 0.0, 1.0], |all| all[i]);
        let scale = scales.as_ref().map_or([1.0; 3], |all| all[i]);
        let (translation, rotation) = (translation.map(f64::from), rotation.map(f64::from));
        world.after(&Matrix::of_parts(translation, rotation, scale.map(f64::from)))
    };
    Ok((0..count).map(place).collect())
}
