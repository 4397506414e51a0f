//! How the program was called, as pictures say it.

/// Flags that are left out, as they change nothing of the whole, and whether a value follows: which share of the picture it
/// was, and how it was gone on with.
const LEFT_OUT: [(&str, bool); 4] =
    [("--tiles", true), ("--sample-range", true), ("--checkpoint-every", true), ("--resume", false)];

/// Flags of `view` that say where the page is, and whether a value follows.
#[cfg(feature = "view")]
const OF_VIEWERS: [(&str, bool); 3] = [("--port", true), ("--listen", true), ("--no-open", false)];

/// The command line that renders what a viewer shows: the words that `view` was called with, but for the page's, and these flags.
#[cfg(feature = "view")]
pub(crate) fn render_of_view(flags: Vec<String>) -> String {
    // The program's name and `view` come first.
    let arguments = std::env::args_os().skip(2).map(|argument| argument.to_string_lossy().into_owned());
    let arguments = without(arguments.collect(), &OF_VIEWERS);
    let words = ["eosphor", "render"].map(str::to_owned).into_iter().chain(arguments).chain(flags);
    words.map(|word| quoted(&word)).collect::<Vec<_>>().join(" ")
}

/// The program's name and its arguments, quoted so that a shell reads them as they were, as if one undisturbed call had made
/// the picture.
pub(crate) fn command_line() -> String {
    let arguments = std::env::args_os().skip(1).map(|argument| argument.to_string_lossy().into_owned());
    let arguments = without(arguments.collect(), &LEFT_OUT);
    let arguments = arguments.iter().map(|argument| quoted(argument));
    std::iter::once("eosphor".to_owned()).chain(arguments).collect::<Vec<_>>().join(" ")
}

fn without(arguments: Vec<String>, flags: &[(&str, bool)]) -> Vec<String> {
    let mut arguments = arguments.into_iter();
    let mut kept = Vec::new();
    while let Some(argument) = arguments.next() {
        let name = argument.split('=').next().unwrap_or_default();
        match flags.iter().find(|(flag, _)| *flag == name) {
            Some((_, true)) if !argument.contains('=') => drop(arguments.next()),
            Some(_) => {}
            None => kept.push(argument),
        }
    }
    kept
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
    fn shares_and_interruptions_are_not_spoken_of() {
        let words = |text: &str| text.split(' ').map(str::to_string).collect::<Vec<_>>();
        for text in [
            "render --tiles 1/2 a.obj -o b.png",
            "render a.obj --tiles=1/2 -o b.png",
            "render a.obj --resume --checkpoint-every 5 -o b.png --resume",
            "render --checkpoint-every=5 a.obj -o b.png --sample-range 0..4",
        ] {
            assert_eq!(without(words(text), &LEFT_OUT), words("render a.obj -o b.png"));
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
