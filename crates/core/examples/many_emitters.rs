//! A thousand receivers in a room of a hundred thousand linear emitters: the tree against one by one, and the gradient.
//!
//! `cargo run --release -p radgrad-core --example many_emitters`

use std::time::Instant;

use radgrad_core::batch::{Answers, EmitterTree, Emitters, Engine, Receivers};
use radgrad_core::{DVec3, Emission, Emitter, Error, Polygon, Receiver};

/// The walls of a room of 5 by 4 by 3, each of `side` by `side` cells of two triangles, steadily brighter towards the top.
fn room(side: u32) -> Result<Vec<Emitter>, Error> {
    let (x, y, z) = (DVec3::X * 5.0, DVec3::Y * 4.0, DVec3::Z * 3.0);
    let walls = [(DVec3::ZERO, x, y), (z, y, x), (DVec3::ZERO, y, z), (x, z, y), (DVec3::ZERO, z, x), (y, x, z)];
    let mut emitters = Vec::new();
    for (corner, a, b) in walls {
        let vertex = |i: u32, j: u32| corner + (a * f64::from(i) + b * f64::from(j)) / f64::from(side);
        for (i, j) in (0..side * side).map(|cell| (cell % side, cell / side)) {
            for (second, third) in [((i + 1, j), (i + 1, j + 1)), ((i + 1, j + 1), (i, j + 1))] {
                let triangle = Polygon::new(vec![vertex(i, j), vertex(second.0, second.1), vertex(third.0, third.1)])?;
                let emission = Emission::gradient(0.1 + vertex(i, j).z, DVec3::Z);
                emitters.push(Emitter::new(triangle, emission)?);
            }
        }
    }
    Ok(emitters)
}

fn main() -> Result<(), Error> {
    let emitters = room(92)?;
    // A lattice of receivers on a table, facing up.
    let place = |step: f64| (0..1000).map(|i| 0.5 + step * f64::from(i % 40)).collect::<Vec<f64>>();
    let (x, y, z) = (place(0.1), place(0.07), vec![0.8; 1000]);
    let (zero, one) = (vec![0.0; 1000], vec![1.0; 1000]);
    let receivers = Receivers::new([&x, &y, &z], [&zero, &zero, &one], &[1.0])?;

    let start = Instant::now();
    let tree = EmitterTree::new(&emitters);
    println!("{} emitters in a tree after {:.2?}", emitters.len(), start.elapsed());

    let (start, mut answers) = (Instant::now(), Answers::new());
    // About a millionth of the total.
    let tally = Engine::new().total(&receivers, &tree, 2e-6, &mut answers)?;
    println!("{} receivers after {:.2?}: {tally:#?}", receivers.count(), start.elapsed());
    let pairs = (emitters.len() * receivers.count()) as f64;
    println!("{:.0} times fewer evaluations than one by one", pairs / (tally.alone + tally.far_fields) as f64);

    let lamps = Emitters::new(&emitters);
    let receiver = Receiver::new(DVec3::new(x[7], y[7], z[7]), DVec3::Z, 1.0)?;
    let (start, mut each) = (Instant::now(), Answers::new());
    Engine::new().each_to(&receiver, &lamps, 1e-6, &mut each)?;
    println!("receiver 7 one by one after {:.2?}: {:?}", start.elapsed(), each.counts);
    let difference = answers.radiosity[7] - each.radiosity.iter().sum::<f64>();
    println!(
        "receiver 7: {}, one by one differs by {difference:.1e}, the bound is {:.1e}",
        answers.radiosity[7], answers.radiosity_error[7]
    );
    // Bounds on the emitters' gradients add up to one on their sum's.
    let gradient = each.gradient.each_ref().map(|components| components.iter().sum::<f64>());
    println!("gradient {gradient:.6?} within {:.1e}", each.gradient_error.iter().sum::<f64>());
    Ok(())
}
