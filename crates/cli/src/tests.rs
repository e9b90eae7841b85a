//! Files that were changed at random: each is read or refused, none is lost, and no more is read than the bytes say.
//!
//! `RADGRAD_MUTANTS` is how many changes of each kind of file are tried.

use std::fs;
use std::path::{Path, PathBuf};

use radgrad_core::{DVec3, Polygon};
use radgrad_scene::{FactorSettings, FormFactors, Scene};
use radgrad_solver::{Next, Options, solve_for};

use crate::factors::kept::Kept;
use crate::points::Points;
use crate::resume;

/// The words that are put in: numbers out of range, ends of texts and words of the formats.
const TOKENS: [&str; 16] = [
    "nan",
    "-1",
    "1e999",
    "-0.0",
    "18446744073709551616",
    "4294967295",
    "null",
    "\"",
    "{",
    "[",
    "]",
    ",",
    "\n",
    "\0",
    "\u{feff}",
    "#",
];

/// Numbers of xorshift (G. Marsaglia 2003).
struct Random(u64);

impl Random {
    fn below(&mut self, count: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        usize::try_from(self.0 >> 33).unwrap() % count.max(1)
    }

    /// A text with up to four changes.
    fn changed(&mut self, seed: &[u8]) -> Vec<u8> {
        let mut text = seed.to_vec();
        for _ in 0..=self.below(4) {
            let (a, b) = (self.below(text.len() + 1), self.below(text.len() + 1));
            let part = a.min(b)..a.max(b).min(a.min(b) + 40);
            match self.below(6) {
                0 => drop(text.drain(part)),
                1 => {
                    let copy = text[part].to_vec();
                    drop(text.splice(b..b, copy));
                }
                2 => drop(text.splice(a..a, TOKENS[self.below(TOKENS.len())].bytes())),
                3 => drop(text.splice(part, TOKENS[self.below(TOKENS.len())].bytes())),
                4 => text.truncate(a.max(text.len() / 2)),
                _ if a < text.len() => text[a] ^= 1 << self.below(8),
                _ => {}
            }
        }
        text
    }
}

/// A file of a test's own, in a folder where nothing else may be left.
struct Lone(PathBuf);

impl Lone {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("radgrad-changed-{name}-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        Self(folder)
    }

    /// Changes a file again and again; `check` gets its name, and its content before and says whether that may be another afterwards.
    fn under_fire(&self, seed: &[u8], mut check: impl FnMut(&Path, &[u8]) -> bool) {
        let count = std::env::var("RADGRAD_MUTANTS").ok().and_then(|count| count.parse().ok()).unwrap_or(500);
        let (file, mut random) = (self.0.join("changed"), Random(0x9e37_79b9_7f4a_7c15));
        for _ in 0..count {
            let text = random.changed(seed);
            fs::write(&file, &text).unwrap();
            if !check(&file, &text) {
                assert!(fs::read(&file).unwrap() == text, "a file that is refused or only read stays as it is");
            }
            assert_eq!(fs::read_dir(&self.0).unwrap().count(), 1, "nothing else is left beside it");
        }
    }
}

impl Drop for Lone {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// A lamp over a floor.
fn scene() -> Scene {
    let mut scene = Scene::new(["grey"]).unwrap();
    for (name, height, radiance) in [("floor", 0.0, 0.0), ("lamp", 1.0, 1.0), ("wall", 0.5, 0.0)] {
        let material = scene.add_material(name, [0.5], [radiance]).unwrap();
        let surface = scene.add_surface(name);
        let mut corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec3::new(x, y, height)).to_vec();
        if height > 0.0 {
            corners.reverse();
        }
        if name == "wall" {
            corners.iter_mut().for_each(|corner| *corner = DVec3::new(1.0 + 0.0 * corner.x, corner.y, corner.x));
        }
        scene.add_face(surface, material, Polygon::new(corners).unwrap(), None).unwrap();
    }
    scene
}

#[test]
fn points_are_read_or_refused_line_by_line() {
    let seeds = [
        "id,x,y,z,nx,ny,nz\na,0,0,0.75,0,0,1\n\"b, c\",1e-3,0.5,0.75,0,0,1\n# none\n",
        "0 0 .75 0 0 1\n1;0;0.75;0;0;1\n\n0.5,0.5,0.5,0,1,0\n",
        "{\"id\":7,\"position\":[0,0,0.75],\"normal\":[0,0,1]}\n{\"position\":[0.5,0.5,0],\"normal\":[0,0,1],\"on\":\"face\"}\n",
    ];
    let lone = Lone::new("points");
    for seed in seeds {
        lone.under_fire(seed.as_bytes(), |file, text| {
            let lines = text.iter().filter(|byte| **byte == b'\n').count() + 1;
            assert!(text.is_empty() || Points::read(file, text.len() as u64 - 1).is_err(), "a byte too many");
            if let Ok(points) = Points::read(file, 1 << 20) {
                assert!(points.places().count() <= lines);
            }
            false
        });
    }
}

#[test]
fn a_file_of_solve_resume_is_taken_up_or_refused() {
    let (scene, lone) = (scene(), Lone::new("solve"));
    let run = resume::Run { scene: resume::fingerprint(&scene), squares: false };
    let seed = format!("{{\"scene\":\"{}\",\"divisions\":[0,1,2,3,4,5]}}\n", run.scene);
    let options = Options { error: 1.0, most_elements: 50, ..Options::default() };
    lone.under_fire(seed.as_bytes(), |file, text| {
        if let Ok(divisions) = resume::read(file, &run, 1 << 20) {
            assert!(divisions.len() <= text.len());
            // Whatever elements it names.
            let solved = solve_for(&scene, &options, &divisions, &[], |_| Next::from(false));
            assert!(solved.is_err() || solved.is_ok_and(|solution| solution.mean()[0].is_finite()));
        }
        false
    });
}

#[test]
fn rows_of_factors_resume_are_taken_up_or_refused() {
    let (scene, lone) = (scene(), Lone::new("factors"));
    let factors = FormFactors::new(&scene).unwrap();
    let (rows, settings) = (factors.faces().len(), FactorSettings::default());
    let open = |file: &Path| Kept::open(file, "scene", "settings".to_owned());
    let file = lone.0.join("changed");
    let (kept, _) = open(&file).unwrap();
    let matrix = factors.rows_from(0..rows, &settings, Vec::new(), |row| kept.keep(row)).unwrap();
    kept.close().unwrap();
    let seed = fs::read(&file).unwrap();
    lone.under_fire(&seed, |file, text| {
        let Ok((kept, computed)) = open(file) else { return false };
        assert!(computed.len() <= text.len());
        kept.close().unwrap();
        let after = fs::read(file).unwrap();
        // The end of a line that a kill left is taken off, and a head that was not whole is written.
        let whole = text.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
        assert!(after == text[..whole] || whole == 0 && seed.starts_with(&after), "only what has no end is taken off");
        let answer = factors.rows_from(0..rows, &settings, computed, |_| ());
        assert!(answer.is_err() || answer.is_ok_and(|answer| answer.entries().count() <= matrix.entries().count()));
        true
    });
}

#[cfg(feature = "audit")]
#[test]
fn gates_are_read_or_refused() {
    use radgrad_audit::checks::foreign::Gates;

    let seed = "[all]\nvalue = 1e-6\ngradient = 1e-5 # larger\nvalue_over_bound = 1.0\n[far]\nvalue = 0.5\n";
    Lone::new("gates").under_fire(seed.as_bytes(), |_, text| {
        if let Ok(text) = std::str::from_utf8(text) {
            let said = Gates::from_toml(text).map_or_else(|error| error.to_string(), |gates| format!("{gates:?}"));
            assert!(said.len() <= 1000 + 8 * text.len(), "{said}");
        }
        false
    });
}
