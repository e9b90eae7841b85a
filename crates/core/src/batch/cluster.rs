//! Bounds on a cluster of emitters: where they are, which way they face, and how much they may give a receiver.
//!
//! All bounds hold for every emitter of the cluster at once and are derived from an oriented box around the vertices, the mean of
//! the normals, and the heights of the box's centre over the emitters' planes. Quantities are computed with a few roundings of
//! |v| + a, v the offset of the centre from the receiver and a the box's radius; [`SLACK`] pays for them.
//!
//! Upper bound on the radiosity due to the emitters, with P the sum of `|B| A`, d the distance of the box, `n1.r <= h1` and `-n2.r
//! <= h2`:
//! - `(rho/pi) P min(1, h1/d) min(1, h2/d) / d^2`, the integrand of HS95 Eq. 1 at its largest;
//! - where all normals are within an angle delta of n1, the part of an emitter that is above the receiver's horizon is seen
//!   between that and the emitter's plane through the receiver, a lune of dihedral angle delta in which `n1.omega <= sin delta`:
//!   at most `(rho/pi) 2 delta sin delta |B|` for each emitter. So a floor gives nothing to a floor, however rounded;
//! - `rho |B|` for each.

use glam::DVec3;

use crate::batch::shapes::Shapes;

/// Relative to |v| + a: above the rounding of any quantity here, a few tens of roundoffs.
const SLACK: f64 = 1e-13;

/// One above 1 by more than the rounding of a bound.
pub(super) const UP: f64 = 1.0 + 1e-12;

/// Bounds on the places, normals and power of a cluster's emitters.
#[derive(Debug, Clone)]
pub(super) struct Cluster {
    /// Centre and axes of the box around all vertices, and its half-widths along them.
    pub(super) centre: DVec3,
    pub(super) axes: [DVec3; 3],
    pub(super) half: [f64; 3],
    /// Length of the half diagonal.
    pub(super) radius: f64,
    /// Mean of the unit normals, and the largest distance of one from it.
    normal: DVec3,
    pub(super) spread: f64,
    /// Least and largest height of the centre over an emitter's plane.
    offsets: [f64; 2],
    /// Sum of `|B| A`, and of `|B|`.
    pub(super) power: f64,
    brightness: f64,
}

/// A cluster seen from a receiver.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sight {
    /// All of it is below the receiver's horizon.
    pub(super) below: bool,
    /// All emitters face away from the receiver.
    pub(super) behind: bool,
    /// All of it is above the horizon and all emitters face the receiver.
    pub(super) whole: bool,
    /// Upper bound on `|B(x)|` due to the cluster, without the factor rho.
    pub(super) largest_value: f64,
    /// Upper bound on n1.r.
    pub(super) highest: f64,
    /// Lower bound on the distance of the box.
    pub(super) clear: f64,
}

impl Cluster {
    pub(super) fn new(shapes: &Shapes) -> Self {
        let normal = shapes.normals.iter().sum::<DVec3>() / shapes.count() as f64;
        let (axes, middle) = frame(normal, &shapes.vertices);
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for v in &shapes.vertices {
            for k in 0..3 {
                let along = axes[k].dot(*v - middle);
                (low[k], high[k]) = (low[k].min(along), high[k].max(along));
            }
        }
        let centre = middle + (0..3).map(|k| axes[k] * (0.5 * (low[k] + high[k]))).sum::<DVec3>();
        let mut half = [0.0f64; 3];
        for v in &shapes.vertices {
            for k in 0..3 {
                half[k] = half[k].max(axes[k].dot(*v - centre).abs());
            }
        }
        let longest = DVec3::from(half).length();
        // The axes are perpendicular and of length 1 to a few roundoffs.
        let half = half.map(|half| half * UP + longest * SLACK);
        let radius = DVec3::from(half).length() * UP;
        let (mut spread, mut offsets) = (0.0f64, [f64::INFINITY, f64::NEG_INFINITY]);
        let (mut power_sum, mut brightness) = (0.0, 0.0);
        for emission in &shapes.largest_emissions {
            brightness += emission;
        }
        // Rounded vertices may be off one plane: the emitter is then the fan of triangles.
        for (corner, facet) in shapes.facets() {
            power_sum += facet.power;
            let Some(unit) = facet.unit_normal else {
                // It may face anywhere.
                (spread, offsets) = (2.0, [f64::NEG_INFINITY, f64::INFINITY]);
                continue;
            };
            spread = spread.max((unit - normal).length() + facet.uncertainty);
            let (offset, uncertainty) = (unit.dot(centre - corner), 2.0 * facet.uncertainty * radius);
            offsets = [offsets[0].min(offset - uncertainty), offsets[1].max(offset + uncertainty)];
        }
        Self {
            centre,
            axes,
            half,
            radius,
            normal,
            spread: spread * UP + 4.0 * f64::EPSILON,
            offsets,
            power: power_sum * UP,
            brightness: brightness * UP,
        }
    }

    /// Bounds on the distances and directions of the cluster from a receiver at `x` with unit normal n1.
    #[inline]
    pub(super) fn sight(&self, x: DVec3, n1: DVec3) -> Sight {
        let v = self.centre - x;
        let distance = v.length();
        let slack = SLACK * (distance + self.radius);
        let (mut reach, mut outside) = (0.0, 0.0);
        for (axis, half) in self.axes.iter().zip(self.half) {
            reach += n1.dot(*axis).abs() * half;
            let excess = (axis.dot(v).abs() - half).max(0.0);
            outside += excess * excess;
        }
        let clear = (outside.sqrt() - slack).max(0.0);
        let height = n1.dot(v);
        let (lowest, highest) = (height - reach - slack, height + reach + slack);
        let front = -self.normal.dot(v);
        let turn = self.spread * distance + slack;
        let (least, most_front) = (front + self.offsets[0] - turn, front + self.offsets[1] + turn);
        let (below, behind) = (highest <= 0.0, most_front <= 0.0);
        Sight {
            below,
            behind,
            whole: lowest > 0.0 && least > 0.0,
            largest_value: if below || behind { 0.0 } else { self.largest_value(n1, highest, most_front, clear) },
            highest,
            clear,
        }
    }

    fn largest_value(&self, n1: DVec3, highest: f64, most_front: f64, clear: f64) -> f64 {
        let turned = (n1 - self.normal).length() + self.spread + 4.0 * f64::EPSILON;
        // delta <= 2 asin(t/2) <= 1.1 t up to t = 1.
        let lune = if turned <= 1.0 { 2.0 * 1.1 * 1.1 * turned * turned } else { f64::INFINITY };
        let by_each = self.brightness * lune.min(std::f64::consts::PI);
        // Cosines that are not above 1 by rounding.
        let far = if clear > 0.0 {
            self.power * (highest / clear).min(UP) * (most_front / clear).min(UP) / (clear * clear)
        } else {
            f64::INFINITY
        };
        by_each.min(far) * (std::f64::consts::FRAC_1_PI * UP) + f64::MIN_POSITIVE
    }
}

/// Axes for a box: the third along the mean normal, the others where the points in its plane are spread most and least; and a
/// point in the middle.
fn frame(normal: DVec3, points: &[DVec3]) -> ([DVec3; 3], DVec3) {
    let middle = points.iter().sum::<DVec3>() / points.len() as f64;
    let up = normal.try_normalize().unwrap_or(DVec3::Z);
    let (first, second) = up.any_orthonormal_pair();
    let (mut uu, mut uv, mut vv) = (0.0, 0.0, 0.0);
    for point in points {
        let (u, v) = (first.dot(*point - middle), second.dot(*point - middle));
        (uu, uv, vv) = (uu + u * u, uv + u * v, vv + v * v);
    }
    // Half the angle of the tensor, by square roots only: the same on every machine.
    let (difference, across) = (uu - vv, 2.0 * uv);
    let size = (difference * difference + across * across).sqrt();
    let cosine = if size > 0.0 { (0.5 * (1.0 + difference / size)).max(0.0).sqrt() } else { 1.0 };
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt().copysign(across);
    let along = first * cosine + second * sine;
    ([along, up.cross(along), up], middle)
}
