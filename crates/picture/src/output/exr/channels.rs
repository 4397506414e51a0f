//! The channels of a file, and what each takes from a pixel.

use crate::output::alpha::coverage;
use eosphor_core::integrator::PixelFeatures;
use eosphor_core::math::Vec3;
use eosphor_render::CameraWork;
use exr::meta::attribute::SampleType;
use exr::prelude::f16;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Layers that an EXR file can have besides the colours: what the camera rays of a pixel find first
/// ([`PixelFeatures`]), and the work on them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Layer {
    /// `albedo.R`, `.G`, `.B`: diffuse colour, linear, mean over the samples.
    Albedo,
    /// `normal.X`, `.Y`, `.Z`: shading normal in world space, towards the viewer, mean over the samples.
    Normal,
    /// `depth.Z`: mean distance along the ray over the samples that hit, in world units; infinite where none does.
    /// Always 32-bit.
    Depth,
    /// `object.ID`: number of the instance that the first sample hits; 4294967295 where it hits nothing.
    Object,
    /// `material.ID`: number of the material that the first sample hits; 4294967295 where it hits nothing.
    Material,
    /// `cost.nodes`, `cost.tests`: nodes visited and primitives tested by the camera rays. They depend on the hierarchy.
    Cost,
}

impl Layer {
    /// All, in their usual order.
    pub const ALL: [Layer; 6] =
        [Layer::Albedo, Layer::Normal, Layer::Depth, Layer::Object, Layer::Material, Layer::Cost];

    fn channels(self) -> &'static [(&'static str, Source)] {
        match self {
            Layer::Albedo => &[
                ("albedo.R", Source::Albedo(|c| c.x)),
                ("albedo.G", Source::Albedo(|c| c.y)),
                ("albedo.B", Source::Albedo(|c| c.z)),
            ],
            Layer::Normal => &[
                ("normal.X", Source::Normal(|n| n.x)),
                ("normal.Y", Source::Normal(|n| n.y)),
                ("normal.Z", Source::Normal(|n| n.z)),
            ],
            Layer::Depth => &[("depth.Z", Source::Depth)],
            Layer::Object => &[("object.ID", Source::Object)],
            Layer::Material => &[("material.ID", Source::Material)],
            Layer::Cost => &[("cost.nodes", Source::Nodes), ("cost.tests", Source::Tests)],
        }
    }
}

impl fmt::Display for Layer {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Layer::Albedo => "albedo",
            Layer::Normal => "normal",
            Layer::Depth => "depth",
            Layer::Object => "object",
            Layer::Material => "material",
            Layer::Cost => "cost",
        })
    }
}

impl FromStr for Layer {
    type Err = String;
    fn from_str(s: &str) -> Result<Layer, String> {
        Layer::ALL.into_iter().find(|layer| layer.to_string() == s).ok_or_else(|| {
            let names: Vec<String> = Layer::ALL.iter().map(Layer::to_string).collect();
            format!("unknown layer '{s}': choose of {}", names.join(", "))
        })
    }
}

/// A component of a vector.
type Component = fn(&Vec3) -> f32;

/// Where the values of a channel come from.
#[derive(Clone, Copy)]
enum Source {
    Color(Component),
    Alpha,
    Albedo(Component),
    Normal(Component),
    Depth,
    Object,
    Material,
    Nodes,
    Tests,
}

/// A row of pixels, with features where the file has layers.
pub(super) struct Row<'a> {
    pub(super) colors: &'a [Vec3],
    pub(super) features: &'a [PixelFeatures],
    pub(super) work: &'a [CameraWork],
}

/// A channel of a file.
pub(in crate::output) struct Channel {
    pub(super) name: &'static str,
    pub(super) samples: SampleType,
    source: Source,
}

impl Channel {
    /// The colours, alpha where it is wanted, and these layers, in the order that the format asks for: by name. With `half`, all
    /// but distances and numbers have 16 bits.
    pub(in crate::output) fn all(layers: &[Layer], alpha: bool, half: bool) -> Vec<Channel> {
        let colors =
            [("R", Source::Color(|c| c.x)), ("G", Source::Color(|c| c.y)), ("B", Source::Color(|c| c.z))];
        let alpha = alpha.then_some(("A", Source::Alpha));
        let layers = layers.iter().flat_map(|layer| layer.channels().iter().copied());
        let channel = |(name, source)| {
            let samples = match source {
                Source::Color(_) | Source::Alpha | Source::Albedo(_) | Source::Normal(_) if half => {
                    SampleType::F16
                }
                Source::Color(_) | Source::Alpha | Source::Albedo(_) | Source::Normal(_) | Source::Depth => {
                    SampleType::F32
                }
                Source::Object | Source::Material | Source::Nodes | Source::Tests => SampleType::U32,
            };
            Channel { name, samples, source }
        };
        let mut channels: Vec<Channel> = colors.into_iter().chain(alpha).chain(layers).map(channel).collect();
        channels.sort_by_key(|channel| channel.name);
        channels.dedup_by_key(|channel| channel.name);
        channels
    }

    /// Whether it is of a layer or alpha, and not of the colours.
    pub(super) fn is_of_features(&self) -> bool {
        !matches!(self.source, Source::Color(_))
    }

    /// Appends the values of a row.
    pub(super) fn append(&self, row: &Row, bytes: &mut Vec<u8>) {
        let float = |x: f32, bytes: &mut Vec<u8>| match self.samples {
            SampleType::F16 => bytes.extend_from_slice(&half(x).to_ne_bytes()),
            _ => bytes.extend_from_slice(&x.to_ne_bytes()),
        };
        let mut number = |x: u32| bytes.extend_from_slice(&x.to_ne_bytes());
        match self.source {
            Source::Object => row.features.iter().for_each(|pixel| number(pixel.object)),
            Source::Material => row.features.iter().for_each(|pixel| number(pixel.material)),
            Source::Nodes => row.work.iter().for_each(|work| number(work.nodes)),
            Source::Tests => row.work.iter().for_each(|work| number(work.tests)),
            Source::Color(component) => row.colors.iter().for_each(|c| float(component(c), bytes)),
            Source::Alpha => row.features.iter().for_each(|pixel| float(coverage(pixel), bytes)),
            Source::Albedo(component) => {
                row.features.iter().for_each(|pixel| float(component(&pixel.albedo), bytes))
            }
            Source::Normal(component) => {
                row.features.iter().for_each(|pixel| float(component(&pixel.normal), bytes))
            }
            Source::Depth => row.features.iter().for_each(|pixel| float(pixel.depth, bytes)),
        }
    }
}

/// Rounded to the nearest, ties to even, by integer arithmetic: the same on every machine. What is too large becomes the
/// largest number, 65,504, and not infinity, with which no program can go on.
fn half(x: f32) -> f16 {
    let limit = f32::from(f16::MAX);
    f16::from_f32_const(if x.is_finite() { x.clamp(-limit, limit) } else { x })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_the_nearest() {
        let bits = |x| half(x).to_bits();
        assert_eq!([bits(1.0), bits(-2.0), bits(0.0)], [0x3c00, 0xc000, 0]);
        // Between 1 and the next number, 1 + 2^-10: below, at and above the middle; then a tie that goes up to even.
        let middle = 1.0 + 2f32.powi(-11);
        assert_eq!([bits(middle - 1e-6), bits(middle), bits(middle + 1e-6)], [0x3c00, 0x3c00, 0x3c01]);
        assert_eq!(bits(1.0 + 3.0 * 2f32.powi(-11)), 0x3c02);
        assert_eq!(bits(2f32.powi(-24)), 1, "subnormal");
        assert_eq!([bits(65_519.0), bits(65_520.0), bits(1e30)], [0x7bff; 3]);
        assert_eq!([bits(f32::INFINITY), bits(f32::NEG_INFINITY)], [0x7c00, 0xfc00]);
        assert!(half(f32::NAN).is_nan());
    }

    #[test]
    fn channels_are_sorted_and_single() {
        let names = |layers| Channel::all(layers, false, false).iter().map(|c| c.name).collect::<Vec<_>>();
        assert_eq!(names(&[]), ["B", "G", "R"]);
        assert_eq!(
            names(&[Layer::Depth, Layer::Cost, Layer::Depth]),
            ["B", "G", "R", "cost.nodes", "cost.tests", "depth.Z"]
        );
        for layer in Layer::ALL {
            assert_eq!(layer.to_string().parse(), Ok(layer));
        }
    }
}
