//! Patches: surfaces over a rectangle of parameters, with their position, normal and element of area.
//!
//! Parameters u and v run over [0, 1] each. With the tangents `x_u`, `x_v` the element of area is `|x_u x x_v| du dv`; light is
//! given and taken on the side of the unit normal. A polygon has no parameters of its own: it is cut into parallelograms and
//! triangles, each the image of the square, a triangle by `(u, v) -> (u, (1 - u) v)`.

use std::f64::consts::{PI, TAU};

use radgrad_core::{DVec3, Polygon};

use crate::error::Error;

/// On which side a closed surface gives and takes light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Towards its centre or axis.
    Inside,
    /// Away from it.
    Outside,
}

/// A surface over parameters.
///
/// ```
/// use radgrad_core::DVec3;
/// use radgrad_curved::{Patch, Side};
/// let tube = Patch::cylinder(DVec3::ZERO, 2.0 * DVec3::Z, 0.1, DVec3::X, [0.0, std::f64::consts::TAU], Side::Outside)?;
/// let dome = Patch::sphere(DVec3::ZERO, 5.0, [0.0, std::f64::consts::FRAC_PI_2], [0.0, std::f64::consts::TAU], Side::Inside)?;
/// # let _ = (tube, dome);
/// # Ok::<(), radgrad_curved::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Patch(pub(crate) Form);

#[derive(Debug, Clone)]
pub(crate) enum Form {
    Polygon(Polygon),
    Sphere(Sphere),
    Cylinder(Cylinder),
    /// Corners at (0,0), (1,0), (1,1), (0,1).
    Bilinear([DVec3; 4]),
    /// Control points: `u` changes along a row, `v` from row to row.
    Bezier(Box<[[DVec3; 4]; 4]>),
}

/// `x = c + R (sin p cos a, sin p sin a, cos p)`, with the polar angle p along v and the azimuth a along u.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sphere {
    pub(crate) centre: DVec3,
    pub(crate) radius: f64,
    pub(crate) polar: [f64; 2],
    pub(crate) azimuth: [f64; 2],
    pub(crate) outwards: bool,
}

/// `x = base + R (zero cos a + quarter sin a) + v axis`, with the azimuth a along u.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cylinder {
    pub(crate) base: DVec3,
    pub(crate) axis: DVec3,
    pub(crate) radius: f64,
    pub(crate) zero: DVec3,
    pub(crate) quarter: DVec3,
    pub(crate) azimuth: [f64; 2],
    pub(crate) outwards: bool,
}

/// A point of a patch.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Spot {
    pub(crate) point: DVec3,
    /// Unit length, or zero where the patch has none.
    pub(crate) normal: DVec3,
    /// Area over that of the parameters.
    pub(crate) area: f64,
    pub(crate) at: [f64; 2],
}

fn refused(what: &'static str, rule: String) -> Error {
    Error::Patch { what, rule }
}

/// Whether angles rise by no more than a turn, or half a one.
fn range(name: &'static str, [from, to]: [f64; 2], low: f64, high: f64) -> Result<(), Error> {
    let fits = from < to && to - from <= high * (1.0 + 1e-15) && from.is_finite() && from >= low;
    let rule = || format!("angles from {from} to {to}: they must rise, from {low} or more, by no more than {high}");
    if fits { Ok(()) } else { Err(refused(name, rule())) }
}

fn length(name: &'static str, value: f64) -> Result<(), Error> {
    let fits = value.is_finite() && value > 0.0;
    if fits { Ok(()) } else { Err(refused(name, format!("its radius is {value}: it must be above 0 and finite"))) }
}

fn finite(name: &'static str, points: &[DVec3]) -> Result<(), Error> {
    match points.iter().find(|p| !p.is_finite()) {
        None => Ok(()),
        Some(p) => Err(refused(name, format!("one of its points is {p}: it must be finite"))),
    }
}

impl Patch {
    /// A planar polygon.
    #[must_use]
    pub const fn polygon(polygon: Polygon) -> Self {
        Self(Form::Polygon(polygon))
    }

    /// A part of a sphere: polar angles, measured from the direction of z, within [0, pi], and azimuths around z from x, over no
    /// more than a turn.
    ///
    /// # Errors
    /// If the radius or an angle is out of range.
    pub fn sphere(centre: DVec3, radius: f64, polar: [f64; 2], azimuth: [f64; 2], side: Side) -> Result<Self, Error> {
        finite("sphere", &[centre])?;
        length("sphere", radius)?;
        range("sphere", polar, 0.0, PI - polar[0])?;
        range("sphere", azimuth, f64::MIN, TAU)?;
        Ok(Self(Form::Sphere(Sphere { centre, radius, polar, azimuth, outwards: side == Side::Outside })))
    }

    /// A whole sphere.
    ///
    /// # Errors
    /// As [`Self::sphere`].
    pub fn whole_sphere(centre: DVec3, radius: f64, side: Side) -> Result<Self, Error> {
        Self::sphere(centre, radius, [0.0, PI], [0.0, TAU], side)
    }

    /// A part of the wall of a circular cylinder from the circle around `base` to that around `base + axis`, with azimuths
    /// measured from the direction of `zero`.
    ///
    /// # Errors
    /// If the radius or an angle is out of range, or `axis` is zero or along `zero`.
    pub fn cylinder(base: DVec3, axis: DVec3, radius: f64, zero: DVec3, azimuth: [f64; 2], side: Side) -> Result<Self, Error> {
        finite("cylinder", &[base, axis, zero])?;
        length("cylinder", radius)?;
        range("cylinder", azimuth, f64::MIN, TAU)?;
        let along = axis.try_normalize().ok_or_else(|| refused("cylinder", "its axis is zero".to_owned()))?;
        let across = (zero - along * zero.dot(along)).try_normalize();
        let zero = across.ok_or_else(|| refused("cylinder", format!("azimuths begin along the axis, at {zero}")))?;
        let outwards = side == Side::Outside;
        Ok(Self(Form::Cylinder(Cylinder { base, axis, radius, zero, quarter: along.cross(zero), azimuth, outwards })))
    }

    /// The bilinear surface with these corners, which gives and takes light on the side from which they are counter-clockwise.
    ///
    /// # Errors
    /// If a corner is not finite.
    pub fn bilinear(corners: [DVec3; 4]) -> Result<Self, Error> {
        finite("bilinear patch", &corners)?;
        Ok(Self(Form::Bilinear(corners)))
    }

    /// The bicubic Bezier surface of these control points, `u` along rows and `v` from row to row, which gives and takes light on
    /// the side of `x_u x x_v`.
    ///
    /// # Errors
    /// If a point is not finite.
    pub fn bezier(control: [[DVec3; 4]; 4]) -> Result<Self, Error> {
        finite("Bezier patch", control.as_flattened())?;
        Ok(Self(Form::Bezier(Box::new(control))))
    }

    /// Largest value of `direction . x` over the patch, or one above it.
    pub(crate) fn farthest_along(&self, direction: DVec3) -> f64 {
        let largest = |points: &[DVec3]| points.iter().map(|p| direction.dot(*p)).fold(f64::NEG_INFINITY, f64::max);
        match &self.0 {
            Form::Polygon(polygon) => largest(polygon.vertices()),
            Form::Sphere(s) => {
                // Of the azimuths the best one is the same at each polar angle.
                let around = farthest_on_arc(s.azimuth, [direction.x, direction.y]);
                direction.dot(s.centre) + s.radius * farthest_on_arc(s.polar, [direction.z, around])
            }
            Form::Cylinder(c) => {
                let around = farthest_on_arc(c.azimuth, [direction.dot(c.zero), direction.dot(c.quarter)]);
                largest(&[c.base, c.base + c.axis]) + c.radius * around
            }
            Form::Bilinear(corners) => largest(corners),
            Form::Bezier(control) => largest(control.as_flattened()),
        }
    }

    /// About the smaller of its widths.
    pub(crate) fn width(&self) -> f64 {
        let of_outline = |points: &[DVec3], area: f64| {
            let longest = points.iter().flat_map(|p| points.iter().map(|q| (*p - *q).length())).fold(0.0, f64::max);
            area / longest
        };
        match &self.0 {
            Form::Polygon(polygon) => of_outline(polygon.vertices(), polygon.area()),
            Form::Sphere(s) => s.radius * span(s.polar).min(span(s.azimuth)).min(2.0),
            Form::Cylinder(c) => (c.radius * span(c.azimuth).min(2.0)).min(c.axis.length()),
            Form::Bilinear([a, b, c, d]) => of_outline(&[*a, *b, *c, *d], 0.5 * (*c - *a).cross(*d - *b).length()),
            // These hide nothing.
            Form::Bezier(_) => f64::INFINITY,
        }
    }

    /// Largest length of the part of `x - centre` across a direction, or one above it; across no direction, of all of it.
    pub(crate) fn farthest_from(&self, centre: DVec3, along: DVec3) -> f64 {
        let across = |p: DVec3| (p - centre - along * along.dot(p - centre)).length();
        let largest = |points: &[DVec3]| points.iter().map(|&p| across(p)).fold(0.0, f64::max);
        match &self.0 {
            Form::Polygon(polygon) => largest(polygon.vertices()),
            Form::Sphere(s) => across(s.centre) + s.radius,
            Form::Cylinder(c) => largest(&[c.base, c.base + c.axis]) + c.radius,
            Form::Bilinear(corners) => largest(corners),
            Form::Bezier(control) => largest(control.as_flattened()),
        }
    }

    /// The point at parameters; of a polygon see [`radgrad_solver::Element`].
    pub(crate) fn spot(&self, at: [f64; 2]) -> Spot {
        let [u, v] = at;
        let (point, along, across) = match &self.0 {
            Form::Polygon(polygon) => return Spot { point: polygon.vertices()[0], normal: polygon.normal(), area: 0.0, at },
            Form::Sphere(s) => return s.spot(at),
            Form::Cylinder(c) => return c.spot(at),
            Form::Bilinear([a, b, c, d]) => {
                let twist = *a - *b + *c - *d;
                (*a + (*b - *a) * u + (*d - *a) * v + twist * (u * v), *b - *a + twist * v, *d - *a + twist * u)
            }
            Form::Bezier(control) => {
                let (b, d) = ([bernstein(u), bernstein(v)], [slopes(u), slopes(v)]);
                let sum = |of_u: [f64; 4], of_v: [f64; 4]| {
                    let row = |row: &[DVec3; 4]| row.iter().zip(of_u).map(|(p, w)| *p * w).sum::<DVec3>();
                    control.iter().zip(of_v).map(|(r, w)| row(r) * w).sum::<DVec3>()
                };
                (sum(b[0], b[1]), sum(d[0], b[1]), sum(b[0], d[1]))
            }
        };
        let across = along.cross(across);
        let area = across.length();
        let normal = across.try_normalize().unwrap_or(DVec3::ZERO);
        Spot { point, normal, area, at }
    }
}

impl Sphere {
    fn spot(&self, at: [f64; 2]) -> Spot {
        let [azimuth, polar] = [between(self.azimuth, at[0]), between(self.polar, at[1])];
        let (sin, cos) = (libm::sin(polar), libm::cos(polar));
        let outwards = DVec3::new(sin * libm::cos(azimuth), sin * libm::sin(azimuth), cos);
        let area = self.radius * self.radius * sin.abs() * span(self.azimuth) * span(self.polar);
        let normal = if self.outwards { outwards } else { -outwards };
        Spot { point: self.centre + outwards * self.radius, normal, area, at }
    }

    /// Whether a point of the whole sphere is on this part.
    pub(crate) fn holds(&self, point: DVec3) -> bool {
        let r = point - self.centre;
        let polar = libm::acos((r.z / self.radius).clamp(-1.0, 1.0));
        (self.polar[0]..=self.polar[1]).contains(&polar) && turned_within(self.azimuth, libm::atan2(r.y, r.x))
    }
}

impl Cylinder {
    fn spot(&self, at: [f64; 2]) -> Spot {
        let azimuth = between(self.azimuth, at[0]);
        let outwards = self.zero * libm::cos(azimuth) + self.quarter * libm::sin(azimuth);
        let normal = if self.outwards { outwards } else { -outwards };
        let area = self.radius * span(self.azimuth) * self.axis.length();
        Spot { point: self.base + outwards * self.radius + self.axis * at[1], normal, area, at }
    }

    /// The part of a vector across the axis.
    pub(crate) fn across(&self, r: DVec3) -> DVec3 {
        r - self.axis * (self.axis.dot(r) / self.axis.length_squared())
    }

    /// Whether a point of the infinite cylinder is on this part.
    pub(crate) fn holds(&self, point: DVec3) -> bool {
        let r = point - self.base;
        let along = self.axis.dot(r) / self.axis.length_squared();
        (0.0..=1.0).contains(&along) && turned_within(self.azimuth, libm::atan2(r.dot(self.quarter), r.dot(self.zero)))
    }
}

fn between([from, to]: [f64; 2], part: f64) -> f64 {
    from + part * (to - from)
}

fn span([from, to]: [f64; 2]) -> f64 {
    to - from
}

/// Whether an angle, or one that is turns away from it, is in a range.
fn turned_within([from, to]: [f64; 2], angle: f64) -> bool {
    let above = (angle - from).rem_euclid(TAU);
    above <= to - from
}

/// Largest value of `x cos a + y sin a` over a range of angles.
fn farthest_on_arc(range: [f64; 2], [x, y]: [f64; 2]) -> f64 {
    if turned_within(range, libm::atan2(y, x)) {
        return libm::hypot(x, y);
    }
    let height = |angle: f64| x * libm::cos(angle) + y * libm::sin(angle);
    height(range[0]).max(height(range[1]))
}

/// Bernstein polynomials of degree 3.
fn bernstein(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t]
}

/// Their derivatives.
fn slopes(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [-3.0 * s * s, 3.0 * s * (s - 2.0 * t), 3.0 * t * (2.0 * s - t), 3.0 * t * t]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_and_areas_are_those_of_the_tangents() {
        let corners = [[0.0, 0.0, 0.3], [2.0, -0.5, -0.4], [1.5, 1.0, 0.5], [-0.2, 1.0, -0.2]].map(DVec3::from);
        let control = std::array::from_fn(|row: usize| {
            std::array::from_fn(|column: usize| {
                let [x, y] = [column, row].map(|i| i as f64);
                DVec3::new(x + 0.1 * y * y, y - 0.2 * x, 0.1 * x * x * y)
            })
        });
        let cylinder = |side| Patch::cylinder(DVec3::ONE, DVec3::new(0.5, 2.0, 1.0), 0.7, DVec3::X, [0.3, 4.0], side);
        let patches = [
            (Patch::sphere(DVec3::ONE, 1.7, [0.2, 3.0], [-1.0, 4.0], Side::Inside).unwrap(), 1.0),
            (Patch::sphere(DVec3::ONE, 1.7, [0.2, 3.0], [-1.0, 4.0], Side::Outside).unwrap(), -1.0),
            (cylinder(Side::Outside).unwrap(), 1.0),
            (cylinder(Side::Inside).unwrap(), -1.0),
            (Patch::bilinear(corners).unwrap(), 1.0),
            (Patch::bezier(control).unwrap(), 1.0),
        ];
        for (which, (patch, turn)) in patches.iter().enumerate() {
            for at in [[0.2, 0.3], [0.7, 0.9]] {
                let step = 1e-5;
                let along = |k: usize| {
                    let moved = |h: f64| patch.spot([0, 1].map(|i| at[i] + if i == k { h } else { 0.0 })).point;
                    (moved(step) - moved(-step)) / (2.0 * step)
                };
                let (across, spot) = (along(0).cross(along(1)), patch.spot(at));
                assert!((across.length() - spot.area).abs() < 1e-7, "{which}");
                assert!((across.normalize() * *turn - spot.normal).length() < 1e-7, "{which}: {across} {}", spot.normal);
                assert!(patch.farthest_along(spot.normal) >= spot.normal.dot(spot.point) - 1e-12);
                assert!(patch.farthest_from(DVec3::ZERO, DVec3::X) >= spot.point.with_x(0.0).length() - 1e-12);
                let far = patch.farthest_along(DVec3::new(1.0, -2.0, 0.5));
                assert!(far >= DVec3::new(1.0, -2.0, 0.5).dot(spot.point), "{which}");
            }
        }
    }
}
