//! Values of flags.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use eosphor::Region;
use eosphor::math::Vec3;
use std::ops::{Bound, RangeBounds, RangeInclusive};

/// The range of lengths that may be 0.
pub(super) const LENGTHS: RangeInclusive<f32> = 0.0..=1e12;

/// Of lengths that have to be some.
pub(super) const OVER_0: (Bound<f32>, Bound<f32>) = (Bound::Excluded(0.0), Bound::Included(1e12));

/// One of a few names; `--help` and completions list them.
pub(super) fn named<T, const N: usize>(names: [(&'static str, T); N]) -> impl TypedValueParser<Value = T>
where
    T: Copy + Send + Sync + 'static,
{
    let parser = PossibleValuesParser::new(names.map(|(name, _)| name));
    parser.try_map(move |text| {
        let found = names.iter().find(|(name, _)| *name == text);
        found.map(|(_, value)| *value).ok_or_else(|| format!("there is no {text}"))
    })
}

/// A whole number of a range, which the message names.
pub(super) fn whole<T>(range: RangeInclusive<u32>) -> impl TypedValueParser<Value = T>
where
    T: TryFrom<u32> + Clone + Send + Sync + 'static,
{
    move |text: &str| -> Result<T, String> {
        let number = text.parse().ok().filter(|number| range.contains(number));
        let number = number.and_then(|number| T::try_from(number).ok());
        number.ok_or_else(|| format!("it must be a whole number, {}", words(&range, u32::to_string)))
    }
}

/// A number of a range, which the message names.
pub(super) fn within(
    range: impl RangeBounds<f32> + Clone + Send + Sync + 'static,
) -> impl TypedValueParser<Value = f32> {
    move |text: &str| -> Result<f32, String> {
        // What is not finite is in none.
        let number = number(text).ok().filter(|number| range.contains(number));
        number.ok_or_else(|| format!("it must be a number, {}", words(&range, short)))
    }
}

/// A range as help texts and messages say it.
fn words<T>(range: &impl RangeBounds<T>, show: impl Fn(&T) -> String) -> String {
    let low = match range.start_bound() {
        Bound::Included(low) => Some(format!("at least {}", show(low))),
        Bound::Excluded(low) => Some(format!("over {}", show(low))),
        Bound::Unbounded => None,
    };
    let high = match range.end_bound() {
        Bound::Included(high) => Some(format!("at most {}", show(high))),
        Bound::Excluded(high) => Some(format!("under {}", show(high))),
        Bound::Unbounded => None,
    };
    match (range.start_bound(), range.end_bound()) {
        (Bound::Included(low), Bound::Included(high)) => format!("{} to {}", show(low), show(high)),
        _ => low.into_iter().chain(high).collect::<Vec<String>>().join(" and "),
    }
}

/// 1e12 rather than all its digits.
fn short(number: &f32) -> String {
    if number.abs() < 1e5 { number.to_string() } else { format!("{number:e}") }
}

/// `800x600`.
pub(super) fn size(text: &str) -> Result<[u32; 2], String> {
    let (width, height) = text.split_once(['x', 'X']).ok_or("it must be WIDTHxHEIGHT, as 800x600")?;
    let side = |text: &str| {
        let sane = text.parse().ok().filter(|side| (1..=eosphor::MAX_SIDE).contains(side));
        sane.ok_or_else(|| format!("each side must be a whole number from 1 to {}", eosphor::MAX_SIDE))
    };
    Ok([side(width)?, side(height)?])
}

/// `100,50,320x240`.
pub(super) fn region(text: &str) -> Result<Region, String> {
    let wrong = || "it must be X,Y,WIDTHxHEIGHT, as 100,50,320x240".to_owned();
    let mut words = text.splitn(3, ',');
    let mut place = || words.next().and_then(|word| word.parse().ok()).ok_or_else(wrong);
    let (x, y) = (place()?, place()?);
    let [width, height] = size(words.next().ok_or_else(wrong)?)?;
    Ok(Region { x, y, width, height })
}

/// `1,-2.5,3`.
pub(super) fn triple(text: &str) -> Result<Vec3, String> {
    let numbers = text.split(',').map(number).collect::<Result<Vec<f32>, String>>()?;
    let triple: [f32; 3] = numbers.try_into().map_err(|_| "it must be three numbers, as 1,0,-2.5")?;
    Ok(triple.into())
}

/// `0.2,0.3,0.5`, of light.
pub(super) fn color(text: &str) -> Result<Vec3, String> {
    let color = triple(text)?;
    let is_light = [color.x, color.y, color.z].iter().all(|&x| x >= 0.0);
    is_light.then_some(color).ok_or_else(|| "each number must be 0 or more".into())
}

/// A place, in double precision, for it may be far from 0; within the range of single precision.
pub(super) fn place(text: &str) -> Result<[f64; 3], String> {
    triple(text)?;
    let exact = |word: &str| word.trim().parse().map_err(|_| format!("\"{word}\" is no finite number"));
    let numbers = text.split(',').map(exact).collect::<Result<Vec<f64>, String>>()?;
    numbers.try_into().map_err(|_| "it must be three numbers, as 1,0,-2.5".into())
}

/// A finite number.
pub(super) fn number(text: &str) -> Result<f32, String> {
    let number = text.trim().parse::<f32>().ok().filter(|x| x.is_finite());
    number.ok_or_else(|| format!("\"{text}\" is no finite number"))
}

/// `512M`, `4G`, `4GiB` or bytes.
pub(super) fn bytes(text: &str) -> Result<u64, String> {
    let wrong = || "it must be a whole number of bytes, or of K, M, G or T, as 512M".to_owned();
    let end = text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
    let (digits, unit) = text.split_at(end);
    let unit = match unit.to_ascii_lowercase().as_str() {
        "" => 1,
        "k" | "kib" => 1 << 10,
        "m" | "mib" => 1 << 20,
        "g" | "gib" => 1 << 30,
        "t" | "tib" => 1 << 40,
        _ => return Err(wrong()),
    };
    let number: u64 = digits.parse().map_err(|_| wrong())?;
    number.checked_mul(unit).ok_or_else(wrong)
}

#[cfg(test)]
mod tests {
    use super::*;
    use eosphor::math::vec3;

    #[test]
    fn ranges_have_words() {
        assert_eq!(words(&(1..=65_536), u32::to_string), "1 to 65536");
        assert_eq!(words(&(-64.0..=64.0), short), "-64 to 64");
        assert_eq!(words(&OVER_0, short), "over 0 and at most 1e12");
        assert_eq!(words(&(Bound::Excluded(0.0), Bound::Excluded(180.0)), short), "over 0 and under 180");
        assert_eq!(words(&(1..), u32::to_string), "at least 1");
    }

    #[test]
    fn sizes() {
        assert_eq!(size("800x600"), Ok([800, 600]));
        assert_eq!(size("1X65535"), Ok([1, 65_535]));
        for bad in ["", "x", "800", "0x5", "5x0", "99999x99999", "-1x5", "1.5x2", "5x5x5", "99999999999x1"] {
            assert!(size(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn regions() {
        assert_eq!(region("100,50,320x240"), Ok(Region { x: 100, y: 50, width: 320, height: 240 }));
        for bad in ["", "1,2", "1,2,3", "-1,2,3x4", "1,2,0x4", "1,2,3x4,5", "1,2,3x4x5", "x,2,3x4", "1,,3x4"]
        {
            assert!(region(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn sizes_of_memory() {
        for (text, expected) in [
            ("0", 0),
            ("1000", 1000),
            ("3k", 3072),
            ("512M", 512 << 20),
            ("4GiB", 4 << 30),
            ("1T", 1 << 40),
            ("18446744073709551615", u64::MAX),
        ] {
            assert_eq!(bytes(text), Ok(expected), "{text}");
        }
        for bad in ["", "M", "-1", "1.5G", "4GB", "4 G", "1P", "18446744073709551616", "99999999T", "4Gé"] {
            assert!(bytes(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn triples() {
        assert_eq!(triple("1, -2.5,3e2"), Ok(vec3(1.0, -2.5, 300.0)));
        assert_eq!(place("5000000.001, -2.5,3e2"), Ok([5_000_000.001, -2.5, 300.0]));
        for bad in ["", "1,2", "1,2,3,4", "1,,3", "a,b,c", "1,nan,2", "inf,0,0", "1e39,0,0"] {
            assert!(triple(bad).is_err() && place(bad).is_err(), "{bad}");
        }
    }
}
