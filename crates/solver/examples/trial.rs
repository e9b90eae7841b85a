//! t
use radgrad_core::*;
use radgrad_scene::*;
use radgrad_solver::*;
use std::time::Instant;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let scene = Scene::read(&a[1], Degenerate::Refuse).unwrap();
    let o = Options { error: a[2].parse().unwrap(), degree: a[3].parse().unwrap(), most_elements: a[4].parse().unwrap(), ..Options::default() };
    let t = Instant::now();
    let s = solve(&scene, &o, |p| { println!("{:.2}s {p:?}", t.elapsed().as_secs_f64()); true }).unwrap();
    println!("{:.2}s mean {:?}", t.elapsed().as_secs_f64(), s.mean());
    for w in s.mean_bound() { println!("{w:?}"); }
    for f in 0..scene.faces().len() {
        let p = &scene.faces()[f].polygon().vertices();
        let c = (p[0] + p[1] + p[2]) / 3.0;
        let t = Instant::now();
        if let Ok(g) = s.gather(c, scene.faces()[f].polygon().normal()) {
            println!("{f} {:?} {:?} {:.0} us", g.radiosity, g.ledger.iter().map(|l| l.total()).collect::<Vec<_>>(), t.elapsed().as_secs_f64() * 1e6);
        }
    }
}
