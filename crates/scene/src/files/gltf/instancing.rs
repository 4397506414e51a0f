//! EXT_mesh_gpu_instancing: one node that places its mesh many times.

use super::accessors::Accessors;
use crate::model::Matrix;
use gltf::json::scene::Node;
use gltf::json::{Value, deserialize};
use std::collections::BTreeMap;

/// Where a node places its mesh: once, or as the extension says.
pub(super) fn worlds(accessors: &Accessors<'_>, node: &Node, world: &Matrix) -> Result<Vec<Matrix>, String> {
    const NAME: &str = "EXT_mesh_gpu_instancing";
    let Some(value) = node.extensions.as_ref().and_then(|e| e.others.get(NAME)) else {
        return Ok(vec![*world]);
    };
    let attributes = value.get("attributes").cloned().unwrap_or(Value::Null);
    let attributes: BTreeMap<String, usize> = deserialize::from_value(attributes)
        .map_err(|_| format!("{NAME} without attributes; mend the file"))?;
    let attribute = |name: &str| attributes.get(name).copied();
    let whole = |values: [f32; 3]| values;
    let translations = attribute("TRANSLATION").map(|i| accessors.read(i, whole)).transpose()?;
    let rotations = attribute("ROTATION").map(|i| accessors.read(i, |q: [f32; 4]| q)).transpose()?;
    let scales = attribute("SCALE").map(|i| accessors.read(i, whole)).transpose()?;

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
