//! How the program was called, as pictures say it.

/// The program's name and its arguments, quoted so that a shell reads them as they were. Without which share of the picture
/// it was: the whole is what one call would have made.
pub(crate) fn command_line() -> String {
    let arguments = std::env::args_os().skip(1).map(|argument| argument.to_string_lossy().into_owned());
    let arguments = without_shares(arguments.collect());
    let arguments = arguments.iter().map(|argument| quoted(argument));
    std::iter::once("eosphor".to_owned()).chain(arguments).collect::<Vec<_>>().join(" ")
}

fn without_shares(arguments: Vec<String>) -> Vec<String> {
    let is_value = |k: usize| k > 0 && arguments[k - 1] == "--tiles";
    let is_flag = |argument: &str| argument == "--tiles" || argument.starts_with("--tiles=");
    let kept = arguments.iter().enumerate().filter(|(k, argument)| !is_flag(argument) && !is_value(*k));
    kept.map(|(_, argument)| argument.clone()).collect()
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
    fn shares_are_not_spoken_of() {
        let words = |text: &str| text.split(' ').map(str::to_string).collect::<Vec<_>>();
        for text in ["render --tiles 1/2 a.obj -o b.png", "render a.obj --tiles=1/2 -o b.png"] {
            assert_eq!(without_shares(words(text)), words("render a.obj -o b.png"));
        }
    }

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
