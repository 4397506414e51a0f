//! Buffers and the views into them.

use super::Index;
use serde::Deserialize;

/// A buffer names its bytes. Its `byteLength` is not needed: what counts is how many bytes there are.
#[derive(Debug, Deserialize)]
pub struct Buffer {
    pub name: Option<String>,
    /// A file or a data URI. The first buffer of a GLB has none: its bytes are in the container.
    pub uri: Option<String>,
}

/// A range of the bytes of a buffer.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct BufferView {
    pub name: Option<String>,
    pub buffer: Index,
    pub byte_offset: Option<u64>,
    pub byte_length: u64,
    /// From the start of an element to that of the next one; without it, they follow each other tightly.
    pub byte_stride: Option<usize>,
}
