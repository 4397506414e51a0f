//! The documentation of the format in Markdown, printed from its schema: scenes/REFERENCE.md.

use serde_json::Value;
use std::fmt::Write;

const HEAD: &str = "\
# The scene format in full

Printed by `eosphor schema --markdown`. [README.md](README.md) shows the format by example; editors that read JSON schemas
complete and check scenes that say `\"$schema\": \"schema.json\"` ([schema.json](schema.json), printed by `eosphor schema`).

Unknown keys are errors. Keys may be left out unless they are *required*. `colour` may be written for `color` in any key.
[docs/units.md](../docs/units.md) has the units of light.
";

/// The documentation of scene files in Markdown, as `eosphor schema --markdown` prints it.
pub fn scene_reference() -> String {
    let schema = Value::from(super::schema::schema());
    let mut page = Page { text: HEAD.into(), definitions: &schema["$defs"], queue: Vec::new() };
    page.section(&schema);
    let mut done = 0;
    while let Some(name) = page.queue.get(done).cloned() {
        page.section(&schema["$defs"][&name]);
        done += 1;
    }
    page.text
}

struct Page<'a> {
    text: String,
    definitions: &'a Value,
    /// Named parts in the order in which they are mentioned first.
    queue: Vec<String>,
}

impl Page<'_> {
    fn section(&mut self, schema: &Value) {
        let name = schema["title"].as_str().unwrap_or_default();
        let _ = write!(self.text, "\n## {name}\n");
        self.paragraph(schema["description"].as_str().unwrap_or_default());
        let mut inner = Vec::new();
        self.contents(name, schema, &mut inner);
        for (name, schema) in inner {
            let _ = write!(self.text, "\n### {name}\n");
            self.paragraph(schema["description"].as_str().unwrap_or_default());
            self.contents(&name, schema, &mut Vec::new());
        }
        for example in items(&schema["examples"]) {
            let _ = write!(self.text, "\n```json\n{}\n```\n", Inline(example));
        }
    }

    fn paragraph(&mut self, text: &str) {
        if !text.is_empty() {
            let _ = write!(self.text, "\n{text}\n");
        }
    }

    /// The table of an object or of a choice, or the type of anything else. Objects without a name are left to `inner`.
    fn contents<'s>(&mut self, name: &str, schema: &'s Value, inner: &mut Vec<(String, &'s Value)>) {
        if schema["properties"].is_object() {
            self.keys(name, schema, inner);
        } else if schema["oneOf"].is_array() {
            self.choices(name, items(&schema["oneOf"]), inner);
        } else if let Some(object) = items(&schema["anyOf"]).iter().find(|b| b["properties"].is_object()) {
            let others = items(&schema["anyOf"]).iter().filter(|b| !b["properties"].is_object());
            let others: Vec<String> = others.map(|other| self.kind(name, other)).collect();
            self.paragraph(&format!("{}, or an object:", capital(&others.join(" or "))));
            self.keys(name, object, inner);
        } else {
            let kind = self.kind(name, schema);
            self.paragraph(&format!("Type: {kind}."));
        }
    }

    fn keys<'s>(&mut self, name: &str, schema: &'s Value, inner: &mut Vec<(String, &'s Value)>) {
        self.text += "\n| key | type | default | meaning |\n|---|---|---|---|\n";
        for (key, contents) in schema["properties"].as_object().into_iter().flatten() {
            let kind = self.kind_or_inner(name, key, contents, inner);
            let default = match &contents["default"] {
                Value::Null if items(&schema["required"]).iter().any(|k| k == key) => "*required*".into(),
                Value::Null => String::new(),
                default => format!("`{}`", Inline(default)),
            };
            let meaning = contents["description"].as_str().unwrap_or_default();
            let _ = writeln!(self.text, "| `{key}` | {kind} | {default} | {meaning} |");
        }
        for part in items(&schema["allOf"]) {
            if let [loser, winner] = items(&part["not"]["required"]) {
                self.paragraph(&format!("Not both {} and {}.", Inline(loser).code(), Inline(winner).code()));
            }
        }
        let kinds = items(&schema["oneOf"]).iter().flat_map(|part| items(&part["required"]));
        let kinds: Vec<String> = kinds.map(|kind| Inline(kind).code()).collect();
        if !kinds.is_empty() {
            self.paragraph(&format!("Exactly one of {}.", kinds.join(", ")));
        }
    }

    fn choices<'s>(&mut self, name: &str, branches: &'s [Value], inner: &mut Vec<(String, &'s Value)>) {
        self.text += "\n| value | meaning |\n|---|---|\n";
        for branch in branches {
            let meaning = branch["description"].as_str().unwrap_or_default();
            let words = branch["const"].as_str().into_iter().chain(strings(&branch["enum"]));
            for word in words {
                let _ = writeln!(self.text, "| `\"{word}\"` | {meaning} |");
            }
            for (key, contents) in branch["properties"].as_object().into_iter().flatten() {
                let kind = self.kind_or_inner(name, key, contents, inner);
                let _ = writeln!(self.text, "| {{`\"{key}\"`: {kind}}} | {meaning} |");
            }
        }
    }

    /// The type of a key; an object without a name gets a section of its own.
    fn kind_or_inner<'s>(
        &mut self,
        name: &str,
        key: &str,
        schema: &'s Value,
        inner: &mut Vec<(String, &'s Value)>,
    ) -> String {
        if !schema["properties"].is_object() {
            return self.kind(name, schema);
        }
        inner.push((format!("{name} {key}"), schema));
        format!("[object](#{}-{key})", anchor(name))
    }

    /// The type of a value in words, with links to the named parts.
    fn kind(&mut self, name: &str, schema: &Value) -> String {
        if let Some(name) = schema["$ref"].as_str().and_then(|path| path.strip_prefix("#/$defs/")) {
            let known = self.queue.iter().any(|queued| queued == name);
            if !known && self.definitions.get(name).is_some() {
                self.queue.push(name.into());
            }
            let title = self.definitions[name]["title"].as_str().unwrap_or_default();
            return format!("[{title}](#{})", anchor(title));
        }
        let branches = items(&schema["anyOf"]).iter().filter(|branch| branch["type"] != "null");
        let branches: Vec<String> = branches.map(|branch| self.kind(name, branch)).collect();
        if !branches.is_empty() {
            return branches.join(", or ");
        }
        if schema["enum"].is_array() {
            let words: Vec<String> = strings(&schema["enum"]).map(|word| format!("`\"{word}\"`")).collect();
            return format!("one of {}", words.join(", "));
        }
        if !schema["const"].is_null() {
            return Inline(&schema["const"]).code();
        }
        let types = &schema["type"];
        let kind = types.as_str().or_else(|| strings(types).find(|kind| *kind != "null"));
        match kind.unwrap_or_default() {
            "boolean" => "true or false".into(),
            "number" => format!("number{}", range(schema)),
            "integer" => format!("whole number{}", range(schema)),
            "array" => self.list(name, schema),
            "object" => {
                let contents = self.kind(name, &schema["additionalProperties"]);
                format!("object of names, each {contents}")
            }
            other => other.into(),
        }
    }

    fn list(&mut self, name: &str, schema: &Value) -> String {
        let item = &schema["items"];
        match (schema["minItems"].as_u64(), item["type"].as_str()) {
            (Some(length), Some("number")) => format!("{length} numbers{}", range(item)),
            (Some(length), Some("integer")) => format!("{length} whole numbers{}", range(item)),
            (Some(length), _) => format!("list of {length} times {}", self.kind(name, item)),
            (None, _) => format!("list of {}", self.kind(name, item)),
        }
    }
}

/// The range of a number, after a comma.
fn range(schema: &Value) -> String {
    let bound = |key: &str| schema[key].as_f64();
    match (bound("minimum"), bound("exclusiveMinimum"), bound("maximum"), bound("exclusiveMaximum")) {
        (Some(min), _, Some(max), _) => format!(", {min} to {max}"),
        (Some(min), ..) => format!(", {min} or more"),
        (_, Some(over), Some(max), _) => format!(", over {over}, at most {max}"),
        (_, Some(over), _, Some(under)) => format!(", over {over} and under {under}"),
        (_, Some(over), ..) => format!(", over {over}"),
        _ => String::new(),
    }
}

/// JSON in one line, with blanks.
pub(super) struct Inline<'a>(pub(super) &'a Value);

impl Inline<'_> {
    fn code(&self) -> String {
        match self.0 {
            Value::String(word) => format!("`{word}`"),
            _ => format!("`{self}`"),
        }
    }
}

impl std::fmt::Display for Inline<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.0 {
            Value::Array(items) => {
                let items: Vec<String> = items.iter().map(|item| Inline(item).to_string()).collect();
                write!(f, "[{}]", items.join(", "))
            }
            Value::Object(entries) => {
                let entry = |(key, value): (&String, &Value)| format!("\"{key}\": {}", Inline(value));
                write!(f, "{{ {} }}", entries.iter().map(entry).collect::<Vec<_>>().join(", "))
            }
            other => write!(f, "{other}"),
        }
    }
}

/// What a link to a heading says.
fn anchor(title: &str) -> String {
    title.to_lowercase().replace(' ', "-")
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

fn items(list: &Value) -> &[Value] {
    list.as_array().map_or(&[], Vec::as_slice)
}

fn strings(list: &Value) -> impl Iterator<Item = &str> {
    items(list).iter().filter_map(Value::as_str)
}
