//! The visible part of an emitter behind an occluder, where it is a polygon again.
//!
//! One kind of occluded case can be put to oracles of free sight: a triangle that stands on the diagonal between the neighbours
//! of a vertex and hides that vertex. The visible part is the emitter without that vertex. The seam lies in the emitter's plane,
//! so it stays where it is when the receiver moves, and the gradient too is that of the visible part. The cubature has no other
//! way to a truth with occluders, and the enclosure with occluders is held against it.
//!
//! Decided by exact predicates on the vertices as given (Shewchuk, "Adaptive precision floating-point arithmetic and fast robust
//! geometric predicates", 1997).

use std::borrow::Cow;

use glam::DVec3;
use radgrad_core::{Emission, Emitter, Linear, Polygon};
use radgrad_scene::case::Problem;

use crate::cases::sampler::normalising_power;

/// The emitter in free sight with the same radiosity and gradient; `None` where there is none that this module knows of.
#[must_use]
pub fn visible_part(problem: &Problem) -> Option<Cow<'_, Emitter>> {
    match problem.occluders.as_slice() {
        [] => Some(Cow::Borrowed(&problem.emitter)),
        [screen] => occluded(problem, screen).map(Cow::Owned),
        _ => None,
    }
}

/// The visible part of the emitter and no occluders where [`visible_part`] knows that part, else emitter and occluders as they stand.
#[must_use]
pub(crate) fn reduced(problem: &Problem) -> (Cow<'_, Emitter>, &[Polygon]) {
    visible_part(problem).map_or((Cow::Borrowed(&problem.emitter), problem.occluders.as_slice()), |emitter| (emitter, &[]))
}

fn occluded(problem: &Problem, screen: &Polygon) -> Option<Emitter> {
    let &[a, b, c] = screen.vertices() else { return None };
    let hidden = (0..problem.emitter.polygon().vertices().len())
        .find(|&vertex| [[a, b, c], [b, c, a], [c, a, b]].into_iter().any(|base_first| hides(problem, base_first, vertex)))?;
    without(&problem.emitter, hidden)
}

/// Whether a triangle stands on the two neighbours of a vertex and hides the part that the diagonal cuts off, and no more.
fn hides(problem: &Problem, [p, q, top]: [DVec3; 3], vertex: usize) -> bool {
    let (x, vertices) = (problem.receiver.position(), problem.emitter.polygon().vertices());
    let count = vertices.len();
    let largest = vertices.iter().chain([&x, &top]).fold(0.0, |m: f64, v| m.max(v.abs().max_element()));
    let volume = |a: DVec3, b, c, d| volume([a, b, c, d].map(|v| v * normalising_power(largest)));
    let [before, corner, after] = [vertex + count - 1, vertex, vertex + 1].map(|i| vertices[i % count]);
    if [p, q] != [before, after] && [q, p] != [before, after] {
        return false;
    }
    // The corner lies in the cone of the screen, and the other vertices beyond the side through the diagonal.
    let inward = volume(x, p, q, top);
    let in_cone = [(p, q), (q, top), (top, p)].iter().all(|(from, to)| agree(volume(x, *from, *to, corner), inward));
    let mut others = vertices.iter().filter(|v| ![p, corner, q].contains(v));
    let apart = others.all(|v| agree(volume(x, p, q, *v), -inward));
    // The screen is on the receiver's side of the emitter's plane.
    in_cone && apart && agree(volume(p, corner, q, top), volume(p, corner, q, x))
}

/// Positive, negative or 0 as the volume of a tetrahedron, exactly.
fn volume(corners: [DVec3; 4]) -> f64 {
    let [a, b, c, d] = corners.map(|v| robust::Coord3D { x: v.x, y: v.y, z: v.z });
    robust::orient3d(a, b, c, d)
}

/// Whether both have one sign.
fn agree(a: f64, b: f64) -> bool {
    (a > 0.0 && b > 0.0) || (a < 0.0 && b < 0.0)
}

/// The emitter without a vertex, if its emission is stated apart from that vertex.
fn without(emitter: &Emitter, vertex: usize) -> Option<Emitter> {
    let drop = |list: &[f64]| list.iter().enumerate().filter(|(i, _)| *i != vertex).map(|(_, v)| *v).collect();
    let emission = match emitter.emission() {
        Emission::Linear(Linear::AtVertices(values)) => Emission::at_vertices(drop(values)),
        Emission::Linear(Linear::Gradient { .. }) if vertex == 0 => return None,
        other => other.clone(),
    };
    let remaining = emitter.polygon().vertices().iter().enumerate().filter(|(i, _)| *i != vertex).map(|(_, v)| *v);
    Emitter::new(Polygon::from_rounded(remaining.collect(), emitter.polygon().precision()).ok()?, emission).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases::family::Family;
    use radgrad_core::{Receiver, evaluate};

    fn problem(top: DVec3) -> Problem {
        let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
        let emission = Emission::at_vertices(vec![1.0, 2.0, 4.0, 3.0]);
        let emitter = Emitter::new(Polygon::new(square.to_vec()).unwrap(), emission).unwrap();
        let screen = Polygon::new(vec![square[1], square[3], top]).unwrap();
        let receiver = Receiver::new(DVec3::new(0.3, 0.2, 2.0), DVec3::NEG_Z, 1.0).unwrap();
        Problem { receiver, emitter, occluders: vec![screen], tolerance: 1e-12 }
    }

    #[test]
    fn a_screen_on_a_diagonal_hides_its_corner_and_nothing_else() {
        let problem = problem(DVec3::new(1.5, 1.5, 0.5));
        let visible = visible_part(&problem).expect("one corner is hidden");
        assert_eq!(visible.polygon().vertices(), [DVec3::ZERO, DVec3::X, DVec3::Y]);
        assert_eq!(visible.emission(), &Emission::at_vertices(vec![1.0, 2.0, 3.0]));
        let past = evaluate(&problem.receiver, &problem.emitter, &problem.occluders).unwrap();
        let free = evaluate(&problem.receiver, &visible, &[]).unwrap();
        assert!((past.radiosity - free.radiosity).abs() <= past.radiosity_error + free.radiosity_error);
        assert!((past.gradient - free.gradient).length() <= past.gradient_error + free.gradient_error);
    }

    #[test]
    fn other_screens_are_not_taken_for_one() {
        // Too small to hide the corner, below the plane, leaning aside.
        for top in [DVec3::new(0.8, 0.8, 0.1), DVec3::new(1.5, 1.5, -0.5), DVec3::new(3.0, 0.5, 0.5)] {
            assert_eq!(visible_part(&problem(top)), None, "{top}");
        }
        let mut two = problem(DVec3::new(1.5, 1.5, 0.5));
        two.occluders.push(two.occluders[0].clone());
        assert_eq!(visible_part(&two), None);
    }

    #[test]
    fn every_case_of_a_family_with_a_screen_has_a_seen_part() {
        for (family, index) in [Family::FarScreen, Family::ScreenScale].into_iter().flat_map(|f| (0..300).map(move |i| (f, i))) {
            let problem = family.case(1, index).problem().expect("valid");
            let count = problem.emitter.polygon().vertices().len();
            let visible = visible_part(&problem).unwrap_or_else(|| panic!("{family} {index}: {problem:?}"));
            assert_eq!(visible.polygon().vertices().len(), count - 1);
        }
    }
}
