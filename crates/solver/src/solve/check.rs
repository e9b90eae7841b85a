//! Checks of a round that cost little: no point sees more than everything, and every answer is a number.

use radgrad_scene::Scene;
use rayon::prelude::*;

use crate::error::Error;
use crate::estimate::ledger::Ledger;
use crate::links::cluster::far::{MARGIN, cover};
use crate::solve::solution::Solution;

/// Faces that are named of those that a point sees most of.
const NAMED: usize = 3;

impl Solution {
    /// Refuses faces that overlap, by form factors that sum to more than 1 whatever their errors are, and numbers that are not
    /// finite. The sum leaves out clusters, so it may miss an overlap but never claims one.
    pub(super) fn check(&self, scene: &Scene) -> Result<(), Error> {
        if let Some(error) = self.system.receivers.par_iter().find_map_first(|&receiver| self.covered(scene, receiver)) {
            return Err(error);
        }
        let estimates = self.error_estimate.mean.iter().map(Ledger::total).collect();
        self.refuse([("mean radiosity", self.radiosity.mean.clone()), ("estimate of the error", estimates)])
    }

    fn refuse<const N: usize>(&self, figures: [(&str, Vec<f64>); N]) -> Result<(), Error> {
        for (quantity, values) in figures {
            if let Some(channel) = values.iter().position(|value| !value.is_finite()) {
                let (channel, value) = (self.system.channels[channel].clone(), values[channel]);
                return Err(Error::NotFinite { quantity: quantity.to_owned(), channel, value });
            }
        }
        Ok(())
    }

    fn covered(&self, scene: &Scene, receiver: usize) -> Option<Error> {
        let links = &self.system.links[receiver];
        let mut sums = vec![0.0; self.basis(receiver).nodes().len()];
        links.iter().for_each(|link| cover(&mut sums, &link.rows, 1.0));
        let node = (0..sums.len()).find(|&node| sums[node] > 1.0 + MARGIN)?;
        let mut by_face: Vec<(f64, usize)> = Vec::new();
        for link in links {
            let (face, factor) = (self.element(link.source).face(), link.rows[node].factor());
            match by_face.iter_mut().find(|(_, counted)| *counted == face) {
                Some((sum, _)) => *sum += factor,
                None => by_face.push((factor, face)),
            }
        }
        by_face.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let faces = by_face.iter().take(NAMED).map(|&(_, face)| scene.name_of(face)).collect();
        Some(Error::Covered { face: scene.name_of(self.element(receiver).face()), sum: sums[node], faces })
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use radgrad_core::{DVec3, Polygon};
    use radgrad_scene::{Occluders, Placement, Prepared};

    use super::*;
    use crate::mesh::Mesh;
    use crate::solve::goal_points::GoalPoints;
    use crate::solve::options::Options;
    use crate::solve::solve_on;

    #[test]
    fn a_point_that_sees_a_lamp_twice_is_found_though_the_scene_was_not_held_to_overlaps() {
        let mut scene = Scene::new(["grey"]).unwrap();
        let (white, surface) = (scene.add_material("white", [0.5], [1.0]).unwrap(), scene.add_surface("all"));
        let mut level = |size: f64, z: f64, turned: bool| {
            let mut corners =
                [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| DVec3::new(size * x, size * y, z));
            if turned {
                corners.reverse();
            }
            scene.add_face(surface, white, Polygon::new(corners.to_vec()).unwrap(), None).unwrap();
        };
        level(1.0, 0.0, false);
        level(10.0, 1.0, true);
        let options = Options { error: 0.1, ..Options::default() };
        let solved = |scene: &Scene| {
            let (placement, index, warnings) = (Placement::default(), Arc::new(Occluders::new(scene.polygons())), Vec::new());
            let ready = Prepared { scene: scene.clone(), placement, index, warnings };
            solve_on(&ready, &options, (Mesh::new(scene, 1).unwrap(), GoalPoints::default()), |_| false).map(|_| ())
        };
        assert_eq!(solved(&scene), Ok(()));
        let again = scene.faces()[1].polygon().clone();
        scene.add_face(surface, white, again, None).unwrap();
        let error = solved(&scene).unwrap_err();
        let Error::Covered { sum, faces, .. } = &error else { panic!("{error}") };
        assert!(
            *sum > 1.5 && ["face 1 of `all`", "face 2 of `all`"].iter().all(|twice| faces.iter().any(|face| face == twice)),
            "{error}"
        );
    }
}
