//! The radiosity of a solution on each surface of its scene.

use radgrad_scene::{Scene, Surface, largest, smallest};

use crate::solve::solution::Solution;

/// The radiosity of a surface, in each channel; of one that exchanges no light only the area.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceRadiosity {
    /// Its area, in the square of the scene's unit of length.
    pub area: f64,
    /// The mean radiosity.
    pub mean: Vec<f64>,
    /// The part of it that is reflected.
    pub reflected: Vec<f64>,
    /// The least radiosity at nodes, corners and centres of its elements.
    pub least: Vec<f64>,
    /// The largest there.
    pub largest: Vec<f64>,
}

impl Solution {
    /// The radiosity of each surface of the scene that was solved. No value is below the emission of its face, where it emits
    /// evenly, and 0 else.
    ///
    /// ```
    /// use radgrad_solver::{Options, solve};
    /// # use radgrad_scene::{Degenerate, Scene};
    /// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/two_blocks.obj");
    /// # let scene = Scene::read(file, Degenerate::Refuse)?;
    /// let solution = solve(&scene, &Options { error: 0.5, degree: Some(1), first_elements: 1, ..Options::default() }, |_| true)?;
    /// for (surface, found) in scene.surfaces().iter().zip(solution.by_surface(&scene)) {
    ///     println!("{}: {:?}, from {:?} to {:?}", surface.name(), found.mean, found.least, found.largest);
    /// }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn by_surface(&self, scene: &Scene) -> Vec<SurfaceRadiosity> {
        let channels = self.channels().len();
        let dark = |surface: &Surface| {
            let area = surface.faces().iter().map(|&face| scene.faces()[face].polygon().area()).sum();
            SurfaceRadiosity { area, mean: Vec::new(), reflected: Vec::new(), least: Vec::new(), largest: Vec::new() }
        };
        let mut radiosities: Vec<SurfaceRadiosity> = scene.surfaces().iter().map(dark).collect();
        let mut areas = vec![0.0; radiosities.len()];
        for leaf in self.system.mesh.leaves() {
            let (element, basis) = (self.element(leaf), self.basis(leaf));
            let surface = scene.faces()[element.face()].surface();
            areas[surface] += element.area();
            let radiosity = &mut radiosities[surface];
            radiosity.mean.resize(channels, 0.0);
            radiosity.reflected.resize(channels, 0.0);
            radiosity.least.resize(channels, f64::INFINITY);
            radiosity.largest.resize(channels, f64::NEG_INFINITY);
            let shape = element.shape();
            for channel in 0..channels {
                // The first function of a basis is 1, and the others have no mean.
                let whole = self.coefficients_on(leaf, channel)[0];
                let emitted = self.emitted_on(leaf, channel)[0] + self.lamp_on(element.face(), channel);
                radiosity.mean[channel] += element.area() * whole;
                radiosity.reflected[channel] += element.area() * (whole - emitted);
                let nodes = basis.nodes().iter().map(|node| node.at);
                for at in nodes.chain(shape.corners().iter().copied()).chain([shape.centre()]) {
                    let value = self.value_on(leaf, channel, at);
                    radiosity.least[channel] = smallest(radiosity.least[channel], value);
                    radiosity.largest[channel] = largest(radiosity.largest[channel], value);
                }
            }
        }
        // The correction of the mean is part of it, and all reflected light has a share in that.
        let share = |channel: usize| {
            let total: f64 = radiosities.iter().filter_map(|radiosity| radiosity.reflected.get(channel)).sum();
            if total > 0.0 { self.radiosity.reflected[channel] * self.system.mesh.area() / total } else { 1.0 }
        };
        let shares: Vec<f64> = (0..channels).map(share).collect();
        for (radiosity, area) in radiosities.iter_mut().zip(areas) {
            for ((mean, reflected), share) in radiosity.mean.iter_mut().zip(&mut radiosity.reflected).zip(&shares) {
                let emitted = *mean - *reflected;
                *reflected *= share / area;
                *mean = emitted / area + *reflected;
            }
        }
        radiosities
    }
}
