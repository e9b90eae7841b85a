//! Parts of factors, which the audit holds against truth one by one: no part of the interface.

use radgrad_core::{DVec3, Polygon};

use super::bracket;
use super::bracket::Cell;
use super::screen::Screen;
use crate::occluders;

/// The exchange of two polygons with nothing in between, and the bound on its error, with so much truncation over it and an error of `resolved` over the
/// smaller area allowed.
#[must_use]
pub fn exchange(from: &Polygon, to: &Polygon, truncation: f64, resolved: f64) -> [f64; 2] {
    let found = super::exchange::exchange(from, to, truncation, resolved);
    [found.area, found.error]
}

/// `(a.b) int_0^1 int_0^1 ln|x(s) - y(t)| ds dt` over two edges, and the bound on its error, with so much truncation of the mean logarithm allowed.
#[must_use]
pub fn mean_logarithm(a: [DVec3; 2], b: [DVec3; 2], truncation: f64) -> [f64; 2] {
    super::exchange::edges::mean_logarithm(a, b, truncation).into()
}

/// Bounds on the share of the segments between two convex cells that pass outside an edge.
#[must_use]
pub fn share_outside(cells: [&Polygon; 2], edge: [DVec3; 2]) -> [f64; 2] {
    let [a, b] = cells.map(|cell| Cell { points: cell.vertices().to_vec(), area: cell.area() });
    bracket::share_outside([&a, &b], edge)
}

/// A bound on the form factor that a polygon hides of an emitter from a point of a surface, if planes of surfaces say that it hides nothing.
#[must_use]
pub fn may_hide(point: DVec3, surface: &Polygon, emitter: &Polygon, other: &Polygon) -> f64 {
    occluders::level::may_hide(point, surface, emitter, other)
}

/// The height of a point over a screen, 0 where it is level with it up to rounding.
#[must_use]
pub fn height(screen: &Polygon, point: DVec3) -> f64 {
    Screen::all_of(screen).first().map_or(f64::NAN, |screen| screen.height(point))
}
