//! Typed arrays in buffers: all component types, strides and sparse ones, straight from bytes.

use super::buffers::{Buffers, View, part};
use super::document::{Accessor, ComponentType, Document, ElementType, Sparse};
use super::{Part, named};
use std::cell::Cell;

/// Elements that may be taken from accessors whatever the buffers hold.
const FREE_ELEMENTS: u64 = 1 << 22;

/// Beyond, so many for each byte of the buffers. A byte holds at most one index, and several meshes may share it.
const ELEMENTS_A_BYTE: u64 = 16;

/// Reads accessors.
pub(super) struct Accessors<'a> {
    pub(super) root: &'a Document,
    buffers: &'a Buffers<'a>,
    pub(super) budget: Budget,
}

/// Elements that may still be taken. Accessors without bytes, and ones that are used again and again, would otherwise
/// make a small file fill the memory.
pub(super) struct Budget(Cell<u64>);

impl Budget {
    /// Counts elements that are about to be stored.
    pub(super) fn spend(&self, elements: u64) -> Result<(), String> {
        let left = self.0.get().checked_sub(elements).ok_or(
            "its accessors hold, or are used for, far more elements than its buffers have bytes; mend the file",
        )?;
        self.0.set(left);
        Ok(())
    }
}

/// Elements in a buffer, checked to lie within: one every `stride` bytes, the last one whole.
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    count: usize,
}

impl<'a> Accessors<'a> {
    pub(super) fn new(root: &'a Document, buffers: &'a Buffers<'a>) -> Accessors<'a> {
        let elements = FREE_ELEMENTS.saturating_add(buffers.total().saturating_mul(ELEMENTS_A_BYTE));
        Accessors { root, buffers, budget: Budget(Cell::new(elements)) }
    }

    /// The elements of an accessor with `N` components each (16 are a matrix), as numbers: normalised ones from -1 or 0
    /// to 1, others as they are.
    pub(super) fn read<const N: usize, T: Clone>(
        &self,
        number: usize,
        map: impl Fn([f32; N]) -> T + Copy,
    ) -> Result<Vec<T>, String> {
        let accessor = named(&self.root.accessors, number, "accessor")?;
        let inner = || {
            let component = component_type(accessor)?;
            // Columns of such matrices lie at multiples of four bytes where components are floats.
            let is_matrix = N == 16 && accessor.element_type == Some(ElementType::Mat4);
            if N == 16 && !(is_matrix && component == ComponentType::F32) {
                return Err("it must hold matrices of 4 x 4 floats; export it again".into());
            }
            if !is_matrix && components(accessor)? != N {
                return Err(format!("it has {} components, not {N}; export it again", components(accessor)?));
            }
            let size = N * component_size(component);
            let count = self.count(accessor)?;
            let (normalized, base) = (accessor.normalized, self.base(accessor, size, count)?);
            let mut all = match base {
                Some(elements) => decode(&elements, component, normalized, map),
                None => vec![map([0.0; N]); count],
            };
            if let Some(sparse) = &accessor.sparse {
                let (places, values) = self.sparse(sparse, size, count)?;
                for (place, value) in places.into_iter().zip(decode(&values, component, normalized, map)) {
                    all[place as usize] = value;
                }
            }
            Ok(all)
        };
        inner().map_err(|problem| self.at(number, problem))
    }

    /// The components of an element of an accessor.
    pub(super) fn components(&self, number: usize) -> Result<usize, String> {
        let accessor = named(&self.root.accessors, number, "accessor")?;
        components(accessor).map_err(|problem| self.at(number, problem))
    }

    /// The indices of an accessor; the caller checks what they index.
    pub(super) fn indices(&self, number: usize) -> Result<Vec<u32>, String> {
        let accessor = named(&self.root.accessors, number, "accessor")?;
        let inner = || {
            let component = component_type(accessor)?;
            if components(accessor)? != 1 {
                return Err("indices must be a SCALAR; export it again".to_string());
            }
            let size = component_size(component);
            let count = self.count(accessor)?;
            let mut all = match self.base(accessor, size, count)? {
                Some(elements) => whole_numbers(&elements, component)?,
                None => vec![0; count],
            };
            if let Some(sparse) = &accessor.sparse {
                let (places, values) = self.sparse(sparse, size, count)?;
                for (place, value) in places.into_iter().zip(whole_numbers(&values, component)?) {
                    all[place as usize] = value;
                }
            }
            Ok(all)
        };
        inner().map_err(|problem| self.at(number, problem))
    }

    fn at(&self, number: usize, problem: String) -> String {
        let name = self.root.accessors.get(number).and_then(|a| a.name.as_deref());
        format!("{}: {problem}", Part::new("accessor", number, name))
    }

    /// How many elements an accessor has; they are counted as taken.
    fn count(&self, accessor: &Accessor) -> Result<usize, String> {
        self.budget.spend(accessor.count)?;
        usize::try_from(accessor.count).map_err(|_| "it has too many elements".to_string())
    }

    /// The elements before sparse ones replace some; `None` where they are all zero.
    fn base(&self, accessor: &Accessor, size: usize, count: usize) -> Result<Option<Elements<'_>>, String> {
        let Some(view) = accessor.buffer_view else { return Ok(None) };
        let view = self.buffers.view(view.value())?;
        elements(&view, accessor.byte_offset.unwrap_or_default(), size, count).map(Some)
    }

    /// Where a sparse accessor differs from its base, each place less than `count`, and its elements there.
    fn sparse(&self, sparse: &Sparse, size: usize, count: usize) -> Result<(Vec<u32>, Elements<'_>), String> {
        let inner = || {
            let many = usize::try_from(sparse.count).ok().filter(|&many| many <= count);
            let many = many.ok_or_else(|| format!("{} places for {count} elements", sparse.count))?;
            let Some(component) = sparse.indices.component_type else {
                return Err("its indices have an unknown component type".into());
            };
            let view = self.buffers.view(sparse.indices.buffer_view.value())?;
            let offset = sparse.indices.byte_offset;
            let places =
                whole_numbers(&elements(&view, offset, component_size(component), many)?, component)?;
            if let Some(place) = places.iter().find(|&&place| place as usize >= count) {
                return Err(format!("place {place} does not exist; there are {count}"));
            }
            let view = self.buffers.view(sparse.values.buffer_view.value())?;
            Ok((places, elements(&View { stride: None, ..view }, sparse.values.byte_offset, size, many)?))
        };
        inner().map_err(|problem: String| format!("its sparse part: {problem}"))
    }
}

/// Elements of a view, checked to lie within it.
fn elements<'a>(view: &View<'a>, offset: u64, size: usize, count: usize) -> Result<Elements<'a>, String> {
    let stride = view.stride.unwrap_or(size);
    if stride < size {
        return Err(format!("its elements of {size} bytes are {stride} apart; export it again"));
    }
    let length = count.checked_sub(1).map_or(Some(0), |last| last.checked_mul(stride)?.checked_add(size));
    let bytes = length.and_then(|length| part(view.bytes, offset, length as u64)).ok_or_else(|| {
        format!(
            "{count} elements of {size} bytes, {stride} apart from byte {offset} on, do not fit its bufferView of {} \
             bytes; export it again",
            view.bytes.len()
        )
    })?;
    Ok(Elements { bytes, stride, count })
}

fn component_type(accessor: &Accessor) -> Result<ComponentType, String> {
    accessor.component_type.ok_or_else(|| "its component type is unknown; export it again".into())
}

fn component_size(component: ComponentType) -> usize {
    match component {
        ComponentType::I8 | ComponentType::U8 => 1,
        ComponentType::I16 | ComponentType::U16 => 2,
        ComponentType::U32 | ComponentType::F32 => 4,
    }
}

fn components(accessor: &Accessor) -> Result<usize, String> {
    match accessor.element_type {
        Some(ElementType::Scalar) => Ok(1),
        Some(ElementType::Vec2) => Ok(2),
        Some(ElementType::Vec3) => Ok(3),
        Some(ElementType::Vec4) => Ok(4),
        Some(ElementType::Mat2 | ElementType::Mat3 | ElementType::Mat4) => {
            Err("it holds matrices, not vectors; export it again".into())
        }
        None => Err("its type is unknown; export it again".into()),
    }
}

fn decode<const N: usize, T>(
    elements: &Elements<'_>,
    component: ComponentType,
    normalized: bool,
    map: impl Fn([f32; N]) -> T,
) -> Vec<T> {
    use ComponentType::{F32, I8, I16, U8, U16, U32};
    match (component, normalized) {
        (F32, _) => each(elements, f32::from_le_bytes, map),
        (U8, false) => each(elements, |[b]: [u8; 1]| f32::from(b), map),
        (U8, true) => each(elements, |[b]: [u8; 1]| f32::from(b) / 255.0, map),
        (I8, false) => each(elements, |[b]: [u8; 1]| f32::from(b as i8), map),
        (I8, true) => each(elements, |[b]: [u8; 1]| (f32::from(b as i8) / 127.0).max(-1.0), map),
        (U16, false) => each(elements, |b| f32::from(u16::from_le_bytes(b)), map),
        (U16, true) => each(elements, |b| f32::from(u16::from_le_bytes(b)) / 65_535.0, map),
        (I16, false) => each(elements, |b| f32::from(i16::from_le_bytes(b)), map),
        (I16, true) => each(elements, |b| (f32::from(i16::from_le_bytes(b)) / 32_767.0).max(-1.0), map),
        (U32, _) => each(elements, |b| u32::from_le_bytes(b) as f32, map),
    }
}

/// Elements of `N` components of `S` bytes. Tight ones go through `chunks_exact`, of which the compiler makes a copy.
fn each<const N: usize, const S: usize, T>(
    elements: &Elements<'_>,
    value: impl Fn([u8; S]) -> f32,
    map: impl Fn([f32; N]) -> T,
) -> Vec<T> {
    let component = |bytes: &[u8], k: usize| value(std::array::from_fn(|i| bytes[k * S + i]));
    let element = |bytes: &[u8]| {
        let bytes = &bytes[..N * S];
        map(std::array::from_fn(|k| component(bytes, k)))
    };
    if elements.stride == N * S {
        elements.bytes.chunks_exact(N * S).map(element).collect()
    } else {
        elements.bytes.chunks(elements.stride).take(elements.count).map(element).collect()
    }
}

fn whole_numbers(elements: &Elements<'_>, component: ComponentType) -> Result<Vec<u32>, String> {
    fn each<const S: usize>(elements: &Elements<'_>, value: impl Fn([u8; S]) -> u32) -> Vec<u32> {
        let element = |bytes: &[u8]| value(std::array::from_fn(|i| bytes[i]));
        if elements.stride == S {
            elements.bytes.chunks_exact(S).map(element).collect()
        } else {
            elements.bytes.chunks(elements.stride).take(elements.count).map(element).collect()
        }
    }
    match component {
        ComponentType::U8 => Ok(each(elements, |[b]: [u8; 1]| u32::from(b))),
        ComponentType::U16 => Ok(each(elements, |b| u32::from(u16::from_le_bytes(b)))),
        ComponentType::U32 => Ok(each(elements, u32::from_le_bytes)),
        _ => Err("indices must be unsigned whole numbers; export it again".into()),
    }
}
