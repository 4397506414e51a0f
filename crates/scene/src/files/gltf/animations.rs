//! Samplers of animations: keys of the model.

use super::accessors::{Accessors, Budget};
use super::channels::{Played, Target};
use super::document::{self, AnimationSampler};
use super::weights;
use crate::model::{Interpolation, Move, MoveKey, WeightTrack};
use eosphor_core::math::{Vec3, sqrt64};
use std::collections::HashMap;
use std::sync::Arc;

/// The latest time of a key, in seconds.
const MAX_SECONDS: f32 = 1e9;

/// What a key takes of the memory, in elements of accessors.
const ELEMENTS_A_KEY: u64 = 4;

/// Straight parts that a curve between two keys becomes.
const PARTS: u32 = 32;

/// A value and its time.
type Key<const N: usize> = (f32, [f32; N]);

/// The motions of the animation that is played, each made when it is needed, and once.
pub(super) struct Animations<'a> {
    accessors: &'a Accessors<'a>,
    played: Option<Played<'a>>,
    made: HashMap<(usize, Target), Arc<Move>>,
    /// By sampler and number of morph targets.
    tracks: HashMap<(usize, usize), Arc<WeightTrack>>,
}

impl<'a> Animations<'a> {
    pub(super) fn new(accessors: &'a Accessors<'a>, played: Option<Played<'a>>) -> Animations<'a> {
        Animations { accessors, played, made: HashMap::new(), tracks: HashMap::new() }
    }

    /// How a part of a node's transform moves; `None` where it stays.
    pub(super) fn motion(&mut self, node: usize, target: Target) -> Result<Option<Arc<Move>>, String> {
        let Some(played) = &self.played else { return Ok(None) };
        let Some(&number) = played.samplers.get(&(node, target)) else { return Ok(None) };
        if let Some(motion) = self.made.get(&(number, target)) {
            return Ok(Some(Arc::clone(motion)));
        }
        let sampler = &played.animation.samplers[number];
        let motion = made(self.accessors, sampler, target).map_err(|e| played.of_sampler(number, &e))?;
        let motion = motion.map(Arc::new);
        if let Some(motion) = &motion {
            self.made.insert((number, target), Arc::clone(motion));
        }
        Ok(motion)
    }

    /// The number of the sampler that moves the weights of a node's morph targets.
    pub(super) fn weights_sampler(&self, node: usize) -> Option<usize> {
        self.played.as_ref()?.samplers.get(&(node, Target::Weights)).copied()
    }

    /// The weights that a sampler gives so many morph targets.
    pub(super) fn weights(
        &mut self,
        number: usize,
        targets: usize,
    ) -> Result<Option<Arc<WeightTrack>>, String> {
        let Some(played) = &self.played else { return Ok(None) };
        if let Some(track) = self.tracks.get(&(number, targets)) {
            return Ok(Some(Arc::clone(track)));
        }
        let track = weights::track(self.accessors, &played.animation.samplers[number], targets);
        let track = Arc::new(track.map_err(|e| played.of_sampler(number, &e))?);
        self.tracks.insert((number, targets), Arc::clone(&track));
        Ok(Some(track))
    }
}

/// Motions that are no longer shared: cameras and lights have their own.
pub(super) fn own(moves: &[Arc<Move>], budget: &Budget) -> Result<Vec<Move>, String> {
    for motion in moves {
        budget.spend(ELEMENTS_A_KEY * (1 + motion.keys.len() as u64))?;
    }
    Ok(moves.iter().map(|motion| Move::clone(motion)).collect())
}

/// The motion of a part of a transform; `None` where the target is none.
fn made(
    accessors: &Accessors<'_>,
    sampler: &AnimationSampler,
    target: Target,
) -> Result<Option<Move>, String> {
    let Some(kind) = sampler.interpolation else {
        return Err("its interpolation is unknown; it must be LINEAR, STEP or CUBICSPLINE".into());
    };
    let interpolation = match kind {
        document::Interpolation::Step => Interpolation::Step,
        document::Interpolation::Linear | document::Interpolation::CubicSpline => Interpolation::Linear,
    };
    let key = |seconds| MoveKey { seconds, ..MoveKey::default() };
    let vector = |x: [f32; 3]| Some(Vec3::from(x));
    let keys = match target {
        Target::Translation => {
            let keys = read(accessors, sampler, kind)?.into_iter();
            keys.map(|(seconds, x)| MoveKey { translate: vector(x), ..key(seconds) }).collect()
        }
        Target::Rotation => {
            let keys = read::<4>(accessors, sampler, kind)?.into_iter();
            keys.map(|(seconds, q)| MoveKey { rotation: Some(q), ..key(seconds) }).collect()
        }
        Target::Scale => {
            let keys = read(accessors, sampler, kind)?.into_iter();
            keys.map(|(seconds, x)| MoveKey { scale: vector(x), ..key(seconds) }).collect()
        }
        Target::Weights => return Ok(None),
    };
    Ok(Some(Move { keys, interpolation, ..Move::default() }))
}

/// The keys of a sampler, at times that increase. Those of four components are rotations.
fn read<const N: usize>(
    accessors: &Accessors<'_>,
    sampler: &AnimationSampler,
    kind: document::Interpolation,
) -> Result<Vec<Key<N>>, String> {
    let is_curve = kind == document::Interpolation::CubicSpline;
    let times = accessors.read(sampler.input.value(), |[seconds]: [f32; 1]| seconds);
    let times = times.map_err(|e| format!("its times: {e}"))?;
    let values = accessors.read(sampler.output.value(), |value: [f32; N]| value);
    let values = values.map_err(|e| format!("its values: {e}"))?;
    check_times(&times)?;
    let each = if is_curve { 3 } else { 1 };
    if Some(values.len()) != times.len().checked_mul(each) {
        let (found, times) = (values.len(), times.len());
        let wanted = if is_curve { "three for each" } else { "one for each" };
        return Err(format!("there are {found} values for {times} times, not {wanted}; export it again"));
    }
    let groups: Vec<&[[f32; N]]> = values.chunks_exact(each).collect();
    for (i, group) in groups.iter().enumerate() {
        if group.iter().flatten().any(|x| !x.is_finite()) {
            return Err(format!("the values of key {i} are not finite; export it again"));
        }
        if N == 4 && group[each / 2].iter().all(|&x| x == 0.0) {
            return Err(format!("the rotation of key {i} has no length; export it again"));
        }
    }
    let kept = keys_of(&times).map(|i| (times[i], groups[i]));
    let count = kept.clone().count() as u64 * if is_curve { u64::from(PARTS) } else { 1 };
    accessors.budget.spend(count.saturating_mul(ELEMENTS_A_KEY))?;
    Ok(match is_curve {
        true => straightened(&kept.map(|(time, v)| (time, [v[0], v[1], v[2]])).collect::<Vec<_>>()),
        false => kept.map(|(time, value)| (time, value[0])).collect(),
    })
}

/// The numbers of the keys that count: of those at one time, the last.
pub(super) fn keys_of(times: &[f32]) -> impl Iterator<Item = usize> + Clone {
    (0..times.len()).filter(|&i| times.get(i + 1) != Some(&times[i]))
}

pub(super) fn check_times(times: &[f32]) -> Result<(), String> {
    if times.is_empty() {
        return Err("it has no keys; export it again".into());
    }
    if let Some((i, time)) = times.iter().enumerate().find(|(_, time)| !(0.0..=MAX_SECONDS).contains(*time)) {
        return Err(format!(
            "the time of key {i} is {time}; it must be 0 to {MAX_SECONDS:e} seconds; export it again"
        ));
    }
    match times.windows(2).position(|pair| pair[1] < pair[0]) {
        Some(i) => Err(format!(
            "its times must increase: {} is followed by {}; export it again",
            times[i],
            times[i + 1]
        )),
        None => Ok(()),
    }
}

/// A curve as straight parts. Keys are in-tangent, value and out-tangent (glTF 2.0, appendix C.5).
fn straightened<const N: usize>(curve: &[(f32, [[f32; N]; 3])]) -> Vec<Key<N>> {
    let mut keys: Vec<Key<N>> = curve.iter().take(1).map(|(time, [_, value, _])| (*time, *value)).collect();
    for pair in curve.windows(2) {
        let ((from, [_, v0, out]), (to, [into, v1, _])) = (pair[0], pair[1]);
        let span = f64::from(to) - f64::from(from);
        for part in 1..PARTS {
            let t = f64::from(part) / f64::from(PARTS);
            let seconds = (f64::from(from) + t * span) as f32;
            // Single precision may not tell the times of a short span apart.
            if keys.last().is_some_and(|last| seconds <= last.0) || seconds >= to {
                continue;
            }
            let (t2, t3) = (t * t, t * t * t);
            let value: [f64; N] = std::array::from_fn(|k| {
                let [v0, out, into, v1] = [v0[k], out[k], into[k], v1[k]].map(f64::from);
                (2.0 * t3 - 3.0 * t2 + 1.0) * v0
                    + span * (t3 - 2.0 * t2 + t) * out
                    + (3.0 * t2 - 2.0 * t3) * v1
                    + span * (t3 - t2) * into
            });
            if let Some(value) = on_the_way(value) {
                keys.push((seconds, value));
            }
        }
        keys.push((to, v1));
    }
    keys
}

/// A value of the curve; of four components, a rotation of length 1, if it has a length.
fn on_the_way<const N: usize>(value: [f64; N]) -> Option<[f32; N]> {
    if N != 4 {
        return Some(value.map(|x| x as f32));
    }
    let length = sqrt64(value.iter().map(|x| x * x).sum());
    (length > 1e-12 && length.is_finite()).then(|| value.map(|x| (x / length) as f32))
}
