//! The derived bound of a linear emission: the tables of `linear_bound`.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;
use radgrad_scene::gauss_legendre;

use super::boundary::{Piece, Seen, U, is_narrow};

/// A segment of the boundary in the emitter's plane, with the numbers that its terms and their errors are made of.
struct Segment {
    along: DVec3,
    outward: DVec3,
    kappa: f64,
    distance: f64,
    /// The distance in the plane.
    d: f64,
    logarithms: [f64; 2],
    flux: f64,
    slope_outward: f64,
    slope_along: f64,
    /// Its part of X1, and the logarithm of the quotient in that.
    term: f64,
    quotient: f64,
}

/// `int 1/2 ln(1 + (d/(h cos phi))^2)` between two places along a line.
fn x1(d: f64, h: f64, [from, to]: [f64; 2]) -> f64 {
    let rule = gauss_legendre(24);
    // The integrand has a logarithm a distance of about h from the real axis of the place: in halves towards both ends of that range.
    let phi = |s: f64| libm::atan2(s, d);
    let parts = 32;
    let mut sum = 0.0;
    for part in 0..parts {
        let at = |k: i32| phi(from) + (phi(to) - phi(from)) * f64::from(k) / f64::from(parts);
        let (a, b) = (at(part), at(part + 1));
        for &(x, weight) in rule {
            let angle = 0.5 * (a + b) + 0.5 * (b - a) * x;
            let reach = d / (h * libm::cos(angle));
            sum += 0.5 * (b - a) * weight * 0.5 * libm::log1p(reach * reach);
        }
    }
    sum
}

impl Segment {
    fn new(seen: &Seen, slope: DVec3, piece: &Piece) -> Self {
        let (h, n2) = (seen.height, seen.n2);
        let (along, distance) = piece.edge.as_ref().map_or_else(
            || {
                let meet = n2.cross(piece.normal);
                (meet.normalize(), h / meet.length())
            },
            |edge| (edge.along, edge.distance),
        );
        let kappa = n2.dot(piece.normal);
        let outward = along.cross(n2);
        let logarithms = piece.ends.map(|end| libm::log(end.length() / h));
        let (slope_outward, slope_along) = (slope.dot(outward), slope.dot(along));
        let flux = kappa * piece.angle * slope_outward + (logarithms[1] - logarithms[0]) * slope_along;
        let d = distance * kappa.abs();
        let places = piece.ends.map(|end| end.dot(along));
        let logarithm_of = |s: f64| {
            if s * s <= d * distance {
                return 0.0;
            }
            let of_one = libm::log(4.0 * s * s * (distance + d).powi(2) / ((d * d + s * s) * (distance * distance + s * s)));
            of_one * s.signum()
        };
        let quotient = logarithm_of(places[1]) - logarithm_of(places[0]);
        Self {
            along,
            outward,
            kappa,
            distance,
            d,
            logarithms,
            flux,
            slope_outward,
            slope_along,
            term: kappa.signum() * x1(d, h, places),
            quotient,
        }
    }
}

/// The error of an end of a segment in X1 at s along it: that of phi and of psi but for their rounding, of `ln(r/h)`, and past a right angle.
fn of_end(segment: &Segment, h: f64, [s, logarithm]: [f64; 2], [of_phi, of_psi, of_logarithm, past]: [f64; 4]) -> f64 {
    let Segment { d, distance, .. } = *segment;
    let (phi, psi) = (libm::atan2(s, d), libm::atan2(s, distance));
    let is_obtuse = s * s > d * distance;
    let (most_phi, most_psi) = (logarithm + (phi * psi).min(1.0), (phi * psi).min(0.5));
    let rounded = 4.0 * most_phi * phi + 2.4 * phi.powi(3) + 3.5 * phi * psi * psi + phi * of_logarithm;
    let apart = most_phi * of_phi + most_psi * of_psi + if is_obtuse { past } else { 0.0 };
    let least = if s > 1e-8 * distance && (s * s - d * distance) / (s * (distance + d)) <= 4.0 {
        let of_sum = (phi + psi) * (s * s - d * distance) / (s * (distance + d));
        let cotangent = (s * s + d * distance) * (distance + d) / (s * h * h);
        let of_difference = (phi - psi) * cotangent;
        let error = 1e-5 + 16.0 * U * phi * cotangent;
        let by_phi = (logarithm + 0.5 * (of_difference - of_sum) - phi * d / s).abs() + error;
        let by_psi = 0.5 * (of_sum + of_difference).abs() + error;
        let together = by_phi * of_phi + by_psi * of_psi + 4.0 * most_psi * psi + if is_obtuse { 17.7 } else { 0.0 };
        together.min(apart)
    } else {
        apart
    };
    rounded + least
}

/// The bounds, given the emission at the first vertex and the gradient's size, and gB; `None` of an uncut polygon that has an edge past a
/// quarter turn or near its line, and of a cut one of many edges, for which double precision has another bound.
pub(super) fn bounds(seen: &Seen, [value, size_of_gradient]: [f64; 2], slope: DVec3) -> Option<[f64; 2]> {
    let is_cut = seen.is_cut();
    let near = |piece: &Piece| piece.edge.as_ref().is_some_and(|edge| edge.of_moment > 3.5 * 4.0 + 1.0);
    if (is_cut && seen.vertices.len() > 4) || (!is_cut && seen.pieces.iter().any(|piece| !is_narrow(&piece.ends) || near(piece)))
    {
        return None;
    }
    let Seen { n1, n2, height: h, ref pieces, .. } = *seen;
    let (steep, additions) = (slope.length(), seen.additions());
    let beta = value - slope.dot(seen.vertices[0]);
    let dbeta = 5.0 * steep * seen.vertices[0].length() + beta.abs();
    let (mut angles, mut slopes, mut x1, mut contour, mut edges, mut fluxes) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    let (mut sum_x1, mut sum_contour) = (0.0, DVec3::ZERO);
    for piece in pieces {
        let segment = Segment::new(seen, slope, piece);
        let Segment { outward, kappa, distance, d, logarithms: [l1, l2], flux, slope_outward, slope_along, .. } = segment;
        let (g, kappa, outward_slope, along_slope) = (piece.angle, kappa.abs(), slope_outward.abs(), slope_along.abs());
        sum_x1 += segment.term;
        sum_contour += outward * flux;
        let difference = (l2 - l1).abs();
        let facing = n1.dot(outward).abs();
        let places = piece.ends.map(|end| end.dot(segment.along).abs());
        fluxes += flux.abs();
        x1 += 4.4 * segment.quotient.abs() + additions * (segment.term).abs();
        let Some(edge) = &piece.edge else {
            // Where the horizon cuts.
            let [z1, z2] = piece.moved;
            let inverse = distance / h;
            let of_along = 8.0 * inverse + 6.0;
            let turned = z1 + z2 + 3.5 + 9.0 * g.min(1.0) + 4.0 * g;
            let of_difference = 3.0 * (l1.abs() + l2.abs()) + 6.0 + difference + z1 + z2;
            let of_flux = outward_slope * (8.0 * g + kappa * (turned + 3.0 * g))
                + kappa * g * steep * (of_along + 8.0)
                + along_slope * (of_difference + 3.0 * difference)
                + difference * steep * (of_along + 6.0)
                + flux.abs();
            contour += facing * of_flux + flux.abs() * (of_along + 13.5 + additions);
            let of_distance = distance * (1.0 + 8.0 * inverse + 4.0);
            let of_d = 8.0 * distance + d * (1.0 + 8.0 * inverse + 6.0);
            for k in 0..2 {
                let (s, r, l) = (places[k], piece.ends[k].length(), [l1, l2][k].abs());
                let rho = d * d + s * s;
                let of_s = r * (of_along + piece.moved[k] + 4.0);
                let of_phi = (d * of_s + s * of_d) / rho;
                let of_psi = (distance * of_s + s * of_distance) / (r * r) + 4.0 * libm::atan2(s, distance);
                let far = (s * s - d * distance) / ((distance + d) * rho);
                let past = 30.0 + FRAC_PI_2 * (of_s * s / (r * r) + far * (of_distance + of_d));
                x1 += of_end(&segment, h, [s, l], [of_phi, of_psi, 8.0 * l + 3.5 + 1.0 + piece.moved[k], past]);
            }
            let turned = turned + g * (5.5 + additions);
            angles += turned;
            slopes += steep * (turned + 2.5 * g);
            continue;
        };
        let ew = edge.of_moment;
        let z = piece.moved[0];
        let turned = 8.0 * g.min(1.0) + 4.0 * g + 2.0 * z;
        let (dg, dsin) = (turned + g.min(1.0) * ew, g * (ew + 14.0) + 2.0 * z);
        let (of_angle, across) = (turned + 3.5 * g, g * (ew + 2.0 + additions));
        angles += n1.dot(piece.normal).abs() * of_angle + across;
        slopes += slope.dot(piece.normal).abs() * of_angle + across * steep;
        for k in 0..2 {
            let (s, r, l) = (places[k], piece.ends[k].length(), [l1, l2][k].abs());
            let rho = d * d + s * s;
            let of_phi = (16.0 * s * d + 6.0 * d * r + s * distance * (ew + 5.0) + z * d * r) / rho;
            let of_psi = 6.0 + libm::atan2(s, distance) * (ew + 15.5) + z;
            let past = 30.0 + 9.43 + (s * s - d * distance) / rho * (3.15 * ew + 19.0) + 1.58 * z;
            x1 += of_end(&segment, h, [s, l], [of_phi, of_psi, 8.0 * l + 3.5 + 1.0 + z, past]);
        }
        let of_difference = 3.0 * (l1.abs() + l2.abs()) + 6.0 + difference + 2.0 * z;
        let of_flux = outward_slope * (g * (ew + 5.0) + kappa * turned + 10.0 * kappa * g)
            + 9.5 * kappa * g * steep
            + along_slope * (of_difference + 5.5 * difference)
            + 6.0 * difference * steep
            + flux.abs();
        contour += facing * (of_flux + 4.5 * flux.abs()) + flux.abs() * (additions + 8.5);
        edges += if is_narrow(&piece.ends) {
            let p: f64 = piece.ends.iter().map(|end| (beta + slope.dot(*end)).abs() / end.length()).sum();
            let s: f64 = piece.ends.iter().map(|end| n1.dot(*end).abs() / end.length()).sum();
            let q: f64 = piece.ends.iter().map(|end| 1.0 / end.length()).sum();
            let dp = q * dbeta + 6.5 * p + 10.0 * steep + z * (p + 2.0 * steep);
            let dc = 10.0 + 6.5 * s + 2.0 * z;
            let (quarter, sum) = (0.25 / (1.0 + libm::cos(g)), g + libm::sin(g));
            let first = quarter * (p * s * (dg + dsin) + sum * (s * dp + p * (14.0 * s + 4.0 * z * s + dc)));
            let second = g * (0.11 * p * dg + 0.091 * (g * dp + 6.0 * g * p + p * dc));
            first + second + p * (quarter * sum * s + 0.091 * g * g.min(s)) * (ew + 6.5 + additions)
        } else {
            let en = ew + 5.0;
            let column = 0.5 * dg + dsin + g * (2.0 * 0.71 * (2.0 * en + 54.0 + 2.0 * z) + 28.0);
            let first = (beta.abs() * (column + g * (2.0 * en + 36.0)) + g * dbeta) / distance;
            let second = steep * (2.0 * column + g * (2.0 * en + 56.0));
            first + second + g * (beta.abs() / distance + steep) * (ew + 6.5 + additions)
        };
    }
    let phi = seen.phi();
    let q = (slope * sum_x1 - sum_contour) * 0.5 - n2 * slope.dot(phi);
    let (across, facing) = (q.dot(n1).abs(), phi.dot(n1).abs());
    let of_phi = 0.5 * angles + 5.0 * phi.length();
    let partial = 0.5 * (steep * sum_x1.abs() + fluxes) + slope.dot(phi).abs();
    let of_slope = 0.5 * slopes + 5.0 * steep * phi.length();
    let of_q = 0.5 * (slope.dot(n1).abs() * x1 + contour) + n1.dot(n2).abs() * of_slope + 9.0 * partial;
    let radiosity = beta.abs() * of_phi
        + facing * dbeta
        + h * (of_q + across)
        + 4.0 * (beta.abs() * phi.length() + h * partial)
        + 3.0 * (phi * beta + q * h).dot(n1).abs();
    let gradient = libm::hypot(steep * of_phi, of_q) + edges + 5.0 * (steep * facing + across) + 4.0 * size_of_gradient;
    Some([1.002 * U * radiosity, 1.002 * U * gradient])
}
