//! Lists of operands.

/// What is in parentheses.
pub(crate) fn inside(list: &str) -> &str {
    list.trim_matches(['(', ')', ' '])
}

/// Operands: what commas part outside of brackets.
pub(crate) fn split(operands: &str) -> Vec<&str> {
    let (mut depth, mut first, mut all) = (0, 0, Vec::new());
    for (at, character) in operands.char_indices() {
        match character {
            '{' | '[' | '(' => depth += 1,
            '}' | ']' | ')' => depth -= 1,
            ',' if depth == 0 => {
                all.push(operands[first..at].trim());
                first = at + 1;
            }
            _ => {}
        }
    }
    let last = operands[first..].trim();
    if !last.is_empty() {
        all.push(last);
    }
    all
}

/// The items of `{a, b}`, or the only one.
pub(crate) fn vector(text: &str) -> Vec<&str> {
    match text.strip_prefix('{').and_then(|text| text.strip_suffix('}')) {
        Some(items) => items.split(',').map(str::trim).collect(),
        None => vec![text],
    }
}
