//! Radiosity and gradient of an emission that has no closed form, with an estimate of their error.
//!
//! The emitter is cut into triangles. On each the emission is taken for the polynomial of degree [`FINE`] through its values on a
//! triangular lattice, whose radiosity and gradient `radgrad-core` has in closed form, past horizon and occluders and however
//! near the receiver is. How far the answer with the polynomial of degree [`COARSE`] is from that is taken for its error, and the
//! triangles with the largest ones are cut in four until the sum of all is within the tolerance. The emission is seen at points
//! only: its course between them is in no estimate.
//!
//! The polynomial is Newton's: with forward differences D along the two edges and `(s, t)` the barycentric coordinates times the
//! degree, `p = sum D_s^i D_t^j f(0, 0) C(s, i) C(t, j)`.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use radgrad_core::{DVec3, Emission, Emitter, Method, Polygon, Polynomial, Receiver, effort, evaluate_to};

use super::expression::Expression;
use crate::error::Error;
use crate::extremes::largest;
use crate::scene::split::triangles;

const FINE: usize = 6;
const COARSE: usize = 4;

/// Triangles that are evaluated before it is said that the tolerance was not reached.
const MOST_TRIANGLES: usize = 4000;

/// Operations of the integrals over a triangle in free sight.
const OF_A_TRIANGLE: u64 = 400_000;

/// The relative errors of values of the emission and of the integrand, above which it may be asked to come down.
const ROUNDING: f64 = 1e-15;

/// Radiosity and gradient, and by how much each is estimated to be off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Estimate {
    pub(super) radiosity: f64,
    pub(super) gradient: DVec3,
    pub(super) radiosity_estimate: f64,
    pub(super) gradient_estimate: f64,
    /// Whether the estimates are within the tolerance.
    pub(super) converged: bool,
}

/// The integrals over one triangle, with lengths multiplied by a power of two.
#[derive(Debug, Clone, Copy)]
struct Piece {
    corners: [DVec3; 3],
    radiosity: f64,
    gradient: DVec3,
    radiosity_off: f64,
    gradient_off: f64,
}

impl Piece {
    /// Its errors over the sizes of the results.
    fn share(&self, [radiosity, gradient]: [f64; 2]) -> f64 {
        self.radiosity_off / largest(radiosity, f64::MIN_POSITIVE) + self.gradient_off / largest(gradient, f64::MIN_POSITIVE)
    }
}

/// A piece in the order of its errors.
struct Ranked {
    share: f64,
    place: usize,
}

impl PartialEq for Ranked {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Ranked {}
impl PartialOrd for Ranked {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Ranked {
    fn cmp(&self, other: &Self) -> Ordering {
        self.share.total_cmp(&other.share).then(self.place.cmp(&other.place))
    }
}

/// The problem to integrate, lengths multiplied by a power of two.
struct Task<'a> {
    receiver: Receiver,
    occluders: Vec<Polygon>,
    expression: &'a Expression,
    /// Which coordinates show the emitter largest.
    axes: [usize; 2],
    scale: f64,
    /// Of each piece.
    tolerance: f64,
}

/// Whether the receiver is in front of any of the polygon that it sees. This is for the polygon as a whole to say: its triangles are
/// exactly flat.
fn is_lit(receiver: &Receiver, polygon: &Polygon, occluders: &[Polygon]) -> Result<bool, Error> {
    let evenly = Emitter::new(polygon.clone(), Emission::Constant(1.0)).map_err(Error::Emitter)?;
    match evaluate_to(receiver, &evenly, occluders, 1.0).map_err(Error::Evaluation)?.method {
        Method::OnSurface => Err(Error::Unsupported {
            what: "an expression seen from the surface of its own emitter, whose vertices are not in one plane,".to_owned(),
            instead: "move the receiver off it",
        }),
        method => Ok(method != Method::Zero),
    }
}

/// Radiosity and gradient at `receiver` from `polygon` where it emits `expression`, past `occluders`.
pub(super) fn estimate(
    receiver: &Receiver,
    polygon: &Polygon,
    occluders: &[Polygon],
    expression: &Expression,
    tolerance: f64,
) -> Result<Estimate, Error> {
    if !is_lit(receiver, polygon, occluders)? {
        return Ok(Estimate {
            radiosity: 0.0,
            gradient: DVec3::ZERO,
            radiosity_estimate: 0.0,
            gradient_estimate: 0.0,
            converged: true,
        });
    }
    let task = Task::new(receiver, polygon, occluders, expression, tolerance)?;
    let corners = triangles(polygon.vertices()).unwrap_or_default();
    let mut pieces = Vec::new();
    for corners in corners {
        pieces.extend(task.piece(corners.map(|i| polygon.vertices()[i] * task.scale))?);
    }
    let mut heap = BinaryHeap::new();
    let mut ranked = 0;
    loop {
        let sum = task.sum(&pieces);
        let limits = [sum.radiosity.abs(), sum.gradient.length()];
        while let Some(piece) = pieces.get(ranked) {
            heap.push(Ranked { share: piece.share(limits), place: ranked });
            ranked += 1;
        }
        let met = sum.radiosity_estimate <= tolerance * limits[0] && sum.gradient_estimate <= tolerance * limits[1];
        let sizes = pieces.iter().fold([0.0; 2], |[r, g], p| [r + p.radiosity.abs(), g + p.gradient.length()]);
        let is_rounding = sum.radiosity_estimate <= ROUNDING * sizes[0] && sum.gradient_estimate <= ROUNDING * sizes[1];
        if met || is_rounding || pieces.len() >= MOST_TRIANGLES || effort::is_over() {
            return task.in_unit(Estimate { converged: met, ..sum });
        }
        // As many at a time as are a fraction of all, so that the sums cost little beside the pieces.
        for _ in 0..1 + pieces.len() / 16 {
            let Some(Ranked { place, .. }) = heap.pop() else { return task.in_unit(sum) };
            let [a, b, c] = pieces[place].corners;
            let [ab, bc, ca] = [0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)];
            let mut parts = Vec::with_capacity(4);
            for corners in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
                parts.push(task.piece(corners)?);
            }
            // Too small to be cut again: it stays as it is, and its error with it.
            let parts: Option<Vec<Piece>> = parts.into_iter().collect();
            if let Some(parts) = parts {
                pieces[place] = parts[3];
                heap.push(Ranked { share: parts[3].share(limits), place });
                pieces.extend_from_slice(&parts[..3]);
            }
        }
    }
}

impl<'a> Task<'a> {
    fn new(
        receiver: &Receiver,
        polygon: &Polygon,
        occluders: &[Polygon],
        expression: &'a Expression,
        tolerance: f64,
    ) -> Result<Self, Error> {
        // So that powers of lengths stay in the range of doubles.
        let (_, exponent) = libm::frexp(polygon.size());
        let scale = libm::scalbn(1.0, (-exponent).clamp(-1000, 1000));
        let normal = polygon.normal().abs();
        let axes = if normal.z >= normal.x && normal.z >= normal.y {
            [0, 1]
        } else if normal.y >= normal.x {
            [0, 2]
        } else {
            [1, 2]
        };
        let moved = Receiver::new(receiver.position() * scale, receiver.given_normal(), receiver.reflectance());
        let mut screens = Vec::with_capacity(occluders.len());
        for (index, occluder) in occluders.iter().enumerate() {
            screens.push(occluder.map(scale, |vertex| vertex * scale).map_err(|source| Error::Occluder { index, source })?);
        }
        let tolerance = largest(0.1 * tolerance, 1e-13);
        Ok(Self { receiver: moved.map_err(Error::Receiver)?, occluders: screens, expression, axes, scale, tolerance })
    }

    /// The integrals over a triangle; `None` if it is too small to be one.
    fn piece(&self, corners: [DVec3; 3]) -> Result<Option<Piece>, Error> {
        let Ok(triangle) = Polygon::new(corners.to_vec()) else { return Ok(None) };
        effort::spend(OF_A_TRIANGLE);
        let mut answers = Vec::with_capacity(2);
        for degree in [FINE, COARSE] {
            let Some(polynomial) = self.polynomial(corners, degree)? else { return Ok(None) };
            let emitter = Emitter::new(triangle.clone(), Emission::Polynomial(polynomial)).map_err(Error::Emitter)?;
            let answer = evaluate_to(&self.receiver, &emitter, &self.occluders, self.tolerance);
            answers.push(answer.map_err(Error::Evaluation)?);
        }
        let (fine, coarse) = (&answers[0], &answers[1]);
        Ok(Some(Piece {
            corners,
            radiosity: fine.radiosity,
            gradient: fine.gradient,
            radiosity_off: (fine.radiosity - coarse.radiosity).abs() + fine.radiosity_error,
            gradient_off: (fine.gradient - coarse.gradient).length() + fine.gradient_error,
        }))
    }

    /// The polynomial through the values on the lattice; `None` if the triangle is too thin for one.
    fn polynomial(&self, [a, b, c]: [DVec3; 3], degree: usize) -> Result<Option<Polynomial>, Error> {
        let n = degree as f64;
        // By rows of i, of which each is one shorter than the one before.
        let mut table: Vec<Vec<f64>> = Vec::with_capacity(degree + 1);
        for i in 0..=degree {
            let place = |j: usize| a + (b - a) * (i as f64 / n) + (c - a) * (j as f64 / n);
            let row: Result<_, Error> = (0..=degree - i).map(|j| self.expression.evaluate(place(j) / self.scale)).collect();
            table.push(row?);
        }
        // Differences along the first index, then along the second.
        for order in 1..=degree {
            for i in (order..=degree).rev() {
                let (before, row) = table.split_at_mut(i);
                row[0].iter_mut().zip(&before[i - 1]).for_each(|(value, before)| *value -= before);
            }
        }
        for row in &mut table {
            for order in 1..row.len() {
                for j in (order..row.len()).rev() {
                    row[j] -= row[j - 1];
                }
            }
        }
        // (s, t) as linear forms of the two coordinates, from the first corner.
        let [p, q] = [b - a, c - a].map(|v| self.axes.map(|axis| v[axis]));
        let area = p[0] * q[1] - p[1] * q[0];
        let forms = [[q[1], -q[0]], [-p[1], p[0]]].map(|form| form.map(|c| n * c / area));
        if !forms.iter().flatten().all(|c| c.is_finite()) {
            return Ok(None);
        }
        let mut sum = Bivariate::new(degree);
        let mut along_first = Bivariate::new(degree);
        along_first.0[0][0] = 1.0;
        for (i, row) in table.iter().enumerate() {
            let mut product = along_first.clone();
            for (j, difference) in row.iter().enumerate() {
                sum.add(&product, *difference);
                product = product.times(forms[1], -(j as f64), 1.0 / (j + 1) as f64);
            }
            along_first = along_first.times(forms[0], -(i as f64), 1.0 / (i + 1) as f64);
        }
        let terms = sum.0.iter().enumerate().flat_map(|(i, row)| {
            row.iter().enumerate().filter(|(_, c)| **c != 0.0).map(move |(j, &c)| {
                let mut powers = [0_u8; 3];
                // At most the degree.
                (powers[self.axes[0]], powers[self.axes[1]]) = (u8::try_from(i).unwrap_or(0), u8::try_from(j).unwrap_or(0));
                (c, powers)
            })
        });
        Polynomial::new(a, terms.collect::<Vec<_>>()).map(Some).map_err(Error::Emitter)
    }

    fn sum(&self, pieces: &[Piece]) -> Estimate {
        let zero =
            Estimate { radiosity: 0.0, gradient: DVec3::ZERO, radiosity_estimate: 0.0, gradient_estimate: 0.0, converged: false };
        pieces.iter().fold(zero, |sum, piece| Estimate {
            radiosity: sum.radiosity + piece.radiosity,
            gradient: sum.gradient + piece.gradient,
            radiosity_estimate: sum.radiosity_estimate + piece.radiosity_off,
            gradient_estimate: sum.gradient_estimate + piece.gradient_off,
            ..sum
        })
    }

    /// In the lengths of the caller.
    fn in_unit(&self, sum: Estimate) -> Result<Estimate, Error> {
        let Estimate { gradient, gradient_estimate, .. } = sum;
        Ok(Estimate { gradient: gradient * self.scale, gradient_estimate: gradient_estimate * self.scale, ..sum })
    }
}

/// A polynomial of two variables, by the powers of the first, then of the second.
#[derive(Clone)]
struct Bivariate(Vec<Vec<f64>>);

impl Bivariate {
    fn new(degree: usize) -> Self {
        Self(vec![vec![0.0; degree + 1]; degree + 1])
    }

    fn add(&mut self, other: &Self, factor: f64) {
        for (sum, row) in self.0.iter_mut().zip(&other.0) {
            for (sum, c) in sum.iter_mut().zip(row) {
                *sum += c * factor;
            }
        }
    }

    /// Times `factor (form + constant)`, without the terms beyond the degree.
    fn times(&self, form: [f64; 2], constant: f64, factor: f64) -> Self {
        let mut product = Self(self.0.iter().map(|row| row.iter().map(|c| c * constant * factor).collect()).collect());
        for (i, row) in self.0.iter().enumerate() {
            for (j, c) in row.iter().enumerate() {
                if let Some(sum) = product.0.get_mut(i + 1) {
                    sum[j] += c * form[0] * factor;
                }
                if let Some(sum) = product.0[i].get_mut(j + 1) {
                    *sum += c * form[1] * factor;
                }
            }
        }
        product
    }
}

#[cfg(test)]
mod tests {
    use radgrad_core::evaluate;

    use super::*;

    fn square() -> Polygon {
        let corners = [[-0.9, -0.8, 1.0], [-0.7, 0.9, 1.0], [0.8, 0.7, 1.0], [0.9, -0.6, 1.0]];
        Polygon::new(corners.map(DVec3::from).to_vec()).unwrap()
    }

    fn screen() -> Polygon {
        Polygon::new([[0.1, -2.0, 0.5], [0.1, 2.0, 0.5], [3.0, 0.0, 0.6]].map(DVec3::from).to_vec()).unwrap()
    }

    fn estimate_of(text: &str, receiver: &Receiver, occluders: &[Polygon], tolerance: f64) -> Estimate {
        estimate(receiver, &square(), occluders, &Expression::parse(text).unwrap(), tolerance).unwrap()
    }

    /// A polynomial of degree 6, which has a closed form, and the same as a limit that no triangle has exactly.
    #[test]
    fn a_polynomial_is_that_of_the_closed_form_past_an_occluder_and_horizon() {
        let polynomial = [(1.0, [0, 0, 0]), (0.5, [3, 2, 0]), (-0.25, [0, 6, 0])];
        let emission = Emission::Polynomial(Polynomial::new(DVec3::ZERO, polynomial).unwrap());
        let emitter = Emitter::new(square(), emission).unwrap();
        for normal in [DVec3::Z, DVec3::new(1.0, 0.3, 0.2)] {
            // In contact all but a thousandth of the gradients of the triangles cancels.
            for (height, tolerance) in [(0.0, 1e-9), (0.999, 1e-6)] {
                let position = DVec3::new(0.1, -0.2, height);
                let receiver = Receiver::new(position, normal, 0.7).unwrap();
                for occluders in [vec![], vec![screen()]] {
                    let expected = evaluate(&receiver, &emitter, &occluders).unwrap();
                    let computed = estimate_of("1 + x^3*y^2/2 - y^6/4", &receiver, &occluders, tolerance);
                    let errors =
                        [(computed.radiosity - expected.radiosity).abs(), (computed.gradient - expected.gradient).length()];
                    assert!(computed.converged && errors[0] <= tolerance * expected.radiosity.abs(), "{computed:?} {expected:?}");
                    assert!(errors[1] <= tolerance * expected.gradient.length(), "{computed:?} {expected:?}");
                }
            }
        }
    }

    /// Against the closed form of the exponential's Taylor polynomial of degree 12, which is within 2e-10 of it here.
    #[test]
    fn an_exponential_is_within_its_estimate() {
        let mut factor = 1.0;
        let terms = (0..=12_u8).map(|k| {
            factor = if k == 0 { 1.0 } else { -factor / f64::from(k) };
            (factor, [1, k, 0])
        });
        let terms: Vec<_> = terms.chain([(1.0, [0, 0, 0])]).collect();
        let polynomial = Polynomial::new(DVec3::ZERO, terms);
        let emitter = Emitter::new(square(), Emission::Polynomial(polynomial.unwrap())).unwrap();
        let receiver = Receiver::new(DVec3::new(0.3, 0.1, 0.2), DVec3::new(0.2, 0.1, 1.0), 1.0).unwrap();
        let expected = evaluate(&receiver, &emitter, &[]).unwrap();
        for tolerance in [1e-3, 1e-6, 1e-9] {
            let computed = estimate_of("1 + x*exp(-y)", &receiver, &[], tolerance);
            assert!(computed.converged, "{computed:?}");
            assert!(
                (computed.radiosity - expected.radiosity).abs() <= computed.radiosity_estimate + 1e-10,
                "{computed:?} {expected:?}"
            );
            assert!(
                (computed.gradient - expected.gradient).length() <= computed.gradient_estimate + 1e-9,
                "{computed:?} {expected:?}"
            );
        }
    }

    #[test]
    fn units_of_length_change_nothing_and_what_does_not_converge_says_so() {
        let receiver = Receiver::new(DVec3::new(0.3, 0.1, 0.2), DVec3::Z, 1.0).unwrap();
        let computed = estimate_of("1 + x^2*cos(y)", &receiver, &[], 1e-8);
        let unit = 2f64.powi(-90);
        let corners = square().vertices().iter().map(|&v| v * unit).collect();
        let small = Receiver::new(receiver.position() * unit, DVec3::Z, 1.0).unwrap();
        let text = format!("1 + (x*{:e})^2*cos(y*{:e})", 1.0 / unit, 1.0 / unit);
        let again = estimate(&small, &Polygon::new(corners).unwrap(), &[], &Expression::parse(&text).unwrap(), 1e-8).unwrap();
        assert_eq!((again.radiosity, again.gradient * unit), (computed.radiosity, computed.gradient));
        let jump = estimate_of("1 + max(0, x - 0.123)/abs(x - 0.123)", &receiver, &[], 1e-10);
        assert!(!jump.converged && jump.radiosity_estimate > 1e-10 * jump.radiosity, "{jump:?}");
        let dark = Receiver::new(DVec3::new(0.0, 0.0, 2.0), DVec3::Z, 1.0).unwrap();
        assert_eq!(estimate_of("x", &dark, &[], 1e-8).radiosity, 0.0);
    }
}
