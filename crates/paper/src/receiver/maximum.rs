//! Where on a receiver an emitter gives most light.
//!
//! On a plane, a single convex emitter of constant radiosity has one maximum and no other (G. Drettakis and E. Fiume 1993; HS95
//! 3.2). Newton's method finds where the tangential gradient is zero, with the second derivatives of `radgrad-core`; where these
//! are not those of a maximum beyond their bound, it climbs along the gradient. A step that leaves the receiver ends at its edge,
//! and goes on along it. Steps are halved until the radiosity rises (L. Armijo 1966), so that the search ends at a maximum, local
//! if the emitter is concave or its emission not constant.
//!
//! The place is good to about 1e-9 of the receiver's size where the maximum is a smooth one. Where emitter and receiver touch,
//! the largest value is a limit at the contact, and the place returned is next to it.

use radgrad_core::{DVec3, Emission, Emitter, Error as CoreError, Polygon, Receiver, evaluate_to, hessian_to};
use radgrad_scene::{largest, smallest, triangulate};

use crate::error::Error;

const MOST_STEPS: usize = 200;
const MOST_HALVINGS: usize = 50;
const TOLERANCE: f64 = 1e-11;

/// Steps shorter than this fraction of the receiver's size are not taken any more.
const SHORTEST: f64 = 1e-9;

/// A point is on an edge within this fraction of the size.
const ON_EDGE: f64 = 1e-13;

/// The brightest place of a receiver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Maximum {
    /// Where.
    pub position: DVec3,
    /// Radiosity there for a reflectance of 1, in the unit of the emission.
    pub value: f64,
    /// Gradient there within the receiver's plane: zero to rounding inside, outward on the boundary.
    pub slope: DVec3,
}

/// The point of a receiver to which an emitter gives most, nothing being between; `None` if it gives nothing at all. A concave
/// receiver is searched triangle by triangle.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon};
/// use radgrad_paper::receiver::brightest;
/// let point = |x, y, z| DVec3::new(x, y, z);
/// let floor = Polygon::new(vec![point(0.0, 0.0, 0.0), point(4.0, 0.0, 0.0), point(4.0, 3.0, 0.0), point(0.0, 3.0, 0.0)])?;
/// let lamp = Polygon::new(vec![point(1.0, 0.5, 1.0), point(1.0, 1.5, 1.0), point(2.0, 1.5, 1.0), point(2.0, 0.5, 1.0)])?;
/// let lamp = Emitter::new(lamp, Emission::Constant(1.0))?;
/// let maximum = brightest(&floor, &lamp)?.expect("the lamp lights the floor");
/// assert!((maximum.position - point(1.5, 1.0, 0.0)).length() < 1e-9, "below its centre");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If a radiosity over- or underflows.
pub fn brightest(receiver: &Polygon, emitter: &Emitter) -> Result<Option<Maximum>, Error> {
    let vertices = receiver.vertices();
    let pieces = if is_convex(vertices, receiver.normal()) {
        vec![vertices.to_vec()]
    } else {
        let triangles = triangulate(vertices).unwrap_or_default();
        triangles.into_iter().map(|corners| corners.map(|i| vertices[i]).to_vec()).collect()
    };
    let mut best: Option<Maximum> = None;
    for corners in pieces {
        let maximum = Search::new(&corners, receiver, emitter).climb()?;
        best = [best, maximum].into_iter().flatten().max_by(|a, b| a.value.total_cmp(&b.value));
    }
    Ok(best)
}

fn is_convex(vertices: &[DVec3], normal: DVec3) -> bool {
    let count = vertices.len();
    let edge = |i: usize| vertices[(i + 1) % count] - vertices[i % count];
    (0..count).all(|i| normal.dot(edge(i).cross(edge(i + 1))) >= 0.0)
}

/// An edge of the receiver: a point of it, its direction and the direction out of the receiver, both of length 1.
struct Side {
    corner: DVec3,
    along: DVec3,
    outward: DVec3,
}

struct Search<'a> {
    corners: &'a [DVec3],
    sides: Vec<Side>,
    normal: DVec3,
    size: f64,
    emitter: &'a Emitter,
}

/// Value and gradient within the plane at a point.
#[derive(Clone, Copy)]
struct Place {
    point: DVec3,
    value: f64,
    slope: DVec3,
}

impl<'a> Search<'a> {
    fn new(corners: &'a [DVec3], receiver: &Polygon, emitter: &'a Emitter) -> Self {
        let normal = receiver.normal();
        let side = |i: usize| {
            let along = (corners[(i + 1) % corners.len()] - corners[i]).normalize();
            Side { corner: corners[i], along, outward: along.cross(normal) }
        };
        Self { sides: (0..corners.len()).map(side).collect(), corners, normal, size: receiver.size(), emitter }
    }

    fn sample(&self, point: DVec3) -> Result<Place, Error> {
        let refused = |source| Error::Sample { position: point, source };
        let receiver = Receiver::new(point, self.normal, 1.0).map_err(refused)?;
        let answer = evaluate_to(&receiver, self.emitter, &[], TOLERANCE).map_err(refused)?;
        Ok(Place { point, value: answer.radiosity, slope: answer.gradient.reject_from_normalized(self.normal) })
    }

    /// `d B'' d` and the like in the plane: the second derivatives along two directions of it, and mixed, with a bound on the
    /// error of each.
    fn curvature(&self, point: DVec3, [u, v]: [DVec3; 2]) -> Result<([f64; 3], f64), Error> {
        let refused = |source: CoreError| Error::Sample { position: point, source };
        if matches!(self.emitter.emission(), Emission::Constant(_)) {
            let receiver = Receiver::new(point, self.normal, 1.0).map_err(refused)?;
            let hessian = hessian_to(&receiver, self.emitter, &[], 1e-6).map_err(refused)?;
            let second_derivative = |a: DVec3, b: DVec3| a.dot(hessian.matrix * b);
            return Ok(([second_derivative(u, u), second_derivative(v, v), second_derivative(u, v)], hessian.error));
        }
        // No closed form: differences of gradients, good to about 1e-6 of their size.
        let step = 1e-4 * self.size;
        let change = |d: DVec3| {
            Ok::<_, Error>((self.sample(point + step * d)?.slope - self.sample(point - step * d)?.slope) / (2.0 * step))
        };
        let (along_u, along_v) = (change(u)?, change(v)?);
        Ok(([along_u.dot(u), along_v.dot(v), 0.5 * (along_u.dot(v) + along_v.dot(u))], 0.0))
    }

    fn climb(&self) -> Result<Option<Maximum>, Error> {
        let centre = self.corners.iter().sum::<DVec3>() / self.corners.len() as f64;
        let of_emitter = self.emitter.polygon().vertices();
        let above = of_emitter.iter().sum::<DVec3>() / of_emitter.len() as f64;
        // In the light there is a corner, if anything is: B > 0 on one side of the emitter's plane.
        let mut here = self.sample(centre)?;
        for point in self.corners.iter().copied().chain([self.nearest(above)]) {
            let there = self.sample(point)?;
            if there.value > here.value {
                here = there;
            }
        }
        if here.value <= 0.0 {
            return Ok(None);
        }
        for _ in 0..MOST_STEPS {
            let Some(step) = self.step(&here)? else { break };
            let gain = here.slope.dot(step);
            if step.length() <= SHORTEST * self.size || gain <= 1e-13 * here.value {
                // Too little to be seen in values: the last steps of Newton's method need no comparison.
                let there = self.sample(here.point + step)?;
                if there.slope.length() < here.slope.length() && there.value > 0.0 {
                    here = there;
                    continue;
                }
                break;
            }
            let halves = std::iter::successors(Some(1.0), |s| Some(0.5 * s)).take(MOST_HALVINGS);
            let mut risen = None;
            for part in halves {
                let there = self.sample(here.point + part * step)?;
                if there.value >= here.value + 1e-4 * part * gain {
                    risen = Some(there);
                    break;
                }
            }
            let Some(there) = risen else { break };
            let stalled = there.value - here.value <= 1e-10 * here.value && gain > 1e-6 * here.value;
            here = there;
            if stalled {
                break;
            }
        }
        Ok(Some(Maximum { position: here.point, value: here.value, slope: here.slope }))
    }

    /// The step to take from here, within the receiver; `None` where every way is downward or out of it.
    fn step(&self, here: &Place) -> Result<Option<DVec3>, Error> {
        let (u, v) = self.normal.any_orthonormal_pair();
        let ([uu, vv, uv], error) = self.curvature(here.point, [u, v])?;
        let (g, h) = (here.slope.dot(u), here.slope.dot(v));
        let climb = here.slope.normalize_or_zero() * self.size;
        let determinant = uu * vv - uv * uv;
        let surely_a_maximum = uu + vv < -2.0 * error && determinant > error * (uu.abs() + vv.abs() + 2.0 * uv.abs());
        let free =
            if surely_a_maximum { u * ((uv * h - vv * g) / determinant) + v * ((uv * g - uu * h) / determinant) } else { climb };
        let touched: Vec<&Side> = self.sides.iter().filter(|s| self.room(s, here.point) <= ON_EDGE * self.size).collect();
        let feasible = |step: DVec3| touched.iter().all(|side| step.dot(side.outward) <= 1e-9 * step.length());
        let inside = |step: DVec3| if step.length() > 0.0 { Some(self.cut(here.point, step)) } else { None };
        if feasible(free) {
            return Ok(inside(free));
        }
        let ways = touched.iter().flat_map(|side| [side.along, -side.along]).filter(|&way| feasible(way));
        let Some(way) = ways.max_by(|a, b| a.dot(here.slope).total_cmp(&b.dot(here.slope))) else { return Ok(None) };
        let rise = here.slope.dot(way);
        if rise <= 0.0 {
            return Ok(None);
        }
        let ([bend, ..], error) = self.curvature(here.point, [way, way.cross(self.normal)])?;
        let length = if bend < -error { -rise / bend } else { self.size };
        Ok(inside(way * length))
    }

    /// Distance from a side, inward.
    fn room(&self, side: &Side, point: DVec3) -> f64 {
        side.outward.dot(side.corner - point)
    }

    /// A step, cut where it would leave the receiver.
    fn cut(&self, from: DVec3, step: DVec3) -> DVec3 {
        let part = |side: &Side| {
            let outward = step.dot(side.outward);
            if outward > 1e-9 * step.length() { largest(self.room(side, from) / outward, 0.0) } else { 1.0 }
        };
        step * self.sides.iter().map(part).fold(1.0, smallest)
    }

    /// The point of the receiver that is nearest to the foot of another point.
    fn nearest(&self, point: DVec3) -> DVec3 {
        let foot = point - self.normal * self.normal.dot(point - self.corners[0]);
        if self.sides.iter().all(|side| self.room(side, foot) >= 0.0) {
            return foot;
        }
        let on_side = |(i, side): (usize, &Side)| {
            let length = (self.corners[(i + 1) % self.corners.len()] - side.corner).length();
            side.corner + side.along * (foot - side.corner).dot(side.along).clamp(0.0, length)
        };
        let nearest = self.sides.iter().enumerate().map(on_side);
        nearest.min_by(|a, b| (*a - foot).length().total_cmp(&(*b - foot).length())).unwrap_or(foot)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polygon(points: &[[f64; 3]]) -> Polygon {
        Polygon::new(points.iter().map(|&p| p.into()).collect()).unwrap()
    }

    fn lamp(points: &[[f64; 3]]) -> Emitter {
        Emitter::new(polygon(points), Emission::Constant(1.0)).unwrap()
    }

    /// The largest radiosity on a grid of the rectangle [x0, x1] x [y0, y1] at z = 0.
    fn on_grid(x: [f64; 2], y: [f64; 2], emitter: &Emitter) -> f64 {
        let n = 200;
        let coordinate = |[low, high]: [f64; 2], i: i32| low + (high - low) * f64::from(i) / f64::from(n);
        let value = |i, j| {
            let receiver = Receiver::new(DVec3::new(coordinate(x, i), coordinate(y, j), 0.0), DVec3::Z, 1.0).unwrap();
            radgrad_core::radiosity(&receiver, emitter).unwrap()
        };
        (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))).map(|(i, j)| value(i, j)).fold(0.0, largest)
    }

    #[test]
    fn nothing_on_a_grid_is_brighter_than_the_maximum() {
        let floor = polygon(&[[-2.0, -2.0, 0.0], [3.0, -2.0, 0.0], [3.0, 2.0, 0.0], [-2.0, 2.0, 0.0]]);
        let lamps = [
            lamp(&[[0.0, 0.0, 0.1], [0.1, 0.3, 0.1], [0.4, 0.1, 0.15]]),
            lamp(&[[0.0, 0.0, 1.0], [0.2, 1.0, 1.4], [1.2, 1.1, 0.9]]),
            lamp(&[[2.0, 1.9, 0.02], [2.0, 2.4, 0.02], [2.4, 2.4, 0.02], [2.4, 1.9, 0.02]]),
            lamp(&[[5.0, 5.0, 1.0], [5.0, 7.0, 1.0], [7.0, 7.0, 1.0], [7.0, 5.0, 1.0]]),
            lamp(&[[0.0, -1.0, 0.1], [0.0, 1.0, 0.1], [0.0, 1.0, 1.0], [0.0, -1.0, 1.0]]),
        ];
        for (index, emitter) in lamps.iter().enumerate() {
            let maximum = brightest(&floor, emitter).unwrap().unwrap();
            let grid = on_grid([-2.0, 3.0], [-2.0, 2.0], emitter);
            assert!(maximum.value >= grid && maximum.value < 1.05 * grid, "{index}: {maximum:?} {grid}");
            let p = maximum.position;
            assert!(p.x >= -2.0 - 1e-12 && p.x <= 3.0 + 1e-12 && p.y.abs() <= 2.0 + 1e-12, "{index}: {maximum:?}");
            let inside = p.x > -1.99 && p.x < 2.99 && p.y.abs() < 1.99;
            assert!(!inside || maximum.slope.length() <= 1e-8 * maximum.value, "{index}: {maximum:?}");
        }
    }

    #[test]
    fn a_receiver_behind_or_below_has_no_brightest_place() {
        let floor = polygon(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        let upward = lamp(&[[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]]);
        let under = lamp(&[[0.0, 0.0, -1.0], [1.0, 0.0, -1.0], [0.0, 1.0, -1.0]]);
        for emitter in [upward, under] {
            assert_eq!(brightest(&floor, &emitter).unwrap(), None);
        }
    }

    #[test]
    fn a_concave_receiver_has_its_maximum_in_the_right_arm() {
        let l = polygon(&[[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [3.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0, 3.0, 0.0], [0.0, 3.0, 0.0]]);
        let emitter = lamp(&[[0.25, 2.0, 0.5], [0.25, 2.5, 0.5], [0.75, 2.5, 0.5], [0.75, 2.0, 0.5]]);
        let maximum = brightest(&l, &emitter).unwrap().unwrap();
        assert!((maximum.position - DVec3::new(0.5, 2.25, 0.0)).length() < 1e-7, "{maximum:?}");
    }
}
