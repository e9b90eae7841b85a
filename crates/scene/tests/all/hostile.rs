//! Readers under fire: files that were changed at random, and rules that hold for each result.
//!
//! The seed is fixed, so that every run tries the same files; `RADGRAD_MUTANTS` sets how many of each kind.

mod rules;

use std::path::Path;

use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use radgrad_scene::case::Line;
use radgrad_scene::{Degenerate, gltf, obj, view3d};

use rules::{MTL, beside, is_shown, judge, png};

// The seeds of the fuzz targets.
const OBJ: &str = include_str!("../../../../fuzz/seeds/obj/room.obj");
const VS3: &str = include_str!("../../../../fuzz/seeds/vs3/room.txt");
const GLTF: &str = include_str!("../../../../fuzz/seeds/gltf/room.gltf");
const LINE: &str = include_str!("../../../../fuzz/seeds/eval/case.jsonl");

/// Text that strangers put into files.
const TOKENS: [&[u8]; 20] = [
    b"1e308",
    b"-1e308",
    b"1e-320",
    b"nan",
    b"inf",
    b"18446744073709551615",
    b"-9223372036854775808",
    b"0",
    b"-1",
    b"\n",
    b"\r",
    b"\\\n",
    b"#",
    b"\xef\xbb\xbf",
    b"\xff",
    b"\x1b[2J",
    b"/",
    b"{}",
    b"[[[[",
    b",",
];

/// One change: its kind, its place (a share of the length) and the byte, token or length for it.
type Change = (u8, f64, u8, f64);

#[allow(clippy::cast_possible_truncation, reason = "a share of a length is one")]
fn changed(seed: &[u8], changes: &[Change]) -> Vec<u8> {
    let mut file = seed.to_vec();
    for &(kind, at, byte, other) in changes {
        let place = |share: f64| ((file.len() as f64 * share) as usize).min(file.len());
        let (at, other) = (place(at), place(other));
        let (low, high) = (at.min(other), at.max(other));
        match kind {
            0 if at < file.len() => file[at] = byte,
            1 => file.insert(at, byte),
            2 => drop(file.drain(low..high.min(low + 40))),
            3 => drop(file.splice(at..at, TOKENS[usize::from(byte) % TOKENS.len()].iter().copied())),
            4 => {
                let part = file[low..high].to_vec();
                drop(file.splice(other..other, part));
            }
            5 => file.truncate(at.max(file.len() / 2)),
            _ if at < file.len() => file[at] ^= 1 << (byte % 8),
            _ => {}
        }
    }
    file
}

/// Tries as many changes of a file as are asked for.
fn under_fire(seed: &[u8], check: impl Fn(&[u8])) {
    let cases = std::env::var("RADGRAD_MUTANTS").ok().and_then(|count| count.parse().ok()).unwrap_or(1000);
    let config = Config { cases, failure_persistence: None, ..Config::default() };
    let mut runner = TestRunner::new_with_rng(config, TestRng::from_seed(RngAlgorithm::ChaCha, &[22; 32]));
    let changes = prop::collection::vec((0..7_u8, 0.0..1.0, any::<u8>(), 0.0..1.0), 0..6);
    let tried = runner.run(&changes, |changes| {
        check(&changed(seed, &changes));
        Ok(())
    });
    tried.unwrap();
}

#[test]
fn obj_mtl_and_png_are_read_or_refused() {
    let png = png();
    under_fire(OBJ.as_bytes(), |file| {
        judge(|reading| obj::parse(file, Path::new("a.obj"), reading, beside(MTL.as_bytes(), &png)));
    });
    under_fire(MTL.as_bytes(), |library| {
        judge(|reading| obj::parse(OBJ.as_bytes(), Path::new("a.obj"), reading, beside(library, &png)));
    });
    under_fire(&png, |texture| {
        judge(|reading| obj::parse(OBJ.as_bytes(), Path::new("a.obj"), reading, beside(MTL.as_bytes(), texture)));
    });
}

#[test]
fn gltf_is_read_or_refused() {
    let png = png();
    under_fire(GLTF.as_bytes(), |file| judge(|reading| gltf::parse(file, Path::new("a.gltf"), reading, beside(b"", &png))));
    let json = GLTF.as_bytes();
    let length = |count: usize| u32::try_from(count).unwrap().to_le_bytes();
    let binary = [b"glTF\x02\0\0\0".as_slice(), &length(20 + json.len()), &length(json.len()), b"JSON", json].concat();
    under_fire(&binary, |file| judge(|reading| gltf::parse(file, Path::new("a.glb"), reading, beside(b"", &png))));
}

#[test]
fn view3d_is_read_or_refused() {
    under_fire(VS3.as_bytes(), |file| judge(|reading| view3d::parse(file, Path::new("a.vs3"), reading)));
}

#[test]
fn lines_of_eval_are_read_or_refused() {
    under_fire(LINE.as_bytes(), |text| match Line::read(1, text) {
        None => {}
        Some(Ok(line)) => drop(line.case.problem()),
        Some(Err(refusal)) => assert!(is_shown(&refusal.error.to_string()), "{refusal:?}"),
    });
}

#[test]
fn what_the_files_are_before_any_change_is_read() {
    let png = png();
    for scene in [
        obj::parse(OBJ.as_bytes(), Path::new("a.obj"), Degenerate::Refuse, beside(MTL.as_bytes(), &png)),
        gltf::parse(GLTF.as_bytes(), Path::new("a.gltf"), Degenerate::Refuse, beside(b"", &png)),
    ] {
        assert!(scene.unwrap().is_textured());
    }
    assert!(Line::read(1, LINE.as_bytes()).unwrap().unwrap().case.problem().is_ok());
}
