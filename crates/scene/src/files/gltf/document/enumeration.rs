//! Members whose values the specification lists: strings, and numbers that come from OpenGL.

use serde::de::{Deserializer, Error, Unexpected, Visitor};
use std::fmt;
use std::marker::PhantomData;

/// A type of which the specification lists all values.
pub(super) trait Enumeration: Copy + 'static {
    const TERMS: Terms<Self>;
}

/// How files write the values of an enumeration.
pub(super) enum Terms<T: 'static> {
    Names(&'static [(&'static str, T)]),
    Codes(&'static [(u64, T)]),
}

/// Reads a value for `#[serde(deserialize_with)]`. One that the specification does not list is `None`: it is refused
/// where it is used, and does no harm where it is not.
pub(super) fn listed<'de, T: Enumeration, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<T>, D::Error> {
    deserializer.deserialize_any(Listed(PhantomData))
}

struct Listed<T>(PhantomData<T>);

impl<T: Enumeration> Visitor<'_> for Listed<T> {
    type Value = Option<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let terms: Vec<String> = match T::TERMS {
            Terms::Names(names) => names.iter().map(|(name, _)| format!("{name:?}")).collect(),
            Terms::Codes(codes) => codes.iter().map(|(code, _)| code.to_string()).collect(),
        };
        write!(f, "one of {}", terms.join(", "))
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<Option<T>, E> {
        match T::TERMS {
            Terms::Names(names) => {
                Ok(names.iter().find(|(known, _)| *known == name).map(|(_, value)| *value))
            }
            Terms::Codes(_) => Err(E::invalid_type(Unexpected::Str(name), &self)),
        }
    }

    fn visit_u64<E: Error>(self, code: u64) -> Result<Option<T>, E> {
        match T::TERMS {
            Terms::Codes(codes) => {
                Ok(codes.iter().find(|(known, _)| *known == code).map(|(_, value)| *value))
            }
            Terms::Names(_) => Err(E::invalid_type(Unexpected::Unsigned(code), &self)),
        }
    }

    fn visit_unit<E: Error>(self) -> Result<Option<T>, E> {
        Ok(None)
    }
}
