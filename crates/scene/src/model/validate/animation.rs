//! What moves: frames, keys and laws.

use super::{Check, MAX_COORDINATE, color, in_range, index, number, point};
use crate::error::Problem;
use crate::model::{Animation, CameraMotion, Law, LightMotion, MAX_FRAMES, Move, MoveKey, Scene};
use eosphor_core::math::Vec3;

pub(super) fn check(animation: &Animation, lights: usize) -> Check {
    in_range("animation.frames".to_string(), animation.frames, 1, MAX_FRAMES)?;
    if !(animation.fps > 0.0 && animation.fps <= 1000.0) {
        let message = format!("{} must be over 0 and at most 1000", animation.fps);
        return Err(Problem::new("animation.fps", message));
    }
    for (i, motion) in animation.lights.iter().enumerate() {
        check_light_motion(motion, &format!("animation.lights[{i}]"), lights)?;
    }
    match &animation.camera {
        None => Ok(()),
        Some(CameraMotion::Orbit { turns, around }) => {
            let what = || "animation.camera.orbit".to_string();
            number("animation.camera.orbit.turns", *turns, -1e6, 1e6)?;
            point(what, "around", around.unwrap_or(Vec3::ZERO))
        }
        Some(CameraMotion::Laws { position, look_at }) => {
            check_law("animation.camera.laws.position", position)?;
            check_law("animation.camera.laws.look-at", look_at)
        }
        Some(CameraMotion::Keys { keys, .. }) => {
            if keys.is_empty() {
                return Err(Problem::new("animation.camera.keys.keys", "there must be at least one"));
            }
            for (i, key) in keys.iter().enumerate() {
                let what = || format!("animation.camera.keys.keys[{i}]");
                number(&format!("{}.seconds", what()), key.seconds, 0.0, 1e9)?;
                point(what, "position", key.position)?;
                point(what, "look-at", key.look_at)?;
            }
            check_order(keys.iter().map(|key| key.seconds), "animation.camera.keys.keys")
        }
        Some(CameraMotion::Moves(moves)) => check_moves("animation.camera", moves),
    }
}

impl Scene {
    /// Whether there is the frame that a single picture shows.
    pub(super) fn check_frame(&self) -> Check {
        match &self.animation {
            Some(animation) => in_range("frame".to_string(), self.frame, 0, animation.frames - 1),
            None if self.frame == 0 => Ok(()),
            None => {
                let message =
                    format!("there is no frame {}: nothing moves, so there is no animation", self.frame);
                Err(Problem::new("frame", message))
            }
        }
    }
}

/// Times must grow.
fn check_order(seconds: impl Iterator<Item = f32>, keys: &str) -> Check {
    let mut before = f32::NEG_INFINITY;
    for (i, seconds) in seconds.enumerate() {
        if seconds <= before {
            let message = "keys must be in the order of their seconds, each later than the one before";
            return Err(Problem::new(format!("{keys}[{i}].seconds"), message));
        }
        before = seconds;
    }
    Ok(())
}

fn check_light_motion(motion: &LightMotion, name: &str, lights: usize) -> Check {
    index(|| name.to_string(), "light", motion.light, lights)?;
    if motion.keys.is_empty() && motion.moves.is_empty() {
        return Err(Problem::new(format!("{name}.keys"), "there must be at least one, or one of \"moves\""));
    }
    check_moves(name, &motion.moves)?;
    for (i, key) in motion.keys.iter().enumerate() {
        let what = || format!("{name}.keys[{i}]");
        number(&format!("{}.seconds", what()), key.seconds, 0.0, 1e9)?;
        // Curves swing beyond their keys.
        let [position, shade] = [key.position, key.color].map(|v| v.unwrap_or(Vec3::ZERO) * 10.0);
        point(what, "position", position)?;
        color(&format!("{}.color", what()), shade)?;
        if let Some(direction) = key.direction
            && direction.normalize_or(Vec3::ZERO) == Vec3::ZERO
        {
            return Err(Problem::new(format!("{}.direction", what()), "it has no length"));
        }
    }
    check_order(motion.keys.iter().map(|key| key.seconds), &format!("{name}.keys"))
}

fn check_law(name: &str, law: &Law) -> Check {
    let Law {
        r,
        z,
        phi,
        r_amplitude,
        z_amplitude,
        r_frequency,
        z_frequency,
        phi_frequency,
        r_phase,
        z_phase,
    } = *law;
    for (key, length) in [("r", r), ("z", z), ("r-amplitude", r_amplitude), ("z-amplitude", z_amplitude)] {
        number(&format!("{name}.{key}"), length, -0.1 * MAX_COORDINATE, 0.1 * MAX_COORDINATE)?;
    }
    let angles = [("phi", phi), ("r-phase", r_phase), ("z-phase", z_phase)];
    let frequencies =
        [("r-frequency", r_frequency), ("z-frequency", z_frequency), ("phi-frequency", phi_frequency)];
    angles
        .into_iter()
        .chain(frequencies)
        .try_for_each(|(key, angle)| number(&format!("{name}.{key}"), angle, -1e6, 1e6))
}

/// The motions of what has this name.
pub(super) fn check_moves<'a>(name: &str, moves: impl IntoIterator<Item = &'a Move>) -> Check {
    for (i, motion) in moves.into_iter().enumerate() {
        let name = || format!("{name}.moves[{i}]");
        for (k, key) in motion.keys.iter().enumerate() {
            check_move_key(key, &|| format!("{}.keys[{k}]", name()))?;
        }
        check_order(motion.keys.iter().map(|key| key.seconds), &format!("{}.keys", name()))?;
        point(name, "around", motion.around)?;
        let last = motion.transform.affine();
        if !last.is_finite() || last.inverse().is_none() {
            let message = "it squashes things flat or is not finite; no scale may be 0";
            return Err(Problem::new(format!("{}.transform", name()), message));
        }
    }
    Ok(())
}

fn check_move_key(key: &MoveKey, name: &dyn Fn() -> String) -> Check {
    number(&format!("{}.seconds", name()), key.seconds, 0.0, 1e9)?;
    // Curves swing beyond their keys.
    point(name, "translate", key.translate.unwrap_or(Vec3::ZERO) * 10.0)?;
    point(name, "scale", key.scale.unwrap_or(Vec3::ONE) * 10.0)?;
    for degrees in <[f32; 3]>::from(key.rotate_degrees.unwrap_or(Vec3::ZERO)) {
        number(&format!("{}.rotate-degrees", name()), degrees, -1e6, 1e6)?;
    }
    let rotation = key.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let square: f64 = rotation.iter().map(|&part| f64::from(part) * f64::from(part)).sum();
    // Of denormal numbers, squares are 0.
    if !(square > 0.0 && square.is_finite()) {
        let message = "it has no length, and so says no rotation; none is [0, 0, 0, 1]";
        return Err(Problem::new(format!("{}.rotation", name()), message));
    }
    Ok(())
}
