//! What a projection leaves out of light that is smooth, from more places than its nodes.
//!
//! | symbol | meaning |
//! |---|---|
//! | `S` | the irradiance of sources that are wholly seen from all of an element |
//! | `P S`, `r` | its projection from the element's nodes, and `S - P S` |
//! | `Q` | interpolation by Legendre polynomials of degree n in s and in t at `(n + 1)^2` Gauss nodes |
//! | `q` | what a polynomial p of degree n leaves of S: Taylor's (module [`super`], by sources) or one in each coordinate ([`super::continued`]) |
//! | `d` | bound on the errors of the evaluations at the nodes of Q |
//!
//! `Q p = p` for polynomials p of degree n, and so for P S. So `S - Q S = (S - p) - Q (S - p)`, and `r = Q r + (S - Q S)`.
//!
//! The nodes' rule is exact for the square of what Q gives, so that the root mean square of `Q g` is that of g at the nodes: in the mean
//! `|r|` is at most that of r at the nodes, and `2 q + d` more. As for all p of that degree
//! `|p(x)|^2 <= sum_k (2k + 1) sum_l (2l + 1) mean p^2 = (n + 1)^4 mean p^2`, `|Q g|` is at most `(n + 1)^2` times the largest `|g|` at
//! the nodes, so that `|r|` is at most the sum of the magnitudes of the Legendre series of Q r, and `q + (n + 1)^2 (q + d)` more.
//! Sources count together, with their signs; q and d add up. The part of r along the polynomials of P is that of Q r, which the rule of the
//! nodes gives exactly, and in the mean square `2 q + d` more.
//!
//! Where sources are near, q is small on cells of the element alone: it is then cut into cells, each with its own Q and q. Of q counts the
//! root mean square over the cells, and for the largest value the largest one.

use radgrad_core::mutant;
use radgrad_scene::{gauss_legendre, largest};

use super::left::{Gathered, Kind, Left, Light, Proof};
use super::nodes::ROUNDED;
use super::terms::Target;
use crate::links::station::Station;
use crate::mesh::Sight;
use crate::mesh::element::Element;
use crate::mesh::shape::{Shape, in_parent};

/// Degrees that are tried: the last only where an element may be cut into cells, as little else is left there.
const DEGREES: [usize; 6] = [3, 5, 7, 9, 12, 16];

/// The degree that is taken where none is enough. A higher one raises the bound on the largest value, in which what polynomials leave counts
/// `(n + 1)^2` times.
const FALLBACK: usize = DEGREES[DEGREES.len() - 2];

/// How often an element is cut into four at most, where it may be cut, and evaluations on all its cells.
const MOST_CUTS: usize = 2;
const MOST_EVALUATIONS: usize = 10_000;

/// Share of the residual at the nodes up to which what polynomials leave may go; above it more nodes are tried. The part of the residual along
/// an element's polynomials counts whole in the mean, the rest for what the importance has beyond them.
const PART: f64 = 1e-4;

/// The same of the light: less is enough.
const LITTLE: f64 = 1e-8;

/// A cell of an element, and the corner of its square in the reference coordinates of the element.
type Cell = (Element, [f64; 2]);

/// Sources that count together: which do, and their residual in each channel.
#[derive(Debug, Default)]
pub(super) struct Finely {
    pub(super) takes: Vec<bool>,
    pub(super) left: Vec<Left>,
    /// For each channel the residual's part along the element's polynomials, and a bound on the root mean square by which that is off.
    pub(super) along: Vec<(Vec<f64>, f64)>,
}

impl Proof<'_> {
    /// The residual of the sources that count for less together than each by itself; `alone` is the mean residual of a source by
    /// itself, summed over the channels.
    pub(super) fn finely(
        &self,
        to: usize,
        light: &Light<'_>,
        gathered: &Gathered<'_>,
        kinds: &[Kind],
        alone: &dyn Fn(usize) -> f64,
    ) -> Finely {
        let element = &self.mesh.elements()[to];
        if element.shape() != Shape::Parallelogram {
            return Finely { takes: vec![false; kinds.len()], ..Finely::default() };
        }
        let cells = self.cells(to);
        let below = cells.iter().map(|cells| cells.iter().map(|(cell, corner)| (cell, *corner)).collect());
        let levels: Vec<Vec<(&Element, [f64; 2])>> = std::iter::once(vec![(element, [0.0; 2])]).chain(below).collect();
        let on = |levels: &[Vec<(&Element, [f64; 2])>]| self.finely_on(to, levels, light, (gathered, kinds), alone);
        // Where cells are not enough they are not worth their work.
        let in_cells = if levels.len() > 1 { on(&levels) } else { None };
        in_cells.or_else(|| on(&levels[..1])).unwrap_or_else(|| Finely { takes: vec![false; kinds.len()], ..Finely::default() })
    }

    /// The same on the element or on its cells, by how often it is cut into four. `None` if there is nothing to count, and in cells if too much
    /// is left of Taylor's series.
    fn finely_on(
        &self,
        to: usize,
        levels: &[Vec<(&Element, [f64; 2])>],
        light: &Light<'_>,
        (gathered, kinds): (&Gathered<'_>, &[Kind]),
        alone: &dyn Fn(usize) -> f64,
    ) -> Option<Finely> {
        let (element, basis) = (&self.mesh.elements()[to], self.mesh.basis(to));
        let target = self.target(to, element);
        let degrees = &DEGREES[usize::from(basis.degree() > DEGREES[0])..DEGREES.len() - usize::from(self.deepest == 0)];
        let highest = degrees[degrees.len() - 1];
        let coefficients =
            |source: usize| -> Vec<Vec<f64>> { (0..self.channels).map(|channel| light.of(self.mesh, source, channel)).collect() };
        // For each channel, in the root mean square over the cells of a level and the largest on one of them.
        let beyond = |source: usize, (level, degree): (usize, usize)| -> Vec<Left> {
            let targets: Vec<Target<'_>> = levels[level].iter().map(|(cell, _)| self.target(to, cell)).collect();
            let part = 1.0 / targets.len() as f64;
            let of = |held: &Vec<f64>| {
                let polynomial = self.polynomial(source, held);
                let on_cells = targets.iter().map(|target| self.smooth(target, source, &polynomial, degree));
                let (most, square) = on_cells.fold((0.0, 0.0), |(most, square), q| (largest(most, q), square + part * q * q));
                Left { largest: most, mean: square.sqrt() }
            };
            coefficients(source).iter().map(of).collect()
        };
        let takes: Vec<bool> = (gathered.sources.iter().zip(kinds).enumerate())
            .map(|(index, ((source, _), kind))| {
                let by_itself = |level: usize| 2.0 * beyond(*source, (level, highest)).iter().map(|of| of.mean).sum::<f64>();
                *kind == Kind::Clear
                    && self.in_front(&target, *source)
                    && (0..levels.len()).any(|level| 2.0 * by_itself(level) < alone(index))
            })
            .collect();
        let taken: Vec<usize> =
            gathered.sources.iter().zip(&takes).filter(|(_, takes)| **takes).map(|((source, _), _)| *source).collect();
        if taken.is_empty() {
            return None;
        }
        // What their projection is off at the nodes that it is made of.
        let held: Vec<Vec<f64>> = (0..self.channels)
            .map(|channel| {
                let mut at_nodes = vec![0.0; basis.nodes().len()];
                for (index, (source, _)) in gathered.sources.iter().enumerate().filter(|(index, _)| takes[*index]) {
                    let held = light.of(self.mesh, *source, channel);
                    at_nodes.iter_mut().enumerate().for_each(|(node, sum)| *sum += (gathered.value)(index, node, &held));
                }
                let held = basis.project(&at_nodes);
                let off = |node: usize| at_nodes[node] - basis.at_node(node).iter().zip(&held).map(|(f, c)| f * c).sum::<f64>();
                let most = (0..at_nodes.len()).map(|node| off(node).abs()).fold(0.0, largest);
                held.into_iter().chain([most]).collect()
            })
            .collect();
        let left_by = |way: (usize, usize)| -> Vec<Left> {
            let mut sums = vec![Left::default(); self.channels];
            taken.iter().for_each(|&source| sums.iter_mut().zip(beyond(source, way)).for_each(|(sum, of)| *sum = sum.and(of)));
            sums
        };
        let places = |&(level, degree): &(usize, usize)| levels[level].len() * (degree + 1) * (degree + 1);
        let ways = (0..levels.len()).flat_map(|level| degrees.iter().map(move |&degree| (level, degree)));
        let mut ways: Vec<(usize, usize)> =
            ways.filter(|way| way.0 == 0 || places(way) * taken.len() <= MOST_EVALUATIONS).collect();
        ways.sort_by_key(places);
        let enough = |way: (usize, usize)| {
            let left = left_by(way);
            left.iter()
                .zip(&held)
                .all(|(left, held)| left.mean <= largest(PART * held[basis.len()], LITTLE * held[0].abs()))
                .then_some((way, left))
        };
        let ((level, degree), beyond) = match ways.into_iter().find_map(enough) {
            Some(found) => found,
            None if levels.len() > 1 => return None,
            None => ((0, FALLBACK), left_by((0, FALLBACK))),
        };

        let sources: Vec<(usize, Vec<Vec<f64>>)> = taken.iter().map(|&source| (source, coefficients(source))).collect();
        let rule: Vec<(f64, f64)> = gauss_legendre(degree + 1).iter().map(|(x, weight)| (0.5 + 0.5 * x, 0.5 * weight)).collect();
        let weight = |place: usize| rule[place / rule.len()].1 * rule[place % rule.len()].1;
        let (mut square, mut most) = (vec![0.0_f64; self.channels], vec![0.0_f64; self.channels]);
        let (mut error, mut size) = (square.clone(), square.clone());
        let mut along = vec![vec![0.0_f64; basis.len()]; self.channels];
        let part = 1.0 / levels[level].len() as f64;
        for &(cell, corner) in &levels[level] {
            let mut off = vec![vec![0.0; rule.len() * rule.len()]; self.channels];
            for place in 0..rule.len() * rule.len() {
                let at = [rule[place / rule.len()].0, rule[place % rule.len()].0];
                let station = Station::on(element, cell.point(at));
                let values = basis.values([0, 1].map(|axis| corner[axis] + part.sqrt() * at[axis]));
                let (mut errors, mut sums, mut sizes) =
                    (vec![0.0; self.channels], vec![0.0; self.channels], vec![0.0; self.channels]);
                for (source, held) in &sources {
                    let Ok(row) = self.optics.receive(&station, *source, &Sight::Clear, held[0].len()) else { return None };
                    for (channel, held) in held.iter().enumerate() {
                        sums[channel] += row.values.iter().zip(held).map(|(v, c)| v * c).sum::<f64>();
                        sizes[channel] += row.values.iter().zip(held).map(|(v, c)| (v * c).abs()).sum::<f64>();
                        errors[channel] += row.error_of(held);
                    }
                }
                for channel in 0..self.channels {
                    let polynomial: f64 = held[channel].iter().zip(&values).map(|(c, v)| c * v).sum();
                    let left = sums[channel] - polynomial;
                    off[channel][place] = left;
                    square[channel] += part * weight(place) * left * left;
                    along[channel].iter_mut().zip(&values).for_each(|(sum, value)| *sum += part * weight(place) * left * value);
                    error[channel] = largest(error[channel], errors[channel]);
                    size[channel] = largest(size[channel], sizes[channel]);
                }
            }
            most.iter_mut().zip(&off).for_each(|(most, off)| *most = largest(*most, legendre_sum(&rule, off)));
        }
        let places = (rule.len() * rule.len()) as f64;
        let mut of_channel = |channel: usize| {
            // Sums, and the polynomial's values, round.
            let error = error[channel] + 1e-13 * size[channel];
            let beyond = beyond[channel];
            let mean = square[channel].sqrt() + 2.0 * beyond.mean + error;
            let most = most[channel] + beyond.largest + places * (beyond.largest + error);
            let along = std::mem::take(&mut along[channel]);
            let off = (2.0 * beyond.mean + error) * ROUNDED;
            (
                Left { largest: most * ROUNDED, mean: mean * ROUNDED },
                mutant!("solver.along-finely", (along, off), |_| (Vec::new(), 0.0)),
            )
        };
        let (left, along) = (0..self.channels).map(&mut of_channel).unzip();
        Some(Finely { takes, left, along })
    }

    /// The cells of an element by how often it is cut into four, from once on; none if it is not to be cut.
    fn cells(&self, to: usize) -> Vec<Vec<Cell>> {
        let (element, basis) = (&self.mesh.elements()[to], self.mesh.basis(to));
        let mut levels: Vec<Vec<Cell>> = Vec::new();
        for level in 0..self.deepest.min(MOST_CUTS) {
            let quarters = |cell: &Element, corner: [f64; 2]| -> Option<Vec<Cell>> {
                let within = |child: usize| in_parent(element.shape(), child, [0.0; 2]).map(|at| at / f64::from(1 << level));
                let at = |child: usize| [corner[0] + within(child)[0], corner[1] + within(child)[1]];
                Some(cell.divided(0, basis).ok()?.into_iter().enumerate().map(|(child, cell)| (cell, at(child))).collect())
            };
            let next: Option<Vec<Vec<Cell>>> = match levels.last() {
                None => quarters(element, [0.0; 2]).map(|cells| vec![cells]),
                Some(cells) => cells.iter().map(|(cell, corner)| quarters(cell, *corner)).collect(),
            };
            let Some(next) = next else { break };
            levels.push(next.into_iter().flatten().collect());
        }
        levels
    }
}

/// The sum of the magnitudes of the Legendre series of what has these values at the nodes of a rule's square.
fn legendre_sum(rule: &[(f64, f64)], values: &[f64]) -> f64 {
    let count = rule.len();
    // For each place the polynomials of degree 0, 1 and so on, of a mean square of 1; at the ends they are the largest.
    let at: Vec<Vec<f64>> = rule
        .iter()
        .map(|(s, _)| {
            let x = 2.0 * s - 1.0;
            let mut of = vec![1.0, x];
            for k in 1..count {
                let k_f = k as f64;
                of.push(((2.0 * k_f + 1.0) * x * of[k] - k_f * of[k - 1]) / (k_f + 1.0));
            }
            of.iter().enumerate().take(count).map(|(k, p)| p * ((2 * k + 1) as f64).sqrt()).collect()
        })
        .collect();
    let most = |k: usize| ((2 * k + 1) as f64).sqrt();
    let along = |row: &[f64], k: usize| row.iter().enumerate().map(|(b, v)| rule[b].1 * at[b][k] * v).sum::<f64>();
    let rows: Vec<Vec<f64>> = values.chunks_exact(count).map(|row| (0..count).map(|k| along(row, k)).collect()).collect();
    let of = |j: usize, k: usize| (0..count).map(|a| rule[a].1 * at[a][j] * rows[a][k]).sum::<f64>();
    (0..count).flat_map(|j| (0..count).map(move |k| (j, k))).map(|(j, k)| of(j, k).abs() * most(j) * most(k)).sum()
}
