//! Points of eight dimensions, four pairs, of Sobol's sequence, Owen-scrambled: decisions that follow from each other share them,
//! so that they are spread well together, too.
//!
//! [`point_2d`](super::point_2d) of the same seed has the same order, so it may stand in place of the first pair. Dimensions from
//! the third on have the polynomials and the first direction numbers of Joe and Kuo ("Constructing Sobol sequences with better
//! two-dimensional projections", SIAM J. Sci. Comput. 30, 2008; new-joe-kuo-6).

use super::hash::mix;
use super::sobol::{laine_karras, owen_scramble, pascal, unit_float};

/// What bit `k` of a number adds to a coordinate, modulo 2 and with the coordinate's bits in reversed order.
type Generator = [u32; 32];

/// Dimensions 2 to 7, by the polynomials' degrees and inner coefficients and the first direction numbers.
const GENERATORS: [Generator; 6] = [
    generator(2, 1, [1, 3, 0, 0, 0]),
    generator(3, 1, [1, 3, 1, 0, 0]),
    generator(3, 2, [1, 1, 1, 0, 0]),
    generator(4, 1, [1, 1, 3, 3, 0]),
    generator(4, 4, [1, 3, 5, 13, 0]),
    generator(5, 2, [1, 1, 5, 5, 17]),
];

/// By the recurrence of Bratley and Fox (1988, "Algorithm 659").
const fn generator(degree: usize, coefficients: u32, first: [u32; 5]) -> Generator {
    let mut numbers = [0u32; 32];
    let mut k = 0;
    while k < 32 {
        numbers[k] = if k < degree {
            first[k]
        } else {
            let mut number = numbers[k - degree] ^ (numbers[k - degree] << degree);
            let mut j = 1;
            while j < degree {
                if (coefficients >> (degree - 1 - j)) & 1 == 1 {
                    number ^= numbers[k - j] << j;
                }
                j += 1;
            }
            number
        };
        k += 1;
    }
    k = 0;
    while k < 32 {
        numbers[k] = (numbers[k] << (31 - k)).reverse_bits();
        k += 1;
    }
    numbers
}

/// Points of a first block of 2^8 take so many steps, of one of 2^16 twice as many.
const FEW_BITS: usize = 8;
const MORE_BITS: usize = 16;

/// Seeds of a point: of the order of all points, and of both coordinates of a pair.
#[inline(always)]
fn seeds(seed: u32, pair: u32) -> [u32; 3] {
    let order = mix(seed);
    let x = mix(order ^ pair.wrapping_mul(0x9e37_79b9));
    [order, x, mix(x)]
}

/// The place of point `index` in the scrambled order. Bits which would be the same for all of the first 2^8 points are 0 for these:
/// the fewer bits, the fewer steps.
#[inline(always)]
fn place(index: u32, order_seed: u32) -> u32 {
    let place = owen_scramble(index, order_seed);
    if index >> FEW_BITS == 0 { low_bits(place, FEW_BITS) } else { place ^ upper_bits(order_seed) }
}

#[inline(always)]
fn low_bits(x: u32, count: usize) -> u32 {
    x & ((1 << count) - 1)
}

/// The bits above the lowest few that the first points have in their scrambled order.
#[inline(always)]
fn upper_bits(order_seed: u32) -> u32 {
    owen_scramble(0, order_seed) >> FEW_BITS << FEW_BITS
}

/// A coordinate of a point, its bits reversed.
#[inline(always)]
fn generated(generator: &Generator, place: u32) -> u32 {
    let (mut x, mut k) = (0, 0);
    while k < FEW_BITS {
        // By `get`, which has no panic for GPUs.
        if let Some(number) = generator.get(k) {
            x ^= number & 0u32.wrapping_sub((place >> k) & 1);
        }
        k += 1;
    }
    let mut rest = place >> FEW_BITS;
    while rest != 0 {
        if let Some(number) = generator.get(k) {
            x ^= number & 0u32.wrapping_sub(rest & 1);
        }
        rest >>= 1;
        k += 1;
    }
    x
}

/// Coordinates of pairs 0 and 1, or of pairs 2 and 3.
#[inline(always)]
fn coordinates(place: u32, is_upper: bool, is_second: bool) -> [u32; 2] {
    let [a, b, c, d, e, f] = &GENERATORS;
    match (is_upper, is_second) {
        (false, false) => [place, pascal(place)],
        (false, true) => [generated(a, place), generated(b, place)],
        (true, false) => [generated(c, place), generated(d, place)],
        (true, true) => [generated(e, place), generated(f, place)],
    }
}

/// One of four pairs of coordinates of point `index` of the sequence of `seed`, in [0, 1) with 24 bits each.
///
/// Every seed, of any quality, gives an independent sequence.
#[inline(always)]
pub fn point_8d(index: u32, seed: u32, pair: u32) -> [f32; 2] {
    let [order_seed, x_seed, y_seed] = seeds(seed, pair);
    let [x, y] = coordinates(place(index, order_seed), pair >= 2, pair % 2 == 1);
    [scrambled(x, x_seed), scrambled(y, y_seed)]
}

#[inline(always)]
fn scrambled(x: u32, seed: u32) -> f32 {
    unit_float(laine_karras(x, seed).reverse_bits())
}

/// [`point_8d`] in several lanes, of the lower two pairs or the upper two.
#[inline(always)]
pub fn points_8d<const W: usize>(
    index: &[u32; W],
    seed: &[u32; W],
    is_upper: bool,
    is_second: &[bool; W],
) -> [[f32; W]; 2] {
    let is_below = |bits: usize| index.iter().all(|index| index >> bits == 0);
    if is_below(FEW_BITS) {
        points_of_bits::<W, FEW_BITS>(index, seed, is_upper, is_second)
    } else if is_below(MORE_BITS) {
        points_of_bits::<W, MORE_BITS>(index, seed, is_upper, is_second)
    } else {
        points_of_bits::<W, 32>(index, seed, is_upper, is_second)
    }
}

/// The same where no number has more bits: loops over arrays, free of branches.
#[inline(always)]
fn points_of_bits<const W: usize, const BITS: usize>(
    index: &[u32; W],
    seed: &[u32; W],
    is_upper: bool,
    is_second: &[bool; W],
) -> [[f32; W]; 2] {
    let (mut places, mut x_seeds, mut y_seeds) = ([0; W], [0; W], [0; W]);
    let (mut mask, mut x, mut y) = ([0; W], [0; W], [0; W]);
    for lane in 0..W {
        let pair = 2 * u32::from(is_upper) + u32::from(is_second[lane]);
        let [order_seed, x_seed, y_seed] = seeds(seed[lane], pair);
        let place = owen_scramble(index[lane], order_seed);
        places[lane] = if BITS == FEW_BITS { low_bits(place, BITS) } else { place ^ upper_bits(order_seed) };
        (x_seeds[lane], y_seeds[lane]) = (x_seed, y_seed);
        mask[lane] = 0u32.wrapping_sub(u32::from(is_second[lane]));
    }
    let [a, b, c, d, e, f] = &GENERATORS;
    if is_upper {
        for k in 0..BITS {
            for lane in 0..W {
                let bit = 0u32.wrapping_sub((places[lane] >> k) & 1);
                x[lane] ^= bit & (c[k] ^ (mask[lane] & (c[k] ^ e[k])));
                y[lane] ^= bit & (d[k] ^ (mask[lane] & (d[k] ^ f[k])));
            }
        }
    } else {
        for k in 0..BITS {
            for lane in 0..W {
                let bit = 0u32.wrapping_sub((places[lane] >> k) & 1);
                x[lane] ^= bit & a[k];
                y[lane] ^= bit & b[k];
            }
        }
        for lane in 0..W {
            x[lane] = (x[lane] & mask[lane]) | (places[lane] & !mask[lane]);
            y[lane] = (y[lane] & mask[lane]) | (pascal(places[lane]) & !mask[lane]);
        }
    }
    let mut points = [[0.0; W]; 2];
    for lane in 0..W {
        points[0][lane] = scrambled(x[lane], x_seeds[lane]);
        points[1][lane] = scrambled(y[lane], y_seeds[lane]);
    }
    points
}

#[cfg(test)]
mod tests {
    use super::super::{hash_pair, point_2d};
    use super::*;

    /// Points of SciPy's `qmc.Sobol(8, scramble=False)`, which has them in the order of Gray's code.
    #[test]
    fn points_are_those_of_scipy() {
        for (index, expected) in [
            (1, [32768, 32768, 32768, 32768, 32768, 32768, 32768, 32768]),
            (2, [16384, 49152, 49152, 49152, 16384, 16384, 49152, 16384]),
            (5, [40960, 8192, 57344, 40960, 40960, 57344, 8192, 8192]),
            (13, [45056, 53248, 28672, 61440, 4096, 53248, 61440, 28672]),
            (1000, [6080, 10560, 29504, 59584, 65088, 10688, 1088, 41920]),
            (54321, [35883, 47485, 43699, 27887, 7729, 26565, 59513, 53987]),
        ] {
            for (pair, expected) in expected.chunks(2).enumerate() {
                let found = coordinates(index, pair >= 2, pair % 2 == 1);
                assert_eq!(found.map(|x| x.reverse_bits() >> 16), expected);
            }
        }
    }

    #[test]
    fn lanes_have_the_points_of_one() {
        for block in [0u32, 250, 3_000, 65_530, 1 << 20, u32::MAX - 15] {
            for is_upper in [false, true] {
                let index: [u32; 8] = std::array::from_fn(|k| block.wrapping_add(2 * k as u32));
                let seed = std::array::from_fn(|k| hash_pair(block, k as u32 / 3));
                let is_second = std::array::from_fn(|k| k % 3 == 1);
                let [x, y] = points_8d::<8>(&index, &seed, is_upper, &is_second);
                for k in 0..8 {
                    let pair = 2 * u32::from(is_upper) + u32::from(is_second[k]);
                    assert_eq!([x[k], y[k]], point_8d(index[k], seed[k], pair));
                }
            }
        }
    }

    /// In each dimension an aligned block of 2^m points has one in each of 2^m equal intervals, beyond 2^16 points, too.
    #[test]
    fn blocks_are_even_in_each_dimension() {
        for seed in [3, 1234] {
            for (first, count) in
                [(0u32, 64usize), (0, 1024), (1024, 256), (65_536 - 32, 32), (1 << 17, 1024)]
            {
                for pair in 0..4 {
                    let mut seen = [vec![false; count], vec![false; count]];
                    for index in first..first + count as u32 {
                        for (seen, x) in seen.iter_mut().zip(point_8d(index, seed, pair)) {
                            let interval = &mut seen[(x * count as f32) as usize];
                            assert!(!*interval, "two points of pair {pair} in one interval");
                            *interval = true;
                        }
                    }
                }
            }
        }
    }

    /// Across pairs, too: of 256 points, each of 8 x 8 squares has as many as another, to within a factor; random ones differ by
    /// more.
    #[test]
    fn pairs_are_even_together() {
        let worst = |of: &dyn Fn(u32) -> [f32; 2]| {
            let mut cells = [0i32; 64];
            for index in 0..256 {
                let [x, y] = of(index);
                cells[(y * 8.0) as usize * 8 + (x * 8.0) as usize] += 1;
            }
            cells.iter().map(|n| (n - 4).abs()).max().unwrap()
        };
        for seed in [5, 99, 4711] {
            for (a, b) in [(0, 1), (0, 2), (1, 2), (1, 3), (0, 3), (2, 3)] {
                for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                    let of = |k| [point_8d(k, seed, a)[i], point_8d(k, seed, b)[j]];
                    assert!(worst(&of) <= 2, "pairs {a} and {b}, coordinates {i} and {j}");
                }
            }
            for (pair, j) in [(2, 0), (2, 1), (1, 1)] {
                let of = |k| [point_2d(k, seed)[0], point_8d(k, seed, pair)[j]];
                assert!(worst(&of) <= 2, "a point of two dimensions and pair {pair}, coordinate {j}");
            }
            let alone = |k| [point_2d(k, seed)[0], point_2d(k, seed + 1)[0]];
            assert!(worst(&alone) > 2, "sequences of their own are not even together");
        }
    }
}
