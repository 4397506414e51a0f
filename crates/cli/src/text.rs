//! Numbers for people.

pub(crate) use eosphor::job::bytes_in_words as bytes;

/// 1234567 as `1,234,567`.
pub(crate) fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// Seconds as `9 s`, `2 min 05 s` or `3 h 20 min`.
pub(crate) fn duration(seconds: f64) -> String {
    // A float too large for the integer saturates.
    let s = seconds.round() as u64;
    match s {
        0..60 => format!("{s} s"),
        60..3600 => format!("{} min {:02} s", s / 60, s % 60),
        _ => format!("{} h {:02} min", grouped(s / 3600), s / 60 % 60),
    }
}

/// `a / b`, and 0 where there is nothing to divide by.
pub(crate) fn ratio(a: f64, b: f64) -> f64 {
    if b > 0.0 { a / b } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_for_people() {
        assert_eq!([0, 999, 1000, 1234567].map(grouped), ["0", "999", "1,000", "1,234,567"]);
        assert_eq!([9.4, 125.0, 12_000.0].map(duration), ["9 s", "2 min 05 s", "3 h 20 min"]);
        assert_eq!(ratio(1.0, 0.0), 0.0);
    }
}
