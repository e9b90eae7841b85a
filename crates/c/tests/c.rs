//! The library as C sees it: a program in C is compiled against the header and run, and calls are counted that must not allocate.

#![allow(unsafe_code, reason = "an allocator that counts, and functions for C")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::path::Path;
use std::process::Command;
use std::ptr::null_mut;

use radgrad_c::*;

/// Counts what the thread allocates.
struct Counting;

thread_local! {
    static ALLOCATED: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: it hands on to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATED.set(ALLOCATED.get() + 1);
        // SAFETY: as for the caller.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as for the caller.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const SQUARE: [f64; 12] = [0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 1.0];
const UP: [f64; 3] = [0.0, 0.0, 1.0];

fn constant() -> *mut Emitter {
    let mut lamp = null_mut();
    // SAFETY: four vertices, and room for an address.
    assert_eq!(unsafe { radgrad_emitter_constant(SQUARE.as_ptr(), 4, 1.0, &raw mut lamp) }, Status::RADGRAD_OK);
    lamp
}

fn linear() -> *mut Emitter {
    let (mut lamp, values) = (null_mut(), [1.0, 2.0, 3.0, 2.0]);
    // SAFETY: four vertices with their values, and room for an address.
    assert_eq!(unsafe { radgrad_emitter_linear(SQUARE.as_ptr(), 4, values.as_ptr(), &raw mut lamp) }, Status::RADGRAD_OK);
    lamp
}

/// Over, beside and near below, and cut by the horizon.
fn points(count: usize) -> (Vec<f64>, Vec<f64>) {
    let mut state = 1_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        f64::from(u32::try_from(state >> 33).unwrap()) / f64::from(1_u32 << 31)
    };
    let point = |i: usize| {
        let depth = [0.5, 0.99, 0.8, 0.7, 0.9, 1.5][i % 6];
        [3.0 * random() - 1.0, 3.0 * random() - 1.0, depth, random() - 0.5, random() - 0.5, random() + 0.01]
    };
    let all: Vec<[f64; 6]> = (0..count).map(point).collect();
    (all.iter().flat_map(|p| [p[0], p[1], p[2]]).collect(), all.iter().flat_map(|p| [p[3], p[4], p[5]]).collect())
}

#[test]
fn calls_near_an_emitter_do_not_allocate() {
    let (position, normal) = points(6000);
    let single = |numbers: &[f64]| numbers.iter().map(|c| format!("{c:e}").parse::<f32>().unwrap()).collect::<Vec<f32>>();
    let (mut narrow, mut narrow_normal) = (single(&position), single(&normal));
    let (mut position, mut normal) = (position, normal);
    let (mut radiosity, mut error, mut values) = (vec![0.0; 6000], vec![0.0; 6000], vec![0.0_f32; 6000]);
    let mut gradient = vec![0.0; 18_000];
    for lamp in [constant(), linear()] {
        let room = radgrad_room_new();
        let rows = |data: &mut Vec<f64>| ArrayF64 { data: data.as_mut_ptr(), point_stride: 3, component_stride: 1 };
        let numbers = |data: &mut Vec<f64>| ArrayF64 { data: data.as_mut_ptr(), point_stride: 1, component_stride: 0 };
        let nothing = ArrayF64 { data: null_mut(), point_stride: 0, component_stride: 0 };
        let given = PointsF64 { count: 6000, position: rows(&mut position), normal: rows(&mut normal), reflectance: nothing };
        let wanted = AnswersF64 {
            radiosity: numbers(&mut radiosity),
            gradient: rows(&mut gradient),
            radiosity_error: numbers(&mut error),
            gradient_error: nothing,
        };
        let rows = |data: &mut Vec<f32>| ArrayF32 { data: data.as_mut_ptr(), point_stride: 3, component_stride: 1 };
        let none = ArrayF32 { data: null_mut(), point_stride: 0, component_stride: 0 };
        let narrow_given =
            PointsF32 { count: 6000, position: rows(&mut narrow), normal: rows(&mut narrow_normal), reflectance: none };
        let narrow_wanted = AnswersF32 {
            radiosity: ArrayF32 { data: values.as_mut_ptr(), point_stride: 1, component_stride: 0 },
            gradient: none,
            radiosity_error: none,
            gradient_error: none,
        };
        let mut one = Answer::default();
        let before = ALLOCATED.get();
        // SAFETY: all arrays have 6000 points, and room and lamp are from the library.
        unsafe {
            assert_eq!(radgrad_batch_f64(room, lamp, given, 1e-10, wanted, null_mut()), Status::RADGRAD_OK);
            assert_eq!(radgrad_batch_f32(room, lamp, narrow_given, 1e-4, narrow_wanted, null_mut()), Status::RADGRAD_OK);
        }
        let in_batches = ALLOCATED.get() - before;
        let (before, mut answered) = (ALLOCATED.get(), 0);
        for i in (0..18_000).step_by(3) {
            // SAFETY: there are three numbers each, and the lamp is from the library.
            let status = unsafe {
                radgrad_evaluate(lamp, position.as_ptr().add(i), normal.as_ptr().add(i), 1.0, 1e-10, &raw mut one)
            };
            assert_eq!(status, Status::RADGRAD_OK);
            assert!((one.radiosity - radiosity[i / 3]).abs() <= one.radiosity_error + error[i / 3]);
            answered += usize::from(one.radiosity > 0.0);
        }
        let one_by_one = ALLOCATED.get() - before;
        println!("{in_batches} allocations in 12 chunks of two batches, {one_by_one} in {answered} calls");
        // The outline of the emitter, or a few things of a linear one, for each chunk; corners where a Gauss rule is the cheapest.
        assert!(in_batches <= 12 * 8 + answered / 10, "{in_batches}");
        assert!(one_by_one <= answered / 10, "{one_by_one} of {answered}");
        assert!(radiosity.iter().filter(|value| **value > 0.0).count() > 1500);
        // SAFETY: they are not used any more.
        unsafe {
            radgrad_room_free(room);
            radgrad_emitter_free(lamp);
        }
    }
}

#[test]
fn what_is_refused_has_its_status_and_its_words() {
    let (mut lamp, mut answer, lit) = (null_mut(), Answer::default(), constant());
    let bad = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0];
    let mut text = [1; 200];
    // SAFETY: numbers are as many as is said, and what is NULL is what is tried.
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
