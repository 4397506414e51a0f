//! Lamps of which some are chosen by chance, where there are too many to sample all of them: those that the tree of lights promises
//! the most of.

use super::receiver::Receiver;
use crate::light::LightReceiver;
use crate::math::Vec3;
use crate::sampling::{hash_pair, point_2d, with_digits};
use crate::view::SceneView;

/// Keys of the number by which a lamp is chosen, and of its further digits.
const CHOICE: u32 = 0x1;
const DIGITS: u32 = 0x2;

/// Whether lamps are drawn; else all of them are sampled.
#[inline(always)]
pub fn are_lamps_drawn(view: &SceneView) -> bool {
    !view.light_nodes.is_empty()
}

/// How many lights are sampled each at every point: all, or those that are no lamps, which come first.
#[inline(always)]
pub fn lights_alone(view: &SceneView) -> u32 {
    if !are_lamps_drawn(view) {
        return view.lights.len() as u32;
    }
    let mut alone = 0;
    while (alone as usize) < view.lights.len() && !view.lights[alone as usize].is_lamp() {
        alone += 1;
    }
    alone
}

/// Number `draw` of the lamps that are drawn for a side of a point; `None` where nothing reaches it. `receiver` has the key of all
/// draws, and its `first` is the sample of the pixel. What comes back is for the lamp, whose number it has.
#[inline(always)]
pub fn draw_lamp(view: &SceneView, receiver: &Receiver, draw: u32) -> Option<(u32, Receiver)> {
    let draws = view.settings.lamp_samples;
    let first = receiver.first.wrapping_mul(draws).wrapping_add(draw);
    let [u, _] = point_2d(first, hash_pair(receiver.key, CHOICE));
    let u = with_digits(u, hash_pair(hash_pair(receiver.key, DIGITS), first));
    // Rays of a lobe do not know, where they arrive, which normal they left.
    let normal = if receiver.lobe.is_there() { Vec3::ZERO } else { receiver.normal };
    let chosen = view.light_tree().choose(&LightReceiver { position: receiver.origin, normal }, u)?;
    let scale = 1.0 / (chosen.chance * draws as f32);
    Some((chosen.number, Receiver { first, scale, ..*receiver }))
}
