//! The Cornell box: the radiosity at its points by the light past walls and blocks, against the oracle, which shares no formula
//! with it and finds the visible part in another way.
//!
//! The coordinates are those that Cornell University's Program of Computer Graphics measured, in millimetres.

use radgrad_core::{Answer, DVec3, Emission, Emitter, Polygon, Receiver, evaluate};
use radgrad_oracle::{Enclosure, enclose_occluded};
use radgrad_scene::{Beam, Degenerate, FormFactors, Scene};

struct Room {
    scene: Scene,
    light: usize,
    lamp: Emitter,
}

impl Room {
    fn read() -> Self {
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../data/scenes/cornell.obj");
        let scene = Scene::read(file, Degenerate::Refuse).unwrap();
        let light = scene.surfaces()[scene.surface_named("light").unwrap()].faces()[0];
        let lamp = Emitter::new(scene.faces()[light].polygon().clone(), Emission::Constant(1.0)).unwrap();
        Self { scene, light, lamp }
    }

    fn others(&self) -> impl Iterator<Item = &Polygon> {
        self.scene.polygons().enumerate().filter(|(face, _)| *face != self.light).map(|(_, polygon)| polygon)
    }

    fn truth(&self, receiver: &Receiver, more: &[Polygon]) -> Enclosure {
        let occluders: Vec<Polygon> = self.others().chain(more).cloned().collect();
        enclose_occluded(receiver, &self.lamp, &occluders, 18).unwrap()
    }

    /// With the occluders that the index finds, and those.
    fn answer(&self, receiver: &Receiver, more: &[Polygon]) -> Answer {
        let index = FormFactors::new(&self.scene).unwrap();
        let beam = Beam::from_receiver(receiver, self.lamp.polygon()).unwrap();
        let occluders = index.index().in_beam(&beam, &[self.light]).polygons;
        evaluate(receiver, &self.lamp, occluders.iter().map(|&face| self.scene.faces()[face].polygon()).chain(more)).unwrap()
    }
}

fn error_of_gradient(truth: &Enclosure, gradient: DVec3) -> f64 {
    [0, 1, 2].map(|axis| truth.gradient[axis].error_of(gradient[axis])).iter().fold(0.0, |norm: f64, error| norm.hypot(*error))
}

fn size_of_gradient(truth: &Enclosure) -> f64 {
    truth.gradient.each_ref().map(|c| c.to_f64()).iter().fold(0.0, |norm: f64, c| norm.hypot(*c))
}

#[test]
fn the_left_wall_is_split_and_said_to_be() {
    let Room { scene, .. } = Room::read();
    let wall = &scene.surfaces()[scene.surface_named("left").unwrap()];
    let notes: Vec<String> = scene.notes().iter().map(ToString::to_string).collect();
    assert_eq!((wall.faces().len(), notes.len()), (2, 1), "{notes:?}");
    assert!(notes[0].contains("a face of `left`") && notes[0].contains("split into 2 triangles"), "{notes:?}");
}

#[test]
fn value_and_gradient_are_the_oracles_anywhere_in_the_box() {
    let room = Room::read();
    let (mut visible, mut partly, mut dark) = (0, 0, 0);
    // On the floor, which is exactly level, and above it, facing all ways.
    let normals = [DVec3::Y, DVec3::new(0.6, 0.3, -0.2), DVec3::new(-0.5, 0.8, 0.4)];
    for k in 0..60 {
        let share = |step: usize, period: usize| ((k * step) % period) as f64 / period as f64;
        let height = [0.0, 0.0, 80.0, 200.0, 350.0][k % 5];
        let x = DVec3::new(20.0 + 510.0 * share(7, 60), height, 15.0 + 530.0 * share(23, 61));
        let receiver = Receiver::new(x, if height == 0.0 { DVec3::Y } else { normals[k % 3] }, 1.0).unwrap();
        let (truth, answer) = (room.truth(&receiver, &[]), room.answer(&receiver, &[]));
        let error = truth.radiosity.error_of(answer.radiosity);
        assert!(error <= 1e-12 && error <= answer.radiosity_error + truth.radiosity.radius(), "{x}: {answer:?} {truth:?}");
        let (error, size) = (error_of_gradient(&truth, answer.gradient), size_of_gradient(&truth));
        assert!(error <= 1e-10 * size && answer.gradient_error <= 1e-10 * size, "{x}: {answer:?} {truth:?}");
        let free = radgrad_core::radiosity(&receiver, &room.lamp).unwrap();
        if answer.radiosity == 0.0 {
            dark += 1;
        } else if answer.radiosity < 0.999 * free {
            partly += 1;
        } else {
            visible += 1;
        }
    }
    assert!(visible > 10 && partly > 3 && dark > 3, "{visible} {partly} {dark}");
}

#[test]
fn where_a_shadow_begins_the_gradient_is_the_limit_from_either_side() {
    let room = Room::read();
    // The floor's points in the plane of an edge of the light and a corner of the short block: the corner is seen on the edge.
    let (corner, edges) = (DVec3::new(290.0, 165.0, 114.0), room.lamp.polygon().vertices());
    let mut events = 0;
    for (i, &from) in edges.iter().enumerate() {
        let to = edges[(i + 1) % edges.len()];
        for share in [0.25, 0.75] {
            let on_edge = from + (to - from) * share;
            let x = on_edge + (corner - on_edge) * (on_edge.y / (on_edge.y - corner.y));
            let aside = (to - from).cross(corner - from).with_y(0.0).normalize();
            let receiver = |shift: f64| Receiver::new(x.with_y(0.0) + aside * shift, DVec3::Y, 1.0).unwrap();
            let [before, here, after] = [-1e-3, 0.0, 1e-3].map(|shift| {
                let (truth, answer) = (room.truth(&receiver(shift), &[]), room.answer(&receiver(shift), &[]));
                assert!(truth.radiosity.error_of(answer.radiosity) <= 1e-12, "{x}: {answer:?} {truth:?}");
                assert!(error_of_gradient(&truth, answer.gradient) <= 1e-10 * size_of_gradient(&truth), "{x}: {answer:?}");
                answer.gradient
            });
            assert!((before - here).length() < 1e-7 && (after - here).length() < 1e-7, "{before} {here} {after}");
            events += usize::from(before != after);
        }
    }
    assert!(events > 4, "{events}");
}

#[test]
fn where_the_gradient_jumps_its_bound_says_so_and_either_side_is_right() {
    let room = Room::read();
    // A shelf with an edge along an edge of the light: from the floor at z = 100 the two are seen as one.
    let corners = [[300.0, 274.4, 0.0], [300.0, 274.4, 163.5], [420.0, 274.4, 163.5], [420.0, 274.4, 0.0]];
    let shelf = [Polygon::new(corners.map(DVec3::from).to_vec()).unwrap()];
    let receiver = |z: f64| Receiver::new(DVec3::new(450.0, 0.0, z), DVec3::Y, 1.0).unwrap();
    let (here, truth) = (room.answer(&receiver(100.0), &shelf), room.truth(&receiver(100.0), &shelf));
    assert!(truth.radiosity.error_of(here.radiosity) <= 1e-12, "{here:?} {truth:?}");
    let [before, after] = [-1e-9, 1e-9].map(|shift| {
        let (truth, answer) = (room.truth(&receiver(100.0 + shift), &shelf), room.answer(&receiver(100.0 + shift), &shelf));
        assert!(truth.radiosity.error_of(answer.radiosity) <= 1e-12, "{answer:?} {truth:?}");
        assert!(error_of_gradient(&truth, answer.gradient) <= 1e-10 * size_of_gradient(&truth), "{answer:?} {truth:?}");
        answer.gradient
    });
    let jump = (after - before).length();
    assert!(jump > 1e-5, "{before} {after}");
    // At the event itself: one of the two, and a bound that has both inside.
    assert!([before, after].iter().any(|side| (*side - here.gradient).length() < 1e-6 * jump), "{before} {here:?} {after}");
    assert!(here.gradient_error >= 0.999 * jump, "{here:?} {jump}");
}
