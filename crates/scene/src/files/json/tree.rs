//! The contents of a JSON file with the place of everything in it.

use std::borrow::Cow;

/// A value and where it begins, in bytes.
pub(super) struct Node<'a> {
    pub(super) at: usize,
    pub(super) value: Value<'a>,
}

pub(super) enum Value<'a> {
    Null,
    Flag,
    /// The number and how it is written; infinite where it is too large.
    Number(f64, &'a str),
    Text(Cow<'a, str>),
    List(Vec<Node<'a>>),
    /// In the file's order; no key twice.
    Object(Vec<Entry<'a>>),
}

/// A key with its value.
pub(super) struct Entry<'a> {
    pub(super) key: Cow<'a, str>,
    pub(super) key_at: usize,
    pub(super) value: Node<'a>,
}

/// From a value to one inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Step<'s> {
    Key(&'s str),
    Item(usize),
}

impl<'s> From<&'s str> for Step<'s> {
    fn from(key: &'s str) -> Step<'s> {
        Step::Key(key)
    }
}

impl From<usize> for Step<'_> {
    fn from(item: usize) -> Step<'static> {
        Step::Item(item)
    }
}

/// A list of steps, from keys and numbers.
macro_rules! way {
    ($($step:expr),+) => { [$(crate::files::json::tree::Step::from($step)),+] };
}
pub(super) use way;

impl<'a> Node<'a> {
    /// The entries of an object; none of anything else.
    pub(super) fn entries(&self) -> &[Entry<'a>] {
        match &self.value {
            Value::Object(entries) => entries,
            _ => &[],
        }
    }

    /// The value of a key.
    pub(super) fn get(&self, key: &str) -> Option<&Node<'a>> {
        self.entries().iter().find(|entry| entry.key == key).map(|entry| &entry.value)
    }

    fn step(&self, step: Step) -> Option<&Node<'a>> {
        match (step, &self.value) {
            (Step::Key(key), _) => self.get(key),
            (Step::Item(item), Value::List(items)) => items.get(item),
            _ => None,
        }
    }

    /// The value at the end of a path, if there is one.
    pub(super) fn at_end(&self, path: &[Step]) -> Option<&Node<'a>> {
        path.iter().try_fold(self, |node, &step| node.step(step))
    }

    /// As many numbers.
    pub(super) fn numbers<const N: usize>(&self) -> Option<[f64; N]> {
        let Value::List(items) = &self.value else { return None };
        let number = |item: &Node| if let Value::Number(x, _) = item.value { Some(x) } else { None };
        items.iter().map(number).collect::<Option<Vec<f64>>>()?.try_into().ok()
    }

    /// The value at the end of a path, or the last on the way to it.
    pub(super) fn follow(&self, path: &[Step]) -> &Node<'a> {
        let mut node = self;
        for &step in path {
            match node.step(step) {
                Some(next) => node = next,
                None => break,
            }
        }
        node
    }

    /// The value of the first such key, in this object or, however deep, inside.
    pub(super) fn find(&self, key: &str) -> Option<&Node<'a>> {
        self.get(key).or_else(|| match &self.value {
            Value::Object(entries) => entries.iter().find_map(|entry| entry.value.find(key)),
            Value::List(items) => items.iter().find_map(|item| item.find(key)),
            _ => None,
        })
    }
}
