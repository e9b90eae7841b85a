//! Orthonormal polynomials on an element, degree 0 to 4.
//!
//! An element is the image of the unit square or of the triangle (0,0), (1,0), (0,1) under an affine map, so that a polynomial
//! of the reference coordinates is one of the position, and radiates in closed form. On a parallelogram the functions are
//! products of Legendre polynomials (H. Zatz 1993), `(degree + 1)^2` of them, on a triangle those of Proriol and Dubiner,
//! `(degree + 1)(degree + 2)/2`. They are orthonormal in the mean over the element: the first is 1, its coefficient is the mean
//! radiosity, and all coefficients have the unit of radiosity. Functions are ordered by degree: the first ones of a basis are
//! the basis of a lower degree.
//!
//! The second family comes out of a Gram-Schmidt process on monomials with exact moments, which loses two digits at degree 3;
//! values from monomials lose four at degree 4.
//! Values over an element are bounded by Bernstein coefficients: a polynomial lies between the least and the largest of them.

use std::sync::OnceLock;

use crate::mesh::rule::{self, Node};
use crate::mesh::shape::{Shape, in_parent, moment};
use radgrad_scene::{largest, smallest};

/// Highest degree of a basis.
pub const MAX_DEGREE: usize = 4;

/// Powers of the distance from an element's centre, from 0 on, of which means are kept.
pub(crate) const POWERS: usize = MAX_DEGREE + 2;

/// A polynomial of the reference coordinates: a coefficient for each of the basis' monomials `s^i t^j`.
type Monomials = Vec<f64>;

/// The parts of samples beyond a basis.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Excess {
    pub(crate) last: f64,
    pub(crate) next: f64,
    pub(crate) largest: f64,
    pub(crate) truncation: f64,
    pub(crate) spread: f64,
}

impl Excess {
    /// Estimate of its magnitude over the element: the part beyond the next degree counts twice, since the samples are not where it
    /// is largest.
    pub(crate) fn magnitude(&self) -> f64 {
        self.largest + 2.0 * self.truncation
    }
}

/// An orthonormal basis on a shape, the rule that projects on it, and the maps between an element and its four children.
///
/// ```
/// use radgrad_solver::{Basis, Shape};
/// let basis = Basis::new(Shape::Parallelogram, 1);
/// assert_eq!(basis.len(), 4);
/// let values = basis.values([0.5, 1.0]);
/// assert!((values[0] - 1.0).abs() < 1e-15 && values[1].abs() < 1e-15, "1, then sqrt(3)(2s - 1), which is 0 in the middle");
/// // f(s, t) = 3 + s, from its values at the nodes:
/// let samples: Vec<f64> = basis.nodes().iter().map(|node| 3.0 + node.at[0]).collect();
/// let coefficients = basis.project(&samples);
/// assert!((coefficients[0] - 3.5).abs() < 1e-14);
/// ```
#[derive(Debug, Clone)]
pub struct Basis {
    shape: Shape,
    degree: usize,
    powers: Vec<[usize; 2]>,
    functions: Vec<Monomials>,
    nodes: Vec<Node>,
    /// Values of the functions at the nodes.
    at_nodes: Vec<Vec<f64>>,
    /// For each child, function of the child and function of the parent.
    to_child: [Vec<Vec<f64>>; 4],
    /// For each Bernstein polynomial, its coefficient in each function.
    bernstein: Vec<Vec<f64>>,
    /// Bound on the magnitude of all functions, and by how much sums of moments may enlarge rounding errors.
    largest: f64,
    conditioning: f64,
    /// Bound on the magnitude of each function.
    sizes: Vec<f64>,
    /// The basis of the next degree, at the nodes and in Bernstein polynomials: for the remainder of the projection.
    above: Option<Box<Self>>,
}

impl Basis {
    /// The basis of a degree, at most [`MAX_DEGREE`]; a higher one is taken as that.
    #[must_use]
    pub fn new(shape: Shape, degree: usize) -> Self {
        let degree = degree.min(MAX_DEGREE);
        let nodes = rule::for_degree(shape, degree);
        let above = Self::with_nodes(shape, degree + 1, nodes.clone(), None);
        Self::with_nodes(shape, degree, nodes, Some(Box::new(above)))
    }

    /// The same with the fewest nodes that project on it, and no estimate of the truncation.
    pub(crate) fn of_fewest_nodes(shape: Shape, degree: usize) -> Self {
        Self::with_nodes(shape, degree, rule::least_for_degree(shape, degree), None)
    }

    /// That of the first degree.
    pub(crate) fn linear(shape: Shape) -> &'static Self {
        static LINEAR: OnceLock<[Basis; 2]> = OnceLock::new();
        let [on_squares, on_triangles] =
            LINEAR.get_or_init(|| [Shape::Parallelogram, Shape::Triangle].map(|shape| Self::of_fewest_nodes(shape, 1)));
        match shape {
            Shape::Parallelogram => on_squares,
            Shape::Triangle => on_triangles,
        }
    }

    fn with_nodes(shape: Shape, degree: usize, nodes: Vec<Node>, above: Option<Box<Self>>) -> Self {
        let powers = powers(shape, degree);
        let functions = match shape {
            Shape::Parallelogram => legendre_products(&powers),
            Shape::Triangle => orthonormal(&powers),
        };
        let (at_nodes, to_child) = (Vec::new(), [const { Vec::new() }; 4]);
        let mut basis = Self {
            shape,
            degree,
            powers,
            functions,
            nodes,
            at_nodes,
            to_child,
            bernstein: Vec::new(),
            largest: 1.0,
            conditioning: 1.0,
            sizes: Vec::new(),
            above,
        };
        basis.at_nodes = basis.nodes.iter().map(|node| basis.values(node.at)).collect();
        basis.to_child = [0, 1, 2, 3].map(|child| basis.child_map(child));
        basis.bernstein = basis.bernstein_map();
        basis.largest = basis.bernstein.iter().flatten().fold(1.0, |most, c| largest(most, c.abs()));
        let largest_coefficient =
            |function: usize| basis.bernstein.iter().fold(0.0, |most: f64, row| largest(most, row[function].abs()));
        basis.sizes = (0..basis.len()).map(largest_coefficient).collect();
        let size = |f: &Monomials| f.iter().map(|c| c.abs()).sum::<f64>();
        basis.conditioning = basis.functions.iter().map(size).fold(1.0, largest);
        basis
    }

    /// Number of functions.
    #[must_use]
    pub fn len(&self) -> usize {
        self.functions.len()
    }

    /// Whether there are no functions: never.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.functions.is_empty()
    }

    /// Number of functions up to a degree.
    #[must_use]
    pub const fn count(&self, degree: usize) -> usize {
        match self.shape {
            Shape::Parallelogram => (degree + 1) * (degree + 1),
            Shape::Triangle => (degree + 1) * (degree + 2) / 2,
        }
    }

    /// The degree.
    #[must_use]
    pub const fn degree(&self) -> usize {
        self.degree
    }

    /// Nodes at which a function is sampled to be projected.
    #[must_use]
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Values of all functions at a point.
    #[must_use]
    pub fn values(&self, [s, t]: [f64; 2]) -> Vec<f64> {
        let monomials: Vec<f64> = self.powers.iter().map(|&[i, j]| power(s, i) * power(t, j)).collect();
        self.functions.iter().map(|f| dot(f, &monomials)).collect()
    }

    /// The same in a buffer that has their number.
    pub(crate) fn fill(&self, [s, t]: [f64; 2], values: &mut [f64]) {
        let powers = |x: f64| {
            let mut powers = [1.0; MAX_DEGREE + 2];
            for i in 1..powers.len() {
                powers[i] = powers[i - 1] * x;
            }
            powers
        };
        let (of_s, of_t) = (powers(s), powers(t));
        for (value, function) in values.iter_mut().zip(&self.functions) {
            *value = function.iter().zip(&self.powers).map(|(c, &[i, j])| c * (of_s[i] * of_t[j])).sum();
        }
    }

    /// Derivatives of all functions with respect to `s` and `t` at a point.
    #[must_use]
    pub fn slopes(&self, [s, t]: [f64; 2]) -> Vec<[f64; 2]> {
        let along = |&[i, j]: &[usize; 2]| if i == 0 { 0.0 } else { i as f64 * power(s, i - 1) * power(t, j) };
        let across = |&[i, j]: &[usize; 2]| if j == 0 { 0.0 } else { j as f64 * power(s, i) * power(t, j - 1) };
        let (along, across): (Vec<f64>, Vec<f64>) = self.powers.iter().map(|p| (along(p), across(p))).unzip();
        self.functions.iter().map(|f| [dot(f, &along), dot(f, &across)]).collect()
    }

    /// The monomials `s^i t^j` of a function, each with its coefficient.
    pub fn monomials(&self, function: usize) -> impl Iterator<Item = (f64, [usize; 2])> {
        self.functions[function].iter().copied().zip(self.powers.iter().copied()).filter(|(c, _)| *c != 0.0)
    }

    /// Exponents of the monomials `s^i t^j`, in the order of the moments that [`Self::of_moments`] takes.
    pub(crate) fn powers(&self) -> &[[usize; 2]] {
        &self.powers
    }

    /// Integrals of the functions from those of the monomials; the first ones from the first ones.
    pub(crate) fn of_moments(&self, moments: &[f64]) -> Vec<f64> {
        self.functions.iter().take(moments.len()).map(|f| dot(f, moments)).collect()
    }

    /// By how much [`Self::of_moments`] may enlarge rounding errors.
    pub(crate) const fn conditioning(&self) -> f64 {
        self.conditioning
    }

    /// Coefficients of the projection of a function given at the nodes: exact for functions of the basis.
    #[must_use]
    pub fn project(&self, samples: &[f64]) -> Vec<f64> {
        let mut coefficients = vec![0.0; self.len()];
        for ((node, values), sample) in self.nodes.iter().zip(&self.at_nodes).zip(samples) {
            for (c, v) in coefficients.iter_mut().zip(values) {
                *c += node.weight * v * sample;
            }
        }
        coefficients
    }

    /// Values of the functions at a node.
    #[must_use]
    pub fn at_node(&self, node: usize) -> &[f64] {
        &self.at_nodes[node]
    }

    /// Coefficients on a child of the function that has these coefficients on the parent; absent ones are 0.
    #[must_use]
    pub fn restrict(&self, child: usize, parent: &[f64]) -> Vec<f64> {
        self.to_child[child].iter().map(|row| dot(row, parent)).collect()
    }

    /// Adds to the parent's coefficients those of the projection of a child's.
    pub fn pull(&self, child: usize, of_child: &[f64], parent: &mut [f64]) {
        for (row, c) in self.to_child[child].iter().zip(of_child) {
            for (p, weight) in parent.iter_mut().zip(row) {
                *p += 0.25 * weight * c;
            }
        }
    }

    /// The shape of the elements that it is for.
    #[must_use]
    pub const fn shape(&self) -> Shape {
        self.shape
    }

    /// Bernstein coefficients of the function that has these coefficients.
    pub(crate) fn bernstein(&self, coefficients: &[f64]) -> Vec<f64> {
        self.bernstein.iter().map(|row| dot(row, coefficients)).collect()
    }

    /// Least and largest value over the element, or beyond them: the range of the Bernstein coefficients.
    #[must_use]
    pub fn range(&self, coefficients: &[f64]) -> [f64; 2] {
        let values = self.bernstein.iter().map(|row| dot(row, coefficients));
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [smallest(low, v), largest(high, v)])
    }

    /// A bound on the magnitude over the element.
    #[must_use]
    pub fn magnitude(&self, coefficients: &[f64]) -> f64 {
        let [low, high] = self.range(coefficients);
        largest(high, -low)
    }

    /// Estimate of the largest magnitude over the element of the remainder of samples at all [`Self::nodes`], in their unit: a
    /// bound on their part of the next degree, and twice the largest remainder beyond that at the nodes.
    ///
    /// ```
    /// use radgrad_solver::{Basis, Shape};
    /// let basis = Basis::new(Shape::Parallelogram, 1);
    /// // Of s^2 linear functions leave s^2 - s + 1/6, at most 1/6.
    /// let samples: Vec<f64> = basis.nodes().iter().map(|node| node.at[0] * node.at[0]).collect();
    /// let truncation = basis.magnitude_beyond(&samples);
    /// assert!(truncation >= 1.0 / 6.0 && truncation < 0.4);
    /// ```
    #[must_use]
    pub fn magnitude_beyond(&self, samples: &[f64]) -> f64 {
        self.excess(samples).magnitude()
    }

    /// The parts of samples at the nodes beyond this basis: the size of their part of this degree and of the next one, in the root
    /// mean square, a bound on the magnitude of the latter over the element, and the remainder beyond it at the nodes, at most and
    /// in the root mean square.
    pub(crate) fn excess(&self, samples: &[f64]) -> Excess {
        let Some(above) = &self.above else { return Excess::default() };
        let mut coefficients = above.project(samples);
        let size = |part: &[f64]| part.iter().map(|c| c * c).sum::<f64>().sqrt();
        let lower = self.degree.checked_sub(1).map_or(0, |d| self.count(d));
        let (last, next) = (size(&coefficients[lower..self.len()]), size(&coefficients[self.len()..]));
        let remainders: Vec<f64> =
            above.at_nodes.iter().zip(samples).map(|(at, sample)| sample - dot(at, &coefficients)).collect();
        let truncation = remainders.iter().fold(0.0, |most: f64, r| largest(most, r.abs()));
        let squares = |others: bool| {
            let chosen = remainders.iter().zip(&self.nodes).filter(|(_, node)| (node.weight == 0.0) == others);
            let (sum, count) = chosen.fold((0.0, 0), |(sum, count), (r, _)| (sum + r * r, count + 1));
            sum / f64::from(count.max(1))
        };
        let spread = largest(squares(true), squares(false)).sqrt();
        coefficients[..self.len()].fill(0.0);
        Excess { last, next, largest: above.magnitude(&coefficients), truncation, spread }
    }

    /// The part of the samples' truncation that lies along the basis, which the rule of the nodes cannot tell: it falls off as
    /// the last two degrees do, and where nothing falls off, as where a shadow's edge crosses, an interval between nodes decides.
    pub(crate) fn seen_of(&self, excess: &Excess) -> f64 {
        let ratio = if excess.next < excess.last { excess.next / excess.last } else { 1.0 };
        let falls = std::iter::repeat_n(ratio, self.degree + 2).product::<f64>();
        smallest(falls, 1.0 / (self.degree + 2) as f64)
    }

    /// The basis of the next degree; it has none itself.
    pub(crate) fn above(&self) -> Option<&Self> {
        self.above.as_deref()
    }

    /// The part of the next degree of samples at the nodes, in the basis of that degree.
    pub(crate) fn next(&self, samples: &[f64]) -> Vec<f64> {
        let mut coefficients = self.above().map_or_else(Vec::new, |above| above.project(samples));
        let own = self.len().min(coefficients.len());
        coefficients[..own].fill(0.0);
        coefficients
    }

    /// A bound on the magnitude of each function.
    pub(crate) fn sizes(&self) -> &[f64] {
        &self.sizes
    }

    /// A bound on the magnitude of all functions.
    pub(crate) const fn largest(&self) -> f64 {
        self.largest
    }

    fn child_map(&self, child: usize) -> Vec<Vec<f64>> {
        let mut map = vec![vec![0.0; self.len()]; self.len()];
        for (node, of_child) in self.nodes.iter().zip(&self.at_nodes) {
            let of_parent = self.values(in_parent(self.shape, child, node.at));
            for (row, c) in map.iter_mut().zip(of_child) {
                for (entry, p) in row.iter_mut().zip(&of_parent) {
                    *entry += node.weight * c * p;
                }
            }
        }
        map
    }

    /// `s^i t^j` in Bernstein polynomials, for all functions.
    fn bernstein_map(&self) -> Vec<Vec<f64>> {
        let n = self.degree;
        let falling = |a: usize, i: usize| (0..i).map(|k| a as f64 - k as f64).product::<f64>();
        let indices = (0..=n).flat_map(|a| (0..=n).map(move |b| [a, b]));
        let indices = indices.filter(|[a, b]| self.shape == Shape::Parallelogram || a + b <= n);
        let weight = |[a, b]: [usize; 2], [i, j]: [usize; 2]| match self.shape {
            Shape::Parallelogram => falling(a, i) / falling(n, i) * (falling(b, j) / falling(n, j)),
            Shape::Triangle => falling(a, i) * falling(b, j) / falling(n, i + j),
        };
        let row = |at: [usize; 2]| -> Vec<f64> {
            let monomials: Vec<f64> = self.powers.iter().map(|&p| weight(at, p)).collect();
            self.functions.iter().map(|f| dot(f, &monomials)).collect()
        };
        indices.map(row).collect()
    }
}

/// Exponents in the order of degrees.
fn powers(shape: Shape, degree: usize) -> Vec<[usize; 2]> {
    let pairs = (0..=degree).flat_map(|i| (0..=degree).map(move |j| [i, j]));
    let mut powers: Vec<[usize; 2]> = match shape {
        Shape::Parallelogram => pairs.collect(),
        Shape::Triangle => pairs.filter(|[i, j]| i + j <= degree).collect(),
    };
    powers.sort_by_key(|&[i, j]| match shape {
        Shape::Parallelogram => (i.max(j), i + j, j),
        Shape::Triangle => (i + j, 0, j),
    });
    powers
}

/// `P_i(2s - 1) P_j(2t - 1) sqrt((2i + 1)(2j + 1))`.
fn legendre_products(powers: &[[usize; 2]]) -> Vec<Monomials> {
    const LEGENDRE: [[f64; 6]; 6] = [
        [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [-1.0, 2.0, 0.0, 0.0, 0.0, 0.0],
        [1.0, -6.0, 6.0, 0.0, 0.0, 0.0],
        [-1.0, 12.0, -30.0, 20.0, 0.0, 0.0],
        [1.0, -20.0, 90.0, -140.0, 70.0, 0.0],
        [-1.0, 30.0, -210.0, 560.0, -630.0, 252.0],
    ];
    let product = |[i, j]: [usize; 2]| {
        let length = ((2 * i + 1) as f64 * (2 * j + 1) as f64).sqrt();
        powers.iter().map(|&[p, q]| LEGENDRE[i][p] * LEGENDRE[j][q] * length).collect()
    };
    powers.iter().map(|&p| product(p)).collect()
}

/// Gram-Schmidt on the triangle, each function twice, so that rounding leaves no part along the ones before.
fn orthonormal(powers: &[[usize; 2]]) -> Vec<Monomials> {
    let product = |f: &[f64], g: &[f64]| -> f64 {
        let pairs = f.iter().zip(powers).flat_map(|(a, p)| g.iter().zip(powers).map(move |(b, q)| (a * b, p, q)));
        pairs.map(|(ab, p, q)| ab * moment(Shape::Triangle, p[0] + q[0], p[1] + q[1])).sum()
    };
    let mut functions: Vec<Monomials> = Vec::with_capacity(powers.len());
    for index in 0..powers.len() {
        let mut f = vec![0.0; powers.len()];
        f[index] = 1.0;
        for _ in 0..2 {
            for g in &functions {
                let along = product(&f, g);
                f.iter_mut().zip(g).for_each(|(f, g)| *f -= along * g);
            }
            let length = product(&f, &f).sqrt();
            f.iter_mut().for_each(|c| *c /= length);
        }
        functions.push(f);
    }
    functions
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn power(x: f64, n: usize) -> f64 {
    std::iter::repeat_n(x, n).product()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAPES: [Shape; 2] = [Shape::Parallelogram, Shape::Triangle];

    #[test]
    fn functions_are_orthonormal_in_the_mean() {
        for shape in SHAPES {
            for degree in 0..=MAX_DEGREE {
                let basis = Basis::new(shape, degree);
                assert_eq!(basis.len(), basis.count(degree));
                for a in 0..basis.len() {
                    for b in 0..basis.len() {
                        let values = |n: usize| basis.at_node(n)[a] * basis.at_node(n)[b] * basis.nodes()[n].weight;
                        let product: f64 = (0..basis.nodes().len()).map(values).sum();
                        assert!((product - f64::from(u8::from(a == b))).abs() < 2e-11, "{shape:?} {degree} {a} {b} {product:e}");
                    }
                }
            }
        }
    }

    #[test]
    fn on_a_square_they_are_products_of_legendre_polynomials() {
        let basis = Basis::new(Shape::Parallelogram, 2);
        let (s, t) = (0.3_f64, 0.9_f64);
        let legendre = |n: usize, x: f64| {
            let x = 2.0 * x - 1.0;
            [1.0, x, 0.5 * (3.0 * x * x - 1.0)][n] * (2.0 * n as f64 + 1.0).sqrt()
        };
        for (value, [i, j]) in basis.values([s, t]).into_iter().zip([[0, 0], [1, 0], [0, 1], [1, 1], [2, 0], [0, 2]]) {
            assert!((value - legendre(i, s) * legendre(j, t)).abs() < 1e-13);
        }
    }

    #[test]
    fn a_polynomial_goes_down_to_the_children_and_back_up_unchanged() {
        for shape in SHAPES {
            let basis = Basis::new(shape, 3);
            let parent: Vec<f64> = (0..basis.len()).map(|i| 1.0 - 0.2 * i as f64).collect();
            let mut back = vec![0.0; basis.len()];
            for child in 0..4 {
                let of_child = basis.restrict(child, &parent);
                let place = [0.2, 0.7];
                let here: f64 = dot(&basis.values(place), &of_child);
                let there: f64 = dot(&basis.values(in_parent(shape, child, place)), &parent);
                assert!((here - there).abs() < 1e-11, "{shape:?} {child}: {here} {there}");
                basis.pull(child, &of_child, &mut back);
            }
            assert!(parent.iter().zip(&back).all(|(a, b)| (a - b).abs() < 1e-11));
        }
    }

    #[test]
    fn bernstein_coefficients_enclose_the_values_and_slopes_are_derivatives() {
        for shape in SHAPES {
            let basis = Basis::new(shape, 3);
            let coefficients: Vec<f64> = (0..basis.len()).map(|i| (i as f64 * 1.7).sin()).collect();
            let [low, high] = basis.range(&coefficients);
            for i in 0..=10 {
                for j in 0..=10 {
                    let place = [f64::from(i) / 10.0, f64::from(j) / 10.0];
                    if shape == Shape::Triangle && i + j > 10 {
                        continue;
                    }
                    let value = dot(&basis.values(place), &coefficients);
                    assert!((low - 1e-12..=high + 1e-12).contains(&value));
                    let step = 1e-6;
                    let ahead = dot(&basis.values([place[0] + step, place[1]]), &coefficients);
                    let slope: f64 = basis.slopes(place).iter().zip(&coefficients).map(|(s, c)| s[0] * c).sum();
                    assert!(((ahead - value) / step - slope).abs() < 1e-3);
                }
            }
            assert!(basis.magnitude(&coefficients) < 3.0 * largest(high, -low));
        }
    }
}
