//! The derivatives of a case as sums over its visible boundary, for whatever emission and scalar.
//!
//! An edge of the emitter or of an occluder moves with its two ends ([`crate::forms::hats`]), a plane of an emission that varies
//! with all vertices of the emitter ([`crate::forms::polynomial::parameters`]). Where an occluder meets the emitter's plane, the line
//! in which it does moves with both: with n, n' the unit normals of occluder and emitter, the normal of the plane through x and that
//! line is `N = alpha n + beta n'`, and a motion v of its points, which is across the line, has `n.v` from the occluder's vertices and
//! `n'.v` from the emitter's, `N.v = alpha n.v + beta n'.v`. Each is an affine function on the line, shared between two of its points.
//!
//! Where sight is undecided, a region of a known solid angle counts or does not: the derivatives by the emission and by the emitter's plane
//! change by that times their largest integrand ([`Largest`]), those by edges by the weight of the region's boundary, of which a vertex
//! has at most all. Of a line in which an occluder meets the emitter's plane it has more: with gamma the angle between the planes
//! `|alpha|, |beta| <= 1/sin gamma`, and the line is on the emitter, over which the vertex's affine function is bounded. So the weight
//! counts that bound over `sin gamma` times, for the occluder of which this is most. Where a polygon is not flat to the last digit, no
//! line in which another one meets it is known to have a direction, and these derivatives have no bound.

use radgrad_numbers::offset::offset;
use radgrad_numbers::radius::Radius;
use radgrad_numbers::real::{RadiusOf, Real};
use radgrad_numbers::vec3::Vec3;

use crate::boundary::arc::Arc;
use crate::boundary::case::Case;
use crate::boundary::edge_name::EdgeName;
use crate::boundary::line::Line;
use crate::boundary::origin::Origin;
use crate::boundary::plan::{Side, side_of};
use crate::boundary::traced::visit_with_origins;
use crate::boundary::visibility::uncertainty::Uncertainty;
use crate::forms::affine_weights::{AffineWeight, affine_weights, largest_weight};
use crate::forms::constant::{EdgeSum, SolidAngleVector};
use crate::forms::hats::Ends;
use crate::forms::linear::SeenLinear;
use crate::forms::polynomial::parameters::{ByParameters, Largest, Parameter, Parameters};
use crate::forms::polynomial::sum::{PolynomialSum, SeenPolynomial};
use crate::problem::emission::Emission;
use crate::problem::polygon::Polygon;
use crate::problem::receiver::unit_normal;

/// Derivatives without the factor rho/pi, in normalised lengths and emission.
pub(super) struct Sums<T> {
    pub(super) irradiance: Vec3<T>,
    pub(super) gradient: Vec3<T>,
    /// By the vertices of the emitter, then by those of each occluder.
    pub(super) vertices: Vec<Vec<Vec3<T>>>,
    pub(super) emission: Vec<Parameter<T>>,
}

/// The derivatives by vertices that move lines, for the visible boundary so far.
struct Moved<'a, T> {
    case: Case<'a>,
    vertices: Vec<Vec<Vec3<T>>>,
}

impl<T: Real> Sums<T> {
    /// The sums; `None` where nothing is visible.
    pub(super) fn new(case: &Case<'_>) -> Option<Self> {
        if let Emission::Constant(_) = case.emitter.emission() { Self::of_constant(case) } else { Self::of_varying(case) }
    }

    fn of_constant(case: &Case<'_>) -> Option<Self> {
        let n1 = unit_normal(case.receiver);
        let (mut angles, mut edges, mut moved) = (SolidAngleVector::zero(), EdgeSum::new(n1), Moved::new(case));
        let uncertainty = visit_with_origins(case, |arc: &Arc<T>, origin| {
            angles.add(arc);
            edges.add(arc);
            moved.add(arc, origin, |ends, line| ends.shares_of_constant(arc, line, n1));
        })?;
        let emission = T::exact(case.emitter.affine().value);
        for vertex in moved.vertices.iter_mut().flatten() {
            *vertex = *vertex * emission;
        }
        let by_value = Parameter::value(n1.dot(angles.phi()).widened(uncertainty.solid_angle));
        let sums = Self {
            irradiance: angles.phi() * emission,
            gradient: edges.sum() * emission,
            vertices: Vec::new(),
            emission: vec![by_value],
        };
        Some(sums.with(moved, &uncertainty, 0.0.into()))
    }

    fn of_varying(case: &Case<'_>) -> Option<Self> {
        let Case { receiver, emitter, plan, .. } = *case;
        let (x, polygon) = (receiver.position(), emitter.polygon());
        let seen = seen(case);
        let weights = affine_weights(polygon, x, plan.power);
        let parameters = Parameters::new(receiver, emitter, plan.power, &seen, &weights);
        let mut sum = PolynomialSum::new(seen.raised());
        let mut moved = Moved::new(case);
        let uncertainty = visit_with_origins(case, |arc: &Arc<T>, origin| {
            let weighed = sum.add_weighed(arc);
            if let Some(weighed) = weighed {
                moved.add(arc, origin, |ends, _| ends.shares(weighed));
            }
        })?;
        let ByParameters { vertices, mut emission } = parameters.derivatives(&sum.within());
        for (sum, vertex) in moved.vertices[0].iter_mut().zip(vertices) {
            *sum = *sum + vertex;
        }
        let mut by_vertices = 0.0.into();
        if !uncertainty.is_none() {
            let weight = largest_weight(&weights, polygon, x, plan.power);
            let Largest { parameters, slope } = parameters.largest(weight);
            // Of a weight, which is 1 at least, along the slope and across the plane.
            by_vertices = uncertainty.solid_angle * slope * weight * 2.02;
            for (parameter, largest) in emission.iter_mut().zip(parameters) {
                parameter.derivative = parameter.derivative.widened(uncertainty.solid_angle * largest * 1.01);
            }
        }
        let sums = Self { irradiance: sum.irradiance(), gradient: sum.gradient(), vertices: Vec::new(), emission };
        Some(sums.with(moved, &uncertainty, by_vertices))
    }

    /// With the derivatives by the vertices, and the bounds on the changes by undecided visibility; within the outline that is `within`.
    fn with(self, moved: Moved<'_, T>, uncertainty: &Uncertainty<RadiusOf<T>>, within: RadiusOf<T>) -> Self {
        let Case { emitter, .. } = moved.case;
        let zero = 0.0.into();
        let edges = if uncertainty.edges == zero {
            zero
        } else {
            uncertainty.edges * moved.largest_share() * (emitter.largest_emission() * emitter.power() * 1.01)
        };
        let widened = |v: Vec3<T>| v.map(|c| c.widened(edges + within));
        Self {
            irradiance: self.irradiance.map(|c| c.widened(uncertainty.irradiance)),
            gradient: self.gradient.map(|c| c.widened(uncertainty.gradient)),
            vertices: moved.vertices.into_iter().map(|polygon| polygon.into_iter().map(widened).collect()).collect(),
            emission: self.emission,
        }
    }
}

fn seen<T: Real>(case: &Case<'_>) -> SeenPolynomial<T> {
    let Case { receiver, emitter, plan, .. } = *case;
    match emitter.polynomial() {
        Some(plane) => SeenPolynomial::new(receiver, emitter, plane, plan.power),
        None => SeenPolynomial::linear(SeenLinear::new(receiver, emitter, plan.power), emitter.polygon()),
    }
}

impl<'a, T: Real> Moved<'a, T> {
    fn new(case: &Case<'a>) -> Self {
        let polygons = std::iter::once(case.emitter.polygon()).chain(case.occluders.iter().copied());
        let vertices = polygons.map(|polygon| vec![Vec3::zero(); polygon.vertices().len()]).collect();
        Self { case: *case, vertices }
    }

    /// Bound on the share of a vertex in the weight of a line.
    fn largest_share(&self) -> RadiusOf<T> {
        let Case { receiver, emitter, occluders, plan } = self.case;
        let (x, polygon) = (receiver.position(), emitter.polygon());
        let weight = |moved: &Polygon| largest_weight::<T>(&affine_weights(moved, x, plan.power), polygon, x, plan.power);
        let meets = |occluder: &&&Polygon| {
            let sides = || occluder.vertices().iter().map(|&v| side_of(v, polygon, plan.power));
            sides().any(|side| side == Side::Front) && sides().any(|side| side == Side::Back)
        };
        occluders.iter().filter(meets).fold(1.0.into(), |most: RadiusOf<T>, occluder| {
            let sine_squared = occluder.unit_normal::<T>().cross(polygon.unit_normal()).norm_squared();
            let sine = (sine_squared.size() - sine_squared.error()).max(0.0.into()).sqrt();
            // More than the largest, and not a number where one is not.
            most + (weight(occluder) + weight(polygon)) * 1.01 / sine
        })
    }

    fn polygon(&self, number: usize) -> &'a Polygon {
        if number == 0 { self.case.emitter.polygon() } else { self.case.occluders[number - 1] }
    }

    /// Adds the motions of an arc's line, given how the weight of the arc is shared between two points of it.
    fn add(&mut self, arc: &Arc<T>, origin: Origin, shares: impl Fn(&Ends<T>, &Line<T>) -> [T; 2]) {
        let Some(line) = arc.line() else { return };
        match origin {
            Origin::Horizon => {}
            Origin::Edge { occluder, edge } => {
                let number = occluder.map_or(0, |index| index + 1);
                self.add_edge(number, edge, line, |ends| shares(ends, line));
            }
            Origin::Waterline(index) => self.add_waterline(index + 1, line, |ends| shares(ends, line)),
        }
    }

    fn add_edge(&mut self, number: usize, edge: EdgeName, line: &Line<T>, shares: impl Fn(&Ends<T>) -> [T; 2]) {
        let (x, power, vertices) = (self.case.receiver.position(), self.case.plan.power, self.polygon(number).vertices());
        let place = |end| vertices.iter().position(|vertex| *vertex == end);
        let [a, b] = edge.ends();
        let (Some(a), Some(b)) = (place(a), place(b)) else { return };
        // Run as the arc is.
        let e: Vec3<T> = offset(vertices[b], vertices[a], power);
        let (places, e) = if e.dot(line.e).value() < 0.0 { ([b, a], -e) } else { ([a, b], e) };
        let ends = Ends::new(places.map(|i| offset(vertices[i], x, power)), e);
        let moved = &mut self.vertices[number];
        for (place, share) in places.into_iter().zip(shares(&ends)) {
            moved[place] = moved[place] + line.normal * share;
        }
    }

    fn add_waterline(&mut self, number: usize, line: &Line<T>, shares: impl Fn(&Ends<T>) -> [T; 2]) {
        let (x, power) = (self.case.receiver.position(), self.case.plan.power);
        let frame = line.frame();
        // As far from each other as they are from x.
        let [toward, along] = [frame.toward, frame.along].map(|axis| axis * frame.distance);
        let points = [toward - along, toward + along];
        let shares = shares(&Ends::new(points, along + along));
        let normals = [number, 0].map(|number| self.polygon(number).unit_normal::<T>());
        let cosine = normals[0].dot(normals[1]);
        let sine_squared = normals[0].cross(normals[1]).norm_squared();
        let on = normals.map(|normal| normal.dot(line.normal));
        let parts = [(on[0] - cosine * on[1]) / sine_squared, (on[1] - cosine * on[0]) / sine_squared];
        for ((number, normal), part) in [number, 0].into_iter().zip(normals).zip(parts) {
            let polygon = self.polygon(number);
            let is_flat = polygon.half_slab() == 0.0;
            let weights: Vec<AffineWeight<T>> = affine_weights(polygon, x, power);
            for (vertex, weight) in self.vertices[number].iter_mut().zip(weights) {
                let share = weight.at(points[0]) * shares[0] + weight.at(points[1]) * shares[1];
                let moved = *vertex + normal * (part * share);
                // No plane is that of a polygon that is not flat.
                *vertex = if is_flat { moved } else { moved.map(|c| c.widened(f64::INFINITY.into())) };
            }
        }
    }
}
