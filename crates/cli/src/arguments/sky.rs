//! Flags of a sky with its sun.

use super::values::{number, within};
use super::{Need, check};
use crate::failure::Failure;
use clap::Args;
use eosphor::{EnvironmentMap, EnvironmentSource, Scene, Sky, sun_position};

#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Lights")]
pub(crate) struct SkyFlags {
    /// Surround the scene with a clear sky with its sun, by the model of Hosek and Wilkie, above ground that it lights; a radiance
    /// of 1 stands for 30,000 cd/m². Needs --integrator path
    #[arg(long, conflicts_with = "environment")]
    sky: bool,
    /// Where the sky's sun stands: degrees over the horizon (0 to 90), and clockwise from north (-360 to 360). With +y up, north is
    /// -z and east +x; with +z up, north is +y [default: 45,135]
    #[arg(long, value_name = "ELEVATION[,AZIMUTH]", value_parser = sun, allow_hyphen_values = true)]
    sky_sun: Option<(f32, Option<f32>)>,
    /// The time that the sky's sun stands at, as 2026-06-21T15:30+02:00: with its zone, or Z for universal time
    #[arg(long, value_name = "TIME", value_parser = time, allow_hyphen_values = true,
        requires = "sky_place", conflicts_with = "sky_sun")]
    sky_time: Option<String>,
    /// The place that --sky-time is meant at: degrees north (-90 to 90) and east (-180 to 180)
    #[arg(long, value_name = "LATITUDE,LONGITUDE", value_parser = place, requires = "sky_time", allow_hyphen_values = true)]
    sky_place: Option<[f64; 2]>,
    /// How hazy the sky is, 1 to 10: 2 is very clear, 3 clear, 6 hazy [default: 3]
    #[arg(long, value_name = "X", value_parser = within(1.0..=10.0), allow_hyphen_values = true)]
    sky_turbidity: Option<f32>,
    /// The share of light that the ground below the sky reflects, 0 to 1 [default: 0.3]
    #[arg(long, value_name = "X", value_parser = within(0.0..=1.0), allow_hyphen_values = true)]
    sky_albedo: Option<f32>,
    /// The radiance of the sun's disk over what the model says, 0 to 1e6; 0: no disk [default: 1]
    #[arg(long, value_name = "X", value_parser = within(0.0..=1e6), allow_hyphen_values = true)]
    sky_sun_strength: Option<f32>,
}

impl SkyFlags {
    pub(super) fn is_given(&self) -> bool {
        self.sky
    }

    /// Puts a sky in place of the scene's environment, or changes the scene's sky.
    pub(super) fn apply(&self, scene: &mut Scene) -> Result<(), Failure> {
        if self.sky {
            scene.environment = Some(EnvironmentMap::of_sky(Sky::default()));
        }
        let sky = match &mut scene.environment {
            Some(EnvironmentMap { source: EnvironmentSource::Sky(sky), .. }) => Some(sky),
            _ => None,
        };
        let is_met = sky.is_some();
        let of_sky =
            |flag, is_given| Need { flag, is_given, is_met, needs: "--sky, or a scene that has one" };
        check(&[
            of_sky("--sky-sun", self.sky_sun.is_some()),
            of_sky("--sky-time", self.sky_time.is_some()),
            of_sky("--sky-turbidity", self.sky_turbidity.is_some()),
            of_sky("--sky-albedo", self.sky_albedo.is_some()),
            of_sky("--sky-sun-strength", self.sky_sun_strength.is_some()),
        ])?;
        let Some(sky) = sky else { return Ok(()) };
        if let Some((elevation, azimuth)) = self.sky_sun {
            sky.sun_elevation_degrees = elevation;
            sky.sun_azimuth_degrees = azimuth.unwrap_or(sky.sun_azimuth_degrees);
        }
        if let (Some(time), Some([latitude, longitude])) = (&self.sky_time, self.sky_place) {
            let sun = sun_position(time, latitude, longitude);
            sun.and_then(|sun| sky.put_sun(sun))
                .map_err(|problem| Failure::Usage(format!("--sky-time: {problem}")))?;
        }
        sky.turbidity = self.sky_turbidity.unwrap_or(sky.turbidity);
        sky.albedo = self.sky_albedo.unwrap_or(sky.albedo);
        sky.sun_strength = self.sky_sun_strength.unwrap_or(sky.sun_strength);
        Ok(())
    }
}

/// `30` or `30,225`.
fn sun(text: &str) -> Result<(f32, Option<f32>), String> {
    let (elevation, azimuth) = match text.split_once(',') {
        Some((elevation, azimuth)) => (number(elevation)?, Some(number(azimuth)?)),
        None => (number(text)?, None),
    };
    if !(0.0..=90.0).contains(&elevation) {
        return Err(format!("{elevation} is out of range: the sun stands 0 to 90 degrees over the horizon"));
    }
    match azimuth.filter(|azimuth| !(-360.0..=360.0).contains(azimuth)) {
        Some(azimuth) => Err(format!("{azimuth} is out of range: the azimuth must be from -360 to 360")),
        None => Ok((elevation, azimuth)),
    }
}

/// `2026-06-21T15:30+02:00`.
fn time(text: &str) -> Result<String, String> {
    sun_position(text, 0.0, 0.0).map(|_| text.to_owned())
}

/// `50.1,14.4`.
fn place(text: &str) -> Result<[f64; 2], String> {
    let exact = |word: &str| {
        number(word)?;
        word.trim().parse::<f64>().map_err(|_| format!("\"{word}\" is no finite number"))
    };
    let (latitude, longitude) = text.split_once(',').ok_or("it must be two numbers, as 50.1,14.4")?;
    Ok([exact(latitude)?, exact(longitude)?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn suns_have_one_number_or_two() {
        assert_eq!(sun("30"), Ok((30.0, None)));
        assert_eq!(sun("0,-90.5"), Ok((0.0, Some(-90.5))));
        for bad in ["", "x", "91", "-0.1", "nan", "30,", "30,361", "30,1,2", "30,inf"] {
            assert!(sun(bad).is_err(), "{bad}");
        }
        assert_eq!(place("-33.9, 151.2"), Ok([-33.9, 151.2]));
        for bad in ["", "1", "1,2,3", "nan,0", "1,x"] {
            assert!(place(bad).is_err(), "{bad}");
        }
    }
}
