//! Solved scenes: their radiosity and its bound on the mesh, and how far the bound is from the error where that is known.
//!
//! Two scenes: unit squares that face each other, whose radiosity is known to 17 digits at two points; and a closed room with a
//! block, lit by its ceiling. What is drawn of the room is one gather a cell, `B_g = E + rho G B_h`, and the bound on its error.

use std::error::Error;
use std::f64::consts::PI;

use radgrad_core::{DVec3, Polygon};
use radgrad_scene::Scene;
use radgrad_solver::{Element, Ledger, Options, Shape, Solution, solve};
use rayon::prelude::*;

use super::axis::Axis;
use super::convex::Point;
use super::plates::Plate;
use super::svg::{Anchor, Svg, around};
use super::table::{Cell, Table};
use crate::figures::panel::ticks;
use crate::plot::Colours;

/// Radiosity of two squares that reflect half and emit 1, at the centre and at a corner of either.
const KNOWN: [(&str, DVec3, f64); 2] = [
    ("centre", DVec3::new(0.5, 0.5, 0.0), 1.133_303_564_992_420_8),
    ("corner", DVec3::new(0.0, 0.0, 0.0), 1.076_981_393_145_044_5),
];
/// Errors asked for of the two squares.
const ASKED: [f64; 4] = [1e-2, 1e-3, 1e-4, 1e-6];
const MOST_ELEMENTS: usize = 400;
/// Room, in m; the ceiling emits 100 W/m2, the rest reflects half.
const ROOM: DVec3 = DVec3::new(3.0, 2.0, 2.0);
const BLOCK: [DVec3; 2] = [DVec3::new(1.0, 0.6, 0.0), DVec3::new(1.8, 1.4, 0.9)];
const ROOM_ERROR: f64 = 0.05;

/// What is shown of them.
pub(super) struct Solved {
    pub(super) plates: Vec<Plate>,
    pub(super) ledger: Plate,
    pub(super) known: Table,
    /// `effectivity.csv`.
    pub(super) effectivity_csv: Vec<u8>,
    /// `elements.csv`: of the room.
    pub(super) elements_csv: Vec<u8>,
    /// `ledger.csv`.
    pub(super) ledger_csv: Vec<u8>,
}

/// Solves and draws.
pub(super) fn solved() -> Result<Solved, Box<dyn Error>> {
    let (squares, room) = (squares()?, room()?);
    let asked = Options { error: ROOM_ERROR, degree: Some(1), ..Options::default() };
    let room = solve(&room, &asked, |_| true)?;
    let trials = trials(&squares)?;
    let best = solve(&squares, &Options { error: ASKED[3], degree: Some(2), first_elements: 1, ..Options::default() }, |_| true)?;
    let ledgers = [("two squares, degree 2", &best), ("room, degree 1", &room)];
    let cells = Cells::of(&room)?;
    Ok(Solved {
        plates: vec![cells.radiosity(&room)?, cells.bound(&room)?, effectivity(&trials)],
        ledger: ledger(&ledgers),
        known: known(&trials),
        effectivity_csv: trials_csv(&trials)?,
        elements_csv: cells.csv(&room)?,
        ledger_csv: ledger_csv(&ledgers)?,
    })
}

fn squares() -> Result<Scene, Box<dyn Error>> {
    let mut scene = Scene::new(["grey"])?;
    let grey = scene.add_material("grey", [0.5], [1.0 / PI])?;
    let surface = scene.add_surface("squares");
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    for corners in [corners.map(|(x, y)| DVec3::new(x, y, 0.0)), corners.map(|(x, y)| DVec3::new(y, x, 1.0))] {
        scene.add_face(surface, grey, Polygon::new(corners.to_vec())?, None)?;
    }
    Ok(scene)
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
    let at = |x: f64, y: f64, z: DVec3| DVec3::new(x, y, z.z);
    let (x, y) = (ROOM.x, ROOM.y);
    add("ceiling", lamp, [at(0.0, y, over), at(x, y, over), at(x, 0.0, over)])?;
    add("south", wall, [at(0.0, 0.0, over), at(x, 0.0, over), at(x, 0.0, under)])?;
    add("north", wall, [at(x, y, under), at(x, y, over), at(0.0, y, over)])?;
    add("west", wall, [at(0.0, y, under), at(0.0, y, over), at(0.0, 0.0, over)])?;
    add("east", wall, [at(x, 0.0, over), at(x, y, over), at(x, y, under)])?;
    for ([x0, x1], [y0, y1]) in
        [([0.0, x], [0.0, low.y]), ([0.0, low.x], [low.y, high.y]), ([high.x, x], [low.y, high.y]), ([0.0, x], [high.y, y])]
    {
        add("floor", wall, [at(x0, y0, under), at(x1, y0, under), at(x1, y1, under)])?;
    }
    add("block", wall, [at(low.x, low.y, high), at(high.x, low.y, high), at(high.x, high.y, high)])?;
    let foot = [at(low.x, low.y, low), at(high.x, low.y, low), at(high.x, high.y, low), at(low.x, high.y, low)];
    for (a, b) in foot.into_iter().zip(foot.into_iter().cycle().skip(1)) {
        add("block", wall, [a, b, at(b.x, b.y, high)])?;
    }
    Ok(scene)
}

/// A solution of the squares beside what is known.
struct Trial {
    degree: usize,
    asked: f64,
    elements: usize,
    place: &'static str,
    error: f64,
    bound: f64,
}

fn trials(squares: &Scene) -> Result<Vec<Trial>, Box<dyn Error>> {
    let mut trials = Vec::new();
    for (degree, asked) in (0..=3).flat_map(|degree| ASKED.map(|asked| (degree, asked))) {
        let options =
            Options { error: asked, degree: Some(degree), first_elements: 1, most_elements: MOST_ELEMENTS, ..Options::default() };
        let solution = solve(squares, &options, |_| true)?;
        // What already met a coarser demand is the same solution.
        if trials.last().is_some_and(|last: &Trial| last.degree == degree && last.elements == solution.progress().elements) {
            continue;
        }
        for (place, point, exact) in KNOWN {
            let gathered = solution.gather(point, DVec3::Z)?;
            let (error, bound) = ((gathered.radiosity[0] - exact).abs(), gathered.ledger[0].total());
            trials.push(Trial { degree, asked, elements: solution.progress().elements, place, error, bound });
        }
    }
    Ok(trials)
}

/// Errors and bounds over the number of elements, at the centre.
fn effectivity(trials: &[Trial]) -> Plate {
    const SIZE: (f64, f64) = (560.0, 330.0);
    let (left, right, top, bottom) = (58.0, 548.0, 34.0, 276.0);
    let shown = || trials.iter().filter(|trial| trial.place == KNOWN[0].0);
    let most = shown().map(|trial| trial.elements as f64).fold(10.0, f64::max);
    let across = Axis { base: 10.0, exponents: [0.0, libm::log10(most).ceil()], places: [left, right] };
    let lowest = shown().map(|trial| trial.error.max(1e-17)).fold(1.0, f64::min);
    let highest = shown().map(|trial| trial.bound).fold(lowest, f64::max);
    let exponents = [libm::log10(lowest).floor(), libm::log10(highest).ceil()];
    let up = Axis { base: 10.0, exponents, places: [bottom, top] };
    let mut svg = Svg::new(SIZE.0, SIZE.1);
    svg.text("title", (left, 18.0), Anchor::Start, "L   Error and bound at the centre of a square");
    across.draw_below(&mut svg, [top, bottom], 5.0, "tick");
    up.draw_left(&mut svg, left, 8.0, "tick");
    for trial in shown() {
        // Degrees stand beside each other where they have as many elements.
        let x = across.place(trial.elements as f64) + 11.0 * (trial.degree as f64 - 1.5);
        let [error, bound] = [trial.error.max(1e-17), trial.bound].map(|of| up.place(of));
        let class = format!("d{}", trial.degree);
        svg.line(&format!("{class} reach"), (x, error), (x, bound));
        svg.circle(&format!("{class} error"), (x, error), 3.4);
        svg.line(&format!("{class} bound"), (x - 5.0, bound), (x + 5.0, bound));
        svg.text("tick", (x, bound - 4.0), Anchor::Middle, &trial.degree.to_string());
    }
    svg.rectangle("frame", (left, top), (right - left, bottom - top));
    svg.text("label", ((left + right) / 2.0, bottom + 30.0), Anchor::Middle, "elements (count)");
    svg.text_upward("label", (14.0, (top + bottom) / 2.0), "error and bound (W/m²)");
    svg.text("label", ((left + right) / 2.0, bottom + 48.0), Anchor::Middle, "dot: error; bar: bound; number and colour: degree");
    let title = "Figure L: error and bound of two squares by number of elements";
    Plate {
        picture: svg.finish("plot", title, "For degrees 0 to 3: the error is below its bound in every solution."),
        caption: format!(
            "L. Two unit squares 1 m apart, each reflects half and emits 1 W/m²: {:.16} W/m² at the centre. The bound over the error is the \
             effectivity: 1 would be a bound without slack, below 1 a broken one.",
            KNOWN[0].2
        ),
    }
}

fn known(trials: &[Trial]) -> Table {
    let titles = ["where", "#degree", "#asked", "#elements", "#error (W/m²)", "#bound (W/m²)", "#bound / error"];
    let mut table =
        Table::new("Two squares: what is known of the error, what is stated, and their ratio", &["effectivity.csv"], &titles);
    for trial in trials {
        let number = |x: f64, text: String| Cell::from(&text).by(x);
        table.push([
            Cell::from(trial.place),
            number(trial.degree as f64, trial.degree.to_string()),
            number(trial.asked, format!("{:.0e}", trial.asked)),
            number(trial.elements as f64, trial.elements.to_string()),
            number(trial.error, format!("{:.1e}", trial.error)),
            number(trial.bound, format!("{:.1e}", trial.bound)),
            number(trial.bound / trial.error, format!("{:.1}", trial.bound / trial.error)),
        ]);
    }
    table
}

fn trials_csv(trials: &[Trial]) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut rows = csv::Writer::from_writer(Vec::new());
    rows.write_record(["where", "degree", "asked", "elements", "error", "bound", "effectivity"])?;
    for Trial { degree, asked, elements, place, error, bound } in trials {
        let [asked, error, bound, effectivity] = [*asked, *error, *bound, bound / error].map(|x| format!("{x:.3e}"));
        rows.write_record([*place, &degree.to_string(), &asked, &elements.to_string(), &error, &bound, &effectivity])?;
    }
    Ok(rows.into_inner()?)
}

/// A leaf of the room that is seen from where it is drawn.
struct Leaf {
    index: usize,
    /// Cells: outline and gathered radiosity.
    cells: Vec<(Vec<DVec3>, f64)>,
    /// Bound on the gathered radiosity at the centre.
    bound: Ledger,
    radiosity: f64,
    is_seen: bool,
    is_block: bool,
}

struct Cells(Vec<Leaf>);

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
    fn of(room: &Solution) -> Result<Self, Box<dyn Error>> {
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
                bound: at_centre.ledger[0],
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

    fn seen(&self) -> impl Iterator<Item = &Leaf> {
        self.0.iter().filter(|leaf| leaf.is_seen)
    }

    fn radiosity(&self, room: &Solution) -> Result<Plate, Box<dyn Error>> {
        let top = self.seen().flat_map(|leaf| &leaf.cells).map(|cell| cell.1).fold(0.0, f64::max);
        let painted = self.seen().map(|leaf| (leaf, leaf.cells.iter().map(|(outline, b)| (outline.as_slice(), *b)).collect()));
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

    fn bound(&self, room: &Solution) -> Result<Plate, Box<dyn Error>> {
        let top = self.seen().map(|leaf| leaf.bound.total()).fold(0.0, f64::max);
        let outlines: Vec<(&Leaf, Vec<&[DVec3]>)> =
            self.seen().map(|leaf| (leaf, vec![room.mesh().elements()[leaf.index].polygon().vertices()])).collect();
        let painted = outlines.into_iter().map(|(leaf, of)| (leaf, of.into_iter().map(|o| (o, leaf.bound.total())).collect()));
        let title = "Figure K: bound on the error of the radiosity in the room";
        let picture = draw(room, painted, ["K   Bound on its error", "bound (W/m²)", title], top, Colours::Inferno);
        let bound = room.mean_bound()[0].total();
        Ok(Plate {
            picture,
            caption: format!(
                "K. The bound stated with the gather at the centre of each element. Mean over all area {bound:.2} W/m², {:.1} % of the mean \
                 radiosity; {:.0} % was asked for.",
                100.0 * bound / room.mean()[0],
                100.0 * ROOM_ERROR
            ),
        })
    }

    /// A row a leaf: radiosity and bound at its centre, by source.
    fn csv(&self, room: &Solution) -> Result<Vec<u8>, Box<dyn Error>> {
        let mut rows = csv::Writer::from_writer(Vec::new());
        let names = ["element", "face", "level", "area", "x", "y", "z", "radiosity", "bound"];
        rows.write_record(names.iter().chain(&Ledger::NAMES))?;
        for leaf in &self.0 {
            let element = &room.mesh().elements()[leaf.index];
            let counts = [leaf.index, element.face(), element.level() as usize].map(|count| count.to_string());
            let centre = element.centre().to_array().map(|x| format!("{x:.5}"));
            let bounds = [leaf.bound.total()].into_iter().chain(leaf.bound.entries()).map(|x| format!("{x:.3e}"));
            let numbers = [format!("{:.6}", element.area())].into_iter().chain(centre).chain([format!("{:.6}", leaf.radiosity)]);
            rows.write_record(counts.into_iter().chain(numbers).chain(bounds))?;
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
    let at = |i: f64, k: f64| element.point([i / f64::from(along), k / f64::from(across)]);
    let cell = |(i, k): (u32, u32)| {
        let (i, k) = (f64::from(i), f64::from(k));
        (vec![at(i, k), at(i + 1.0, k), at(i + 1.0, k + 1.0), at(i, k + 1.0)], at(i + 0.5, k + 0.5))
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
            svg.filled("tile", colours.at(value / top), &flat(outline));
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
        svg.painted("bar-step", colours.at(t), &commands);
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

/// The mean of the bound over the mean radiosity, by its sources, a bar each.
fn ledger(of: &[(&str, &Solution)]) -> Plate {
    const SIZE: (f64, f64) = (560.0, 330.0);
    let (left, right, top, row) = (104.0, 548.0, 40.0, 39.0);
    let bottom = top + row * 6.0;
    let axis = Axis { base: 10.0, exponents: [-18.0, 0.0], places: [left, right] };
    let mut svg = Svg::new(SIZE.0, SIZE.1);
    svg.text("title", (left, 18.0), Anchor::Start, "M   Where the bound comes from");
    axis.draw_below(&mut svg, [top - 8.0, bottom], 6.0, "tick");
    for (index, name) in Ledger::NAMES.into_iter().chain(["all"]).enumerate() {
        let y = top + row * index as f64;
        svg.text("label", (left - 8.0, y + row / 2.0), Anchor::End, name);
        for (rank, (_, solution)) in of.iter().enumerate() {
            let part = share(solution, index);
            let upper = y + 3.0 + 16.0 * rank as f64;
            svg.rectangle(&format!("l{rank}"), (left, upper), (axis.place(part.max(1e-18)) - left, 13.0));
            let label = if part == 0.0 { "0".to_owned() } else { format!("{part:.1e}") };
            svg.text("tick", (axis.place(part.max(1e-18)).min(right - 52.0) + 5.0, upper + 10.0), Anchor::Start, &label);
        }
    }
    svg.text("label", ((left + right) / 2.0, bottom + 31.0), Anchor::Middle, "mean bound over mean radiosity (no unit)");
    let title = "Figure M: the bound by its sources";
    Plate {
        picture: svg.finish("plot", title, "Nearly all of both bounds is discretisation; the linear system adds rounding only."),
        caption: "M. The ledger: what of the bound is due to the scene read otherwise than given, to polynomials on elements, to links and \
                  rounding, to what is hidden, and to the linear system."
            .to_owned(),
    }
}

/// The scenes of the ledger with their colours.
pub(super) fn legend() -> String {
    use super::rungs::swatch;
    [swatch("l0", "two squares, degree 2"), swatch("l1", "room, degree 1")].concat()
}

/// An entry of the ledger, the sum after the last, over the mean radiosity.
fn share(solution: &Solution, index: usize) -> f64 {
    let ledger = solution.mean_bound()[0];
    ledger.entries().get(index).copied().unwrap_or_else(|| ledger.total()) / solution.mean()[0]
}

fn ledger_csv(of: &[(&str, &Solution)]) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut rows = csv::Writer::from_writer(Vec::new());
    rows.write_record(["scene", "elements", "links", "mean-radiosity"].iter().chain(&Ledger::NAMES).chain(&["all"]))?;
    for (name, solution) in of {
        let progress = solution.progress();
        let counts = [progress.elements, progress.links].map(|count| count.to_string());
        let parts = (0..=Ledger::NAMES.len()).map(|index| format!("{:.3e}", share(solution, index)));
        let mean = format!("{:.6}", solution.mean()[0]);
        rows.write_record([(*name).to_owned()].into_iter().chain(counts).chain([mean]).chain(parts))?;
    }
    Ok(rows.into_inner()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_error_is_beyond_its_bound_and_finer_is_nearer() {
        let trials = trials(&squares().unwrap()).unwrap();
        assert!(trials.iter().all(|trial| trial.error <= trial.bound));
        let worst = |asked: f64| trials.iter().filter(|t| t.asked == asked).map(|t| t.error).fold(0.0, f64::max);
        assert!(worst(1e-6) < worst(1e-2), "{} {}", worst(1e-6), worst(1e-2));
    }

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
