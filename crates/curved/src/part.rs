//! Parts of patches, each with one polynomial.
//!
//! A part of a curved patch is a rectangle of parameters, with polynomials of its own coordinates in [0, 1]. A part of a polygon
//! is an [`Element`], whose polynomials are those of the position.

use radgrad_core::DVec3;
use radgrad_solver::{Basis, Element, Shape};

use crate::error::Error;
use crate::patch::{Form, Patch, Spot};

#[derive(Debug)]
pub(crate) struct PatchPart {
    pub(crate) patch: usize,
    pub(crate) ground: Ground,
}

#[derive(Debug)]
pub(crate) enum Ground {
    Flat(Box<Element>),
    Curved { low: [f64; 2], size: [f64; 2] },
}

/// A point of the unit square carried to a part: where it is, with the area over that of the square, and its coordinates there.
pub(crate) struct Sample {
    pub(crate) spot: Spot,
    pub(crate) reference: [f64; 2],
}

impl PatchPart {
    /// The parts that a patch begins with.
    pub(crate) fn of_patch(index: usize, patch: &Patch, bases: &[Basis; 2]) -> Result<Vec<Self>, Error> {
        let Form::Polygon(polygon) = &patch.0 else {
            return Ok(vec![Self { patch: index, ground: Ground::Curved { low: [0.0; 2], size: [1.0; 2] } }]);
        };
        let elements = Element::of_face(polygon, index, bases)?;
        Ok(elements.into_iter().map(|element| Self { patch: index, ground: Ground::Flat(Box::new(element)) }).collect())
    }

    pub(crate) fn shape(&self) -> Shape {
        match &self.ground {
            Ground::Flat(element) => element.shape(),
            Ground::Curved { .. } => Shape::Parallelogram,
        }
    }

    pub(crate) fn divided(&self, basis: &Basis) -> Result<Vec<Self>, Error> {
        match &self.ground {
            Ground::Flat(element) => {
                let children = element.divided(0, basis)?;
                Ok(children.into_iter().map(|child| Self { patch: self.patch, ground: Ground::Flat(Box::new(child)) }).collect())
            }
            Ground::Curved { low, size } => {
                let half = size.map(|s| 0.5 * s);
                let child = |[i, j]: [f64; 2]| {
                    let low = [low[0] + i * half[0], low[1] + j * half[1]];
                    Self { patch: self.patch, ground: Ground::Curved { low, size: half } }
                };
                Ok([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(child).into_iter().collect())
            }
        }
    }

    /// The point with these coordinates; its `area` is that over the coordinates'.
    pub(crate) fn spot(&self, patches: &[&Patch], reference: [f64; 2]) -> Spot {
        match &self.ground {
            Ground::Flat(element) => {
                Spot { point: element.point(reference), normal: element.polygon().normal(), area: element.area(), at: reference }
            }
            Ground::Curved { low, size } => {
                let spot = patches[self.patch].spot([0, 1].map(|k| low[k] + size[k] * reference[k]));
                Spot { area: spot.area * size[0] * size[1], ..spot }
            }
        }
    }

    /// A point of the unit square: of a triangle that with the coordinates `(s, (1 - s) t)`.
    pub(crate) fn sample(&self, patches: &[&Patch], [s, t]: [f64; 2]) -> Sample {
        let (reference, weight) = match self.shape() {
            Shape::Parallelogram => ([s, t], 1.0),
            Shape::Triangle => ([s, (1.0 - s) * t], 2.0 * (1.0 - s)),
        };
        let spot = self.spot(patches, reference);
        Sample { spot: Spot { area: spot.area * weight, ..spot }, reference }
    }

    /// Largest value of `direction . x` over the part, or one above it.
    pub(crate) fn farthest_along(&self, patches: &[&Patch], direction: DVec3) -> f64 {
        match &self.ground {
            Ground::Flat(element) => {
                element.polygon().vertices().iter().map(|v| direction.dot(*v)).fold(f64::NEG_INFINITY, f64::max)
            }
            Ground::Curved { .. } => patches[self.patch].farthest_along(direction),
        }
    }

    /// Coordinates on this part of a point of its patch, if it is on it.
    pub(crate) fn reference(&self, spot: &Spot) -> Option<[f64; 2]> {
        match &self.ground {
            Ground::Flat(element) => {
                let reference = element.reference(spot.point);
                (element.excess(reference) <= 1e-12).then_some(reference)
            }
            Ground::Curved { low, size } => {
                let reference = [0, 1].map(|k| (spot.at[k] - low[k]) / size[k]);
                reference.iter().all(|c| (0.0..=1.0).contains(c)).then_some(reference)
            }
        }
    }
}
