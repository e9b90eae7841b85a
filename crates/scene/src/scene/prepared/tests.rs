//! Scenes that are moved, scaled, refused and warned of.

use super::*;

/// Faces with these names and vertices, of a material that glows or not.
fn scene(faces: &[(&str, bool, Vec<[f64; 3]>)]) -> Scene {
    let mut scene = Scene::new(["grey"]).unwrap();
    let dull = scene.add_material("dull", [0.5], [0.0]).unwrap();
    let lamp = scene.add_material("lamp", [0.5], [1.0]).unwrap();
    for (name, glows, vertices) in faces {
        let surface = scene.add_surface(*name);
        let polygon = Polygon::new(vertices.iter().copied().map(DVec3::from).collect()).unwrap();
        scene.add_face(surface, if *glows { lamp } else { dull }, polygon, None).unwrap();
    }
    scene
}

/// A horizontal square that faces up.
fn level(low: f64, high: f64, z: f64) -> Vec<[f64; 3]> {
    vec![[low, low, z], [high, low, z], [high, high, z], [low, high, z]]
}

fn reversed(mut outline: Vec<[f64; 3]>) -> Vec<[f64; 3]> {
    outline.reverse();
    outline
}

fn moved(outline: &[[f64; 3]], by: impl Fn(f64) -> f64) -> Vec<[f64; 3]> {
    outline.iter().map(|v| v.map(&by)).collect()
}

fn messages(scene: &Scene) -> Vec<String> {
    Prepared::new(scene).unwrap().warnings.iter().map(ToString::to_string).collect()
}

#[test]
fn a_scene_near_the_origin_stays_and_one_far_away_is_moved_exactly() {
    let (floor, ceiling) = (level(0.0, 1.0, 0.0), reversed(level(0.0, 1.0, 1.0)));
    let here = scene(&[("floor", false, floor.clone()), ("ceiling", true, ceiling.clone())]);
    let ready = Prepared::new(&here).unwrap();
    assert_eq!((&ready.scene, ready.warnings.len()), (&here, 0));
    for shift in [1e3, 1e9, 1e12, 1e15] {
        let there = |outline: &[[f64; 3]]| moved(outline, |x| x + shift);
        let far = scene(&[("floor", false, there(&floor)), ("ceiling", true, there(&ceiling))]);
        let ready = Prepared::new(&far).unwrap();
        for (polygon, outline) in ready.scene.polygons().zip([&floor, &ceiling]) {
            let centred: Vec<DVec3> = moved(outline, |x| x - 0.5).into_iter().map(DVec3::from).collect();
            assert_eq!(polygon.vertices(), centred);
        }
        let corner = DVec3::splat(1.0 + shift);
        assert_eq!(ready.placement.inward(corner), DVec3::splat(0.5));
        assert_eq!(ready.placement.outward(DVec3::splat(0.5)), corner);
        // Doubles near 1e9 are 2^-23 apart and more.
        let is_coarse = ready.warnings.iter().any(|warning| matches!(warning, Warning::Coarse { .. }));
        assert_eq!(is_coarse, shift >= 1e9, "{shift}");
    }
}

#[test]
fn an_extraordinary_unit_is_changed_by_a_power_of_two() {
    let (floor, ceiling) = (level(0.0, 1.0, 0.0), reversed(level(0.0, 1.0, 1.0)));
    for exponent in [-1030, -700, -520, -100, -30, 0, 30, 100, 520, 700, 1023] {
        let scaled = |outline: &[[f64; 3]]| moved(outline, |x| libm::ldexp(x, exponent));
        let of_unit = scene(&[("floor", false, scaled(&floor)), ("ceiling", true, scaled(&ceiling))]);
        let ready = Prepared::new(&of_unit).unwrap();
        let size = ready.scene.bounds().unwrap().1.x;
        // Powers of two end at 2^1000.
        let expected = match exponent {
            -64..=64 => libm::ldexp(1.0, exponent),
            -999..=999 => 0.5,
            _ => libm::ldexp(1.0, exponent - exponent.signum() * 1000),
        };
        assert_eq!(size, expected, "2^{exponent}");
        assert_eq!(ready.placement.outward(DVec3::splat(size)), DVec3::splat(libm::ldexp(1.0, exponent)));
    }
    let sizes = scene(&[("huge", true, level(0.0, 1e300, 0.0)), ("tiny", false, level(1.0, 1.5, 1e-30))]);
    let error = Prepared::new(&sizes).unwrap_err().to_string();
    assert!(error.contains("face 1 of `tiny`: vertex 0") && error.contains("too different sizes"), "{error}");
}

#[test]
fn faces_that_overlap_in_one_plane_are_refused_by_name() {
    let overlaps = |first: Vec<[f64; 3]>, second: Vec<[f64; 3]>| {
        Prepared::new(&scene(&[("lamp", true, reversed(level(-1.0, 2.0, 3.0))), ("floor", false, first), ("rug", false, second)]))
    };
    let floor = || level(0.0, 1.0, 0.0);
    for (rug, share) in
        [(floor(), 100.0), (level(0.25, 0.75, 0.0), 100.0), (level(0.5, 1.5, 0.0), 25.0), (level(-1.0, 2.0, 0.0), 100.0)]
    {
        let error = overlaps(floor(), rug).unwrap_err().to_string();
        let names = "face 1 of `floor` and face 2 of `rug` overlap in one plane around (0.";
        assert!(error.starts_with(names) && error.contains(&format!("on {share:.3} % of the smaller")), "{error}");
    }
    // Level up to rounding, and in a slanted plane whose coordinates round.
    assert!(overlaps(floor(), level(0.25, 0.75, 1e-16)).is_err());
    let slanted = |outline: Vec<[f64; 3]>| outline.iter().map(|[x, y, _]| [0.6 * x, *y, 0.8 * x + 0.1 * y]).collect::<Vec<_>>();
    assert!(overlaps(slanted(floor()), slanted(level(0.3, 0.7, 0.0))).is_err());
    // Notched, so that their hulls overlap and they do not; and moved so that they do.
    let l = [[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]].map(|[x, y]| [x, y, 0.0]).to_vec();
    assert!(overlaps(l.clone(), level(1.0, 3.0, 0.0)).is_ok());
    assert!(overlaps(l, level(0.9, 3.0, 0.0)).is_err());
    // Far away and in another unit as well.
    for by in [|x: f64| x + 1e10, |x: f64| x * 2f64.powi(600), |x: f64| x * 1e-200] {
        let faces =
            [("lamp", true, reversed(level(-1.0, 2.0, 3.0))), ("floor", false, floor()), ("rug", false, level(0.25, 0.75, 0.0))];
        let error = Prepared::new(&scene(&faces.map(|(name, glows, outline)| (name, glows, moved(&outline, by))))).unwrap_err();
        assert!(
            matches!(&error, Error::Overlap { pairs, .. } if pairs.iter().any(|pair| (pair.share - 1.0).abs() < 1e-9)),
            "{error}"
        );
    }
}

#[test]
fn faces_that_meet_stand_before_each_other_or_back_to_back_are_not_refused() {
    let lamp = || ("lamp", true, reversed(level(-1.0, 2.0, 3.0)));
    let floor = || ("floor", false, level(0.0, 1.0, 0.0));
    let with = |outline: Vec<[f64; 3]>| Prepared::new(&scene(&[lamp(), floor(), ("other", false, outline)])).map(|_| ());
    // A rug over the floor, the floor's back, a wall through it, a neighbour, and one beside a part of its edge.
    assert_eq!(with(level(0.25, 0.75, 1e-6)), Ok(()));
    assert_eq!(with(reversed(level(0.0, 1.0, 0.0))), Ok(()));
    assert_eq!(with(vec![[0.5, -1.0, -1.0], [0.5, 2.0, -1.0], [0.5, 2.0, 1.0], [0.5, -1.0, 1.0]]), Ok(()));
    assert_eq!(with(level(1.0, 2.0, 0.0)), Ok(()));
    assert_eq!(with(vec![[1.0, 0.3, 0.0], [2.0, 0.3, 0.0], [2.0, 0.7, 0.0], [1.0, 0.7, 0.0]]), Ok(()));
    // Triangles of a fan with a vertex of rounded coordinates on the diagonal between them.
    let middle = [1.0 / 3.0, 0.7 / 3.0, 0.0];
    let fan = [
        ("a", vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.7, 0.0]]),
        ("b", vec![[0.0, 0.0, 0.0], middle, [0.0, 0.7, 0.0]]),
        ("c", vec![middle, [1.0, 0.7, 0.0], [0.0, 0.7, 0.0]]),
    ];
    let mut faces = vec![lamp()];
    faces.extend(fan.map(|(name, outline)| (name, false, outline)));
    assert!(Prepared::new(&scene(&faces)).is_ok());
}

#[test]
fn what_only_hides_may_lie_in_the_plane_of_a_wall() {
    let mut scene = scene(&[("floor", true, level(0.0, 1.0, 0.0)), ("ceiling", false, reversed(level(0.0, 1.0, 1.0)))]);
    let screen = scene.add_obstruction("screen");
    scene.add_face(screen, 0, Polygon::new(level(0.0, 1.0, 0.0).into_iter().map(DVec3::from).collect()).unwrap(), None).unwrap();
    assert!(Prepared::new(&scene).is_ok());
}

#[test]
fn many_faces_are_compared_in_nearly_linear_time() {
    // A floor of 100 x 100 tiles under as large a ceiling.
    let tile = |i: u32, j: u32| {
        let (x, y) = (f64::from(i), f64::from(j));
        vec![[x, y, 0.0], [x + 1.0, y, 0.0], [x + 1.0, y + 1.0, 0.0], [x, y + 1.0, 0.0]]
    };
    let mut faces: Vec<_> = (0..100).flat_map(|i| (0..100).map(move |j| ("tile", false, tile(i, j)))).collect();
    faces.push(("ceiling", true, reversed(level(0.0, 100.0, 3.0))));
    assert!(Prepared::new(&scene(&faces)).is_ok());
    faces.push(("twice", false, tile(31, 7)));
    let error = Prepared::new(&scene(&faces)).unwrap_err().to_string();
    assert!(error.starts_with("face 3107 of `tile` and face 10001 of `twice` overlap"), "{error}");
}

#[test]
fn what_is_probably_not_meant_is_said() {
    let floor = || ("floor", false, level(0.0, 1.0, 0.0));
    let lamp = |z: f64| ("lamp", true, reversed(level(0.25, 0.75, z)));
    assert_eq!(messages(&scene(&[floor(), lamp(1.0)])), [""; 0]);
    let dark = messages(&scene(&[floor(), ("ceiling", false, reversed(level(0.0, 1.0, 1.0)))]));
    assert!(dark.len() == 1 && dark[0].contains("no lamp"), "{dark:?}");
    // A lamp wound the other way, under a ceiling that the floor sees.
    let ceiling = || ("ceiling", false, reversed(level(0.0, 1.0, 1.0)));
    let turned = messages(&scene(&[floor(), ceiling(), ("lamp", true, level(0.25, 0.75, 2.0))]));
    assert!(
        turned.len() == 1 && turned[0].starts_with("lamps that light nothing") && turned[0].ends_with(": `lamp`"),
        "{turned:?}"
    );
    let outside = messages(&scene(&[floor(), lamp(1.0), ("roof", false, level(0.0, 1.0, 2.0))]));
    assert!(
        outside.len() == 1 && outside[0].starts_with("surfaces that see nothing") && outside[0].ends_with(": `roof`"),
        "{outside:?}"
    );
    let inside_out =
        messages(&scene(&[("floor", true, reversed(level(0.0, 1.0, 0.0))), ("ceiling", false, level(0.0, 1.0, 1.0))]));
    assert!(inside_out.len() == 1 && inside_out[0].contains("turned inside out"), "{inside_out:?}");
}
