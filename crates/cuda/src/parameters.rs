//! What a kernel takes: arrays, which are copied to the device first, and numbers, in the kernel's order.

use std::mem::MaybeUninit;

/// Arrays start at multiples of this: more than any item asks for, and whole cache lines.
const ALIGNMENT: u64 = 256;

/// What the kernel's declaration says of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A reference to the first item of an array whose items have this alignment.
    Array { align: usize },
    /// `u64`.
    Count,
    /// `u32`.
    Number,
}

/// Parameters of a kernel, and where each array shall lie in one piece of the device's memory. Nothing is copied before
/// it is known how much that is.
#[derive(Default)]
pub(crate) struct Parameters<'a> {
    names: Vec<&'static str>,
    kinds: Vec<Kind>,
    /// Numbers as they are; of arrays, their offset.
    values: Vec<u64>,
    pieces: Vec<Piece<'a>>,
    bytes: u64,
}

/// An array and its offset in the device's memory.
pub(crate) struct Piece<'a> {
    pub(crate) offset: u64,
    /// Not necessarily initialised: types may have padding.
    pub(crate) bytes: &'a [MaybeUninit<u8>],
}

impl<'a> Parameters<'a> {
    /// An array. `T` is one of core's types, which are `repr(C)` without pointers, so that host and device agree on
    /// sizes, alignment and byte order. An empty one becomes a place that is never read, because kernels take references.
    pub(crate) fn array<T: Copy>(&mut self, name: &'static str, items: &'a [T]) {
        const { assert!(align_of::<T>() as u64 <= ALIGNMENT) };
        // SAFETY: any memory can be looked at as bytes that need not be initialised.
        let bytes = unsafe { std::slice::from_raw_parts(items.as_ptr().cast(), size_of_val(items)) };
        let offset = self.bytes.next_multiple_of(ALIGNMENT);
        self.pieces.push(Piece { offset, bytes });
        self.bytes = offset + bytes.len().max(size_of::<T>()) as u64;
        self.push(name, Kind::Array { align: align_of::<T>() }, offset);
    }

    /// How many items an array has.
    pub(crate) fn count(&mut self, name: &'static str, items: usize) {
        self.push(name, Kind::Count, items as u64);
    }

    /// A number.
    pub(crate) fn number(&mut self, name: &'static str, value: u32) {
        self.push(name, Kind::Number, value.into());
    }

    /// What the parameters are called, in order.
    pub(crate) fn names(&self) -> &[&'static str] {
        &self.names
    }

    /// Puts the values of these parameters in place of those of the same names among `values`, whose names are `names`.
    pub(crate) fn replace(&self, base: u64, names: &[&'static str], values: &mut [u64]) {
        for (own, value) in self.names.iter().zip(self.values(base)) {
            let place = names.iter().position(|name| name == own);
            values[place.expect("every kernel has this parameter")] = value;
        }
    }

    fn push(&mut self, name: &'static str, kind: Kind, value: u64) {
        self.names.push(name);
        self.kinds.push(kind);
        self.values.push(value);
    }

    /// What was added, in order.
    #[cfg(test)]
    pub(crate) fn kinds(&self) -> &[Kind] {
        &self.kinds
    }

    /// Memory that the arrays take.
    pub(crate) fn bytes(&self) -> u64 {
        self.bytes
    }

    /// What is to be copied where.
    pub(crate) fn pieces(&self) -> &[Piece<'a>] {
        &self.pieces
    }

    /// The parameters with the arrays in memory that starts at `base`. The driver reads as many of the eight bytes as the
    /// parameter has, the lower ones first.
    pub(crate) fn values(&self, base: u64) -> Vec<u64> {
        let value = |(kind, value): (&Kind, &u64)| match kind {
            Kind::Array { .. } => base + value,
            _ => *value,
        };
        self.kinds.iter().zip(&self.values).map(value).collect()
    }
}

// The lower bytes must come first.
const _: () = assert!(cfg!(target_endian = "little"));

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_have_parameters_of_their_own() {
        let (all, own) = ([1u8; 4], [2u8; 4]);
        let mut parameters = Parameters::default();
        parameters.number("first", 1);
        parameters.array("items", &all);
        parameters.count("count", 4);
        parameters.number("last", 2);
        let mut values = parameters.values(1000);
        let mut frame = Parameters::default();
        frame.number("last", 3);
        frame.array("items", &own);
        frame.replace(5000, parameters.names(), &mut values);
        assert_eq!(values, [1, 5000, 4, 3]);
    }

    #[test]
    fn arrays_lie_apart_and_aligned() {
        let (bytes, floats, nothing) = ([1u8; 300], [0.5f32; 3], [0u64; 0]);
        let mut parameters = Parameters::default();
        parameters.array("bytes", &bytes);
        parameters.number("seven", 7);
        parameters.array("nothing", &nothing);
        parameters.array("floats", &floats);
        parameters.number("nine", 9);
        parameters.count("three", 3);
        assert_eq!(parameters.bytes(), 512 + 256 + 12);
        assert_eq!(parameters.values(1 << 40)[..2], [1 << 40, 7]);
        assert_eq!(parameters.values(4096)[2..], [4096 + 512, 4096 + 768, 9, 3]);
        let pieces: Vec<_> = parameters.pieces().iter().map(|p| (p.offset, p.bytes.len())).collect();
        assert_eq!(pieces, [(0, 300), (512, 0), (768, 12)]);
        assert_eq!(parameters.kinds()[2..4], [Kind::Array { align: 8 }, Kind::Array { align: 4 }]);
    }
}
