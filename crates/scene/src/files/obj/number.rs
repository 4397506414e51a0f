//! Numbers in OBJ and MTL files.

/// What a word says as a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Number {
    /// A finite number.
    Good(f32),
    /// A finite number followed by something else, as in `-0.2200.`.
    Stray(f32),
    /// Infinite or not a number, as in `nan`, `-inf`, `1.#IND`, `1e99`.
    NotFinite,
    /// No number at all.
    Bad,
}

/// Reads a word as a number, correctly rounded to single precision.
pub(super) fn number(word: &[u8]) -> Number {
    match fast_float2::parse_partial::<f32, _>(word) {
        Ok((x, _)) if !x.is_finite() => Number::NotFinite,
        Ok((x, length)) if length == word.len() => Number::Good(x),
        Ok((_, length)) if word[length..].starts_with(b"#") => Number::NotFinite,
        Ok((x, _)) => Number::Stray(x),
        Err(_) => Number::Bad,
    }
}

/// The value, in double precision, of a word that is known to be a number.
pub(super) fn exact_number(word: &[u8]) -> f64 {
    fast_float2::parse_partial::<f64, _>(word).map_or(0.0, |(x, _)| x)
}

/// A whole number with an optional sign; saturates instead of overflowing.
pub(super) fn whole_number(word: &[u8]) -> Option<i64> {
    let (negative, digits) = match word {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, word),
    };
    if digits.is_empty() {
        return None;
    }
    let mut value = 0i64;
    for &digit in digits {
        if !digit.is_ascii_digit() {
            return None;
        }
        value = value.saturating_mul(10).saturating_add(i64::from(digit - b'0'));
    }
    Some(if negative { -value } else { value })
}

/// The run of at most eight digits that eight bytes start with: its value and its length. There is no branch on the
/// length, which is as good as random in a mesh.
#[inline(always)]
pub(super) fn eight_digits(bytes: [u8; 8]) -> (u32, usize) {
    let x = u64::from_le_bytes(bytes) ^ 0x3030_3030_3030_3030;
    // Digits are 0 to 9 now. The high bit marks the others, rightly up to the first of them: no carry comes before.
    let others = (x.wrapping_add(0x7676_7676_7676_7676) | x) & 0x8080_8080_8080_8080;
    let length = others.trailing_zeros() as usize / 8;
    // Moves the last digit of the run to the last byte; zeros go before the first.
    let x = x.checked_shl(64 - 8 * length as u32).unwrap_or(0);
    // Pairs, then fours and eights (Lemire 2018, as in fast_float's parse_eight_digits_unrolled).
    const MASK: u64 = 0x0000_00ff_0000_00ff;
    let pairs = x.wrapping_mul(10).wrapping_add(x >> 8);
    let high = (pairs & MASK).wrapping_mul(100 + (1_000_000 << 32));
    let low = ((pairs >> 16) & MASK).wrapping_mul(1 + (10_000 << 32));
    ((high.wrapping_add(low) >> 32) as u32, length)
}

/// The number that these bytes start with and how long it is, for decimals without exponent of at most eight digits on
/// either side of the point; others, and the last eight bytes of a file, are left to [`leading_number`]. The same as
/// [`number`] gives, bit by bit.
///
/// Below 2^53 the digits are exact in double precision, so is the power of ten, and their quotient is correctly rounded
/// (Clinger 1990). Rounding it again to single precision gives what one rounding would, unless it looks like the
/// middle between two single-precision numbers: then it may have been rounded to there.
#[inline(always)]
pub(super) fn plain_number(bytes: &[u8]) -> Option<(f32, usize)> {
    let negative = *bytes.first()? == b'-';
    let start = usize::from(negative);
    let (whole, whole_length) = eight_digits(*bytes.get(start..)?.first_chunk()?);
    let mut end = start + whole_length;
    let mut digits = u64::from(whole);
    let mut decimals = 0;
    if *bytes.get(end)? == b'.' {
        let (fraction, length) = eight_digits(*bytes.get(end + 1..)?.first_chunk()?);
        end += 1 + length;
        decimals = length;
        digits = digits * u64::from(POWERS[length]) + u64::from(fraction);
    }
    if whole_length + decimals == 0 || matches!(*bytes.get(end)?, b'0'..=b'9' | b'.' | b'e' | b'E') {
        return None;
    }
    let x = digits as f64 / f64::from(POWERS[decimals]);
    if digits >= 1 << 53 || x.to_bits() & 0x1fff_ffff == 0x1000_0000 {
        return None;
    }
    Some((if negative { -x as f32 } else { x as f32 }, end))
}

/// Powers of ten, exact in double precision too.
const POWERS: [u32; 9] = [1, 10, 100, 1_000, 10_000, 100_000, 1_000_000, 10_000_000, 100_000_000];

/// The finite number that these bytes start with and how long it is.
pub(super) fn leading_number(bytes: &[u8]) -> Option<(f32, usize)> {
    let (x, length) = fast_float2::parse_partial::<f32, _>(bytes).ok()?;
    x.is_finite().then_some((x, length))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn numbers() {
        for (word, expected) in [
            ("1", Number::Good(1.0)),
            ("+2.", Number::Good(2.0)),
            (".5", Number::Good(0.5)),
            ("-3.1E2", Number::Good(-310.0)),
            ("-0.2200.", Number::Stray(-0.22)),
            ("3.1+e2", Number::Stray(3.1)),
            ("nan", Number::NotFinite),
            ("-inf", Number::NotFinite),
            ("1.#IND", Number::NotFinite),
            ("1e99", Number::NotFinite),
            ("x", Number::Bad),
            ("", Number::Bad),
            ("-", Number::Bad),
        ] {
            assert_eq!(number(word.as_bytes()), expected, "{word}");
        }
    }

    #[test]
    fn runs_of_digits() {
        for (text, expected) in [
            ("12345678", (12_345_678, 8)),
            ("1234567 ", (1_234_567, 7)),
            ("9/99999/", (9, 1)),
            ("00000000", (0, 8)),
            (".1234567", (0, 0)),
            ("1\u{ff}\u{8a}\u{89}9999", (1, 1)),
            (":1234567", (0, 0)),
        ] {
            let bytes = text.chars().map(|c| c as u8).collect::<Vec<u8>>();
            assert_eq!(eight_digits(*bytes.first_chunk().unwrap()), expected, "{text:?}");
        }
    }

    /// What both ways of reading say of a word that is followed by a blank.
    fn agree(word: &str) -> Result<(), TestCaseError> {
        let line = format!("{word}         ");
        if let Some((x, length)) = plain_number(line.as_bytes()) {
            let expected = fast_float2::parse::<f32, _>(word).map(f32::to_bits).ok();
            prop_assert_eq!((Some(x.to_bits()), length), (expected, word.len()), "{}", word);
        }
        Ok(())
    }

    #[test]
    fn plain_numbers_are_plain() {
        for word in ["0", "-0", "-12.5", "123.", ".25", "99999999.99", "0.00000001", "16777216"] {
            assert!(plain_number(format!("{word}         ").as_bytes()).is_some(), "{word}");
        }
        // Digits of 2^53 and more, more digits than eight, exponents, middles between two numbers, no numbers.
        for word in
            ["99999999.99999999", "123456789", "1.123456789", "1e5", "16777217", "1.2.3", "+1", "-", ".", "x"]
        {
            assert_eq!(plain_number(format!("{word}         ").as_bytes()), None, "{word}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 4000, ..ProptestConfig::default() })]

        #[test]
        fn plain_numbers_are_correctly_rounded(sign in "-?", whole in "[0-9]{0,8}", fraction in "[0-9]{0,8}") {
            agree(&format!("{sign}{whole}.{fraction}"))?;
            agree(&format!("{sign}{whole}"))?;
        }

        #[test]
        fn numbers_in_the_middle_are_correctly_rounded(bits in 0x3f00_0000u32..0x4b80_0000, step in -2i64..3) {
            // The middle between two neighbours in single precision, and doubles near it, in decimals.
            let middle = (f64::from(f32::from_bits(bits)) + f64::from(f32::from_bits(bits + 1))) / 2.0;
            let x = f64::from_bits((middle.to_bits() as i64 + step) as u64);
            for decimals in 0..9 {
                agree(&format!("{x:.decimals$}"))?;
            }
        }
    }
}
