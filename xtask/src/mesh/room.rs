//! A closed room of squares: a lamp in the middle of the ceiling, and a block on the floor.

use super::{Quad, reversed};

/// The materials of the room.
pub(super) const MATERIALS: &str =
    "newmtl white\nKd 0.7 0.7 0.7\nnewmtl red\nKd 0.6 0.1 0.1\nnewmtl light\nKd 0.8 0.8 0.8\nKe 20 20 20\n";

/// A room of size 1 whose sides have `side^2` squares each, as OBJ; `materials` is the file with [`MATERIALS`].
pub(super) fn room(side: usize, materials: &str) -> String {
    let mut text = format!("mtllib {materials}\n");
    let mut count = 0;
    let mut add = |surface: &str, material: &str, squares: Vec<Quad>| {
        text += &format!("o {surface}\nusemtl {material}\n");
        for square in squares {
            for [x, y, z] in square {
                text += &format!("v {x} {y} {z}\n");
            }
            text += &format!("f {} {} {} {}\n", count + 1, count + 2, count + 3, count + 4);
            count += 4;
        }
    };
    // A third of the squares along the ceiling, about the middle.
    let is_lamp = |[i, j]: [usize; 2]| [i, j].iter().all(|k| 3 * k + 2 > side && 3 * (k + 1) < 2 * side + 2);
    let inside = |axis, at_high| plane(axis, at_high, [[0.0, 1.0]; 3], side, |_| true);
    for (axis, name) in ["x", "y"].into_iter().enumerate() {
        for (is_high, end) in [(false, "low"), (true, "high")] {
            let material = if axis == 0 && !is_high { "red" } else { "white" };
            add(&format!("wall_{name}_{end}"), material, inside(axis, is_high));
        }
    }
    add("floor", "white", inside(2, false));
    add("ceiling", "white", plane(2, true, [[0.0, 1.0]; 3], side, |square| !is_lamp(square)));
    add("lamp", "light", plane(2, true, [[0.0, 1.0]; 3], side, is_lamp));
    // It stands a little above the floor, and is seen from outside.
    let block = [[0.2, 0.5], [0.3, 0.7], [0.01, 0.4]];
    let sides = [(0, false), (0, true), (1, false), (1, true), (2, false), (2, true)];
    let squares = sides.into_iter().flat_map(|(axis, is_high)| plane(axis, is_high, block, side.div_ceil(3), |_| true));
    add("block", "white", squares.map(reversed).collect());
    text
}

/// The squares of a side of a box that count, seen from inside: across an axis, at its low or its high end.
fn plane(axis: usize, is_high: bool, ends: [[f64; 2]; 3], side: usize, counts: impl Fn([usize; 2]) -> bool) -> Vec<Quad> {
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let at = |axis: usize, k: usize| ends[axis][0] + (ends[axis][1] - ends[axis][0]) * k as f64 / side as f64;
    let corner = |i: usize, j: usize| {
        let mut corner = [ends[axis][usize::from(is_high)]; 3];
        (corner[u], corner[v]) = (at(u, i), at(v, j));
        corner
    };
    let squares = (0..side).flat_map(|i| (0..side).map(move |j| [i, j])).filter(|square| counts(*square));
    let square = |[i, j]: [usize; 2]| [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
    squares.map(|place| if is_high { reversed(square(place)) } else { square(place) }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_room_is_closed_and_has_a_lamp() {
        for side in [4, 9] {
            let text = room(side, "room.mtl");
            let faces = |of: &str| of.lines().filter(|line| line.starts_with("f ")).count();
            assert_eq!(faces(&text), 6 * side * side + 6 * side.div_ceil(3).pow(2), "{side}");
            let [_, lamp] = [0, 1].map(|part| text.split("o lamp").nth(part).unwrap());
            let squares = faces(lamp.split("o block").next().unwrap());
            assert!(squares > 0 && 2 * squares < side * side, "{side}: {squares}");
            // Twice the area vectors of the room: they sum to 0.
            let corners: Vec<[f64; 3]> = text
                .split("o block")
                .next()
                .unwrap()
                .lines()
                .filter_map(|line| line.strip_prefix("v "))
                .map(|line| line.split(' ').map(|word| word.parse().unwrap()).collect::<Vec<f64>>().try_into().unwrap())
                .collect();
            let mut sum = [0.0; 3];
            for square in corners.chunks_exact(4) {
                let [p, q] = [[0, 2], [1, 3]].map(|[a, b]| [0, 1, 2].map(|k: usize| square[b][k] - square[a][k]));
                let cross = [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
                (0..3).for_each(|k| sum[k] += cross[k]);
                // And each looks to the middle.
                let towards: f64 = (0..3).map(|k| (0.5 - square[0][k]) * cross[k]).sum();
                assert!(towards > 0.0, "{square:?}");
            }
            assert!(sum.iter().all(|sum: &f64| sum.abs() < 1e-9), "{sum:?}");
        }
    }
}
