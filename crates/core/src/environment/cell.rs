//! How bright the corners of a cell are, and places in it by that: the picture is interpolated between its texels, and samples are
//! as dense as it is bright.

use super::index::Pick;
use crate::math::{fma, max, sqrt};

/// The corners of a cell of the table.
#[derive(Clone, Copy)]
pub(super) struct Corners {
    /// Brightness by row and column, the upper left one first; 255: as bright as the brightest of them.
    brightness: [[f32; 2]; 2],
    /// The sum of the four.
    sum: f32,
}

/// A place in a cell.
#[derive(Clone, Copy)]
pub(super) struct CellPlace {
    /// From the left, 0 to 1.
    pub(super) across: f32,
    /// From the top.
    pub(super) down: f32,
}

/// The word of a table that says how bright the corners of a cell are, by row and column, 8 bits each. None that has light beside
/// it is black, so that no light is missed.
pub fn corners_word(brightness: [[f64; 2]; 2]) -> u32 {
    let [[a, b], [c, d]] = brightness;
    let most = a.max(b).max(c.max(d));
    if !(most > 0.0) {
        return 0;
    }
    let scale = 255.0 / most;
    let part = |x: f64| ((x * scale + 0.5) as u32).clamp(1, 255);
    part(a) | (part(b) << 8) | (part(c) << 16) | (part(d) << 24)
}

impl Corners {
    #[inline(always)]
    pub(super) fn of_word(word: u32) -> Corners {
        let part = |shift: u32| ((word >> shift) & 0xff) as f32;
        let (upper, lower) = ([part(0), part(8)], [part(16), part(24)]);
        Corners { brightness: [upper, lower], sum: max((upper[0] + upper[1]) + (lower[0] + lower[1]), 1.0) }
    }

    /// The place that the rests of picks of its row and column lead to.
    #[inline(always)]
    pub(super) fn place(&self, row: &Pick, column: &Pick) -> CellPlace {
        let [upper, lower] = self.brightness;
        let down = place_on_line(upper[0] + upper[1], lower[0] + lower[1], row.rest);
        let [left, right] = self.row(down);
        CellPlace { across: place_on_line(left, right, column.rest), down }
    }

    /// How dense places are here, beside the mean of the cell.
    #[inline(always)]
    pub(super) fn density(&self, place: CellPlace) -> f32 {
        let [left, right] = self.row(place.down);
        4.0 * fma(right - left, place.across, left) / self.sum
    }

    /// The brightness of the left and the right border so far down.
    #[inline(always)]
    fn row(&self, down: f32) -> [f32; 2] {
        let [[a, b], [c, d]] = self.brightness;
        [fma(c - a, down, a), fma(d - b, down, b)]
    }
}

/// Where `u` in [0, 1) leads on a line of length 1, with density growing evenly from one end to the other.
#[inline(always)]
fn place_on_line(near: f32, far: f32, u: f32) -> f32 {
    // The solution of `near x + (far - near) x^2 / 2 = u (near + far) / 2` that has no difference of similar numbers.
    let root = sqrt(fma(u, far * far - near * near, near * near));
    // Black cells are not chosen; their place has to be a number.
    u * (near + far) / max(near + root, f32::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::point_2d;

    #[test]
    fn places_are_as_dense_as_corners_are_bright() {
        for corners in [[[1.0, 1.0], [1.0, 1.0]], [[0.0, 9.0], [0.0, 1.0]], [[1e9, 2.0], [3e8, 7e8]]] {
            let corners = Corners::of_word(corners_word(corners));
            let (mut sampled, mut said) = ([0.0; 16], [0.0; 16]);
            let count = 1 << 14;
            let part = |place: CellPlace| (place.across * 4.0) as usize + 4 * (place.down * 4.0) as usize;
            for i in 0..count {
                let [down, across] = point_2d(i, 7);
                let pick = |rest: f32| Pick { rest, ..Pick::NONE };
                let place = corners.place(&pick(down), &pick(across));
                assert!((0.0..1.0).contains(&place.across) && (0.0..1.0).contains(&place.down));
                sampled[part(place)] += 1.0 / f64::from(count);
                let even = CellPlace { across, down };
                said[part(even)] += f64::from(corners.density(even)) / f64::from(count);
            }
            assert!((said.iter().sum::<f64>() - 1.0).abs() < 1e-3);
            for (a, b) in sampled.iter().zip(&said) {
                assert!((a - b).abs() < 1e-3, "{sampled:?} {said:?}");
            }
        }
    }

    #[test]
    fn corners_beside_light_are_not_black() {
        assert_eq!(corners_word([[0.0; 2]; 2]), 0);
        assert_eq!(corners_word([[0.0, 1e-300], [0.0, 0.0]]), 0x01_01_ff_01);
        assert_eq!(corners_word([[4.0, 2.0], [1.0, 0.0]]), 0x01_40_80_ff);
        let black = Corners::of_word(0);
        let pick = Pick { rest: 0.5, ..Pick::NONE };
        let place = black.place(&pick, &pick);
        assert_eq!((place.across, place.down, black.density(place)), (0.0, 0.0, 0.0));
    }
}
