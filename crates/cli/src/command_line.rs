//! How the program was called, as pictures say it.

/// The program's name and its arguments, quoted so that a shell reads them as they were.
pub(crate) fn command_line() -> String {
    let arguments = std::env::args_os().skip(1).map(|argument| quoted(&argument.to_string_lossy()));
    std::iter::once("eosphor".to_owned()).chain(arguments).collect::<Vec<_>>().join(" ")
}

/// In single quotes, where a shell could take it for anything else than a word.
fn quoted(argument: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./:,=+@%^".contains(c);
    match !argument.is_empty() && argument.chars().all(plain) {
        true => argument.to_owned(),
        false => format!("'{}'", argument.replace('\'', r"'\''")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_needs_quotes_has_them() {
        assert_eq!(
            ["--size", "8x8", "a/b.png", "1,-2.5"].map(quoted),
            ["--size", "8x8", "a/b.png", "1,-2.5"]
        );
        assert_eq!(
            ["", "a b", "it's", "$x", "für"].map(quoted),
            ["''", "'a b'", r"'it'\''s'", "'$x'", "'für'"]
        );
    }
}
