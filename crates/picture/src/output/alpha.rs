//! Pictures without their background: the colours of what is before it, and how much of each pixel that covers.

use super::{DevelopSettings, Developed};
use eosphor_core::integrator::PixelFeatures;
use eosphor_core::math::Vec3;
use eosphor_render::{FeatureRows, Film};

/// How much of a pixel is covered: 0 where it shows the background alone, 1 where it shows none of it past surfaces. What is
/// seen of it in mirrors and through glass covers.
pub(super) fn coverage(features: &PixelFeatures) -> f32 {
    1.0 - features.background.max_component()
}

/// Colours of what is before a background of this radiance, times their coverage, as EXR wants them.
pub(super) fn premultiplied(film: &Film, features: &FeatureRows, background: Vec3) -> Film {
    let pixels = film.pixels.iter().zip(&features.pixels).map(|(&color, features)| {
        if coverage(features) <= 0.0 {
            return Vec3::ZERO;
        }
        let (color, radiance) = (<[f32; 3]>::from(color), <[f32; 3]>::from(background));
        let seen = <[f32; 3]>::from(features.background);
        // (What rounding leaves of a background may be below 0.)
        let own =
            |k: usize| (f64::from(color[k]) - f64::from(radiance[k]) * f64::from(seen[k])).max(0.0) as f32;
        [own(0), own(1), own(2)].into()
    });
    Film { width: film.width, height: film.height, pixels: pixels.collect() }
}

/// Bytes with an alpha channel, of colours that are not multiplied by their coverage, as PNG wants them.
pub(super) fn developed(
    film: &Film,
    features: &FeatureRows,
    background: Vec3,
    settings: &DevelopSettings,
) -> Developed {
    let mut film = premultiplied(film, features, background);
    for (color, features) in film.pixels.iter_mut().zip(&features.pixels) {
        let coverage = coverage(features);
        if coverage > 0.0 {
            *color = <[f32; 3]>::from(*color).map(|x| x / coverage).into();
        }
    }
    let alpha = features.pixels.iter().map(|features| (coverage(features) * 255.0 + 0.5) as u8).collect();
    Developed { alpha, ..Developed::new(&film, settings) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eosphor_core::develop::Transfer;
    use eosphor_core::math::vec3;

    /// Three pixels: background, an edge that covers a quarter, what hides it.
    fn rows(background: Vec3) -> (Film, FeatureRows) {
        let (own, mut features) = (vec3(0.5, 0.25, 1.0), FeatureRows::new(3, 1));
        features.pixels[1].background = Vec3::splat(0.75);
        features.pixels[2].background = Vec3::ZERO;
        let pixels = vec![background, background * 0.75 + own * 0.25, own];
        (Film { width: 3, height: 1, pixels }, features)
    }

    #[test]
    fn the_background_is_taken_out() {
        let background = vec3(0.25, 0.5, 0.0);
        let (film, features) = rows(background);
        let own = premultiplied(&film, &features, background).pixels;
        assert_eq!(own, [Vec3::ZERO, vec3(0.125, 0.0625, 0.25), vec3(0.5, 0.25, 1.0)]);
        assert_eq!(features.pixels.iter().map(coverage).collect::<Vec<f32>>(), [0.0, 0.25, 1.0]);
        let settings = DevelopSettings { transfer: Transfer::Linear, ..DevelopSettings::default() };
        let bytes = developed(&film, &features, background, &settings);
        assert_eq!(bytes.rgb, [0, 0, 0, 128, 64, 255, 128, 64, 255]);
        assert_eq!(bytes.alpha, [0, 64, 255]);
    }

    /// What the sum has lost by rounding is not below 0.
    #[test]
    fn no_light_is_below_zero() {
        let (mut film, features) = rows(Vec3::splat(0.1));
        film.pixels[1] = Vec3::splat(0.074_999_99);
        let own = premultiplied(&film, &features, Vec3::splat(0.1)).pixels[1];
        assert!(own == Vec3::ZERO && own.x.is_sign_positive(), "{own:?}");
    }
}
