//! The closed forms on a scalar of the caller's, with the constants of their bounds: for `cargo xtask prove`, which records them.
//! No part of the interface. All of it is generic, so a normal build compiles none.

pub use crate::boundary::line::MOMENT_UNITS;
pub use crate::forms::constant_bound::units;
pub use crate::forms::linear_bound::{CHI_TERM as LINEAR_CHI_TERM, PSI_TERM as LINEAR_PSI_TERM};
pub use radgrad_numbers::arc_tangent::{TRUNCATION as ARC_TANGENT_TRUNCATION, UNITS as ARC_TANGENT_UNITS};
pub use radgrad_numbers::arithmetic::{Arithmetic, Doubles};
pub use radgrad_numbers::logarithm::{TRUNCATION as LOGARITHM_TRUNCATION, UNITS as LOGARITHM_UNITS};
pub use radgrad_numbers::series::clausen::{DOUBLE_TRUNCATION as CLAUSEN_TRUNCATION, DOUBLE_UNITS as CLAUSEN_UNITS};
pub use radgrad_numbers::series::sine::REST as SINE_REST;

use radgrad_numbers::series::{clausen, sine};
use radgrad_numbers::vec3::Vec3;
use radgrad_numbers::{arc_tangent as angle, logarithm as natural};

use crate::boundary::arc::{Arc, Generator};
use crate::boundary::line::{Line, Sighted};

fn vector<T>([x, y, z]: [T; 3]) -> Vec3<T> {
    Vec3 { x, y, z }
}

fn array<T>(Vec3 { x, y, z }: Vec3<T>) -> [T; 3] {
    [x, y, z]
}

/// Angle of the point (x, y), y not negative.
pub fn arc_tangent<T: Doubles>(y: T, x: T) -> T {
    angle::angle::<T, true>(y, x)
}

/// Logarithm of a positive normal number.
pub fn logarithm<T: Doubles>(x: T) -> T {
    natural::of_normal(x)
}

/// `(g - sin g)/2g^3` of `z = g^2`, at most 1.
pub fn sine_series<T: Arithmetic>(z: T) -> T {
    sine::double_sum(z)
}

/// `(g - sin g)/4(1 - cos g)` on doubles, up to a quarter turn.
pub fn psi<T: Arithmetic>(g: T) -> T {
    sine::psi(g, g, g, g)
}

/// `J(x)/x^3` of `z = x^2`, the linear emitter's special function.
pub fn clausen_series<T: Arithmetic>(z: T) -> T {
    clausen::double_sum(z)
}

/// The product of two vectors.
pub fn cross<T: Arithmetic>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    array(vector(a).cross(vector(b)))
}

/// `1/|r|` and `n.r/|r|` of an offset r.
pub fn sighted<T: Arithmetic>(r: [T; 3], n: [T; 3]) -> [T; 2] {
    let sighted = Sighted::new(vector(r));
    [sighted.inverse, sighted.cosine(vector(n))]
}

/// `|w|`, N and one over the distance of the line of an edge e with the moment w.
pub fn line<T: Arithmetic>(e: [T; 3], w: [T; 3]) -> (T, [T; 3], T) {
    let line = line_of(e, w);
    (line.moment, array(line.normal), line.nearness())
}

fn line_of<T: Arithmetic>(e: [T; 3], w: [T; 3]) -> Line<T> {
    let square = vector(e).norm_squared();
    Line::new(vector(e), square, vector(w), square)
}

/// Inline and across of the part `fraction` long of an edge e with the moment w, seen from r to s.
pub fn inline_and_across<T: Arithmetic>([r, s, e, w]: [[T; 3]; 4], fraction: T) -> [T; 2] {
    let arc = Arc::of_edge(Sighted::new(vector(r)), Sighted::new(vector(s)), fraction, line_of(e, w));
    [arc.inline, arc.across]
}

/// The weight of an arc up to a quarter turn, from its angle, across and inline, `1/|r|` of its ends, and their q and c.
pub fn weight<T: Arithmetic>([angle, across, inline]: [T; 3], inverse: [T; 2], q: [T; 2], c: [T; 2]) -> T {
    let somewhere = vector([angle; 3]);
    let [start, end] = inverse.map(|inverse| Sighted { point: somewhere, square: angle, inverse });
    Arc { start, end, angle, across, inline, generator: Generator::Horizon(somewhere) }.within_a_quarter_turn(q, c)
}
