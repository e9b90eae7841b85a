//! Which edges and vertices of the input lie on one line, decided exactly.
//!
//! Screens that share an edge, meet in a T-junction, continue each other, or stand on the emitter's edge leave nothing between
//! them. As doubles their edges are on one line, and no bound on a distance from it would ever say so.

use glam::DVec3;
use radgrad_numbers::exact::are_in_line;
use radgrad_numbers::power::normalising_power;

/// The end points of an edge of the input, in the order of their bits: the same for whoever shares the edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct EdgeName([[u64; 3]; 2]);

/// 2^-440: its digits end at 2^-492.
const SMALLEST: f64 = f64::from_bits((1023 - 440) << 52);

impl EdgeName {
    pub(crate) fn new(from: DVec3, to: DVec3) -> Self {
        // Adding zero makes -0 and 0 one.
        let [a, b] = [from, to].map(|p| (p + 0.0).to_array().map(f64::to_bits));
        Self(if a <= b { [a, b] } else { [b, a] })
    }

    pub(crate) fn ends(self) -> [DVec3; 2] {
        self.0.map(|bits| bits.map(f64::from_bits).into())
    }

    /// An end point that the two edges share.
    pub(crate) fn shared_end(self, other: Self) -> Option<DVec3> {
        self.0.iter().find(|end| other.0.contains(end)).map(|bits| bits.map(f64::from_bits).into())
    }

    /// Whether the two edges are exactly on one line.
    pub(crate) fn is_on_the_line_of(self, other: Self) -> bool {
        other.ends().into_iter().all(|end| self.is_in_line_with(end))
    }

    /// Whether the point is exactly on the line of the edge: it is, seen along each axis.
    pub(crate) fn is_in_line_with(self, point: DVec3) -> bool {
        let [a, b] = self.ends();
        let points = [a, b, point];
        if points[..2].contains(&points[2]) {
            return true;
        }
        let largest = points.iter().fold(0.0, |m: f64, p| m.max(p.abs().max_element()));
        let scaled = points.map(|p| p * normalising_power(largest));
        // Then products of two differences are multiples of 2^-984, and none is lost to underflow.
        let is_in_range = |c: f64| c == 0.0 || c.abs() >= SMALLEST;
        if !scaled.iter().all(|p| p.to_array().into_iter().all(is_in_range)) {
            return are_in_line(points);
        }
        [[0, 1], [1, 2], [2, 0]].into_iter().all(|[i, j]| {
            let [a, b, c] = scaled.map(|p| robust::Coord { x: p[i], y: p[j] });
            robust::orient2d(a, b, c) == 0.0
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn point(x: f64, y: f64, z: f64) -> DVec3 {
        DVec3::new(x, y, z)
    }

    #[test]
    fn a_name_has_no_direction_and_no_sign_of_zero() {
        let (a, b) = (point(0.0, 1.0, 2.0), point(-0.0, 3.0, 1.0));
        assert_eq!(EdgeName::new(a, b), EdgeName::new(b, point(-0.0, 1.0, 2.0)));
    }

    #[test]
    fn the_end_that_edges_share_is_found_whichever_it_is() {
        let [a, b, c] = [point(0.0, 1.0, 2.0), point(-1.0, 3.0, 1.0), point(4.0, 0.5, 0.0)];
        for (p, q) in [(EdgeName::new(a, b), EdgeName::new(b, c)), (EdgeName::new(b, a), EdgeName::new(c, b))] {
            assert_eq!((p.shared_end(q), q.shared_end(p)), (Some(b), Some(b)));
        }
        assert_eq!(EdgeName::new(a, b).shared_end(EdgeName::new(c, point(0.0, 1.0, 2f64.next_up()))), None);
    }

    #[test]
    fn edges_are_on_one_line_to_the_last_bit_or_not_at_all() {
        let edge = EdgeName::new(point(0.0, -1.0, 2.0), point(0.0, 1.0, 2.0));
        let part = |step: f64| EdgeName::new(point(0.0, -1.0, 2.0), point(step, 0.3, 2.0));
        assert!(edge.is_on_the_line_of(part(0.0)) && part(0.0).is_on_the_line_of(edge));
        assert!(!edge.is_on_the_line_of(part(f64::EPSILON)) && !edge.is_on_the_line_of(part(2f64.powi(-440))));
        assert!(!edge.is_on_the_line_of(EdgeName::new(point(0.125, -1.0, 2.0), point(0.125, 1.0, 2.0))), "beside it");
        assert!(edge.is_on_the_line_of(EdgeName::new(point(0.0, -1e-300, 2.0), point(0.0, 0.3, 2.0))));
        assert!(!edge.is_on_the_line_of(EdgeName::new(point(1e-300, 0.0, 2.0), point(0.0, 0.3, 2.0))));
        assert!(edge.is_in_line_with(point(0.0, 7.0, 2.0)) && !edge.is_in_line_with(point(0.0, 0.5, 2f64.next_up())));
    }

    #[test]
    fn scale_changes_nothing() {
        let (a, b) = (point(1.0, 2.0, 3.0), point(-1.0, 0.5, 2.0));
        let (c, d) = (a + (b - a) * 0.5, a + (b - a) * 4.0);
        for power in [2f64.powi(-900), 1.0, 2f64.powi(900)] {
            let edge = |a: DVec3, b: DVec3| EdgeName::new(a * power, b * power);
            assert!(edge(a, b).is_on_the_line_of(edge(c, d)));
            assert!(!edge(a, b).is_on_the_line_of(edge(c, d.with_z(d.z.next_up()))));
        }
    }
}
