//! The JSON schema of the scene format (draft 2020-12): made from the types that read it, so that it says what they read.
//! Files are checked by it (`rules.rs`, `check.rs`), and scenes/REFERENCE.md is printed from it (`reference.rs`).

use super::format::SceneFile;
use schemars::Schema;
use schemars::generate::SchemaSettings;
use schemars::transform::{Transform, transform_subschemas};
use serde_json::{Map, Value, json};

/// Where the schema is published.
const ID: &str = "https://raw.githubusercontent.com/eosphor/eosphor/main/scenes/schema.json";

/// The JSON schema of scene files, as `eosphor schema` prints it.
pub fn scene_schema() -> String {
    // The alternate form of a value is the pretty one.
    format!("{:#}\n", Value::from(schema()))
}

/// The schema of a whole file.
pub(super) fn schema() -> Schema {
    let settings = SchemaSettings::draft2020_12().with_transform(Tidy);
    let mut schema = settings.into_generator().into_root_schema_for::<SceneFile>();
    schema.insert("title".into(), "Eosphor scene".into());
    for (name, part) in schema.get_mut("$defs").and_then(Value::as_object_mut).into_iter().flatten() {
        part["title"] = title(name).into();
    }
    let mut whole = Map::new();
    whole.insert("$schema".into(), schema.remove("$schema").unwrap_or_default());
    whole.insert("$id".into(), ID.into());
    whole.append(schema.ensure_object());
    whole.into()
}

/// Comments and constants of Rust in the form that readers of JSON expect.
#[derive(Clone, Debug)]
struct Tidy;

impl Transform for Tidy {
    fn transform(&mut self, schema: &mut Schema) {
        transform_subschemas(self, schema);
        // How wide the numbers of the program are says nothing about the file.
        schema.remove("format");
        if let Some(Value::String(text)) = schema.get_mut("description") {
            *text = plain(text);
        }
        // Defaults that say "nothing" or repeat those of an inner object.
        let says_nothing = |d: &Value| d.is_null() || d.is_object() || *d == json!([]);
        if schema.get("default").is_some_and(says_nothing) {
            schema.remove("default");
        }
        for key in ["default", "minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum"] {
            if let Some(number) = schema.get_mut(key) {
                shorten(number);
            }
        }
        if schema.get("properties").is_some() && schema.get("additionalProperties").is_none() {
            schema.insert("additionalProperties".into(), false.into());
        }
    }
}

/// The name of a type in words.
fn title(name: &str) -> String {
    let word = |(i, c): (usize, char)| match c {
        'A'..='Z' if i > 0 => [' ', c.to_ascii_lowercase()].into_iter().collect(),
        _ => String::from(c),
    };
    name.chars().enumerate().map(word).collect()
}

/// A comment of Rust without its links and line ends: [`super::Camera::look_at`] becomes `look-at`.
fn plain(comment: &str) -> String {
    let mut text = String::new();
    for (i, part) in comment.split("[`").enumerate() {
        match part.split_once("`]") {
            Some((link, rest)) if i > 0 => {
                let name = link.rsplit("::").next().unwrap_or(link);
                let key = title(name).replace(['_', ' '], "-").to_lowercase();
                text += &format!("`{key}`{rest}");
            }
            _ => text += part,
        }
    }
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Single-precision numbers with the fewest digits, whole ones without a point.
fn shorten(value: &mut Value) {
    match value {
        Value::Array(items) => items.iter_mut().for_each(shorten),
        Value::Number(number) => {
            let Some(x) = number.as_f64() else { return };
            if x.fract() == 0.0 && x.abs() < 1e15 {
                *value = (x as i64).into();
            } else if let Ok(short) = (x as f32).to_string().parse::<f64>() {
                *value = short.into();
            }
        }
        _ => {}
    }
}

/// Turns "one of these objects of one key" into keys of which one must be there, which stands beside other keys.
pub(super) fn lift_kinds(schema: &mut Schema) {
    let Some(Value::Array(kinds)) = schema.remove("oneOf") else { return };
    let (mut keys, mut required) = (Map::new(), Vec::new());
    for kind in kinds {
        let Value::Object(mut kind) = kind else { continue };
        let description = kind.remove("description");
        let Some(Value::Object(properties)) = kind.remove("properties") else { continue };
        for (key, mut contents) in properties {
            if let (Some(object), Some(text)) = (contents.as_object_mut(), &description) {
                object.insert("description".into(), text.clone());
            }
            required.push(json!({ "required": [key] }));
            keys.insert(key, contents);
        }
    }
    if let Some(Value::Object(beside)) = schema.get_mut("properties") {
        keys.append(beside);
        *beside = keys;
    }
    schema.insert("oneOf".into(), required.into());
}
