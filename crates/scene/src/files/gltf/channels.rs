//! Which channels of which animation are played.

use super::document::{Animation, Channel, Document, Property};
use super::{Part, named, quoted};
use crate::files::warnings::Warnings;
use std::collections::HashMap;
use std::path::Path;

/// Parts of a node's transform that a channel can animate, the first applied last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Target {
    Translation,
    Rotation,
    Scale,
    /// Not of its transform: the weights of its mesh's morph targets.
    Weights,
}

impl Target {
    /// Those of its transform.
    pub(super) const OF_TRANSFORM: [Target; 3] = [Target::Translation, Target::Rotation, Target::Scale];
}

/// The animation that is played.
pub(super) struct Played<'a> {
    pub(super) number: usize,
    pub(super) animation: &'a Animation,
    /// Samplers by node and target.
    pub(super) samplers: HashMap<(usize, Target), usize>,
}

impl Played<'_> {
    /// For messages.
    pub(super) fn name(&self) -> Part {
        name(self.number, self.animation)
    }

    /// What is wrong with a sampler.
    pub(super) fn of_sampler(&self, number: usize, problem: &str) -> String {
        format!("{}, {}: {problem}", self.name(), Part::new("sampler", number, None))
    }
}

fn name(number: usize, animation: &Animation) -> Part {
    Part::new("animation", number, animation.name.as_deref())
}

/// The first animation, if there is one. What of it is left out, and which others there are, is warned of.
pub(super) fn played<'a>(
    warnings: &mut Warnings,
    path: &Path,
    root: &'a Document,
) -> Result<Option<Played<'a>>, String> {
    let Some(animation) = root.animations.first() else { return Ok(None) };
    if root.animations.len() > 1 {
        let message =
            format!("there are {} animations: {}; the first is played", root.animations.len(), list(root));
        warnings.add(path, None, message);
    }
    let mut played = Played { number: 0, animation, samplers: HashMap::new() };
    let mut left_out = 0;
    for (i, channel) in animation.channels.iter().enumerate() {
        let target = target(root, channel).map_err(|e| format!("{}, channel {i}: {e}", played.name()))?;
        let Some(target) = target else {
            left_out += 1;
            continue;
        };
        let sampler = channel.sampler.value();
        named(&animation.samplers, sampler, "sampler")
            .map_err(|e| format!("{}, channel {i}: {e}; mend the file", played.name()))?;
        played.samplers.insert(target, sampler);
    }
    if left_out > 0 {
        let channels = if left_out == 1 { "1 channel is" } else { &format!("{left_out} channels are") };
        let message = format!(
            "{}: {channels} left out: only translation, rotation and scale of nodes that have no matrix are animated, and \
             weights of morph targets",
            played.name()
        );
        warnings.add(path, None, message);
    }
    Ok(Some(played))
}

/// What a channel animates; `None` where that is left out.
fn target(root: &Document, channel: &Channel) -> Result<Option<(usize, Target)>, String> {
    let target = match channel.target.path {
        Some(Property::Translation) => Target::Translation,
        Some(Property::Rotation) => Target::Rotation,
        Some(Property::Scale) => Target::Scale,
        Some(Property::Weights) => Target::Weights,
        None => return Ok(None),
    };
    // Without a node, an extension says what is animated.
    let Some(number) = channel.target.node else { return Ok(None) };
    let number = number.value();
    let node = named(&root.nodes, number, "node").map_err(|e| format!("{e}; mend the file"))?;
    let is_there = match target {
        Target::Weights => {
            let mesh = node.mesh.and_then(|mesh| root.meshes.get(mesh.value()));
            mesh.is_some_and(|mesh| mesh.target_count() > 0)
        }
        _ => node.matrix.is_none(),
    };
    Ok(is_there.then_some((number, target)))
}

/// The first ones, by number and name.
fn list(root: &Document) -> String {
    const LISTED: usize = 20;
    let entry = |(number, animation): (usize, &Animation)| match &animation.name {
        Some(name) => format!("{number} {}", quoted(name)),
        None => number.to_string(),
    };
    let more = if root.animations.len() > LISTED { ", ..." } else { "" };
    root.animations.iter().enumerate().take(LISTED).map(entry).collect::<Vec<_>>().join(", ") + more
}
