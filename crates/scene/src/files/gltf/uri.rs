//! What a `uri` of glTF names: a file beside the glTF, or bytes written into it.

/// The bytes of a `data:` URI, or `None` where it is another.
pub(super) fn data(uri: &str) -> Option<Result<Vec<u8>, String>> {
    let rest = uri.get(..5).filter(|scheme| scheme.eq_ignore_ascii_case("data:")).map(|_| &uri[5..])?;
    let Some((kind, text)) = rest.split_once(',') else {
        return Some(Err("a data URI without a comma".into()));
    };
    let is_base64 =
        kind.get(kind.len().saturating_sub(7)..).is_some_and(|e| e.eq_ignore_ascii_case(";base64"));
    Some(if is_base64 { base64(text.as_bytes()) } else { Ok(percent_decoded(text)) })
}

/// `%20` read as a blank, and so on; what is no such code stays as it is.
pub(super) fn percent_decoded(text: &str) -> Vec<u8> {
    let bytes = text.as_bytes();
    let mut out = Vec::with_capacity(bytes.len());
    let mut i = 0;
    while i < bytes.len() {
        let digit = |at: usize| bytes.get(at).and_then(|&b| (b as char).to_digit(16));
        match (bytes[i], digit(i + 1), digit(i + 2)) {
            (b'%', Some(high), Some(low)) => {
                out.push((high * 16 + low) as u8);
                i += 3;
            }
            (byte, ..) => {
                out.push(byte);
                i += 1;
            }
        }
    }
    out
}

/// Whether a URI points into the network: `http://` and the like. `C:\x` does not.
pub(super) fn is_remote(uri: &str) -> bool {
    uri.split_once("://").is_some_and(|(scheme, _)| {
        scheme.len() > 1 && scheme.bytes().all(|b| b.is_ascii_alphanumeric() || b"+-.".contains(&b))
    })
}

/// No digit.
const NONE: u8 = 64;

/// The value of each base64 digit, those of the variant for URLs included.
const VALUES: [u8; 256] = {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut values = [NONE; 256];
    let mut i = 0;
    while i < 64 {
        values[DIGITS[i] as usize] = i as u8;
        i += 1;
    }
    values[b'-' as usize] = 62;
    values[b'_' as usize] = 63;
    values
};

/// RFC 4648; padding may be missing.
fn base64(text: &[u8]) -> Result<Vec<u8>, String> {
    let end = text.iter().rposition(|&b| b != b'=').map_or(0, |last| last + 1);
    let digits = &text[..end];
    if digits.len() % 4 == 1 {
        return Err("a data URI whose base64 is cut short".into());
    }
    let mut out = Vec::with_capacity(digits.len() / 4 * 3 + 2);
    let mut all = 0;
    for group in digits.chunks(4) {
        let mut bits = 0;
        for k in 0..4 {
            let value = group.get(k).map_or(0, |&digit| VALUES[digit as usize]);
            all |= value;
            bits = bits << 6 | u32::from(value & 63);
        }
        out.extend_from_slice(&bits.to_be_bytes()[1..group.len()]);
    }
    if all & NONE != 0 {
        return Err("a data URI with a character that is not base64".into());
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_of_rfc_4648_and_percent_codes() {
        for (uri, bytes) in [
            ("data:;base64,", "".as_bytes()),
            ("data:application/octet-stream;base64,Zg==", b"f"),
            ("data:;base64,Zg", b"f"),
            ("data:;base64,Zm8=", b"fo"),
            ("data:;base64,Zm9v", b"foo"),
            ("DATA:text/plain;BASE64,Zm9vYmFy", b"foobar"),
            ("data:;base64,+/-_", &[0xfb, 0xff, 0xbf]),
            ("data:,a%20b%2", b"a b%2"),
        ] {
            assert_eq!(data(uri).unwrap().unwrap(), bytes, "{uri}");
        }
        assert!(data("a.bin").is_none() && data("dat").is_none() && data("dät:;x").is_none());
        for wrong in ["data:;base64", "data:;base64,Zm9vY", "data:;base64,Zm 9", "data:;base64,Zé"] {
            assert!(data(wrong).unwrap().is_err(), "{wrong}");
        }
    }

    #[test]
    fn names_of_files_and_of_the_network() {
        assert_eq!(percent_decoded("a%20b%C3%A9%zz%"), "a bé%zz%".as_bytes());
        assert!(is_remote("https://x/y.bin") && is_remote("file:///y.bin"));
        assert!(!is_remote("a.bin") && !is_remote("C:/y.bin") && !is_remote("a b://c"));
    }
}
