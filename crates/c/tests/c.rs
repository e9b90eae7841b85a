//! The library as C sees it: a program in C is compiled against the header and run.

#![allow(unsafe_code, reason = "functions for C")]

use std::path::Path;
use std::process::Command;
use std::ptr::null_mut;

use radgrad_c::*;

const SQUARE: [f64; 12] = [0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 1.0];
const UP: [f64; 3] = [0.0, 0.0, 1.0];

fn constant() -> *mut Emitter {
    let mut lamp = null_mut();
    // SAFETY: four vertices, and room for an address.
    assert_eq!(unsafe { radgrad_emitter_constant(SQUARE.as_ptr(), 4, 1.0, &raw mut lamp) }, Status::RADGRAD_OK);
    lamp
}

#[test]
fn what_is_refused_has_its_status_and_its_words() {
    let (mut lamp, mut answer, lit) = (null_mut(), Answer::default(), constant());
    let bad = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0];
    let mut text = [1; 200];
    // SAFETY: each array has as many numbers as its count says; the functions must refuse NULL, which some calls pass.
    unsafe {
        assert_eq!(radgrad_emitter_constant(bad.as_ptr(), 2, 1.0, &raw mut lamp), Status::RADGRAD_EMITTER);
        let length = radgrad_message(text.as_mut_ptr(), text.len());
        let said: Vec<u8> = text[..length].iter().map(|c| c.to_ne_bytes()[0]).collect();
        assert_eq!(String::from_utf8(said).unwrap(), "a polygon needs at least 3 vertices, this one has 2");
        assert_eq!((text[length], radgrad_message(text.as_mut_ptr(), 5), text[4]), (0, length, 0));
        assert_eq!(radgrad_emitter_constant(null_mut(), 4, 1.0, &raw mut lamp), Status::RADGRAD_NULL);
        let zero = [0.0; 3];
        let evaluate = |normal: &[f64; 3], rho, tolerance, answer| {
            radgrad_evaluate(lit, zero.as_ptr(), normal.as_ptr(), rho, tolerance, answer)
        };
        assert_eq!(evaluate(&zero, 1.0, 1e-9, &raw mut answer), Status::RADGRAD_RECEIVER);
        assert_eq!(evaluate(&UP, 2.0, 1e-9, &raw mut answer), Status::RADGRAD_RECEIVER);
        assert_eq!(evaluate(&UP, 1.0, 2.0, &raw mut answer), Status::RADGRAD_TOLERANCE);
        assert_eq!(evaluate(&UP, 1.0, 1e-9, null_mut()), Status::RADGRAD_NULL);
        let mut position = vec![0.0; 3 * 2000];
        position[3 * 1500 + 1] = f64::NAN;
        let (mut up, mut failed) = (UP, 0);
        let none = ArrayF64 { data: null_mut(), point_stride: 0, component_stride: 0 };
        let points = PointsF64 {
            count: 2000,
            position: ArrayF64 { data: position.as_mut_ptr(), point_stride: 3, component_stride: 1 },
            normal: ArrayF64 { data: up.as_mut_ptr(), point_stride: 0, component_stride: 1 },
            reflectance: none,
        };
        let answers = AnswersF64 { radiosity: none, gradient: none, radiosity_error: none, gradient_error: none };
        let room = radgrad_room_new();
        assert_eq!(radgrad_batch_f64(room, lit, points, 1e-9, answers, &raw mut failed), Status::RADGRAD_RECEIVER);
        assert_eq!(failed, 1500);
        let nobody = PointsF64 { count: 0, position: none, ..points };
        assert_eq!(radgrad_batch_f64(room, lit, nobody, 1e-9, answers, null_mut()), Status::RADGRAD_OK);
        radgrad_room_free(room);
        radgrad_emitter_free(lit);
        radgrad_emitter_free(null_mut());
    }
}

#[test]
fn a_program_in_c_compiles_and_runs() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let compiler = std::env::var_os("CC").unwrap_or_else(|| "cc".into());
    if cfg!(not(unix)) || Command::new(&compiler).arg("--version").output().is_err() {
        println!("SKIPPED: there is no C compiler {compiler:?}: the example in C was not compiled");
        return;
    }
    // Beside this program, where cargo put the library that it tests.
    let libraries = std::env::current_exe().unwrap().parent().unwrap().to_owned();
    let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join("desk");
    let compiled = Command::new(&compiler)
        .args(["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-I"])
        .arg(here.join("include"))
        .arg(here.join("examples/desk.c"))
        .args([std::ffi::OsStr::new("-L"), libraries.as_os_str()])
        .arg(format!("-Wl,-rpath,{}", libraries.display()))
        .args(["-lradgrad_c", "-lm", "-o"])
        .arg(&program)
        .output()
        .unwrap();
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
    let ran = Command::new(&program).output().unwrap();
    assert!(ran.status.success(), "it ended with {}", ran.status);
    let printed = String::from_utf8(ran.stdout).unwrap();
    // 0.8 x 100 x the factor of a unit square from a point 1 below its middle, 0.2394...
    let value: f64 = printed.split([' ', '\n']).find_map(|word| word.parse().ok()).unwrap();
    let exact = 80.0 * 4.0 / std::f64::consts::PI * (0.5 / 1.25_f64.sqrt()) * (0.5 / 1.25_f64.sqrt()).atan();
    assert!((value - exact).abs() < 1e-11, "{printed}: {exact}");
}
