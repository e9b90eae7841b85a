//! The order in which receivers gather.
//!
//! In sweeps every receiver gathers in its turn, with the radiosities of those before it (Gauss-Seidel). In Southwell's order the
//! one gathers whose residual `s + P rho G b - b`, times its area, is the largest, and its change is shot back along the links to
//! all that gather from it, so that every residual stays known (R. V. Southwell 1946; S. Gortler, M. F. Cohen and P. Slusallek
//! 1994). Both end at the solution of the one linear system. One gather changes one receiver: Southwell's order needs fewer of them
//! where little of the scene is bright, but each costs as many links again for the shooting, and the residuals cost a sweep.
//!
//! Shooting adds rounding errors, and goes along links alone, not to those that see a cluster of which the receiver is a part
//! ([`crate::links::cluster`]). So residuals are computed anew, with the powers of clusters, until none is too large: the light of
//! clusters is a small part, and each time the remaining error shrinks by that factor.

use crate::field::Field;
use crate::field::gathering::{Equation, multiply};
use radgrad_scene::largest;

/// The order in which receivers gather. The solution is the same up to the unsolved residual, and the number of gathers is in
/// [`crate::solve::options::Progress`].
///
/// ```
/// # use radgrad_scene::{Degenerate, Scene};
/// use radgrad_solver::{Options, Order, solve};
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/two_blocks.obj");
/// let scene = Scene::read(file, Degenerate::Refuse)?;
/// let gathers = |order: Order| -> Result<usize, radgrad_solver::Error> {
///     let options = Options { error: 1.0, degree: Some(0), first_elements: 1, order, ..Options::default() };
///     Ok(solve(&scene, &options, |_| false)?.progress().gathers)
/// };
/// assert!(gathers(Order::Southwell)? < gathers(Order::GaussSeidel)?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Order {
    /// One after the other, again and again.
    #[default]
    GaussSeidel,
    /// The one with the largest residual times its area.
    Southwell,
}

/// Which links have an element for their source: receivers and indices among their links.
type Gatherers = Vec<Vec<(usize, usize)>>;

impl Equation<'_> {
    /// Lets receivers gather in Southwell's order until no coefficient's residual is above `until`, relative to `scale` in each
    /// channel, or there were `most` gathers. Returns how many there were.
    pub(crate) fn southwell(&self, field: &mut Field, own: &mut [Vec<f64>], scale: &[f64], until: f64, most: usize) -> usize {
        field.pool(self.mesh);
        let mut residuals = vec![Vec::new(); own.len()];
        for &receiver in self.receivers {
            residuals[receiver] = self.change(receiver, field, &own[receiver], scale.len());
        }
        let gatherers = self.gatherers();
        let size = |receiver: usize, residual: &[f64]| {
            let len = self.mesh.basis(receiver).len();
            let relative = |(of, scale): (&[f64], &f64)| of.iter().fold(0.0, |most: f64, r| largest(most, r.abs())) / scale;
            residual.chunks_exact(len).zip(scale).map(relative).fold(0.0, largest)
        };
        let mut sizes: Vec<f64> = self.receivers.iter().map(|&receiver| size(receiver, &residuals[receiver])).collect();
        let mut places = vec![usize::MAX; own.len()];
        self.receivers.iter().enumerate().for_each(|(place, &receiver)| places[receiver] = place);
        let area = |place: usize| self.mesh.elements()[self.receivers[place]].area();
        for count in 0..most {
            let open = (0..sizes.len()).filter(|&place| sizes[place] > until);
            let Some(place) = open.max_by(|&a, &b| (sizes[a] * area(a)).total_cmp(&(sizes[b] * area(b))).then(b.cmp(&a))) else {
                return count;
            };
            let receiver = self.receivers[place];
            let len = self.mesh.basis(receiver).len();
            let change = std::mem::take(&mut residuals[receiver]);
            residuals[receiver] = vec![0.0; change.len()];
            sizes[place] = 0.0;
            own[receiver].iter_mut().zip(&change).for_each(|(own, change)| *own += change);
            for (channel, change) in change.chunks_exact(len).enumerate() {
                field.add(self.mesh, receiver, channel, change);
            }
            for (element, change) in self.changes(receiver, &change) {
                for &link in &gatherers[element] {
                    let residual = &mut residuals[link.0];
                    self.shoot(link, &change, residual);
                    sizes[places[link.0]] = size(link.0, residual);
                }
            }
        }
        most
    }

    fn gatherers(&self) -> Gatherers {
        let mut gatherers = vec![Vec::new(); self.mesh.elements().len()];
        for &receiver in self.receivers {
            for (index, link) in self.links[receiver].iter().enumerate() {
                gatherers[link.source].push((receiver, index));
            }
        }
        gatherers
    }

    /// The change of an element, of those above it and of those below, by a change of its own coefficients.
    fn changes(&self, element: usize, change: &[f64]) -> Vec<(usize, Vec<f64>)> {
        let (elements, len) = (self.mesh.elements(), self.mesh.basis(element).len());
        let mut changes = vec![(element, change.to_vec())];
        let mut below = 0;
        while let Some((at, change)) = changes.get(below).cloned() {
            for child in elements[at].children().into_iter().flat_map(|first| first..first + 4) {
                let restricted = |c: &[f64]| self.mesh.basis(child).restrict(self.mesh.child(child), c);
                changes.push((child, change.chunks_exact(len).flat_map(restricted).collect()));
            }
            below += 1;
        }
        let (mut at, mut change) = (element, change.to_vec());
        while let Some(parent) = elements[at].parent() {
            let pulled = |c: &[f64]| {
                let mut sum = vec![0.0; len];
                self.mesh.basis(parent).pull(self.mesh.child(at), c, &mut sum);
                sum
            };
            change = change.chunks_exact(len).flat_map(pulled).collect();
            changes.push((parent, change.clone()));
            at = parent;
        }
        changes
    }

    /// Adds the light of a source's change along a link to the residual of the receiver that gathers by it.
    fn shoot(&self, (gatherer, index): (usize, usize), change: &[f64], residual: &mut [f64]) {
        let link = &self.links[gatherer][index];
        let (own, len) = (self.mesh.basis(gatherer).len(), self.mesh.basis(link.source).len());
        for (channel, (change, residual)) in change.chunks_exact(len).zip(residual.chunks_exact_mut(own)).enumerate() {
            let mut more = vec![0.0; own];
            multiply(&link.matrix, change, &mut more);
            self.surfaces.reflect(self.mesh, gatherer, channel, &mut more);
            residual.iter_mut().zip(more).for_each(|(r, more)| *r += more);
        }
    }
}
