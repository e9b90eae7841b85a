//! Moments of the visible region of the emitter's plane, brought down to its boundary by recursion in the degree.
//!
//! With p = (u, v) the position relative to the foot point of x, h the height of x and `r^2 = h^2 + |p|^2`, write for a
//! polynomial f `A<f> = int f / r^4 dA`, `C<f> = int f / r^2 dA` and `K<F> = contour F.nu / r^2 ds`, nu the outward normal. The
//! divergence theorem on `f e / r^2`, e constant, gives `C<df/de> - 2 A<f (p.e)> = K<f e>`, and on `f p / r^2`, f homogeneous
//! of degree k, gives
//! - `k C<f> + 2 h^2 A<f> = K<f p>`                                        (1).
//!
//! Euler's `k f = p . grad f` and the first identity for each partial derivative of f give
//! - `2 k A<f> = C<Laplacian f> - K<grad f>`                                (2).
//!
//! By turns (2) and (1) raise the degree by two: A of degree k needs C of degree k - 2, and C of degree k needs A of the same.
//! They start from `X1 = C<1>`, the one number that is not elementary ([`crate::forms::linear`]), and
//! `h^2 X2 = h^2 A<1> = 1/2 K<p>`, the projected solid angle of the plane. On the boundary, `K` of monomials is elementary
//! ([`crate::forms::polynomial::segment`]).
//!
//! Exact in the differences that (1) and (2) take; these cancel by up to `(h/s)^2` each second degree when the region, of size
//! s around the foot point, is seen under a small angle, and by `(D/s)` to the degree, in the sums over monomials, when it lies
//! at a distance D from the foot point.

use radgrad_numbers::real::Real;

use crate::problem::polynomial::bivariate::{Bivariate, exponents, whole};

/// The integrals along the boundary.
#[derive(Debug, Clone)]
pub(in crate::forms) struct Contour<T> {
    /// `K<u^i v^j e>` for e along u and along v.
    pub(in crate::forms) flux: [Bivariate<T>; 2],
    pub(in crate::forms) x1: T,
    /// `h^2 X2`.
    pub(in crate::forms) facing: T,
}

/// `A<u^i v^j>` up to one degree more than the contour's. `A<1> = X2` may be out of range near contact: it is kept as `h^2 X2`.
#[derive(Debug, Clone)]
pub(in crate::forms) struct Moments<T> {
    over_fourth: Bivariate<T>,
    facing: T,
    height: T,
}

impl<T: Real> Contour<T> {
    pub(in crate::forms) fn zero(degree: usize) -> Self {
        let zero = T::exact(0.0);
        Self { flux: [Bivariate::zero(degree), Bivariate::zero(degree)], x1: zero, facing: zero }
    }

    pub(in crate::forms) fn moments(&self, height: T) -> Moments<T> {
        let degree = self.flux[0].degree() + 1;
        let twice_square = height * height * T::exact(2.0);
        let mut a = Bivariate::zero(degree);
        let mut c = Bivariate::zero(degree.saturating_sub(2));
        *c.coefficient_mut(0, 0) = self.x1;
        for (i, j) in exponents(degree).skip(1) {
            let k = whole::<T>(i + j);
            *a.coefficient_mut(i, j) = (laplacian(&c, i, j) - self.outflow_of_gradient(i, j)) / (k + k);
            if i + j + 2 <= degree {
                let outflow = self.flux[0].coefficient(i + 1, j) + self.flux[1].coefficient(i, j + 1);
                *c.coefficient_mut(i, j) = (outflow - twice_square * a.coefficient(i, j)) / k;
            }
        }
        Moments { over_fourth: a, facing: self.facing, height }
    }

    /// `K<grad u^i v^j>`.
    fn outflow_of_gradient(&self, i: usize, j: usize) -> T {
        let along_u = if i > 0 { self.flux[0].coefficient(i - 1, j) * whole(i) } else { T::exact(0.0) };
        let along_v = if j > 0 { self.flux[1].coefficient(i, j - 1) * whole(j) } else { T::exact(0.0) };
        along_u + along_v
    }
}

/// `C<Laplacian u^i v^j>`.
fn laplacian<T: Real>(c: &Bivariate<T>, i: usize, j: usize) -> T {
    let along_u = if i > 1 { c.coefficient(i - 2, j) * whole(i * (i - 1)) } else { T::exact(0.0) };
    let along_v = if j > 1 { c.coefficient(i, j - 2) * whole(j * (j - 1)) } else { T::exact(0.0) };
    along_u + along_v
}

impl<T: Real> Moments<T> {
    /// `A<f p>`, along u and v.
    pub(in crate::forms) fn in_plane(&self, f: &Bivariate<T>) -> [T; 2] {
        [f.contract(&self.over_fourth, (1, 0), 0), f.contract(&self.over_fourth, (0, 1), 0)]
    }

    /// `h^2 A<f>`.
    pub(in crate::forms) fn facing(&self, f: &Bivariate<T>) -> T {
        f.coefficient(0, 0) * self.facing + self.height * self.height * self.without_constant(f)
    }

    /// `A<f - f(0)>`.
    pub(in crate::forms) fn without_constant(&self, f: &Bivariate<T>) -> T {
        f.contract(&self.over_fourth, (0, 0), 1)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::boundary::arc::Arc;
    use crate::boundary::line::{Line, Sighted};
    use crate::forms::polynomial::segment::{Segment, on_line};
    use crate::forms::segment::{logarithms, x1_term};
    use radgrad_numbers::vec3::Vec3;

    const HEIGHT: f64 = 0.75;
    const CORNERS: [[f64; 2]; 3] = [[-0.5, -0.25], [1.0, 0.125], [0.25, 0.875]];

    fn contour(degree: usize) -> Contour<f64> {
        let mut contour = Contour::zero(degree);
        for i in 0..3 {
            let [from, to] = [CORNERS[i], CORNERS[(i + 1) % 3]].map(|[u, v]| DVec3::new(u, v, -HEIGHT));
            let [start, end] = [from, to].map(|point| Sighted::from(point, DVec3::ZERO, 1.0));
            let line = Line::through([from, to], [&start, &end], DVec3::ZERO, 1.0);
            let arc = Arc::of_edge(start, end, 1.0, line);
            let frame = line.frame();
            let outward = frame.along.cross(Vec3::new(0.0, 0.0, 1.0));
            let signed = frame.distance * frame.normal.z;
            let segment = Segment::new(&arc, frame, degree);
            let foot = [outward.x * signed, outward.y * signed];
            let powers = on_line(segment.over_square().to_vec(), foot, [frame.along.x, frame.along.y]);
            contour.flux[0].add_scaled(&powers, outward.x);
            contour.flux[1].add_scaled(&powers, outward.y);
            contour.x1 += x1_term(&arc, &frame, frame.normal.z, HEIGHT, logarithms(&arc, HEIGHT));
            contour.facing += 0.5 * arc.angle * frame.normal.z;
        }
        contour
    }

    /// `int u^i v^j / r^4 dA` by the midpoint rule of 400^2 small triangles, extrapolated from half as many a side.
    fn by_quadrature(i: usize, j: usize) -> f64 {
        let [p, q, r] = CORNERS;
        let twice_area = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
        let value = |a: f64, b: f64| {
            let [u, v] = [0, 1].map(|k| p[k] + a * (q[k] - p[k]) + b * (r[k] - p[k]));
            let square = HEIGHT * HEIGHT + u * u + v * v;
            (0..i).map(|_| u).chain((0..j).map(|_| v)).product::<f64>() / (square * square)
        };
        let rule = |n: i32| {
            let step = 1.0 / f64::from(n);
            let mut sum = 0.0;
            for k in 0..n {
                for l in 0..n - k {
                    sum += value((f64::from(k) + 1.0 / 3.0) * step, (f64::from(l) + 1.0 / 3.0) * step);
                    if l + 1 < n - k {
                        sum += value((f64::from(k) + 2.0 / 3.0) * step, (f64::from(l) + 2.0 / 3.0) * step);
                    }
                }
            }
            sum * 0.5 * step * step * twice_area
        };
        (4.0 * rule(400) - rule(200)) / 3.0
    }

    #[test]
    fn the_recursion_gives_the_moments_of_a_triangle() {
        let moments = contour(5).moments(HEIGHT);
        for (i, j) in exponents(6).skip(1) {
            let error = moments.over_fourth.coefficient(i, j) - by_quadrature(i, j);
            assert!(error.abs() < 1e-10, "u^{i} v^{j}: off by {error:e}");
        }
        assert!((moments.facing / (HEIGHT * HEIGHT) - by_quadrature(0, 0)).abs() < 1e-10);
    }
}
