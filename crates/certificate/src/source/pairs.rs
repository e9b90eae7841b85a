//! Pairs of a triangle of a lamp and a triangle of a face that may be lit by it, each with a bound on the share of the lamp's emission that one
//! sends the other, divided where that is most.
//!
//! The power that goes from a triangle p to a triangle c is at most `E` times the least of the area of p, the area of c, and the product of both
//! with the largest kernel `(n_c.r)(-n_p.r)/(pi r^4)`. The first two are drawn by a ray from p, or from c, that has to end on the other one; the last by
//! a point of each, that have to see each other. No pair is kept of which one cannot see the front of the other, or that a convex face hides
//! whole: if it crosses the segments between all corners of both, it crosses every segment between them, as the crossing of a segment between
//! points of both is a mean of the crossings between corners, with positive weights.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::f64::consts::PI;

use radgrad_core::DVec3;
use radgrad_scene::{largest, smallest};
use rand::rngs::ChaCha8Rng;

use crate::model::{Hit, Model, Triangle};
use crate::paths::by_cosine;

/// Pairs of the faces' own triangles, beyond which there are too many.
const MOST_FACES: usize = 100_000;

/// Pairs beyond the first ones at which division ends, and the share of all power of the largest one below which nothing is gained.
const MOST: usize = 20_000;

/// Divisions after which the largest factor of a lamp is bounded well enough.
const DIVISIONS: usize = 1_000;

/// Faces on the way between the middles of a pair that are examined for whether they hide it.
const EXAMINED: usize = 4;

/// Margin of signs and insides, relative to the lengths at hand: no pair is left out by less.
const MARGIN: f64 = 1e-9;

/// A triangle of a lamp and one of a face.
#[derive(Debug, Clone)]
pub(crate) struct Pair {
    pub(crate) lamp: usize,
    piece: Triangle,
    face: usize,
    cell: Triangle,
    /// Bound on the power that goes from one to the other.
    power: f64,
    way: Way,
}

/// How a pair is drawn.
#[derive(Debug, Clone, Copy)]
enum Way {
    /// A ray leaves the lamp's triangle, or arrives on the other one.
    Leaves,
    Arrives,
    /// A point on each; the largest kernel.
    Segment(f64),
}

/// The pairs of a scene, unless there are too many.
pub(super) fn pairs(model: &Model<'_>) -> Option<Vec<Pair>> {
    let receivers: Vec<usize> = receivers(model).collect();
    let count = |faces: &mut dyn Iterator<Item = usize>| faces.map(|face| model.faces[face].triangles.len()).sum::<usize>();
    let lamps: Vec<usize> = model.lamps().map(|(lamp, _)| lamp).collect();
    let first = count(&mut lamps.iter().copied()).checked_mul(count(&mut receivers.iter().copied()))?;
    if first > MOST_FACES {
        return None;
    }
    let by_power = |pair: Pair| Largest(pair.power, pair);
    let mut heap = BinaryHeap::new();
    for &lamp in &lamps {
        for &face in receivers.iter().filter(|face| **face != lamp) {
            for &piece in &model.faces[lamp].triangles {
                for &cell in &model.faces[face].triangles {
                    heap.extend(Pair::new(model, (lamp, piece), (face, cell)).map(by_power));
                }
            }
        }
    }
    let limit = first + MOST;
    let mut ends = Vec::new();
    while heap.len() + ends.len() < limit
        && let Some(Largest(_, pair)) = heap.pop()
    {
        match pair.parts(model) {
            Some(parts) => heap.extend(parts.into_iter().map(by_power)),
            None => ends.push(pair),
        }
    }
    ends.extend(heap.into_iter().map(|Largest(_, pair)| pair));
    (!ends.is_empty()).then_some(ends)
}

impl Pair {
    pub(super) const fn power(&self) -> f64 {
        self.power
    }

    /// The pair, unless nothing goes from one to the other.
    fn new(model: &Model<'_>, (lamp, piece): (usize, Triangle), (face, cell): (usize, Triangle)) -> Option<Self> {
        let [from, to] = [&model.faces[lamp], &model.faces[face]];
        let kernel = largest_kernel((from.normal, piece), (to.normal, cell));
        if kernel == 0.0 || is_hidden(model, (lamp, piece), (face, cell)) {
            return None;
        }
        let areas = [piece.area(), cell.area()];
        let apart = kernel * areas[0] * areas[1];
        let least = smallest(apart, smallest(areas[0], areas[1]));
        let way = if least == apart {
            Way::Segment(kernel)
        } else if least == areas[0] {
            Way::Leaves
        } else {
            Way::Arrives
        };
        Some(Self { lamp, piece, face, cell, power: from.brightest() * least, way })
    }

    /// The pair with the larger one of its triangles divided; `None` where both are too small to be.
    fn parts(&self, model: &Model<'_>) -> Option<Vec<Self>> {
        let of_piece = self.piece.area() > self.cell.area();
        let parts = if of_piece { self.piece.parts() } else { self.cell.parts() };
        if parts.iter().any(|part| !part.area().is_normal()) {
            return None;
        }
        let part = |part: Triangle| {
            let [piece, cell] = if of_piece { [part, self.cell] } else { [self.piece, part] };
            Self::new(model, (self.lamp, piece), (self.face, cell))
        };
        Some(parts.into_iter().filter_map(part).collect())
    }

    /// A point of the lamp; where on the face its light arrives, and with which share of the bound, if it does.
    pub(super) fn draw(&self, model: &Model<'_>, generator: &mut ChaCha8Rng) -> (DVec3, Option<(Hit, f64)>) {
        let [from, to] = [self.lamp, self.face].map(|face| model.faces[face].normal);
        match self.way {
            Way::Leaves => {
                let point = self.piece.point(generator);
                let hit = model.hit(Some(self.lamp), point, by_cosine(from, generator));
                (point, hit.filter(|(face, at)| *face == self.face && self.cell.contains(*at, to)).map(|hit| (hit, 1.0)))
            }
            Way::Arrives => {
                let origin = self.cell.point(generator);
                let hit = model.hit(Some(self.face), origin, by_cosine(to, generator));
                let point = hit.filter(|(lamp, point)| *lamp == self.lamp && self.piece.contains(*point, from));
                point.map_or((origin, None), |(_, point)| (point, Some(((self.face, origin), 1.0))))
            }
            Way::Segment(kernel) => {
                let (point, at) = (self.piece.point(generator), self.cell.point(generator));
                let ray = at - point;
                let (leaves, arrives, square) = (from.dot(ray), -to.dot(ray), ray.length_squared());
                let sees = leaves > 0.0 && arrives > 0.0 && !model.index.is_between([point, at], &[self.lamp, self.face]);
                (point, sees.then(|| ((self.face, at), leaves * arrives / (PI * square * square * kernel))))
            }
        }
    }
}

/// The most that the factor from any point of a face to a lamp can be, whatever is between.
pub(crate) fn largest_factor(model: &Model<'_>, lamp: usize) -> f64 {
    let from = &model.faces[lamp];
    let cells = || receivers(model).filter(|face| *face != lamp);
    if from.triangles.len() * cells().map(|face| model.faces[face].triangles.len()).sum::<usize>() > MOST_FACES {
        return 1.0;
    }
    let bounded = |(face, cell): (usize, Triangle)| {
        let kernel = |piece: &Triangle| piece.area() * largest_kernel((from.normal, *piece), (model.faces[face].normal, cell));
        let factor = smallest(from.triangles.iter().map(kernel).sum::<f64>(), 1.0);
        Largest(factor, (face, cell))
    };
    let cell = |face: usize| model.faces[face].triangles.iter().map(move |&cell| (face, cell));
    let mut heap: BinaryHeap<_> = cells().flat_map(cell).map(bounded).collect();
    for _ in 0..DIVISIONS {
        let Some(Largest(_, (face, cell))) = heap.pop() else { return 0.0 };
        heap.extend(cell.parts().into_iter().map(|part| bounded((face, part))));
    }
    heap.peek().map_or(0.0, |Largest(factor, _)| *factor)
}

/// The faces that reflect.
fn receivers<'a>(model: &'a Model<'_>) -> impl Iterator<Item = usize> + 'a {
    let reflects = |face: &usize| model.faces[*face].exchanges && model.faces[*face].reflectance.iter().any(|rho| *rho > 0.0);
    (0..model.faces.len()).filter(reflects)
}

/// The largest kernel between a triangle of a lamp and one that it lights: 0 if one cannot see the front of the other, infinite if they may touch.
fn largest_kernel((from, piece): (DVec3, Triangle), (to, cell): (DVec3, Triangle)) -> f64 {
    let (mut leaves, mut arrives, mut size) = (0.0, 0.0, 0.0);
    for y in piece.corners {
        for x in cell.corners {
            let ray = x - y;
            leaves = largest(leaves, from.dot(ray));
            arrives = largest(arrives, -to.dot(ray));
            size = largest(size, ray.length());
        }
    }
    let margin = MARGIN * size;
    // Nothing of one is before the other by more than rounding.
    if leaves <= margin || arrives <= margin {
        return 0.0;
    }
    let distance = distance(piece, cell) - margin;
    if distance <= 0.0 {
        return f64::INFINITY;
    }
    ((leaves + margin) / distance).min(1.0) * ((arrives + margin) / distance).min(1.0) / (PI * distance * distance)
}

/// The distance of two triangles, or less: along the line of their middles.
fn distance(a: Triangle, b: Triangle) -> f64 {
    let along = (b.centroid() - a.centroid()).normalize_or_zero();
    let last = a.corners.iter().map(|v| along.dot(*v)).fold(f64::NEG_INFINITY, largest);
    let first = b.corners.iter().map(|v| along.dot(*v)).fold(f64::INFINITY, smallest);
    first - last
}

/// Whether one convex face hides the whole of each from the other.
fn is_hidden(model: &Model<'_>, (lamp, piece): (usize, Triangle), (face, cell): (usize, Triangle)) -> bool {
    let (from, to) = (piece.centroid(), cell.centroid());
    let mut passed = vec![lamp, face];
    for _ in 0..EXAMINED {
        let Some((between, at)) = model.index.first_along(from, to - from, &passed) else { return false };
        if (at - from).length_squared() >= (to - from).length_squared() {
            return false;
        }
        if model.is_convex(between) && hides(model, between, piece, cell) {
            return true;
        }
        passed.push(between);
    }
    false
}

/// Whether a convex face crosses all segments between the corners of two triangles, by more than rounding.
fn hides(model: &Model<'_>, face: usize, piece: Triangle, cell: Triangle) -> bool {
    let (normal, outline) = (model.faces[face].normal, model.outline(face));
    let origin = outline[0];
    piece.corners.iter().all(|&y| {
        cell.corners.iter().all(|&x| {
            let [above, below] = [y, x].map(|point| normal.dot(point - origin));
            let margin = MARGIN * ((y - origin).length() + (x - origin).length());
            if above * below >= 0.0 || above.abs() <= margin || below.abs() <= margin {
                return false;
            }
            let crossing = y + (x - y) * (above / (above - below));
            (0..outline.len()).all(|k| {
                let (a, b) = (outline[k], outline[(k + 1) % outline.len()]);
                normal.dot((b - a).cross(crossing - a)) > margin * (b - a).length()
            })
        })
    })
}

/// Something with the number by which it is compared.
struct Largest<T>(f64, T);

impl<T> PartialEq for Largest<T> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl<T> Eq for Largest<T> {}

impl<T> PartialOrd for Largest<T> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<T> Ord for Largest<T> {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rooms;
    use radgrad_scene::Prepared;

    #[test]
    fn only_what_is_hidden_whole_is_left_out() -> Result<(), radgrad_scene::Error> {
        // The plate's ends along x and along y; floor and lamp are unit squares.
        let plates = [
            ([-0.5, 0.5], [-0.5, 1.5]),
            ([0.5, 1.5], [-0.5, 1.5]),
            ([-0.5, 1.5], [-0.5, 0.5]),
            ([-0.5, 1.5], [0.5, 1.5]),
            ([-0.5, 1.5], [-0.5, 0.999]),
            ([-0.5, 1.5], [-0.5, 1.5]),
        ];
        let whole = plates.len() - 1;
        for (which, (x, y)) in plates.into_iter().enumerate() {
            let scene = rooms::plate_under_a_lamp(x, y);
            let prepared = Prepared::new(&scene)?;
            let model = Model::new(&prepared);
            let [floor, lamp, _] = &model.faces[..] else { panic!("three faces") };
            for piece in &lamp.triangles {
                for cell in &floor.triangles {
                    assert_eq!(hides(&model, 2, *piece, *cell), which == whole, "plate {which}");
                    assert_eq!(is_hidden(&model, (1, *piece), (0, *cell)), which == whole, "plate {which}");
                }
            }
        }
        Ok(())
    }

    #[test]
    fn no_kernel_between_points_is_above_the_largest() {
        let mut generator = rand::SeedableRng::seed_from_u64(3);
        let triangle = |corners: [[f64; 3]; 3]| Triangle { corners: corners.map(DVec3::from) };
        let floor = triangle([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        let over = triangle([[0.0, 0.0, 1.0], [0.0, 1.0, 1.0], [1.0, 0.0, 1.0]]);
        let wall = triangle([[2.0, 0.0, 0.0], [2.0, 0.0, 1.0], [2.0, 1.0, 0.0]]);
        for (piece, from) in [(over, DVec3::NEG_Z), (wall, DVec3::NEG_X)] {
            let bound = largest_kernel((from, piece), (DVec3::Z, floor));
            let kernel = |(y, x): (DVec3, DVec3)| {
                let ray = x - y;
                from.dot(ray) * -ray.z / (PI * ray.length_squared() * ray.length_squared())
            };
            let points: Vec<(DVec3, DVec3)> =
                (0..500).map(|_| (piece.point(&mut generator), floor.point(&mut generator))).collect();
            let largest_kernel_drawn = points.into_iter().map(kernel).fold(0.0, largest);
            assert!(largest_kernel_drawn <= bound && bound < 8.0 * largest_kernel_drawn, "{largest_kernel_drawn} of {bound}");
        }
    }
}
