//! Frames a second.

use std::fmt::{self, Display, Formatter};
use std::num::NonZeroU32;
use std::str::FromStr;

/// The most frames a second.
const HIGHEST: u32 = 240;

/// The largest numerator and denominator, so that no product of them overflows.
const LARGEST: u32 = 1_000_000;

/// Frames a second, as a fraction: 30000/1001 is what people call 29.97.
///
/// ```
/// use eosphor_picture::output::FrameRate;
///
/// assert_eq!("25".parse(), FrameRate::new(25, 1));
/// assert_eq!("29.97".parse(), FrameRate::new(30_000, 1001));
/// assert_eq!("12.5".parse(), FrameRate::new(25, 2));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameRate {
    numerator: NonZeroU32,
    denominator: NonZeroU32,
}

/// A number of frames a second that cannot be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "frames a second must be a number or a fraction above 0 and up to {HIGHEST}: 24, 29.97 or 30000/1001"
)]
pub struct InvalidFrameRate;

impl FrameRate {
    /// So many frames in so many seconds, in lowest terms.
    ///
    /// # Errors
    ///
    /// Where it is 0 or above 240, or has a part above 1,000,000 in lowest terms.
    pub fn new(frames: u32, seconds: u32) -> Result<FrameRate, InvalidFrameRate> {
        let common = greatest_common_divisor(frames, seconds).max(1);
        let rate = (frames / common, seconds / common);
        let within = rate.0 <= LARGEST && rate.1 <= LARGEST && rate.0 <= rate.1.saturating_mul(HIGHEST);
        match (NonZeroU32::new(rate.0), NonZeroU32::new(rate.1)) {
            (Some(numerator), Some(denominator)) if within => Ok(FrameRate { numerator, denominator }),
            _ => Err(InvalidFrameRate),
        }
    }

    /// How many frames there are in [`FrameRate::denominator`] seconds.
    pub fn numerator(self) -> u32 {
        self.numerator.get()
    }

    /// How many seconds [`FrameRate::numerator`] frames take.
    pub fn denominator(self) -> u32 {
        self.denominator.get()
    }

    /// Frames per second, rounded to double precision.
    pub fn hertz(self) -> f64 {
        self.numerator() as f64 / self.denominator() as f64
    }

    /// The numerator is the time scale of the file: units a second.
    pub(super) fn time_scale(self) -> NonZeroU32 {
        self.numerator
    }
}

impl FromStr for FrameRate {
    type Err = InvalidFrameRate;

    /// A whole number, a fraction, or a decimal. The decimals that stand for the rates of television are those rates.
    fn from_str(text: &str) -> Result<FrameRate, InvalidFrameRate> {
        let whole = |text: &str| text.parse::<u32>().map_err(|_| InvalidFrameRate);
        if let Some((frames, seconds)) = text.split_once('/') {
            return FrameRate::new(whole(frames)?, whole(seconds)?);
        }
        let Some((before, after)) = text.split_once('.') else { return FrameRate::new(whole(text)?, 1) };
        match text {
            "23.976" | "23.98" => return FrameRate::new(24_000, 1001),
            "29.97" => return FrameRate::new(30_000, 1001),
            "59.94" => return FrameRate::new(60_000, 1001),
            "119.88" => return FrameRate::new(120_000, 1001),
            _ => {}
        }
        if after.is_empty() || after.len() > 6 || !after.bytes().all(|byte| byte.is_ascii_digit()) {
            return Err(InvalidFrameRate);
        }
        let unit = 10u32.pow(after.len() as u32);
        let frames =
            whole(before)?.checked_mul(unit).and_then(|frames| frames.checked_add(whole(after).ok()?));
        FrameRate::new(frames.ok_or(InvalidFrameRate)?, unit)
    }
}

impl Display for FrameRate {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self.denominator() {
            1 => write!(f, "{}", self.numerator),
            denominator => write!(f, "{}/{denominator}", self.numerator),
        }
    }
}

fn greatest_common_divisor(mut a: u32, mut b: u32) -> u32 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_read_and_written() {
        let cases = [
            ("24", "24"),
            ("60/2", "30"),
            ("23.976", "24000/1001"),
            ("59.94", "60000/1001"),
            ("12.5", "25/2"),
            ("0.25", "1/4"),
            ("30000/1001", "30000/1001"),
            ("240", "240"),
        ];
        for (text, written) in cases {
            let rate: FrameRate = text.parse().unwrap();
            assert_eq!(rate.to_string(), written);
            assert_eq!(written.parse(), Ok(rate));
        }
    }

    #[test]
    fn what_is_no_rate_is_refused() {
        let wrong = [
            "",
            "0",
            "-1",
            "241",
            "1/0",
            "0/1",
            "0/0",
            "30/",
            "/2",
            "1.",
            ".5",
            "1e2",
            "nan",
            "4294967295.999999",
            "1.0000001",
            "1.+5",
            "999999999999",
            "2000001/1000003",
            "240.1",
            "25fps",
            "1/2/3",
        ];
        for text in wrong {
            assert!(text.parse::<FrameRate>().is_err(), "{text}");
        }
    }
}
