//! Integer hashes: the source of every random decision.

/// Scrambles 32 bits, one to one: every input bit flips every output bit with a probability near one half.
///
/// Wellons' "lowbias32" (nullprogram.com/blog/2018/07/31), after an offset that keeps zero from mapping to itself.
#[inline(always)]
pub fn mix(x: u32) -> u32 {
    let x = x.wrapping_add(0x9e37_79b9);
    let x = (x ^ (x >> 16)).wrapping_mul(0x7feb_352d);
    let x = (x ^ (x >> 15)).wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// One hash of two numbers in order, made to be chained: `hash_pair(hash_pair(seed, pixel), path)`.
///
/// Of the two only `b` is mixed beforehand: it is often a constant, and then that costs nothing. Without it the
/// sequences in `b` of two values of `a` could be shifted copies of each other.
#[inline(always)]
pub fn hash_pair(a: u32, b: u32) -> u32 {
    mix(a.wrapping_mul(0x9e37_79b1) ^ mix(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Asserts that flipping any input bit flips any output bit about half the time.
    fn assert_avalanche(hash: impl Fn(u32) -> u32) {
        const TRIALS: u32 = 4096;
        for input in 0..32 {
            let mut flips = [0u32; 32];
            for x in 0..TRIALS {
                // Half of the inputs are small numbers, as pixels and samples are.
                let x = if x % 2 == 0 { x } else { x.wrapping_mul(0x0019_660d) };
                let difference = hash(x) ^ hash(x ^ (1 << input));
                for (output, count) in flips.iter_mut().enumerate() {
                    *count += (difference >> output) & 1;
                }
            }
            for (output, count) in flips.into_iter().enumerate() {
                let probability = count as f32 / TRIALS as f32;
                assert!((probability - 0.5).abs() < 0.1, "bit {input} to {output}: {probability}");
            }
        }
    }

    #[test]
    fn every_bit_matters() {
        assert_avalanche(mix);
        for fixed in [0, 1, 77, 0xdead_beef] {
            assert_avalanche(|a| hash_pair(a, fixed));
            assert_avalanche(|b| hash_pair(fixed, b));
        }
    }

    #[test]
    fn mix_is_one_to_one_on_a_sample() {
        let mut values: Vec<u32> = (0..1_000_000).map(mix).collect();
        values.sort_unstable();
        values.dedup();
        assert_eq!(values.len(), 1_000_000);
        assert_ne!(mix(0), 0);
    }

    #[test]
    fn pairs_collide_as_rarely_as_random_numbers() {
        // 1024 x 1024 pairs in 2^32 values: n^2 / 2^33 = 128 collisions expected, with deviation 11.
        let mut values: Vec<u32> = (0..1 << 20).map(|i| hash_pair(i >> 10, i & 1023)).collect();
        values.sort_unstable();
        values.dedup();
        let collisions = (1 << 20) - values.len() as i32;
        assert!((70..190).contains(&collisions), "{collisions}");
        assert_ne!(hash_pair(1, 2), hash_pair(2, 1));
    }

    #[test]
    fn hashes_are_uniform() {
        let mut bins = [0u32; 256];
        for i in 0..1 << 16 {
            bins[(hash_pair(hash_pair(7, i >> 8), i & 255) >> 24) as usize] += 1;
        }
        // Chi-square with 255 degrees of freedom: mean 255, deviation 22.6.
        let chi_square: f32 = bins.iter().map(|&n| (n as f32 - 256.0).powi(2) / 256.0).sum();
        assert!((165.0..370.0).contains(&chi_square), "{chi_square}");
    }
}
