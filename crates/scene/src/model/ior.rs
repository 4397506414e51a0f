//! Indices of refraction by name.

use serde::de::{self, Deserializer, Visitor};
use std::fmt;

/// Known indices of refraction against vacuum: name and value.
pub const INDICES_OF_REFRACTION: [(&str, f32); 13] = [
    ("vacuum", 1.0),
    ("air", 1.0002),
    ("liquid-helium", 1.025),
    ("ice", 1.31),
    ("water", 1.333),
    ("cornea", 1.38),
    ("borosilicate", 1.47),
    ("crown-glass", 1.52),
    ("amber", 1.55),
    ("flint", 1.612),
    ("crown-glass-impure", 1.65),
    ("sapphire", 1.771),
    ("diamond", 2.419),
];

/// The index of refraction of a named substance.
pub fn index_of_refraction(name: &str) -> Option<f32> {
    INDICES_OF_REFRACTION.iter().find(|(known, _)| *known == name).map(|(_, ior)| *ior)
}

/// Reads a number or the name of a substance.
pub(super) fn number_or_name<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f32, D::Error> {
    struct Ior;
    impl Visitor<'_> for Ior {
        type Value = f32;
        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            write!(f, "an index of refraction: a number or one of {}", names())
        }
        fn visit_f64<E: de::Error>(self, x: f64) -> Result<f32, E> {
            Ok(x as f32)
        }
        fn visit_u64<E: de::Error>(self, x: u64) -> Result<f32, E> {
            Ok(x as f32)
        }
        fn visit_i64<E: de::Error>(self, x: i64) -> Result<f32, E> {
            Ok(x as f32)
        }
        fn visit_str<E: de::Error>(self, name: &str) -> Result<f32, E> {
            index_of_refraction(name).ok_or_else(|| E::invalid_value(de::Unexpected::Str(name), &self))
        }
    }
    deserializer.deserialize_any(Ior)
}

fn names() -> String {
    INDICES_OF_REFRACTION.map(|(name, _)| name).join(", ")
}
