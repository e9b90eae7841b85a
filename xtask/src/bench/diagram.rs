//! Work-precision diagrams: error over time, both logarithmic, a panel for each emission, a line for each method from coarse to
//! fine. A method with more digits than a double stands in a strip below, by its setting.

use super::marker;
use super::method::Method;
use super::point::Point as Measured;
use super::regime::{Kind, Regime};
use crate::plot::{Anchor, FAINT, INK, Picture, Point, Rgb, Stroke, Type};

/// Room of a panel's axes.
const AXES: Point = (400.0, 400.0);
/// Room of the strip below it.
const STRIP: f64 = 68.0;
const MARGIN_LEFT: f64 = 62.0;
const MARGIN_TOP: f64 = 88.0;
const MARGIN_BOTTOM: f64 = 54.0;
const LEGEND: f64 = 196.0;
const GRID: Rgb = (226, 226, 232);

/// Decades of the time in nanoseconds.
const TIMES: [i32; 2] = [0, 9];
/// Decades of the error.
const ERRORS: [i32; 2] = [-17, 1];

/// A panel: some points under a title.
struct Panel<'a> {
    /// The kind of its cases.
    title: String,
    /// The points.
    points: Vec<&'a Measured>,
}

/// The diagram of a regime: constant beside linear emission.
pub(crate) fn of_regime(regime: Regime, points: &[Measured]) -> Picture {
    let panels = Kind::ALL.map(|kind| Panel {
        title: format!("{} emission", kind.name()),
        points: points.iter().filter(|point| point.kind == kind).collect(),
    });
    draw(regime.title(), &panels)
}

/// That as an SVG file, with a description for those who do not see it.
pub(crate) fn svg_of_regime(regime: Regime, points: &[Measured]) -> String {
    of_regime(regime, points).svg_of(regime.title(), &description(points))
}

/// A description of the diagram, in words.
fn description(points: &[Measured]) -> String {
    let best = |kind: Kind, method: Method| {
        let measured = points.iter().filter(|point| point.kind == kind && point.method == method);
        measured.min_by(|a, b| a.errors.worst().total_cmp(&b.errors.worst()))
    };
    let line = |kind: Kind, method: Method| {
        let point = best(kind, method)?;
        Some(format!("{} {:.0e} in {:.3} \u{b5}s", method.name(), point.errors.worst(), point.time.median * 1e-3))
    };
    let panel = |kind: Kind| {
        let lines: Vec<String> = Method::ALL.into_iter().filter_map(|method| line(kind, method)).collect();
        format!("{} emission: {}", kind.name(), lines.join(", "))
    };
    format!(
        "Relative error over the time of an answer, both logarithmic, a line for each method from coarse to fine. The smallest error of \
         each and its time, with {}; with {}.",
        panel(Kind::Constant),
        panel(Kind::Linear)
    )
}

/// Constant emission in several regimes, side by side.
pub(crate) fn of_front_page(regimes: &[(Regime, Vec<Measured>)]) -> Picture {
    let mut panels = Vec::new();
    for (regime, points) in regimes {
        let points = points.iter().filter(|point| point.kind == Kind::Constant).collect();
        panels.push(Panel { title: regime.label().to_owned(), points });
    }
    draw("Radiosity and gradient of a triangle: run time against error", &panels)
}

/// Panels side by side with their legend.
fn draw(title: &str, panels: &[Panel<'_>]) -> Picture {
    let panel_width = MARGIN_LEFT + AXES.0 + 16.0;
    let width = panel_width * panels.len() as f64;
    let mut picture = Picture::new(width + LEGEND, MARGIN_TOP + AXES.1 + STRIP + MARGIN_BOTTOM);
    picture.text((MARGIN_LEFT, 28.0), title, Type { size: 17, colour: INK, anchor: Anchor::Start });
    let under = "Radiosity and gradient of 16 receivers, batches of 1024, on one thread. Error: the larger of the worst of both, relative to \
                 the oracle's enclosures. Time: median.";
    picture.text((MARGIN_LEFT, 46.0), under, Type { size: 11, colour: FAINT, anchor: Anchor::Start });
    for (index, panel) in panels.iter().enumerate() {
        let frame = Frame { left: MARGIN_LEFT + panel_width * index as f64, top: MARGIN_TOP };
        frame.axes(&mut picture, &panel.title);
        Method::ALL.iter().for_each(|method| frame.series(&mut picture, *method, &panel.points));
    }
    legend(&mut picture, width + 8.0, panels);
    picture
}

/// Where the axes stand.
struct Frame {
    left: f64,
    top: f64,
}

impl Frame {
    fn x(&self, nanoseconds: f64) -> f64 {
        self.left + AXES.0 * fraction(nanoseconds, TIMES)
    }

    fn y(&self, error: f64) -> f64 {
        self.top + AXES.1 * (1.0 - fraction(error, ERRORS))
    }

    fn axes(&self, picture: &mut Picture, title: &str) {
        let label = |anchor| Type { size: 11, colour: INK, anchor };
        let (right, bottom) = (self.left + AXES.0, self.top + AXES.1);
        let floor = bottom + STRIP;
        for decade in TIMES[0]..=TIMES[1] {
            let x = self.x(power_of_ten(decade));
            picture.line(&[(x, self.top), (x, floor)], Stroke::solid(GRID, 0.8));
            picture.text((x, floor + 17.0), &duration(decade), label(Anchor::Middle));
        }
        for decade in (ERRORS[0]..=ERRORS[1]).filter(|decade| decade % 2 == 0) {
            let y = self.y(power_of_ten(decade));
            picture.line(&[(self.left, y), (right, y)], Stroke::solid(GRID, 0.8));
            picture.text((self.left - 7.0, y + 4.0), &superscript(decade), label(Anchor::End));
        }
        let frame = [(self.left, self.top), (right, self.top), (right, floor), (self.left, floor)];
        picture.outline(&frame, Stroke::solid(INK, 0.9));
        picture.line(&[(self.left, bottom), (right, bottom)], Stroke::dashed(FAINT, 0.9));
        picture.text((self.left - 7.0, bottom + STRIP / 2.0), "finer than", Type { size: 10, ..label(Anchor::End) });
        picture.text((self.left - 7.0, bottom + STRIP / 2.0 + 12.0), "a double", Type { size: 10, ..label(Anchor::End) });
        picture.text((self.left + AXES.0 / 2.0, floor + 36.0), "time an answer", Type { size: 12, ..label(Anchor::Middle) });
        picture.text((self.left - 40.0, self.top - 9.0), "relative error", Type { size: 12, ..label(Anchor::Start) });
        picture.text((right, self.top - 9.0), title, Type { size: 13, ..label(Anchor::End) });
    }

    /// A method's points and the line through them.
    fn series(&self, picture: &mut Picture, method: Method, points: &[&Measured]) {
        let points = points.iter().filter(|point| point.method == method);
        let [top, bottom, latest] = [ERRORS[1], ERRORS[0], TIMES[1]].map(power_of_ten);
        let (inside, beyond): (Vec<&Measured>, Vec<&Measured>) = points.partition(|point| point.errors.worst() >= bottom);
        let place = |point: &Measured| (self.x(point.time.median), self.y(point.errors.worst()));
        for stretch in inside.split(|point| point.errors.worst() >= top || point.time.median > latest) {
            let line: Vec<Point> = stretch.iter().map(|point| place(point)).collect();
            if line.len() > 1 {
                picture.line(&line, Stroke::solid(marker::colour(method), 1.0));
            }
            stretch.iter().for_each(|point| marker::draw(picture, method, place(point), point.given_up > 0));
        }
        for (row, point) in beyond.into_iter().enumerate() {
            let place = (self.x(point.time.median), self.top + AXES.1 + 10.0 + 16.0 * row as f64);
            marker::draw(picture, method, place, point.given_up > 0);
            let label = Type { size: 10, colour: INK, anchor: Anchor::End };
            picture.text((place.0 - 9.0, place.1 + 4.0), &point.setting, label);
        }
    }
}

fn legend(picture: &mut Picture, left: f64, panels: &[Panel<'_>]) {
    let drawn = |method: &&Method| panels.iter().flat_map(|panel| &panel.points).any(|point| point.method == **method);
    let text = Type { size: 12, colour: INK, anchor: Anchor::Start };
    let mut y = MARGIN_TOP + 8.0;
    for method in Method::ALL.iter().filter(drawn) {
        picture.line(&[(left, y), (left + 26.0, y)], Stroke::solid(marker::colour(*method), 1.0));
        marker::draw(picture, *method, (left + 13.0, y), false);
        picture.text((left + 34.0, y + 4.0), method.name(), text);
        y += 22.0;
    }
    let notes = [
        "Lines go from coarse to fine.",
        "Hollow or thin: the method says",
        "itself that it fell short.",
        "Not drawn: errors above 10,",
        "times above a second.",
    ];
    for note in notes {
        y += 15.0;
        picture.text((left, y), note, Type { size: 11, colour: FAINT, anchor: Anchor::Start });
    }
}

/// Place of a figure between two decades, on a logarithmic scale.
fn fraction(figure: f64, [low, high]: [i32; 2]) -> f64 {
    (libm::log10(figure) - f64::from(low)) / f64::from(high - low)
}

fn power_of_ten(decade: i32) -> f64 {
    libm::exp10(f64::from(decade))
}

/// `10^decade` nanoseconds with their unit: `100 ns`, `1 µs`.
fn duration(decade: i32) -> String {
    let units = ["ns", "µs", "ms", "s"];
    let step = (decade.max(0) / 3).min(3);
    let unit = units.get(step as usize).copied().unwrap_or("s");
    format!("{} {unit}", 10u64.pow(u32::try_from(decade - 3 * step).unwrap_or(0)))
}

/// `10^decade` as it is written.
fn superscript(decade: i32) -> String {
    let digit = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '4'..='9' => char::from_u32('⁰' as u32 + c as u32 - '0' as u32).unwrap_or(c),
        _ => '⁰',
    };
    if decade == 0 { "1".to_owned() } else { format!("10{}", decade.to_string().chars().map(digit).collect::<String>()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::clock::Spread;
    use crate::bench::truth::{Errors, Quantity};

    #[test]
    fn decades_carry_their_units() {
        assert_eq!([0, 1, 2, 3, 5, 6, 8, 9].map(duration).join(" "), "1 ns 10 ns 100 ns 1 µs 100 µs 1 ms 100 ms 1 s");
        assert_eq!([-16, -2, 0, 1, 3].map(superscript).join(" "), "10⁻¹⁶ 10⁻² 1 10¹ 10³");
    }

    fn point(kind: Kind, method: Method, error: f64, nanoseconds: f64) -> Measured {
        let quantity = Quantity { median: error, worst: error };
        Measured {
            kind,
            method,
            setting: String::new(),
            errors: Errors { value: quantity, gradient: quantity },
            time: Spread::quartiles(vec![nanoseconds]),
            evaluations: 1.0,
            given_up: 0,
        }
    }

    /// Two points of every method in each panel.
    fn points() -> Vec<Measured> {
        let points_of = |kind: Kind| {
            let of_method = move |(row, method): (usize, Method)| {
                [1e-3, 1e-9].map(|error| point(kind, method, error, 10.0 * (row + 1) as f64))
            };
            Method::ALL.into_iter().enumerate().flat_map(of_method)
        };
        Kind::ALL.into_iter().flat_map(points_of).collect()
    }

    /// Place, height and content of each text.
    fn texts(svg: &str) -> Vec<(f64, f64, String)> {
        let attribute = |tag: &str, name: &str| -> f64 {
            let (_, rest) = tag.split_once(&format!(" {name}=\"")).unwrap();
            rest.split_once('"').unwrap().0.parse().unwrap()
        };
        let text = |part: &str| {
            let (tag, rest) = part.split_once('>').unwrap();
            (attribute(tag, "x"), attribute(tag, "y"), rest.split_once("</text>").unwrap().0.to_owned())
        };
        svg.split("<text").skip(1).map(text).collect()
    }

    #[test]
    fn a_diagram_names_its_axes_its_methods_and_what_it_shows() {
        let svg = svg_of_regime(Regime::Easy, &points());
        let labels = texts(&svg);
        for method in Method::ALL {
            assert_eq!(labels.iter().filter(|(_, _, text)| text == method.name()).count(), 1, "{}", method.name());
            assert!(svg.split_once("<desc>").unwrap().1.split_once("</desc>").unwrap().0.contains(method.name()));
        }
        for (text, count) in [("time an answer", 2), ("relative error", 2), ("1 ns", 2), ("1 s", 2), ("10⁻¹⁶", 2)] {
            assert_eq!(labels.iter().filter(|(_, _, found)| found == text).count(), count, "{text}");
        }
        assert!(svg.contains(&format!("<title>{}</title>", Regime::Easy.title())));
        let without: Vec<Measured> = points().into_iter().filter(|point| point.method != Method::MonteCarlo).collect();
        assert!(!svg_of_regime(Regime::Easy, &without).contains(Method::MonteCarlo.name()));
    }

    #[test]
    fn what_is_beyond_the_axes_is_not_drawn() {
        let drawn = |nanoseconds: f64| {
            let late = [
                point(Kind::Constant, Method::MonteCarlo, 1e-3, 10.0),
                point(Kind::Constant, Method::MonteCarlo, 1e-4, nanoseconds),
            ];
            of_regime(Regime::Easy, &late).svg_of("", "").len()
        };
        assert!(drawn(2e9) < drawn(9e8));
    }

    #[test]
    fn no_two_texts_stand_on_each_other() {
        let labels = texts(&svg_of_regime(Regime::Near2, &points()));
        for (i, (x, y, text)) in labels.iter().enumerate() {
            let on_it = labels[..i].iter().find(|(other_x, other_y, _)| (x - other_x).abs() < 12.0 && (y - other_y).abs() < 9.0);
            assert_eq!(on_it, None, "{text} at ({x}, {y})");
        }
    }

    #[test]
    fn a_decade_is_the_same_length_everywhere() {
        let step = |at: f64| fraction(10.0 * at, TIMES) - fraction(at, TIMES);
        assert!((step(1.0) - step(1e6)).abs() < 1e-15);
        assert_eq!((fraction(1.0, TIMES), fraction(1e9, TIMES)), (0.0, 1.0));
    }
}
