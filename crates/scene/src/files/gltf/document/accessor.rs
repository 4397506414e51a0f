//! Accessors: how elements lie in buffers.

use super::Index;
use super::enumeration::{Enumeration, Terms, listed};
use serde::Deserialize;

/// Elements of the same type, one after the other in a view of a buffer.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Accessor {
    pub name: Option<String>,
    /// Without a view all elements are zero, but for sparse ones.
    pub buffer_view: Option<Index>,
    /// From the start of the view to the first element.
    pub byte_offset: Option<u64>,
    pub count: u64,
    #[serde(deserialize_with = "listed")]
    pub component_type: Option<ComponentType>,
    #[serde(rename = "type", deserialize_with = "listed")]
    pub element_type: Option<ElementType>,
    /// Whether whole numbers stand for 0 to 1, or -1 to 1.
    #[serde(default)]
    pub normalized: bool,
    pub sparse: Option<Sparse>,
}

/// Elements that replace some of an accessor's.
#[derive(Debug, Deserialize)]
pub struct Sparse {
    pub count: u64,
    pub indices: SparseIndices,
    pub values: SparseValues,
}

/// The places of the elements that are replaced.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SparseIndices {
    pub buffer_view: Index,
    #[serde(default)]
    pub byte_offset: u64,
    #[serde(deserialize_with = "listed")]
    pub component_type: Option<ComponentType>,
}

/// The elements that replace others.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SparseValues {
    pub buffer_view: Index,
    #[serde(default)]
    pub byte_offset: u64,
}

/// The type of one component of an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ComponentType {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Enumeration for ComponentType {
    const TERMS: Terms<ComponentType> = Terms::Codes(&[
        (5120, ComponentType::I8),
        (5121, ComponentType::U8),
        (5122, ComponentType::I16),
        (5123, ComponentType::U16),
        (5125, ComponentType::U32),
        (5126, ComponentType::F32),
    ]);
}

/// How many components an element has, and how they are arranged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ElementType {
    Scalar,
    Vec2,
    Vec3,
    Vec4,
    Mat2,
    Mat3,
    Mat4,
}

impl Enumeration for ElementType {
    const TERMS: Terms<ElementType> = Terms::Names(&[
        ("SCALAR", ElementType::Scalar),
        ("VEC2", ElementType::Vec2),
        ("VEC3", ElementType::Vec3),
        ("VEC4", ElementType::Vec4),
        ("MAT2", ElementType::Mat2),
        ("MAT3", ElementType::Mat3),
        ("MAT4", ElementType::Mat4),
    ]);
}
