//! Refinement of one receiver by the gradient: the promises of the criteria, the cases that fool them (HS95 Fig. 3), and the effect
//! of a sample at the maximum.

use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, evaluate_to};
use radgrad_paper::receiver::{Lighting, Refinement, refine_constant, refine_linear};
use radgrad_scene::largest;

fn rectangle([x0, x1]: [f64; 2], [y0, y1]: [f64; 2], z: f64) -> Vec<DVec3> {
    [(x0, y0), (x1, y0), (x1, y1), (x0, y1)].map(|(x, y)| DVec3::new(x, y, z)).to_vec()
}

fn floor(half: f64) -> Polygon {
    Polygon::new(rectangle([-half, half], [-half, half], 0.0)).unwrap()
}

/// A lamp that shines down.
fn lamp(x: [f64; 2], y: [f64; 2], z: f64, emission: Emission) -> Emitter {
    let mut corners = rectangle(x, y, z);
    corners.reverse();
    Emitter::new(Polygon::new(corners).unwrap(), emission).unwrap()
}

const fn light<'a>(emitters: &'a [Emitter], occluders: &'a [Polygon]) -> Lighting<'a> {
    Lighting { emitters, occluders, reflectance: 1.0, tolerance: 1e-9 }
}

/// The largest difference on a grid over the floor, and the largest radiosity there.
fn true_error(half: f64, light: &Lighting<'_>, value: impl Fn(DVec3) -> Option<f64>) -> (f64, f64) {
    let n = 60;
    let coordinate = |i: i32| half * (f64::from(2 * i) / f64::from(n) - 1.0) * 0.999;
    let (mut error, mut greatest) = (0.0_f64, 0.0_f64);
    for (i, j) in (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))) {
        let point = DVec3::new(coordinate(i), coordinate(j), 0.0);
        let receiver = Receiver::new(point, DVec3::Z, light.reflectance).unwrap();
        let exact: f64 =
            light.emitters.iter().map(|emitter| evaluate_to(&receiver, emitter, light.occluders, 1e-6).unwrap().radiosity).sum();
        error = largest(error, (value(point).expect("the mesh covers the floor") - exact).abs());
        greatest = largest(greatest, exact);
    }
    (error, greatest)
}

/// The paper's Fig. 3: a small lamp close to a large floor. All corners and the one centroid lie around its peak.
fn peak() -> [Emitter; 1] {
    [lamp([-0.3, 0.3], [-0.3, 0.3], 0.5, Emission::Constant(1.0))]
}

#[test]
fn a_linear_element_is_fooled_by_a_peak_between_its_samples_and_right_with_the_maximum_first() {
    let (half, lamps) = (4.0, peak());
    let light = light(&lamps, &[]);
    let wanted = Refinement { error: 0.01, maximum_first: false, ..Refinement::default() };
    let fooled = refine_linear(&floor(half), &light, &wanted).unwrap();
    assert_eq!(fooled.triangles().len(), 2, "the criterion sees nothing to divide");
    let (error, largest) = true_error(half, &light, |p| fooled.value(p));
    assert!(largest > 0.2 && error > 0.95 * largest, "{error} of {largest}: all of the light is missed");

    let right = refine_linear(&floor(half), &light, &Refinement { maximum_first: true, ..wanted }).unwrap();
    let (error, _) = true_error(half, &light, |p| right.value(p));
    assert!(error <= 1.2 * wanted.error, "{error} with {} triangles", right.triangles().len());
    println!("linear: {} triangles, off {error:.4}, allowed {}", right.triangles().len(), wanted.error);
}

#[test]
fn a_constant_element_is_fooled_on_top_of_a_peak_and_beside_it_and_right_with_the_maximum_first() {
    let (half, lamps) = (4.0, peak());
    let light = light(&lamps, &[]);
    let wanted = Refinement { error: 0.02, maximum_first: false, ..Refinement::default() };
    let fooled = refine_constant(&floor(half), &light, &wanted).unwrap();
    assert_eq!(fooled.elements().len(), 1, "the gradient is zero below the lamp");
    let (error, largest) = true_error(half, &light, |p| fooled.value(p));
    assert!(error > 0.95 * largest, "{error} of {largest}: the floor is as bright everywhere as below the lamp");

    // The centroid beside the peak: a lamp near a corner, far from the floor's centre.
    let aside = [lamp([2.2, 2.8], [1.2, 1.8], 0.3, Emission::Constant(1.0))];
    let beside = Lighting { emitters: &aside, ..light };
    let missed = refine_constant(&floor(half), &beside, &wanted).unwrap();
    assert_eq!(missed.elements().len(), 1, "nearly no light and no gradient at the centre");
    let (error, largest) = true_error(half, &beside, |p| missed.value(p));
    assert!(error > 0.95 * largest, "{error} of {largest}");

    for light in [light, beside] {
        let right = refine_constant(&floor(half), &light, &Refinement { maximum_first: true, ..wanted }).unwrap();
        let (error, _) = true_error(half, &light, |p| right.value(p));
        assert!(error <= 2.5 * wanted.error, "{error} with {} elements", right.elements().len());
        println!("constant: {} elements, off {error:.4}, allowed {}", right.elements().len(), wanted.error);
    }
}

#[test]
fn several_emitters_and_occluders_are_refined_to_what_is_allowed() {
    let half = 2.0;
    let lamps = [
        lamp([-1.5, -1.0], [-1.0, -0.4], 0.6, Emission::Constant(1.0)),
        lamp([0.4, 1.2], [0.3, 1.5], 0.8, Emission::at_vertices(vec![1.0, 2.0, 1.5, 0.5])),
    ];
    let screen = [Polygon::new(rectangle([0.2, 1.0], [0.0, 0.9], 0.4)).unwrap()];
    let light = light(&lamps, &screen);
    let wanted = Refinement { error: 0.04, longest: 0.5, ..Refinement::default() };
    let linear = refine_linear(&floor(half), &light, &wanted).unwrap();
    let constant = refine_constant(&floor(half), &light, &wanted).unwrap();
    assert!(linear.worst() <= wanted.error && constant.worst() <= wanted.error);
    let (error, _) = true_error(half, &light, |p| linear.value(p));
    assert!(error <= 2.0 * wanted.error, "{error} with {} triangles", linear.triangles().len());
    println!("past an occluder: {} triangles, off {error:.4}, allowed {}", linear.triangles().len(), wanted.error);
    let (error, _) = true_error(half, &light, |p| constant.value(p));
    assert!(error <= 2.0 * wanted.error, "{error} with {} elements", constant.elements().len());
}

#[test]
fn elements_cover_the_receiver_and_meet_along_whole_edges() {
    let lamps = peak();
    let light = light(&lamps, &[]);
    let l = [[-2.0, -2.0], [2.0, -2.0], [2.0, 0.1], [0.3, 0.1], [0.3, 2.0], [-2.0, 2.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
    let floor = Polygon::new(l.to_vec()).unwrap();
    let mesh = refine_linear(&floor, &light, &Refinement::default()).unwrap();
    let area = |corners: &[DVec3]| Polygon::new(corners.to_vec()).unwrap().area();
    let triangles: f64 = mesh.triangles().iter().map(|t| area(&t.map(|i| mesh.samples()[i].position))).sum();
    assert!((triangles - floor.area()).abs() < 1e-9);
    let mut edges = std::collections::HashMap::new();
    for t in mesh.triangles() {
        for k in 0..3 {
            *edges.entry([t[k].min(t[(k + 1) % 3]), t[k].max(t[(k + 1) % 3])]).or_insert(0) += 1;
        }
    }
    // Euler: one outline, no hole.
    assert_eq!(mesh.samples().len() + mesh.triangles().len(), edges.len() + 1);
    assert!(edges.values().all(|&count| count <= 2));
    let mesh = refine_constant(&floor, &light, &Refinement::default()).unwrap();
    let elements: f64 = mesh.elements().iter().map(|e| area(&e.corners)).sum();
    assert!((elements - floor.area()).abs() < 1e-9);
}

#[test]
fn fewer_elements_than_uniform_ones_for_the_same_true_error() {
    let (half, lamps) = (4.0, peak());
    let light = light(&lamps, &[]);
    let mesh = refine_constant(&floor(half), &light, &Refinement { error: 0.01, ..Refinement::default() }).unwrap();
    let (error, _) = true_error(half, &light, |p| mesh.value(p));
    // A uniform grid of squares, each with the value at its centre.
    let uniform = |n: i32| {
        let cell = |x: f64| ((x + half) / (2.0 * half) * f64::from(n)).floor().clamp(0.0, f64::from(n - 1));
        let centre = |x: f64| half * (2.0 * (cell(x) + 0.5) / f64::from(n) - 1.0);
        let value = |p: DVec3| light.sample(DVec3::new(centre(p.x), centre(p.y), 0.0), DVec3::Z).ok().map(|s| s.value);
        true_error(half, &light, value).0
    };
    let n = (1..).map(|k| 4 * k).find(|&n| uniform(n) <= error).unwrap();
    let ratio = f64::from(n * n) / mesh.elements().len() as f64;
    assert!(ratio >= 3.0, "{} elements against {n} x {n}, off {error}", mesh.elements().len());
    println!("{} elements, uniform {}: {ratio:.1} times", mesh.elements().len(), n * n);
}

#[test]
fn an_error_or_a_length_that_nothing_can_have_is_refused() {
    let lamps = peak();
    for error in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let refused = refine_linear(&floor(1.0), &light(&lamps, &[]), &Refinement { error, ..Refinement::default() });
        assert!(refused.unwrap_err().to_string().starts_with(&format!("elements may be off {error}")));
    }
    let refused = refine_constant(&floor(1.0), &light(&lamps, &[]), &Refinement { longest: 0.0, ..Refinement::default() });
    assert!(refused.unwrap_err().to_string().starts_with("sides may be 0 long"));
}
