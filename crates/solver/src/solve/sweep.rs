//! Solving the linear system of a round: receivers gather one after the other until nothing changes by much.

use crate::error::Error;
use crate::field::Field;
use crate::solve::may_be_even;
use crate::solve::solution::{Radiosity, Solution, means, reference};
use radgrad_scene::largest;

/// Sweeps, and the change by the last one over the mean radiosity beyond which light has not settled after so many.
const MOST_SWEEPS: usize = 1000;
const SETTLED: f64 = 1e-6;

impl Solution {
    /// Begins with reflected light as if all were reflected evenly everywhere (M. F. Cohen et al. 1988, the ambient term): before
    /// a receiver knows the clusters that it sees, it has to know how bright these may be.
    pub(super) fn fill_evenly(&mut self) {
        for channel in 0..self.channels().len() {
            let (mut area, mut sent, mut reflected) = (0.0, 0.0, 0.0);
            for &receiver in &self.system.receivers {
                let element = self.element(receiver);
                let rho = self.system.surfaces.reflectance[element.face()][channel];
                let emitted = self.emitted_on(receiver, channel)[0] + self.lamp_on(element.face(), channel);
                let direct = self.radiosity.field.coefficients(receiver, channel)[0];
                area += element.area();
                sent += element.area() * (emitted + direct);
                reflected += element.area() * rho;
            }
            let (sent, rho) = (sent / area, reflected / area);
            let even = if rho < 1.0 { sent / (1.0 - rho) } else { sent };
            for &receiver in &self.system.receivers {
                let mut change = self.emitted_on(receiver, channel);
                change[0] += self.system.reflectance(receiver, channel) * even;
                let len = change.len();
                let own = &mut self.radiosity.own[receiver][channel * len..(channel + 1) * len];
                own.iter_mut().zip(&change).for_each(|(own, change)| *own += change);
                self.radiosity.field.add(&self.system.mesh, receiver, channel, &change);
            }
        }
        self.radiosity.field.pull(&self.system.mesh);
        (self.radiosity.mean, self.radiosity.reflected) =
            means(&self.radiosity.field, &self.system.mesh, &self.radiosity.emitted);
    }

    /// Lets receivers gather until the linear system is solved to changes of that, relative to the mean radiosity.
    pub(super) fn sweep(&mut self, until: f64) -> Result<(), Error> {
        let mut source = vec![Vec::new(); self.system.mesh.elements().len()];
        for &receiver in &self.system.receivers {
            source[receiver] = (0..self.channels().len()).flat_map(|channel| self.emitted_on(receiver, channel)).collect();
        }
        let (system, radiosity) = (&self.system, &mut self.radiosity);
        let Radiosity { field, own, mean, reflected, emitted, .. } = radiosity;
        // Where light may be even, as in a furnace, reflected light is known no better than all light: changes are held to that.
        let is_even = may_be_even(&system.mesh, &system.lamps);
        let scale_of = |mean: &[f64], reflected: &[f64]| if is_even { mean.to_vec() } else { reference(mean, reflected) };
        let scaled = |field: &Field, scale: &mut [f64]| {
            let (mean, reflected) = means(field, &system.mesh, emitted);
            scale.copy_from_slice(&scale_of(&mean, &reflected));
        };
        let (before, equation) = (scale_of(mean, reflected), system.equation(&source));
        let (sweeps, change) = equation.solve((field, own), (until, MOST_SWEEPS), before, scaled);
        (*mean, *reflected) = means(field, &system.mesh, emitted);
        self.progress.gathers += sweeps * system.receivers.len();
        field.pull(&system.mesh);
        if change > largest(until, SETTLED) { Err(Error::Unsettled { sweeps, change }) } else { Ok(()) }
    }
}
