//! Bounds on the light of clusters exceed the light of all of their elements.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use radgrad_core::{DVec3, Polygon};
use radgrad_scene::{Prepared, Scene, largest};

use crate::clock::Clock;
use crate::field::Field;
use crate::gathering::irradiance;
use crate::links::cell::Rules;
use crate::links::cluster::far::Far;
use crate::links::cluster::sampled::Draw;
use crate::links::gatherer::Gatherer;
use crate::links::link::Link;
use crate::links::refine::{Need, WITHOUT_ORDER};
use crate::links::station::Station;
use crate::links::transfer::{Optics, Row};
use crate::mesh::Mesh;
use crate::mesh::clusters::{Clusters, Parts};
use crate::solve::goal_points::GoalPoints;
use crate::solve::options::Options;
use crate::solve::{solve, solve_on};

/// Blocks in a room, which all may hide each other: 5 faces each, and 7 of the room.
fn city(side: usize) -> Mesh {
    Mesh::new(&scene(side), 1).unwrap()
}

/// A part of the ceiling glows.
fn scene(side: usize) -> Scene {
    let mut scene = Scene::new(["grey"]).unwrap();
    let (white, surface) = (scene.add_material("white", [0.5], [0.0]).unwrap(), scene.add_surface("all"));
    let lamp = scene.add_material("lamp", [0.5], [10.0]).unwrap();
    let mut add_of = |material: usize, quad: [[f64; 3]; 4]| {
        let polygon = Polygon::new(quad.map(DVec3::from).to_vec()).unwrap();
        scene.add_face(surface, material, polygon, None).unwrap();
    };
    let sides = |[a, c]: [f64; 2], [b, d]: [f64; 2], height: f64| {
        let walls = [[[a, c], [b, c]], [[b, c], [b, d]], [[b, d], [a, d]], [[a, d], [a, c]]];
        walls.map(|[[p, q], [r, s]]| [[p, q, 0.0], [r, s, 0.0], [r, s, height], [p, q, height]])
    };
    let extent = side as f64;
    let roof = |[a, c]: [f64; 2], [b, d]: [f64; 2], height: f64| [[a, c, height], [b, c, height], [b, d, height], [a, d, height]];
    let lit = 0.3 * extent;
    for (material, [from, to]) in [(lamp, [0.0, lit]), (white, [lit, extent])] {
        add_of(material, roof([from, 0.0], [to, extent], 3.0).map(|[x, y, z]| [from + to - x, y, z]));
    }
    let mut add = |quad: [[f64; 3]; 4]| add_of(white, quad);
    add(roof([0.0; 2], [extent; 2], 0.0));
    sides([0.0; 2], [extent; 2], 3.0).into_iter().for_each(|[p, q, r, s]| add([q, p, s, r]));
    for index in 0..side * side {
        let (i, j) = ((index / side) as f64, (index % side) as f64);
        let height = 0.3 + (0.618_033_988_749_894_9 * index as f64).fract();
        // Over the floor, so that this is not cut.
        add(roof([i + 0.2, j + 0.3], [i + 0.7, j + 0.8], height));
        sides([i + 0.2, j + 0.3], [i + 0.7, j + 0.8], height).into_iter().for_each(|wall| {
            add(wall.map(|[x, y, z]| [x, y, largest(z, 0.01)]));
        });
    }
    scene
}

/// Links to all roots.
fn all_links(optics: &Optics<'_>, receiver: usize) -> Vec<Link> {
    let field = Field::dark(optics.mesh, 1);
    let need = Need {
        field: &field,
        weight: &[0.0],
        allowed: 1.0,
        without_order: WITHOUT_ORDER,
        of_rays: WITHOUT_ORDER,
        clock: Clock::started(),
    };
    let sources = optics.mesh.roots().iter().map(|&root| (root, None));
    optics.links(Gatherer::Element(receiver), sources, &need).unwrap()
}

fn optics<'a>(mesh: &'a Mesh, rules: &'a Rules) -> Optics<'a> {
    Optics { mesh, rules, absolute: 1e-9, past: 1e-9, cells: 0, brightness: 1.0, clock: Clock::started() }
}

#[test]
fn a_cluster_gives_no_more_than_its_view_and_a_cluster_that_faces_away_gives_nothing() {
    let (mesh, rules) = (city(3), Rules::new());
    let tree = Clusters::always_over(mesh.elements(), &vec![false; mesh.polygons().len()]);
    let optics = optics(&mesh, &rules);
    let (mut seen, mut away, mut tight) = (0, 0, 0.0_f64);
    for receiver in (0..mesh.elements().len()).step_by(7) {
        let links = all_links(&optics, receiver);
        for cluster in tree.clusters() {
            let mut open = vec![*cluster];
            let mut factors = vec![0.0; Station::at_nodes(&mesh, receiver).len()];
            while let Some(at) = open.pop() {
                match at.parts {
                    Parts::Two(parts) => open.extend(parts.map(|part| tree.clusters()[part])),
                    Parts::Element(element) => links.iter().filter(|link| link.source == element).for_each(|link| {
                        factors.iter_mut().zip(&link.rows).for_each(|(sum, row)| *sum += row.values[0] - row.error);
                    }),
                }
            }
            for (station, factor) in Station::at_nodes(&mesh, receiver).iter().zip(factors) {
                let view = cluster.view(station);
                assert!(factor <= view.factor && factor <= view.peak * cluster.area(), "{factor} {view:?} {cluster:?}");
                assert!(cluster.faces(&mesh.elements()[receiver]) || factor <= 0.0);
                seen += usize::from(factor > 0.0);
                away += usize::from(view.factor == 0.0);
                tight = largest(tight, factor / largest(view.factor, 1e-9));
            }
        }
    }
    assert!(seen > 1000 && away > 1000 && tight > 0.9, "{seen} {away} {tight}");
}

/// Light that differs from face to face and over each, here and there negative.
fn uneven(mesh: &Mesh) -> Field {
    let mut field = Field::dark(mesh, 1);
    for element in 0..mesh.elements().len() {
        let value = (0.754_877_666_246_692_7 * element as f64).fract();
        field.add(mesh, element, 0, &[value, 0.3 * value, -0.4 * value]);
    }
    field.pool(mesh);
    field.pull(mesh);
    field
}

#[test]
fn closed_clusters_are_mostly_within_twice_their_estimates() {
    let (mesh, rules) = (city(5).clustered(), Rules::new());
    let optics = optics(&mesh, &rules);
    let field = uneven(&mesh);
    let (mut near, mut all, mut within, mut nodes_seen, mut squares) = (0, 0, 0, 0, [0.0, 0.0]);
    let (mut points, mut within_at) = (0, 0);
    for allowed in [0.02, 0.1] {
        let (mut receivers, mut deviations) = (0, 0.0);
        for receiver in (0..mesh.elements().len()).step_by(5) {
            let exact = all_links(&optics, receiver);
            let need = Need {
                field: &field,
                weight: &[1.0],
                allowed,
                without_order: WITHOUT_ORDER,
                of_rays: WITHOUT_ORDER,
                clock: Clock::started(),
            };
            let (mut links, mut far) = optics.first_links(Gatherer::Element(receiver), None, &need).unwrap();
            optics.refine(Gatherer::Element(receiver), (&mut links, &mut far), &need).unwrap();
            near += links.len();
            all += exact.len();
            let nodes = Station::at_nodes(&mesh, receiver).len();
            let sums = |links: &[Link], far: &Far| irradiance(&field, links, far, 0, nodes);
            let [rough, exact_sums] = [sums(&links, &far), sums(&exact, &Far::default())];
            if !far.is_empty() {
                let likely = far.likely_mean(&field, 0, mesh.basis(receiver));
                (receivers, deviations) = (receivers + 1, deviations + likely * likely);
            }
            for (node, station) in Station::at_nodes(&mesh, receiver).iter().enumerate() {
                let (error, rounding) = ((rough[node] - exact_sums[node]).abs(), 1e-6);
                if !far.is_empty() {
                    let likely = far.likely(&field, 0, node);
                    (nodes_seen, within) = (nodes_seen + 1, within + usize::from(error <= 2.0 * likely + rounding));
                    squares = [squares[0] + error * error, squares[1] + likely * likely];
                }
                // The value of a gather at the point itself.
                let at_node: Vec<(usize, Row)> = links.iter().map(|link| (link.source, link.rows[node].clone())).collect();
                let of_point = far.of_point(&optics, station, &at_node);
                let linked: f64 = rough[node] - far.value(&field, 0, node);
                let error = (linked + of_point.value(&field, 0, 0) - exact_sums[node]).abs();
                let likely = of_point.likely(&field, 0, 0);
                (points, within_at) = (points + 1, within_at + usize::from(error <= 2.0 * likely + rounding));
            }
        }
        // In the mean over the nodes; those rays that are gathered by are not those that were found good enough.
        let deviation = (deviations / f64::from(receivers)).sqrt();
        assert!(deviation <= WITHOUT_ORDER * allowed, "{allowed}: {deviation}");
    }
    let [error, likely] = squares.map(f64::sqrt);
    assert!(nodes_seen > 100 && 20 * within >= 19 * nodes_seen, "{within} of {nodes_seen}, {error} by {likely}");
    assert!(20 * within_at >= 19 * points, "{within_at} of {points}");
    assert!(2 * near < all && likely < 8.0 * error && error < likely, "{near} of {all}, {error} by {likely}");
}

#[test]
fn clusters_are_opened_further_and_nothing_is_linked_twice() {
    let (mesh, rules) = (city(5).clustered(), Rules::new());
    let optics = optics(&mesh, &rules);
    let field = uneven(&mesh);
    let (mut before, mut after, mut receivers, mut deviations) = (0, 0, 0, 0.0);
    for receiver in (0..mesh.elements().len()).step_by(5) {
        let need = |allowed: f64| Need {
            field: &field,
            weight: &[1.0],
            allowed,
            without_order: WITHOUT_ORDER,
            of_rays: WITHOUT_ORDER,
            clock: Clock::started(),
        };
        let (mut links, mut far) = optics.first_links(Gatherer::Element(receiver), None, &need(0.4)).unwrap();
        optics.refine(Gatherer::Element(receiver), (&mut links, &mut far), &need(0.4)).unwrap();
        before += links.len();
        optics.refine(Gatherer::Element(receiver), (&mut links, &mut far), &need(0.02)).unwrap();
        after += links.len();
        let sources: BTreeSet<usize> = links.iter().map(|link| link.source).collect();
        assert_eq!(sources.len(), links.len(), "{receiver}");
        let exact: BTreeMap<usize, f64> =
            all_links(&optics, receiver).iter().map(|link| (link.source, link.rows[0].values[0])).collect();
        for link in &links {
            // The faces between that are known may be fewer, and so the sum of the light that they let through.
            let [exact, found] = [exact[&link.source], link.rows[0].values[0]];
            assert!((exact - found).abs() <= 1e-14 * exact, "{exact} {found}");
        }
        if !far.is_empty() {
            let likely = far.likely_mean(&field, 0, mesh.basis(receiver));
            (receivers, deviations) = (receivers + 1, deviations + likely * likely);
        }
    }
    let deviation = (deviations / f64::from(receivers)).sqrt();
    assert!(after > before + before / 4 && deviation <= WITHOUT_ORDER * 0.02, "{before} {after} {deviation}");
}

#[test]
fn a_carpet_in_the_plane_of_the_floor_is_found() {
    let square = |low: f64, high: f64, z: f64| {
        let corners = [[low, low, z], [high, low, z], [high, high, z], [low, high, z]];
        Polygon::new(corners.map(DVec3::from).to_vec()).unwrap()
    };
    let are_apart = |polygons: &[Polygon]| {
        let mut scene = Scene::new(["grey"]).unwrap();
        let (white, surface) = (scene.add_material("white", [0.5], [0.0]).unwrap(), scene.add_surface("all"));
        for polygon in polygons {
            scene.add_face(surface, white, polygon.clone(), None).unwrap();
        }
        let mesh = Mesh::new(&scene, 0).unwrap();
        Clusters::always_over(mesh.elements(), &vec![false; mesh.polygons().len()]).are_apart()
    };
    assert!(!are_apart(&[square(0.0, 4.0, 0.0), square(1.0, 2.0, 0.0)]));
    assert!(are_apart(&[square(0.0, 4.0, 0.0), square(1.0, 2.0, 0.1), square(4.0, 5.0, 0.0)]));
    assert!(are_apart(&[square(0.0, 4.0, 0.0), square(4.0, 5.0, 0.0)]));
}

#[test]
fn a_point_in_a_cluster_may_see_nothing_else() {
    let mesh = city(3);
    let tree = Clusters::always_over(mesh.elements(), &vec![false; mesh.polygons().len()]);
    let station = Station { point: DVec3::new(1.0, 1.0, 0.5), normal: DVec3::Z, face: Some(0) };
    let view = tree.clusters()[0].view(&station);
    assert!(view.factor == 1.0 && view.peak.is_infinite());
}

#[test]
fn by_clusters_light_from_a_lamp_is_within_its_estimate_of_a_far_finer_solution() {
    let scene = scene(3);
    let degree = Some(1);
    let fine = solve(&scene, &Options { error: 0.05, degree, ..Options::default() }, |_| true).unwrap();
    let fine_estimate = fine.error_estimate.mean[0].total();
    let options = Options { error: 0.3, degree, first_elements: 1, most_elements: 0, ..Options::default() };
    let mesh = Mesh::new(&scene, 1).unwrap().clustered();
    let rough = solve_on(&Prepared::new(&scene).unwrap(), &options, (mesh, GoalPoints::default()), |_| true).unwrap();
    assert!(rough.system.far.iter().any(|far| !far.is_empty()), "clusters are in force");
    let stated = rough.error_estimate.mean[0].total();
    let (mut mean_error, mut area, mut at_points, mut exceeding) = (0.0, 0.0, 0.0, 0.0);
    for leaf in rough.mesh().leaves() {
        let element = &rough.mesh().elements()[leaf];
        let [there, here] = [fine.gather(element.centre(), element.polygon().normal()), rough.gather_on(leaf, element.centre())];
        let [there, here] = [there.unwrap(), here.unwrap()];
        let apart = (there.radiosity[0] - here.radiosity[0]).abs();
        let [estimate, of_fine] = [&here, &there].map(|gathered| gathered.estimate[0].total());
        if apart > 2.0 * (estimate + of_fine) {
            exceeding += element.area();
        }
        (mean_error, area) = (mean_error + element.area() * apart, area + element.area());
        at_points += element.area() * estimate;
    }
    let [mean_error, at_points] = [mean_error, at_points].map(|sum| sum / area);
    println!("{mean_error:.1e} mean_error, {stated:.1e} stated, {at_points:.1e} at points, {fine_estimate:.1e} of the finer one");
    assert!(mean_error <= stated + fine_estimate && mean_error > fine_estimate / 20.0, "{mean_error} {stated} {fine_estimate}");
    assert!(exceeding <= 0.05 * area, "{exceeding} of {area} is off by more than twice the estimate");
}

#[test]
fn without_time_there_is_an_answer_with_an_estimate() {
    let scene = scene(8);
    let options = Options { error: 0.05, degree: Some(1), time: Some(Duration::ZERO), ..Options::default() };
    // Some hundred faces are put into clusters where there is no time to link all of them to all others.
    for mesh in [Mesh::new(&scene, 1).unwrap().clustered(), Mesh::new(&scene, 1).unwrap()] {
        let rough = solve_on(&Prepared::new(&scene).unwrap(), &options, (mesh, GoalPoints::default()), |_| true).unwrap();
        assert!(rough.system.far.iter().any(|far| !far.is_empty()), "clusters are in force");
        assert!(rough.progress().round == 1 && rough.mean()[0] > 0.0 && rough.progress().estimate.is_finite());
        let element = &rough.mesh().elements()[0];
        let gathered = rough.gather(element.centre(), element.polygon().normal()).unwrap();
        assert!(gathered.estimate[0].total().is_finite());
    }
}

#[test]
fn rays_see_all_of_a_closed_room_whatever_hides_what() {
    let (mesh, rules) = (city(5).clustered(), Rules::new());
    let optics = optics(&mesh, &rules);
    let root = mesh.clusters().root().unwrap();
    for receiver in (0..mesh.elements().len()).step_by(7) {
        let exact = all_links(&optics, receiver);
        for (node, station) in Station::at_nodes(&mesh, receiver).iter().enumerate() {
            let rays = optics.rays(station, 256, Draw::Second);
            let part = |cluster: usize| {
                let part = &mesh.clusters().clusters()[cluster];
                optics.look(station, &rays, cluster).weight * part.area()
            };
            // A ray in a hundred may pass below a wall, which is over the floor, and end on the back of another one.
            assert!((0.99..1.0 + 1e-12).contains(&part(root)), "{receiver} {node}: {}", part(root));
            // The largest source is met as often as its form factor says, within four deviations.
            let factor = |link: &&Link| link.rows[node].values.first().copied().unwrap_or(0.0);
            let largest = exact.iter().max_by(|a, b| factor(a).total_cmp(&factor(b))).unwrap();
            let (met, factor) = (part(mesh.clusters().single(largest.source)), factor(&largest));
            let deviation = (factor * (1.0 - factor) / 256.0).sqrt();
            assert!((met - factor).abs() <= 4.0 * deviation + 2.0 / 256.0, "{receiver} {node}: {met} for {factor}");
        }
    }
}
