//! The linear system of the irradiances, its residual, the bound, and one more gather.
//!
//! At the nodes of a part the irradiance is a sum over all parts; its projection on the basis is the part's polynomial. Sweeps by
//! Gauss-Seidel solve that. Parts whose residual is at least half of the largest are divided until the bound is met.

use radgrad_core::DVec3;
use radgrad_solver::{Basis, Node, Shape};
use rayon::prelude::*;

use crate::cubature::Integrals;
use crate::error::Error;
use crate::part::PatchPart;
use crate::patch::{Form, Patch};
use crate::scene::CurvedScene;
use crate::sight::{self, Station};
use crate::transport::Transport;

/// Sweeps until the linear system is solved.
const MOST_SWEEPS: usize = 2000;

/// Change relative to the largest irradiance below which it is.
const SOLVED: f64 = 1e-14;

/// The part of the requested error that a kernel's integral may have, per unit of the source's radiosity.
const INTEGRAL_PART: f64 = 1e-3;

/// The requested accuracy, and the limits of the work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvedOptions {
    /// Bound on the error of gathers over the largest radiosity, at most.
    pub error: f64,
    /// Degree of the polynomials, 0 to 4.
    pub degree: usize,
    /// Parts beyond which none is divided any more.
    pub most_parts: usize,
    /// Cells of cubature for one integral.
    pub most_cells: usize,
}

impl Default for CurvedOptions {
    fn default() -> Self {
        Self { error: 1e-3, degree: 2, most_parts: 64, most_cells: 400 }
    }
}

/// Radiosity at a point of a patch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvedAnswer {
    /// Radiosity.
    pub radiosity: f64,
    /// Irradiance.
    pub irradiance: f64,
    /// Bound on the error of the irradiance.
    pub irradiance_bound: f64,
    /// Bound on the error of the radiosity, as far as residuals and cubature are estimated rightly.
    pub bound: f64,
}

/// Polynomial irradiances on parts of patches, with a bound on their error.
#[derive(Debug)]
pub struct CurvedSolution {
    scene: CurvedScene,
    options: CurvedOptions,
    bases: [Basis; 2],
    blockers: Vec<usize>,
    parts: Vec<PatchPart>,
    /// Integrals for each part, each of its nodes, each source.
    rows: Vec<Vec<Vec<Integrals>>>,
    irradiance: Vec<Vec<f64>>,
    /// Bound on `|q|` over each part.
    residual: Vec<f64>,
    bound: f64,
    relative: f64,
    tolerance: f64,
}

/// Solves a scene of curved patches and polygons.
///
/// ```
/// use radgrad_core::DVec3;
/// use radgrad_curved::{CurvedOptions, CurvedScene, Patch, Side, Value, solve};
/// // Inside a sphere the irradiance is the mean radiosity, everywhere.
/// let mut scene = CurvedScene::new();
/// let sphere = Patch::whole_sphere(DVec3::ZERO, 2.0, Side::Inside)?;
/// scene.add(sphere, 0.6, Value::function(3.0, |x| 1.0 + 0.5 * x.z))?;
/// let solution = solve(scene, &CurvedOptions::default())?;
/// let answer = solution.gather(0, [0.3, 0.8])?;
/// assert!((answer.irradiance - 1.0 / (1.0 - 0.6)).abs() < 1e-6);
/// # Ok::<(), radgrad_curved::Error>(())
/// ```
///
/// # Errors
/// If the requested error is not in (0, 1], a Bezier patch may hide something, or a function leaves its range.
pub fn solve(scene: CurvedScene, options: &CurvedOptions) -> Result<CurvedSolution, Error> {
    if !(options.error > 0.0 && options.error <= 1.0) {
        return Err(Error::Tolerance { value: options.error });
    }
    let bases = [Shape::Parallelogram, Shape::Triangle].map(|shape| Basis::new(shape, options.degree));
    let patches: Vec<&Patch> = scene.patches.iter().collect();
    let size = extent(&patches);
    let blockers: Vec<usize> = (0..patches.len()).filter(|&which| sight::may_hide(which, &patches, size)).collect();
    if let Some(&bezier) = blockers.iter().find(|&&which| matches!(patches[which].0, Form::Bezier(_))) {
        return Err(Error::Hides { patch: bezier });
    }
    let mut parts = Vec::new();
    for (index, patch) in patches.iter().enumerate() {
        parts.extend(PatchPart::of_patch(index, patch, &bases)?);
    }
    let tolerance = INTEGRAL_PART * options.error;
    let (rows, irradiance, residual) = (Vec::new(), Vec::new(), Vec::new());
    let mut solution = CurvedSolution {
        scene,
        options: *options,
        bases,
        blockers,
        parts,
        rows,
        irradiance,
        residual,
        bound: f64::INFINITY,
        relative: f64::INFINITY,
        tolerance,
    };
    let mut changed: Vec<bool> = vec![true; solution.parts.len()];
    loop {
        solution.link(&changed)?;
        solution.sweep();
        solution.bound()?;
        if solution.relative <= options.error || solution.parts.len() >= options.most_parts {
            return Ok(solution);
        }
        changed = solution.divide()?;
    }
}

/// Largest extent of the scene, or one above it.
fn extent(patches: &[&Patch]) -> f64 {
    let along = |axis: DVec3| {
        let far = |direction: DVec3| patches.iter().map(|p| p.farthest_along(direction)).fold(f64::NEG_INFINITY, f64::max);
        far(axis) + far(-axis)
    };
    [DVec3::X, DVec3::Y, DVec3::Z].map(along).into_iter().fold(0.0, f64::max)
}

impl CurvedSolution {
    /// Runs `f` with the scene as transport takes it.
    fn with_transport<T>(&self, f: impl FnOnce(&Transport<'_>) -> T) -> T {
        let patches: Vec<&Patch> = self.scene.patches.iter().collect();
        f(&Transport {
            patches: &patches,
            values: &self.scene.values,
            blockers: &self.blockers,
            bases: &self.bases,
            tolerance: self.tolerance,
            most_cells: self.options.most_cells,
        })
    }

    fn basis(&self, part: &PatchPart) -> &Basis {
        &self.bases[usize::from(part.shape() == Shape::Triangle)]
    }

    /// Rows between parts of which one is new; the others are kept.
    fn link(&mut self, new: &[bool]) -> Result<(), Error> {
        let rows = std::mem::take(&mut self.rows);
        let rows = self.with_transport(|transport| {
            let of_part = |(index, part): (usize, &PatchPart)| -> Result<Vec<Vec<Integrals>>, Error> {
                let nodes = transport.basis(part).nodes().iter().enumerate();
                let of_node = |(node, reference): (usize, &Node)| {
                    let spot = part.spot(transport.patches, reference.at);
                    if spot.normal == DVec3::ZERO {
                        let rule = format!("patch {} has no normal at {}", part.patch, spot.point);
                        return Err(Error::Patch { what: "surface", rule });
                    }
                    let station = Station { patch: part.patch, spot };
                    let row = |(source, from): (usize, &PatchPart)| {
                        let cached = rows.get(index).and_then(|of_node| of_node.get(node)).and_then(|row| row.get(source));
                        match cached {
                            Some(cached) if !new[index] && !new[source] => Ok(cached.clone()),
                            _ => transport.row(&station, from),
                        }
                    };
                    self.parts.iter().enumerate().map(row).collect()
                };
                nodes.map(of_node).collect()
            };
            self.parts.par_iter().enumerate().map(of_part).collect::<Result<Vec<_>, Error>>()
        })?;
        self.rows = rows;
        self.irradiance.resize(self.parts.len(), Vec::new());
        for (held, part) in self.irradiance.iter_mut().zip(&self.parts) {
            let len = self.bases[usize::from(part.shape() == Shape::Triangle)].len();
            held.resize(len, 0.0);
        }
        Ok(())
    }

    /// `G(E + rho H_h)` from a row, and the error of its integrals.
    fn received(&self, row: &[Integrals]) -> [f64; 2] {
        row.iter().zip(&self.irradiance).fold([0.0; 2], |[sum, error], (part, held)| {
            let last = part.values.len() - 1;
            let value: f64 = part.values.iter().zip(held).map(|(g, h)| g * h).sum();
            let from_errors: f64 = part.errors.iter().zip(held).map(|(e, h)| e * h.abs()).sum();
            [sum + value + part.values[last], error + from_errors + part.errors[last]]
        })
    }

    fn at_nodes(&self, part: usize) -> Vec<[f64; 2]> {
        self.rows[part].iter().map(|row| self.received(row)).collect()
    }

    fn sweep(&mut self) {
        for _ in 0..MOST_SWEEPS {
            let (mut change, mut largest) = (0.0_f64, f64::MIN_POSITIVE);
            for part in 0..self.parts.len() {
                let samples: Vec<f64> = self.at_nodes(part).iter().map(|h| h[0]).collect();
                let new = self.basis(&self.parts[part]).project(&samples);
                for (new, held) in new.iter().zip(&self.irradiance[part]) {
                    change = change.max((new - held).abs());
                    largest = largest.max(new.abs());
                }
                self.irradiance[part] = new;
            }
            if change <= SOLVED * largest {
                break;
            }
        }
    }

    /// Bounds on the residual, and W.
    fn bound(&mut self) -> Result<(), Error> {
        let of_part = |part: usize| {
            let (basis, at_nodes) = (self.basis(&self.parts[part]), self.at_nodes(part));
            let samples: Vec<f64> = at_nodes.iter().map(|h| h[0]).collect();
            let residual: Vec<f64> = basis.project(&samples).iter().zip(&self.irradiance[part]).map(|(p, h)| p - h).collect();
            let integrals = at_nodes.iter().fold(0.0, |most: f64, h| most.max(h[1]));
            // Cubature errs at the nodes, and so does the polynomial through their samples.
            basis.magnitude_beyond(&samples) + basis.magnitude(&residual) + 2.0 * integrals
        };
        self.residual = (0..self.parts.len()).map(of_part).collect();
        let rho = self.scene.values.iter().map(|values| values[0].largest()).fold(0.0, f64::max);
        let worst = self.residual.iter().fold(0.0, |most: f64, q| most.max(*q));
        self.bound = worst / (1.0 - rho);
        let mut brightest = f64::MIN_POSITIVE;
        for (part, held) in self.parts.iter().zip(&self.irradiance) {
            let [rho, emitted] = &self.scene.values[part.patch];
            brightest = brightest.max(emitted.largest() + rho.largest() * held[0].max(0.0));
        }
        self.relative = rho * rho * self.bound / brightest;
        Ok(())
    }

    /// Divides the parts with the largest residuals, and says which ones are new.
    fn divide(&mut self) -> Result<Vec<bool>, Error> {
        let worst = self.residual.iter().fold(0.0, |most: f64, q| most.max(*q));
        let marked: Vec<bool> = self.residual.iter().map(|&q| q >= 0.5 * worst).collect();
        let (mut parts, mut held, mut rows, mut new) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let old = std::mem::take(&mut self.parts).into_iter().zip(std::mem::take(&mut self.irradiance));
        for ((index, (part, irradiance)), of_part) in old.enumerate().zip(std::mem::take(&mut self.rows)) {
            let basis = &self.bases[usize::from(part.shape() == Shape::Triangle)];
            if marked[index] {
                for (child, piece) in part.divided(basis)?.into_iter().enumerate() {
                    held.push(basis.restrict(child, &irradiance));
                    parts.push(piece);
                    rows.push(Vec::new());
                    new.push(true);
                }
            } else {
                parts.push(part);
                held.push(irradiance);
                rows.push(of_part);
                new.push(false);
            }
        }
        // The kept rows, with a place for each of the parts that a source became.
        for row in rows.iter_mut().flatten() {
            let mut spread = Vec::with_capacity(parts.len());
            for (integrals, marked) in row.drain(..).zip(&marked) {
                let copies = if *marked { 4 } else { 1 };
                spread.extend(std::iter::repeat_n(integrals, copies));
            }
            *row = spread;
        }
        (self.parts, self.irradiance, self.rows) = (parts, held, rows);
        Ok(new)
    }

    /// Number of parts.
    #[must_use]
    pub fn parts(&self) -> usize {
        self.parts.len()
    }

    /// Radiosity at the parameters of a patch, by one more gather. Of a polygon they are along its first and its last edge from its
    /// first vertex.
    ///
    /// # Errors
    /// If there is no such patch or the point is not on it.
    pub fn gather(&self, patch: usize, at: [f64; 2]) -> Result<CurvedAnswer, Error> {
        let outside = || {
            let rule = format!("there is no point {at:?} on patch {patch} of {}", self.scene.patches.len());
            Error::Patch { what: "point", rule }
        };
        let surface = self.scene.patches.get(patch).ok_or_else(outside)?;
        let mut spot = surface.spot(at);
        if let Form::Polygon(polygon) = &surface.0 {
            let v = polygon.vertices();
            spot.point = v[0] + (v[1] - v[0]) * at[0] + (v[v.len() - 1] - v[0]) * at[1];
        }
        let is_on = |part: &&PatchPart| part.patch == patch && part.reference(&spot).is_some();
        self.parts.iter().find(is_on).ok_or_else(outside)?;
        self.gathered(&Station { patch, spot })
    }

    fn gathered(&self, station: &Station) -> Result<CurvedAnswer, Error> {
        self.with_transport(|transport| {
            let row: Result<Vec<Integrals>, Error> = self.parts.iter().map(|part| transport.row(station, part)).collect();
            let row = row?;
            let [irradiance, error] = self.received(&row);
            let reflecting: f64 = row.iter().map(|part| part.values[0] + part.errors[0]).sum();
            let [rho, emitted] = transport.surface_at(station.patch, station.spot.point)?;
            let irradiance_bound = reflecting * self.bound + error;
            Ok(CurvedAnswer {
                radiosity: emitted + rho * irradiance,
                irradiance,
                irradiance_bound,
                bound: rho * irradiance_bound + 4.0 * f64::EPSILON * (emitted + rho * irradiance),
            })
        })
    }
}
