//! Convex cones with their apex at the receiver, cut by planes through it, all signs exact.
//!
//! Whatever bounds the visible part of a triangle lies in a plane through the receiver: an edge of the emitter or of an
//! occluder, the horizon, the line in which an occluder meets the emitter's plane. A corner is the direction in which two such
//! planes meet, the cross product of their normals as given: cutting a cut cone makes no number longer, so that every sign is
//! that of exact arithmetic on the input. A sign is taken from doubles where their rounding cannot change it.

use std::rc::Rc;

use crate::enclosure::exact::{ExactVector, cross, dot};
use crate::enclosure::surface::dot64;

/// A direction or a normal, but for a positive factor.
#[derive(Debug, Clone)]
pub(crate) struct Direction {
    pub(crate) exact: ExactVector,
    /// Next to it, the largest component 1/2 to 1.
    near: [f64; 3],
}

/// Bound on the rounding of a dot product of two vectors with components below 1, each cut to 52 bits: 3 products, each off by
/// less than 2^-50.
const CERTAIN: f64 = 1e-14;

impl Direction {
    /// None for the vector 0.
    pub(crate) fn new(vector: &ExactVector) -> Option<Self> {
        let power = vector.iter().filter(|c| !c.is_zero()).map(|c| -c.exponent()).min()?;
        let exact = vector.each_ref().map(|c| c.times_power(power));
        let near = exact.each_ref().map(|c| c.leading());
        Some(Self { exact, near })
    }

    /// Sign of the dot product.
    pub(crate) fn side(&self, other: &Self) -> i32 {
        let near = dot64(self.near, other.near);
        if near > CERTAIN {
            1
        } else if near < -CERTAIN {
            -1
        } else {
            dot(&self.exact, &other.exact).sign()
        }
    }

    /// The cross product; none if both are parallel.
    pub(crate) fn cross(&self, other: &Self) -> Option<Self> {
        Self::new(&cross(&self.exact, &other.exact))
    }

    pub(crate) fn reversed(&self) -> Self {
        Self { exact: self.exact.each_ref().map(|c| -c), near: self.near.map(|c| -c) }
    }
}

/// Planes through the receiver, by the number of their normal in a list.
pub(crate) type Planes = Vec<Direction>;

/// A corner of a cone, and the plane of the side from there to the next.
#[derive(Debug, Clone)]
pub(crate) struct Corner {
    pub(crate) direction: Rc<Direction>,
    pub(crate) plane: usize,
    /// Whether the plane's normal points into the cone.
    pub(crate) inward: bool,
}

/// A convex cone within the half-space where `facing` is negative, its corners counter-clockwise as the emitter's.
#[derive(Debug, Clone)]
pub(crate) struct Cone(pub(crate) Vec<Corner>);

impl Cone {
    /// The part on the side of a plane where its normal points to, or away from; none if that is empty.
    pub(crate) fn cut(&self, planes: &Planes, plane: usize, inward: bool, facing: &Direction) -> Option<Self> {
        let depth = |corner: &Corner| planes[plane].side(&corner.direction) * if inward { 1 } else { -1 };
        let depths: Vec<i32> = self.0.iter().map(depth).collect();
        if !depths.iter().any(|d| *d > 0) {
            return None;
        }
        if !depths.iter().any(|d| *d < 0) {
            return Some(self.clone());
        }
        let mut corners = Vec::with_capacity(self.0.len() + 1);
        for (i, corner) in self.0.iter().enumerate() {
            let next = depths[(i + 1) % depths.len()];
            if depths[i] > 0 || (depths[i] == 0 && next > 0) {
                corners.push(corner.clone());
            } else if depths[i] == 0 && next < 0 {
                corners.push(Corner { direction: Rc::clone(&corner.direction), plane, inward });
            }
            if depths[i] * next < 0 {
                let meeting = planes[corner.plane].cross(&planes[plane])?;
                let direction = Rc::new(if meeting.side(facing) < 0 { meeting } else { meeting.reversed() });
                corners.push(if next < 0 { Corner { direction, plane, inward } } else { Corner { direction, ..corner.clone() } });
            }
        }
        Some(Self(corners))
    }

    /// Whether a plane has the whole cone on its outer side or on it.
    pub(crate) fn is_beyond(&self, normal: &Direction) -> bool {
        self.0.iter().all(|corner| normal.side(&corner.direction) <= 0)
    }
}
