//! A closed room with a block, lit by its ceiling: radiosity and the estimate of its error on the mesh.
//!
//! Drawn is one gather a cell, `B_g = E + rho G B_h`, and the estimate of its error at the centre of each element, seen along parallel
//! lines. Faces that are turned away are not drawn: so the room is seen through its near walls.

use std::error::Error;
use std::f64::consts::PI;

use radgrad_core::{DVec3, Polygon};
use radgrad_scene::Scene;
use radgrad_solver::{Element, Ledger, Options, Shape, Solution, solve};
use rayon::prelude::*;

use super::convex::Point;
use super::plates::Plate;
use super::svg::{Anchor, Svg, around};
use crate::figures::panel::ticks;
use crate::plot::Colours;

/// Room, in m; the ceiling emits 100 W/m2, the rest reflects half.
const ROOM: DVec3 = DVec3::new(3.0, 2.0, 2.0);
const BLOCK: [DVec3; 2] = [DVec3::new(1.0, 0.6, 0.0), DVec3::new(1.8, 1.4, 0.9)];
const ROOM_ERROR: f64 = 0.05;

/// Solves the room.
pub(super) fn solution() -> Result<Solution, Box<dyn Error>> {
    Ok(solve(&room()?, &Options { error: ROOM_ERROR, degree: Some(1), ..Options::default() }, |_| true)?)
}

/// The floor is cut around the block's foot.
fn room() -> Result<Scene, Box<dyn Error>> {
    let mut scene = Scene::new(["grey"])?;
    let (wall, lamp) = (scene.add_material("wall", [0.5], [0.0])?, scene.add_material("lamp", [0.0], [100.0 / PI])?);
    let ([low, high], zero) = (BLOCK, DVec3::ZERO);
    let (over, under) = (DVec3::new(0.0, 0.0, ROOM.z), zero);
    // A rectangle by three of its corners, counter-clockwise from the side that is seen.
    let mut add = |name: &str, material, [a, b, c]: [DVec3; 3]| -> Result<(), Box<dyn Error>> {
        let surface = scene.add_surface(name);
        scene.add_face(surface, material, Polygon::new(vec![a, b, c, a + c - b])?, None)?;
        Ok(())
    };
    let corner = |x: f64, y: f64, z: DVec3| DVec3::new(x, y, z.z);
    let (x, y) = (ROOM.x, ROOM.y);
    add("ceiling", lamp, [corner(0.0, y, over), corner(x, y, over), corner(x, 0.0, over)])?;
    add("south", wall, [corner(0.0, 0.0, over), corner(x, 0.0, over), corner(x, 0.0, under)])?;
    add("north", wall, [corner(x, y, under), corner(x, y, over), corner(0.0, y, over)])?;
    add("west", wall, [corner(0.0, y, under), corner(0.0, y, over), corner(0.0, 0.0, over)])?;
    add("east", wall, [corner(x, 0.0, over), corner(x, y, over), corner(x, y, under)])?;
    for ([x0, x1], [y0, y1]) in
        [([0.0, x], [0.0, low.y]), ([0.0, low.x], [low.y, high.y]), ([high.x, x], [low.y, high.y]), ([0.0, x], [high.y, y])]
    {
        add("floor", wall, [corner(x0, y0, under), corner(x1, y0, under), corner(x1, y1, under)])?;
    }
    add("block", wall, [corner(low.x, low.y, high), corner(high.x, low.y, high), corner(high.x, high.y, high)])?;
    let foot = [corner(low.x, low.y, low), corner(high.x, low.y, low), corner(high.x, high.y, low), corner(low.x, high.y, low)];
    for (a, b) in foot.into_iter().zip(foot.into_iter().cycle().skip(1)) {
        add("block", wall, [a, b, corner(b.x, b.y, high)])?;
    }
    Ok(scene)
}

/// A leaf of the room that is seen from where it is drawn.
pub(super) struct Leaf {
    index: usize,
    /// Cells: outline and gathered radiosity.
    cells: Vec<(Vec<DVec3>, f64)>,
    /// Estimate of the error of the gathered radiosity at the centre.
    estimate: Ledger,
    radiosity: f64,
    is_seen: bool,
    is_block: bool,
}

pub(super) struct Cells(Vec<Leaf>);

/// Pixels to a metre, and where the origin stands.
const SCALE: f64 = 104.0;
const ORIGIN: Point = (64.0, 346.0);
const ROOM_SIZE: (f64, f64) = (520.0, 404.0);

/// Where a point of the room is drawn: along parallel lines, from an azimuth of -60 and an elevation of 30 degrees.
fn place(p: DVec3) -> Point {
    let (right, back) = (0.866 * p.x + 0.5 * p.y, -0.5 * p.x + 0.866 * p.y);
    (ORIGIN.0 + SCALE * right, ORIGIN.1 - 46.0 - SCALE * (0.5 * back + 0.866 * p.z))
}

/// Toward the eye.
const EYE: DVec3 = DVec3::new(0.433, -0.75, 0.5);

impl Cells {
    pub(super) fn visible(room: &Solution) -> Result<Self, Box<dyn Error>> {
        let leaves: Vec<usize> = room.mesh().leaves().collect();
        let leaf = |index: usize| {
            let element = &room.mesh().elements()[index];
            let corners = element.polygon().vertices();
            let is_seen = element.polygon().normal().dot(EYE) > 0.0;
            let at_centre = room.gather_on(index, element.centre())?;
            let gather = |(outline, at): (Vec<DVec3>, DVec3)| Ok((outline, room.gather_on(index, at)?.radiosity[0]));
            let cells = if is_seen { cells(element) } else { Vec::new() };
            Ok::<_, radgrad_solver::Error>(Leaf {
                index,
                cells: cells.into_iter().map(gather).collect::<Result<_, radgrad_solver::Error>>()?,
                estimate: at_centre.estimate[0],
                radiosity: at_centre.radiosity[0],
                is_seen,
                is_block: corners.iter().all(|v| v.cmpge(BLOCK[0]).all() && v.cmple(BLOCK[1]).all()),
            })
        };
        let mut leaves = leaves.into_par_iter().map(leaf).collect::<Result<Vec<_>, _>>()?;
        // The block is in front of all of the room that is seen.
        leaves.sort_by_key(|leaf| (leaf.is_block, leaf.index));
        Ok(Self(leaves))
    }

    fn visible_leaves(&self) -> impl Iterator<Item = &Leaf> {
        self.0.iter().filter(|leaf| leaf.is_seen)
    }

    pub(super) fn radiosity(&self, room: &Solution) -> Result<Plate, Box<dyn Error>> {
        let top = self.visible_leaves().flat_map(|leaf| &leaf.cells).map(|cell| cell.1).fold(0.0, f64::max);
        let painted =
            self.visible_leaves().map(|leaf| (leaf, leaf.cells.iter().map(|(outline, b)| (outline.as_slice(), *b)).collect()));
        let title = "Figure J: radiosity in a room with a block";
        let picture = draw(room, painted, ["J   Radiosity", "B (W/m²)", title], top, Colours::Viridis);
        let mean = room.mean()[0];
        Ok(Plate {
            picture,
            caption: format!(
                "J. A closed room of 3 m by 2 m by 2 m with a block, seen through its east and south walls and its ceiling, which emits 100 \
                 W/m²; all else reflects half. {} elements, {} links; mean radiosity {mean:.2} W/m². Lines: the mesh. Colours: one \
                 exact gather a cell.",
                room.progress().elements,
                room.progress().links
            ),
        })
    }

    pub(super) fn estimate(&self, room: &Solution) -> Result<Plate, Box<dyn Error>> {
        let top = self.visible_leaves().map(|leaf| leaf.estimate.total()).fold(0.0, f64::max);
        let outlines: Vec<(&Leaf, Vec<&[DVec3]>)> =
            self.visible_leaves().map(|leaf| (leaf, vec![room.mesh().elements()[leaf.index].polygon().vertices()])).collect();
        let painted = outlines.into_iter().map(|(leaf, of)| (leaf, of.into_iter().map(|o| (o, leaf.estimate.total())).collect()));
        let title = "Figure K: estimate of the error of the radiosity in the room";
        let picture = draw(room, painted, ["K   Estimate of its error", "estimate (W/m²)", title], top, Colours::Inferno);
        let estimate = room.mean_estimate()[0].total();
        Ok(Plate {
            picture,
            caption: format!(
                "K. The estimate stated with the gather at the centre of each element. Of the mean over all area {estimate:.2} W/m², {:.1} % of the mean \
                 radiosity; {:.0} % was asked for.",
                100.0 * estimate / room.mean()[0],
                100.0 * ROOM_ERROR
            ),
        })
    }

    /// A row a leaf: radiosity and estimate at its centre, by source.
    pub(super) fn csv(&self, room: &Solution) -> Result<Vec<u8>, Box<dyn Error>> {
        let mut rows = csv::Writer::from_writer(Vec::new());
        let names = ["element", "face", "level", "area", "x", "y", "z", "radiosity", "estimate"];
        rows.write_record(names.iter().chain(&Ledger::NAMES))?;
        for leaf in &self.0 {
            let element = &room.mesh().elements()[leaf.index];
            let counts = [leaf.index, element.face(), element.level() as usize].map(|count| count.to_string());
            let centre = element.centre().to_array().map(|x| format!("{x:.5}"));
            let estimates = [leaf.estimate.total()].into_iter().chain(leaf.estimate.entries()).map(|x| format!("{x:.3e}"));
            let numbers = [format!("{:.6}", element.area())].into_iter().chain(centre).chain([format!("{:.6}", leaf.radiosity)]);
            rows.write_record(counts.into_iter().chain(numbers).chain(estimates))?;
        }
        Ok(rows.into_inner()?)
    }
}

/// The cells of an element with a point in each, about a seventh of a metre wide.
fn cells(element: &Element) -> Vec<(Vec<DVec3>, DVec3)> {
    if element.shape() == Shape::Triangle {
        return vec![(element.polygon().vertices().to_vec(), element.centre())];
    }
    let length = |to: [f64; 2]| (element.point(to) - element.point([0.0, 0.0])).length();
    let count = |length: f64| (1..6u32).find(|n| length / f64::from(*n) < 0.15).unwrap_or(6);
    let [along, across] = [count(length([1.0, 0.0])), count(length([0.0, 1.0]))];
    let corner = |i: f64, k: f64| element.point([i / f64::from(along), k / f64::from(across)]);
    let cell = |(i, k): (u32, u32)| {
        let (i, k) = (f64::from(i), f64::from(k));
        (vec![corner(i, k), corner(i + 1.0, k), corner(i + 1.0, k + 1.0), corner(i, k + 1.0)], corner(i + 0.5, k + 0.5))
    };
    (0..along).flat_map(|i| (0..across).map(move |k| (i, k))).map(cell).collect()
}

/// The room with painted cells and its mesh; heading, unit and title are given.
fn draw<'a>(
    room: &Solution,
    painted: impl Iterator<Item = (&'a Leaf, Vec<(&'a [DVec3], f64)>)>,
    [heading, unit, title]: [&str; 3],
    top: f64,
    colours: Colours,
) -> String {
    let mut svg = Svg::new(ROOM_SIZE.0, ROOM_SIZE.1);
    svg.text("title", (14.0, 18.0), Anchor::Start, heading);
    let flat = |outline: &[DVec3]| around(&outline.iter().map(|p| place(*p)).collect::<Vec<_>>());
    let mut count = 0;
    for (leaf, cells) in painted {
        for (outline, value) in cells {
            svg.filled("tile", colours.colour(value / top), &flat(outline));
        }
        svg.path("mesh", &flat(room.mesh().elements()[leaf.index].polygon().vertices()));
        count += 1;
    }
    scale(&mut svg, colours, top, unit);
    axes(&mut svg);
    svg.finish("plot", title, &format!("{count} elements are seen; colours from 0 to {top:.3} W/m², mesh drawn."))
}

/// Lengths along the edges of the floor that are nearest.
fn axes(svg: &mut Svg) {
    for (to, name) in [(DVec3::X * ROOM.x, "x (m)"), (DVec3::X * ROOM.x + DVec3::Y * ROOM.y, "y (m)")] {
        let is_x = name.starts_with('x');
        let from = if is_x { DVec3::ZERO } else { DVec3::X * ROOM.x };
        let length = (to - from).length();
        for tick in ticks(0.0, length, 4).values {
            let (x, y) = place(from + (to - from) * (tick / length));
            svg.line("axis", (x, y), (x, y + 4.0));
            let (dx, anchor) = if is_x { (-3.0, Anchor::End) } else { (4.0, Anchor::Start) };
            svg.text("tick", (x + dx, y + 13.0), anchor, &format!("{tick}"));
        }
        let (x, y) = place(from.lerp(to, 0.5));
        let (dx, anchor) = if is_x { (-16.0, Anchor::End) } else { (18.0, Anchor::Start) };
        svg.text("label", (x + dx, y + 26.0), anchor, name);
    }
    for z in ticks(0.0, ROOM.z, 4).values {
        let (x, y) = place(DVec3::Z * z);
        svg.line("axis", (x - 4.0, y), (x, y));
        svg.text("tick", (x - 7.0, y + 3.5), Anchor::End, &format!("{z}"));
    }
    let (x, y) = place(DVec3::Z * ROOM.z);
    svg.text("label", (x + 4.0, y - 8.0), Anchor::End, "z (m)");
}

fn scale(svg: &mut Svg, colours: Colours, top: f64, unit: &str) {
    let (left, upper, height, steps) = (456.0, 76.0, 220.0, 55u32);
    let step = height / f64::from(steps);
    for index in 0..steps {
        let (t, y) = ((f64::from(index) + 0.5) / f64::from(steps), upper + height - step * (f64::from(index) + 0.5));
        let commands = format!("M{left} {y:.2}h14");
        svg.painted("bar-step", colours.colour(t), &commands);
    }
    svg.rectangle("frame", (left, upper), (14.0, height));
    let levels = ticks(0.0, top, 6);
    for &level in &levels.values {
        let y = upper + height * (1.0 - level / top);
        svg.line("axis", (left + 14.0, y), (left + 18.0, y));
        svg.text("tick", (left + 21.0, y + 3.5), Anchor::Start, &levels.label(level));
    }
    svg.text("label", (left + 54.0, upper - 9.0), Anchor::End, unit);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_room_is_closed() {
        let room = room().unwrap();
        // Twice the floor but for the block's foot is the floor and the ceiling; the block's top is as large as its foot.
        let (walls, block) = (2.0 * (ROOM.x + ROOM.y) * ROOM.z, BLOCK[1] - BLOCK[0]);
        let expected = walls + 2.0 * ROOM.x * ROOM.y + 2.0 * (block.x + block.y) * block.z;
        let area: f64 = room.polygons().map(Polygon::area).sum();
        assert!((area - expected).abs() < 1e-12, "{area} {expected}");
    }
}
