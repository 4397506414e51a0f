//! The usual layout straight from bytes: vertices of little-endian floats, faces that are triangles of 32-bit indices.

use super::header::{Element, Property, Shape};
use super::part::{Part, check_position, triangle};
use super::role::{Kind, NORMAL, POSITION, Plan, Role};
use super::rows::Fault;
use super::scalar::Scalar;
use crate::model::Triangle;
use eosphor_core::math::{Vec3, vec3};
use rayon::prelude::*;

/// Reads rows of one size, if their layout is the usual one.
pub(super) fn read(bytes: &[u8], element: &Element, size: usize, plan: &Plan) -> Result<Option<Part>, Fault> {
    match element.kind {
        Kind::Vertex if !plan.colors && !plan.uvs => vertices(bytes, element, size, plan),
        Kind::Face => Ok(triangles(bytes, element, plan)),
        _ => Ok(None),
    }
}

fn vertices(bytes: &[u8], element: &Element, size: usize, plan: &Plan) -> Result<Option<Part>, Fault> {
    let Some(xyz) = three_floats(element, POSITION) else { return Ok(None) };
    let nxyz = three_floats(element, NORMAL);
    if plan.normals && nxyz.is_none() {
        return Ok(None);
    }
    let column = |offset: usize| -> Vec<Vec3> {
        bytes.par_chunks_exact(size).with_min_len(1 << 14).map(|row| point(&row[offset..])).collect()
    };
    let positions = column(xyz);
    let wrong = positions.par_iter().position_first(|&p| check_position(p).is_err());
    if let Some(number) = wrong {
        let problem = check_position(positions[number]).err().unwrap_or_default();
        return Err(Fault { line: None, message: format!("{} {number}: {problem}", element.name) });
    }
    let mut part = Part { positions, ..Part::default() };
    if let Some(offset) = nxyz.filter(|_| plan.normals) {
        part.normals = column(offset);
        for n in part.normals.iter_mut().filter(|n| !n.is_finite()) {
            *n = Vec3::ZERO;
            part.oddities.not_finite += 1;
        }
    }
    Ok(Some(part))
}

/// Where three numbers of a vertex stand in its row, if they are floats side by side.
fn three_floats(element: &Element, slot: usize) -> Option<usize> {
    let first = element.properties.iter().position(|p| p.role == Role::Number(slot))?;
    let float = |k: usize| Property { role: Role::Number(slot + k), shape: Shape::One(Scalar::F32) };
    let own = element.properties.get(first..first + 3)?;
    if own != [float(0), float(1), float(2)] {
        return None;
    }
    let size = |p: &Property| if let Shape::One(scalar) = p.shape { scalar.size() } else { 0 };
    Some(element.properties[..first].iter().map(size).sum())
}

/// Every list is known to be of length 3.
fn triangles(bytes: &[u8], element: &Element, plan: &Plan) -> Option<Part> {
    const SIZE: usize = 13;
    let [list] = element.properties.as_slice() else { return None };
    let usual = |item| Shape::List { length: Scalar::U8, item };
    if list.role != Role::Indices || (list.shape != usual(Scalar::I32) && list.shape != usual(Scalar::U32)) {
        return None;
    }
    let read = |row: &[u8]| triangle(plan, [word(row, 1), word(row, 5), word(row, 9)], 0);
    let triangles: Vec<Triangle> = bytes.par_chunks_exact(SIZE).with_min_len(1 << 14).map(read).collect();
    // Equal ones: the first face counts, so that the message is the same every time.
    let of = |(number, t): (usize, &Triangle)| {
        let [a, b, c] = t.positions;
        (a.max(b).max(c), std::cmp::Reverse(number as u64))
    };
    let (largest, number) = triangles.par_iter().with_min_len(1 << 14).enumerate().map(of).max()?;
    if largest > i32::MAX as u32 {
        // Rows that are read one by one say what is wrong.
        return None;
    }
    let largest = Some((largest, "face", (None, number.0)));
    Some(Part { triangles, largest, ..Part::default() })
}

#[inline]
fn point(row: &[u8]) -> Vec3 {
    let float = |at| f32::from_bits(word(row, at));
    vec3(float(0), float(4), float(8))
}

#[inline]
fn word(row: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([row[at], row[at + 1], row[at + 2], row[at + 3]])
}
