//! scratch
use radgrad_core::DVec3;
use radgrad_scene::{Degenerate, Scene};
use radgrad_solver::{Marking, Options, Shape, Solution, solve};
use std::time::Instant;
struct Place { face: usize, point: DVec3, share: f64, share2: f64, exact: Vec<f64> }
fn places(reference: &Solution, many: f64) -> Vec<Place> {
    let (elements, roots) = (reference.mesh().elements(), reference.mesh().roots());
    let total: f64 = roots.iter().map(|&root| elements[root].area()).sum();
    let mut places = Vec::new();
    for element in roots.iter().map(|&root| &elements[root]) {
        let count = (many * element.area() / total).ceil();
        let mut k = 0.5;
        while k < count {
            let [a, b] = [0.754_877_666_246_692_7 * k, 0.569_840_290_998_053_2 * k].map(f64::fract);
            let at = if element.shape() == Shape::Triangle && a + b > 1.0 { [1.0 - a, 1.0 - b] } else { [a, b] };
            let (face, point) = (element.face(), element.point(at));
            places.push(Place { face, point, share: element.area() / count / total, share2: 0.0, exact: vec![] });
            k += 1.0;
        }
    }
    places
}
fn errors(solution: &Solution, places: &[Place]) -> (f64, f64) {
    let mesh = solution.mesh();
    let n = solution.channels().len();
    let (mut s, mut m) = (0.0, 0.0);
    for p in places {
        let leaf = mesh.leaf_at(p.face, p.point).unwrap();
        let at = mesh.elements()[leaf].reference(p.point);
        for c in 0..n {
            let d = (solution.value_on(leaf, c, at) - p.exact[c]) / solution.mean()[c];
            s += p.share * d * d / n as f64;
            m += p.share * d.abs() / n as f64;
        }
    }
    (s.sqrt(), m)
}
fn main() {
    let file = std::env::args().nth(1).unwrap();
    let modes = std::env::args().nth(2).unwrap();
    let degrees: Vec<usize> = std::env::args().nth(3).unwrap().chars().map(|c| c as usize - 48).collect();
    let most: usize = std::env::args().nth(4).unwrap().parse().unwrap();
    let error: f64 = std::env::args().nth(5).unwrap().parse().unwrap();
    let scene = Scene::read(&file, Degenerate::Refuse).unwrap();
    let rough = Options { error: 0.05, degree: Some(2), first_elements: 300, most_elements: 1, ..Options::default() };
    let cache = format!("/tmp/wtS-truth2-{}", file.replace('/', "_"));
    let start = Instant::now();
    let mut reference = solve(&scene, &Options { error: 0.02, most_elements: 1, first_elements: 1, ..rough }, |_| false).unwrap();
    let mut all = places(&reference, 4000.0);
    if let Ok(text) = std::fs::read_to_string(&cache) {
        for (p, l) in all.iter_mut().zip(text.lines()) { p.exact = l.split(' ').map(|t| t.parse().unwrap()).collect(); }
    } else {
        reference = solve(&scene, &Options { error: 0.0005, degree: Some(2), marking: Marking::Gradient, most_elements: 2200, time: None, ..Options::default() }, |s| { eprintln!("ref {} {:?}", s.progress().elements, s.progress().estimate); true }).unwrap();
        let mut text = String::new();
        use rayon::prelude::*;
        all.par_iter_mut().for_each(|p| {
            let leaf = reference.mesh().leaf_at(p.face, p.point).unwrap();
            let g = reference.gather_on(leaf, p.point).unwrap();
            p.exact = g.radiosity;
            p.share2 = g.estimate[0].total() / reference.mean()[0];
        });
        eprintln!("estimated error of truth mean {:.6}", all.iter().map(|p| p.share * p.share2).sum::<f64>());
        for p in &mut all {
            text += &p.exact.iter().map(|e| format!("{e}")).collect::<Vec<_>>().join(" "); text.push('\n');
        }
        std::fs::write(&cache, text).unwrap();
    }
    eprintln!("places {} {:?}", all.len(), start.elapsed());
    for degree in degrees {
        for mode in modes.chars() {
            let rough = Options { degree: Some(degree), error: 0.05, ..rough };
            if mode == 'u' {
                for first_elements in [1, 160, 640, 2560, 10240] {
                    let start = Instant::now();
                    let s = solve(&scene, &Options { first_elements, uniform: true, ..rough }, |_| true).unwrap();
                    let (r, m) = errors(&s, &all);
                    println!("u {degree} {} rms {r:.5} mean {m:.5} {:?}", s.progress().elements, start.elapsed());
                    if s.progress().elements > most { break }
                }
            } else {
                let marking = match mode { 'g' => Marking::Gradient, 'b' => Marking::Residual, _ => Marking::Shadows };
                let start = Instant::now();
                solve(&scene, &Options { error, first_elements: 1, most_elements: most, marking, ..rough }, |s| {
                    let (r, m) = errors(s, &all);
                    println!("{mode} {degree} {} rms {r:.5} mean {m:.5} est {:.5} {:?}", s.progress().elements, s.progress().estimate, start.elapsed());
                    true
                }).unwrap();
            }
        }
    }
}
