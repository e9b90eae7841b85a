//! Several numbers of one precision, one a lane: the scalar of the batch kernels.
//!
//! [`Lanes`] wraps the native vector of an instruction set, so that the kernels read like the scalar forms. Every operation is
//! the correctly rounded one of IEEE 754 and no product is fused with a sum: all instruction sets give the same digits. All
//! that runs on lanes is `#[inline(always)]`, down from [`fearless_simd::dispatch`], which enables the instructions.

use std::fmt::{self, Debug, Formatter};
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdFloatElement, SimdMask};

use crate::lanes::angle::ArcTangent;
use crate::vec3::Vec3;

/// Lanes of the widest vector there is, 512 bits of single precision.
pub const MOST_LANES: usize = 16;

/// Single or double precision, with the types and constants of each.
pub trait Lane: SimdFloatElement + Send + Sync + 'static {
    /// Whether it is single precision.
    const IS_SINGLE: bool;
    /// Lanes of the widest vector of this precision.
    const WIDEST: usize;
    /// Unit roundoff u.
    const ROUNDOFF: f64;
    /// Emitters of a size between this and its inverse need not be normalised.
    const UNSCALED: f64;
    /// Farther vertices and shorter edges, in normalised lengths, may take a product out of the normal range.
    const FARTHEST: f64;
    /// See [`Self::FARTHEST`].
    const SHORTEST: f64;
    /// Distance from the farthest vertex over that from an edge's line, beyond which too many digits are lost.
    const CONDITION: f64;
    /// The largest finite number.
    const LARGEST: f64;
    /// The smallest normal number.
    const TINY: f64;
    /// The constants of [`angle`](crate::lanes::angle::angle).
    const ARC_TANGENT: ArcTangent<Self>;

    /// The nearest number.
    fn nearest(value: f64) -> Self;
    /// As a double, exactly.
    fn to_double(self) -> f64;
}

/// A vector of numbers.
pub struct Lanes<S: Simd, F: Lane>(pub(super) F::Native<S>);

/// A truth value for each lane.
pub struct Mask<S: Simd, F: Lane>(pub(super) <F::Native<S> as SimdBase<S>>::Mask);

impl<S: Simd, F: Lane> Clone for Lanes<S, F> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<S: Simd, F: Lane> Copy for Lanes<S, F> {}

impl<S: Simd, F: Lane> Clone for Mask<S, F> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<S: Simd, F: Lane> Copy for Mask<S, F> {}

impl<S: Simd, F: Lane> Debug for Lanes<S, F> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl<S: Simd, F: Lane> Debug for Mask<S, F> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{:b}", self.bits())
    }
}

impl<S: Simd, F: Lane> Lanes<S, F> {
    /// How many there are.
    pub const COUNT: usize = F::Native::<S>::LEN;

    /// The same number in all lanes.
    #[inline(always)]
    pub fn splat(simd: S, value: F) -> Self {
        Self(F::Native::<S>::splat(simd, value))
    }

    /// The first numbers of a slice at least as long.
    #[inline(always)]
    pub fn load(simd: S, slice: &[F]) -> Self {
        Self(F::Native::<S>::from_slice(simd, &slice[..Self::COUNT]))
    }

    /// Writes to the first numbers of a slice at least as long.
    #[inline(always)]
    pub fn store(self, slice: &mut [F]) {
        self.0.store_slice(&mut slice[..Self::COUNT]);
    }

    /// Square roots.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }

    /// Magnitudes.
    #[inline(always)]
    pub fn abs(self) -> Self {
        Self(self.0.abs())
    }

    /// The magnitude of this with the sign of the other.
    #[inline(always)]
    pub fn copysign(self, sign: Self) -> Self {
        Self(self.0.copysign(sign.0))
    }

    /// The larger; neither must be NaN.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        Self(self.0.max(other.0))
    }

    /// The smaller; neither must be NaN.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        Self(self.0.min(other.0))
    }

    /// Where this is smaller.
    #[inline(always)]
    pub fn below(self, other: Self) -> Mask<S, F> {
        Mask(self.0.simd_lt(other.0))
    }

    /// Where this is smaller or equal.
    #[inline(always)]
    pub fn at_most(self, other: Self) -> Mask<S, F> {
        Mask(self.0.simd_le(other.0))
    }
}

/// `sum c[k] z^k` of several z by Horner's rule in `z^2`, even and odd powers side by side, so that operations need not wait for
/// each other; a coefficient is loaded once.
#[inline(always)]
pub fn polynomials<S: Simd, F: Lane, const N: usize>(simd: S, z: [Lanes<S, F>; N], c: &[F]) -> [Lanes<S, F>; N] {
    let Some((last, lower)) = c.split_last() else { return [constant(simd, 0.0); N] };
    let Some((next, lower)) = lower.split_last() else { return [Lanes::splat(simd, *last); N] };
    let mut squares = z;
    for square in &mut squares {
        *square = *square * *square;
    }
    let (mut sums, mut others) = ([Lanes::splat(simd, *last); N], [Lanes::splat(simd, *next); N]);
    for coefficient in lower.iter().rev() {
        let coefficient = Lanes::splat(simd, *coefficient);
        for k in 0..N {
            (sums[k], others[k]) = (others[k], sums[k] * squares[k] + coefficient);
        }
    }
    for k in 0..N {
        sums[k] = sums[k] * z[k] + others[k];
    }
    sums
}

#[repr(align(64))]
struct CacheLine([u8; 64]);

/// Makes the stack frame of the function that this is inlined into begin at a cache line: the widest vectors are as long as one,
/// and where one lies across two, as it does in three processes of four, a batch takes a tenth longer.
#[inline(always)]
pub fn align_frame() {
    std::hint::black_box(&mut CacheLine([0; 64]).0);
}

/// The number nearest to a constant, in all lanes.
#[inline(always)]
pub fn constant<S: Simd, F: Lane>(simd: S, value: f64) -> Lanes<S, F> {
    Lanes::splat(simd, F::nearest(value))
}

/// Vectors from the first entries of three slices.
#[inline(always)]
pub fn load<S: Simd, F: Lane>(simd: S, [x, y, z]: [&[F]; 3]) -> Vec3<Lanes<S, F>> {
    Vec3::new(Lanes::load(simd, x), Lanes::load(simd, y), Lanes::load(simd, z))
}

/// The same vector in all lanes.
#[inline(always)]
pub fn same<S: Simd, F: Lane>(simd: S, [x, y, z]: [F; 3]) -> Vec3<Lanes<S, F>> {
    Vec3::new(Lanes::splat(simd, x), Lanes::splat(simd, y), Lanes::splat(simd, z))
}

impl<S: Simd, F: Lane> Mask<S, F> {
    /// One number where the mask is set, the other where it is not.
    #[inline(always)]
    pub fn select(self, set: Lanes<S, F>, unset: Lanes<S, F>) -> Lanes<S, F> {
        Lanes(self.0.select(set.0, unset.0))
    }

    /// Whether it is set in any lane.
    #[inline(always)]
    pub fn any(self) -> bool {
        self.0.any_true()
    }

    /// The same for vectors.
    #[inline(always)]
    pub fn select_vector(self, set: Vec3<Lanes<S, F>>, unset: Vec3<Lanes<S, F>>) -> Vec3<Lanes<S, F>> {
        Vec3::new(self.select(set.x, unset.x), self.select(set.y, unset.y), self.select(set.z, unset.z))
    }

    /// Lane i as bit i.
    #[inline(always)]
    pub fn bits(self) -> u64 {
        self.0.to_bitmask()
    }
}

macro_rules! operation {
    ($type:ident, $trait:ident, $name:ident) => {
        impl<S: Simd, F: Lane> $trait for $type<S, F> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self($trait::$name(self.0, other.0))
            }
        }
    };
}

operation!(Lanes, Add, add);
operation!(Lanes, Sub, sub);
operation!(Lanes, Mul, mul);
operation!(Lanes, Div, div);
operation!(Mask, BitAnd, bitand);
operation!(Mask, BitOr, bitor);
operation!(Mask, BitXor, bitxor);

impl<S: Simd, F: Lane> Neg for Lanes<S, F> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl<S: Simd, F: Lane> Not for Mask<S, F> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
}

impl Lane for f64 {
    const IS_SINGLE: bool = false;
    const WIDEST: usize = 8;
    const ROUNDOFF: Self = Self::EPSILON / 2.0;
    const UNSCALED: Self = (1 << 30) as Self;
    const FARTHEST: Self = (1u128 << 120) as Self;
    const SHORTEST: Self = 1.0 / (1u128 << 100) as Self;
    const CONDITION: Self = (1 << 16) as Self;
    const LARGEST: Self = Self::MAX;
    const TINY: Self = Self::MIN_POSITIVE;
    const ARC_TANGENT: ArcTangent<Self> = ArcTangent::<Self>::DOUBLE;

    #[inline(always)]
    fn nearest(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn to_double(self) -> f64 {
        self
    }
}

impl Lane for f32 {
    const IS_SINGLE: bool = true;
    const WIDEST: usize = MOST_LANES;
    const ROUNDOFF: f64 = 1.0 / (1 << 24) as f64;
    const UNSCALED: f64 = 4.0;
    const FARTHEST: f64 = (1 << 16) as f64;
    const SHORTEST: f64 = 1.0 / (1 << 10) as f64;
    const CONDITION: f64 = (1 << 7) as f64;
    const LARGEST: f64 = Self::MAX as f64;
    const TINY: f64 = Self::MIN_POSITIVE as f64;
    const ARC_TANGENT: ArcTangent<Self> = ArcTangent::<Self>::SINGLE;

    #[inline(always)]
    #[allow(clippy::cast_possible_truncation, reason = "to the nearest is what it is for")]
    fn nearest(value: f64) -> Self {
        value as Self
    }
    #[inline(always)]
    fn to_double(self) -> f64 {
        f64::from(self)
    }
}
