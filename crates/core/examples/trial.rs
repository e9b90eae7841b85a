//! trial
use radgrad_core::batch::*;
use radgrad_core::*;
use std::time::Instant;
fn main() {
    let corners = [[0.0, 0.0, 1.0], [0.5, 0.75, 1.0], [1.0, 0.0, 1.0]].map(DVec3::from);
    let polygon = Polygon::new(corners.to_vec()).unwrap();
    let lamp = Emitter::new(polygon.clone(), Emission::Constant(2.0)).unwrap();
    const M: usize = 4096;
    for regime in ["easy", "clipped", "mixed", "d=3", "d=10"] {
        let mut x = [vec![], vec![], vec![]];
        let mut n = [vec![], vec![], vec![]];
        for i in 0..M {
            let (a, b) = ((i % 64) as f64 / 64.0, (i / 64) as f64 / 64.0);
            let (p, q) = match regime {
                "easy" => ([a, b, -0.5], [0.2, -0.1, 1.0]),
                "clipped" => ([a, b, 0.0], [1.0, 0.3, 0.1]),
                "mixed" => ([a, b, 0.25], [1.0 - 2.0 * a, 0.3, 1.0 - b]),
                "d=3" => ([a, b, -2.0], [0.2, -0.1, 1.0]),
                _ => ([a, b, -9.0], [0.2, -0.1, 1.0]),
            };
            for k in 0..3 {
                x[k].push(p[k] as f32 as f64);
                n[k].push(q[k] as f32 as f64);
            }
        }
        let s = |v: &[Vec<f64>; 3]| v.clone().map(|v| v.iter().map(|c| *c as f32).collect::<Vec<f32>>());
        let (xs, ns) = (s(&x), s(&n));
        let many = Receivers::new([&x[0], &x[1], &x[2]], [&n[0], &n[1], &n[2]], &[0.75]).unwrap();
        let few = Receivers::new([&xs[0], &xs[1], &xs[2]], [&ns[0], &ns[1], &ns[2]], &[0.75]).unwrap();
        let receivers: Vec<Receiver> = (0..M)
            .map(|i| Receiver::new(DVec3::new(x[0][i], x[1][i], x[2][i]), DVec3::new(n[0][i], n[1][i], n[2][i]), 0.75).unwrap())
            .collect();
        let t = |f: &mut dyn FnMut()| {
            let mut best = f64::MAX;
            for _ in 0..20 {
                let s = Instant::now();
                f();
                best = best.min(s.elapsed().as_secs_f64());
            }
            best * 1e9 / M as f64
        };
        let scalar = t(&mut || {
            for r in &receivers {
                std::hint::black_box(radiosity_and_gradient(r, &lamp).unwrap());
            }
        });
        println!(
            "{regime}: scalar v+g {scalar:.1} ns; new {:.2} ns",
            t(&mut || {
                std::hint::black_box(Receivers::new([&x[0], &x[1], &x[2]], [&n[0], &n[1], &n[2]], &[0.75]).unwrap());
            })
        );
        let truth: Vec<Answer> = receivers.iter().map(|r| evaluate(r, &lamp, &[]).unwrap()).collect();
        let mut out = Answers::new();
        let mut single = Answers::new();
        for engine in Engine::all().into_iter().take(if regime == "easy" { 4 } else { 1 }) {
            let v = t(&mut || engine.radiosity(&many, &lamp, &mut out).unwrap());
            let vg = t(&mut || engine.radiosity_and_gradient(&many, &lamp, &mut out).unwrap());
            let two = t(&mut || engine.threads().radiosity_and_gradient(&many, &lamp, &mut out).unwrap());
            let e10 = t(&mut || engine.evaluate_to(&many, &lamp, 1e-10, &mut out).unwrap());
            println!(
                "  {engine:?} f64 v {v:.2} vg {vg:.2} (x{:.1}) threads {two:.2} 1e-10 {e10:.2} {:?}",
                scalar / vg,
                out.counts
            );
            let mut worst = [0.0f64; 4];
            for (i, a) in truth.iter().enumerate() {
                if a.radiosity == 0.0 {
                    assert_eq!(out.radiosity[i], 0.0);
                    continue;
                }
                worst[0] = worst[0].max((a.radiosity - out.radiosity[i]).abs() / (a.radiosity_error + out.radiosity_error[i]));
                let g = DVec3::new(out.gradient[0][i], out.gradient[1][i], out.gradient[2][i]);
                worst[1] = worst[1].max((a.gradient - g).length() / (a.gradient_error + out.gradient_error[i]));
                worst[2] = worst[2].max(out.radiosity_error[i] / a.radiosity);
                worst[3] = worst[3].max(out.gradient_error[i] / a.gradient.length());
            }
            println!("    error/bound {:.3} {:.3}, relative bound {:e} {:e}", worst[0], worst[1], worst[2], worst[3]);
            let v = t(&mut || engine.radiosity(&few, &lamp, &mut single).unwrap());
            let cv = single.counts;
            let vg1 = t(&mut || engine.radiosity_and_gradient(&few, &lamp, &mut single).unwrap());
            let mut err: Vec<[f64; 2]> = vec![];
            for (i, a) in truth.iter().enumerate() {
                if a.radiosity == 0.0 {
                    assert_eq!(single.radiosity[i], 0.0);
                    continue;
                }
                let g = DVec3::new(single.gradient[0][i] as f64, single.gradient[1][i] as f64, single.gradient[2][i] as f64);
                err.push([
                    (a.radiosity - single.radiosity[i] as f64).abs() / a.radiosity,
                    (a.gradient - g).length() / a.gradient.length(),
                ]);
            }
            let max = err.iter().fold([0.0f64; 2], |m, e| [m[0].max(e[0]), m[1].max(e[1])]);
            let counts = single.counts;
            let e4 = t(&mut || engine.evaluate_to(&few, &lamp, 1e-3, &mut single).unwrap());
            println!(
                "    f32 v {v:.2} {cv:?}\n   vg {vg1:.2} (x{:.2} f64) {counts:?}, errors {max:?}; to 1e-3 {e4:.2} {:?}",
                vg / vg1,
                single.counts
            );
            let mut worst = [0.0f64; 4];
            for (i, a) in truth.iter().enumerate() {
                if a.radiosity == 0.0 {
                    assert_eq!(out.radiosity[i], 0.0);
                    continue;
                }
                worst[0] = worst[0].max(
                    (a.radiosity - single.radiosity[i] as f64).abs() / (a.radiosity_error + single.radiosity_error[i] as f64),
                );
                let g = DVec3::new(single.gradient[0][i] as f64, single.gradient[1][i] as f64, single.gradient[2][i] as f64);
                worst[1] = worst[1].max((a.gradient - g).length() / (a.gradient_error + single.gradient_error[i] as f64));
                let q = (a.radiosity - single.radiosity[i] as f64).abs() / (a.radiosity_error + single.radiosity_error[i] as f64);
                if q > 0.9 {
                    println!("bad {i} {a:?} {} {}", single.radiosity[i], single.radiosity_error[i]);
                }
                worst[2] = worst[2].max((a.radiosity - single.radiosity[i] as f64).abs() / a.radiosity);
                worst[3] = worst[3].max((a.gradient - g).length() / a.gradient.length());
            }
            println!("    error/bound {:.3} {:.3}, error {:e} {:e}", worst[0], worst[1], worst[2], worst[3]);
        }
    }
}
