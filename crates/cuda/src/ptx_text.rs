//! Kernels out of a text of PTX. (`cargo xtask ptx --registers` reads this file too: what it measures is what the driver gets.)

use std::collections::HashMap;

/// A text, taken apart.
pub(crate) struct Parts<'a> {
    all: Vec<Part<'a>>,
    /// What each kernel and function calls.
    calls: HashMap<&'a str, Vec<&'a str>>,
}

/// The name of the table of constants that a line is.
pub(crate) fn table_name(line: &str) -> Option<&str> {
    let line = line.strip_prefix(".visible ").unwrap_or(line);
    line.strip_prefix(".global .align ")?.split_once(".b8 ")?.1.split('[').next()
}

/// A piece of the text.
struct Part<'a> {
    /// The kernel or function that it declares or defines; `None` of what belongs to none.
    name: Option<&'a str>,
    text: &'a str,
}

impl<'a> Parts<'a> {
    /// Of this text.
    pub(crate) fn of(ptx: &'a str) -> Parts<'a> {
        let mut parts = Parts { all: Vec::new(), calls: HashMap::new() };
        let (mut name, mut start, mut at) = (None, 0, 0);
        for line in ptx.split_inclusive('\n') {
            if let Some(started) = name_of(line) {
                parts.all.push(Part { name: None, text: &ptx[start..at] });
                (name, start) = (Some(started), at);
            }
            at += line.len();
            if let Some(caller) = name {
                if let Some(callee) = callee(line) {
                    parts.calls.entry(caller).or_default().push(callee);
                }
                // Definitions end with a brace, declarations with a semicolon.
                if line.starts_with(['}', ';']) {
                    parts.all.push(Part { name, text: &ptx[start..at] });
                    (name, start) = (None, at);
                }
            }
        }
        parts.all.push(Part { name, text: &ptx[start..] });
        parts
    }

    /// The text with these kernels alone, the functions that they call and the tables that they read: the driver compiles all that
    /// it is given.
    pub(crate) fn with_kernels(&self, kernels: &[&str]) -> String {
        let mut wanted: Vec<&str> = kernels.to_vec();
        let mut next = 0;
        while next < wanted.len() {
            let calls = self.calls.get(wanted[next]).map_or(&[][..], |calls| calls);
            for &function in calls {
                if !wanted.contains(&function) {
                    wanted.push(function);
                }
            }
            next += 1;
        }
        let code = || self.all.iter().filter(|part| part.name.is_some_and(|name| wanted.contains(&name)));
        let is_read = |table: &str| code().any(|part| part.text.contains(table));
        let mut text = String::new();
        for part in &self.all {
            match part.name {
                Some(name) if wanted.contains(&name) => text.push_str(part.text),
                Some(_) => {}
                None => {
                    let is_kept = |line: &&str| table_name(line).is_none_or(is_read);
                    text.extend(part.text.split_inclusive('\n').filter(is_kept));
                }
            }
        }
        text
    }
}

/// The name of the kernel that starts on a line.
pub(crate) fn kernel_name(line: &str) -> Option<&str> {
    Some(line.strip_prefix(".visible .entry ")?.trim_end().trim_end_matches('('))
}

/// The name of the kernel or function that starts on a line.
fn name_of(line: &str) -> Option<&str> {
    kernel_name(line).or_else(|| {
        let function = line.strip_prefix(".visible .func ")?;
        function.split_whitespace().last().map(|name| name.trim_end_matches('('))
    })
}

/// The function that is called on a line.
fn callee(line: &str) -> Option<&str> {
    let call = line.trim_start().strip_prefix("call.uni ")?;
    let call = call.strip_prefix("(retval0), ").unwrap_or(call);
    call.split_once(',').map(|(name, _)| name)
}
