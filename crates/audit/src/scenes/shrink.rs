//! The fewest faces that still fail.

use super::model::{Exact, Model};

/// A scene without a face; the points on it go too, and the exact value of the whole is no longer known.
#[must_use]
pub fn without(model: &Model, part: usize) -> Model {
    let mut smaller = model.clone();
    let below = smaller.parts.remove(part).lies;
    for other in &mut smaller.parts {
        other.lies = other.lies.and_then(|lies| lies.without(part, below));
    }
    smaller.probes.retain(|probe| probe.part != part);
    for probe in &mut smaller.probes {
        probe.part -= usize::from(probe.part > part);
    }
    smaller.exact = Exact::Nothing;
    smaller.closed = false;
    smaller
}

/// The smallest scene that `fails` found from one that does, by leaving out faces, then points; `fails` may say no to all once it
/// has had enough.
pub fn shrink(model: &Model, mut fails: impl FnMut(&Model) -> bool) -> Model {
    let mut smallest = model.clone();
    let mut part = smallest.parts.len();
    while part > 0 && smallest.parts.len() > 1 {
        part -= 1;
        let smaller = without(&smallest, part);
        if fails(&smaller) {
            smallest = smaller;
            part = part.min(smallest.parts.len());
        }
    }
    for probe in (0..smallest.probes.len()).rev() {
        let mut smaller = smallest.clone();
        smaller.probes.remove(probe);
        if fails(&smaller) {
            smallest = smaller;
        }
    }
    smallest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes::family::Family;

    #[test]
    fn a_scene_shrinks_to_what_makes_it_fail() {
        let model = Family::Clutter.model(1, 0);
        let lamp = |model: &Model| model.parts.iter().any(|part| part.emitted[0] > 0.0);
        let small = shrink(&model, lamp);
        assert_eq!((small.parts.len(), small.probes.len()), (1, 0));
        assert!(lamp(&small));
    }
}
