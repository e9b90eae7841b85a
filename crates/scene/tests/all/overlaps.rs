//! Files with faces in one plane, as people write them.

use std::path::PathBuf;

use radgrad_scene::{Error, FactorSettings, FormFactors, Overlaps, Reading, Scene};

fn file(name: &str) -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes")).join(name)
}

fn read(name: &str, overlaps: Overlaps) -> Result<Scene, Error> {
    Scene::read(file(name), Reading { overlaps, ..Reading::default() })
}

/// A note or an error without the folder of its files.
fn said(text: &impl ToString) -> String {
    text.to_string().replace(&format!("{}/", file("").display().to_string().trim_end_matches('/')), "")
}

fn reading(name: &str, overlaps: Overlaps) -> Scene {
    read(name, overlaps).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn a_room_with_a_window_drawn_on_its_wall_is_closed() {
    let room = reading("window_on_wall.obj", Overlaps::Nested);
    let notes: Vec<String> = room.notes().iter().map(said).collect();
    let cut = "window_on_wall.obj:18: a face of `south` is cut into 4 pieces around a face of `window` (window_on_wall.obj:42)";
    assert!(notes.iter().any(|note| note == cut), "{notes:?}");
    let factors = FormFactors::new(&room).unwrap();
    let matrix = factors.matrix(&FactorSettings::default(), || ()).unwrap();
    assert!(matrix.worst_closure() < 1e-6, "{}", matrix.worst_closure());
    let window = room.faces().len() - 1;
    assert!((matrix.factor(0, window) - 0.035_821).abs() < 1e-6, "{}", matrix.factor(0, window));
}

#[test]
fn a_lamp_on_its_ceiling_gives_all_of_its_light() {
    let room = reading("lamp_on_ceiling.obj", Overlaps::Nested);
    let [ceiling, lamp] = ["ceiling", "lamp"].map(|name| room.surface_named(name).unwrap());
    assert_eq!((room.area_of(ceiling), room.area_of(lamp)), (15.0, 1.0));
    assert!(FormFactors::new(&room).is_ok());
    let refused = said(&read("lamp_on_ceiling.obj", Overlaps::Refuse).unwrap_err());
    let pair = "face 1 of `ceiling` (lamp_on_ceiling.obj:15) and face 6 of `lamp` (lamp_on_ceiling.obj:50) overlap";
    assert!(refused.starts_with("lamp_on_ceiling.obj: ") && refused.contains(pair), "{refused}");
}

#[test]
fn a_face_that_is_there_twice_is_read_once() {
    let block = reading("face_twice.obj", Overlaps::Nested);
    assert_eq!(block.faces().len(), 5);
    let note = "face_twice.obj:11: a face of `block` is left out: it is the same as a face of `block` (face_twice.obj:10)";
    assert!(block.notes().iter().any(|found| said(found) == note), "{:?}", block.notes());
}

#[test]
fn a_hole_that_an_outline_reaches_along_an_edge_is_cut_out() {
    let wall = reading("hole_at_bridge.obj", Overlaps::Nested);
    assert_eq!(wall.area_of(wall.surface_named("wall").unwrap()), 8.0);
    assert!(FormFactors::new(&wall).is_ok());
}
