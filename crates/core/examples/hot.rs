//! hot
use radgrad_core::batch::*;
use radgrad_core::*;
fn main() {
    let corners = [[0.0, 0.0, 1.0], [0.5, 0.75, 1.0], [1.0, 0.0, 1.0]].map(DVec3::from);
    let lamp = Emitter::new(Polygon::new(corners.to_vec()).unwrap(), Emission::Constant(2.0)).unwrap();
    const M: usize = 4096;
    let which = std::env::args().nth(1).unwrap();
    let x: Vec<f64> = (0..M).map(|i| (i % 64) as f64 / 64.0).collect();
    let y: Vec<f64> = (0..M).map(|i| (i / 64) as f64 / 64.0).collect();
    let z = vec![-0.5; M];
    let n = [vec![0.25; M], vec![-0.125; M], vec![1.0; M]];
    let s = |v: &Vec<f64>| v.iter().map(|c| *c as f32).collect::<Vec<f32>>();
    let many = Receivers::new([&x, &y, &z], [&n[0], &n[1], &n[2]], &[0.75]).unwrap();
    let (xs, ys, zs) = (s(&x), s(&y), s(&z));
    let ns = [s(&n[0]), s(&n[1]), s(&n[2])];
    let few = Receivers::new([&xs, &ys, &zs], [&ns[0], &ns[1], &ns[2]], &[0.75]).unwrap();
    let e = Engine::new();
    let (mut a, mut b) = (Answers::new(), Answers::new());
    let mut best = f64::MAX;
    for _ in 0..3000 {
        let t = std::time::Instant::now();
        match which.as_str() {
            "f64" => e.radiosity_and_gradient(&many, &lamp, &mut a).unwrap(),
            "f64b" => e.evaluate_to(&many, &lamp, 1e-10, &mut a).unwrap(),
            _ => e.radiosity_and_gradient(&few, &lamp, &mut b).unwrap(),
        }
        best = best.min(t.elapsed().as_secs_f64());
    }
    println!("{:.2}", best * 1e9 / M as f64);
}
