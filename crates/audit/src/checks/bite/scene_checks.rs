//! Checks of form factors, of solutions and of whole scenes.

use radgrad_oracle::scene::Effort;
use radgrad_solver::Marking;
use rayon::prelude::*;

use super::{Setting, named};
use crate::cases::sampler::Sampler;
use crate::checks::{exchanges, hidden, screens};
use crate::scenes;

/// Exchanges with nothing in between, of edges and polygons.
pub(super) fn free_exchanges(_: &Setting<'_>) -> Vec<String> {
    let lines: Vec<&str> = exchanges::edges().collect();
    let mut findings: Vec<String> = lines.par_iter().flat_map_iter(|line| exchanges::of_edges(line)).collect();
    let drawn = (0..40u64).into_par_iter().flat_map_iter(|index| [exchanges::of_pair(index), exchanges::of_tetrahedron(index)]);
    findings.extend(drawn.flatten_iter().collect::<Vec<_>>());
    findings.extend(exchanges::of_shortest_edges());
    findings
}

/// Factors past drawn screens.
pub(super) fn past_screens(_: &Setting<'_>) -> Vec<String> {
    let drawn = |index: u64| {
        let pairs = (index < 1).then(|| [screens::of_complements(index), screens::of_nothing()]).into_iter().flatten();
        let asked = [screens::of_drawn(index), screens::of_shares(index), screens::of_corners(index)].into_iter().chain(pairs);
        asked.flat_map(|said| said.unwrap_or_else(|error| vec![error])).collect::<Vec<_>>()
    };
    (0..11u64).into_par_iter().flat_map_iter(drawn).collect()
}

/// The index: faces in beams and along rays.
pub(super) fn in_beams(_: &Setting<'_>) -> Vec<String> {
    let asked = |index: u64| {
        let city = (index < 8).then(|| hidden::of_city(index).unwrap_or_else(|error| vec![error]));
        let horizons = (10 * index..10 * index + 10).flat_map(hidden::of_horizon).collect();
        [hidden::of_beam(index), hidden::of_rays(index), hidden::of_starts(index), horizons]
            .into_iter()
            .chain(city)
            .flatten()
            .collect::<Vec<_>>()
    };
    (0..80u64).into_par_iter().flat_map_iter(asked).collect()
}

/// Form factors of pairs of faces, many of them, against rays.
pub(super) fn brackets(_: &Setting<'_>) -> Vec<String> {
    use scenes::family::Family as Scenes;
    let families = [Scenes::Clutter, Scenes::Slit, Scenes::Touching, Scenes::Open, Scenes::Grating, Scenes::Downlight];
    let brackets = scenes::brackets::Brackets::measure(&families, 120, 13, |_, _| ());
    brackets.outside.iter().map(|outside| format!("{}: {}", outside.name, outside.said)).collect()
}

/// The pieces of solutions, each by itself.
pub(super) fn pieces(_: &Setting<'_>) -> Vec<String> {
    use scenes::pieces::cuts::{partitions, shadow_lines};
    use scenes::pieces::hidden::{sights, unseen, views};
    use scenes::pieces::textures::{gathers, projections, textures};
    use scenes::pieces::{rules, transfers};
    let told = [transfers(12), views(8), unseen(24), textures(12)];
    [told.concat(), sights(24), gathers(12), shadow_lines(18), partitions(4), projections(8), rules()].concat()
}

/// Solutions and certificates with light in another unit and channels in another order.
pub(super) fn alike(_: &Setting<'_>) -> Vec<String> {
    use scenes::family::Family as Scenes;
    let families = [Scenes::Facing, Scenes::Downlight, Scenes::Slit, Scenes::Touching];
    let findings_of = |(index, &family): (usize, &Scenes)| {
        let name = scenes::family::Name { family, seed: 31, index: 1 };
        let mut model = name.model();
        model.colour(&mut Sampler::new(31, "alike", 0));
        model.ways.marking = if index.is_multiple_of(2) { Marking::Residual } else { Marking::Gradient };
        let wrong = scenes::alike::in_other_channels(&model).unwrap_or_else(|error| vec![error]);
        named(name, wrong)
    };
    families.par_iter().enumerate().flat_map_iter(findings_of).collect()
}

/// Rays for the truth of a scene.
const RAYS: usize = 8_000;

/// A few scenes, every bound of `solve`, `factors` and `field`.
pub(super) fn whole_scenes(_: &Setting<'_>) -> Vec<String> {
    use scenes::family::Family as Scenes;
    let effort = Effort { rays: RAYS, rays_a_point: RAYS, ..scenes::truth::EFFORT };
    let families = [
        Scenes::Facing,
        Scenes::Furnace,
        Scenes::Downlight,
        Scenes::Slit,
        Scenes::Touching,
        Scenes::Open,
        Scenes::Groove,
        Scenes::Plates,
        Scenes::Overlap,
        Scenes::Rounded,
        Scenes::Nested,
    ];
    let table = scenes::table::Table::measure(&families, families.len() as u64, 11, &effort, |_, _| ());
    let findings_of = |violation: &scenes::table::Violation| {
        let first = violation.faults.first().map_or("", String::as_str);
        format!("{}: {}: {first}", violation.name, violation.subject.name())
    };
    let mut findings: Vec<String> = table.violations.iter().map(findings_of).collect();
    // No gate forbids an estimate that is off now and then; of these scenes none is.
    let off = table.statements.iter().filter(|(_, judged)| judged.verdict == scenes::judge::Verdict::Off);
    findings.extend(off.map(|(name, judged)| {
        let statement = &judged.statement;
        format!("{name}: {}: {:e}, estimated to {:e}, is off", statement.of.name(), statement.value, statement.stated.size())
    }));
    if table.judged() == 0 {
        findings.push("no bound of a scene was judged".to_owned());
    }
    findings
}
