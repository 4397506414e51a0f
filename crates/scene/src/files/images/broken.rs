//! What is said of picture files that decoders give up on.

use std::fmt::Display;

/// What decoders say of a file that ends too early, in small letters.
const CUT_SHORT: [&str; 10] = [
    "unexpected end",
    "unexpected eof",
    "unexpectedeof",
    "end of file",
    "failed to fill",
    "insufficientinput",
    "no more bytes",
    "missing bytes",
    "exhausted",
    "not enough",
];

/// The reasons for which decoders give up on whole files.
const UNREAD: [&str; 4] = ["unsupported", "not supported", "does not support", "unimplemented"];

/// What is wrong with a picture file and what to do, from what a decoder says, which speaks of its own insides.
pub fn broken_picture(kind: &str, reason: impl Display) -> String {
    let reason = reason.to_string().to_lowercase();
    let says = |words: &[&str]| words.iter().any(|word| reason.contains(word));
    match () {
        () if says(&CUT_SHORT) => cut_short(kind),
        () if says(&UNREAD) => unread(kind),
        () if says(&["crc", "checksum"]) => {
            format!("this {kind} file is damaged: a checksum does not fit its data; get it again")
        }
        () => damaged(kind),
    }
}

/// Of a file that ends too early.
pub(super) fn cut_short(kind: &str) -> String {
    format!("this {kind} file is cut short; get it again")
}

/// Of a variant of the format that is not read.
pub(super) fn unread(kind: &str) -> String {
    format!("{kind} files of this sort are not read; save it as a plain PNG, or EXR")
}

/// Of a file that contradicts its format.
pub(super) fn damaged(kind: &str) -> String {
    format!("this {kind} file is damaged: its data cannot be decoded; get it again, or save it anew")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_decoders_words_are_not_shown() {
        for (reason, words) in [
            ("Format(FormatError { inner: UnexpectedEof })", "cut short; get it again"),
            ("CRC error: expected 0x1 have 0x2 while decoding IDAT chunk", "a checksum"),
            ("Error parsing image. Illegal start bytes:5", "cannot be decoded"),
            ("Unsupported(ArithmeticCoding)", "not read; save it as"),
        ] {
            let said = broken_picture("PNG", reason);
            assert!(said.contains(words) && said.contains("PNG") && !said.contains("Format"), "{said}");
        }
    }
}
