//! What the schema of scene files says of types that JSON writes in another way than Rust keeps them.

#![allow(
    clippy::approx_constant,
    reason = "an example shows people a rotation in the digits that files have"
)]

use super::INDICES_OF_REFRACTION;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use std::borrow::Cow;

/// Defines types that stand for others in schemas.
macro_rules! schema_types {
    ($($(#[$doc:meta])* $name:ident = { $($schema:tt)* })+) => {$(
        $(#[$doc])*
        pub(crate) enum $name {}

        impl JsonSchema for $name {
            fn schema_name() -> Cow<'static, str> {
                stringify!($name).into()
            }

            fn json_schema(_: &mut SchemaGenerator) -> Schema {
                json_schema!({ $($schema)* })
            }
        }
    )+};
}

schema_types! {
    /// For [`eosphor_core::math::Vec3`].
    Vector = {
        "description": "A point or a direction: x, y and z, right-handed.",
        "type": "array",
        "items": { "type": "number" },
        "minItems": 3,
        "maxItems": 3,
        "examples": [[0, 1.5, -2]]
    }

    /// For rotations.
    Quaternion = {
        "description": "A rotation: x, y, z and w of a quaternion.",
        "type": "array",
        "items": { "type": "number" },
        "minItems": 4,
        "maxItems": 4,
        "examples": [[0, 0.7071068, 0, 0.7071068]]
    }

    /// For colours.
    Color = {
        "description": "Linear red, green and blue.",
        "type": "array",
        "items": { "type": "number", "minimum": 0 },
        "minItems": 3,
        "maxItems": 3,
        "examples": [[0.8, 0.5, 0.2]]
    }

    /// For colours of at most 1.
    Share = {
        "description": "A share of linear red, green and blue.",
        "type": "array",
        "items": { "type": "number", "minimum": 0, "maximum": 1 },
        "minItems": 3,
        "maxItems": 3,
        "examples": [[0.9, 1, 0.95]]
    }

    /// For [`super::Transform::scale`].
    Scale = {
        "description": "A number for all axes, or one for x, y and z each.",
        "anyOf": [
            { "type": "number" },
            { "type": "array", "items": { "type": "number" }, "minItems": 3, "maxItems": 3 }
        ],
        "examples": [2, [1, 1, -1]]
    }

    /// For indices of refraction.
    IndexOfRefraction = {
        "description": "A number, or a substance by its name.",
        "anyOf": [
            { "type": "number", "minimum": 0.01, "maximum": 100 },
            { "type": "string", "enum": INDICES_OF_REFRACTION.map(|(name, _)| name) }
        ],
        "examples": ["water", 1.7]
    }
}
