//! The schema in a form that files are checked by.

use serde_json::{Map, Value};
use std::sync::LazyLock;

/// What a value must be.
#[derive(Clone, Debug, Default)]
pub(super) struct Rule {
    pub(super) kind: Kind,
    /// It may also be null.
    pub(super) nullable: bool,
}

#[derive(Clone, Debug, Default)]
pub(super) enum Kind {
    #[default]
    Any,
    Flag,
    Text,
    Number(Range),
    List {
        item: Box<Rule>,
        /// How many there must be.
        length: Option<usize>,
    },
    Object(Keys),
    /// An object of any names.
    Names(Box<Rule>),
    /// A word, or an object of one of these keys.
    Choice {
        words: Vec<String>,
        keys: Vec<(String, Rule)>,
    },
    /// Values of different types.
    Union(Vec<Rule>),
}

#[derive(Clone, Debug, Default)]
pub(super) struct Range {
    pub(super) whole: bool,
    pub(super) min: Option<f64>,
    pub(super) max: Option<f64>,
    pub(super) over: Option<f64>,
    pub(super) under: Option<f64>,
}

#[derive(Clone, Debug, Default)]
pub(super) struct Keys {
    pub(super) keys: Vec<(String, Rule)>,
    pub(super) required: Vec<String>,
    /// Exactly one of these must be there, where there are any.
    pub(super) one_of: Vec<String>,
    /// Pairs that exclude each other; the first is the one to drop.
    pub(super) exclude: Vec<(String, String)>,
}

/// The rules of a whole file.
pub(super) static RULES: LazyLock<Rule> = LazyLock::new(|| {
    let schema = Value::from(super::schema::schema());
    Definitions(schema.get("$defs").and_then(Value::as_object)).rule(&schema)
});

/// The named parts of a schema.
struct Definitions<'a>(Option<&'a Map<String, Value>>);

impl Definitions<'_> {
    fn rule(&self, schema: &Value) -> Rule {
        if let Some(name) = schema["$ref"].as_str().and_then(|name| name.strip_prefix("#/$defs/")) {
            return self.0.and_then(|all| all.get(name)).map_or(Rule::default(), |schema| self.rule(schema));
        }
        let branches = items(&schema["anyOf"]);
        if !branches.is_empty() {
            return self.union(branches);
        }
        let (kind, nullable) = match &schema["type"] {
            Value::Array(types) => (types.iter().find(|t| *t != "null"), types.iter().any(|t| t == "null")),
            other => (Some(other), false),
        };
        let kind = match kind.and_then(Value::as_str) {
            _ if schema["enum"].is_array() => self.choice(std::slice::from_ref(schema)),
            None if schema["oneOf"].is_array() => self.choice(items(&schema["oneOf"])),
            Some("boolean") => Kind::Flag,
            Some("string") => Kind::Text,
            Some("number") => Kind::Number(range(schema, false)),
            Some("integer") => Kind::Number(range(schema, true)),
            Some("array") => {
                let length = schema["minItems"].as_u64().and_then(|n| usize::try_from(n).ok());
                Kind::List { item: Box::new(self.rule(&schema["items"])), length }
            }
            Some("object") if schema["additionalProperties"].is_object() => {
                Kind::Names(Box::new(self.rule(&schema["additionalProperties"])))
            }
            Some("object") => Kind::Object(self.keys(schema)),
            _ => Kind::Any,
        };
        Rule { kind, nullable }
    }

    fn union(&self, branches: &[Value]) -> Rule {
        let is_null = |branch: &&Value| branch["type"] == "null";
        let nullable = branches.iter().any(|branch| is_null(&branch));
        let mut rules: Vec<Rule> = branches.iter().filter(|b| !is_null(b)).map(|b| self.rule(b)).collect();
        match (rules.pop(), rules.is_empty()) {
            (Some(only), true) => Rule { nullable, ..only },
            (last, _) => {
                rules.extend(last);
                Rule { kind: Kind::Union(rules), nullable }
            }
        }
    }

    /// An enum: names of variants without contents are words, others are keys.
    fn choice(&self, branches: &[Value]) -> Kind {
        let (mut words, mut keys) = (Vec::new(), Vec::new());
        for branch in branches {
            words.extend(branch["const"].as_str().map(str::to_owned));
            words.extend(items(&branch["enum"]).iter().filter_map(Value::as_str).map(str::to_owned));
            keys.extend(self.properties(branch));
        }
        Kind::Choice { words, keys }
    }

    fn properties(&self, schema: &Value) -> Vec<(String, Rule)> {
        let properties = schema["properties"].as_object();
        let all = properties.into_iter().flatten();
        all.map(|(name, contents)| (name.clone(), self.rule(contents))).collect()
    }

    fn keys(&self, schema: &Value) -> Keys {
        let pair = |part: &Value| match strings(&part["not"]["required"]).as_slice() {
            [first, second] => Some((first.clone(), second.clone())),
            _ => None,
        };
        Keys {
            keys: self.properties(schema),
            required: strings(&schema["required"]),
            one_of: items(&schema["oneOf"]).iter().flat_map(|part| strings(&part["required"])).collect(),
            exclude: items(&schema["allOf"]).iter().filter_map(pair).collect(),
        }
    }
}

fn range(schema: &Value, whole: bool) -> Range {
    let number = |key: &str| schema[key].as_f64();
    Range {
        whole,
        min: number("minimum"),
        max: number("maximum"),
        over: number("exclusiveMinimum"),
        under: number("exclusiveMaximum"),
    }
}

fn items(list: &Value) -> &[Value] {
    list.as_array().map_or(&[], Vec::as_slice)
}

fn strings(list: &Value) -> Vec<String> {
    items(list).iter().filter_map(|item| item.as_str().map(str::to_owned)).collect()
}
