//! Which outlines are polygons, judged by whole numbers: corners on a small grid, so that edges often meet, fold back or have a corner in
//! common, in a plane and a unit in which every coordinate is exact. A polygon hides as much of a larger lamp as it gives in its place: as a
//! lamp it is taken whole, and as a screen in convex parts.

use glam::DVec3;
use radgrad_core::{Emission, Emitter, Error, Polygon, Receiver, evaluate_to};
use radgrad_scene::{largest, smallest};

use crate::cases::sampler::Sampler;
use crate::measures::measure::is_worse;

type Corner = [i64; 2];

fn turn([a, b, c]: [Corner; 3]) -> i64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Whether a point on the line through two others is on the segment between them.
fn is_between([a, b]: [Corner; 2], p: Corner) -> bool {
    (0..2).all(|k| a[k].min(b[k]) <= p[k] && p[k] <= a[k].max(b[k]))
}

/// Whether two edges have more in common than a corner that follows from their order.
fn meet(outline: &[Corner], [first, second]: [usize; 2]) -> bool {
    let count = outline.len();
    let ends = |i: usize| [outline[i], outline[(i + 1) % count]];
    let ([a, b], [c, d]) = (ends(first), ends(second));
    // The far ends of neighbours, about their corner.
    let folded = |from: Corner, corner: Corner, to: Corner| {
        turn([from, corner, to]) == 0 && (0..2).map(|k| (corner[k] - from[k]) * (to[k] - corner[k])).sum::<i64>() < 0
    };
    if (first + 1) % count == second {
        return folded(a, b, d);
    }
    if (second + 1) % count == first {
        return folded(c, d, b);
    }
    let [abc, abd, cda, cdb] = [[a, b, c], [a, b, d], [c, d, a], [c, d, b]].map(turn);
    let is_across = abc.signum() * abd.signum() < 0 && cda.signum() * cdb.signum() < 0;
    let touches = [(abc, [a, b], c), (abd, [a, b], d), (cda, [c, d], a), (cdb, [c, d], b)];
    is_across || touches.into_iter().any(|(turn, edge, corner)| turn == 0 && is_between(edge, corner))
}

/// Planes with exact coordinates: their axes, and how large their cross product is.
const PLANES: [[[f64; 3]; 2]; 7] = [
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
    [[0.0, 1.0, 0.0], [0.0, 0.0, -1.0]],
    [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]],
    [[1.0, 0.0, 2.0], [0.0, 1.0, -1.0]],
    [[1.0, -3.0, 0.0], [0.0, 0.5, 1.0]],
    [[0.0, 1.0, 0.25], [-1.0, 0.0, 0.25]],
    [[2.0, 1.0, -1.0], [1.0, -1.0, 4.0]],
];

/// Contradictions of the answer for a drawn outline.
fn wrong(sampler: &mut Sampler) -> Vec<String> {
    let count = 3 + sampler.below(5) as usize;
    let outline: Vec<Corner> = (0..count).map(|_| [sampler.integer(0, 4), sampler.integer(0, 4)]).collect();
    let [u, v] = PLANES[sampler.below(7) as usize].map(DVec3::from);
    let unit = libm::ldexp(1.0, [0, 0, 40, -60, -400, 400][sampler.below(6) as usize]);
    let start = DVec3::from([(); 3].map(|()| sampler.integer(-8, 8) as f64));
    let vertices: Vec<DVec3> = outline.iter().map(|[x, y]| (start + u * *x as f64 + v * *y as f64) * unit).collect();
    let next = |i: usize| (i + 1) % count;
    let repeated = (0..count).find(|&i| outline[i] == outline[next(i)]);
    let twice: i64 = (1..count - 1).map(|i| turn([outline[0], outline[i], outline[i + 1]])).sum();
    let crossing = (0..count).any(|i| (i + 1..count).any(|j| meet(&outline, [i, j])));
    let said = Polygon::new(vertices.clone());
    let normal = u.cross(v);
    let is_right = match &said {
        Err(Error::RepeatedVertex { first, second, value }) => {
            repeated == Some(*first) && *second == next(*first) && *value == vertices[*first]
        }
        Err(Error::NotSimple { first, second, .. }) => repeated.is_none() && meet(&outline, [*first, *second]),
        Err(Error::ZeroArea { count: told }) => repeated.is_none() && twice == 0 && *told == count,
        Err(_) => false,
        Ok(polygon) => {
            let area = 0.5 * twice.abs() as f64 * normal.length();
            let side = (normal * twice as f64).normalize();
            let coordinates = |axis: usize| vertices.iter().map(move |v| v.to_array()[axis]);
            let extent = |axis: usize| {
                coordinates(axis).fold(f64::NEG_INFINITY, largest) - coordinates(axis).fold(f64::INFINITY, smallest)
            };
            let size = [0, 1, 2].map(extent).into_iter().fold(0.0, largest);
            repeated.is_none()
                && twice != 0
                && !crossing
                && (polygon.normal() - side).length() <= 4.0 * f64::EPSILON
                && (polygon.area() / (unit * unit) - area).abs() <= 8.0 * f64::EPSILON * area
                && polygon.size() == size
                && polygon.planarity_defect() == 0.0
        }
    };
    let told = || format!("{vertices:?}: {said:?}; {twice} twice the area, repeated: {repeated:?}, edges meet: {crossing}");
    if !is_right {
        return vec![told()];
    }
    let Ok(screen) = said else { return Vec::new() };
    let hidden = hidden([start, u, v].map(|vector| vector * unit), screen);
    hidden.unwrap_or_else(|error| vec![error.to_string()]).into_iter().map(|what| format!("{vertices:?}: {what}")).collect()
}

/// Contradictions between what an outline of a grid hides and what it gives.
fn hidden([start, u, v]: [DVec3; 3], outline: Polygon) -> Result<Vec<String>, Error> {
    let side = u.cross(v).dot(outline.normal()).signum();
    let up = u.cross(v) * (side / u.length());
    let receiver = Receiver::new(start + u * 2.0 + v + up * 2.0, -up + u * 0.3, 1.0)?;
    let mut corners = [[-9.0, -9.0], [9.0, -9.0], [9.0, 13.0], [-9.0, 13.0]].map(|[x, y]| start + u * x + v * y - up).to_vec();
    if side < 0.0 {
        corners.reverse();
    }
    let lamp = Emitter::new(Polygon::new(corners)?, Emission::Constant(1.0))?;
    let whole = evaluate_to(&receiver, &lamp, &[], 1.0)?;
    let seen = evaluate_to(&receiver, &lamp, [&outline], 1.0)?;
    let own = evaluate_to(&receiver, &Emitter::new(outline, Emission::Constant(1.0))?, &[], 1.0)?;
    let error = (whole.radiosity - seen.radiosity - own.radiosity).abs();
    let room = whole.radiosity_error + seen.radiosity_error + own.radiosity_error + f64::EPSILON * whole.radiosity;
    let is_off = is_worse(error, room) || is_worse(room, 1e-10);
    let told = || format!("{seen:?} of {whole:?} is seen beside {own:?}: off by {error:e}, known to {room:e}");
    Ok(if is_off { vec![told()] } else { Vec::new() })
}

/// Contradictions of so many drawn outlines.
pub(super) fn all_wrong(count: u64) -> Vec<String> {
    (0..count).flat_map(|index| wrong(&mut Sampler::new(62, "outlines", index))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outlines_are_judged_as_they_are_drawn() {
        assert_eq!(all_wrong(2000), Vec::<String>::new());
        let bow = [[0, 0], [2, 2], [2, 0], [0, 2]];
        assert!(meet(&bow, [0, 2]) && !meet(&bow, [0, 1]) && !meet(&bow, [1, 3]));
        assert!(meet(&[[0, 0], [4, 0], [2, 0], [2, 2]], [0, 1]) && meet(&[[0, 0], [4, 0], [4, 2], [2, 0]], [0, 2]));
    }
}
