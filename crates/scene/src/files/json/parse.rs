//! From text to a tree of values that knows the place of everything. It takes what serde_json takes, and says in our
//! words what is wrong.

use super::fault::{Fault, quoted};
use super::tree::{Entry, Node, Value};
use std::borrow::Cow;
use std::collections::HashSet;

/// Levels of lists and objects inside each other. Scenes need 8.
const MAX_DEPTH: u32 = 100;

/// Objects of at least so many keys look for repeated ones by hashing.
const MIN_HASHED_KEYS: usize = 16;

/// The tree of a whole file.
pub(super) fn parse(text: &str) -> Result<Node<'_>, Fault> {
    let mut parser = Parser { text, at: 0, depth: 0 };
    parser.skip_blanks();
    if parser.peek().is_none() {
        return Err(Fault::new(0, "the file is empty"));
    }
    let root = parser.value()?;
    parser.skip_blanks();
    match parser.peek() {
        None => Ok(root),
        Some(_) => {
            Err(parser.fault("the file goes on after its end; there is one pair of { } around everything"))
        }
    }
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
    depth: u32,
}

impl<'a> Parser<'a> {
    fn fault(&self, message: impl Into<String>) -> Fault {
        Fault::new(self.at, message)
    }

    fn peek(&self) -> Option<u8> {
        self.text.as_bytes().get(self.at).copied()
    }

    fn skip_blanks(&mut self) {
        while matches!(self.peek(), Some(b' ' | b'\t' | b'\n' | b'\r')) {
            self.at += 1;
        }
    }

    /// The bytes from here on that belong together, as a text.
    fn word(&self, belongs: impl Fn(u8) -> bool) -> &'a str {
        let rest = &self.text.as_bytes()[self.at..];
        let length = rest.iter().position(|&b| !belongs(b)).unwrap_or(rest.len());
        // What belongs is ASCII, so that this is the boundary of a character.
        &self.text[self.at..self.at + length]
    }

    fn value(&mut self) -> Result<Node<'a>, Fault> {
        let at = self.at;
        let value = match self.peek() {
            Some(b'{') => self.nested(Parser::object)?,
            Some(b'[') => self.nested(Parser::list)?,
            Some(b'"') => Value::Text(self.string()?),
            Some(b'-' | b'+' | b'.' | b'0'..=b'9') => self.number()?,
            _ => self.named_value()?,
        };
        Ok(Node { at, value })
    }

    fn nested(&mut self, read: fn(&mut Parser<'a>) -> Result<Value<'a>, Fault>) -> Result<Value<'a>, Fault> {
        if self.depth == MAX_DEPTH {
            return Err(self.fault(format!("this is nested more than {MAX_DEPTH} levels deep")));
        }
        self.depth += 1;
        let value = read(self);
        self.depth -= 1;
        value
    }

    fn named_value(&mut self) -> Result<Value<'a>, Fault> {
        let word = self.word(|b| b.is_ascii_alphanumeric() || b == b'_' || b == b'-');
        let value = match word {
            "null" => Value::Null,
            "true" | "false" => Value::Flag,
            "" => return Err(self.no_value()),
            _ => {
                return Err(self.fault(format!("{word} is no value; strings stand in double quotes")));
            }
        };
        self.at += word.len();
        Ok(value)
    }

    fn no_value(&self) -> Fault {
        self.fault(match self.peek() {
            Some(b'/' | b'#') => "JSON has no comments; remarks can go into the key \"description\"",
            Some(b'\'') => "strings stand in double quotes",
            _ => "a value is missing here",
        })
    }

    fn number(&mut self) -> Result<Value<'a>, Fault> {
        let word = self.word(|b| matches!(b, b'-' | b'+' | b'.' | b'e' | b'E' | b'0'..=b'9'));
        if !is_number(word) {
            return Err(self.fault(format!(
                "{} is no number; write it as 12, -0.5 or 1.5e-3",
                quoted(word).trim_matches('"')
            )));
        }
        self.at += word.len();
        Ok(Value::Number(word.parse().unwrap_or(f64::INFINITY), word))
    }

    fn string(&mut self) -> Result<Cow<'a, str>, Fault> {
        let start = self.at;
        let mut escapes = false;
        self.at += 1;
        loop {
            match self.peek() {
                Some(b'"') => break,
                Some(b'\\') => {
                    escapes = true;
                    // What follows may be a byte of a longer character: its others are skipped like all.
                    self.at += 2;
                }
                None | Some(b'\n' | b'\r') => {
                    return Err(Fault::new(start, "this string is not closed in its line"));
                }
                Some(0..=0x1f) => {
                    return Err(
                        self.fault("a control character stands in a string; write a tabulator as \\t")
                    );
                }
                Some(_) => self.at += 1,
            }
        }
        self.at += 1;
        if !escapes {
            return Ok(Cow::Borrowed(&self.text[start + 1..self.at - 1]));
        }
        serde_json::from_str(&self.text[start..self.at]).map(Cow::Owned).map_err(|_| {
            Fault::new(
                start,
                "an escape in this string is wrong; there are \\\" \\\\ \\/ \\b \\f \\n \\r \\t \\u00E4",
            )
        })
    }

    fn list(&mut self) -> Result<Value<'a>, Fault> {
        let start = self.at;
        self.at += 1;
        let mut items = Vec::new();
        self.skip_blanks();
        if self.take(b']') {
            return Ok(Value::List(items));
        }
        loop {
            self.skip_blanks();
            items.push(self.value()?);
            if self.ends(b']', start, "list")? {
                return Ok(Value::List(items));
            }
        }
    }

    fn object(&mut self) -> Result<Value<'a>, Fault> {
        let start = self.at;
        self.at += 1;
        let mut entries: Vec<Entry> = Vec::new();
        let mut many = HashSet::new();
        self.skip_blanks();
        if self.take(b'}') {
            return Ok(Value::Object(entries));
        }
        loop {
            self.skip_blanks();
            let key_at = self.at;
            if self.peek() != Some(b'"') {
                return Err(self.no_key(start));
            }
            let key = self.string()?;
            let twice = if entries.len() < MIN_HASHED_KEYS {
                entries.iter().any(|entry| entry.key == key)
            } else {
                if many.is_empty() {
                    many.extend(entries.iter().map(|entry| entry.key.clone()));
                }
                many.contains(&key)
            };
            if twice {
                return Err(Fault::new(key_at, format!("{} is given twice", quoted(&key))));
            }
            if !many.is_empty() {
                many.insert(key.clone());
            }
            self.skip_blanks();
            if !self.take(b':') {
                return Err(self.fault(format!("a colon is missing after {}", quoted(&key))));
            }
            self.skip_blanks();
            entries.push(Entry { key, key_at, value: self.value()? });
            if self.ends(b'}', start, "object")? {
                return Ok(Value::Object(entries));
            }
        }
    }

    fn no_key(&self, start: usize) -> Fault {
        match self.peek() {
            None => Fault::new(start, "this object is not closed; a } is missing"),
            Some(b'}') => self.fault("the comma before this } is one too many"),
            Some(b'/' | b'#') => self.no_value(),
            Some(_) => self.fault("a key must stand here, in double quotes"),
        }
    }

    fn take(&mut self, byte: u8) -> bool {
        let there = self.peek() == Some(byte);
        self.at += usize::from(there);
        there
    }

    /// Whether a list or object ends after a value; otherwise a comma was there and another value must follow.
    fn ends(&mut self, close: u8, start: usize, what: &str) -> Result<bool, Fault> {
        let after_value = self.at;
        self.skip_blanks();
        if self.take(close) {
            return Ok(true);
        }
        let close = char::from(close);
        if !self.take(b',') {
            return Err(match self.peek() {
                None => Fault::new(start, format!("this {what} is not closed; a {close} is missing")),
                Some(b'/' | b'#') => self.no_value(),
                Some(_) => Fault::new(after_value, format!("a comma or a {close} is missing here")),
            });
        }
        self.skip_blanks();
        match (self.peek(), close) {
            (None, _) => Err(Fault::new(start, format!("this {what} is not closed; a {close} is missing"))),
            (Some(b']'), ']') => Err(self.fault("the comma before this ] is one too many")),
            _ => Ok(false),
        }
    }
}

/// JSON's grammar: no plus before, no zeros before, digits on both sides of the point.
fn is_number(word: &str) -> bool {
    let digits = |rest: &str| rest.bytes().take_while(u8::is_ascii_digit).count();
    let rest = word.strip_prefix('-').unwrap_or(word);
    let whole = digits(rest);
    if whole == 0 || (whole > 1 && rest.starts_with('0')) {
        return false;
    }
    let mut rest = &rest[whole..];
    if let Some(fraction) = rest.strip_prefix('.') {
        let count = digits(fraction);
        if count == 0 {
            return false;
        }
        rest = &fraction[count..];
    }
    if let Some(exponent) = rest.strip_prefix(['e', 'E']) {
        let exponent = exponent.strip_prefix(['-', '+']).unwrap_or(exponent);
        return !exponent.is_empty() && digits(exponent) == exponent.len();
    }
    rest.is_empty()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn fault(text: &str) -> (usize, String) {
        match parse(text) {
            Ok(_) => panic!("{text} is read"),
            Err(fault) => (fault.at, fault.message),
        }
    }

    #[test]
    fn what_is_wrong_is_said_at_its_place() {
        for (text, at, message) in [
            ("", 0, "the file is empty"),
            (" \n", 0, "the file is empty"),
            ("{} x", 3, "the file goes on after its end"),
            ("{\"a\": }", 6, "a value is missing here"),
            ("{\"a\": 1", 0, "this object is not closed; a } is missing"),
            ("{\"a\": 1,", 0, "this object is not closed; a } is missing"),
            ("{", 0, "this object is not closed; a } is missing"),
            ("[1, 2", 0, "this list is not closed; a ] is missing"),
            ("[1,\n", 0, "this list is not closed; a ] is missing"),
            ("[1 2]", 2, "a comma or a ] is missing here"),
            ("{\"a\": 1\n\"b\": 2}", 7, "a comma or a } is missing here"),
            ("{\"a\": 1,}", 8, "the comma before this } is one too many"),
            ("[1,]", 3, "the comma before this ] is one too many"),
            ("[,]", 1, "a value is missing here"),
            ("{a: 1}", 1, "a key must stand here, in double quotes"),
            ("{\"a\" 1}", 5, "a colon is missing after \"a\""),
            ("{\"a\": 1, \"a\": 2}", 9, "\"a\" is given twice"),
            ("{\"a\": 'x'}", 6, "strings stand in double quotes"),
            ("{\"a\": True}", 6, "True is no value; strings stand in double quotes"),
            ("{\"a\": \"x}", 6, "this string is not closed in its line"),
            ("{\"a\": \"x\ty\"}", 8, "a control character stands in a string"),
            ("{\"a\": \"\\q\"}", 6, "an escape in this string is wrong"),
            ("{\"a\": \"\\ud800\"}", 6, "an escape in this string is wrong"),
            ("{ // remark\n}", 2, "JSON has no comments"),
            ("{\"a\": 1 // remark\n}", 8, "JSON has no comments"),
            ("{\"a\": 1, // remark\n}", 9, "JSON has no comments"),
            ("[01]", 1, "01 is no number; write it as"),
            ("[.5]", 1, ".5 is no number"),
            ("[+1]", 1, "+1 is no number"),
            ("[1.]", 1, "1. is no number"),
            ("[1e]", 1, "1e is no number"),
            ("[--1]", 1, "--1 is no number"),
            ("[NaN]", 1, "NaN is no value"),
        ] {
            let (place, said) = fault(text);
            assert!(place == at && said.starts_with(message), "{text:?} says at {place}: {said}");
        }
    }

    #[test]
    fn depth_is_bounded() {
        assert!(fault(&"[".repeat(100_000)).1.contains("100 levels"));
        assert!(fault(&"{\"a\":".repeat(100_000)).1.contains("100 levels"));
        let hundred = "[".repeat(100) + &"]".repeat(100);
        assert!(parse(&hundred).is_ok());
    }

    #[test]
    fn repeated_keys_are_found_among_many() {
        let keys: Vec<String> = (0..50).chain([3]).map(|i| format!("\"k{i}\": 0")).collect();
        assert!(fault(&format!("{{{}}}", keys.join(","))).1.contains("\"k3\" is given twice"));
        assert!(parse(&format!("{{{}}}", keys[..50].join(","))).is_ok());
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 2000, ..ProptestConfig::default() })]

        /// Keys cannot repeat here, and no number overflows, since exponents are negative: all else must agree.
        #[test]
        fn it_takes_what_serde_json_takes(words in proptest::collection::vec(proptest::sample::select(vec![
            "[", "[", "]", "]", ",", ",", "{\"a\":", "{", "}", "1", "-0.5e-2", "01", "-", "null", "true", "tru", "\"",
            "\"\"", "\"\\n\"", "\\", "\u{e4}", " ", "\n", "/", "e-5", ".", "\u{1}", "\\u00e4",
        ]), 0..12)) {
            let text = words.concat();
            let ours = parse(&text).is_ok();
            prop_assert_eq!(ours, serde_json::from_str::<serde_json::Value>(&text).is_ok(), "{}", text);
        }
    }
}
