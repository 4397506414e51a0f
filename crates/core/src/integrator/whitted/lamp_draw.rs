//! Lamps of which some are chosen by chance, where there are too many to sample all of them: those that the tree of lights promises
//! the most of.

use super::receiver::Receiver;
use crate::light::{ChosenLight, LightReceiver, TopWays, TreeTop};
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
    let chosen = view.light_tree().choose(&as_of_light(receiver), choice(view, receiver, draw))?;
    Some(drawn_lamp(view, receiver, draw, &chosen))
}

/// Chooses as [`draw_lamp`] does, for several points at a time, in lanes that are wanted; in others maybe, too.
/// [`drawn_lamp`] makes a lamp of what is chosen.
#[inline(always)]
pub fn choose_lamps<const W: usize>(
    view: &SceneView,
    is_wanted: &[bool; W],
    receiver: impl Fn(usize) -> Receiver,
    draw: u32,
) -> [Option<ChosenLight>; W] {
    let u = choices(view, &receiver, draw);
    view.light_tree().choose_lanes(is_wanted, |lane| as_of_light(&receiver(lane)), &u)
}

/// The ways of a point through the first levels of the tree of lights.
#[inline(always)]
pub fn ways_to_lamps(top: &TreeTop, receiver: &Receiver) -> TopWays {
    top.ways(&as_of_light(receiver))
}

/// As [`choose_lamps`], with the ways of each lane.
#[inline(always)]
pub fn choose_lamps_from<const W: usize>(
    view: &SceneView,
    (top, ways): (&TreeTop, &[TopWays; W]),
    is_wanted: &[bool; W],
    receiver: impl Fn(usize) -> Receiver,
    draw: u32,
) -> [Option<ChosenLight>; W] {
    let u = choices(view, &receiver, draw);
    let tree = view.light_tree();
    tree.choose_lanes_from(top, ways, is_wanted, |lane| as_of_light(&receiver(lane)), &u)
}

#[inline(always)]
fn choices<const W: usize>(view: &SceneView, receiver: &impl Fn(usize) -> Receiver, draw: u32) -> [f64; W] {
    let mut u = [0.0; W];
    for lane in 0..W {
        u[lane] = choice(view, &receiver(lane), draw);
    }
    u
}

/// The number of a draw among all draws of a point.
#[inline(always)]
fn draw_number(view: &SceneView, receiver: &Receiver, draw: u32) -> u32 {
    receiver.first.wrapping_mul(view.settings.lamp_samples).wrapping_add(draw)
}

/// The number that chooses a lamp, in [0, 1).
#[inline(always)]
fn choice(view: &SceneView, receiver: &Receiver, draw: u32) -> f64 {
    let first = draw_number(view, receiver, draw);
    let [u, _] = point_2d(first, hash_pair(receiver.key, CHOICE));
    with_digits(u, hash_pair(hash_pair(receiver.key, DIGITS), first))
}

/// What the tree knows of a receiver.
#[inline(always)]
fn as_of_light(receiver: &Receiver) -> LightReceiver {
    // Rays of a lobe do not know, where they arrive, which normal they left.
    let normal = if receiver.lobe.is_there() { Vec3::ZERO } else { receiver.normal };
    LightReceiver { position: receiver.origin, normal }
}

/// The number of a lamp that was chosen, and what receives its light.
#[inline(always)]
pub fn drawn_lamp(view: &SceneView, receiver: &Receiver, draw: u32, chosen: &ChosenLight) -> (u32, Receiver) {
    let scale = 1.0 / (chosen.chance * view.settings.lamp_samples as f32);
    (chosen.number, Receiver { first: draw_number(view, receiver, draw), scale, ..*receiver })
}
