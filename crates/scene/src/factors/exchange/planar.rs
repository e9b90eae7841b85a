//! The mean logarithm of two edges in one plane, or nearly: elementary, and without a division by their angle.
//!
//! With the edges as complex numbers a and b of the plane, the vector between two of their points is `z = z00 + s a - t b`. Its corners
//! are `z00` to `z11`, and `F(z) = z^2/2 (ln z - 3/2)` has `F'' = ln z`, so
//!
//! `int_0^1 int_0^1 ln|z| ds dt = -Re { [F(z11) - F(z10) - F(z01) + F(z00)] / (a b) }`,
//!
//! whether the edges are parallel, at any angle, touch, or have a common end.
//!
//! *The branch.* The corners are those of a parallelogram. If 0 is not inside, the logarithm whose cut runs from 0 away from the middle
//! c of the corners is analytic there: a segment from c to a place on the cut would pass through 0. Arguments are those of `z/c`. If 0 is
//! inside, the edges cross, and are cut there.
//!
//! *Rounding.* A corner errs by 8u of its length, and `|F'| = |z| |ln z - 1|`; squares, logarithms, arguments and products err by 16u more
//! of `|z|^2 (|ln|z|| + |arg| + 3/2)`. Where rounding may have put a corner beyond the cut, F errs by `i pi z^2`, of which
//! `pi |Im z^2/(a b)|` counts: nothing, where all is on one line. A cut made off the crossing by e leaves 0 inside of a part, no farther than
//! `e/sin` along an edge from where the cut of the logarithm leaves it, which is as much as `pi e^2/sin` in each part.
//!
//! *Height.* If the vector is off the plane by at most h, `0 <= ln(|z|^2 + h^2) - ln|z|^2`. The integral of this along the line
//! of one edge, of length l, is at most `2 pi h/l`, so the mean of the logarithm is too low by at most `pi h/l`; and by at most
//! `h^2/2d^2` where no two points are nearer than d.

use std::f64::consts::PI;

use radgrad_core::DVec3;

use super::areas::ROUNDOFF;
use crate::extremes::{largest as larger, smallest as smaller};

/// A complex number.
type Complex = [f64; 2];

/// The vectors between the ends of two edges in a plane, and how far they are off it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plane {
    /// From the start and the end of the first edge, in rows, to the start and the end of the second one.
    corners: [[Complex; 2]; 2],
    along: [Complex; 2],
    /// Of what is in the plane.
    lengths: [f64; 2],
    /// Bound on the length of what is not in the plane.
    height: f64,
}

impl Plane {
    /// The plane along the longer edge that holds the end that is farthest from its line.
    pub(super) fn of(a: [DVec3; 2], b: [DVec3; 2], [along_a, along_b]: [DVec3; 2], lengths: [f64; 2]) -> Self {
        let longer = if lengths[0] >= lengths[1] { along_a / lengths[0] } else { along_b / lengths[1] };
        let across = |v: DVec3| v - longer * longer.dot(v);
        let between = a.map(|x| b.map(|y| x - y));
        let offsets = between.iter().flatten().map(|&r| across(r)).chain([across(along_a), across(along_b)]);
        let offset = offsets.fold(DVec3::ZERO, |most, v| if v.length_squared() > most.length_squared() { v } else { most });
        // Twice, as the first time leaves roundings of a long vector. All on one line is in any plane.
        let side = across(offset.normalize_or_zero()).normalize_or_zero();
        let normal = longer.cross(side);
        let flat = |r: DVec3| [longer.dot(r), side.dot(r)];
        let heights = between.iter().flatten().map(|&r| normal.dot(r).abs() + 8.0 * ROUNDOFF * r.length());
        let is_line = side == DVec3::ZERO;
        let height = if is_line { 8.0 * ROUNDOFF * 4.0 } else { heights.fold(0.0, larger) };
        let along = [along_a, along_b].map(flat);
        Self { corners: between.map(|row| row.map(flat)), along, lengths: along.map(length), height }
    }

    /// How much the mean logarithm may be above that in the plane. `apart` is a bound from below on the distance of the edges, asked for where it may
    /// show this to be at most `enough`.
    pub(super) fn raised(&self, enough: f64, apart: impl FnOnce() -> f64) -> f64 {
        let by_line = PI * self.height / larger(self.lengths[0], self.lengths[1]);
        let square = self.height * self.height;
        // No two points are farther than 4.
        if by_line <= enough || square > 32.0 * enough {
            return by_line;
        }
        let apart = apart();
        if apart > self.height { smaller(by_line, 0.5 * square / (apart * apart - square)) } else { by_line }
    }

    /// The mean logarithm in the plane, and a bound on its rounding: infinite where nothing of an edge is in the plane.
    pub(super) fn mean_logarithm(&self) -> (f64, f64) {
        let product = self.lengths[0] * self.lengths[1];
        let (crossing, mut rounding) = self.crossing();
        let mut sum = 0.0;
        let mut add = |s: [f64; 2], t: [f64; 2], off: f64| {
            let part = self.part(s, t, off);
            sum += part.0;
            rounding += part.1;
        };
        if let Some([s, t]) = crossing {
            // Places inside are as far off as the ends.
            let off = self.lengths[0] + self.lengths[1];
            for s in [[0.0, s], [s, 1.0]] {
                add(s, [0.0, t], off);
                add(s, [t, 1.0], off);
            }
        } else {
            add([0.0, 1.0], [0.0, 1.0], 0.0);
        }
        if product == 0.0 || rounding.is_nan() {
            return (0.0, f64::INFINITY);
        }
        // The axes of the plane are perpendicular units to 8u.
        (sum / product, (rounding + 8.0 * ROUNDOFF * (sum.abs() + product)) / product)
    }

    /// The vector between two places of the edges.
    fn at(&self, s: f64, t: f64) -> Complex {
        // From the nearest corner, so that corners are as they are.
        let (i, j) = (usize::from(s > 0.5), usize::from(t > 0.5));
        let (s, t) = (s - i as f64, t - j as f64);
        [0, 1].map(|k| self.corners[i][j][k] + s * self.along[0][k] - t * self.along[1][k])
    }

    /// Where the edges cross, if inside of both, and a bound on what the error of that does to the integral times both lengths.
    fn crossing(&self) -> (Option<[f64; 2]>, f64) {
        let ([a, b], [m, n]) = (self.along, self.lengths);
        let turn = cross(a, b);
        let s = -cross(self.corners[0][0], b) / turn;
        let t = dot(self.at(s, 0.0), b) / (n * n);
        let off = 16.0 * ROUNDOFF * (m + n + length(self.corners[0][0]));
        let sine = turn.abs() / (m * n);
        let is_inside = |x: f64, slack: f64| x > -slack && x < 1.0 + slack;
        if is_inside(s, 0.0) && is_inside(t, 0.0) {
            let off = off + length(self.at(s, t));
            return (Some([s, t]), 4.0 * PI * off * off / sine);
        }
        let is_near = is_inside(s, off / (m * sine)) && is_inside(t, off / (n * sine));
        (None, if is_near { 4.0 * PI * off * off / sine } else { 0.0 })
    }

    /// The integral over parts of the edges times both lengths, and a bound on its rounding; corners err by 8u of `off` beside their own.
    fn part(&self, s: [f64; 2], t: [f64; 2], off: f64) -> (f64, f64) {
        let corners =
            [(1.0, self.at(s[0], t[0])), (-1.0, self.at(s[1], t[0])), (-1.0, self.at(s[0], t[1])), (1.0, self.at(s[1], t[1]))];
        let middle = [0, 1].map(|k| 0.25 * corners.iter().map(|(_, z)| z[k]).sum::<f64>());
        let [a, b] = self.along;
        let product = [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]];
        let unit = product.map(|x| x / length(product));
        let (mut sum, mut rounding) = (0.0, 0.0);
        for (sign, z) in corners {
            let square = dot(z, z);
            if square == 0.0 {
                continue;
            }
            let (sine, cosine) = (cross(middle, z), dot(middle, z));
            let (logarithm, argument) = (0.5 * libm::log(square) - 1.5, libm::atan2(sine, cosine));
            // z^2 in the direction of a b.
            let power = [z[0] * z[0] - z[1] * z[1], 2.0 * z[0] * z[1]];
            let (real, imaginary) = (dot(power, unit), cross(unit, power));
            sum -= sign * 0.5 * (real * logarithm - imaginary * argument);
            let size = length(z);
            rounding += 24.0 * ROUNDOFF * size * (size + self.height + off) * (logarithm.abs() + argument.abs() + 3.0);
            // The middle errs by roundings of the farthest corner.
            let doubt = 32.0 * ROUNDOFF * size * corners.iter().map(|(_, z)| length(*z)).fold(0.0, larger);
            if cosine <= doubt && sine.abs() <= doubt {
                rounding += PI * (imaginary.abs() + 8.0 * ROUNDOFF * square);
            }
        }
        (sum, rounding)
    }
}

fn dot(a: Complex, b: Complex) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// `Im(conj(a) b)`.
fn cross(a: Complex, b: Complex) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn length(z: Complex) -> f64 {
    dot(z, z).sqrt()
}
