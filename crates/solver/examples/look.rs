//! scratch
use radgrad_scene::{Degenerate, Scene};
use radgrad_solver::{Options, solve};
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let scene = Scene::read(&args[1], Degenerate::Refuse).unwrap();
    let error: f64 = args[2].parse().unwrap();
    let bound: Option<f64> = args.get(4).map(|a| a.parse().unwrap());
    let options =
        Options { error, bound, time: Some(std::time::Duration::from_secs_f64(args[3].parse().unwrap())), ..Options::default() };
    let start = std::time::Instant::now();
    let solution = solve(&scene, &options, |s| {
        let p = s.progress();
        println!("{:.2} s {p:?} {:?}", start.elapsed().as_secs_f64(), s.mean_bound());
        true
    })
    .unwrap();
    println!("{:?} {:?}", solution.mean(), solution.mean_bound());
}
