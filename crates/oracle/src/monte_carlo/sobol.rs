//! The Sobol sequence in two dimensions (Sobol 1967) under Owen's nested uniform scrambling (Owen 1995).
//!
//! The first `2^m` points are a (0, m, 2)-net in base 2: every box `2^-k x 2^-(m-k)` of the dyadic grid holds exactly one.
//! Scrambling keeps that and makes each point uniform on the square, so that means over independent scramblings are unbiased
//! and comparable: their spread is an error estimate, which a plain low-discrepancy sequence does not have. The flips are bits
//! of a hash of (key, dimension, leading digits), hence the same on every machine.

/// Digits that are scrambled one by one; the lower ones are drawn uniformly.
const DIGITS: u32 = 32;

/// Digits whose flips, one for each of `2^GROUP - 1` prefixes, are taken from one hash.
const GROUP: u32 = 4;

/// One scrambled copy of the sequence.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ScrambledSobol {
    keys: [u64; 2],
}

impl ScrambledSobol {
    pub(crate) fn new(key: u64) -> Self {
        Self { keys: [mix(key), mix(key ^ 0xd1b5_4a32_d192_ed03)] }
    }

    /// Point `index`, in `[0, 1)` squared.
    pub(crate) fn point(&self, index: u32) -> [f64; 2] {
        // Generator matrices: the reversed identity, and Pascal's triangle modulo 2 (primitive polynomial x + 1).
        let mut second = 0_u32;
        let mut column = 1_u32 << 31;
        let mut digits = index;
        while digits != 0 {
            if digits & 1 == 1 {
                second ^= column;
            }
            digits >>= 1;
            column ^= column >> 1;
        }
        [scramble(index.reverse_bits(), self.keys[0]), scramble(second, self.keys[1])]
    }
}

/// Flips each digit by a bit that depends on the digits above it, then draws the lower ones at random.
fn scramble(digits: u32, key: u64) -> f64 {
    let mut scrambled = 0_u64;
    for group in 0..DIGITS / GROUP {
        let above = DIGITS - group * GROUP;
        let flips = mix(key ^ prefix(digits, above));
        // The nodes of a binary tree of depth GROUP: 1 at the root, 2 n and 2 n + 1 below n.
        let mut node = 1;
        for place in 1..=GROUP {
            let digit = u64::from(digits >> (above - place) & 1);
            scrambled = scrambled << 1 | (digit ^ (flips >> node & 1));
            node = 2 * node + digit;
        }
    }
    let below = mix(key ^ prefix(digits, 0)) >> (11 + DIGITS);
    unit_interval((scrambled << (53 - DIGITS)) | below)
}

/// The digits above place `above`, told from shorter and longer prefixes by a leading 1, spread over 64 bits.
fn prefix(digits: u32, above: u32) -> u64 {
    (1_u64 << (DIGITS - above) | u64::from(digits) >> above).wrapping_mul(0x9e37_79b9_7f4a_7c15)
}

/// 53 bits as a double in `[0, 1)`: exact.
fn unit_interval(bits: u64) -> f64 {
    bits as f64 / (1_u64 << 53) as f64
}

/// The finaliser of `SplitMix64` (Steele, Lea and Flood 2014).
fn mix(key: u64) -> u64 {
    let z = key.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Boxes of the dyadic grid `2^-k x 2^-(m-k)` that do not hold exactly one of the points.
    fn wrong_boxes(points: &[[f64; 2]], m: u32, k: u32) -> usize {
        let (columns, rows) = ((1_u32 << k), 1_u32 << (m - k));
        let cell = |t: f64, count: u32| (0..count).rev().find(|i| t >= f64::from(*i) / f64::from(count)).unwrap();
        let mut held = vec![0; 1 << m];
        for [a, b] in points {
            held[(cell(*a, columns) * rows + cell(*b, rows)) as usize] += 1;
        }
        held.iter().filter(|count| **count != 1).count()
    }

    #[test]
    fn every_scrambling_is_a_net_in_every_dyadic_grid() {
        for key in 0..8 {
            let sequence = ScrambledSobol::new(key);
            for m in 0..=7 {
                let points: Vec<[f64; 2]> = (0..1 << m).map(|i| sequence.point(i)).collect();
                for k in 0..=m {
                    assert_eq!(wrong_boxes(&points, m, k), 0, "key {key}, 2^{m} points, 2^-{k} columns");
                }
            }
        }
    }

    #[test]
    fn a_net_is_told_from_independent_points() {
        let points: Vec<[f64; 2]> = (0..64).map(|i| ScrambledSobol::new(i).point(0)).collect();
        assert!(wrong_boxes(&points, 6, 3) > 10);
    }

    #[test]
    fn each_point_is_uniform_over_the_scramblings() {
        for index in [0, 5] {
            let mut quarters = [0_usize; 4];
            for key in 0..4000 {
                let [a, b] = ScrambledSobol::new(key).point(index);
                quarters[usize::from(a < 0.5) * 2 + usize::from((0.25..0.75).contains(&b))] += 1;
            }
            // Binomial: 1000 with standard deviation 27.
            assert!(quarters.iter().all(|count| count.abs_diff(1000) < 140), "{quarters:?}");
        }
    }
}
