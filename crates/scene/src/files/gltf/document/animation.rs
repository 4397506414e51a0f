//! Animations.

use super::Index;
use super::enumeration::{Enumeration, Terms, listed};
use serde::Deserialize;

/// An animation: channels, and the samplers that they play.
#[derive(Debug, Deserialize)]
pub struct Animation {
    pub name: Option<String>,
    pub channels: Vec<Channel>,
    pub samplers: Vec<AnimationSampler>,
}

/// A channel gives a sampler to a property of a node.
#[derive(Debug, Deserialize)]
pub struct Channel {
    /// Into the samplers of the animation.
    pub sampler: Index,
    pub target: ChannelTarget,
}

/// What a channel animates.
#[derive(Debug, Deserialize)]
pub struct ChannelTarget {
    /// Without a node, an extension says what is animated.
    pub node: Option<Index>,
    #[serde(deserialize_with = "listed")]
    pub path: Option<Property>,
}

/// Keys of an animation.
#[derive(Debug, Deserialize)]
pub struct AnimationSampler {
    /// The accessor of the times.
    pub input: Index,
    /// The accessor of the values.
    pub output: Index,
    #[serde(default = "Interpolation::linear", deserialize_with = "listed")]
    pub interpolation: Option<Interpolation>,
}

/// Values between two keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    Linear,
    Step,
    CubicSpline,
}

impl Interpolation {
    fn linear() -> Option<Interpolation> {
        Some(Interpolation::Linear)
    }
}

impl Enumeration for Interpolation {
    const TERMS: Terms<Interpolation> = Terms::Names(&[
        ("LINEAR", Interpolation::Linear),
        ("STEP", Interpolation::Step),
        ("CUBICSPLINE", Interpolation::CubicSpline),
    ]);
}

/// A property of a node that can be animated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Property {
    Translation,
    Rotation,
    Scale,
    /// The weights of morph targets.
    Weights,
}

impl Enumeration for Property {
    const TERMS: Terms<Property> = Terms::Names(&[
        ("translation", Property::Translation),
        ("rotation", Property::Rotation),
        ("scale", Property::Scale),
        ("weights", Property::Weights),
    ]);
}
