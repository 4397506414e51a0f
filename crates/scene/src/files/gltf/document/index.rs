//! References from one item to another.

use serde::de::{Deserialize, Deserializer, Error, Unexpected, Visitor};
use std::fmt;

/// The place of an item in one of the document's arrays, counted from 0. Whether there is such an item is checked where
/// it is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Index(u32);

impl Index {
    pub fn value(self) -> usize {
        self.0 as usize
    }
}

impl<'de> Deserialize<'de> for Index {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Index, D::Error> {
        struct Whole;
        impl Visitor<'_> for Whole {
            type Value = Index;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an index: a whole number from 0 on")
            }

            fn visit_u64<E: Error>(self, number: u64) -> Result<Index, E> {
                let index = u32::try_from(number).map(Index);
                index.map_err(|_| E::invalid_value(Unexpected::Unsigned(number), &"an index below 2^32"))
            }
        }
        deserializer.deserialize_u64(Whole)
    }
}
