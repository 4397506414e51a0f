//! Where the sun stands at a time and a place.
//!
//! By the low-accuracy formulas of Meeus, "Astronomical Algorithms" (second edition, 1998), chapters 7, 12, 13 and 25, as NOAA's
//! solar calculator has them too: 0.01 degrees from 1950 to 2050. The air's refraction, which lifts a sun at the horizon by half a
//! degree, is left out, and so is the parallax, 0.002 degrees.

use super::angles::{asin, atan2, turned_once};
use crate::model::Sky;
use eosphor_core::math::elementary64::sin_cos;
use std::f64::consts::PI;

/// A place of the sun in the sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunPosition {
    /// Over the horizon; below it less than 0.
    pub elevation_degrees: f64,
    /// Clockwise from north, 0 to 360.
    pub azimuth_degrees: f64,
}

/// Where the sun stands at a time, such as `2026-06-21T15:30+02:00`, at a latitude (north counts up, -90 to 90) and a longitude
/// (east counts up, -180 to 180) in degrees. The time has its zone: `Z` or hours and minutes ahead of Greenwich; seconds may stand
/// in it.
///
/// # Errors
/// What is wrong with the time or the place, in words.
pub fn sun_position(
    time: &str,
    latitude_degrees: f64,
    longitude_degrees: f64,
) -> Result<SunPosition, String> {
    for (name, value, most) in [("latitude", latitude_degrees, 90.0), ("longitude", longitude_degrees, 180.0)]
    {
        if !(value.abs() <= most) {
            return Err(format!("the {name} {value} is out of range: it must be from -{most} to {most}"));
        }
    }
    let days = days_from_2000(time).ok_or_else(|| {
        format!(
            "\"{time}\" is no date with a time and its zone; write it as 2026-06-21T15:30+02:00, or with Z for universal time"
        )
    })?;
    Ok(position(days, latitude_degrees, longitude_degrees))
}

impl Sky {
    /// Puts the sun where it stands.
    ///
    /// # Errors
    /// Where it is below the horizon, in words: the model has no sky for that.
    pub fn put_sun(&mut self, sun: SunPosition) -> Result<(), String> {
        let SunPosition { elevation_degrees, azimuth_degrees } = sun;
        if elevation_degrees < 0.0 {
            let below = -elevation_degrees;
            return Err(format!(
                "the sun is {below:.1} degrees below the horizon then, and there is no sky for that; choose a time of the day"
            ));
        }
        (self.sun_elevation_degrees, self.sun_azimuth_degrees) =
            (elevation_degrees as f32, azimuth_degrees as f32);
        Ok(())
    }
}

/// Days since noon of the first of January 2000, universal time.
fn days_from_2000(time: &str) -> Option<f64> {
    let number = |from: usize, to: usize| -> Option<i64> {
        let digits = time.get(from..to)?;
        digits.bytes().all(|byte| byte.is_ascii_digit()).then(|| digits.parse().ok())?
    };
    let is = |at: usize, byte: u8| (time.as_bytes().get(at) == Some(&byte)).then_some(());
    let (year, month, day) = (number(0, 4)?, number(5, 7)?, number(8, 10)?);
    let (hour, minute) = (number(11, 13)?, number(14, 16)?);
    [(4, b'-'), (7, b'-'), (10, b'T'), (13, b':')].into_iter().try_for_each(|(at, byte)| is(at, byte))?;
    let has_seconds = is(16, b':').is_some();
    let (second, zone) = if has_seconds { (number(17, 19)?, 19) } else { (0, 16) };
    let ahead = match time.get(zone..)? {
        "Z" => 0,
        text if text.len() == 6 && text.as_bytes()[3] == b':' => {
            let (hours, minutes) = (number(zone + 1, zone + 3)?, number(zone + 4, zone + 6)?);
            let ahead = (hours <= 14 && minutes < 60).then_some(60 * hours + minutes)?;
            match text.as_bytes()[0] {
                b'+' => ahead,
                b'-' => -ahead,
                _ => return None,
            }
        }
        _ => return None,
    };
    let is_leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    let days = [31, if is_leap { 29 } else { 28 }, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
    let days_before = days.iter().take(usize::try_from(month - 1).ok()?).sum::<i64>();
    let is_day = (1..=12).contains(&month) && day >= 1 && day <= days[(month - 1) as usize];
    if !is_day || year < 1 || hour > 23 || minute > 59 || second > 59 {
        return None;
    }
    // By the Gregorian calendar.
    let before = year - 1;
    let leaps = before / 4 - before / 100 + before / 400;
    const TO_2000: i64 = 1999 * 365 + 1999 / 4 - 1999 / 100 + 1999 / 400;
    let whole_days = before * 365 + leaps + days_before + day - 1 - TO_2000;
    let seconds = 60 * (60 * hour + minute - ahead) + second;
    Some(whole_days as f64 - 0.5 + seconds as f64 / 86_400.0)
}

/// `days`: since noon of the first of January 2000, universal time, which counts as the even one of ephemerides.
fn position(days: f64, latitude_degrees: f64, longitude_degrees: f64) -> SunPosition {
    let radians = |degrees: f64| (degrees % 360.0) * (PI / 180.0);
    let (right_ascension, declination) = equatorial(days / 36_525.0);
    let centuries = days / 36_525.0;
    // Meeus 12.4: Greenwich's mean sidereal time.
    let sidereal = 280.460_618_37 + 360.985_647_366_29 * days + 0.000_387_933 * centuries * centuries;
    let hour_angle = radians(sidereal) + radians(longitude_degrees) - right_ascension;
    let (sin_hour, cos_hour) = sin_cos(turned_once(hour_angle));
    let (sin_latitude, cos_latitude) = sin_cos(radians(latitude_degrees));
    let (sin_declination, cos_declination) = sin_cos(declination);
    let up = sin_latitude * sin_declination + cos_latitude * cos_declination * cos_hour;
    let east = -cos_declination * sin_hour;
    let north = cos_latitude * sin_declination - sin_latitude * cos_declination * cos_hour;
    SunPosition {
        elevation_degrees: asin(up) * (180.0 / PI),
        azimuth_degrees: turned_once(atan2(east, north)) * (180.0 / PI),
    }
}

/// The sun's apparent right ascension and declination, in radians. `t`: Julian centuries since 2000.
fn equatorial(t: f64) -> (f64, f64) {
    let radians = |degrees: f64| (degrees % 360.0) * (PI / 180.0);
    let mean_longitude = 280.466_46 + t * (36_000.769_83 + t * 0.000_303_2);
    let anomaly = radians(357.529_11 + t * (35_999.050_29 - t * 0.000_153_7));
    let sine = |k: f64| sin_cos(k * anomaly).0;
    let center = (1.914_602 - t * (0.004_817 + t * 0.000_014)) * sine(1.0)
        + (0.019_993 - t * 0.000_101) * sine(2.0)
        + 0.000_289 * sine(3.0);
    let (sin_node, cos_node) = sin_cos(radians(125.04 - 1_934.136 * t));
    // Aberration and nutation.
    let longitude = radians(mean_longitude + center - 0.005_69 - 0.004_78 * sin_node);
    let obliquity = 23.439_291_11 - t * (0.013_004_167 + t * (1.639e-7 - t * 5.036e-7));
    let (sin_tilt, cos_tilt) = sin_cos(radians(obliquity + 0.002_56 * cos_node));
    let (sin_longitude, cos_longitude) = sin_cos(longitude);
    (atan2(cos_tilt * sin_longitude, cos_longitude), asin(sin_tilt * sin_longitude))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_near(got: f64, want: f64, most: f64) {
        assert!((got - want).abs() <= most, "{got} instead of {want}");
    }

    /// Meeus, example 25.a: 13 October 1992, 0 h.
    #[test]
    fn the_sun_of_meeus() {
        let days = days_from_2000("1992-10-13T00:00Z").unwrap();
        assert_eq!(days, 2_448_908.5 - 2_451_545.0);
        let (right_ascension, declination) = equatorial(days / 36_525.0);
        assert_near(turned_once(right_ascension) * 180.0 / PI, 198.380_83, 2e-5);
        assert_near(declination * 180.0 / PI, -7.785_07, 2e-5);
    }

    /// The example of NREL's solar position algorithm (Reda and Andreas 2008, table A5.1), before refraction.
    #[test]
    fn the_sun_of_nrel() {
        let sun = sun_position("2003-10-17T12:30:30-07:00", 39.742_476, -105.178_6).unwrap();
        assert_near(sun.azimuth_degrees, 194.340_241, 0.01);
        assert_near(sun.elevation_degrees, 39.872_046, 0.01);
    }

    #[test]
    fn letters_of_two_bytes_are_no_time() {
        for time in [
            "0860-06-21T15:30+0\u{3be}00",
            "2024-06-21T15:30\u{3be}0:00",
            "2024-06-21T15:30+0\u{3be}:0",
            "\u{3be}",
        ] {
            assert_eq!(days_from_2000(time), None, "{time}");
        }
    }

    #[test]
    fn noons_and_midnights() {
        // At the solstice it is overhead at the tropic, and in the south of Greenwich at 90 - 51.48 + 23.44 degrees.
        let overhead = sun_position("2024-06-20T12:02Z", 23.436, 0.0).unwrap();
        assert!(overhead.elevation_degrees > 89.9, "{overhead:?}");
        let south = sun_position("2024-06-20T12:02Z", 51.48, 0.0).unwrap();
        assert_near(south.elevation_degrees, 61.956, 0.01);
        assert_near(south.azimuth_degrees, 180.0, 0.3);
        // The sun of midnight in the north.
        let north = sun_position("2024-06-21T00:02Z", 75.0, 0.0).unwrap();
        assert_near(north.elevation_degrees, 75.0 + 23.436 - 90.0, 0.01);
        assert!((north.azimuth_degrees + 180.0) % 360.0 - 180.0 < 0.3, "{north:?}");
        // In the morning it stands in the east, where it is later, too, by the same time of the zone.
        let east = sun_position("2024-03-20T08:00+02:00", 0.0, 30.0).unwrap();
        assert_near(east.azimuth_degrees, 90.0, 0.5);
        assert!(sun_position("2024-03-20T06:00Z", 0.0, 30.0).unwrap() == east);
        assert!(sun_position("2024-03-20T23:00Z", 0.0, 0.0).unwrap().elevation_degrees < -60.0);
    }

    #[test]
    fn times_and_places_that_are_none() {
        for time in [
            "",
            "2024",
            "2024-06-20",
            "2024-06-20T12:00",
            "2024-06-20 12:00Z",
            "2024-13-01T12:00Z",
            "2024-00-01T12:00Z",
            "2023-02-29T12:00Z",
            "2024-06-31T12:00Z",
            "2024-06-20T24:00Z",
            "2024-06-20T12:60Z",
            "2024-06-20T12:00:60Z",
            "2024-06-20T12:00+2",
            "2024-06-20T12:00+15:00",
            "2024-06-20T12:00*02:00",
            "2024-06-20T1-:00Z",
            "0000-06-20T12:00Z",
            "2024-06-20T12:00ZZ",
            "２024-06-20T12:00Z",
            "2024-06-20T12:00+0é0",
        ] {
            let error = sun_position(time, 0.0, 0.0).unwrap_err();
            assert!(error.contains("2026-06-21T15:30+02:00"), "{time}: {error}");
        }
        assert!(sun_position("2024-02-29T12:00:59Z", 90.0, -180.0).is_ok());
        for (latitude, longitude) in [(90.1, 0.0), (f64::NAN, 0.0), (0.0, -180.5), (0.0, f64::INFINITY)] {
            assert!(
                sun_position("2024-02-29T12:00Z", latitude, longitude).unwrap_err().contains("out of range")
            );
        }
    }
}
