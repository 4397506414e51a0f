//! Scale, rotation and translation by time.

use super::interpolation::Interpolation;
use super::matrix::{Matrix, about};
use super::schema_types::{Quaternion, Scale, Vector};
use super::transform::{Transform, add, double, one_or_three, single};
use eosphor_core::math::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

/// Scales are no smaller: an object of no size has no inverse to take rays into it. So small it is not seen.
const LEAST_SCALE: f64 = 1e-6;

const ONE: [f64; 3] = [1.0; 3];

/// A motion by keys: scale, then rotation, then translation, as an object's transform; then a transform that stays. It is
/// applied to what is already in its place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
#[schemars(extend("examples" = [{ "around": [1, 0, 0], "interpolation": "linear", "keys": [
    { "seconds": 0, "rotate-degrees": [0, 0, 0] }, { "seconds": 4, "rotate-degrees": [0, 360, 0] }
] }]))]
pub struct Move {
    /// Keys in order of time, in seconds. A part (scale, rotation, translation) that no key sets stays the identity.
    pub keys: Vec<MoveKey>,
    /// How it goes from one to the next.
    pub interpolation: Interpolation,
    /// The point that scale and rotation leave where it is.
    #[schemars(with = "Vector")]
    pub around: Vec3,
    /// Applied after the keys.
    pub transform: Transform,
}

impl Default for Move {
    fn default() -> Move {
        let (interpolation, transform) = (Interpolation::default(), Transform::default());
        Move { keys: Vec::new(), interpolation, around: Vec3::ZERO, transform }
    }
}

/// What a motion has come to at a time. A key need not set all parts; each goes by the keys that set it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(extend("examples" = [{ "seconds": 1.5, "translate": [0, 3, 0] }]))]
pub struct MoveKey {
    /// Seconds from the first frame.
    #[schemars(range(min = 0))]
    pub seconds: f32,
    /// Scale along the axes. Between keys it may pass 0, where an object is so small that it is not seen.
    #[serde(default, deserialize_with = "one_or_three_or_none")]
    #[schemars(with = "Option<Scale>")]
    pub scale: Option<Vec3>,
    /// Degrees about x, then y, then z. Each angle goes its own way: 0 to 720 is two turns.
    #[serde(default)]
    #[schemars(with = "Option<Vector>")]
    pub rotate_degrees: Option<Vec3>,
    /// A quaternion (x, y, z, w), of any length but 0. From one to the next it goes the shorter way around. After
    /// `rotate-degrees`.
    #[serde(default)]
    #[schemars(with = "Option<Quaternion>")]
    pub rotation: Option<[f32; 4]>,
    /// Moves the object.
    #[serde(default)]
    #[schemars(with = "Option<Vector>")]
    pub translate: Option<Vec3>,
}

impl Move {
    /// The map at a time.
    pub(crate) fn map(&self, seconds: f64) -> Matrix {
        let at = |of: fn(&MoveKey) -> Option<Vec3>| {
            let keys = self
                .keys
                .iter()
                .filter_map(|key| Some((f64::from(key.seconds), <[f32; 3]>::from(of(key)?).map(f64::from))));
            self.interpolation.at(keys, seconds)
        };
        let turns =
            self.keys.iter().filter_map(|key| Some((f64::from(key.seconds), key.rotation?.map(f64::from))));
        let turn = self.interpolation.rotation(turns, seconds).unwrap_or([0.0, 0.0, 0.0, 1.0]);
        let scale = at(|key| key.scale).unwrap_or(ONE);
        let scale = scale.map(|s| if s.abs() < LEAST_SCALE { LEAST_SCALE } else { s });
        let degrees = at(|key| key.rotate_degrees).unwrap_or([0.0; 3]);
        let around = <[f32; 3]>::from(self.around).map(f64::from);
        let still = [0.0, 0.0, 0.0, 1.0];

        let to_middle = Matrix::of_parts(around.map(|x| -x), still, ONE);
        let sized = Matrix::of_parts([0.0; 3], still, scale);
        let angled = (0..3).fold(sized, |before, axis| about(axis, degrees[axis]).after(&before));
        let turned = Matrix::of_parts(around, turn, ONE).after(&angled);
        let translate = at(|key| key.translate).unwrap_or([0.0; 3]);
        let moved = Matrix::of_parts(translate, still, ONE).after(&turned.after(&to_middle));
        match self.transform == Transform::default() {
            true => moved,
            false => self.transform.to_double().after(&moved),
        }
    }

    /// This motion of things whose coordinates have all grown by `by`.
    pub(crate) fn shifted(&self, by: [f64; 3]) -> Move {
        let around = add(double(self.around), by);
        let transform = self.transform.conjugated(by, &self.transform.to_double());
        Move { around: single(around), transform, ..self.clone() }
    }

    /// The motion, and then a step.
    pub(crate) fn then_moved(&self, by: [f64; 3]) -> Move {
        let mut motion = self.clone();
        motion.transform.offset = add(motion.transform.offset, by);
        motion
    }

    /// The map of motions that are applied one after the other.
    pub(crate) fn map_of_all<'a>(moves: impl IntoIterator<Item = &'a Move>, seconds: f64) -> Matrix {
        moves.into_iter().fold(Matrix::IDENTITY, |before, next| next.map(seconds).after(&before))
    }
}

fn one_or_three_or_none<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Vec3>, D::Error> {
    #[derive(Deserialize)]
    struct Factors(#[serde(deserialize_with = "one_or_three")] Vec3);
    Ok(Option::<Factors>::deserialize(deserializer)?.map(|Factors(scale)| scale))
}

#[cfg(test)]
mod tests {
    use super::*;
    use eosphor_core::math::vec3;

    fn key(seconds: f32) -> MoveKey {
        MoveKey { seconds, ..MoveKey::default() }
    }

    fn at(motion: &Move, seconds: f64, p: Vec3) -> Vec3 {
        motion.map(seconds).affine().point(p)
    }

    #[test]
    fn angles_go_round_and_round_about_the_point() {
        let turns =
            |seconds, degrees| MoveKey { rotate_degrees: Some(vec3(0.0, degrees, 0.0)), ..key(seconds) };
        let spin = Move {
            keys: vec![turns(0.0, 0.0), turns(8.0, 720.0)],
            interpolation: Interpolation::Linear,
            around: vec3(5.0, 0.0, 0.0),
            ..Move::default()
        };
        // A quarter a second about y takes z to x.
        let p = vec3(5.0, 1.0, 2.0);
        for (seconds, x, z) in [(0.0, 5.0, 2.0), (1.0, 7.0, 0.0), (2.0, 5.0, -2.0), (5.0, 7.0, 0.0)] {
            assert!((at(&spin, seconds, p) - vec3(x, 1.0, z)).length() < 1e-5, "{seconds}");
        }
    }

    #[test]
    fn scale_comes_before_rotation_before_translation_before_the_transform() {
        let half = std::f32::consts::FRAC_1_SQRT_2;
        let whole = MoveKey {
            scale: Some(vec3(2.0, 1.0, 1.0)),
            rotation: Some([0.0, 0.0, half, half]),
            translate: Some(vec3(10.0, 0.0, 0.0)),
            ..key(0.0)
        };
        let motion = Move {
            keys: vec![whole],
            transform: Transform { scale: Vec3::splat(3.0), ..Transform::default() },
            ..Move::default()
        };
        assert!((at(&motion, 7.0, vec3(1.0, 0.0, 0.0)) - vec3(30.0, 6.0, 0.0)).length() < 1e-5);
    }

    #[test]
    fn parts_go_by_the_keys_that_set_them_and_sizes_never_vanish() {
        let keys = vec![
            MoveKey { translate: Some(Vec3::ZERO), scale: Some(Vec3::ONE), ..key(0.0) },
            MoveKey { scale: Some(Vec3::ZERO), ..key(1.0) },
            MoveKey { translate: Some(vec3(4.0, 0.0, 0.0)), ..key(2.0) },
        ];
        let motion = Move { keys, interpolation: Interpolation::Linear, ..Move::default() };
        assert_eq!(at(&motion, 0.5, Vec3::ONE), vec3(1.5, 0.5, 0.5));
        let gone = motion.map(1.5).affine();
        assert_eq!(gone.point(Vec3::ZERO), vec3(3.0, 0.0, 0.0));
        assert!(gone.inverse().is_some() && gone.direction(Vec3::ONE).length() < 1e-5);
    }

    #[test]
    fn the_first_motion_is_applied_first() {
        let by = |translate, scale| Move {
            keys: vec![MoveKey { translate: Some(translate), scale: Some(scale), ..key(0.0) }],
            ..Move::default()
        };
        let all = [by(Vec3::ONE, Vec3::ONE), by(Vec3::ZERO, Vec3::splat(2.0))];
        assert_eq!(Move::map_of_all(&all, 0.0).position(), Vec3::splat(2.0));
    }
}
