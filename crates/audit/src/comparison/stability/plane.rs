//! Planes of two parameters, each through several ways of losing digits, and the case at each of their points.
//!
//! The emitter is a triangle about 1 across, lit upward from the plane z = 0, where a height is an exact double however small.

use radgrad_core::DVec3;
use radgrad_scene::case::{Case, EmissionRecord, EmitterRecord, Id, ReceiverRecord};

use crate::cases::sampler::power_of_two;

/// Two parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Plane {
    /// How far aside of the emitter's middle, and how high over its plane: contact, grazing, far.
    DistanceHeight,
    /// How steeply the receiver sees a needle, and how wide the needle is.
    AngleWidth,
    /// How steeply the receiver sees the emitter, and how far it looks over the horizon.
    AngleSliver,
    /// The power of two that multiplies all lengths, and how far away the receiver is.
    ScaleDistance,
}

/// The kind of emission.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Emitted {
    /// 1 everywhere.
    Constant,
    /// 1, 2 and 4 at the vertices.
    Linear,
}

impl Emitted {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Constant, Self::Linear];

    /// Name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Constant => "constant",
            Self::Linear => "linear",
        }
    }

    fn record(self) -> EmissionRecord {
        match self {
            Self::Constant => EmissionRecord::Constant { constant: 1.0 },
            Self::Linear => EmissionRecord::Vertices { vertices: vec![1.0, 2.0, 4.0] },
        }
    }
}

/// One parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis {
    /// The quantity, with its unit.
    pub title: &'static str,
    /// The base of which the ends are exponents: 10 or 2.
    pub base: f64,
    /// Exponents at the ends.
    pub ends: [f64; 2],
}

impl Axis {
    const fn decades(title: &'static str, from: f64, to: f64) -> Self {
        Self { title, base: 10.0, ends: [from, to] }
    }

    /// The parameter at step `index` of `count`, both ends among them. Powers of two are whole ones, and exact.
    fn value(self, index: u32, count: u32) -> f64 {
        let [from, to] = self.ends;
        let exponent = from + (to - from) * f64::from(index) / f64::from((count - 1).max(1));
        if self.base == 2.0 {
            #[allow(clippy::cast_possible_truncation, reason = "a rounded exponent of a double is a small integer")]
            return power_of_two(exponent.round() as i64);
        }
        libm::pow(self.base, exponent)
    }
}

/// The triangle's corners: none of its sides along an axis.
const CORNERS: [DVec3; 3] = [DVec3::new(-0.45, -0.3, 0.0), DVec3::new(0.55, -0.25, 0.0), DVec3::new(-0.05, 0.6, 0.0)];

/// Towards which side of the emitter the receiver is.
const ASIDE: DVec3 = DVec3::new(0.8, 0.6, 0.0);

/// The vector that turns a normal away from the direction to the emitter, so that nothing is special about it.
const TILT: DVec3 = DVec3::new(0.21, -0.13, 0.17);

/// Where the receiver is when the distance is not a parameter.
const AT_HAND: f64 = 1.5;

impl Plane {
    /// All.
    pub const ALL: [Self; 4] = [Self::DistanceHeight, Self::AngleWidth, Self::AngleSliver, Self::ScaleDistance];

    /// Name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::DistanceHeight => "distance-height",
            Self::AngleWidth => "angle-width",
            Self::AngleSliver => "angle-sliver",
            Self::ScaleDistance => "scale-distance",
        }
    }

    /// Its two axes.
    #[must_use]
    pub const fn axes(self) -> [Axis; 2] {
        match self {
            Self::DistanceHeight => [
                Axis::decades("distance aside (emitter sizes)", -3.0, 8.0),
                Axis::decades("height over its plane (sizes)", -12.0, 4.0),
            ],
            Self::AngleWidth => [
                Axis::decades("angle over the emitter's plane (rad)", -10.0, 0.0),
                Axis::decades("width of the needle (lengths)", -8.0, 0.0),
            ],
            Self::AngleSliver => [
                Axis::decades("angle over the emitter's plane (rad)", -8.0, 0.0),
                Axis::decades("visible above the horizon (rad)", -10.0, -1.0),
            ],
            Self::ScaleDistance => [
                Axis { title: "scale (factor on all lengths)", base: 2.0, ends: [-900.0, 900.0] },
                Axis::decades("distance (emitter sizes)", -6.0, 6.0),
            ],
        }
    }

    /// The parameters of a point of a grid.
    #[must_use]
    pub fn values(self, [column, row]: [u32; 2], [columns, rows]: [u32; 2]) -> [f64; 2] {
        let [x, y] = self.axes();
        [x.value(column, columns), y.value(row, rows)]
    }

    /// The case at a point.
    #[must_use]
    pub fn case(self, emitted: Emitted, [x, y]: [f64; 2]) -> Case {
        let (corners, position, normal) = match self {
            Self::DistanceHeight => {
                let position = middle(CORNERS) + ASIDE * x + DVec3::Z * y;
                (CORNERS, position, toward(position, CORNERS))
            }
            Self::AngleWidth => {
                let needle = [DVec3::new(-0.5, -0.125 * y, 0.0), DVec3::new(0.5, 0.0, 0.0), DVec3::new(0.125, y, 0.0)];
                let position = middle(needle) + over(x);
                (needle, position, toward(position, needle))
            }
            Self::AngleSliver => {
                let position = middle(CORNERS) + over(x);
                (CORNERS, position, horizon_below(position, CORNERS, y))
            }
            Self::ScaleDistance => {
                let position = middle(CORNERS) + DVec3::new(0.48, 0.36, 0.8) * y;
                (CORNERS.map(|corner| corner * x), position * x, toward(position, CORNERS))
            }
        };
        Case {
            id: Id::Text(format!("{} {} {x:.4e} {y:.4e}", self.name(), emitted.name())),
            receiver: ReceiverRecord { position: position.to_array(), normal: normal.to_array(), reflectance: 1.0 },
            emitter: EmitterRecord { vertices: corners.map(|v| v.to_array()).to_vec(), emission: emitted.record() },
            occluders: Vec::new(),
            tolerance: radgrad_core::DEFAULT_TOLERANCE,
            precision: 0.0,
        }
    }
}

fn middle(corners: [DVec3; 3]) -> DVec3 {
    (corners[0] + corners[1] + corners[2]) / 3.0
}

/// The offset to where the emitter's middle is seen at that angle over its plane.
fn over(angle: f64) -> DVec3 {
    (ASIDE * libm::cos(angle) + DVec3::Z * libm::sin(angle)) * AT_HAND
}

/// A normal that looks at the emitter, a little askew.
fn toward(position: DVec3, corners: [DVec3; 3]) -> DVec3 {
    unit(middle(corners) - position) + TILT
}

/// A normal over whose horizon one corner of the emitter looks by a small angle, the others lying below or lower.
fn horizon_below(position: DVec3, corners: [DVec3; 3], angle: f64) -> DVec3 {
    // Seen from that side the second corner is the outermost.
    let corner = unit(corners[1] - position);
    let inward = middle(corners) - position;
    let across = unit(inward - corner * inward.dot(corner));
    corner * libm::sin(angle) - across * libm::cos(angle)
}

fn unit(v: DVec3) -> DVec3 {
    v / v.length()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_of_the_axes_are_points_of_a_grid() {
        let values = |place| Plane::DistanceHeight.values(place, [3, 5]);
        assert!((values([0, 0])[0] / 1e-3 - 1.0).abs() < 1e-14 && (values([2, 4])[1] / 1e4 - 1.0).abs() < 1e-14);
        assert_eq!(Plane::ScaleDistance.values([0, 0], [3, 3])[0], power_of_two(-900));
    }

    #[test]
    fn heights_are_exact_and_scales_change_no_digit() {
        let position = |plane: Plane, at| DVec3::from_array(plane.case(Emitted::Linear, at).receiver.position);
        assert_eq!(position(Plane::DistanceHeight, [2.0, 1e-12]).z, 1e-12);
        let one = position(Plane::ScaleDistance, [1.0, 3.0]);
        assert_eq!(position(Plane::ScaleDistance, [power_of_two(-900), 3.0]), one * power_of_two(-900));
    }
}
