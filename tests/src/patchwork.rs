//! Emissions that are polynomials on the cells of a grid, smooth, kinked or jumping from one to the next: as functions, and as
//! emitters whose closed forms add up to the truth.

use glam::DVec3;
use radgrad_audit::cases::sampler::Sampler;
use radgrad_core::{Answer, Emission, Emitter, Polygon, Polynomial, Receiver, evaluate_to};

/// `sum c (x - x0)^i (y - y0)^j`.
#[derive(Debug, Clone)]
struct Patch {
    origin: [f64; 2],
    terms: Vec<(f64, [u8; 2])>,
}

impl Patch {
    fn polynomial(&self) -> Polynomial {
        let origin = DVec3::new(self.origin[0], self.origin[1], 0.0);
        Polynomial::new(origin, self.terms.iter().map(|&(c, [i, j])| (c, [i, j, 0]))).unwrap()
    }
}

/// An emission on the square [0, 1]^2 of the plane z = 0, lit from above.
#[derive(Debug, Clone)]
pub struct Patchwork {
    /// Where the cells begin and end, along x and y.
    knots: [Vec<f64>; 2],
    /// One for each cell, those of one x together.
    patches: Vec<Polynomial>,
    /// Width of the smallest feature.
    pub detail: f64,
    /// Whether it is continuous, so that it has a gradient.
    pub is_continuous: bool,
}

/// The kinds of patchworks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// One polynomial of degree up to 8.
    Smooth,
    /// A grid of up to 9 x 9 constants.
    Texels,
    /// Two affine functions that jump at a line.
    Jump,
    /// Two affine functions that meet at a line.
    Kink,
    /// A bump 1/8 to 1/2 of the square wide, a cubic spline each way, on a constant or on nothing.
    Bump,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Smooth, Self::Texels, Self::Jump, Self::Kink, Self::Bump];

    /// A random one of the kind.
    #[must_use]
    pub fn patchwork(self, sampler: &mut Sampler) -> Patchwork {
        let whole = || vec![0.0, 1.0];
        match self {
            Self::Smooth => {
                let degree = u8::try_from(sampler.below(9)).unwrap();
                let powers = (0..=degree).flat_map(|i| (0..=degree - i).map(move |j| [i, j]));
                let terms: Vec<_> = powers.map(|powers| (sampler.between(-2.0, 2.0), powers)).collect();
                let patch = Patch { origin: [0.5, 0.5], terms: [&[(3.0, [0, 0])], &terms[..]].concat() };
                Patchwork::new([whole(), whole()], &[patch], f64::INFINITY, true)
            }
            Self::Texels => {
                let counts = [1 + sampler.below(9), 2 + sampler.below(8)];
                let knots = counts.map(|n| (0..=n).map(|k| f64::from(k) / f64::from(n)).collect());
                let texel = |_| Patch { origin: [0.0; 2], terms: vec![(sampler.uniform(), [0, 0])] };
                let texels: Vec<Patch> = (0..counts[0] * counts[1]).map(texel).collect();
                Patchwork::new(knots, &texels, 1.0 / f64::from(counts[0].max(counts[1])), false)
            }
            Self::Jump | Self::Kink => {
                let (line, level) = (sampler.between(0.05, 0.95), sampler.between(1.0, 2.0));
                let side = |_| {
                    let level = if self == Self::Jump { sampler.between(1.0, 2.0) } else { level };
                    Patch { origin: [line, 0.0], terms: vec![(level, [0, 0]), (sampler.between(-1.0, 1.0), [1, 0])] }
                };
                Patchwork::new([vec![0.0, line, 1.0], whole()], &[0, 1].map(side), line.min(1.0 - line), self == Self::Kink)
            }
            Self::Bump => bump(sampler),
        }
    }
}

/// Pieces of the cubic B-spline between its knots, by their coefficients.
const SPLINE: [[f64; 4]; 4] = [[0.0, 0.0, 0.0, 1.0], [1.0, 3.0, 3.0, -3.0], [4.0, 0.0, -6.0, 3.0], [1.0, -3.0, 3.0, -1.0]];

fn bump(sampler: &mut Sampler) -> Patchwork {
    let width = sampler.spread(-5, -3);
    let background = if sampler.one_in(2) { 0.0 } else { sampler.uniform() };
    let mut knots = || {
        let start = sampler.between(0.01, 0.99 - 4.0 * width);
        [&[0.0], &[0.0, 1.0, 2.0, 3.0, 4.0].map(|k| start + k * width)[..], &[1.0]].concat()
    };
    let knots = [knots(), knots()];
    let mut patches = Vec::new();
    for (i, x) in knots[0][..6].iter().enumerate() {
        for (j, y) in knots[1][..6].iter().enumerate() {
            let mut terms = vec![(background, [0, 0])];
            if let (1..=4, 1..=4) = (i, j) {
                for (p, c) in (0..4u8).zip(SPLINE[i - 1]) {
                    for (q, d) in (0..4u8).zip(SPLINE[j - 1]) {
                        terms.push((c * d / (0..p + q).fold(1.0, |product, _| product * width), [p, q]));
                    }
                }
            }
            patches.push(Patch { origin: [*x, *y], terms });
        }
    }
    Patchwork::new(knots, &patches, 2.0 * width, true)
}

impl Patchwork {
    fn new(knots: [Vec<f64>; 2], patches: &[Patch], detail: f64, is_continuous: bool) -> Self {
        Self { knots, patches: patches.iter().map(Patch::polynomial).collect(), detail, is_continuous }
    }

    fn patch(&self, y: DVec3) -> &Polynomial {
        let place = |knots: &[f64], c: f64| knots[1..knots.len() - 1].iter().take_while(|k| c >= **k).count();
        &self.patches[place(&self.knots[0], y.x) * (self.knots[1].len() - 1) + place(&self.knots[1], y.y)]
    }

    /// The emission at a point of the square.
    #[must_use]
    pub fn radiosity(&self, y: DVec3) -> f64 {
        self.patch(y).value_at(y)
    }

    /// Its gradient between the jumps.
    #[must_use]
    pub fn gradient(&self, y: DVec3) -> DVec3 {
        self.patch(y).gradient_at(y)
    }

    /// Radiosity and gradient, the sum of the cells' closed forms, with bounds on their errors.
    ///
    /// # Panics
    /// If a cell has no answer.
    #[must_use]
    pub fn truth(&self, receiver: &Receiver) -> Answer {
        let spans = |knots: &[f64]| knots.windows(2).map(|k| [k[0], k[1]]).collect::<Vec<_>>();
        let rows = spans(&self.knots[1]);
        let cells = spans(&self.knots[0]).into_iter().flat_map(|x| rows.iter().map(move |y| (x, *y)));
        let answers = cells.zip(&self.patches).map(|((x, y), patch)| {
            let emitter = Emitter::new(rectangle(x, y), Emission::Polynomial(patch.clone())).unwrap();
            evaluate_to(receiver, &emitter, &[], 1e-14).unwrap()
        });
        answers
            .reduce(|a, b| Answer {
                radiosity: a.radiosity + b.radiosity,
                gradient: a.gradient + b.gradient,
                radiosity_error: a.radiosity_error + b.radiosity_error,
                gradient_error: a.gradient_error + b.gradient_error,
                method: a.method,
            })
            .unwrap()
    }
}

/// The square that a patchwork lies on.
///
/// # Panics
/// Never.
#[must_use]
pub fn square() -> Polygon {
    rectangle([0.0, 1.0], [0.0, 1.0])
}

fn rectangle(x: [f64; 2], y: [f64; 2]) -> Polygon {
    let corners = [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])];
    Polygon::new(corners.map(|(x, y)| DVec3::new(x, y, 0.0)).to_vec()).unwrap()
}

/// A receiver 2^low to 2^high over the plane, above the square or beside it, from which some of the middle is in view.
///
/// # Panics
/// Never.
#[must_use]
pub fn receiver(sampler: &mut Sampler, low: i64, high: i64) -> Receiver {
    loop {
        let position = DVec3::new(sampler.between(-0.5, 1.5), sampler.between(-0.5, 1.5), sampler.spread(low, high));
        let normal = sampler.direction() - DVec3::Z * sampler.between(0.0, 1.5);
        let toward = DVec3::new(sampler.between(0.2, 0.8), sampler.between(0.2, 0.8), 0.0) - position;
        if normal.dot(toward) > 0.05 * normal.length() * toward.length() {
            return Receiver::new(position, normal, 0.8).unwrap();
        }
    }
}
