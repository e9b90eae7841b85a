//! Faces cut where others stand on them, or hang close over them.
//!
//! Under a box that stands on a floor it is dark, beside it is not: along the contact the radiosity jumps, and no polynomial
//! across it comes near. So a face is cut along the edges of others that lie in its plane, and stand over it. A lamp close under
//! a ceiling leaves a pocket over it that is as dark, or as bright, and falls off within the gap: there the ceiling is cut along
//! the lamp's edges too. The light that a polynomial across the pocket would send into it is absorbed by the lamp's back, and in
//! a white room that is counted `1/(1 - rho)` times. Each cut goes on to the edge of the convex part that it is in, so that parts
//! stay convex; parts that an edge does not enter stay whole.

use radgrad_core::{DVec3, Polygon};
use radgrad_scene::{largest, smallest};

/// Fraction of the face's size within which points are in its plane or on an edge.
const LEVEL: f64 = 1e-9;

/// The height of a face that is parallel to another and faces it, over the root of the smaller area, up to which it hangs close over that: half of it
/// for one that shows its back, which is dark in any case; and the sine up to which they are parallel.
pub(crate) const CLOSE: f64 = 0.8;
const PARALLEL: f64 = 1e-3;

/// The part of a face's area below which a face that hangs over it takes too little light to be cut for.
const NOTICED: f64 = 1e-3;

/// Parts of a face beyond which cutting costs more than it gains: it is then left whole.
const MOST_PARTS: usize = 64;

/// Convex parts of a face, given its own, between the edges that `others` put down on it, or hang over it up to this part of their size
/// ([`CLOSE`], or 0); `None` if there is nothing to cut.
pub(crate) fn cut<'a>(
    face: &Polygon,
    convex: &[Vec<DVec3>],
    others: impl Iterator<Item = &'a Polygon>,
    close: f64,
) -> Option<Vec<Vec<DVec3>>> {
    let (normal, size) = (face.normal(), face.size());
    let level = LEVEL * size;
    let height = |p: DVec3| normal.dot(p - face.vertices()[0]);
    let mut parts = convex.to_vec();
    for other in others {
        let v = other.vertices();
        if !v.iter().any(|&p| height(p) > level) {
            continue;
        }
        let part = if normal.dot(other.normal()) < 0.0 { close } else { 0.5 * close };
        let height_at_most = part * smallest(face.area(), other.area()).sqrt();
        let is_parallel = normal.cross(other.normal()).length() <= PARALLEL && other.area() >= NOTICED * face.area();
        let hangs = is_parallel && v.iter().all(|&p| height(p) > level && height(p) <= height_at_most);
        for (i, &a) in v.iter().enumerate() {
            let b = v[(i + 1) % v.len()];
            let stands = height(a).abs() <= level && height(b).abs() <= level;
            if (stands || hangs) && (b - a).length() > level {
                let edge = [a, b].map(|p| p - normal * height(p));
                parts = parts.into_iter().flat_map(|part| split(part, edge, normal, level)).collect();
                if parts.len() > MOST_PARTS {
                    return None;
                }
            }
        }
    }
    (parts.len() > convex.len()).then_some(parts)
}

/// A convex part, or the two on either side of a segment that runs inside it.
fn split(part: Vec<DVec3>, [a, b]: [DVec3; 2], normal: DVec3, level: f64) -> Vec<Vec<DVec3>> {
    match inside(&part, [a, b], normal, level) {
        Some([from, to]) if (to - from) * (b - a).length() > level => halves(&part, [a, b], normal, level),
        _ => vec![part],
    }
}

/// The shares of a segment between which it is inside a convex part, by less than a level on no side.
pub(crate) fn inside(part: &[DVec3], [a, b]: [DVec3; 2], normal: DVec3, level: f64) -> Option<[f64; 2]> {
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for (i, &p) in part.iter().enumerate() {
        let edge = part[(i + 1) % part.len()] - p;
        let inward = normal.cross(edge).normalize_or_zero();
        let [start, end] = [a, b].map(|q| inward.dot(q - p) - level);
        if start <= 0.0 && end <= 0.0 {
            return None;
        }
        let crossing = start / (start - end);
        if start < 0.0 {
            from = largest(from, crossing);
        } else if end < 0.0 {
            to = smallest(to, crossing);
        }
    }
    Some([from, to])
}

/// The parts of a convex part on either side of the line through two points; corners within a level are on it.
pub(crate) fn halves(part: &[DVec3], [a, b]: [DVec3; 2], normal: DVec3, level: f64) -> Vec<Vec<DVec3>> {
    let across = normal.cross(b - a).normalize_or_zero();
    let side = |p: DVec3| {
        let side = across.dot(p - a);
        if side.abs() <= level { 0.0 } else { side }
    };
    let half = |sign: f64| {
        let mut half = Vec::with_capacity(part.len() + 1);
        for (i, &p) in part.iter().enumerate() {
            let q = part[(i + 1) % part.len()];
            let (here, there) = (sign * side(p), sign * side(q));
            if here >= 0.0 {
                half.push(p);
            }
            if here * there < 0.0 {
                half.push(p + (q - p) * (here / (here - there)));
            }
        }
        half
    };
    [half(1.0), half(-1.0)].into_iter().filter(|half| half.len() >= 3).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_floor_is_cut_around_what_stands_on_it_and_keeps_its_area() {
        let square = |low: f64, high: f64, z: f64| {
            [(low, low), (high, low), (high, high), (low, high)].map(|(x, y)| DVec3::new(x, y, z)).to_vec()
        };
        let floor = Polygon::new(square(0.0, 4.0, 0.0)).unwrap();
        let (low, high) = (square(1.0, 2.0, 0.0), square(1.0, 2.0, 1.0));
        let side = |i: usize| Polygon::new(vec![low[i], low[(i + 1) % 4], high[(i + 1) % 4], high[i]]).unwrap();
        let sides: Vec<Polygon> = (0..4).map(side).collect();
        let parts = cut(&floor, &[floor.vertices().to_vec()], sides.iter(), CLOSE).unwrap();
        let areas: Vec<f64> = parts.iter().map(|part| Polygon::new(part.clone()).unwrap().area()).collect();
        assert_eq!(parts.len(), 5);
        assert!((areas.iter().sum::<f64>() - 16.0).abs() < 1e-12);
        assert!(areas.iter().any(|area| (area - 1.0).abs() < 1e-12), "{areas:?}");
        // A polygon that hangs close over the floor cuts it likewise; one that hangs higher, or ends at its edge, cuts nothing.
        let close = Polygon::new(square(1.0, 2.0, 0.1)).unwrap();
        assert_eq!(cut(&floor, &[floor.vertices().to_vec()], std::iter::once(&close), CLOSE).map(|parts| parts.len()), Some(5));
        let above = Polygon::new(high).unwrap();
        let wall = Polygon::new([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 0.0, 4.0]].map(DVec3::from).to_vec()).unwrap();
        assert_eq!(cut(&floor, &[floor.vertices().to_vec()], [above, wall].iter(), CLOSE), None);
    }
}
