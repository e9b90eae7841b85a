//! The steady heat balance of grey, diffuse surfaces that exchange heat by radiation alone (the net-radiation method).
//!
//! With radiosities `B`, the net flux that surface i loses is `q_i = sum_j F_ij (B_i - B_j)`, and where its temperature is given
//! `q_i = e_i / (1 - e_i) (sigma T_i^4 - B_i)`. Weighted by areas these equations are symmetric and positive: conjugate gradients solve them.
//! Since only differences of radiosities occur, the heat that one surface loses others gain, whatever rows lack to a sum of 1.

mod error;

use std::collections::{BinaryHeap, HashMap};

use rayon::prelude::*;

pub use self::error::HeatError;

/// The constant of Stefan and Boltzmann, W/(m2 K4).
pub const STEFAN_BOLTZMANN: f64 = 5.670_374_419e-8;

/// By how much the two exchanges of a pair may differ, over the smaller of their areas, and a row's sum exceed 1.
const DEFECT: f64 = 0.01;

/// The part of its view by which a surface is open to the surroundings, and not by an error of its factors.
const OPEN: f64 = 1e-6;

/// Residual of the system over its right side, in the norm of conjugate gradients; and of the heat of any surface over the heat that it exchanges.
const SETTLED: f64 = 1e-15;
const UNSETTLED: f64 = 1e-9;

/// The boundary condition of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Boundary {
    /// Its temperature in kelvin.
    Temperature(f64),
    /// The net heat that it loses by radiation, in watts per unit of area; 0 where it is insulated (adiabatic, reradiating).
    Flux(f64),
}

/// The state of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceHeat {
    /// Kelvin.
    pub temperature: f64,
    /// The net heat that it loses by radiation, W/m2.
    pub flux: f64,
    /// The heat that leaves it, emitted and reflected, W/m2.
    pub radiosity: f64,
    /// The heat that arrives at it, W/m2.
    pub irradiance: f64,
}

/// Temperature, net flux and radiosity of each of grey, diffuse surfaces in a steady state, from their factors: of each row the
/// surfaces that it sees, with the factor.
///
/// Where factors of a row sum to less than 1 the rest of the view is to black `surroundings` of that temperature in kelvin; without
/// them the scene must be closed, to 0.01, and the share that a row lacks counts for nothing.
///
/// ```
/// use radgrad_scene::{Boundary, STEFAN_BOLTZMANN, heat_balance};
///
/// // Two large plates see nothing but each other.
/// let factors = [vec![(1, 1.0)], vec![(0, 1.0)]];
/// let boundary = [Boundary::Temperature(600.0), Boundary::Temperature(300.0)];
/// let plates = heat_balance(&factors, &[1.0, 1.0], &[0.8, 0.5], &boundary, None)?;
/// let expected = STEFAN_BOLTZMANN * (600.0_f64.powi(4) - 300.0_f64.powi(4)) / (1.0 / 0.8 + 1.0 / 0.5 - 1.0);
/// assert!((plates[0].flux - expected).abs() <= 1e-12 * expected);
/// # Ok::<(), radgrad_scene::HeatError>(())
/// ```
///
/// # Errors
/// [`HeatError`]: numbers out of range, factors that are not reciprocal or not of a closed scene, a state that nothing fixes.
pub fn heat_balance(
    factors: &[Vec<(usize, f64)>],
    areas: &[f64],
    emittances: &[f64],
    boundary: &[Boundary],
    surroundings: Option<f64>,
) -> Result<Vec<SurfaceHeat>, HeatError> {
    let rows = factors.len();
    for (what, count) in [("areas", areas.len()), ("emittances", emittances.len()), ("boundary conditions", boundary.len())] {
        if count != rows {
            return Err(HeatError::Count { what, count, rows });
        }
    }
    for surface in 0..rows {
        in_range(surface, areas[surface], emittances[surface], boundary[surface])?;
    }
    if let Some(value) = surroundings.filter(|kelvin| !(*kelvin >= 0.0 && kelvin.is_finite())) {
        return Err(HeatError::Surroundings { value });
    }
    let system = System::new(factors, areas, emittances, boundary, surroundings)?;
    system.check_levels()?;
    let radiosity = system.solve()?;
    (0..rows).map(|surface| system.state(surface, &radiosity, emittances[surface], boundary[surface])).collect()
}

fn power_of(kelvin: f64) -> f64 {
    STEFAN_BOLTZMANN * kelvin.powi(4)
}

fn in_range(surface: usize, area: f64, emittance: f64, boundary: Boundary) -> Result<(), HeatError> {
    let (quantity, value, range) = match boundary {
        Boundary::Temperature(kelvin) => ("its temperature", kelvin, "finite and at least 0 K"),
        Boundary::Flux(flux) => ("its flux", flux, "finite"),
    };
    let is_known = value.is_finite() && (value >= 0.0 || matches!(boundary, Boundary::Flux(_)));
    let checks = [
        (area > 0.0 && area.is_finite(), "its area", area, "finite and above 0"),
        ((0.0..=1.0).contains(&emittance), "its emittance", emittance, "between 0 and 1"),
        (is_known, quantity, value, range),
    ];
    if let Some((_, what, value, range)) = checks.into_iter().find(|check| !check.0) {
        return Err(HeatError::Range { surface, what, value, range });
    }
    let is_mirror = emittance == 0.0 && matches!(boundary, Boundary::Flux(flux) if flux != 0.0);
    if is_mirror { Err(HeatError::Mirror { surface }) } else { Ok(()) }
}

/// The equations, each times the area of its surface over that of the largest.
struct System {
    areas: Vec<f64>,
    /// Exchange with other surfaces.
    exchange: Vec<Vec<(usize, f64)>>,
    /// Conductance to bodies of given emissive power: the body of the surface itself, and the surroundings. Infinite where the radiosity is given.
    ties: Vec<f64>,
    /// The same times that power, with the given flux; the radiosity where that is given.
    given: Vec<f64>,
    /// The part of its view that a surface has of the surroundings.
    open: Vec<f64>,
    surroundings: f64,
}

impl System {
    fn new(
        factors: &[Vec<(usize, f64)>],
        areas: &[f64],
        emittances: &[f64],
        boundary: &[Boundary],
        surroundings: Option<f64>,
    ) -> Result<Self, HeatError> {
        let largest = areas.iter().copied().fold(0.0, crate::extremes::largest);
        let areas: Vec<f64> = areas.iter().map(|area| area / largest).collect();
        let exchange = exchange_of(factors, &areas)?;
        let mut system = Self {
            areas,
            exchange,
            ties: Vec::new(),
            given: Vec::new(),
            open: Vec::new(),
            surroundings: power_of(surroundings.unwrap_or(0.0)),
        };
        for (surface, row) in factors.iter().enumerate() {
            let sum: f64 = row.iter().map(|(_, factor)| factor).sum();
            if surroundings.is_none() && sum < 1.0 - DEFECT {
                return Err(HeatError::Open { surface, sum });
            }
            let lack = 1.0 - sum;
            let open = if surroundings.is_some() && lack > OPEN { lack } else { 0.0 };
            let (area, emittance) = (system.areas[surface], emittances[surface]);
            let (tie, given) = match boundary[surface] {
                Boundary::Temperature(kelvin) if emittance == 1.0 => (f64::INFINITY, power_of(kelvin)),
                Boundary::Temperature(kelvin) => {
                    let body = area * emittance / (1.0 - emittance);
                    (body + area * open, body * power_of(kelvin) + area * open * system.surroundings)
                }
                Boundary::Flux(flux) => (area * open, area * (flux + open * system.surroundings)),
            };
            system.ties.push(tie);
            system.given.push(given);
            system.open.push(open);
        }
        Ok(system)
    }

    /// Refuses surfaces that no way through others ties to a known power.
    fn check_levels(&self) -> Result<(), HeatError> {
        let count = self.ties.len();
        let mut reached: Vec<bool> = self.ties.iter().map(|tie| *tie > 0.0).collect();
        let mut ahead: Vec<usize> = (0..count).filter(|&surface| reached[surface]).collect();
        while let Some(surface) = ahead.pop() {
            for &(other, _) in &self.exchange[surface] {
                if !std::mem::replace(&mut reached[other], true) {
                    ahead.push(other);
                }
            }
        }
        reached.iter().position(|reached| !reached).map_or(Ok(()), |surface| Err(HeatError::NoLevel { surface }))
    }

    fn is_given(&self, surface: usize) -> bool {
        self.ties[surface].is_infinite()
    }

    /// The left sides of the equations of radiosities that are not given; 0 where they are.
    fn apply(&self, values: &[f64]) -> Vec<f64> {
        let side = |surface: usize| {
            let lost: f64 = self.exchange[surface].iter().map(|(other, w)| w * (values[surface] - values[*other])).sum();
            lost + self.ties[surface] * values[surface]
        };
        (0..values.len()).map(|surface| if self.is_given(surface) { 0.0 } else { side(surface) }).collect()
    }

    /// The radiosities, by conjugate gradients, each equation over its diagonal.
    fn solve(&self) -> Result<Vec<f64>, HeatError> {
        let count = self.ties.len();
        let diagonal = |surface: usize| self.ties[surface] + self.exchange[surface].iter().map(|(_, w)| w).sum::<f64>();
        let diagonal: Vec<f64> = (0..count).map(diagonal).collect();
        let over = |residual: &[f64]| -> Vec<f64> {
            residual.iter().zip(&diagonal).map(|(r, d)| if d.is_finite() && *d > 0.0 { r / d } else { 0.0 }).collect()
        };
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut values: Vec<f64> =
            (0..count).map(|surface| if self.is_given(surface) { self.given[surface] } else { 0.0 }).collect();
        // Begun anew from the values that were reached: the residual that is carried along drifts from the true one.
        for _ in 0..3 {
            let sides = self.apply(&values);
            let left = |surface: usize| if self.is_given(surface) { 0.0 } else { self.given[surface] - sides[surface] };
            let mut residual: Vec<f64> = (0..count).map(left).collect();
            let mut scaled = over(&residual);
            let mut direction = scaled.clone();
            let mut energy = dot(&residual, &scaled);
            let enough = energy * SETTLED * SETTLED;
            for _ in 0..4 * count + 50 {
                let along = self.apply(&direction);
                let curvature = dot(&direction, &along);
                if !(energy > enough && curvature > 0.0) {
                    break;
                }
                let step = energy / curvature;
                values.iter_mut().zip(&direction).for_each(|(value, d)| *value += step * d);
                residual.iter_mut().zip(&along).for_each(|(r, a)| *r -= step * a);
                scaled = over(&residual);
                let next = dot(&residual, &scaled);
                direction.iter_mut().zip(&scaled).for_each(|(d, s)| *d = s + next / energy * *d);
                energy = next;
            }
        }
        let sides = self.apply(&values);
        let strongest = diagonal.iter().zip(&values).filter(|(d, _)| d.is_finite()).map(|(d, v)| d * v.abs());
        let strongest = strongest.fold(0.0, crate::extremes::largest);
        for surface in (0..count).filter(|&surface| !self.is_given(surface)) {
            let residual = (self.given[surface] - sides[surface]).abs();
            let is_settled = residual <= UNSETTLED * strongest;
            if !is_settled {
                return Err(HeatError::Unsettled { surface, residual: residual / strongest });
            }
        }
        Ok(values)
    }

    fn state(&self, surface: usize, radiosity: &[f64], emittance: f64, boundary: Boundary) -> Result<SurfaceHeat, HeatError> {
        let own = radiosity[surface];
        let flux_found = || {
            let lost: f64 = self.exchange[surface].iter().map(|(other, w)| w * (own - radiosity[*other])).sum();
            lost / self.areas[surface] + self.open[surface] * (own - self.surroundings)
        };
        let (temperature, flux) = match boundary {
            Boundary::Temperature(kelvin) => (kelvin, flux_found()),
            Boundary::Flux(flux) => {
                // Of a mirror the limit of less and less emittance.
                let held = if flux == 0.0 { 0.0 } else { (1.0 - emittance) / emittance * flux };
                let power = own + held;
                // A surface at 0 K emits a rounding of the power that it balances.
                if power < -UNSETTLED * crate::extremes::largest(held.abs(), own.abs()) {
                    return Err(HeatError::BelowZero { surface, power });
                }
                (if power < 0.0 { 0.0 } else { (power / STEFAN_BOLTZMANN).sqrt().sqrt() }, flux)
            }
        };
        let state = SurfaceHeat { temperature, flux, radiosity: own, irradiance: own - flux };
        let is_finite = [temperature, flux, own, state.irradiance].iter().all(|value| value.is_finite());
        if is_finite { Ok(state) } else { Err(HeatError::Unsettled { surface, residual: f64::NAN }) }
    }
}

/// Areas with which factors are reciprocal, where only these are known: of surfaces that exchange heat all are fixed by one of them, which
/// is 1. Where factors have errors those of the largest ones count.
#[must_use]
pub fn reciprocal_areas(factors: &[Vec<(usize, f64)>]) -> Vec<f64> {
    let mut back: Vec<HashMap<usize, f64>> = vec![HashMap::new(); factors.len()];
    for (from, row) in factors.iter().enumerate() {
        for &(to, factor) in row {
            if let Some(back) = back.get_mut(to) {
                back.insert(from, factor);
            }
        }
    }
    let mut areas = vec![0.0; factors.len()];
    for first in 0..factors.len() {
        // Numbers above 0 are in the order of their bits.
        let mut ahead = BinaryHeap::from([(u64::MAX, first, 1.0_f64.to_bits())]);
        while let Some((_, surface, area)) = ahead.pop() {
            if areas[surface] > 0.0 {
                continue;
            }
            areas[surface] = f64::from_bits(area);
            for &(to, there) in &factors[surface] {
                let Some(from_there) = back[surface].get(&to).copied().filter(|from_there| *from_there > 0.0 && there > 0.0)
                else {
                    continue;
                };
                let area = areas[surface] * (there / from_there);
                if areas[to] == 0.0 && area > 0.0 && area.is_finite() {
                    ahead.push((crate::extremes::smallest(there, from_there).to_bits(), to, area.to_bits()));
                }
            }
        }
    }
    areas
}

/// Derivatives of the net heats by the temperatures, W/(m2 K), where all temperatures are known: row by row, of the surface that loses
/// the heat. Heat is linear in the fourth powers, so that a column is the balance of one surface alone at `4 T^3`.
///
/// # Errors
/// As of [`heat_balance`].
pub fn heat_jacobian(
    factors: &[Vec<(usize, f64)>],
    areas: &[f64],
    emittances: &[f64],
    kelvins: &[f64],
    surroundings: Option<f64>,
) -> Result<Vec<f64>, HeatError> {
    let boundary: Vec<Boundary> = kelvins.iter().map(|kelvin| Boundary::Temperature(*kelvin)).collect();
    heat_balance(factors, areas, emittances, &boundary, surroundings)?;
    let count = kelvins.len();
    let column = |surface: usize| -> Result<Vec<f64>, HeatError> {
        let mut alone = vec![Boundary::Temperature(0.0); count];
        alone[surface] = Boundary::Temperature((4.0 * kelvins[surface].powi(3)).sqrt().sqrt());
        let states = heat_balance(factors, areas, emittances, &alone, surroundings.map(|_| 0.0))?;
        Ok(states.iter().map(|state| state.flux).collect())
    };
    let columns = (0..count).into_par_iter().map(column).collect::<Result<Vec<_>, _>>()?;
    Ok((0..count).flat_map(|row| columns.iter().map(move |column| column[row])).collect())
}

/// Exchanges of surfaces with others, the mean of both ways; none with themselves.
fn exchange_of(factors: &[Vec<(usize, f64)>], areas: &[f64]) -> Result<Vec<Vec<(usize, f64)>>, HeatError> {
    let count = factors.len();
    let mut ways: Vec<Vec<(usize, f64, f64)>> = vec![Vec::new(); count];
    let mut seen_by = vec![usize::MAX; count];
    for (from, row) in factors.iter().enumerate() {
        let sum: f64 = row.iter().map(|(_, factor)| factor).sum();
        if sum > 1.0 + DEFECT {
            return Err(HeatError::MoreThanAll { surface: from, sum });
        }
        for &(to, factor) in row {
            if to >= count {
                return Err(HeatError::Column { from, to, defect: "is not there" });
            }
            if std::mem::replace(&mut seen_by[to], from) == from {
                return Err(HeatError::Column { from, to, defect: "has one already" });
            }
            if !(0.0..=1.0 + DEFECT).contains(&factor) {
                return Err(HeatError::Range {
                    surface: from,
                    what: "one of the factors of F",
                    value: factor,
                    range: "between 0 and 1",
                });
            }
            if to != from {
                ways[from].push((to, areas[from] * factor, 0.0));
                ways[to].push((from, 0.0, areas[from] * factor));
            }
        }
    }
    let row = |(from, mut of): (usize, Vec<(usize, f64, f64)>)| {
        of.sort_by_key(|(to, ..)| *to);
        of.dedup_by(|next, kept| {
            let is_same = next.0 == kept.0;
            if is_same {
                kept.1 += next.1;
                kept.2 += next.2;
            }
            is_same
        });
        let mean = |&(to, there, back): &(usize, f64, f64)| {
            if (there - back).abs() > DEFECT * crate::extremes::smallest(areas[from], areas[to]) {
                return Err(HeatError::Reciprocity { from, to, there, back });
            }
            Ok((to, f64::midpoint(there, back)))
        };
        of.iter().filter(|(_, there, back)| there + back > 0.0).map(mean).collect()
    };
    ways.into_iter().enumerate().map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const BLACK: [f64; 2] = [1.0, 1.0];

    /// Three surfaces of a long triangular duct, by Hottel's strings.
    fn duct(sides: [f64; 3]) -> Vec<Vec<(usize, f64)>> {
        let [a, b, c] = sides;
        let factor = |own: f64, other: f64, third: f64| (own + other - third) / (2.0 * own);
        vec![
            vec![(1, factor(a, b, c)), (2, factor(a, c, b))],
            vec![(0, factor(b, a, c)), (2, factor(b, c, a))],
            vec![(0, factor(c, a, b)), (1, factor(c, b, a))],
        ]
    }

    #[test]
    fn an_insulated_wall_takes_the_temperature_at_which_it_loses_nothing_and_heat_adds_up_to_nothing() {
        let sides = [1.0, 1.3, 0.9];
        let boundary = [Boundary::Temperature(1200.0), Boundary::Temperature(500.0), Boundary::Flux(0.0)];
        let states = heat_balance(&duct(sides), &sides, &[0.8, 0.4, 0.6], &boundary, None).unwrap();
        // Two surfaces with a reradiating one: resistances in series, two paths between (Oppenheim).
        let exchange = |i: usize, j: usize| duct(sides)[i].iter().find(|of| of.0 == j).unwrap().1 * sides[i];
        let between = exchange(0, 1) + 1.0 / (1.0 / exchange(0, 2) + 1.0 / exchange(1, 2));
        let resistance = 0.2 / (0.8 * sides[0]) + 1.0 / between + 0.6 / (0.4 * sides[1]);
        let heat = (power_of(1200.0) - power_of(500.0)) / resistance;
        assert!((states[0].flux * sides[0] - heat).abs() <= 1e-12 * heat, "{states:?} {heat}");
        assert!((states[0].flux * sides[0] + states[1].flux * sides[1]).abs() <= 1e-12 * heat);
        assert!((power_of(states[2].temperature) - states[2].radiosity).abs() <= 1e-12 * heat);
        // A temperature that is found gives the same state when it is given.
        let boundary = [Boundary::Flux(states[0].flux), boundary[1], Boundary::Temperature(states[2].temperature)];
        let again = heat_balance(&duct(sides), &sides, &[0.8, 0.4, 0.6], &boundary, None).unwrap();
        assert!((again[0].temperature - 1200.0).abs() <= 1e-9);
        assert!(again[2].flux.abs() <= 1e-9 * states[0].flux);
    }

    #[test]
    fn a_plate_in_the_open_loses_what_it_emits_less_what_the_surroundings_send() {
        let lone = |boundary, surroundings| heat_balance(&[Vec::new()], &[2.0], &[0.7], &[boundary], surroundings);
        let state = lone(Boundary::Temperature(400.0), Some(280.0)).unwrap()[0];
        let expected = 0.7 * (power_of(400.0) - power_of(280.0));
        assert!((state.flux - expected).abs() <= 1e-13 * expected);
        let back = lone(Boundary::Flux(state.flux), Some(280.0)).unwrap()[0];
        assert!((back.temperature - 400.0).abs() <= 1e-11);
        assert_eq!(lone(Boundary::Flux(1.0), None), Err(HeatError::Open { surface: 0, sum: 0.0 }));
        assert!(matches!(lone(Boundary::Flux(-1e6), Some(280.0)), Err(HeatError::BelowZero { surface: 0, .. })));
    }

    #[test]
    fn what_nothing_fixes_is_refused() {
        let two = [vec![(1, 1.0)], vec![(0, 1.0)]];
        let refused = |areas: &[f64; 2], emittances: &[f64; 2], boundary: &[Boundary; 2]| {
            heat_balance(&two, areas, emittances, boundary, None).unwrap_err()
        };
        let insulated = Boundary::Flux(0.0);
        let warm = Boundary::Temperature(300.0);
        assert_eq!(refused(&[1.0, 1.0], &BLACK, &[insulated, insulated]), HeatError::NoLevel { surface: 0 });
        assert_eq!(refused(&[1.0, 1.0], &[0.0, 1.0], &[Boundary::Flux(1.0), warm]), HeatError::Mirror { surface: 0 });
        assert!(matches!(refused(&[1.0, 2.0], &BLACK, &[warm, warm]), HeatError::Reciprocity { .. }));
        let out_of_range = [
            refused(&[f64::NAN, 1.0], &BLACK, &[warm, warm]),
            refused(&[1.0, 1.0], &[1.0, f64::NAN], &[warm, warm]),
            refused(&[1.0, 1.0], &BLACK, &[warm, Boundary::Temperature(-1.0)]),
            refused(&[1.0, 1.0], &BLACK, &[warm, Boundary::Flux(f64::INFINITY)]),
        ];
        assert!(out_of_range.iter().all(|error| matches!(error, HeatError::Range { .. })), "{out_of_range:?}");
        let twice = [vec![(1, 0.5), (1, 0.5)], vec![(0, 1.0)]];
        let refused = heat_balance(&twice, &[1.0, 1.0], &BLACK, &[warm, warm], None);
        assert_eq!(refused, Err(HeatError::Column { from: 0, to: 1, defect: "has one already" }));
    }

    #[test]
    fn a_ring_of_hundreds_of_reflecting_surfaces_settles() {
        // Each sees its two neighbours; heat goes around from the one that is hot to the one that is cold.
        let count = 400;
        let row = |i: usize| vec![((i + 1) % count, 0.5), ((i + count - 1) % count, 0.5)];
        let factors: Vec<_> = (0..count).map(row).collect();
        let mut boundary = vec![Boundary::Flux(0.0); count];
        boundary[0] = Boundary::Temperature(1000.0);
        boundary[count / 2] = Boundary::Temperature(0.0);
        let states = heat_balance(&factors, &vec![1.0; count], &vec![0.5; count], &boundary, None).unwrap();
        // Two chains of 200 links of 0.5 each, and the two bodies.
        let heat = power_of(1000.0) / (1.0 + 1.0 + 200.0);
        assert!((states[0].flux - heat).abs() <= 1e-10 * heat, "{} {heat}", states[0].flux);
        assert!((states[count / 4].radiosity - 0.5 * power_of(1000.0)).abs() <= 1e-10 * power_of(1000.0));
    }
}
