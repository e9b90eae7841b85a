//! What a point sees of a convex cell past convex screens, in double precision and without a bound.
//!
//! It serves the value of a factor, which an integration estimates and a proven bracket holds; where many digits are asked for, the
//! evaluations of `radgrad_core` serve instead, with their bounds and thirty times their cost.
//!
//! With the point at the origin, a screen's shadow is where `(a x b).r` has the sign of its inside for every edge a b; the screen is
//! first cut off at the cell's plane, so that a ray crosses the rest of it before it reaches the cell. A shadow leaves the parts
//! outside its side k and inside its sides before k. Lambert's formula sums the lit parts over their edges: `F = -(1/2 pi) sum g
//! n.N`, with g the angle at which an edge from u to v is seen and N the unit vector along `u x v`.

use std::f64::consts::TAU;

use radgrad_core::DVec3;

use super::screen::{Screen, Undecided};

/// A point this near a plane is in it: some roundings of coordinates up to 1.
const LEVEL: f64 = 1e-14;

/// Convex polygons, one after the other.
#[derive(Debug, Default)]
struct Pieces {
    points: Vec<DVec3>,
    ends: Vec<usize>,
}

impl Pieces {
    fn clear(&mut self) {
        self.points.clear();
        self.ends.clear();
    }

    fn push(&mut self, points: &[DVec3]) {
        if points.len() >= 3 {
            self.points.extend_from_slice(points);
            self.ends.push(self.points.len());
        }
    }

    /// Ends a polygon, of the points pushed since the last one.
    fn end(&mut self) {
        let start = self.ends.last().copied().unwrap_or(0);
        if self.points.len() >= start + 3 {
            self.ends.push(self.points.len());
        } else {
            self.points.truncate(start);
        }
    }

    fn iter(&self) -> impl Iterator<Item = &[DVec3]> {
        let start = |k: usize| if k == 0 { 0 } else { self.ends[k - 1] };
        self.ends.iter().enumerate().map(move |(k, &end)| &self.points[start(k)..end])
    }
}

/// Room for the lit parts of a cell, used again from point to point.
#[derive(Debug, Default)]
pub(super) struct PointFactor {
    lit: Pieces,
    next: Pieces,
    outline: Vec<DVec3>,
    sides: Vec<DVec3>,
    values: Vec<f64>,
    inner: Vec<DVec3>,
    rest: Vec<DVec3>,
    /// Of each screen the edge that the last cell was outside of: for a point near by it mostly is again.
    beside: Vec<usize>,
}

impl PointFactor {
    /// The factor from a point of this normal to a cell with all its points above the horizon, whose plane has the normal `facing`. Of each
    /// screen it is given what is known of the edges that the cell and all points near this one are seen past.
    pub(super) fn factor<'a>(
        &mut self,
        (point, normal): (DVec3, DVec3),
        (cell, facing): (&[DVec3], DVec3),
        screens: impl Iterator<Item = (&'a Screen, Undecided)>,
    ) -> f64 {
        let Some(&corner) = cell.first() else { return 0.0 };
        let to_plane = corner - point;
        self.lit.clear();
        self.inner.clear();
        self.inner.extend(cell.iter().map(|&y| y - point));
        self.lit.push(&self.inner);
        for (place, (screen, open)) in screens.enumerate() {
            let height = screen.height(point);
            if height == 0.0 {
                continue;
            }
            let sign = if height > 0.0 { -1.0 } else { 1.0 };
            if open.is_parting() {
                // Whatever is inside these edges is behind the screen.
                let side = |[a, b]: [DVec3; 2]| (a - point).cross(b - point) * sign;
                self.sides.clear();
                self.sides.extend(screen.undecided(open.in_order()).map(side));
                // Of many parts mostly none is inside.
                let is_outside = |side: &DVec3| cell.iter().all(|&y| side.dot(y - point) <= 0.0);
                if self.lit.ends.len() > 1 && self.sides.iter().any(is_outside) {
                    continue;
                }
            } else if self.is_beside(screen, place, point, cell, sign) {
                continue;
            } else {
                self.shadow(screen, point, to_plane, facing, sign);
            }
            if self.sides.is_empty() {
                continue;
            }
            self.subtract();
            if self.lit.ends.is_empty() {
                return 0.0;
            }
        }
        let sum: f64 = self.lit.iter().map(|piece| over_edges(normal, piece)).sum();
        -sum / TAU
    }

    /// Whether all of the cell is outside one edge of a screen, the edge of the last time first.
    fn is_beside(&mut self, screen: &Screen, place: usize, point: DVec3, cell: &[DVec3], sign: f64) -> bool {
        if self.beside.len() <= place {
            self.beside.resize(place + 1, 0);
        }
        let outline = screen.outline();
        let count = outline.len();
        let is_outside = |k: usize| {
            let side = (outline[k] - point).cross(outline[(k + 1) % count] - point) * sign;
            cell.iter().all(|&y| side.dot(y - point) <= 0.0)
        };
        let last = self.beside[place];
        let found = (0..count).map(|k| (last + k) % count).find(|&k| is_outside(k));
        self.beside[place] = found.unwrap_or(last);
        found.is_some()
    }

    /// The sides of a screen's shadow, their normals pointing into it; none where it hides nothing.
    fn shadow(&mut self, screen: &Screen, point: DVec3, to_plane: DVec3, facing: DVec3, sign: f64) {
        self.outline.clear();
        self.sides.clear();
        let height = |s: DVec3| {
            let height = facing.dot(s - to_plane);
            if height.abs() <= LEVEL { 0.0 } else { height }
        };
        for [a, b] in screen.edges() {
            let (a, b) = (a - point, b - point);
            let (h, next) = (height(a), height(b));
            if h >= 0.0 {
                self.outline.push(a);
            }
            if h * next < 0.0 {
                self.outline.push(a + (b - a) * (h / (h - next)));
            }
        }
        // What has a point before the horizon has two more, where it comes down to it on either side.
        if !self.outline.iter().any(|&s| height(s) > 0.0) {
            return;
        }
        let count = self.outline.len();
        self.sides.extend((0..count).map(|k| self.outline[k].cross(self.outline[(k + 1) % count]) * sign));
    }

    /// Subtracts the shadow from the lit parts.
    fn subtract(&mut self) {
        self.next.clear();
        for piece in self.lit.iter() {
            // The cut of a single side says as much.
            if self.sides.len() > 1 && self.sides.iter().any(|side| piece.iter().all(|r| side.dot(*r) <= 0.0)) {
                self.next.push(piece);
                continue;
            }
            let mut inner = piece;
            for (k, side) in self.sides.iter().enumerate() {
                self.values.clear();
                self.values.extend(inner.iter().map(|r| side.dot(*r)));
                if self.values.iter().all(|&v| v >= 0.0) {
                    continue;
                }
                // The part inside the last side is hidden.
                let goes_on = k + 1 < self.sides.len();
                self.rest.clear();
                let count = inner.len();
                for i in 0..count {
                    let j = if i + 1 < count { i + 1 } else { 0 };
                    let (here, v, w) = (inner[i], self.values[i], self.values[j]);
                    if v <= 0.0 {
                        self.next.points.push(here);
                    }
                    if goes_on && v >= 0.0 {
                        self.rest.push(here);
                    }
                    if v * w < 0.0 {
                        let cut = here + (inner[j] - here) * (v / (v - w));
                        self.next.points.push(cut);
                        if goes_on {
                            self.rest.push(cut);
                        }
                    }
                }
                self.next.end();
                if self.rest.len() < 3 {
                    break;
                }
                std::mem::swap(&mut self.inner, &mut self.rest);
                inner = &self.inner;
            }
        }
        std::mem::swap(&mut self.lit, &mut self.next);
    }
}

/// `sum g n.N` over the edges of an outline seen from the origin.
fn over_edges(normal: DVec3, outline: &[DVec3]) -> f64 {
    let count = outline.len();
    let edge = |k: usize| {
        let (u, v) = (outline[k], outline[(k + 1) % count]);
        let across = u.cross(v);
        let sine = across.length();
        if sine == 0.0 { 0.0 } else { libm::atan2(sine, u.dot(v)) * (normal.dot(across) / sine) }
    };
    (0..count).map(edge).sum()
}

#[cfg(test)]
mod tests {
    use radgrad_core::{Emission, Emitter, Polygon, Receiver};

    use super::*;
    use crate::factors::evaluate;
    use crate::factors::tests::draws;

    /// Held against the certified closed forms.
    #[test]
    fn factors_of_points_are_those_of_the_closed_forms() {
        let mut draw = draws(5);
        let mut uniform = || draw() - 0.5;
        let (mut view, mut partly) = (PointFactor::default(), 0);
        for _ in 0..400 {
            let square = [(-0.2, -0.2), (-0.2, 0.2), (0.2, 0.2), (0.2, -0.2)];
            let emitter = Polygon::new(square.map(|(x, y)| DVec3::new(x, y, 0.5 + 0.3 * x)).to_vec()).unwrap();
            let point = DVec3::new(uniform(), uniform(), -0.3);
            let normal = DVec3::new(0.3 * uniform(), 0.3 * uniform(), 1.0).normalize();
            let mut triangle = || {
                let mut corner = || DVec3::new(uniform(), uniform(), 0.7 * uniform()) * 0.9;
                Polygon::new(vec![corner(), corner(), corner()]).unwrap()
            };
            let occluders = [triangle(), triangle(), triangle()];
            let screens: Vec<Screen> = occluders.iter().flat_map(Screen::all_of).collect();
            let found = view.factor(
                (point, normal),
                (emitter.vertices(), emitter.normal()),
                screens.iter().map(|screen| (screen, Undecided::ALL)),
            );
            let receiver = Receiver::new(point, normal, 1.0).unwrap();
            let lamp = Emitter::new(emitter, Emission::Constant(1.0)).unwrap();
            let expected = evaluate(&receiver, &lamp, occluders.iter().collect(), 1e-12).unwrap().radiosity;
            assert!((found - expected).abs() <= 1e-12, "{found} {expected}");
            let free = evaluate(&receiver, &lamp, Vec::new(), 1e-12).unwrap().radiosity;
            partly += usize::from(expected > 1e-6 && expected < free - 1e-6);
        }
        assert!(partly > 100, "{partly}");
    }
}
