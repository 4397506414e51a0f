//! Checks a file by the rules of its schema. What passes here is read without errors; so all errors of form have our
//! words and their places.

use super::fault::{Fault, listed, quoted};
use super::nearest::{hint, nearest};
use super::rules::{Keys, Kind, Range, Rule};
use super::tree::{Entry, Node, Value};
use crate::model::MAX_COORDINATE;

/// The message for a value of the wrong type lists the names that are allowed; where there are more than this, it shows
/// only the first as an example.
const MAX_LISTED_WORDS: usize = 6;

/// Checks a whole file.
pub(super) fn check(rule: &Rule, root: &Node) -> Result<(), Fault> {
    value(rule, root, Subject::File)
}

/// What a value is called.
#[derive(Clone, Copy)]
enum Subject<'a> {
    File,
    Key(&'a str),
    /// One of the items under a key.
    Item(&'a str),
}

impl std::fmt::Display for Subject<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Subject::File => f.write_str("a scene"),
            Subject::Key(key) => f.write_str(&quoted(key)),
            Subject::Item(key) => write!(f, "one of {}", quoted(key)),
        }
    }
}

fn value(rule: &Rule, node: &Node, subject: Subject) -> Result<(), Fault> {
    match (&rule.kind, &node.value) {
        (_, Value::Null) if rule.nullable => Ok(()),
        (Kind::Any, _) | (Kind::Flag, Value::Flag) | (Kind::Text, Value::Text(_)) => Ok(()),
        (Kind::Number(range), &Value::Number(x, word)) => number(range, x, word, node, subject),
        (Kind::List { item, length }, Value::List(items)) => {
            if length.is_some_and(|length| length != items.len()) {
                return Err(wrong_type(rule, node, subject, &items.len().to_string()));
            }
            let key = match subject {
                Subject::Key(key) | Subject::Item(key) => key,
                Subject::File => "",
            };
            items.iter().try_for_each(|node| value(item, node, Subject::Item(key)))
        }
        (Kind::Object(rules), Value::Object(entries)) => object(rules, entries, node, subject),
        (Kind::Names(rule), Value::Object(entries)) => {
            entries.iter().try_for_each(|e| value(rule, &e.value, Subject::Key(&e.key)))
        }
        (Kind::Choice { words, keys }, Value::Text(word)) if !words.is_empty() => {
            choice(words, keys, word, node, subject)
        }
        (Kind::Choice { words, keys }, Value::Object(entries)) if !keys.is_empty() => {
            variant(words, keys, entries, node, subject)
        }
        (Kind::Union(rules), _) => match rules.iter().find(|rule| takes(rule, node)) {
            Some(rule) => value(rule, node, subject),
            None => Err(wrong_type(rule, node, subject, type_of(node))),
        },
        _ => Err(wrong_type(rule, node, subject, type_of(node))),
    }
}

fn number(range: &Range, x: f64, word: &str, node: &Node, subject: Subject) -> Result<(), Fault> {
    let fault = |message: String| Err(Fault::new(node.at, message));
    if range.whole && (word == "-0" || !word.bytes().all(|b| b == b'-' || b.is_ascii_digit())) {
        return fault(format!("{subject} must be a whole number, not {word}"));
    }
    // The program keeps single precision, but for whole numbers: what is rounded to a bound lies on it.
    let kept = |x: f64| if range.whole { x } else { f64::from(x as f32) };
    let x = kept(x);
    let inside = range.min.is_none_or(|min| x >= kept(min))
        && range.max.is_none_or(|max| x <= kept(max))
        && range.over.is_none_or(|over| x > over)
        && range.under.is_none_or(|under| x < under);
    if !inside {
        return fault(format!("{subject} is {word}; it must be {}", range_words(range)));
    }
    if x.abs() > f64::from(MAX_COORDINATE) {
        return fault(format!("{word} is out of range; numbers must be within {MAX_COORDINATE:e}"));
    }
    Ok(())
}

fn range_words(range: &Range) -> String {
    match (range.min, range.over, range.max, range.under) {
        (Some(min), _, Some(max), _) => format!("{min} to {max}"),
        (_, Some(over), Some(max), _) => format!("over {over} and at most {max}"),
        (_, Some(over), _, Some(under)) => format!("over {over} and under {under}"),
        (_, Some(over), ..) => format!("over {over}"),
        (Some(min), ..) => format!("{min} or more"),
        _ => format!("{} or less", range.max.unwrap_or(f64::from(MAX_COORDINATE))),
    }
}

fn object(rules: &Keys, entries: &[Entry], node: &Node, subject: Subject) -> Result<(), Fault> {
    let has = |key: &str| entries.iter().find(|e| is(&e.key, key));
    for entry in entries {
        match rules.keys.iter().find(|(key, _)| is(&entry.key, key)) {
            Some((_, rule)) => value(rule, &entry.value, Subject::Key(&entry.key))?,
            None => return Err(unknown_key(entry, &rules.keys)),
        }
    }
    if let Some(missing) = rules.required.iter().find(|key| has(key).is_none()) {
        return Err(Fault::new(node.at, format!("{subject} needs the key {}", quoted(missing))));
    }
    let kinds: Vec<&Entry> = entries.iter().filter(|e| rules.one_of.iter().any(|k| is(&e.key, k))).collect();
    match kinds.as_slice() {
        [] if !rules.one_of.is_empty() => {
            let known = listed(rules.one_of.iter().map(String::as_str), "or");
            return Err(Fault::new(node.at, format!("{subject} is of no kind; give it {known}")));
        }
        [first, second, ..] => return Err(too_many(first, second)),
        _ => {}
    }
    for (loser, winner) in &rules.exclude {
        if let (Some(entry), Some(_)) =
            (has(loser).filter(|e| !is_null(e)), has(winner).filter(|e| !is_null(e)))
        {
            let (loser, winner) = (quoted(loser), quoted(winner));
            let message = format!("{loser} does nothing beside {winner}; drop {loser}");
            return Err(Fault::new(entry.key_at, message));
        }
    }
    Ok(())
}

/// Whether a key of the file is this key of the format. The British spelling is taken too.
fn is(written: &str, key: &str) -> bool {
    written == key || (key.contains("color") && written == key.replace("color", "colour"))
}

fn is_null(entry: &Entry) -> bool {
    matches!(entry.value.value, Value::Null)
}

fn too_many(first: &Entry, second: &Entry) -> Fault {
    let (first, at, second) = (quoted(&first.key), second.key_at, quoted(&second.key));
    Fault::new(at, format!("{first} and {second} exclude each other; drop one of them"))
}

fn unknown_key(entry: &Entry, known: &[(String, Rule)]) -> Fault {
    let hint = hint(&entry.key, known.iter().map(|(key, _)| key.as_str()));
    Fault::new(entry.key_at, format!("unknown key {}; {hint}", quoted(&entry.key)))
}

/// A word of a choice.
fn choice(
    words: &[String],
    keys: &[(String, Rule)],
    word: &str,
    node: &Node,
    subject: Subject,
) -> Result<(), Fault> {
    if words.iter().any(|known| known == word) {
        return Ok(());
    }
    let said = quoted(word);
    if keys.iter().any(|(key, _)| key == word) {
        return Err(Fault::new(node.at, format!("{said} needs contents: {{{said}: ...}}")));
    }
    let hint = match nearest(word, words.iter().map(String::as_str)) {
        Some(near) => format!("did you mean {}?", quoted(near)),
        None => {
            let more: String = keys.iter().map(|(key, _)| format!(" or {{{}: ...}}", quoted(key))).collect();
            format!("it must be {}{more}", listed(words.iter().map(String::as_str), "or"))
        }
    };
    Err(Fault::new(node.at, format!("{subject} is {said}; {hint}")))
}

/// The one key of a choice with contents.
fn variant(
    words: &[String],
    keys: &[(String, Rule)],
    entries: &[Entry],
    node: &Node,
    subject: Subject,
) -> Result<(), Fault> {
    let known = || listed(keys.iter().map(|(key, _)| key.as_str()), "or");
    let [entry] = entries else {
        return Err(match entries {
            [first, second, ..] if keys.iter().any(|(key, _)| *key == second.key) => too_many(first, second),
            [_, second, ..] => unknown_key(second, keys),
            _ => Fault::new(node.at, format!("{subject} is empty; give it {}", known())),
        });
    };
    match keys.iter().find(|(key, _)| *key == entry.key) {
        Some((key, rule)) => value(rule, &entry.value, Subject::Key(key)),
        None if words.iter().any(|word| *word == entry.key) => {
            let word = quoted(&entry.key);
            Err(Fault::new(entry.key_at, format!("{word} stands alone, without {{ }}: {subject} is {word}")))
        }
        None => Err(unknown_key(entry, keys)),
    }
}

fn takes(rule: &Rule, node: &Node) -> bool {
    match (&rule.kind, &node.value) {
        (_, Value::Null) => rule.nullable,
        (Kind::Any, _) | (Kind::Flag, Value::Flag) | (Kind::Text, Value::Text(_)) => true,
        (Kind::Number(_), Value::Number(..)) | (Kind::List { .. }, Value::List(_)) => true,
        (Kind::Object(_) | Kind::Names(_), Value::Object(_)) => true,
        (Kind::Choice { words, .. }, Value::Text(_)) => !words.is_empty(),
        (Kind::Choice { keys, .. }, Value::Object(_)) => !keys.is_empty(),
        (Kind::Union(rules), _) => rules.iter().any(|rule| takes(rule, node)),
        _ => false,
    }
}

fn wrong_type(rule: &Rule, node: &Node, subject: Subject, found: &str) -> Fault {
    Fault::new(node.at, format!("{subject} must be {}, not {found}", expected(rule)))
}

fn type_of(node: &Node) -> &'static str {
    match node.value {
        Value::Null => "null",
        Value::Flag => "true or false",
        Value::Number(..) => "a number",
        Value::Text(_) => "a string",
        Value::List(_) => "a list",
        Value::Object(_) => "an object",
    }
}

/// What a rule takes, in words.
fn expected(rule: &Rule) -> String {
    match &rule.kind {
        Kind::Any => "a value".into(),
        Kind::Flag => "true or false".into(),
        Kind::Text => "a string".into(),
        Kind::Number(range) if range.whole => "a whole number".into(),
        Kind::Number(_) => "a number".into(),
        Kind::List { item, length: Some(length) } => match &item.kind {
            Kind::Number(range) if range.whole => format!("{length} whole numbers"),
            Kind::Number(_) => format!("{length} numbers"),
            _ => format!("a list of {length} times {}", expected(item)),
        },
        Kind::List { .. } => "a list".into(),
        Kind::Object(_) => "an object".into(),
        Kind::Names(_) => "an object of names".into(),
        Kind::Choice { words, keys } if words.len() + keys.len() > MAX_LISTED_WORDS => {
            format!("a name such as {}", listed(words.first().map(String::as_str), ""))
        }
        Kind::Choice { words, keys } => {
            let words = words.iter().map(|word| quoted(word));
            let keys = keys.iter().map(|(key, _)| format!("{{{}: ...}}", quoted(key)));
            words.chain(keys).collect::<Vec<_>>().join(" or ")
        }
        Kind::Union(rules) => rules.iter().map(expected).collect::<Vec<_>>().join(" or "),
    }
}
