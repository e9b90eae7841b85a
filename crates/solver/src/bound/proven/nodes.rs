//! How far the places of an element are from its nodes, and how much a projection may enlarge what it is given.

use radgrad_scene::largest;

use crate::mesh::basis::Basis;
use crate::mesh::shape::Shape;

/// What bounds are raised by for the rounding of the sums and products that they are.
pub(super) const ROUNDED: f64 = 1.0 + 1e-9;

/// Cells along each side of the reference shape in which distances from nodes are bounded.
const CELLS: u32 = 20;

/// The places nearest to a node, in reference coordinates: each is the node plus `ds`, `dt`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Near {
    pub(super) node: usize,
    /// Bounds on the largest `|ds|` and `|dt|`.
    pub(super) most: [f64; 2],
}

/// What a basis' nodes say of places between them.
#[derive(Debug, Clone)]
pub(super) struct Nodes {
    /// These parts make up the shape.
    pub(super) near: Vec<Near>,
    /// Bound on the largest magnitude of the projection of samples of at most 1.
    pub(super) lebesgue: f64,
    /// Bounds on the rounding of a projection, its largest magnitude and its root mean square, over that of one term of a sum and the
    /// samples: the functions are sums of monomials.
    pub(super) rounding: [f64; 2],
    degree: usize,
    shape: Shape,
}

impl Nodes {
    pub(super) fn of(basis: &Basis) -> Self {
        let nodes = basis.nodes();
        let empty = |node| Near { node, most: [0.0; 2] };
        let mut near: Vec<Near> = (0..nodes.len()).map(empty).collect();
        for corners in &cells(basis.shape()) {
            let off = |node: usize, k: usize| corners.iter().map(move |c| (c[k] - nodes[node].at[k]).abs());
            let most = |node: usize, k: usize| off(node, k).fold(0.0, largest);
            let size = |node: usize| most(node, 0) + most(node, 1);
            let nearest = (0..nodes.len()).min_by(|&a, &b| size(a).total_cmp(&size(b))).unwrap_or(0);
            let at = &mut near[nearest];
            at.most = [0, 1].map(|k| largest(at.most[k], most(nearest, k)));
        }
        near.retain(|at| at.most != [0.0; 2]);
        let mut sums = vec![0.0; basis.bernstein(&vec![0.0; basis.len()]).len()];
        for (node, of) in nodes.iter().enumerate().filter(|(_, node)| node.weight != 0.0) {
            let polynomial: Vec<f64> = basis.at_node(node).iter().map(|value| value * of.weight).collect();
            sums.iter_mut().zip(basis.bernstein(&polynomial)).for_each(|(sum, b)| *sum += b.abs());
        }
        let lebesgue = sums.into_iter().fold(1.0, largest) * ROUNDED;
        let of = |(function, size): (usize, &f64)| {
            let sum: f64 = basis.monomials(function).map(|(c, _)| c.abs()).sum();
            [sum * size, sum * sum]
        };
        let sums = basis.sizes().iter().enumerate().map(of).fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d]);
        let rounding = [sums[0], sums[1].sqrt()].map(|sum| sum * (basis.len() + basis.nodes().len()) as f64);
        Self { near, lebesgue, rounding, degree: basis.degree(), shape: basis.shape() }
    }

    /// The place of a Bernstein coefficient: of degree `a` in `s` and `b` in `t`.
    const fn place(&self, a: usize, b: usize) -> usize {
        let n = self.degree;
        match self.shape {
            Shape::Parallelogram => a * (n + 1) + b,
            // Rows of n + 1, n, n - 1 and so on.
            Shape::Triangle => a * (n + 1) - a * a.saturating_sub(1) / 2 + b,
        }
    }

    /// The Bernstein coefficients along a side, from its first corner to its second: of the polynomial on that side.
    pub(super) fn along_side(&self, side: usize, bernstein: &[f64]) -> impl DoubleEndedIterator<Item = f64> {
        let n = self.degree;
        let place = move |k: usize| match (self.shape, side) {
            (_, 0) => self.place(k, 0),
            (Shape::Parallelogram, 1) => self.place(n, k),
            (Shape::Parallelogram, 2) => self.place(n - k, n),
            (Shape::Triangle, 1) => self.place(n - k, k),
            _ => self.place(0, n - k),
        };
        (0..=n).map(move |k| bernstein[place(k)])
    }

    /// Bounds on the magnitudes of the derivatives in `s` and `t` of what has these Bernstein coefficients.
    pub(super) fn slopes(&self, bernstein: &[f64]) -> [f64; 2] {
        let n = self.degree;
        if n == 0 {
            return [0.0; 2];
        }
        let last = |a: usize| if self.shape == Shape::Triangle { n - a } else { n };
        let mut most = [0.0_f64; 2];
        for a in 0..=n {
            for b in 0..=last(a) {
                let here = bernstein[self.place(a, b)];
                if a < n && b <= last(a + 1) {
                    most[0] = largest(most[0], (bernstein[self.place(a + 1, b)] - here).abs());
                }
                if b < last(a) {
                    most[1] = largest(most[1], (bernstein[self.place(a, b + 1)] - here).abs());
                }
            }
        }
        most.map(|difference| n as f64 * difference)
    }
}

/// The reference shape in cells of one area, by their corners.
fn cells(shape: Shape) -> Vec<Vec<[f64; 2]>> {
    let at = |i: u32| f64::from(i) / f64::from(CELLS);
    let mut cells = Vec::new();
    for i in 0..CELLS {
        for j in 0..CELLS {
            let (s, t) = ([at(i), at(i + 1)], [at(j), at(j + 1)]);
            match shape {
                Shape::Parallelogram => cells.push(vec![[s[0], t[0]], [s[1], t[0]], [s[1], t[1]], [s[0], t[1]]]),
                Shape::Triangle => {
                    if i + j < CELLS {
                        cells.push(vec![[s[0], t[0]], [s[1], t[0]], [s[0], t[1]]]);
                    }
                    if i + j + 1 < CELLS {
                        cells.push(vec![[s[1], t[0]], [s[1], t[1]], [s[0], t[1]]]);
                    }
                }
            }
        }
    }
    cells
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bernstein's coefficients at the ends of a side are the values there.
    #[test]
    fn along_a_side_are_the_coefficients_from_its_first_corner_to_its_second() {
        for shape in [Shape::Parallelogram, Shape::Triangle] {
            let corners: &[[f64; 2]] = match shape {
                Shape::Parallelogram => &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
                Shape::Triangle => &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
            };
            for degree in 0..4 {
                let basis = Basis::of_fewest_nodes(shape, degree);
                let nodes = Nodes::of(&basis);
                let coefficients: Vec<f64> = (0..basis.len()).map(|k| (k as f64 + 1.0).sin()).collect();
                let bernstein = basis.bernstein(&coefficients);
                let value = |at: [f64; 2]| -> f64 { basis.values(at).iter().zip(&coefficients).map(|(f, c)| f * c).sum() };
                for (side, &start) in corners.iter().enumerate() {
                    let end = corners[(side + 1) % corners.len()];
                    let along: Vec<f64> = nodes.along_side(side, &bernstein).collect();
                    for k in 0..=10 {
                        let t = 0.1 * f64::from(k);
                        let mut casteljau = along.clone();
                        while casteljau.len() > 1 {
                            casteljau = casteljau.windows(2).map(|pair| pair[0] + t * (pair[1] - pair[0])).collect();
                        }
                        let there = value([0, 1].map(|axis| start[axis] + t * (end[axis] - start[axis])));
                        assert!((casteljau[0] - there).abs() < 1e-12, "{shape:?} {degree} {side} {t}: {along:?}");
                    }
                }
            }
        }
    }
}
