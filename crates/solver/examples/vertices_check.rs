use radgrad_core::{DVec3, Polygon};
use radgrad_scene::{Degenerate, Scene};
use radgrad_solver::*;
struct Instant(f64);
struct Lasted(f64);
impl Lasted {
    fn as_secs_f64(&self) -> f64 {
        self.0
    }
}
impl Instant {
    fn cpu() -> f64 {
        let s = std::fs::read_to_string("/proc/self/stat").unwrap();
        let f: Vec<&str> = s.rsplit(')').next().unwrap().split_whitespace().collect();
        (f[11].parse::<f64>().unwrap() + f[12].parse::<f64>().unwrap()) / 100.0
    }
    fn now() -> Self {
        Self(Self::cpu())
    }
    fn elapsed(&self) -> Lasted {
        Lasted(Self::cpu() - self.0)
    }
}

fn rebuilt(read: &Scene, mode: &str, by: &dyn Fn(&str, usize, usize, DVec3) -> DVec3) -> Scene {
    let mut scene = Scene::new(read.channels().to_vec()).unwrap();
    let parts: Vec<&str> = mode.split(':').collect();
    let lift = parts.get(1).map_or(0.0, |s| s.parse().unwrap());
    let surfaces: Vec<usize> = read.surfaces().iter().map(|s| scene.add_surface(s.name())).collect();
    for (f, face) in read.faces().iter().enumerate() {
        let name = read.surfaces()[face.surface()].name();
        let of = &read.materials()[face.material()];
        let dark = parts[0] != "grey" && !parts[0].split('+').any(|n| n == name);
        let material = scene
            .add_material(
                of.name(),
                of.reflectance().iter().map(|r| if dark { 0.0 } else { *r }).collect::<Vec<_>>(),
                of.radiance().to_vec(),
            )
            .unwrap();
        let is_block = name == "short" || name == "tall";
        let moved = face.polygon().vertices().iter().enumerate().map(|(v, at)| {
            let at = if is_block && at.y < 1e-9 { *at + DVec3::Y * lift } else { *at };
            at + by(name, f, v, at)
        });
        scene.add_face(surfaces[face.surface()], material, Polygon::new(moved.collect()).unwrap(), None).unwrap();
    }
    scene
}

fn cornell() -> Scene {
    let read = Scene::read("data/scenes/cornell.obj", Degenerate::Refuse).unwrap();
    let mut scene = Scene::new(read.channels().to_vec()).unwrap();
    let materials: Vec<usize> = read
        .materials()
        .iter()
        .map(|of| scene.add_material(of.name(), of.reflectance().to_vec(), of.radiance().to_vec()).unwrap())
        .collect();
    let surfaces: Vec<usize> = read.surfaces().iter().map(|s| scene.add_surface(s.name())).collect();
    for face in read.faces() {
        let name = read.surfaces()[face.surface()].name();
        let outline: Vec<DVec3> = face.polygon().vertices().iter().map(|v| *v / 1000.0).collect();
        if name == "light" {
            let ceiling = read.faces().iter().find(|f| read.surfaces()[f.surface()].name() == "ceiling").unwrap();
            scene
                .add_face(
                    surfaces[ceiling.surface()],
                    materials[ceiling.material()],
                    Polygon::new(outline.clone()).unwrap(),
                    None,
                )
                .unwrap();
            let hung = outline.iter().map(|v| *v - DVec3::Y * 0.06).collect();
            scene.add_face(surfaces[face.surface()], materials[face.material()], Polygon::new(hung).unwrap(), None).unwrap();
        } else {
            scene.add_face(surfaces[face.surface()], materials[face.material()], Polygon::new(outline).unwrap(), None).unwrap();
        }
    }
    scene
}

fn office() -> Scene {
    let mut scene = Scene::read("data/scenes/office.obj", Degenerate::Refuse).unwrap();
    let lamp = scene.add_material("lamp", vec![0.3; scene.channels().len()], vec![20.0; scene.channels().len()]).unwrap();
    let add = |scene: &mut Scene, name: &str, low: [f64; 2], high: [f64; 2], z: f64| {
        let surface = scene.add_surface(name);
        let corners =
            [[low[0], low[1]], [low[0], high[1]], [high[0], high[1]], [high[0], low[1]]].map(|[x, y]| DVec3::new(x, y, z));
        scene.add_face(surface, lamp, Polygon::new(corners.to_vec()).unwrap(), None).unwrap();
    };
    add(&mut scene, "lamp1", [1.2, 1.0], [2.0, 1.3], 2.6);
    add(&mut scene, "lamp2", [3.0, 2.4], [3.3, 3.4], 2.7);
    scene
}

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let scene = if args[1] == "cornell" {
        cornell()
    } else if args[1] == "office" {
        office()
    } else {
        Scene::read(&args[1], Degenerate::Refuse).unwrap()
    };
    let error: f64 = args[2].parse().unwrap();
    let fine: f64 = args[3].parse().unwrap();
    let step: f64 = args[4].parse().unwrap();
    let black = &args[5][..];
    let scene = rebuilt(&scene, black, &|_, _, _, _| DVec3::ZERO);
    for s in scene.surfaces() {
        print!("{} ", s.name());
    }
    println!();
    let start = Instant::now();
    let solution = solve(&scene, &Options { error, ..Options::default() }, |_| true).unwrap();
    let solved = start.elapsed().as_secs_f64();
    let (low, high) = scene.bounds().unwrap();
    let up = if args[1] == "cornell" { DVec3::Y } else { DVec3::Z };
    let (ax, ay) = up.any_orthonormal_pair();
    let at = |u: f64, v: f64, h: f64| {
        let d = high - low;
        low + d * (ax.abs() * u + ay.abs() * v + up * h)
    };
    let places = [
        (at(0.1, 0.1, 0.0), up),
        (at(0.8, 0.2, 0.0), up),
        if args[1] == "office" { (DVec3::new(1.5, 1.5, 0.75), up) } else { (at(0.5, 0.08, 0.0), up) },
        (at(0.6, 0.6, 0.75), up),
        (at(0.2, 0.8, 0.3), up + ax),
    ];
    let channels = scene.channels().len();
    let mut sums = Vec::new();
    let area: f64 = (0..scene.surfaces().len()).map(|s| scene.area_of(s)).sum();
    sums.push(WeightedSum {
        surfaces: (0..scene.surfaces().len()).map(|s| vec![scene.area_of(s) / area; channels]).collect(),
        points: vec![],
    });
    sums.push(WeightedSum {
        surfaces: scene
            .surfaces()
            .iter()
            .map(|s| {
                vec![if s.name().contains("floor") || s.name() == "room_b" || s.name() == "desk_t" { 1.0 } else { 0.0 }; channels]
            })
            .collect(),
        points: vec![],
    });
    for (position, normal) in places {
        sums.push(WeightedSum {
            surfaces: vec![],
            points: vec![WeightedPoint { position, normal, weights: vec![1.0; channels] }],
        });
    }
    let derivatives: Vec<(Derivative, f64)> = sums
        .iter()
        .map(|sum| {
            let s = Instant::now();
            let d = solution.derivative_with_vertices(&scene, sum).unwrap();
            (d, s.elapsed().as_secs_f64())
        })
        .collect();
    let plain = {
        let s = Instant::now();
        solution.derivative(&scene, &sums[0]).unwrap();
        s.elapsed().as_secs_f64()
    };
    println!(
        "solved in {solved:.2} s, {:?}, derivative {plain:.2} s, with vertices {:?}",
        solution.progress(),
        derivatives.iter().map(|d| (d.1 * 100.0).round() / 100.0).collect::<Vec<_>>()
    );
    // motions
    let centre = |names: &[&str]| {
        let mut n = 0.0;
        let mut c = DVec3::ZERO;
        for f in scene.faces() {
            if names.iter().any(|n| scene.surfaces()[f.surface()].name().starts_with(n)) {
                for v in f.polygon().vertices() {
                    c += *v;
                    n += 1.0;
                }
            }
        }
        c / n
    };
    type Motion = (String, Box<dyn Fn(&str, usize, usize, DVec3) -> DVec3>);
    let mut motions: Vec<Motion> = Vec::new();
    let groups: Vec<String> = args[6].split(',').map(str::to_owned).collect();
    let size = (high - low).max_element();
    for group in &groups {
        let names: Vec<&str> = group.split('+').collect();
        let c = centre(&names);
        for kind in args[7].split(',') {
            let names: Vec<String> = names.iter().map(|s| s.to_string()).collect();
            let is = move |n: &str| names.iter().any(|m| m == n);
            let m: Box<dyn Fn(&str, usize, usize, DVec3) -> DVec3> = match kind {
                "tx" => Box::new(move |n, _, _, _| if is(n) { ax.abs() * size } else { DVec3::ZERO }),
                "ty" => Box::new(move |n, _, _, _| if is(n) { ay.abs() * size } else { DVec3::ZERO }),
                "tz" => Box::new(move |n, _, _, _| if is(n) { up * size } else { DVec3::ZERO }),
                "rz" => Box::new(move |n, _, _, p| if is(n) { up.cross(p - c) } else { DVec3::ZERO }),
                "rx" => Box::new(move |n, _, _, p| if is(n) { ax.cross(p - c) } else { DVec3::ZERO }),
                "ry" => Box::new(move |n, _, _, p| if is(n) { ay.cross(p - c) } else { DVec3::ZERO }),
                "s" => Box::new(move |n, _, _, p| if is(n) { p - c } else { DVec3::ZERO }),
                "sx" => Box::new(move |n, _, _, p| if is(n) { ax * ax.dot(p - c) } else { DVec3::ZERO }),
                "sy" => Box::new(move |n, _, _, p| if is(n) { ay * ay.dot(p - c) } else { DVec3::ZERO }),
                _ => panic!(),
            };
            motions.push((format!("{group}:{kind}"), m));
        }
    }
    for (name, motion) in &motions {
        let solved = |h: f64| {
            let moved = rebuilt(&scene, black, &|n, f, v, p| motion(n, f, v, p) * h);
            let solution =
                solve(&moved, &Options { error: fine, most_elements: 200_000, ..Options::default() }, |_| true).unwrap();
            sums.iter()
                .map(|sum| {
                    if sum.surfaces.is_empty() {
                        let p = &sum.points[0];
                        let on = solution.gather(p.position, p.normal);
                        match on {
                            Ok(g) => (g.radiosity, g.estimate.iter().map(|e| e.total()).collect::<Vec<_>>()),
                            Err(_) => {
                                let g = solution.irradiance_at(p.position, p.normal).unwrap();
                                (g.irradiance.clone(), g.estimate.iter().map(|e| e.total()).collect())
                            }
                        }
                    } else {
                        let value = if sum.surfaces.iter().all(|w| w[0] > 0.0) {
                            solution.mean().to_vec()
                        } else {
                            solution.derivative(&moved, sum).unwrap().value
                        };
                        (value, solution.mean_estimate().iter().map(|e| e.total()).collect())
                    }
                })
                .collect::<Vec<_>>()
        };
        let (ahead, behind) = (solved(step), solved(-step));
        for (k, (d, _)) in derivatives.iter().enumerate() {
            let c = 0;
            let difference = (ahead[k].0[c] - behind[k].0[c]) / (2.0 * step);
            let noise = (ahead[k].1[c] + behind[k].1[c]) / (2.0 * step);
            let (mut slope, mut norm, mut err, mut way) = (0.0, 0.0, 0.0, 0.0);
            for (f, face) in scene.faces().iter().enumerate() {
                let n = scene.surfaces()[face.surface()].name();
                for (v, p) in face.polygon().vertices().iter().enumerate() {
                    let m = motion(n, f, v, *p);
                    slope += d.vertices[f][v][c].dot(m);
                    if m != DVec3::ZERO {
                        norm += d.vertices[f][v][c].length_squared();
                        way += m.length_squared();
                    }
                    err += (d.vertices_estimate[f][v][c] * m.length()).powi(2);
                }
            }
            let norm = (norm * way).sqrt();
            println!(
                "{name:16} J{k}: {slope:11.6} {difference:11.6} rel {:+.4} of norm {:+.4}  est {:.4} noise {:.4}",
                (slope - difference) / difference.abs(),
                (slope - difference) / norm,
                err.sqrt() / difference.abs(),
                noise / difference.abs()
            );
        }
    }
}
