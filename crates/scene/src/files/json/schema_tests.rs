//! The schema says what is read: every key of it is read, its ranges are those of the model, and the committed copies are
//! what the program prints.

use super::rules::{Keys, Kind, RULES, Range, Rule};
use super::schema::schema;
use super::{check, parse, scene_reference, scene_schema};
use crate::files::source::Source;
use crate::files::{LoadOptions, load_from};
use crate::model::RenderSettings;
use eosphor_core::settings::Integrator;
use serde_json::{Value, json};
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// The folder of example scenes; a crate from the registry has none.
fn scenes() -> Option<PathBuf> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    folder.is_dir().then_some(folder)
}

/// A whole scene around a part of it; what examples name is there.
fn document(key: &str, part: Value) -> Value {
    let mut whole = json!({
        "eosphor": 2,
        "materials": { "red": { "matte": { "color": [1, 0, 0] } } },
        "meshes": [{ "file": "chair.obj" }],
    });
    whole[key] = part;
    whole
}

fn load(whole: &Value) -> Result<(), String> {
    const OBJ: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    const PPM: &[u8] = b"P3\n1 1\n255\n1 2 3\n";
    let mut files = vec![(PathBuf::from("s.json"), Cow::Owned(whole.to_string().into_bytes()))];
    files.push((PathBuf::from("chair.obj"), Cow::Borrowed(OBJ)));
    files.extend(
        ["wood.png", "leaf.png", "bumps.png", "sky.hdr"]
            .map(|name| (PathBuf::from(name), Cow::Borrowed(PPM))),
    );
    let loaded = load_from(Source::Memory(files), Path::new("s.json"), &LoadOptions::default());
    loaded.map(|_| ()).map_err(|error| format!("{error}\n{whole:#}"))
}

/// The part of the schema that a reference leads to.
fn resolved<'a>(whole: &'a Value, part: &'a Value) -> &'a Value {
    match part["$ref"].as_str().and_then(|name| name.strip_prefix("#/$defs/")) {
        Some(name) => resolved(whole, &whole["$defs"][name]),
        None => part,
    }
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

/// Values that a part of the schema takes, so that every key in it is there once.
fn values(whole: &Value, part: &Value) -> Vec<Value> {
    let part = if part["examples"].is_array() { part } else { resolved(whole, part) };
    let mut found: Vec<Value> = list(&part["examples"]).to_vec();
    // Strings beside objects are file names, which examples know.
    if found.len() > 1 && part["anyOf"].is_array() {
        found.extend(
            list(&part["anyOf"])
                .iter()
                .filter(|b| b["properties"].is_object())
                .flat_map(|b| values(whole, b)),
        );
        return found;
    }
    let branches = list(&part["anyOf"]).iter().chain(list(&part["oneOf"]));
    found.extend(
        branches
            .filter(|b| b["required"].is_null() || b["properties"].is_object())
            .flat_map(|b| values(whole, b)),
    );
    if let Some(properties) = part["properties"].as_object() {
        let required = list(&part["required"]);
        let mut base = json!({});
        for key in required.iter().filter_map(Value::as_str) {
            base[key] = values(whole, &properties[key]).swap_remove(0);
        }
        let base = found.iter().find(|example| example.is_object()).cloned().unwrap_or(base);
        let kinds = list(&part["oneOf"]).iter().filter_map(|kind| kind["required"][0].as_str());
        let kinds: Vec<&str> = kinds.filter(|kind| properties.contains_key(*kind)).collect();
        for (key, contents) in properties {
            for value in values(whole, contents) {
                let mut object = base.clone();
                let map = object.as_object_mut().unwrap();
                if kinds.contains(&key.as_str()) {
                    map.retain(|key, _| !kinds.contains(&key.as_str()));
                }
                for pair in list(&part["allOf"]).iter().map(|part| list(&part["not"]["required"])) {
                    if pair.iter().any(|excluding| excluding == key) {
                        map.retain(|key, _| pair.iter().all(|excluded| excluded != key));
                    }
                }
                match key.as_str() {
                    "texture" => drop(map.remove("textures")),
                    "textures" => drop(map.remove("texture")),
                    _ => {}
                }
                map.insert(key.clone(), value);
                // One of these must be there.
                if let Some(&first) =
                    kinds.first().filter(|_| kinds.iter().all(|kind| !map.contains_key(*kind)))
                {
                    map.insert(first.into(), values(whole, &properties[first]).swap_remove(0));
                }
                found.push(object);
            }
        }
    }
    if part["additionalProperties"].is_object() {
        found.extend(values(whole, &part["additionalProperties"]).into_iter().map(|v| json!({ "red": v })));
    }
    if part["items"].is_object() && part["minItems"].is_null() {
        found.extend(values(whole, &part["items"]).into_iter().map(|item| json!([item])));
    }
    found.extend(list(&part["enum"]).iter().cloned());
    found.extend(part.get("const").cloned());
    if found.is_empty() {
        let kind = part["type"].as_str().or(part["type"][0].as_str()).unwrap_or_default();
        let length = part["minItems"].as_u64().unwrap_or_default() as usize;
        found = match kind {
            "boolean" => vec![true.into(), false.into()],
            "number" | "integer" => {
                let bounds = [&part["minimum"], &part["maximum"]].into_iter().filter(|b| !b.is_null());
                bounds.cloned().chain([1.into()]).collect()
            }
            "null" => vec![Value::Null],
            "string" => vec!["words".into()],
            "array" => vec![vec![values(whole, &part["items"]).swap_remove(0); length].into()],
            other => panic!("{other}: {part}"),
        };
    }
    found
}

#[test]
fn every_key_of_the_schema_is_read() {
    let whole = Value::from(schema());
    let mut count = 0;
    for (key, part) in whole["properties"].as_object().unwrap() {
        for value in values(&whole, part) {
            let mut document = document(key, value);
            // A matrix of equal rows is none.
            let text = document.to_string();
            if text.contains("\"matrix\"") {
                continue;
            }
            if key == "meshes" && text.contains("glb") {
                document = serde_json::from_str(&text.replace("chair.glb", "chair.obj")).unwrap();
            }
            // Few keys may stand beside a base.
            if let Some(base) = document.get("base") {
                document = json!({ "eosphor": 2, "base": base });
            }
            // A light that moves must be there.
            if let Some(motions) = document.pointer_mut("/animation/lights").and_then(Value::as_array_mut) {
                motions.iter_mut().for_each(|motion| motion["light"] = 0.into());
                document["lights"] = json!([{ "point": { "position": [0, 3, 0], "color": [1, 1, 1] } }]);
            }
            // What only path tracing reads needs it.
            if let Some(settings) = document.get_mut("settings").and_then(Value::as_object_mut)
                && RenderSettings::keys_not_read(Integrator::Whitted)
                    .iter()
                    .any(|key| settings.contains_key(*key))
            {
                settings.insert("integrator".into(), "path".into());
            }
            load(&document).unwrap();
            count += 1;
        }
    }
    assert!(count > 200, "{count} documents");
}

/// Calls with the path, and the range of the number there.
fn ranges(path: &str, rule: &Rule, visit: &mut impl FnMut(&str, &Range)) {
    let under = |key: &str| format!("{path}/{key}");
    match &rule.kind {
        Kind::Number(range) => visit(path, range),
        Kind::List { item, .. } => ranges(&under("[]"), item, visit),
        Kind::Names(rule) => ranges(&under("red"), rule, visit),
        Kind::Object(Keys { keys, .. }) | Kind::Choice { keys, .. } => {
            keys.iter().for_each(|(key, rule)| ranges(&under(key), rule, visit));
        }
        Kind::Union(rules) => rules.iter().for_each(|rule| ranges(path, rule, visit)),
        Kind::Any | Kind::Flag | Kind::Text => {}
    }
}

#[test]
fn whole_numbers_have_bounds() {
    let mut count = 0;
    ranges("", &RULES, &mut |path, range| {
        count += 1;
        let bounded = range.min.is_some() && range.max.is_some();
        assert!(!range.whole || bounded || path == "/eosphor", "{path}: {range:?}");
    });
    assert!(count > 100, "{count} numbers");
}

/// The bounds that the model itself checks, one by one, against those of the schema.
#[test]
fn the_ranges_are_those_of_the_model() {
    let setting = |key: &str, x: f64| document("settings", json!({ key: x }));
    for (key, lowest, highest) in [
        ("energy-threshold", 0.0, 1.0),
        ("crease-degrees", 0.0, 180.0),
        ("ambient", 0.0, 1e6),
        ("exposure", -64.0, 64.0),
    ] {
        load(&setting(key, lowest)).unwrap();
        load(&setting(key, highest)).unwrap();
        for wrong in [lowest - 0.01, highest + 1.0] {
            let error = load(&setting(key, wrong)).unwrap_err();
            assert!(error.contains(&format!("it must be {lowest} to {highest}")), "{error}");
        }
    }
    let mut text = Vec::new();
    ranges("", &RULES, &mut |path, range| {
        if path.starts_with("/settings") {
            text.push(format!("{path} {:?} {:?}", range.min, range.max));
        }
    });
    assert!(text.contains(&"/settings/samples Some(1.0) Some(65536.0)".into()), "{text:?}");
    assert!(text.contains(&"/settings/size/[] Some(1.0) Some(65535.0)".into()), "{text:?}");
}

#[test]
fn the_texts_are_for_readers_of_json() {
    let text = scene_schema();
    for word in ["None", "::", "[`", "`Some", "super", "serde", "Vec3", "f32"] {
        assert!(!text.contains(word), "the schema says {word}");
    }
    fn described(name: &str, part: &Value) {
        for (key, contents) in part["properties"].as_object().into_iter().flatten() {
            let is_variant = part["oneOf"].is_null() && part["description"].is_null();
            assert!(is_variant || contents["description"].is_string(), "{name}.{key} has no description");
            described(key, contents);
        }
    }
    let whole = Value::from(schema());
    described("scene", &whole);
    for (name, part) in whole["$defs"].as_object().unwrap() {
        assert!(part["description"].is_string() && part["title"].is_string(), "{name}");
        described(name, part);
    }
}

#[test]
fn example_scenes_follow_the_schema() {
    let Some(folder) = scenes() else { return };
    let mut count = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "json") && !path.ends_with("schema.json") {
            let text = std::fs::read_to_string(&path).unwrap();
            check::check(&RULES, &parse::parse(&text).unwrap())
                .unwrap_or_else(|e| panic!("{path:?}: {}", e.message));
            count += 1;
        }
    }
    assert!(count >= 4);
}

/// Blocks of scenes/README.md are whole scenes or some of their keys.
#[test]
fn the_examples_of_the_tutorial_follow_the_schema() {
    let Some(folder) = scenes() else { return };
    let page = std::fs::read_to_string(folder.join("README.md")).unwrap();
    let blocks: Vec<&str> =
        page.split("```json\n").skip(1).filter_map(|rest| rest.split("```").next()).collect();
    for block in &blocks {
        let whole =
            if block.starts_with('{') { block.to_string() } else { format!("{{\"eosphor\": 2, {block}}}") };
        let root = parse::parse(&whole).unwrap_or_else(|e| panic!("{block}: {}", e.message));
        check::check(&RULES, &root).unwrap_or_else(|e| panic!("{block}: {}", e.message));
    }
    assert!(blocks.len() >= 8);
}

#[test]
fn the_committed_copies_are_what_is_printed() {
    let Some(folder) = scenes() else { return };
    for (name, flag, printed) in
        [("schema.json", "", scene_schema()), ("REFERENCE.md", " --markdown", scene_reference())]
    {
        let path = folder.join(name);
        let committed = std::fs::read_to_string(&path).unwrap_or_default().replace("\r\n", "\n");
        assert!(committed == printed, "eosphor schema{flag} > scenes/{name}");
    }
}
