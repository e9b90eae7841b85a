//! A word on scenes without light, and on lamps that no face sees: most often they are wound the other way.

use radgrad_core::{DVec3, Polygon};
use radgrad_scene::{Face, Scene};

use crate::say::say;

/// Says on the standard error which lamps light nothing.
pub(crate) fn report(scene: &Scene) {
    let faces = scene.faces();
    let emits = |face: &Face| scene.materials()[face.material()].emits();
    if !faces.iter().any(emits) {
        say("no face emits light, so that every radiosity is 0: lamps have `Ke` in MTL, an `emissiveFactor` in glTF");
        return;
    }
    let lights = |lamp: &Polygon| faces.iter().any(|face| sees(lamp, face.polygon()) && sees(face.polygon(), lamp));
    let mut idle = faces.iter().filter(|face| emits(face) && !lights(face.polygon()));
    if let Some(lamp) = idle.next() {
        let place = lamp.place().map_or_else(String::new, |place| format!("{place}: "));
        let surface = scene.surfaces()[lamp.surface()].name();
        let rule = "a face gives light to the side from which its vertices are counter-clockwise, and takes it there";
        say(format_args!("{place}lamp `{surface}` lights nothing: {rule}"));
        match idle.count() {
            0 => {}
            more => say(format_args!("{more} lamps more light nothing")),
        }
    }
}

/// Whether a part of another polygon is in front of a polygon's plane, beyond rounding.
fn sees(polygon: &Polygon, other: &Polygon) -> bool {
    const ROUNDING: f64 = 1e-9;
    let (normal, origin) = (polygon.normal(), polygon.vertices()[0]);
    let in_front = |vertex: &DVec3| {
        let offset = *vertex - origin;
        normal.dot(offset) > ROUNDING * offset.length()
    };
    other.vertices().iter().any(in_front)
}
