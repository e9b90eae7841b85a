//! Figure E: the emitter over the receiver plane, seen from above at a slant, with the level lines of the radiosity on the plane.

use radgrad_core::DVec3;

use super::field::Field;
use super::panel::ticks;
use crate::plot::{Anchor, Colours, FAINT, INK, Picture, Point, Rgb, Stroke, Type};

/// Room of the figure in a picture.
pub(crate) const SIZE: Point = (840.0, 490.0);

const LIT: Rgb = (255, 205, 92);
const EDGE: Rgb = (178, 112, 12);
const GROUND: Rgb = (245, 245, 248);
const GRID: Rgb = (221, 221, 228);
const RAY: Rgb = (196, 52, 66);

/// A view along parallel lines: where a point of space stands in the picture.
#[derive(Debug, Clone, Copy)]
struct View {
    centre: Point,
    scale: f64,
}

impl View {
    /// Looks from the direction of azimuth -64 degrees and elevation 20 degrees: the sines and cosines below.
    fn place(self, p: DVec3) -> Point {
        let (right, back) = (0.899 * p.x + 0.438 * p.y, -0.438 * p.x + 0.899 * p.y);
        (self.centre.0 + self.scale * right, self.centre.1 - self.scale * (0.342 * back + 0.940 * p.z))
    }
}

/// Draws the scene: `emitter` over the plane z = 0, on which `radiosity` was sampled, with the receiver point `x` joined to `y`
/// on the emitter.
pub(crate) fn draw(picture: &mut Picture, emitter: &[DVec3; 3], radiosity: &Field, x: DVec3, y: DVec3) {
    let view = View { centre: (316.0, 322.0), scale: 182.0 };
    ground(picture, view, radiosity);
    let corners = emitter.map(|v| view.place(v));
    let feet = emitter.map(|v| view.place(DVec3::new(v.x, v.y, 0.0)));
    picture.fill(&feet, INK, 0.08);
    picture.outline(&feet, Stroke::dashed(FAINT, 0.9));
    for (corner, foot) in corners.iter().zip(feet) {
        picture.line(&[*corner, foot], Stroke::dashed(FAINT, 0.9));
    }
    picture.fill(&corners, LIT, 1.0);
    picture.outline(&corners, Stroke::solid(EDGE, 1.6));
    receiver(picture, view, x, y);
    let middle = (emitter[0] + emitter[1] + emitter[2]) / 3.0;
    picture.arrow(view.place(middle), view.place(middle - DVec3::Z * 0.42), Stroke::solid(EDGE, 1.8));
    let (mx, my) = view.place(middle - DVec3::Z * 0.42);
    picture.text((mx - 8.0, my + 4.0), "n₂", Type { size: 14, colour: EDGE, anchor: Anchor::End });
    labels(picture, emitter, corners);
    let title = Type { size: 17, colour: INK, anchor: Anchor::Start };
    picture.text((30.0, 36.0), "E   Geometry of the scene", title);
    let explained = Type { size: 11, colour: FAINT, ..title };
    picture.text(
        (30.0, 54.0),
        "triangular emitter 1 m over a parallel plane of reflectance 1, with the lines of equal radiosity of figure A",
        explained,
    );
}

fn ground(picture: &mut Picture, view: View, radiosity: &Field) {
    let window = radiosity.window;
    let on_ground = |x: f64, y: f64| view.place(DVec3::new(x, y, 0.0));
    let ([x0, x1], [y0, y1]) = (window.x, window.y);
    let corners = [on_ground(x0, y0), on_ground(x1, y0), on_ground(x1, y1), on_ground(x0, y1)];
    picture.fill(&corners, GROUND, 1.0);
    let label = Type { size: 11, colour: INK, anchor: Anchor::Middle };
    let along_x = ticks(x0, x1, 6);
    for &x in &along_x.values {
        picture.line(&[on_ground(x, y0), on_ground(x, y1)], Stroke::solid(GRID, 0.8));
        let (px, py) = on_ground(x, y0);
        picture.text((px - 4.0, py + 16.0), &along_x.label(x), label);
    }
    let along_y = ticks(y0, y1, 6);
    for &y in &along_y.values {
        picture.line(&[on_ground(x0, y), on_ground(x1, y)], Stroke::solid(GRID, 0.8));
        let (px, py) = on_ground(x1, y);
        picture.text((px + 16.0, py + 10.0), &along_y.label(y), label);
    }
    let (top, _) = radiosity.largest();
    for level in ticks(0.0, top, 8).values {
        let stroke = Stroke::solid(Colours::Viridis.colour(0.9 * level / top), 1.6);
        for segment in radiosity.level_line(level) {
            picture.line(&segment.map(|(x, y)| on_ground(x, y)), stroke);
        }
    }
    picture.outline(&corners, Stroke::solid(INK, 0.9));
    let name = Type { size: 13, ..label };
    let (px, py) = on_ground((x0 + x1) / 2.0, y0);
    picture.text((px - 14.0, py + 36.0), "x (m)", name);
    let (px, py) = on_ground(x1, (y0 + y1) / 2.0);
    picture.text((px + 46.0, py + 24.0), "y (m)", name);
}

/// The receiver point with its normal, joined to a point of the emitter.
fn receiver(picture: &mut Picture, view: View, x: DVec3, y: DVec3) {
    let (at_x, at_y, tip) = (view.place(x), view.place(y), view.place(x + DVec3::Z * 0.42));
    picture.arrow(at_x, at_y, Stroke::solid(RAY, 1.4));
    picture.arrow(at_x, tip, Stroke::solid(INK, 1.8));
    picture.disc(at_x, 3.4, INK);
    let name = |colour, anchor| Type { size: 14, colour, anchor };
    picture.text((at_x.0 + 8.0, at_x.1 + 12.0), "x", name(INK, Anchor::Start));
    picture.text((tip.0, tip.1 - 6.0), "n₁", name(INK, Anchor::Middle));
    picture.text((at_y.0 - 6.0, at_y.1 - 5.0), "y", name(INK, Anchor::End));
    let upper = (0.2 * at_x.0 + 0.8 * at_y.0, 0.2 * at_x.1 + 0.8 * at_y.1);
    picture.text((upper.0 + 14.0, upper.1 + 6.0), "r₁₂", name(RAY, Anchor::Start));
}

fn labels(picture: &mut Picture, emitter: &[DVec3; 3], corners: [Point; 3]) {
    let places = [(-8.0, -6.0, Anchor::End), (0.0, -24.0, Anchor::Middle), (10.0, -6.0, Anchor::Start)];
    for (i, ((v, corner), (dx, dy, anchor))) in emitter.iter().zip(corners).zip(places).enumerate() {
        let (x, y) = (corner.0 + dx, corner.1 + dy);
        let name = ["E₀", "E₁", "E₂"][i];
        picture.text((x, y), &format!("{name} ({}, {}, {})", v.x, v.y, v.z), Type { size: 13, colour: INK, anchor });
        let value = format!("linear: B = {} W/m²", super::LINEAR[i]);
        picture.text((x, y + 14.0), &value, Type { size: 10, colour: FAINT, anchor });
    }
}
