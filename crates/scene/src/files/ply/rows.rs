//! Rows of elements, whatever their encoding, become vertices and triangles.

use super::color;
use super::header::{Element, Shape};
use super::part::Part;
use super::role::{Kind, NORMAL, Plan, Role, SLOTS};
use super::scalar::Scalar;
use std::ops::Range;

/// The numbers of a file, one after the other.
pub(super) trait Values {
    /// Goes to the next row.
    fn start_row(&mut self) -> Result<(), String>;
    /// The next number, rounded to single precision.
    fn number(&mut self, scalar: Scalar) -> Result<f32, String>;
    /// The next number in double precision.
    fn exact(&mut self, scalar: Scalar) -> Result<f64, String>;
    /// The next number, which must be whole.
    fn whole(&mut self, scalar: Scalar) -> Result<i64, String>;
    /// Passes over numbers.
    fn skip(&mut self, scalar: Scalar, count: u64) -> Result<(), String>;
    /// Ends the row.
    fn end_row(&mut self);
    /// The line of the row, where there are lines.
    fn line(&self) -> Option<u32>;
}

/// What is wrong in a row.
#[derive(Debug)]
pub(super) struct Fault {
    pub(super) line: Option<u32>,
    pub(super) message: String,
}

/// The numbers of a row by what they mean.
#[derive(Default)]
struct Row {
    slots: [f32; SLOTS],
    indices: Vec<i64>,
    corner_uvs: Vec<f32>,
    picture: i64,
}

/// Reads these rows of an element into a part. Rows are counted from 0, as the indices of PLY are.
pub(super) fn read<V: Values>(
    values: &mut V,
    element: &Element,
    rows: Range<u64>,
    plan: &Plan,
    part: &mut Part,
) -> Result<(), Fault> {
    part.reserve(element.kind, plan, usize::try_from(rows.end - rows.start).unwrap_or(0));
    let mut row = Row::default();
    // What has no opacity is opaque.
    row.slots[super::role::COLOR + 3] = 1.0;
    for number in rows {
        let read = read_row(values, element, plan, &mut row).and_then(|()| match element.kind {
            Kind::Vertex => part.vertex(plan, &row.slots),
            Kind::Face => {
                part.face(plan, &row.indices, &row.corner_uvs, row.picture, (values.line(), number))
            }
            Kind::Strips => part.strip(plan, &row.indices, (values.line(), number)),
            Kind::Other => Ok(()),
        });
        if let Err(problem) = read {
            // Lines count from 1, rows from 0: both are said where both are known.
            let message = format!("{} {number}: {problem}", element.name);
            return Err(Fault { line: values.line(), message });
        }
    }
    Ok(())
}

#[inline]
fn read_row<V: Values>(values: &mut V, element: &Element, plan: &Plan, row: &mut Row) -> Result<(), String> {
    let is_near = plan.is_near();
    values.start_row()?;
    row.indices.clear();
    row.corner_uvs.clear();
    for property in &element.properties {
        match (property.shape, property.role) {
            (Shape::One(scalar), Role::Number(slot)) if !is_near && slot < NORMAL => {
                row.slots[slot] = (values.exact(scalar)? - plan.origin[slot]) as f32;
            }
            (Shape::One(scalar), Role::Number(slot)) => row.slots[slot] = values.number(scalar)?,
            (Shape::One(scalar), Role::Color(slot)) => {
                let code = values.number(scalar)?;
                row.slots[slot] = match slot - super::role::COLOR {
                    3 => color::opacity(scalar, code),
                    _ => color::linear(scalar, code),
                };
            }
            (Shape::One(scalar), Role::TextureNumber) => row.picture = values.whole(scalar)?,
            (Shape::One(scalar), _) => values.skip(scalar, 1)?,
            (Shape::List { length, item }, role) => {
                let length = values.whole(length)?;
                let length =
                    u64::try_from(length).map_err(|_| format!("a list of {length} numbers cannot be"))?;
                match role {
                    Role::Indices => {
                        for _ in 0..length {
                            row.indices.push(values.whole(item)?);
                        }
                    }
                    Role::CornerUvs => {
                        for _ in 0..length {
                            row.corner_uvs.push(values.number(item)?);
                        }
                    }
                    _ => values.skip(item, length)?,
                }
            }
        }
    }
    values.end_row();
    Ok(())
}
