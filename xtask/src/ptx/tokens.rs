//! A source file as the compiler takes it: its tokens, without comments and without what is compiled for tests alone.

use anyhow::{Result, anyhow};
use proc_macro2::{Delimiter, TokenStream, TokenTree};
use std::iter::Peekable;

/// The tokens of a Rust source, with a space after each. Comments, doc comments, line breaks and items under `#[cfg(test)]`
/// are not among them, so a change of these alone gives the same text.
pub(super) fn of_source(source: &str) -> Result<String> {
    let stream: TokenStream = source.parse().map_err(|error| anyhow!("it is no Rust source: {error}"))?;
    let mut text = String::with_capacity(source.len());
    write(stream, &mut text);
    Ok(text)
}

fn write(stream: TokenStream, text: &mut String) {
    let mut tokens = stream.into_iter().peekable();
    while let Some(token) = tokens.next() {
        match attribute(&token, &mut tokens) {
            Some(Attribute::Doc) => {}
            Some(Attribute::Test) => skip_item(&mut tokens),
            None => write_token(token, text),
        }
    }
}

fn write_token(token: TokenTree, text: &mut String) {
    match token {
        TokenTree::Group(group) => {
            let (open, close) = match group.delimiter() {
                Delimiter::Parenthesis => ("( ", ") "),
                Delimiter::Brace => ("{ ", "} "),
                Delimiter::Bracket => ("[ ", "] "),
                Delimiter::None => ("", ""),
            };
            text.push_str(open);
            write(group.stream(), text);
            text.push_str(close);
        }
        // Joined with what follows, as in `<<`, or alone.
        TokenTree::Punct(punct) => {
            text.push(punct.as_char());
            if punct.spacing() == proc_macro2::Spacing::Alone {
                text.push(' ');
            }
        }
        TokenTree::Ident(_) | TokenTree::Literal(_) => {
            text.push_str(&token.to_string());
            text.push(' ');
        }
    }
}

/// Attributes that change nothing that is compiled.
enum Attribute {
    Doc,
    Test,
}

/// What attribute begins with this token; those that are known are taken from `rest`.
fn attribute(
    first: &TokenTree,
    rest: &mut Peekable<impl Iterator<Item = TokenTree> + Clone>,
) -> Option<Attribute> {
    let is = |token: &TokenTree, c| matches!(token, TokenTree::Punct(punct) if punct.as_char() == c);
    if !is(first, '#') {
        return None;
    }
    let mut ahead = rest.clone();
    let mut next = ahead.next()?;
    if is(&next, '!') {
        next = ahead.next()?;
    }
    let TokenTree::Group(group) = next else { return None };
    let inner = group.stream().to_string();
    let inner: String = inner.chars().filter(|c| !c.is_whitespace()).collect();
    let found = match () {
        () if inner.starts_with("doc=") => Attribute::Doc,
        () if inner == "cfg(test)" => Attribute::Test,
        () => return None,
    };
    *rest = ahead;
    Some(found)
}

/// Skips the rest of an item: to the end of its block, or its semicolon.
fn skip_item(tokens: &mut impl Iterator<Item = TokenTree>) {
    for token in tokens {
        match token {
            TokenTree::Group(group) if group.delimiter() == Delimiter::Brace => return,
            TokenTree::Punct(punct) if punct.as_char() == ';' => return,
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::of_source;

    const SOURCE: &str = "//! A file.\nuse a::b;\n/// Adds.\n#[inline(always)]\nfn f(x: u32) -> u32 { x << 1 + 2 }\n\
        #[cfg(test)]\nmod tests { fn g() {} }\n";

    #[test]
    fn comments_tests_and_line_breaks_are_not_compiled() {
        let tokens = of_source(SOURCE).unwrap();
        assert_eq!(tokens, "use a :: b ; # [ inline ( always ) ] fn f ( x : u32 ) -> u32 { x << 1 + 2 } ");
        for same in [
            SOURCE.replace("/// Adds.", "/// Adds two numbers.\n/// They are small."),
            SOURCE.replace("//! A file.", "// One.\n/* Two. */"),
            SOURCE.replace("fn g() {}", "#[test] fn g() { assert!(true); } struct S;"),
            SOURCE.replace("#[cfg(test)]", "#[cfg(test)]\n#[path = \"a.rs\"]"),
            SOURCE.replace(" { x", "\n{\n    x"),
            SOURCE.to_owned() + "#[cfg(test)]\nmod more;\n",
        ] {
            assert_eq!(of_source(&same).unwrap(), tokens, "{same}");
        }
        for other in [
            SOURCE.replace("<< 1", "<< 2"),
            SOURCE.replace("x << 1", "x < < 1"),
            SOURCE.replace("inline(always)", "inline"),
            SOURCE.replace("cfg(test)", "cfg(not(test))"),
            SOURCE.to_owned() + "mod more;\n",
        ] {
            assert_ne!(of_source(&other).unwrap(), tokens, "{other}");
        }
        assert!(of_source("fn f( {").is_err());
    }
}
