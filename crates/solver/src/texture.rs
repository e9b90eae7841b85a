//! Textures on an element: the operator S of R. Gershbein, P. Schroeder and P. Hanrahan (1993), kept apart from the transfer G.
//!
//! With the irradiance `H = G B` of a leaf known as `H_h = sum h_k phi_k`, its radiosity `E + rho H_h` has the projection
//! `b_i = <E, phi_i> + sum_k S_ik h_k` with `S_ik = <rho phi_k, phi_i>`, means over the leaf. A texture is constant on texels, so
//! the leaf is cut along their edges ([`radgrad_scene::Texture::cut`]) and these are sums of integrals of polynomials, exact but for rounding.
//!
//! What the projection leaves out, `t = E + rho H_h - B_h`, is the texture's detail. For one pair `(rho, E)` it is a polynomial,
//! between the least and the largest of its Bernstein coefficients `E + rho H_j - B_j`; these are affine in the pair, so that their
//! extremes over the leaf are at corners of the convex hull of all pairs. The mean square of t comes from `<E^2>`, `<rho E phi_k>`
//! and `<rho^2 phi_i phi_k>`; where t is nearly 0 it loses digits as differences of squares do, and the former bound is less.

use radgrad_scene::{Face, Material, Quantity, Scene};

use crate::basis::{Basis, Shape};
use crate::element::Element;
use crate::rule::{self, Node};

/// Pieces of no more than this part of a leaf are what rounding leaves along edges that coincide, of texels of two textures or of
/// a texel and the leaf: which texel is there is not determined.
const SLIVER: f64 = 1e-13;

/// What the textures of one channel do to polynomials on a leaf.
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
    /// Projection of `E + rho H` from the coefficients of H.
    pub(crate) fn radiosity(&self, irradiance: &[f64]) -> Vec<f64> {
        self.reflected.chunks(irradiance.len()).zip(&self.emitted).map(|(row, e)| e + dot(row, irradiance)).collect()
    }

    /// Bounds on `E + rho H - B`.
    pub(crate) fn detail(&self, basis: &Basis, irradiance: &[f64], radiosity: &[f64]) -> Detail {
        let (h, b) = (basis.bernstein(irradiance), basis.bernstein(radiosity));
        let of_pair = |[rho, e]: &[f64; 2]| h.iter().zip(&b).map(|(h, b)| (e + rho * h - b).abs()).fold(0.0, f64::max);
        let largest = self.pairs.iter().map(of_pair).fold(0.0, f64::max);
        let squared: f64 = self.squared.chunks(irradiance.len()).zip(irradiance).map(|(row, h)| h * dot(row, irradiance)).sum();
        let whole = self.emitted_squared + 2.0 * dot(&self.crossed, irradiance) + squared;
        let (both, own) = (dot(&self.radiosity(irradiance), radiosity), dot(radiosity, radiosity));
        // Each sum is rounded a few times for each function.
        let rounding = 64.0 * f64::EPSILON * (whole + 2.0 * both.abs() + own);
        Detail { largest, mean: ((whole - 2.0 * both + own).max(0.0) + rounding).sqrt().min(largest) }
    }

    pub(crate) fn largest_reflectance(&self) -> f64 {
        self.pairs.iter().fold(0.0, |most, pair| most.max(pair[0]))
    }

    pub(crate) fn mean_reflectance(&self) -> f64 {
        self.reflected.first().copied().unwrap_or(0.0)
    }

    /// Root mean square of the reflectance, and of what its projection leaves out.
    pub(crate) fn spread_of_reflectance(&self) -> [f64; 2] {
        let all = self.squared.first().copied().unwrap_or(0.0);
        let taken: f64 = self.reflected.iter().take(self.emitted.len()).map(|c| c * c).sum();
        [all.sqrt(), ((all - taken).max(0.0) + 16.0 * f64::EPSILON * all).sqrt()]
    }

    fn new(len: usize) -> Self {
        let matrix = vec![0.0; len * len];
        Self {
            emitted: vec![0.0; len],
            reflected: matrix.clone(),
            squared: matrix,
            crossed: vec![0.0; len],
            emitted_squared: 0.0,
            pairs: Vec::new(),
        }
    }

    /// Adds a piece with the mean products of the functions over the leaf, restricted to the piece.
    fn add(&mut self, products: &[f64], [rho, e]: [f64; 2]) {
        let len = self.emitted.len();
        for (index, product) in products.iter().enumerate() {
            self.reflected[index] += rho * product;
            self.squared[index] += rho * rho * product;
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

/// The patterns of a leaf in each channel; `None` where nothing varies on its face.
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
    let rules = Rules::new(basis);
    cut(face, material, Quantity::Reflectance, element, corners, &mut |corners, rho| {
        cut(face, material, Quantity::Radiance, element, corners, &mut |corners, radiance| {
            let products = rules.products(basis, corners);
            for (channel, pattern) in patterns.iter_mut().enumerate() {
                let value = |quantity, texel: Option<&[f64]>| {
                    material.factors(quantity)[channel] * texel.map_or(1.0, |texel| texel[channel])
                };
                let pair = [value(Quantity::Reflectance, rho), std::f64::consts::PI * value(Quantity::Radiance, radiance)];
                pattern.add(&products, pair);
            }
        });
    });
    for pattern in &mut patterns {
        pattern.pairs = hull(std::mem::take(&mut pattern.pairs));
    }
    Some(patterns)
}

/// What takes a part of an element and the texel on it.
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
            let at = |reference| chart.coordinates(element.point(reference));
            texture.cut(corners, at, |piece| take(&piece.corners, Some(piece.values)));
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
    /// Weight of the whole element: means are over it.
    area: f64,
}

impl Rules {
    fn new(basis: &Basis) -> Self {
        let degree = basis.degree();
        // Of total degree 4 and 2 times that of the basis; the rule carried from the square loses one.
        match basis.shape() {
            Shape::Parallelogram => {
                Self { rectangle: rule::product(degree + 1), triangle: rule::collapsed(2 * degree + 1), area: 1.0 }
            }
            Shape::Triangle => Self { rectangle: rule::product(degree + 1), triangle: rule::collapsed(degree + 1), area: 0.5 },
        }
    }

    /// Means over the element of the products of any two functions on a convex part of it.
    fn products(&self, basis: &Basis, corners: &[[f64; 2]]) -> Vec<f64> {
        let mut products = vec![0.0; basis.len() * basis.len()];
        let mut add = |at: [f64; 2], weight: f64| {
            let values = basis.values(at);
            for (i, a) in values.iter().enumerate() {
                for (k, b) in values.iter().enumerate().skip(i) {
                    products[i * values.len() + k] += weight * a * b;
                }
            }
        };
        if let Some([low, high]) = rectangle(corners) {
            let size = [high[0] - low[0], high[1] - low[1]];
            for node in &self.rectangle {
                add([0, 1].map(|k| low[k] + size[k] * node.at[k]), node.weight * size[0] * size[1] / self.area);
            }
        } else {
            for i in 1..corners.len() - 1 {
                let [a, b, c] = [corners[0], corners[i], corners[i + 1]];
                let (u, v) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
                let area = 0.5 * (u[0] * v[1] - u[1] * v[0]);
                for node in &self.triangle {
                    add([0, 1].map(|k| a[k] + u[k] * node.at[0] + v[k] * node.at[1]), node.weight * area / self.area);
                }
            }
        }
        for i in 0..basis.len() {
            for k in 0..i {
                products[i * basis.len() + k] = products[k * basis.len() + i];
            }
        }
        products
    }
}

/// The corners of a rectangle along the axes.
fn rectangle(corners: &[[f64; 2]]) -> Option<[[f64; 2]; 2]> {
    let &[a, b, c, d] = corners else { return None };
    let along = a[1] == b[1] && b[0] == c[0] && c[1] == d[1] && d[0] == a[0];
    let across = a[0] == b[0] && b[1] == c[1] && c[0] == d[0] && d[1] == a[1];
    (along || across).then(|| [[a[0].min(c[0]), a[1].min(c[1])], [a[0].max(c[0]), a[1].max(c[1])]])
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

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
