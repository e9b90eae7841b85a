//! Random numbers that stay the same for ever: the numbers of a case depend on nothing but (seed, stream, index).
//!
//! The generator is xoshiro256++ (Blackman and Vigna, "Scrambled linear pseudorandom number generators", ACM TOMS 47, 2021), by
//! name from `rand`, seeded through `SplitMix64` (Steele, Lea and Flood, OOPSLA 2014). Distributions are our own few lines:
//! those of a library may change their values with a release, and transcendental functions differ between machines.

use glam::DVec3;
use rand::rngs::Xoshiro256PlusPlus;
use rand::{Rng, SeedableRng};

/// A stream of random numbers.
#[derive(Debug, Clone)]
pub struct Sampler(Xoshiro256PlusPlus);

impl Sampler {
    /// The stream named `stream` for case `index` under `seed`.
    #[must_use]
    pub fn new(seed: u64, stream: &str, index: u64) -> Self {
        let mut state = split_mix(seed);
        for byte in stream.bytes() {
            state = split_mix(state ^ u64::from(byte));
        }
        state = split_mix(state ^ split_mix(index));
        let mut bytes = [0; 32];
        for chunk in bytes.chunks_exact_mut(8) {
            state = state.wrapping_add(GOLDEN);
            chunk.copy_from_slice(&split_mix(state).to_le_bytes());
        }
        Self(Xoshiro256PlusPlus::from_seed(bytes))
    }

    /// Uniform in [0, 1), a multiple of 2^-53.
    pub fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in [low, high).
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// Uniform in 0..count. The bias of the multiplication is below count / 2^32 (Lemire, ACM TOMACS 29, 2019).
    pub fn below(&mut self, count: u32) -> u32 {
        let scaled = (self.0.next_u64() >> 32) * u64::from(count);
        u32::try_from(scaled >> 32).unwrap_or(u32::MAX)
    }

    /// Uniform integer in low..=high.
    pub fn integer(&mut self, low: i64, high: i64) -> i64 {
        low + i64::from(self.below(u32::try_from(high - low + 1).unwrap_or(u32::MAX)))
    }

    /// True once in `count`.
    pub fn one_in(&mut self, count: u32) -> bool {
        self.below(count) == 0
    }

    /// +1 or -1.
    pub fn sign(&mut self) -> f64 {
        if self.one_in(2) { 1.0 } else { -1.0 }
    }

    /// Logarithmically spread in [2^low, 2^high): a uniform exponent times a uniform mantissa, exact in every digit.
    pub fn spread(&mut self, low: i64, high: i64) -> f64 {
        power_of_two(self.integer(low, high - 1)) * (1.0 + self.uniform())
    }

    /// A point of the cube [-1, 1)^3.
    pub fn cube(&mut self) -> DVec3 {
        DVec3::new(self.between(-1.0, 1.0), self.between(-1.0, 1.0), self.between(-1.0, 1.0))
    }

    /// A unit vector, uniform on the sphere: rejection from the cube (von Neumann 1951), no angle needed.
    pub fn direction(&mut self) -> DVec3 {
        loop {
            let v = self.cube();
            let square = v.length_squared();
            if (0.01..=1.0).contains(&square) {
                return v / square.sqrt();
            }
        }
    }

    /// A unit vector on the side of `axis`.
    pub fn hemisphere(&mut self, axis: DVec3) -> DVec3 {
        let v = self.direction();
        if v.dot(axis) < 0.0 { -v } else { v }
    }

    /// A unit vector perpendicular to the unit vector `axis`, up to rounding.
    pub fn perpendicular(&mut self, axis: DVec3) -> DVec3 {
        loop {
            let v = axis.cross(self.direction());
            if v.length_squared() > 0.01 {
                return v.normalize();
            }
        }
    }
}

/// 2^exponent; the exponent is of a normal number.
#[must_use]
pub(crate) const fn power_of_two(exponent: i64) -> f64 {
    assert!(exponent >= -1022 && exponent <= 1023, "the power of two must be a normal number");
    f64::from_bits((1023 + exponent).cast_unsigned() << 52)
}

/// The power of two that brings a positive normal number into [1, 2).
#[must_use]
pub(crate) fn normalising_power(x: f64) -> f64 {
    let exponent = (x.to_bits() >> 52).cast_signed() - 1023;
    power_of_two(-exponent.clamp(-1021, 1021))
}

const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// Output function of `SplitMix64` after one step from `state`.
pub(crate) const fn split_mix(state: u64) -> u64 {
    let z = state.wrapping_add(GOLDEN);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn split_mix_follows_its_published_sequence() {
        // First outputs from state 0 (Vigna's splitmix64.c).
        assert_eq!(split_mix(0), 0xe220_a839_7b1d_cdaf);
        assert_eq!(split_mix(GOLDEN), 0x6e78_9e6a_a1b9_65f4);
    }

    #[test]
    fn normalised_numbers_are_between_1_and_2() {
        for x in [1.0, 1.999, 2.0, 0.75, 3e-300, 7e300] {
            assert!((1.0..2.0).contains(&(x * normalising_power(x))), "{x}");
        }
    }

    #[test]
    fn the_numbers_never_change() {
        let mut sampler = Sampler::new(1, "generic", 0);
        let drawn: Vec<u64> = (0..3).map(|_| sampler.uniform().to_bits()).collect();
        assert_eq!(drawn, PINNED);
    }

    /// As first drawn. Another value here means that every recorded case id names another case.
    const PINNED: [u64; 3] = [0x3fde_c35d_45b1_5d3c, 0x3fe6_dd46_1d6b_4ca1, 0x3fe6_cd5c_429d_2d6a];

    #[test]
    fn streams_and_indices_differ() {
        let first = |seed, stream, index| Sampler::new(seed, stream, index).uniform();
        let base = first(1, "generic", 0);
        for other in [first(2, "generic", 0), first(1, "far", 0), first(1, "generic", 1)] {
            assert_ne!(base, other);
        }
    }

    #[test]
    fn spread_covers_every_exponent_and_stays_inside() {
        let mut sampler = Sampler::new(7, "spread", 0);
        let mut counts = [0; 10];
        for _ in 0..1000 {
            let x = sampler.spread(-5, 5);
            let exponent = (0..10).rev().find(|&k| x >= power_of_two(k - 5)).expect("above the lower end");
            counts[usize::try_from(exponent).expect("small")] += 1;
            assert!(x < 32.0);
        }
        assert!(counts.iter().all(|&count| count > 60), "{counts:?}");
    }

    #[test]
    fn directions_are_unit_vectors_on_both_sides() {
        let mut sampler = Sampler::new(7, "direction", 0);
        let (mut above, mut total) = (0, 0);
        for _ in 0..400 {
            let v = sampler.direction();
            assert!((v.length() - 1.0).abs() < 4e-16);
            assert!(sampler.hemisphere(DVec3::X).x >= 0.0);
            assert!(sampler.perpendicular(v).dot(v).abs() < 1e-15);
            above += i32::from(v.z > 0.0);
            total += 1;
        }
        assert!((above * 2 - total).abs() < 80, "{above} of {total}");
    }
}
