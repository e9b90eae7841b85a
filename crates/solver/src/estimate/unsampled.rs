//! Light that no sample of an element sees, though there may be some: bounds on it, by geometry alone.
//!
//! Only an outline changes whether x sees y: an edge of a face that does not turn the same side to x as the other face at that edge does,
//! or a line where faces cross. So if no outline of a solid, of faces that hang together, is between an element and a source, by their
//! hulls, the solid hides all of the source from all of the element or nothing, and the sight of any one place says which. Where a solid
//! stands on the element, each part of it beside the solid is asked by itself. Sources that are cut so count in full, in the part of the
//! hemisphere that they may fill: the brightest first.

mod edges;

use radgrad_core::DVec3;
use radgrad_scene::{largest, smallest as least};

use crate::links::visible::{Visible, Window};
use crate::mesh::Mesh;
use crate::mesh::element::Element;
use crate::mesh::screen::LEVEL;

pub(crate) use edges::Edges;

/// Faces before a source beyond which it is not asked whether an outline of theirs is between.
const MOST_FACES: usize = 24;

/// Cuts of an element by faces that stand on it, beyond which its parts are not asked one by one.
const MOST_CUTS: usize = 3;

/// Part of a source that may be hidden where nothing is, or seen where all is hidden, by the rounding of its parts.
const NONE: f64 = 0.05;

/// Factor on bounds for the rounding of their sums and products.
const ROUNDED: f64 = 1.0 + 1e-9;

/// A mesh and the lines of its faces.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Outlined<'a> {
    pub(crate) mesh: &'a Mesh,
    pub(crate) edges: &'a Edges,
}

impl Outlined<'_> {
    /// Bounds on the light on an element, at most and in the mean, of sources that its nodes do not see at all and that others of its
    /// places may: these are sources, each with the faces that may hide it and the largest magnitude of its radiosity.
    pub(crate) fn unseen<'s>(&self, element: usize, sources: impl Iterator<Item = (usize, &'s [usize], f64)>) -> [f64; 2] {
        let elements = self.mesh.elements();
        let (mut bounds, mut mean) = (Vec::new(), 0.0);
        for (source, faces, size) in sources {
            if self.may_see_a_part(element, source, faces) {
                let (factor, of) = (factor(&elements[element], &elements[source]), &elements[source]);
                bounds.push((factor, size));
                mean += size * least(factor, of.area() / elements[element].area());
            }
        }
        let largest_irradiance = fill(bounds);
        [largest_irradiance, least(largest_irradiance, mean)]
    }

    /// Whether an outline of the faces before a source may be between it and an element, and no solid hides it whole.
    fn may_see_a_part(&self, to: usize, source: usize, faces: &[usize]) -> bool {
        if faces.len() > MOST_FACES {
            return true;
        }
        let from = self.mesh.elements()[to].polygon().vertices();
        let (mut left, mut is_cut) = (faces.to_vec(), false);
        while let Some(&first) = left.first() {
            let solid = self.edges.solid(first);
            let (of_solid, others): (Vec<usize>, _) = left.into_iter().partition(|&face| self.edges.solid(face) == solid);
            left = others;
            match self.hides(to, from, source, &of_solid, MOST_CUTS) {
                Some(true) => return false,
                Some(false) => {}
                None => is_cut = true,
            }
        }
        is_cut
    }

    /// Whether some faces hide all of a source from all of a part of an element (`true`), or nothing of it; `None` if neither is
    /// sure. Where one of them stands on that part, the pieces on its two sides are asked, and must agree.
    fn hides(&self, to: usize, from: &[DVec3], source: usize, faces: &[usize], cuts: usize) -> Option<bool> {
        let (element, of_source) = (&self.mesh.elements()[to], &self.mesh.elements()[source]);
        if let Some(face) = self.edges.standing(element.face(), from, faces) {
            let remaining = cuts.checked_sub(1)?;
            let of_side = |sign: f64| self.hides(to, &self.edges.beside(face, sign, from), source, faces, remaining);
            return of_side(1.0).filter(|of| of_side(-1.0) == Some(*of));
        }
        let normal = element.polygon().normal();
        let crossing = self.edges.of_face(of_source.face()).iter().filter(|&&line| self.edges.crosses(line));
        let mut lines = faces.iter().flat_map(|&face| self.edges.of_face(face)).chain(crossing);
        let is_cut = lines.any(|&line| {
            let ends = self.edges.ends(line);
            ends.iter().any(|&end| normal.dot(end - element.centre()) > 0.0)
                && self.edges.outlined_from(line, from).iter().any(|from| in_beam(from, of_source, ends))
        });
        if is_cut || from.is_empty() {
            return None;
        }
        let middle = from.iter().sum::<DVec3>() / from.len() as f64;
        let (window, shape) = (Window::on_element(of_source), of_source.shape());
        let convex = faces.iter().flat_map(|&face| self.mesh.convex_parts(face)).map(|part| &part[..]);
        let [free, past] = [
            Visible::from_point(middle, normal, &window, std::iter::empty())?,
            Visible::from_point(middle, normal, &window, convex)?,
        ];
        let [[least, whole], [seen, most]] = [free, past].map(|of| [of.share(shape) - 2.0 * of.doubt, of.share(shape)]);
        // All of it is hidden, or all of it is seen; if neither is sure there may be an outline after all.
        if most < NONE * least { Some(true) } else { (seen > (1.0 - NONE) * whole).then_some(false) }
    }
}

/// Bound on the form factor of a source from anywhere on an element.
fn factor(element: &Element, source: &Element) -> f64 {
    let (n1, n2) = (element.polygon().normal(), source.polygon().normal());
    let (to, from) = (element.polygon().vertices(), source.polygon().vertices());
    let over = from.iter().map(|&v| n1.dot(v - element.centre())).fold(0.0, largest);
    let height = to.iter().map(|&v| n2.dot(v - source.centre())).fold(0.0, largest);
    if over == 0.0 || height == 0.0 {
        return 0.0;
    }
    let distance = largest(element.distance_to(source) * (1.0 - 1e-9), 0.0);
    let lune = least(0.5 * (1.0 - n1.dot(n2)) + 1e-12, 1.0);
    if distance == 0.0 {
        return lune;
    }
    let square = std::f64::consts::PI * distance * distance;
    least(source.area() * least(over / distance, 1.0) * least(height / distance, 1.0) / square * ROUNDED, lune)
}

/// The most of `sum F_j u_j` for `0 <= F_j <= f_j` and `sum F_j <= 1`, from pairs of `f_j` and `u_j`.
pub(crate) fn fill(mut pairs: Vec<(f64, f64)>) -> f64 {
    pairs.sort_by(|a, b| b.1.total_cmp(&a.1));
    let (mut sum, mut rest) = (0.0, 1.0);
    for (factor, value) in pairs {
        if value.is_nan() {
            return f64::NAN;
        }
        if value <= 0.0 || rest <= 0.0 {
            break;
        }
        let part = least(factor, rest);
        sum += part * value;
        rest -= part;
    }
    sum
}

/// Whether a segment may be between points `x` of a convex polygon and a source.
///
/// With heights over the source's plane, `h` of x and `g` of a point p of the segment, the line of sight meets that plane at
/// `(h p - g x)/(h - g)`. On which side of a line `n.y = d` of the plane that is says the sign of `h (n.p - d) - g (n.x - d)`, linear in
/// x and in p: if it is negative at all corners and ends, and no corner of the source is on that side of the line, nothing of the
/// source is past the segment. The lines are the sides of the source, and those of the hull of the crossings: in a plane with the
/// segment and a corner, or with a side and an end. A segment that no more than touches the way to the source, as where a shade meets its
/// lamp, is not between: less than `s (h - g)` will do, which leaves a strip of the source of the width s, [`LEVEL`] of its radius.
fn in_beam(from: &[DVec3], source: &Element, piece: [DVec3; 2]) -> bool {
    let (normal, corner, corners) = (source.polygon().normal(), source.centre(), source.polygon().vertices());
    let height = |p: DVec3| normal.dot(p - corner);
    let (of_piece, of_from) = (piece.map(height), from.iter().map(|&x| height(x)));
    let of_from: Vec<f64> = of_from.collect();
    let reach = source.radius() + from.iter().chain(&piece).map(|p| (*p - corner).length()).fold(0.0, largest);
    let level = 1e-9 * reach;
    let highest = of_from.iter().copied().fold(f64::NEG_INFINITY, largest);
    if of_piece.iter().all(|h| *h < -level) || of_piece.iter().all(|h| *h > highest + level) {
        return false;
    }
    let strip = LEVEL * source.radius();
    let is_separated = |n: DVec3| {
        let d = corners.iter().map(|&v| n.dot(v - corner)).fold(f64::INFINITY, least);
        let across = |x: DVec3| n.dot(x - corner) - d;
        let of_piece = [(across(piece[0]), of_piece[0]), (across(piece[1]), of_piece[1])];
        from.iter().zip(&of_from).all(|(&x, h)| {
            let of_x = across(x);
            of_piece.iter().all(|(of_p, g)| {
                let rounding = 8.0 * f64::EPSILON * ((h * of_p).abs() + (g * of_x).abs());
                h * of_p - g * of_x + rounding <= strip * (h - g)
            })
        })
    };
    let separates = |n: DVec3| {
        let n = n.normalize_or_zero();
        n != DVec3::ZERO && (is_separated(n) || is_separated(-n))
    };
    let count = from.len();
    let sides = (0..corners.len()).map(|i| normal.cross(corners[(i + 1) % corners.len()] - corners[i]));
    let along = from.iter().map(|&x| (piece[0] - x).cross(piece[1] - x));
    let across = (0..count).flat_map(|i| piece.map(|p| (from[i] - p).cross(from[(i + 1) % count] - p)));
    // The line in which such a plane meets that of the source has the direction `normal x n`.
    let others = along.chain(across).map(|n| n - normal * n.dot(normal));
    !sides.chain(others).any(separates)
}

#[cfg(test)]
mod tests {
    use radgrad_core::Polygon;

    use super::*;
    use crate::mesh::basis::Basis;
    use crate::mesh::shape::Shape;

    /// A lamp over a floor, and an edge that comes down from one of its corners.
    #[test]
    fn an_edge_that_touches_the_way_to_a_lamp_is_not_between_and_one_that_reaches_into_it_is() {
        let bases = [Shape::Parallelogram, Shape::Triangle].map(|shape| Basis::new(shape, 0));
        let corners = [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]];
        let lamp = Polygon::new(corners.map(|[x, y]| DVec3::new(x, y, 1.0)).to_vec()).unwrap();
        let lamp = &Element::of_face(&lamp, 0, &bases).unwrap()[0];
        let floor = |x: f64, y: f64| [[0.0, 0.0], [0.1, 0.0], [0.1, 0.1], [0.0, 0.1]].map(|[s, t]| DVec3::new(x + s, y + t, 0.0));
        let edge = |x: f64, y: f64| [DVec3::new(x, y, 1.0), DVec3::new(x, y, 0.5)];
        // Past the edge one sees the scene beyond the lamp, and from the corner's other side the lamp.
        for (x, y) in [(3.0, 0.4), (0.4, 3.0), (3.0, 3.0), (0.4, 0.4)] {
            assert!(!in_beam(&floor(x, y), lamp, edge(0.0, 0.0)), "({x}, {y})");
        }
        assert!(in_beam(&floor(-2.0, -2.0), lamp, edge(0.0, 0.0)));
        for into in [1e-9, 1e-3, 0.5] {
            assert!(in_beam(&floor(3.0, 0.4), lamp, edge(into, into)), "{into}");
        }
        // A side is touched all along, or passed.
        assert!(!in_beam(&floor(3.0, 0.4), lamp, [DVec3::new(-1.0, 0.0, 1.0), DVec3::new(2.0, 0.0, 1.0)]));
        assert!(in_beam(&floor(3.0, 0.4), lamp, [DVec3::new(-1.0, 1e-6, 1.0), DVec3::new(2.0, 1e-6, 1.0)]));
    }
}
