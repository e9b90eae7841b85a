//! A solution as bytes, of which it is made again without solving: queries to it then have the same digits.
//!
//! The mesh follows from the scene, how faces were cut and which elements were divided, and so do bases, lamps, textures and lines of
//! faces. Links, light, estimates and the findings of the rounds are written as they are. Caches are filled again.

use radgrad_scene::{Prepared, Scene, fnv1a};

use crate::bytes::Bytes;
use crate::clock::Clock;
use crate::error::Error;
use crate::links::link::Link;
use crate::mesh::basis::MAX_DEGREE;
use crate::mesh::outline::{Cut, Given};
use crate::mesh::{Mesh, Sight};
use crate::solve::dark;
use crate::solve::goal_points::GoalPoints;
use crate::solve::options::Options;
use crate::solve::solution::Solution;

/// The first bytes: they change with their meaning.
const HEAD: &[u8; 16] = b"radgrad solved 2";

/// Fields as they are written and read, one after the other.
macro_rules! findings {
    ($($part:ident.$field:ident),* $(,)?) => {
        impl Solution {
            /// Writes the findings of rounds.
            fn put_findings(&self, to: &mut Vec<u8>) {
                $(self.$part.$field.put(to);)*
                self.progress.put(to);
            }

            /// Reads them.
            fn take_findings(&mut self, from: &mut &[u8]) -> Option<()> {
                $(self.$part.$field = Bytes::take(from)?;)*
                self.progress = Bytes::take(from)?;
                Some(())
            }
        }
    };
}

findings! {
    radiosity.direct, radiosity.field, radiosity.own, radiosity.unseen, radiosity.mean, radiosity.reflected,
    system.links, system.far, system.receivers, system.extent,
    refinement.served, refinement.direct_residual,
    error_estimate.mean, error_estimate.residuals, error_estimate.weights, error_estimate.shares,
    caches.estimated, caches.importance, caches.known_error,
    budget.absolute, budget.past, budget.asked, budget.allowed, budget.clock, budget.cells,
}

impl Solution {
    /// The solution as bytes, for this version of the program and the same scene.
    ///
    /// ```
    /// use radgrad_solver::{Options, Solution, solve};
    /// # use radgrad_scene::{Degenerate, Scene};
    /// # use radgrad_core::DVec3;
    /// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/two_blocks.obj");
    /// let scene = Scene::read(file, Degenerate::Refuse)?;
    /// let options = Options { error: 0.5, degree: Some(1), first_elements: 1, ..Options::default() };
    /// let solution = solve(&scene, &options, |_| true)?;
    /// let again = Solution::from_bytes(&scene, &solution.to_bytes())?;
    /// let at = |of: &Solution| of.gather(DVec3::new(2.0, 0.5, 0.0), DVec3::Z);
    /// assert_eq!(at(&again)?, at(&solution)?);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut to = Vec::new();
        self.system.mesh.bases()[0].degree().put(&mut to);
        self.system.mesh.given().put(&mut to);
        self.system.mesh.divisions().put(&mut to);
        self.put_findings(&mut to);
        let head = [&HEAD[..], &fnv1a(to.iter().copied()).to_le_bytes()].concat();
        to.splice(0..0, head);
        to
    }

    /// The solution of a scene that was made into bytes.
    ///
    /// # Errors
    /// If the bytes are none, are damaged, or are those of another scene or version; and as for [`crate::solve`].
    pub fn from_bytes(scene: &Scene, bytes: &[u8]) -> Result<Self, Error> {
        let refused = |rule| Error::Bytes { rule };
        let rest = bytes.strip_prefix(HEAD).and_then(|rest| rest.split_first_chunk());
        let (sum, mut rest) = rest.ok_or_else(|| refused("they begin otherwise"))?;
        if fnv1a(rest.iter().copied()) != u64::from_le_bytes(*sum) {
            return Err(refused("their checksum is another one: they are damaged"));
        }
        let ready = Prepared::new(scene)?;
        let from = &mut rest;
        let cut_short = || refused("they are cut short");
        let degree = usize::take(from).filter(|degree| *degree <= MAX_DEGREE).ok_or_else(cut_short)?;
        let given = Given::take(from).ok_or_else(cut_short)?;
        let mut mesh = Mesh::cut(&ready.scene, degree, Cut::of(&given))?;
        for (index, element) in Vec::<usize>::take(from).ok_or_else(cut_short)?.into_iter().enumerate() {
            let count = mesh.elements().len();
            if element >= count {
                return Err(Error::Division { index, element, count });
            }
            mesh.divide(element)?;
        }
        let options = Options { degree: Some(degree), ..Options::default() };
        let mut solution = dark(&ready, &options, (mesh, GoalPoints::default()), Clock::started())?;
        solution.system.surfaces.grow(&solution.system.mesh);
        solution.take_findings(from).ok_or_else(cut_short)?;
        if !(from.is_empty() && solution.is_whole()) {
            return Err(refused("they are those of another scene"));
        }
        Ok(solution)
    }

    /// Whether all that was taken is of this mesh.
    fn is_whole(&self) -> bool {
        let (elements, channels) = (self.system.mesh.elements().len(), self.channels().len());
        let (faces, clusters) = (self.system.mesh.polygons().len(), self.system.mesh.clusters().clusters().len());
        let coefficients = |element: usize| self.basis(element).len() * channels;
        let is_sight = |sight: &Sight| match sight {
            Sight::Nothing(face) => face.is_none_or(|face| face < faces),
            Sight::Clear => true,
            Sight::Past(hiding) => hiding.iter().all(|face| *face < faces),
        };
        let is_link = |receiver: usize, link: &Link| {
            link.source < elements && is_sight(&link.sight) && link.is_of(self.basis(receiver), self.basis(link.source))
        };
        let is_field = |field: Option<&crate::field::Field>| field.is_none_or(|field| field.is_of(&self.system.mesh, channels));
        [self.radiosity.own.len(), self.system.links.len(), self.system.far.len()].iter().all(|length| *length == elements)
            && self.radiosity.own.iter().enumerate().all(|(index, own)| own.is_empty() || own.len() == coefficients(index))
            && self.system.links.iter().enumerate().all(|(receiver, links)| links.iter().all(|link| is_link(receiver, link)))
            && (0..elements).all(|index| self.system.far[index].is_of(self.basis(index), clusters))
            && (self.radiosity.direct.is_empty() && self.system.lamps.is_empty() || self.radiosity.direct.len() == elements)
            && self
                .radiosity
                .direct
                .iter()
                .all(|direct| direct.is_of(self.system.lamps.roots().len(), channels) && direct.sights().iter().all(is_sight))
            && self.system.receivers.iter().all(|receiver| *receiver < elements && self.gathers(*receiver))
            && is_field(Some(&self.radiosity.field))
            && is_field(self.caches.importance.get().and_then(Option::as_ref))
            && is_field(self.caches.known_error.get().and_then(Option::as_ref))
            && self.error_estimate.is_of(elements, channels)
            && self.caches.estimated.get().is_none_or(|of| of.len() == channels)
            && [&self.radiosity.mean, &self.radiosity.reflected].iter().all(|of| of.len() == channels)
    }
}

#[cfg(test)]
mod tests {
    use radgrad_core::DVec3;
    use radgrad_scene::Degenerate;

    use super::*;
    use crate::solve::options::Marking;
    use crate::solve::solve;

    fn scene(name: &str) -> Scene {
        let file = format!("{}/../../data/scenes/{name}", env!("CARGO_MANIFEST_DIR"));
        Scene::read(file, Degenerate::Refuse).unwrap()
    }

    #[test]
    fn a_solution_comes_back_with_all_its_answers() {
        for (name, marking, error) in [
            ("cornell.obj", Marking::Residual, 0.05),
            ("two_blocks.obj", Marking::Gradient, 0.3),
            ("two_blocks.obj", Marking::Shadows, 0.3),
        ] {
            let scene = scene(name);
            let options = Options { error, degree: Some(1), marking, ..Options::default() };
            let solution = solve(&scene, &options, |solution| solution.progress().round < 2).unwrap();
            let bytes = solution.to_bytes();
            let again = Solution::from_bytes(&scene, &bytes).unwrap();
            assert_eq!(again.to_bytes(), bytes, "{name}");
            assert_eq!((again.progress(), again.mean()), (solution.progress(), solution.mean()));
            assert_eq!(format!("{:?}", again.mean_estimate()), format!("{:?}", solution.mean_estimate()));
            let places = solution.mesh().leaves().step_by(7).take(12);
            for element in places.map(|leaf| &solution.mesh().elements()[leaf]) {
                let (point, normal) = (solution.placement().outward(element.centre()), element.polygon().normal());
                let of = |of: &Solution| format!("{:?}{:?}", of.gather(point, normal), of.gradient(point, normal));
                assert_eq!(of(&again), of(&solution), "{name} at {point}");
                let free = |of: &Solution| format!("{:?}", of.irradiance_at(point + 0.01 * normal, DVec3::Z));
                assert_eq!(free(&again), free(&solution), "{name} before {point}");
            }
        }
    }

    #[test]
    fn bytes_of_something_else_are_refused() {
        let (blocks, cornell) = (scene("two_blocks.obj"), scene("cornell.obj"));
        let options = Options { error: 0.9, degree: Some(0), first_elements: 1, ..Options::default() };
        let bytes = solve(&blocks, &options, |_| false).unwrap().to_bytes();
        assert!(Solution::from_bytes(&cornell, &bytes).is_err());
        for end in [0, 10, 24, bytes.len() / 2, bytes.len() - 1] {
            assert!(Solution::from_bytes(&blocks, &bytes[..end]).is_err(), "{end}");
        }
        // Damage that the checksum does not show, since it was made anew.
        for at in (24..bytes.len()).step_by(bytes.len() / 60 + 1) {
            let mut wrong = bytes.clone();
            wrong[at] ^= 0x55;
            let sum = fnv1a(wrong[24..].iter().copied());
            wrong[16..24].copy_from_slice(&sum.to_le_bytes());
            let read = Solution::from_bytes(&blocks, &wrong);
            let _ = read.map(|solution| solution.gather(DVec3::new(2.0, 0.5, 0.0), DVec3::Z));
        }
    }
}
