//! Points as `[x, y, z]`: read with messages that say so, where `serde_json` calls a fourth coordinate "trailing characters".

use std::fmt;

use serde::de::{Deserialize, Deserializer, Error, IgnoredAny, SeqAccess, Visitor};

/// A point or vector on its way to `[f64; 3]`.
pub(super) struct Point(pub(super) [f64; 3]);

impl<'de> Deserialize<'de> for Point {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_seq(Coordinates)
    }
}

struct Coordinates;

impl<'de> Visitor<'de> for Coordinates {
    type Value = Point;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("three coordinates [x, y, z]")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<Point, A::Error> {
        let mut point = [0.0; 3];
        for (index, coordinate) in point.iter_mut().enumerate() {
            *coordinate = sequence.next_element()?.ok_or_else(|| A::Error::invalid_length(index, &self))?;
        }
        let mut count = point.len();
        while sequence.next_element::<IgnoredAny>()?.is_some() {
            count += 1;
        }
        if count == point.len() { Ok(Point(point)) } else { Err(A::Error::invalid_length(count, &self)) }
    }
}

/// For a field that is one point.
pub(super) fn one<'de, D: Deserializer<'de>>(deserializer: D) -> Result<[f64; 3], D::Error> {
    Ok(Point::deserialize(deserializer)?.0)
}

/// For a field that is a list of points.
pub(super) fn list<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<[f64; 3]>, D::Error> {
    Ok(Vec::<Point>::deserialize(deserializer)?.into_iter().map(|p| p.0).collect())
}

/// For a field that is a list of lists of points.
pub(super) fn lists<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<Vec<[f64; 3]>>, D::Error> {
    let lists = Vec::<Vec<Point>>::deserialize(deserializer)?;
    Ok(lists.into_iter().map(|list| list.into_iter().map(|p| p.0).collect()).collect())
}
