//! Pictures of what camera rays find first: normals, depths, objects, materials, costs.

use crate::page_view::Show;
use eosphor::{CostMap, DevelopSettings, Developed, FeatureRows};

/// Draws what is shown instead of the picture.
pub(crate) fn draw(show: Show, features: &FeatureRows) -> Developed {
    let of = |color: &dyn Fn(usize) -> [u8; 3]| {
        let rgb = (0..features.pixels.len()).flat_map(color).collect();
        Developed { width: features.width, height: features.height, rgb, alpha: Vec::new() }
    };
    match show {
        // The colours of costs are those of `eosphor render --show cost`.
        Show::Picture | Show::Cost => {
            let map = CostMap::new(&features.work, features.width, None);
            Developed::new(&map.film, &DevelopSettings::default())
        }
        Show::Normals => of(&|k| {
            let n = features.pixels[k].normal;
            [n.x, n.y, n.z].map(|x| byte(f64::from(x) * 0.5 + 0.5))
        }),
        Show::Depth => {
            let depths = features.pixels.iter().map(|pixel| pixel.depth).filter(|depth| depth.is_finite());
            let (near, far) = depths.fold((f32::INFINITY, 0.0f32), |(a, b), d| (a.min(d), b.max(d)));
            let range = f64::from(far - near).max(f64::MIN_POSITIVE);
            of(&|k| {
                let depth = features.pixels[k].depth;
                // What is farthest can still be told from nothing.
                [byte(match depth.is_finite() {
                    true => 1.0 - 0.9 * f64::from(depth - near) / range,
                    false => 0.0,
                }); 3]
            })
        }
        Show::Objects => of(&|k| color_of(features.pixels[k].object)),
        Show::Materials => of(&|k| color_of(features.pixels[k].material)),
    }
}

fn byte(share: f64) -> u8 {
    (share.clamp(0.0, 1.0) * 255.0).round() as u8
}

/// A colour for a number: neighbours have hues far apart, by the golden ratio. What hits nothing is black.
fn color_of(number: u32) -> [u8; 3] {
    if number == u32::MAX {
        return [0; 3];
    }
    let turns = f64::from(number) * 0.618_033_988_749_895;
    let hue = 6.0 * (turns - turns.floor());
    // Three strengths, so that more of them differ.
    let strength = [1.0, 0.75, 0.55][number as usize % 3];
    let channel = |offset: f64| {
        let place = (hue + offset).rem_euclid(6.0);
        byte(strength * (0.15 + 0.85 * ((place - 3.0).abs() - 1.0).clamp(0.0, 1.0)))
    };
    [channel(0.0), channel(4.0), channel(2.0)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use eosphor::math::vec3;
    use eosphor::{CameraWork, PixelFeatures};

    #[test]
    fn known_colors() {
        let mut features = FeatureRows::new(3, 1);
        let hit = |z, depth| PixelFeatures {
            normal: vec3(0.0, 0.0, z),
            depth,
            object: 0,
            ..PixelFeatures::NOTHING
        };
        (features.pixels[1], features.pixels[2]) = (hit(1.0, 2.0), hit(-1.0, 4.0));
        let rgb = |show| draw(show, &features).rgb;
        assert_eq!(rgb(Show::Normals), [128, 128, 128, 128, 128, 255, 128, 128, 0]);
        assert_eq!(rgb(Show::Depth), [0, 0, 0, 255, 255, 255, 25, 25, 25]);
        assert_eq!(rgb(Show::Objects)[..6], [0, 0, 0, 255, 38, 38]);
        assert_eq!(rgb(Show::Materials), [0; 9]);
        features.work[1] = CameraWork { nodes: 4, tests: 4 };
        let cost = draw(Show::Cost, &features).rgb;
        assert!(cost[3] > 200 && cost[..3] == cost[6..] && cost[0] < 5);
    }

    #[test]
    fn many_numbers_have_colors_of_their_own() {
        let mut colors: Vec<[u8; 3]> = (0..200).map(color_of).collect();
        colors.sort_unstable();
        colors.dedup();
        assert!(colors.len() > 195, "{}", colors.len());
    }
}
