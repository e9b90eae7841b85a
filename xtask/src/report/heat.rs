//! The stability maps: relative error over planes of two parameters, one panel a way to compute it, and the rung that answered.

use radgrad_audit::comparison::stability::{Emitted, Plane};
use serde::Serialize;

use super::audit::{Audit, Point};
use super::axis::Axis;
use super::rungs::{RUNGS, swatch};
use super::svg::{Anchor, Svg, number};

const SIZE: (f64, f64) = (220.0, 196.0);
const LEFT: f64 = 48.0;
const RIGHT: f64 = 210.0;
const TOP: f64 = 24.0;
const BOTTOM: f64 = 156.0;

/// Upper ends of the classes of error, and their names.
const CLASSES: [(f64, &str); 9] = [
    (1e-14, "below 1e-14"),
    (1e-12, "1e-12"),
    (1e-10, "1e-10"),
    (1e-8, "1e-8"),
    (1e-6, "1e-6"),
    (1e-4, "1e-4"),
    (1e-2, "1e-2"),
    (1.0, "1"),
    (f64::INFINITY, "1 and above"),
];

/// The class of no answer.
const NONE: usize = CLASSES.len();

/// One plane with one emission.
#[derive(Debug, Serialize)]
pub(super) struct Group {
    id: String,
    title: String,
    reading: &'static str,
    /// Rows of panels: of the value, of the gradient.
    rows: Vec<Row>,
}

#[derive(Debug, Serialize)]
struct Row {
    title: &'static str,
    panels: Vec<String>,
}

/// The maps in the order of the planes.
pub(super) fn groups(audit: &Audit) -> Vec<Group> {
    let both = |plane| Emitted::ALL.into_iter().map(move |emitted| (plane, emitted));
    Plane::ALL.into_iter().flat_map(both).filter_map(|(plane, emitted)| group(audit, plane, emitted)).collect()
}

fn group(audit: &Audit, plane: Plane, emitted: Emitted) -> Option<Group> {
    let points: Vec<&Point> =
        audit.stability.iter().filter(|p| p.plane == plane.name() && p.emission == emitted.name()).collect();
    let columns = points.iter().position(|p| p.y != points[0].y).filter(|columns| *columns > 1)?;
    let map = Map { plane, columns, points };
    let number = Plane::ALL.iter().position(|p| *p == plane).unwrap_or(0);
    let is_constant = emitted == Emitted::Constant;
    let value = [
        if is_constant { map.errors("single-precision fit", "radiosity", |p| p.single_precision_value) } else { None },
        map.errors("paper's form, corrected", "radiosity", |p| p.corrected_value),
        map.errors("our closed form", "radiosity", |p| p.closed_form_value),
        map.errors("ours, certified", "radiosity", |p| p.certified_value),
        Some(map.rungs()),
    ];
    let gradient = [
        map.errors("paper's form, corrected", "gradient", |p| p.corrected_gradient),
        map.errors("our closed form", "gradient", |p| p.closed_form_gradient),
        map.errors("ours, certified", "gradient", |p| p.certified_gradient),
        map.errors("stated bound, radiosity", "bound on the radiosity", |p| Some(p.value_bound)),
        map.errors("stated bound, gradient", "bound on the gradient", |p| Some(p.gradient_bound)),
    ];
    let row = |title, panels: [Option<String>; 5]| Row { title, panels: panels.into_iter().flatten().collect() };
    Some(Group {
        id: format!("{}-{}", plane.name(), emitted.name()),
        title: format!(
            "{}, {} emission",
            ["Distance and height", "Angle and width of a needle", "Angle and visible sliver", "Scale and distance"][number],
            emitted.name()
        ),
        reading: if is_constant { reading(plane) } else { "" },
        rows: vec![row("Radiosity", value), row("Gradient, and the bounds stated with the answers", gradient)],
    })
}

const fn reading(plane: Plane) -> &'static str {
    match plane {
        Plane::DistanceHeight => {
            "The receiver is moved aside of the emitter's middle and lifted over its plane. Lower left: almost touching. Right: \
             far away, where near-equal terms cancel. Below the diagonal: grazing. The receiver looks at the emitter, a little askew."
        }
        Plane::AngleWidth => {
            "A needle one length long is seen from 1.5 lengths away, at an angle over its plane. Lower left: a \
             thread seen edge-on."
        }
        Plane::AngleSliver => {
            "The receiver's horizon hides all of the emitter but one corner, which rises over it by the angle on the upright \
             axis. The form of the paper is given the part above the horizon, cut in double precision."
        }
        Plane::ScaleDistance => {
            "All lengths are multiplied by a power of two, which changes no digit of the exact answer. Single precision leaves \
             its range near 2\u{207b}\u{2076}\u{2070} and 2\u{2076}\u{2070}; what normalises its lengths sees no scale at all."
        }
    }
}

/// The points of a map with its axes.
struct Map<'a> {
    plane: Plane,
    columns: usize,
    points: Vec<&'a Point>,
}

impl Map<'_> {
    /// A panel of errors; none if the way is not meant for the map.
    fn errors(&self, way: &str, what: &str, error: impl Fn(&Point) -> Option<f64>) -> Option<String> {
        let errors: Vec<f64> = self.points.iter().map(|p| error(p)).collect::<Option<_>>()?;
        let classes: Vec<usize> = errors.iter().map(|&e| class(e)).collect();
        let share = |count: usize| format!("{:.0} %", 100.0 * count as f64 / errors.len() as f64);
        let exact_share = share(errors.iter().filter(|e| **e <= 1e-12).count());
        let lost = share(errors.iter().filter(|e| **e >= 1e-2 || !e.is_finite()).count());
        let largest = errors.iter().copied().fold(0.0, f64::max);
        let description =
            format!("At most 1e-12 at {exact_share} of the points, 1e-2 or more at {lost}; the largest is {largest:.1e}.");
        Some(self.panel(way, &format!("Relative error of the {what}: {way}"), &description, &classes, "h"))
    }

    fn rungs(&self) -> String {
        let rung = |p: &&Point| RUNGS.iter().position(|(name, _)| *name == p.rung).unwrap_or(RUNGS.len());
        let classes: Vec<usize> = self.points.iter().map(rung).collect();
        let shares = RUNGS.iter().enumerate().map(|(rung, (_, name))| {
            let count = classes.iter().filter(|c| **c == rung).count();
            format!("{name} {:.0} %", 100.0 * count as f64 / classes.len() as f64)
        });
        let description = shares.collect::<Vec<_>>().join(", ");
        self.panel("which rung answered", "The rung of the ladder that answered", &description, &classes, "r")
    }

    fn panel(&self, heading: &str, title: &str, description: &str, classes: &[usize], prefix: &str) -> String {
        // Cells overlap by a little: no seam is seen where their edges are rounded.
        const OVERLAP: f64 = 0.3;
        let [x, y] = self.plane.axes();
        let rows = self.points.len() / self.columns;
        let (width, height) = ((RIGHT - LEFT) / self.columns as f64, (BOTTOM - TOP) / rows as f64);
        let mut svg = Svg::new(SIZE.0, SIZE.1);
        svg.text("title small", (LEFT, 15.0), Anchor::Start, heading);
        for class in 0..=NONE {
            let mut path = String::new();
            for (row, cells) in classes.chunks(self.columns).enumerate() {
                let top = BOTTOM - (row + 1) as f64 * height;
                for (start, end) in runs(cells, class) {
                    let (left, across) = (LEFT + start as f64 * width, (end - start) as f64 * width);
                    let across = if end < self.columns { across + OVERLAP } else { across };
                    let height = if row > 0 { height + OVERLAP } else { height };
                    path +=
                        &format!("M{} {}h{}v{}h-{}z", number(left), number(top), number(across), number(height), number(across));
                }
            }
            svg.path(&format!("{prefix}{class} cell"), &path);
        }
        // A cell stands about its point: the ends of the axes are half a cell inside.
        let shown = |axis: radgrad_audit::comparison::stability::Axis, [start, end]: [f64; 2], cell: f64| Axis {
            base: axis.base,
            exponents: axis.ends,
            places: [start + (end - start).signum() * cell / 2.0, end - (end - start).signum() * cell / 2.0],
        };
        let across = shown(x, [LEFT, RIGHT], width);
        for (place, label) in across.ticks(4.0) {
            svg.line("axis", (place, BOTTOM), (place, BOTTOM + 3.0));
            svg.text("tick", (place, BOTTOM + 13.0), Anchor::Middle, &label);
        }
        shown(y, [BOTTOM, TOP], height).draw_left(&mut svg, LEFT, 4.0, "tick");
        svg.rectangle("frame", (LEFT, TOP), (RIGHT - LEFT, BOTTOM - TOP));
        svg.text("label", (SIZE.0 / 2.0 + 6.0, BOTTOM + 29.0), Anchor::Middle, x.title);
        svg.text_upward("label", (9.0, (TOP + BOTTOM) / 2.0), y.title);
        svg.finish("plot", title, description)
    }
}

/// The runs of cells that are of a class, each from and to before.
fn runs(cells: &[usize], class: usize) -> Vec<(usize, usize)> {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for (index, _) in cells.iter().enumerate().filter(|(_, c)| **c == class) {
        match runs.last_mut() {
            Some((_, end)) if *end == index => *end += 1,
            _ => runs.push((index, index + 1)),
        }
    }
    runs
}

fn class(error: f64) -> usize {
    if error.is_finite() { CLASSES.iter().position(|(end, _)| error <= *end).unwrap_or(NONE) } else { NONE }
}

/// The classes with their colours.
pub(super) fn legend() -> String {
    let swatches = CLASSES.iter().enumerate().map(|(class, (_, name))| {
        let name = if class == 0 || class == 8 { (*name).to_owned() } else { format!("to {name}") };
        swatch(&format!("h{class}"), &name)
    });
    swatches.chain([swatch(&format!("h{NONE}"), "no answer, or not a number")]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_cover_the_cells_of_a_class() {
        assert_eq!(runs(&[0, 1, 1, 0, 1], 1), [(1, 3), (4, 5)]);
        assert_eq!(runs(&[0, 0], 1), []);
    }

    #[test]
    fn classes_hold_what_is_at_their_end_and_what_is_no_number_is_apart() {
        assert_eq!([0.0, 1e-14, 1.1e-14, 1.0, 2.0].map(class), [0, 0, 1, 7, 8]);
        assert_eq!([f64::NAN, f64::INFINITY].map(class), [NONE; 2]);
    }
}
