//! Solving the linear system of a round: receivers gather in some order until nothing changes by much.

use crate::error::Error;
use crate::field::acceleration::Acceleration;
use crate::field::gathering::Equation;
use crate::field::order::Order;
use crate::solve::may_be_even;
use crate::solve::solution::{Solution, means};
use radgrad_scene::largest;

/// Sweeps, and the change by the last one over the mean radiosity beyond which light has not settled after so many.
const MOST_SWEEPS: usize = 1000;
const SETTLED: f64 = 1e-6;

impl Solution {
    /// Begins with reflected light as if all were reflected evenly everywhere (M. F. Cohen et al. 1988, the ambient term): before a
    /// receiver knows what it sees of clusters, it has to know how bright these may be.
    pub(super) fn fill_evenly(&mut self) {
        for channel in 0..self.channels.len() {
            let (mut area, mut sent, mut reflected) = (0.0, 0.0, 0.0);
            for &receiver in &self.receivers {
                let element = &self.mesh.elements()[receiver];
                let rho = self.surfaces.reflectance[element.face()][channel];
                let emitted = self.emitted_on(receiver, channel)[0] + self.lamp_on(element.face(), channel);
                let direct = self.field.of(receiver, channel, self.mesh.basis(receiver).len())[0];
                area += element.area();
                sent += element.area() * (emitted + direct);
                reflected += element.area() * rho;
            }
            let (sent, rho) = (sent / area, reflected / area);
            let even = if rho < 1.0 { sent / (1.0 - rho) } else { sent };
            for &receiver in &self.receivers {
                let mut change = self.emitted_on(receiver, channel);
                change[0] += self.surfaces.reflectance[self.mesh.elements()[receiver].face()][channel] * even;
                let len = change.len();
                let own = &mut self.own[receiver][channel * len..(channel + 1) * len];
                own.iter_mut().zip(&change).for_each(|(own, change)| *own += change);
                self.field.add(&self.mesh, receiver, channel, &change);
            }
        }
        self.field.pull(&self.mesh);
        (self.mean, self.reflected) = means(&self.field, &self.mesh, &self.emitted);
    }

    /// Lets receivers gather until the linear system is solved to changes or residuals of that, relative to the mean radiosity.
    pub(super) fn sweep(&mut self, order: Order, until: f64) -> Result<(), Error> {
        let mut source = vec![Vec::new(); self.mesh.elements().len()];
        for &receiver in &self.receivers {
            source[receiver] = (0..self.channels.len()).flat_map(|channel| self.emitted_on(receiver, channel)).collect();
        }
        let (mesh, surfaces, receivers, links) = (&self.mesh, &self.surfaces, &self.receivers[..], &self.links[..]);
        let equation = Equation { mesh, surfaces, receivers, links, far: &self.far, source: &source };
        let (mut acceleration, mut left) = (Acceleration::default(), 0.0);
        for _ in 0..MOST_SWEEPS {
            // Where light may be even, as in a furnace, reflected light is known no better than all light: changes are held to
            // that.
            let of = if may_be_even(mesh, &self.lamps) { self.mean.clone() } else { self.reference() };
            let scale: Vec<f64> = of.iter().map(|&mean| if mean > 0.0 { mean } else { 1.0 }).collect();
            let solved = match order {
                Order::GaussSeidel => {
                    self.progress.gathers += receivers.len();
                    left = equation.sweep(&mut self.field, &mut self.own, &scale);
                    let solved = left <= until || left.is_nan();
                    if !solved {
                        acceleration.after_sweep(&equation, &mut self.field, &mut self.own, scale.len());
                    }
                    solved
                }
                Order::Southwell => {
                    let most = MOST_SWEEPS * receivers.len();
                    let gathers = equation.southwell(&mut self.field, &mut self.own, &scale, until, most);
                    self.progress.gathers += gathers;
                    gathers == 0
                }
            };
            (self.mean, self.reflected) = means(&self.field, mesh, &self.emitted);
            if solved {
                left = 0.0;
                break;
            }
        }
        self.field.pull(&self.mesh);
        if left > largest(until, SETTLED) { Err(Error::Unsettled { sweeps: MOST_SWEEPS, change: left }) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use crate::field::order::Order;
    use crate::solve::options::Options;
    use crate::solve::solution::Solution;
    use crate::solve::solve;
    use radgrad_core::{DVec3, Polygon};
    use radgrad_scene::{Degenerate, Scene, largest};

    /// A room of grey walls, of which a patch of the floor glows.
    fn room() -> Scene {
        let mut scene = Scene::new(["grey"]).unwrap();
        let (wall, surface) = (scene.add_material("wall", [0.3], [0.0]).unwrap(), scene.add_surface("all"));
        let bright = scene.add_material("bright", [0.3], [100.0]).unwrap();
        let mut add = |material: usize, corners: [[f64; 3]; 4]| {
            let polygon = Polygon::new(corners.map(DVec3::from).to_vec()).unwrap();
            scene.add_face(surface, material, polygon, None).unwrap();
        };
        add(bright, [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 4.0, 0.0], [0.0, 4.0, 0.0]]);
        add(wall, [[4.0, 0.0, 0.0], [9.0, 0.0, 0.0], [9.0, 4.0, 0.0], [4.0, 4.0, 0.0]]);
        add(wall, [[0.0, 0.0, 2.0], [0.0, 4.0, 2.0], [9.0, 4.0, 2.0], [9.0, 0.0, 2.0]]);
        for [[x0, y0], [x1, y1]] in
            [[[9.0, 0.0], [0.0, 0.0]], [[9.0, 4.0], [9.0, 0.0]], [[0.0, 4.0], [9.0, 4.0]], [[0.0, 0.0], [0.0, 4.0]]]
        {
            add(wall, [[x0, y0, 0.0], [x1, y1, 0.0], [x1, y1, 2.0], [x0, y0, 2.0]]);
        }
        scene
    }

    /// Forgets what receivers have got.
    fn darken(solution: &mut Solution) {
        for &receiver in &solution.receivers {
            let len = solution.mesh.basis(receiver).len();
            for channel in 0..solution.channels.len() {
                let held = &mut solution.own[receiver][channel * len..(channel + 1) * len];
                let change: Vec<f64> = held.iter().map(|held| -held).collect();
                held.fill(0.0);
                solution.field.add(&solution.mesh, receiver, channel, &change);
            }
        }
    }

    #[test]
    fn both_orders_end_at_the_same_solution_and_southwells_gathers_less_often() {
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/cornell.obj");
        for (name, scene) in [("Cornell box", Scene::read(file, Degenerate::Refuse).unwrap()), ("room", room())] {
            let options = Options { error: 0.2, degree: Some(1), first_elements: 100, ..Options::default() };
            let mut solution = solve(&scene, &options, |_| false).unwrap();
            let mut solved = Vec::new();
            for order in [Order::GaussSeidel, Order::Southwell] {
                let mut counts = Vec::new();
                for until in [1e-3, 1e-6, 1e-14] {
                    darken(&mut solution);
                    let before = solution.progress.gathers;
                    solution.sweep(order, until).unwrap();
                    counts.push(solution.progress.gathers - before);
                }
                println!("{name}, {} receivers, {order:?}: {counts:?} gathers to 1e-3, 1e-6, 1e-14", solution.receivers.len());
                solved.push((solution.own.concat(), counts));
            }
            let [(sweeps, many), (southwell, few)] = &solved[..] else { panic!("two orders") };
            let greatest = sweeps.iter().fold(0.0, |most: f64, c| largest(most, c.abs()));
            for (a, b) in sweeps.iter().zip(southwell) {
                assert!((a - b).abs() <= 1e-12 * greatest, "{name}: {a} in sweeps, {b} in Southwell's order");
            }
            assert!(few.iter().zip(many).all(|(few, many)| few < many), "{name}: {few:?} gathers against {many:?}");
        }
    }
}
