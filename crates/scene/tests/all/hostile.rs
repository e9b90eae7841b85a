//! Readers under fire: files that were changed at random, and rules that hold for each result.
//!
//! The seed is fixed, so that every run tries the same files; `RADGRAD_MUTANTS` sets how many of each kind.

use std::io;
use std::path::Path;

use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use radgrad_scene::case::Line;
use radgrad_scene::{Degenerate, Error, Materials, Reading, Scene, gltf, obj, view3d};

const OBJ: &str = "# a room\nmtllib m.mtl\no room\nv 0 0 0\nv 1 0 0 1\nv 1 1 0.1\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0.5 2\ng floor\n\
    usemtl grey\nf 1/1 2/2 3/3 4/4\nf 1/1 2/2 \\\n 3/3\ng lid\nusemtl lamp\nf -1 -2 -3\nvn 0 0 1\nf 4//1 3//1 1//1\nl 1 2\n";
const MTL: &str = "newmtl grey\nKd 0.5 0.6 0.7\nKs 1 1 1\nillum 2\nmap_Kd -s 2 3 -o 0.1 -clamp on t.png\nnewmtl lamp\nKe 4\nd 0.5\nmap_Ke t.png\n";
const VS3: &str = "T room\nC encl=1\nF 3\nV 1 0 0 0\nV 2 4 0 0\nV 3 4 4 0\nV 4 0 4 0\nV 5 1 1 0\nV 6 2 1 0\nV 7 2 2 0\nV 8 1 2 0\n\
    S 1 1 2 3 4 0 0 0.9 floor\nS 2 5 6 7 8 1 0 0.5 rug\nO 3 1 2 3 0 0 0 1 plate\nN 4 8 7 6 5 1 0 0.1 hole\nS 5 R 0 1 0.2 box\n0 0 1 90 90\n2 3\nEnd of data\n";
const GLTF: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"children":[1],"scale":[1,2,-1]},
    {"mesh":0,"name":"child","rotation":[0,0,1,0],"translation":[0,0,3]}],"meshes":[{"primitives":[{"attributes":{"POSITION":0,
    "TEXCOORD_0":2},"indices":1,"material":0}]}],"materials":[{"doubleSided":true,"emissiveFactor":[1,0,1],"pbrMetallicRoughness":
    {"baseColorFactor":[0.5,0.5,0.5,1],"baseColorTexture":{"index":0}}}],"textures":[{"source":0,"sampler":0}],"samplers":[{"wrapS":33648}],
    "images":[{"uri":"t.png"}],"accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":4},{"bufferView":1,
    "componentType":5123,"type":"SCALAR","count":6},{"bufferView":2,"componentType":5126,"type":"VEC2","count":4}],"bufferViews":
    [{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":12},{"buffer":0,"byteLength":48,"byteStride":12}],"buffers":
    [{"byteLength":60,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAgD8AAAAAAAAAAAAAgD8AAAAAAAABAAIAAAACAAMA"}]}"#;
const LINE: &str = r#"{"id":"a","receiver":{"position":[0,0,0],"normal":[0,0,1],"reflectance":0.5},"emitter":{"vertices":[[0,0,1],
    [0,1,1],[1,1,1],[1,0,1]],"emission":{"vertices":[1,2,3,2]}},"occluders":[[[0,0,0.5],[0.1,0,0.5],[0,0.1,0.5]]],"tolerance":1e-9}"#;

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

/// Checks a scene, or the error in its place.
fn judge(read: impl Fn(Reading) -> Result<Scene, Error>) {
    let reading = |degenerate| Reading { degenerate, budget: 1 << 22, materials: Materials::Optional, ..Reading::default() };
    let refused = read(reading(Degenerate::Refuse));
    let dropped = read(reading(Degenerate::Drop));
    assert!(refused.is_err() || dropped.is_ok(), "{dropped:?}");
    for result in [refused, dropped] {
        match result {
            Ok(scene) => {
                for face in scene.faces() {
                    assert!(face.polygon().area() >= 0.0 && face.polygon().vertices().iter().all(|v| v.is_finite()));
                    let material = &scene.materials()[face.material()];
                    assert!(material.reflectance().iter().all(|rho| (0.0..=1.0).contains(rho)));
                    assert!(material.radiance().iter().all(|radiance| (0.0..f64::INFINITY).contains(radiance)));
                }
                assert!(scene.notes().iter().all(|note| is_shown(&note.to_string())), "{:?}", scene.notes());
            }
            Err(error) => assert!(is_shown(&error.to_string()), "{error}"),
        }
    }
}

/// Whether a terminal shows all of a text.
fn is_shown(text: &str) -> bool {
    !text.contains(char::is_control)
}

fn png() -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, 3, 2);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&[9; 18]).unwrap();
    file
}

/// The files beside a scene.
fn beside<'a>(library: &'a [u8], texture: &'a [u8]) -> impl Fn(&Path) -> io::Result<Vec<u8>> + 'a {
    move |name| match name.to_str() {
        Some("m.mtl") => Ok(library.to_vec()),
        Some("t.png") => Ok(texture.to_vec()),
        _ => Err(io::ErrorKind::NotFound.into()),
    }
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
