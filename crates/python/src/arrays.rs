//! Arrays of numpy as slices, in single or double precision.

use std::borrow::Cow;

use numpy::{Element, PyReadonlyArrayDyn};
use pyo3::prelude::*;
use radgrad_core::DVec3;
use radgrad_core::batch::Precision;

use crate::refused;

/// A precision in which arrays come and go.
pub(crate) trait Number: Precision + Element + Copy + Into<f64> {
    /// Half the distance of 1 from its successor.
    const UNIT_ROUNDOFF: f64;
    /// The smallest normal number.
    const LEAST_NORMAL: f64;

    /// The nearest number of this precision.
    fn rounded(value: f64) -> Self;
}

impl Number for f64 {
    const UNIT_ROUNDOFF: Self = Self::EPSILON / 2.0;
    const LEAST_NORMAL: Self = Self::MIN_POSITIVE;

    fn rounded(value: Self) -> Self {
        value
    }
}

impl Number for f32 {
    const UNIT_ROUNDOFF: f64 = Self::EPSILON as f64 / 2.0;
    const LEAST_NORMAL: f64 = Self::MIN_POSITIVE as f64;

    #[expect(clippy::cast_possible_truncation, reason = "rounding is what is asked for")]
    fn rounded(value: f64) -> Self {
        value as Self
    }
}

/// The numbers of an array in its order.
pub(crate) fn slice<'a, T: Element>(array: &'a PyReadonlyArrayDyn<'_, T>) -> PyResult<&'a [T]> {
    array.as_slice().map_err(|_| refused("an array is not contiguous: pass it through numpy.ascontiguousarray"))
}

/// Rows of three numbers.
pub(crate) fn rows<T: Copy>(numbers: &[T]) -> &[[T; 3]] {
    numbers.as_chunks().0
}

/// Points or directions as vectors.
pub(crate) fn vectors(array: &PyReadonlyArrayDyn<'_, f64>) -> PyResult<Vec<DVec3>> {
    Ok(rows(slice(array)?).iter().map(|row| DVec3::from(*row)).collect())
}

/// Receivers as arrays: rows of positions; of normals and reflectances as many, or one for all.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Points<'a, F> {
    pub(crate) positions: &'a [[F; 3]],
    pub(crate) normals: &'a [[F; 3]],
    pub(crate) reflectances: &'a [F],
}

impl<'a, F: Number> Points<'a, F> {
    pub(crate) fn new(
        positions: &'a PyReadonlyArrayDyn<'_, F>,
        normals: &'a PyReadonlyArrayDyn<'_, F>,
        reflectances: &'a PyReadonlyArrayDyn<'_, F>,
    ) -> PyResult<Self> {
        let points =
            Self { positions: rows(slice(positions)?), normals: rows(slice(normals)?), reflectances: slice(reflectances)? };
        points.check().map(|()| points)
    }

    /// Refuses arrays of lengths that do not go together.
    pub(crate) fn check(&self) -> PyResult<()> {
        let expected = self.positions.len();
        match [("normals", self.normals.len()), ("reflectances", self.reflectances.len())]
            .iter()
            .find(|(_, n)| *n != 1 && *n != expected)
        {
            Some((what, count)) => Err(refused(format!("{count} {what} for {expected} points: give one, or one for each"))),
            None => Ok(()),
        }
    }

    /// One receiver.
    pub(crate) fn receiver(&self, index: usize) -> Result<radgrad_core::Receiver, radgrad_core::Error> {
        let of = |rows: &[[F; 3]]| DVec3::from(rows[if rows.len() == 1 { 0 } else { index }].map(Into::into));
        let reflectance = self.reflectances[if self.reflectances.len() == 1 { 0 } else { index }];
        radgrad_core::Receiver::new(of(self.positions), of(self.normals), reflectance.into())
    }
}

/// Where a point is in the array that the caller gave, for messages.
#[derive(Debug, Clone)]
pub(crate) struct Shape(pub(crate) Vec<usize>);

impl Shape {
    /// `point 3: `, `point (1, 2): `, and nothing of a point alone.
    pub(crate) fn place(&self, mut index: usize) -> Cow<'static, str> {
        let mut indices: Vec<String> = Vec::new();
        for side in self.0.iter().rev() {
            indices.push((index % side).to_string());
            index /= side;
        }
        indices.reverse();
        match &indices[..] {
            [] => "".into(),
            [one] => format!("point {one}: ").into(),
            several => format!("point ({}): ", several.join(", ")).into(),
        }
    }
}
