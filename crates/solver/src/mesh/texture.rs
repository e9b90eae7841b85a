//! Textures on an element: the operator S of R. Gershbein, P. Schroeder and P. Hanrahan (1993), kept apart from the transfer G.
//!
//! With the irradiance `H = G B` of an element known as `H_h = sum h_k phi_k`, its radiosity `E + rho H_h` has the projection
//! `b_i = <E, phi_i> + sum_k S_ik h_k` with `S_ik = <rho phi_k, phi_i>`, means over the leaf. A texture is constant on texels, so
//! the leaf is cut along their edges ([`radgrad_scene::Texture::cut`]) and these are sums of integrals
//! of polynomials, exact but for rounding.
//!
//! The remainder of the projection, `t = E + rho H_h - B_h`, is the texture's detail. For one pair `(rho, E)` it is a polynomial,
//! between the least and the largest of its Bernstein coefficients `E + rho H_j - B_j`; these are affine in the pair, so that their
//! extremes over the leaf are at corners of the convex hull of all pairs. The mean square of t comes from `<E^2>`, `<rho E phi_k>`
//! and `<rho^2 phi_i phi_k>`; where t is nearly 0 it loses digits as differences of squares do, and the former bound is less. Here
//! E is emission with a texture alone.

use radgrad_scene::{Face, Material, Quantity, Scene, largest, smallest};

use crate::mesh::basis::{Basis, dot};
use crate::mesh::element::Element;
use crate::mesh::rule::{self, Node};
use crate::mesh::shape::Shape;

/// Pieces of no more than this part of a leaf are left by rounding along edges that coincide, of texels of two textures or of a
/// texel and the leaf: which texel is there is not determined.
const SLIVER: f64 = 1e-13;

/// The effect of one channel's textures on polynomials on a leaf.
#[derive(Debug, Clone, Default)]
pub(crate) struct Pattern {
    /// `<E, phi_i>`.
    emitted: Vec<f64>,
    /// `<rho phi_i, phi_k>`, row by row.
    reflected: Vec<f64>,
    /// `<rho^2 phi_i phi_k>`, row by row.
    squared: Vec<f64>,
    /// `<rho E phi_k>`.
    crossed: Vec<f64>,
    /// `<E^2>`.
    emitted_squared: f64,
    /// Corners of the convex hull of all pairs of reflectance and emission.
    pairs: Vec<[f64; 2]>,
}

/// The detail of a texture that a projection leaves out, bounded over a leaf.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Detail {
    /// Largest magnitude.
    pub(crate) largest: f64,
    /// Mean magnitude.
    pub(crate) mean: f64,
}

impl Pattern {
    /// Projection of `rho H` from the coefficients of H.
    pub(crate) fn reflected(&self, irradiance: &[f64]) -> Vec<f64> {
        self.reflected.chunks(irradiance.len()).map(|row| dot(row, irradiance)).collect()
    }

    /// Projection of E.
    pub(crate) fn emitted(&self) -> &[f64] {
        &self.emitted
    }

    /// Projection of rho.
    pub(crate) fn reflectance(&self) -> &[f64] {
        &self.reflected[..self.emitted.len()]
    }

    /// Bounds on the remainder of the projection of `E + rho H`, or of `rho H` alone.
    pub(crate) fn detail(&self, basis: &Basis, irradiance: &[f64], with_emission: bool) -> Detail {
        let emits = if with_emission { 1.0 } else { 0.0 };
        let mut radiosity = self.reflected(irradiance);
        radiosity.iter_mut().zip(&self.emitted).for_each(|(b, e)| *b += emits * e);
        let (h, b) = (basis.bernstein(irradiance), basis.bernstein(&radiosity));
        let of_pair = |[rho, e]: &[f64; 2]| h.iter().zip(&b).map(|(h, b)| (emits * e + rho * h - b).abs()).fold(0.0, largest);
        let largest_detail = self.pairs.iter().map(of_pair).fold(0.0, largest);
        let squared: f64 = self.squared.chunks(irradiance.len()).zip(irradiance).map(|(row, h)| h * dot(row, irradiance)).sum();
        let whole = emits * (self.emitted_squared + 2.0 * dot(&self.crossed, irradiance)) + squared;
        let taken = dot(&radiosity, &radiosity);
        // Each sum is rounded a few times for each function.
        let rounding = 64.0 * f64::EPSILON * (whole + 3.0 * taken);
        Detail { largest: largest_detail, mean: smallest((largest(whole - taken, 0.0) + rounding).sqrt(), largest_detail) }
    }

    pub(crate) fn mean_reflectance(&self) -> f64 {
        self.reflected.first().copied().unwrap_or(0.0)
    }

    /// Root mean squares of the reflectance, of its difference from its mean, and of its difference from its projection.
    pub(crate) fn spread_of_reflectance(&self) -> [f64; 3] {
        let whole = self.squared.first().copied().unwrap_or(0.0);
        let without = |count: usize| {
            let taken: f64 = self.reflected.iter().take(count).map(|c| c * c).sum();
            (largest(whole - taken, 0.0) + 16.0 * f64::EPSILON * whole).sqrt()
        };
        [whole.sqrt(), without(1), without(self.emitted.len())]
    }

    fn new(len: usize) -> Self {
        // Half of each, until all pieces are in.
        let matrix = vec![0.0; len * (len + 1) / 2];
        Self {
            emitted: vec![0.0; len],
            reflected: matrix.clone(),
            squared: matrix,
            crossed: vec![0.0; len],
            emitted_squared: 0.0,
            pairs: Vec::new(),
        }
    }

    /// Adds a piece with the mean products of the functions over the leaf, restricted to the piece: of each with those from it on.
    fn add(&mut self, products: &[f64], [rho, e]: [f64; 2]) {
        let len = self.emitted.len();
        for ((reflected, squared), product) in self.reflected.iter_mut().zip(&mut self.squared).zip(products) {
            *reflected += rho * product;
            *squared += rho * rho * product;
        }
        for (index, function) in products.iter().take(len).enumerate() {
            self.emitted[index] += e * function;
            self.crossed[index] += rho * e * function;
        }
        self.emitted_squared += e * e * products[0];
        if products[0] <= SLIVER {
            return;
        }
        if self.pairs.len() >= 64 {
            self.pairs = hull(std::mem::take(&mut self.pairs));
        }
        if self.pairs.last() != Some(&[rho, e]) {
            self.pairs.push([rho, e]);
        }
    }
}

/// The patterns of an element in each channel; `None` where nothing varies on its face.
pub(crate) fn patterns(scene: &Scene, element: &Element, basis: &Basis) -> Option<Vec<Pattern>> {
    let face = &scene.faces()[element.face()];
    let material = &scene.materials()[face.material()];
    if Quantity::ALL.iter().all(|&quantity| face.chart(quantity).is_none()) {
        return None;
    }
    let corners: &[[f64; 2]] = match element.shape() {
        Shape::Parallelogram => &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
        Shape::Triangle => &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
    };
    let channels = scene.channels().len();
    let mut patterns = vec![Pattern::new(basis.len()); channels];
    let mut rules = Rules::new(basis);
    cut(face, material, Quantity::Reflectance, element, corners, &mut |corners, rho| {
        cut(face, material, Quantity::Radiance, element, corners, &mut |corners, radiance| {
            let products = rules.products(basis, corners);
            for (channel, pattern) in patterns.iter_mut().enumerate() {
                let value = |quantity, texel: Option<&[f64]>| {
                    material.factors(quantity)[channel] * texel.map_or(1.0, |texel| texel[channel])
                };
                // Even emission is a polynomial, or that of a lamp kept apart: it leaves nothing out.
                let emitted = if radiance.is_some() { value(Quantity::Radiance, radiance) } else { 0.0 };
                let pair = [value(Quantity::Reflectance, rho), std::f64::consts::PI * emitted];
                pattern.add(products, pair);
            }
        });
    });
    for pattern in &mut patterns {
        pattern.pairs = hull(std::mem::take(&mut pattern.pairs));
        pattern.reflected = square(&pattern.reflected, basis.len());
        pattern.squared = square(&pattern.squared, basis.len());
    }
    Some(patterns)
}

/// A visitor of the parts of an element, each with the texel on it.
type Take<'f, 'a> = dyn FnMut(&[[f64; 2]], Option<&'a [f64]>) + 'f;

/// Cuts a part of an element by one of its textures; without one the part is whole.
fn cut<'a>(
    face: &Face,
    material: &'a Material,
    quantity: Quantity,
    element: &Element,
    corners: &[[f64; 2]],
    take: &mut Take<'_, 'a>,
) {
    match (material.texture(quantity), face.chart(quantity)) {
        (Some(texture), Some(chart)) => {
            let coordinates = |reference| chart.coordinates(element.point(reference));
            texture.cut(corners, coordinates, |piece| take(&piece.corners, Some(piece.values)));
        }
        _ => take(corners, None),
    }
}

/// Rules that integrate products of two functions.
struct Rules {
    /// On a rectangle along the axes.
    rectangle: Vec<Node>,
    /// On any triangle.
    triangle: Vec<Node>,
    /// Area of the whole element in its coordinates: means are over it.
    area: f64,
    values: Vec<f64>,
    products: Vec<f64>,
}

/// A symmetric matrix from the entries on its diagonal and right of it, row by row.
fn square(upper: &[f64], len: usize) -> Vec<f64> {
    let entry = |i: usize, k: usize| upper[i * len - i * (i + 1) / 2 + k];
    (0..len * len).map(|index| entry((index / len).min(index % len), (index / len).max(index % len))).collect()
}

impl Rules {
    fn new(basis: &Basis) -> Self {
        let degree = basis.degree();
        // Of total degree 4 and 2 times that of the basis; the rule carried from the square loses one.
        let (triangle, area) = match basis.shape() {
            Shape::Parallelogram => (rule::collapsed(2 * degree + 1), 1.0),
            Shape::Triangle => (rule::collapsed(degree + 1), 0.5),
        };
        let (len, rectangle) = (basis.len(), rule::product(degree + 1));
        Self { rectangle, triangle, area, values: vec![0.0; len], products: vec![0.0; len * (len + 1) / 2] }
    }

    /// Means over the element of the products of any two functions on a convex part of it: of each with those from it on.
    fn products(&mut self, basis: &Basis, corners: &[[f64; 2]]) -> &[f64] {
        let Self { rectangle, triangle, area, values, products } = self;
        products.fill(0.0);
        let mut add = |at: [f64; 2], weight: f64| {
            basis.fill(at, values);
            let mut rows = &mut products[..];
            for (i, a) in values.iter().enumerate() {
                let (row, after) = rows.split_at_mut(values.len() - i);
                row.iter_mut().zip(&values[i..]).for_each(|(sum, b)| *sum += weight * a * b);
                rows = after;
            }
        };
        if let Some([low, high]) = along_axes(corners) {
            let size = [high[0] - low[0], high[1] - low[1]];
            for node in &*rectangle {
                add([0, 1].map(|k| low[k] + size[k] * node.at[k]), node.weight * size[0] * size[1] / *area);
            }
        } else {
            for i in 1..corners.len() - 1 {
                let [a, b, c] = [corners[0], corners[i], corners[i + 1]];
                let (u, v) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
                let part = 0.5 * (u[0] * v[1] - u[1] * v[0]);
                for node in &*triangle {
                    add([0, 1].map(|k| a[k] + u[k] * node.at[0] + v[k] * node.at[1]), node.weight * part / *area);
                }
            }
        }
        products
    }
}

/// The corners of a rectangle along the axes; cuts may round a side off them.
fn along_axes(corners: &[[f64; 2]]) -> Option<[[f64; 2]; 2]> {
    let &[a, b, c, d] = corners else { return None };
    let same = |p: [f64; 2], q: [f64; 2], k: usize| (p[k] - q[k]).abs() <= 8.0 * f64::EPSILON;
    let turned = |i: usize, k: usize| same(a, b, i) && same(b, c, k) && same(c, d, i) && same(d, a, k);
    (turned(0, 1) || turned(1, 0))
        .then(|| [[smallest(a[0], c[0]), smallest(a[1], c[1])], [largest(a[0], c[0]), largest(a[1], c[1])]])
}

/// Corners of the convex hull of points (A. Andrew 1979). Signs are those of doubles: a corner lost to their rounding is that near
/// to the edge that passes it.
fn hull(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    points.dedup();
    if points.len() < 3 {
        return points;
    }
    let turns = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0.0;
    let half = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for point in points {
            while chain.len() >= 2 && !turns(chain[chain.len() - 2], chain[chain.len() - 1], point) {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let (lower, upper) = (half(&mut points.iter().copied()), half(&mut points.iter().rev().copied()));
    [lower, upper].concat()
}
