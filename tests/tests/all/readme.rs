//! README is short, and its figures are those that are recorded.

use std::collections::HashMap;

use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, evaluate};

const README: &str = include_str!("../../../README.md");
const ERRORS: &str = include_str!("../../../data/tables/errors.csv");

#[test]
fn readme_has_at_most_a_thousand_words() {
    let words = README.split_whitespace().count();
    assert!(words <= 1000, "{words}");
}

/// The tables hold decades: `<1e-13` is a worst error below that and not below a tenth of it.
#[test]
fn accuracies_of_readme_lie_in_the_recorded_decades() {
    let mut worst = HashMap::new();
    for line in ERRORS.lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let [family, quantity, _, _, _, decade, _] = fields[..] else { panic!("{line}") };
        worst.insert((family, quantity), decade.trim_start_matches('<').parse::<f64>().unwrap());
    }
    let table = README.split("| family | value | gradient |").nth(1).unwrap();
    let rows: Vec<&str> = table.lines().skip(2).take_while(|line| line.starts_with('|')).collect();
    assert!(rows.len() >= 6, "{rows:?}");
    for row in rows {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        let family = cells[1].split('`').nth(1).unwrap();
        for (quantity, stated) in [("value", cells[2]), ("gradient", cells[3])] {
            let (stated, decade): (f64, f64) = (stated.parse().unwrap(), worst[&(family, quantity)]);
            assert!(stated <= decade && stated >= 0.1 * decade, "{family}, {quantity}: {stated:e}, recorded below {decade:e}");
        }
    }
}

#[test]
fn the_example_of_readme_prints_what_is_stated() {
    let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
    let polygon = Polygon::new(corners.to_vec()).unwrap();
    let lamp = Emitter::new(polygon, Emission::at_vertices(vec![1.0, 2.0, 3.0, 2.0])).unwrap();
    let floor = Receiver::new(DVec3::ZERO, DVec3::Z, 0.8).unwrap();
    let answer = evaluate(&floor, &lamp, &[]).unwrap();
    let printed = format!("{:.15} +- {:.0e}, gradient {:.12}", answer.radiosity, answer.radiosity_error, answer.gradient);
    assert!(README.contains(&printed), "{printed}");
}
