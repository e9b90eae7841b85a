//! Scenes in files: the one that comes with the project, and any others at hand.

use std::path::Path;

use radgrad_scene::{Degenerate, Note, Scene};

#[test]
fn the_cornell_box_has_its_left_wall_split_and_reported() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/cornell.obj");
    let scene = Scene::read(file, Degenerate::Refuse).unwrap();
    assert_eq!((scene.surfaces().len(), scene.faces().len()), (8, 20));
    let left_wall = scene.surface_named("left").unwrap();
    assert_eq!(scene.surfaces()[left_wall].faces().len(), 2);
    let [Note::Split { surface, triangles: 2, distance, .. }] = scene.notes() else { panic!("{:?}", scene.notes()) };
    assert_eq!(surface, "left");
    // Four corners of a warped quadrilateral are equally far from the plane between them.
    assert!((0.79..0.81).contains(distance), "{distance}");
    // Every wall is seen from the middle of the room.
    let middle = radgrad_core::DVec3::new(278.0, 400.0, 100.0);
    for name in ["floor", "ceiling", "light", "back", "right", "left"] {
        for &face in scene.surfaces()[scene.surface_named(name).unwrap()].faces() {
            let polygon = scene.faces()[face].polygon();
            assert!(polygon.normal().dot(middle - polygon.vertices()[0]) > 0.0, "{name}");
        }
    }
    let light = scene.surface_named("light").unwrap();
    assert_eq!(scene.area_of(light), 130.0 * 105.0);
    assert_eq!(scene.emitted_power(0), 17.0 * std::f64::consts::PI * 130.0 * 105.0);
}

/// `RADGRAD_SCENES=folder cargo test -p radgrad-scene --test all files -- --nocapture` reads every scene in a folder and prints the
/// result of each: a scene with its notes, or an error with its place. None may fail in another way.
#[test]
fn scenes_at_hand_are_read_or_refused_with_a_place() {
    let Some(folder) = std::env::var_os("RADGRAD_SCENES") else { return };
    let mut files: Vec<_> = std::fs::read_dir(Path::new(&folder)).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    for file in files {
        match Scene::read(&file, Degenerate::Refuse) {
            Ok(scene) => {
                let (faces, surfaces) = (scene.faces().len(), scene.surfaces().len());
                println!("{}: {faces} faces, {surfaces} surfaces, {} notes", file.display(), scene.notes().len());
                scene.notes().iter().for_each(|note| println!("    {note}"));
                assert!(scene.faces().iter().all(|face| face.polygon().area() > 0.0));
            }
            Err(radgrad_scene::Error::Format { .. }) => {}
            Err(error) => {
                println!("{error}");
                assert!(error.place().is_some());
            }
        }
    }
}
