//! How finely elements are linked: by the light that a link neglects, or by form factors and areas.
//!
//! With thresholds two elements are linked if the form factor from neither to the other reaches the one threshold; or else the
//! larger of them, seen from the other, is divided, unless its area is below the other threshold (P. Hanrahan, D. Salzman and L.
//! Aupperle 1991, `Refine`). Their estimate of a form factor is that to a disc of the element's area, from centre to centre,
//! `A cos1 cos2 / (pi d^2 + A)`, hidden or not. Where nothing is bright such links are finer than they need be, and where much is
//! they are too rough: the light they neglect is bounded and in the ledger all the same.

use crate::error::Error;
use crate::mesh::Mesh;
use radgrad_scene::largest;

/// How finely elements are linked.
///
/// ```
/// # use radgrad_scene::{Degenerate, Scene};
/// use radgrad_solver::{Linking, Options, solve};
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/cornell.obj");
/// let scene = Scene::read(file, Degenerate::Refuse)?;
/// // In millimetres: no element below 200 x 200 is divided.
/// let linking = Linking::Thresholds { form_factor: 0.2, area: 200.0 * 200.0 };
/// let options = Options { degree: Some(0), first_elements: 1, linking, ..Options::default() };
/// let solution = solve(&scene, &options, |_| true)?;
/// assert_eq!(solution.progress().round, 1);
/// assert!(solution.progress().estimate > 0.0, "of what links that rough neglect, too");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Linking {
    /// As finely as the error asked for needs, round after round.
    #[default]
    Error,
    /// By thresholds, in one round: the mesh and the links follow from them alone, and so does the bound.
    Thresholds {
        /// Form factors from which on an element is divided, above 0 and at most 1.
        form_factor: f64,
        /// Area below which none is divided, in the square of the unit of length.
        area: f64,
    },
}

impl Linking {
    /// Refuses thresholds that are none.
    pub(crate) fn check(self) -> Result<(), Error> {
        let Self::Thresholds { form_factor, area } = self else { return Ok(()) };
        if !(form_factor > 0.0 && form_factor <= 1.0) {
            return Err(Error::FormFactorThreshold { value: form_factor });
        }
        if !(area > 0.0 && area < f64::INFINITY) {
            return Err(Error::AreaThreshold { value: area });
        }
        Ok(())
    }

    /// Divides a mesh by thresholds, if there are any, until it has `most` elements.
    pub(crate) fn divide(self, mesh: &mut Mesh, most: usize) -> Result<(), Error> {
        let roots = mesh.roots().to_vec();
        let pairs = roots.iter().enumerate().flat_map(|(i, &p)| roots[..i].iter().map(move |&q| [q, p]));
        let mut open: Vec<[usize; 2]> = pairs.filter(|_| self != Self::Error).collect();
        while let Some([p, q]) = open.pop() {
            let parted = match [form_factor(mesh, p, q), form_factor(mesh, q, p)] {
                _ if !mesh.facing(p, q) => continue,
                [to_q, to_p] if to_q > to_p => [q, p],
                _ => [p, q],
            };
            let [parted, other] = parted;
            if !self.parts(mesh, other, parted) {
                continue;
            }
            if mesh.elements()[parted].is_leaf() && mesh.elements().len() >= most {
                continue;
            }
            mesh.divide(parted)?;
            open.extend(mesh.elements()[parted].children().into_iter().flat_map(|first| first..first + 4).map(|c| [c, other]));
        }
        Ok(())
    }

    /// Whether thresholds, if there are any, want an element linked by its parts.
    pub(crate) fn parts(self, mesh: &Mesh, receiver: usize, source: usize) -> bool {
        let Self::Thresholds { form_factor: most, area } = self else { return false };
        form_factor(mesh, receiver, source) >= most && mesh.elements()[source].area() >= area
    }
}

/// Estimate of the form factor to a source.
fn form_factor(mesh: &Mesh, receiver: usize, source: usize) -> f64 {
    let [to, from] = [receiver, source].map(|e| &mesh.elements()[e]);
    let r = from.centre() - to.centre();
    let (square, area) = (r.length_squared(), from.area());
    let cosines = largest(to.polygon().normal().dot(r) * -from.polygon().normal().dot(r), 0.0) / square;
    area * cosines / (std::f64::consts::PI * square + area)
}
