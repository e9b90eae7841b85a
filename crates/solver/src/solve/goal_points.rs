//! Points that a solution serves, and their importance: data of [`super::goal`].

use crate::bytes::bytes_of;
use radgrad_core::DVec3;

/// Points that are served, and the importance of elements for them.
#[derive(Debug, Default)]
pub(crate) struct GoalPoints {
    /// Position and normal, in the coordinates of the scene; none to serve the mean.
    pub(super) points: Vec<[DVec3; 2]>,
    /// Whether the mean was served before: then it stays as good as it is.
    pub(super) beside: bool,
    /// Of each receiver of the last round, in each channel: the importance.
    pub(super) importance: Vec<Vec<f64>>,
    /// The mean of it over all area, and of the reflected radiosity at the points.
    pub(super) mean: Vec<f64>,
    pub(super) reflected: Vec<f64>,
}

impl GoalPoints {
    pub(crate) fn at_points(points: &[(DVec3, DVec3)]) -> Self {
        Self { points: points.iter().map(|&(position, normal)| [position, normal]).collect(), ..Self::default() }
    }

    /// Whether the importance for points is known.
    pub(super) fn is_known(&self) -> bool {
        !self.importance.is_empty()
    }
}

bytes_of!(GoalPoints { points, beside, importance, mean, reflected });
