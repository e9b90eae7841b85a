//! Light that a point receives from a part: `G(E)` and `G(rho phi_k)` for each function of its basis.
//!
//! From a flat part of one reflectance and emission that nothing can hide, the closed forms of `radgrad-core` with their bounds.
//! From any other, cubature over its coordinates of
//! `max(0, n1.r) max(0, -n2.r) |x_u x x_v| / (pi r^4)` where x sees it. Between two points of one sphere the kernel is `1/(4 pi
//! R^2)`; between two of one cylinder both products are `q^2/2R`, q the part of r across the axis: there nothing is lost where r is
//! short. On other patches the kernel of near points is a difference that rounds to about `eps (R/r)^2` of its value, on an area
//! like `r^2`: the integral loses an eps for each halving of the cells.

use std::f64::consts::{FRAC_1_PI, PI};

use radgrad_core::{DVec3, Receiver, Tolerance, evaluate_value};
use radgrad_solver::{Basis, Shape};

use crate::cubature::{self, Integrals};
use crate::error::Error;
use crate::part::{Ground, PatchPart};
use crate::patch::{Form, Patch, Spot};
use crate::sight::{self, Station};
use crate::value::Value;

/// A patch that may hide a part: a ball around it and half of its smaller width.
struct Shadow {
    centre: DVec3,
    radius: f64,
    half_width: f64,
}

impl Shadow {
    fn of_patch(patch: &Patch) -> Self {
        let far = |axis: DVec3| [-patch.farthest_along(-axis), patch.farthest_along(axis)];
        let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(far);
        let (low, high) = (DVec3::new(x[0], y[0], z[0]), DVec3::new(x[1], y[1], z[1]));
        Self { centre: 0.5 * (low + high), radius: 0.5 * (high - low).length(), half_width: 0.5 * patch.width() }
    }

    /// Whether rays from a point to a piece around `middle` pass this, and so far apart that it may be between them: at the nodes of a
    /// cell they are a third of its size from each other, and its reach is about half of that. The rays at a part t of the way are
    /// within `t reach` of the middle one; the t at which they are nearest to this, less that, is where the way from the ray's point
    /// to the centre leans on the ray by `reach` over its length.
    fn may_slip_through(&self, from: DVec3, middle: DVec3, reach: f64) -> bool {
        let (to_centre, ray) = (self.centre - from, middle - from);
        let length = ray.length();
        if length == 0.0 {
            return true;
        }
        let (along, lean) = (to_centre.dot(ray) / length, reach / length);
        let distance = (to_centre - ray * (along / length)).length();
        let nearest = if lean < 1.0 { along + lean * distance / (1.0 - lean * lean).sqrt() } else { length };
        let t = (nearest / length).clamp(0.0, 1.0);
        (to_centre - ray * t).length() <= self.radius + reach * t && reach * t > self.half_width
    }
}

/// The quantities of a scene that transport needs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Transport<'a> {
    pub(crate) patches: &'a [&'a Patch],
    /// Reflectance and emission of each patch.
    pub(crate) values: &'a [[Value; 2]],
    /// Patches that may hide others.
    pub(crate) blockers: &'a [usize],
    pub(crate) bases: &'a [Basis; 2],
    /// Error an integral may have, and cells it may take.
    pub(crate) tolerance: f64,
    pub(crate) most_cells: usize,
}

impl Transport<'_> {
    pub(crate) fn basis(&self, part: &PatchPart) -> &Basis {
        &self.bases[usize::from(part.shape() == Shape::Triangle)]
    }

    /// Reflectance and emission at a point of a patch.
    pub(crate) fn surface_at(&self, patch: usize, point: DVec3) -> Result<[f64; 2], Error> {
        let [reflectance, emitted] = &self.values[patch];
        Ok([reflectance.value_at(point, patch, "reflectance")?, emitted.value_at(point, patch, "emission")?])
    }

    /// The functions of a part first, the emission last.
    pub(crate) fn row(&self, receiver: &Station, part: &PatchPart) -> Result<Integrals, Error> {
        let count = self.basis(part).len() + 1;
        if receiver.patch == part.patch && matches!(part.ground, Ground::Flat(_)) {
            return Ok(Integrals { values: vec![0.0; count], errors: vec![0.0; count] });
        }
        let may = |b: &usize| self.blocks(*b, [receiver.patch, part.patch]) && !self.apart(*b, receiver, part);
        let between: Vec<usize> = self.blockers.iter().copied().filter(may).collect();
        if between.is_empty()
            && let Some(row) = self.closed(receiver, part)?
        {
            return Ok(row);
        }
        let basis = self.basis(part);
        let shadows: Vec<Shadow> = between.iter().map(|&b| Shadow::of_patch(self.patches[b])).collect();
        let doubt = |low: [f64; 2], size: [f64; 2]| {
            let point = |s: f64, t: f64| part.sample(self.patches, [low[0] + s * size[0], low[1] + t * size[1]]).spot.point;
            let middle = point(0.5, 0.5);
            let corners = [point(0.0, 0.0), point(1.0, 0.0), point(0.0, 1.0), point(1.0, 1.0)];
            let reach = corners.iter().map(|corner| (*corner - middle).length()).fold(0.0, f64::max);
            shadows.iter().any(|shadow| shadow.may_slip_through(receiver.spot.point, middle, reach))
        };
        cubature::integrate(count, self.tolerance, self.most_cells, doubt, |square, sums| {
            let sample = part.sample(self.patches, square);
            let [mut above, kernel] = self.kernel(receiver, &sample.spot, part.patch);
            let source = Station { patch: part.patch, spot: sample.spot };
            if above > 0.0 && between.iter().any(|&b| sight::hides(b, self.patches[b], receiver, &source)) {
                above = -1.0;
            }
            let weight = kernel * sample.spot.area;
            let [rho, emitted] = self.surface_at(part.patch, sample.spot.point)?;
            for (sum, value) in sums.iter_mut().zip(basis.values(sample.reference)) {
                *sum = weight * rho * value;
            }
            sums[count - 1] = weight * emitted;
            Ok(above)
        })
    }

    /// Whether a patch that may hide something may do so between two others: a flat one and one lit from outside do not hide
    /// patches from themselves.
    fn blocks(&self, blocker: usize, ends: [usize; 2]) -> bool {
        let own = match &self.patches[blocker].0 {
            Form::Polygon(_) => true,
            Form::Sphere(sphere) => sphere.outwards,
            Form::Cylinder(cylinder) => cylinder.outwards,
            _ => ends[0] == ends[1],
        };
        !(own && ends.contains(&blocker))
    }

    /// Whether a plane along two axes has a patch on one side, a point and a part on the other.
    fn apart(&self, blocker: usize, receiver: &Station, part: &PatchPart) -> bool {
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        axes.into_iter().flat_map(|axis| [axis, -axis]).any(|axis| {
            let nearest = -self.patches[blocker].farthest_along(-axis);
            axis.dot(receiver.spot.point).max(part.farthest_along(self.patches, axis)) < nearest
        })
    }

    fn closed(&self, receiver: &Station, part: &PatchPart) -> Result<Option<Integrals>, Error> {
        let ([Value::Constant(rho), Value::Constant(emitted)], Ground::Flat(element)) = (&self.values[part.patch], &part.ground)
        else {
            return Ok(None);
        };
        let (basis, refused) = (self.basis(part), |source| Error::Evaluation { patch: receiver.patch, source });
        let station = Receiver::new(receiver.spot.point, receiver.spot.normal, 1.0).map_err(refused)?;
        let tolerance = Tolerance { relative: 0.0, absolute: self.tolerance };
        let mut row = Integrals::default();
        let mut factor = [0.0; 2];
        for function in 0..basis.len() {
            let value = evaluate_value(&station, element.emitter(function, basis)?, &[], tolerance).map_err(refused)?;
            row.values.push(rho * value.radiosity);
            row.errors.push(rho * value.radiosity_error);
            if function == 0 {
                factor = [value.radiosity, value.radiosity_error];
            }
        }
        row.values.push(emitted * factor[0]);
        row.errors.push(emitted * factor[1]);
        Ok(Some(row))
    }

    /// The smaller cosine, which is 0 or less where one of the points is not on the lit side of the other, and the magnitude of
    /// the kernel; 0 for a point and itself.
    fn kernel(&self, receiver: &Station, source: &Spot, patch: usize) -> [f64; 2] {
        let (x, n1) = (receiver.spot.point, receiver.spot.normal);
        match (&self.patches[receiver.patch].0, &self.patches[patch].0) {
            (Form::Sphere(a), Form::Sphere(b)) if a.centre == b.centre && a.radius == b.radius => {
                let lit = !a.outwards && !b.outwards;
                return if lit { [1.0, 0.25 * FRAC_1_PI / (a.radius * a.radius)] } else { [-1.0, 0.0] };
            }
            (Form::Cylinder(a), Form::Cylinder(_)) if receiver.patch == patch => {
                let r = source.point - x;
                let (length, across) = (r.length_squared(), a.across(r).length_squared());
                let cosine = if length == 0.0 { 0.0 } else { across / (2.0 * a.radius * length) };
                return if a.outwards { [-1.0, 0.0] } else { [1.0, cosine * cosine * FRAC_1_PI] };
            }
            _ => {}
        }
        let r = source.point - x;
        let (above, facing, length) = (n1.dot(r), -source.normal.dot(r), r.length_squared());
        if length == 0.0 {
            return [1.0, 0.0];
        }
        [above.min(facing) / length.sqrt(), (above * facing).abs() / (PI * length * length)]
    }
}
