//! The part of an element that a point sees past occluders: convex polygons in the element's own coordinates, for quadrature.
//!
//! In the coordinates (s, t) of an element's plane a plane through the point x is a line. The horizon keeps the side where
//! `n1.(y - x) > 0`. The shadow of a convex occluder is where `(a - x) x (b - x) . (y - x)` has the sign of its inside for all
//! edges a b; the occluder is first cut off at the element's plane, so that rays cross the rest of it before they reach the
//! element. A shadow is subtracted as the core does it: the parts outside its side k and inside its sides before k.
//!
//! All of it is in double precision. A line that is off by its rounding gives a strip of the element to the wrong side, at most
//! `2 delta / |gradient|` wide with delta the error of its function over the element; [`Visible::doubt`] is the sum of those
//! strips as a part of the area. An occluder level with the element or the horizon up to [`LEVEL`] hides nothing, as in the scene's
//! beams: planes are those of surfaces.

use radgrad_core::DVec3;
use radgrad_scene::{largest, smallest};

use crate::mesh::element::Element;
use crate::mesh::screen::LEVEL;
use crate::mesh::shape::Shape;

/// Corners that a part may have.
const MOST_CORNERS: usize = 16;

/// Parts beyond which the closed forms are cheaper.
const MOST_PARTS: usize = 1024;

/// The region that is looked at: the affine image of a reference shape.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Window<'a> {
    pub(crate) shape: Shape,
    /// The images of the shape's corners; the first one is that of the origin.
    pub(crate) vertices: &'a [DVec3],
    /// The images of the directions of s and t.
    pub(crate) axes: [DVec3; 2],
    pub(crate) normal: DVec3,
}

impl<'a> Window<'a> {
    /// An element, as the region that is looked at.
    pub(crate) fn on_element(element: &'a Element) -> Self {
        let polygon = element.polygon();
        Self { shape: element.shape(), vertices: polygon.vertices(), axes: element.axes(), normal: polygon.normal() }
    }
}

/// A convex polygon in reference coordinates.
#[derive(Debug, Clone, Copy)]
pub(crate) struct VisiblePart {
    corners: [[f64; 2]; MOST_CORNERS],
    count: usize,
}

/// The visible part of an element.
#[derive(Debug, Clone)]
pub(crate) struct Visible {
    /// Empty if nothing is, or if [`Self::whole`].
    pub(crate) parts: Vec<VisiblePart>,
    /// Whether nothing cuts the element.
    pub(crate) whole: bool,
    /// Bound on the part of the area that is taken for visible and is not, or the other way round.
    pub(crate) doubt: f64,
}

/// `c0 + c1 s + c2 t`, and a bound on its error over the element.
#[derive(Debug, Clone, Copy)]
struct Line {
    c: [f64; 3],
    error: f64,
}

impl Line {
    fn evaluate(&self, [s, t]: [f64; 2]) -> f64 {
        self.c[0] + self.c[1] * s + self.c[2] * t
    }

    /// The part of the element's area where its sign is not known.
    fn doubt(&self) -> f64 {
        // A chord of the unit square is at most sqrt(2) long; a triangle's area is half of that.
        4.0 * std::f64::consts::SQRT_2 * self.error / self.c[1].hypot(self.c[2])
    }

    /// The doubt, if a part is on the negative side.
    fn beside(&self, part: &VisiblePart) -> Option<f64> {
        let highest = part.corners().iter().map(|&c| self.evaluate(c)).fold(f64::NEG_INFINITY, largest);
        (highest <= self.error).then(|| if highest > -self.error { self.doubt() } else { 0.0 })
    }
}

impl VisiblePart {
    fn full(shape: Shape) -> Self {
        let mut part = Self { corners: [[0.0; 2]; MOST_CORNERS], count: 0 };
        let corners: &[[f64; 2]] = match shape {
            Shape::Parallelogram => &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
            Shape::Triangle => &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
        };
        corners.iter().for_each(|&corner| part.push(corner));
        part
    }

    fn push(&mut self, corner: [f64; 2]) {
        // A polygon of more corners is caught by `is_full`.
        if self.count < MOST_CORNERS {
            self.corners[self.count] = corner;
        }
        self.count += 1;
    }

    const fn is_full(&self) -> bool {
        self.count >= MOST_CORNERS
    }

    pub(crate) fn corners(&self) -> &[[f64; 2]] {
        &self.corners[..self.count.min(MOST_CORNERS)]
    }

    fn area(&self) -> f64 {
        let c = self.corners();
        let cross = |i: usize| (c[i][0] - c[0][0]) * (c[i + 1][1] - c[0][1]) - (c[i][1] - c[0][1]) * (c[i + 1][0] - c[0][0]);
        0.5 * (1..c.len().saturating_sub(1)).map(cross).sum::<f64>()
    }

    /// The part where the line is positive (`sign` 1) or negative (-1), if any.
    fn clipped(&self, line: &Line, sign: f64) -> Option<Self> {
        let (c, n) = (self.corners(), self.count);
        let mut values = [0.0; MOST_CORNERS];
        values.iter_mut().zip(c).for_each(|(v, &corner)| *v = sign * line.evaluate(corner));
        let inside = values[..n].iter().filter(|&&v| v > 0.0).count();
        if inside == 0 {
            return None;
        }
        if values[..n].iter().all(|&v| v >= 0.0) {
            return Some(*self);
        }
        let mut clipped = Self { count: 0, ..*self };
        for i in 0..n {
            let j = (i + 1) % n;
            if values[i] >= 0.0 {
                clipped.push(c[i]);
            }
            if (values[i] > 0.0 && values[j] < 0.0) || (values[i] < 0.0 && values[j] > 0.0) {
                let fraction = values[i] / (values[i] - values[j]);
                clipped.push([c[i][0] + fraction * (c[j][0] - c[i][0]), c[i][1] + fraction * (c[j][1] - c[i][1])]);
            }
        }
        (clipped.count >= 3).then_some(clipped)
    }
}

/// A point that looks at a window.
struct Viewpoint<'a> {
    point: DVec3,
    normal: DVec3,
    window: &'a Window<'a>,
    to_origin: DVec3,
    /// At least the distance of any place of the window.
    reach: f64,
}

impl<'a> Viewpoint<'a> {
    fn new(point: DVec3, normal: DVec3, window: &'a Window<'a>) -> Self {
        let (to_origin, [u, v]) = (window.vertices[0] - point, window.axes);
        Self { point, normal, window, to_origin, reach: to_origin.length() + u.length() + v.length() }
    }

    /// Where the plane through the point with this normal meets that of the window.
    fn line(&self, normal: DVec3, error: f64) -> Line {
        let [u, v] = self.window.axes;
        Line { c: [normal.dot(self.to_origin), normal.dot(u), normal.dot(v)], error }
    }

    /// The horizon, where any of the window is below it.
    fn horizon(&self) -> Option<Line> {
        let is_below = |v: &DVec3| self.normal.dot(*v - self.point) < -LEVEL * self.reach;
        self.window.vertices.iter().any(is_below).then(|| self.line(self.normal, 8.0 * f64::EPSILON * self.reach))
    }

    /// The part of an occluder before the window's plane, from the point; less than three corners if it hides nothing.
    fn before(&self, occluder: &[DVec3], heights: &mut Vec<f64>, cut: &mut Vec<DVec3>) {
        let level = LEVEL * (self.reach + (occluder[0] - self.point).length());
        heights.clear();
        heights.extend(occluder.iter().map(|&p| self.window.normal.dot(p - self.window.vertices[0])));
        cut.clear();
        let is_low = |p: &DVec3| self.normal.dot(*p - self.point) <= level;
        if heights.iter().all(|&h| h <= level) || occluder.iter().all(is_low) {
            return;
        }
        if heights.iter().all(|&h| h >= -level) {
            cut.extend(occluder.iter().map(|p| *p - self.point));
            return;
        }
        for (i, &p) in occluder.iter().enumerate() {
            let j = (i + 1) % occluder.len();
            if heights[i] >= 0.0 {
                cut.push(p - self.point);
            }
            if heights[i] * heights[j] < 0.0 {
                cut.push(p + (occluder[j] - p) * (heights[i] / (heights[i] - heights[j])) - self.point);
            }
        }
    }

    /// The sides of a shadow, positive inside; none if the occluder is seen edge-on and hides nothing.
    fn sides(&self, cut: &[DVec3], lines: &mut Vec<Line>) {
        lines.clear();
        let count = cut.len();
        let size = cut.iter().map(|p| p.length()).fold(0.0, largest);
        let turning = (1..count - 1).map(|i| (cut[i] - cut[0]).cross(cut[i + 1] - cut[0])).sum::<DVec3>();
        let side = turning.dot(cut[0]);
        if side.abs() <= LEVEL * turning.length() * size {
            return;
        }
        // Seen from behind they turn the other way.
        let sign = side.signum();
        lines.extend((0..count).map(|i| {
            let (a, b) = (cut[i], cut[(i + 1) % count]);
            self.line(a.cross(b) * sign, 16.0 * f64::EPSILON * (a.length() * b.length() * self.reach))
        }));
    }
}

impl Visible {
    /// The part of a window that a point on a surface of the given normal sees past convex occluders; `None` where that is too
    /// intricate: the closed forms have to answer.
    pub(crate) fn from_point<'a>(
        point: DVec3,
        normal: DVec3,
        window: &Window<'_>,
        occluders: impl Iterator<Item = &'a [DVec3]>,
    ) -> Option<Self> {
        let viewpoint = Viewpoint::new(point, normal, window);
        let mut visible = Self { parts: vec![VisiblePart::full(window.shape)], whole: true, doubt: 0.0 };
        if let Some(horizon) = viewpoint.horizon() {
            visible.whole = false;
            visible.doubt += horizon.doubt();
            visible.parts = visible.parts[0].clipped(&horizon, 1.0).into_iter().collect();
        }
        // Made once for all.
        let (mut heights, mut cut, mut lines) = (Vec::new(), Vec::new(), Vec::new());
        for occluder in occluders {
            if visible.parts.is_empty() {
                break;
            }
            viewpoint.before(occluder, &mut heights, &mut cut);
            if cut.len() < 3 {
                continue;
            }
            viewpoint.sides(&cut, &mut lines);
            if !lines.is_empty() {
                visible.subtract(&lines)?;
            }
        }
        if visible.whole {
            visible.parts.clear();
        }
        Some(visible)
    }

    /// Takes away the region inside all lines; `None` if the rest is too intricate.
    fn subtract(&mut self, lines: &[Line]) -> Option<()> {
        let mut besides = vec![None; self.parts.len()];
        for (beside, part) in besides.iter_mut().zip(&self.parts) {
            *beside = lines.iter().find_map(|line| line.beside(part));
        }
        self.doubt += besides.iter().flatten().sum::<f64>();
        if besides.iter().all(Option::is_some) {
            return Some(());
        }
        self.whole = false;
        let parts = std::mem::take(&mut self.parts);
        self.parts.reserve(parts.len() + 4);
        for (part, beside) in parts.into_iter().zip(besides) {
            if beside.is_some() {
                self.parts.push(part);
            } else {
                self.subtract_from(part, lines)?;
            }
        }
        (self.parts.len() <= MOST_PARTS).then_some(())
    }

    /// Adds the parts outside each of the lines, beginning with the first.
    fn subtract_from(&mut self, part: VisiblePart, lines: &[Line]) -> Option<()> {
        let mut remainder = Some(part);
        for line in lines {
            let Some(inner) = remainder else { break };
            if inner.corners().iter().any(|&c| line.evaluate(c) <= line.error) {
                self.doubt += line.doubt();
            }
            if let Some(outer) = inner.clipped(line, -1.0) {
                if outer.is_full() {
                    return None;
                }
                // A part thinner than the doubt is in it.
                if outer.area() > line.doubt() { self.parts.push(outer) } else { self.doubt += 2.0 * outer.area() }
            }
            remainder = inner.clipped(line, 1.0);
            if remainder.is_some_and(|remainder| remainder.is_full()) {
                return None;
            }
        }
        Some(())
    }

    /// Bound on the part of the area that is seen.
    pub(crate) fn share(&self, shape: Shape) -> f64 {
        if self.whole {
            return 1.0;
        }
        let visible_area: f64 = self.parts.iter().map(VisiblePart::area).sum();
        smallest(visible_area / VisiblePart::full(shape).area() + self.doubt, 1.0)
    }

    /// Whether nothing is seen.
    pub(crate) const fn is_hidden(&self) -> bool {
        !self.whole && self.parts.is_empty()
    }
}
