//! A segment as seen from the receiver, drawn uniformly in the angle it subtends.
//!
//! The line integrals of the gradient go like `1/r^3` along an edge: uniform in its length, nearly every sample of an edge that
//! passes close would miss the part that counts. Uniform in angle the density is `1/r^2` over `int dl/r^2 = angle / distance of
//! the line = |e| / (|a| |b|) (angle / sin angle)`, for a segment `e` from `a` to `b`, which keeps its digits for an edge seen
//! end-on. A place is a pair of weights of the two ends, each with its digits: an end 1e-12 as far as the other is approached
//! as well as any.

/// The angle and the ends' distances.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Arc {
    distances: [f64; 2],
    angle: f64,
    /// `int dl/r^2` along the segment.
    pub(crate) measure: f64,
}

impl Arc {
    /// The arc given by the ends' distances, their dot product, the length of the segment and that of the ends' cross product.
    pub(crate) fn new(distances: [f64; 2], dot: f64, length: f64, cross: f64) -> Self {
        let angle = libm::atan2(cross, dot);
        let product = distances[0] * distances[1];
        let bend = if cross > 0.0 { angle * product / cross } else { 1.0 };
        Self { distances, angle, measure: length / product * bend }
    }

    /// Weights of the two ends, of sum 1, for the place that has the fraction `v` of the angle behind it.
    pub(crate) fn weights(&self, v: f64) -> [f64; 2] {
        let [start, end] = [1.0 - v, v].map(|part| if self.angle > 0.0 { libm::sin(part * self.angle) } else { part });
        let [start, end] = [start / self.distances[0], end / self.distances[1]];
        [start / (start + end), end / (start + end)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn arc(a: DVec3, b: DVec3) -> Arc {
        Arc::new([a.length(), b.length()], a.dot(b), (b - a).length(), a.cross(b).length())
    }

    #[test]
    fn the_fraction_is_that_of_the_angle() {
        for (a, b) in [(DVec3::new(1.0, 0.0, 1.0), DVec3::new(-3.0, 2.0, 1.0)), (DVec3::X * 1e-12, DVec3::new(1e-12, 1.0, 0.0))] {
            let whole = arc(a, b);
            for v in [0.0, 0.1, 0.5, 1.0] {
                let [start, end] = whole.weights(v);
                let direction = a * start + b * end;
                assert!((a.angle_between(direction) - v * whole.angle).abs() < 1e-7, "{v}: {direction}");
                assert!((start + end - 1.0).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn the_measure_is_the_integral_of_the_inverse_square() {
        let (a, b) = (DVec3::new(0.5, -1.0, 0.25), DVec3::new(0.25, 2.0, 1.0));
        let count = 1000;
        let squared = |i: i32| a.lerp(b, (f64::from(i) + 0.5) / f64::from(count)).length_squared();
        let sum: f64 = (0..count).map(|i| (b - a).length() / f64::from(count) / squared(i)).sum();
        assert!((arc(a, b).measure / sum - 1.0).abs() < 1e-5);
        // End-on, from 1 to 3: 1 - 1/3.
        assert!((arc(DVec3::X, DVec3::X * 3.0).measure - 2.0 / 3.0).abs() < 1e-15);
    }
}
