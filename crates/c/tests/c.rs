//! The library as C sees it: a program in C is compiled against the header and run.

#![allow(unsafe_code, reason = "functions for C")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::path::Path;
use std::process::Command;
use std::ptr::null_mut;

use radgrad_c::*;

/// The system's allocator, which counts the allocations of each thread.
struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: the system's allocator does all the work.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: the caller's promise is that of the system's allocator.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, address: *mut u8, layout: Layout) {
        // SAFETY: the same.
        unsafe { System.dealloc(address, layout) }
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
fn derivatives_are_those_of_the_library() {
    let mut lamps = [constant(), null_mut(), null_mut()];
    // SAFETY: four vertices, a value for each or three numbers of a slope, and room for an address.
    unsafe {
        assert_eq!(
            radgrad_emitter_linear(SQUARE.as_ptr(), 4, [1.0, 2.0, 3.0, 2.0].as_ptr(), &raw mut lamps[1]),
            Status::RADGRAD_OK
        );
        assert_eq!(
            radgrad_emitter_affine(SQUARE.as_ptr(), 4, 1.0, [0.5, 0.25, 0.0].as_ptr(), &raw mut lamps[2]),
            Status::RADGRAD_OK
        );
    }
    let (position, normal) = ([0.2, 0.3, 0.0], [0.1, 0.0, 1.0]);
    for (lamp, parameters) in lamps.into_iter().zip([1, 4, 4]) {
        let (mut slopes, mut vertices, mut emission) = (Slopes::default(), [f64::NAN; 17], [f64::NAN; 9]);
        let (x, n) = (position.as_ptr(), normal.as_ptr());
        // SAFETY: the emitter is whole, and there is room for four vertices and four parameters.
        let status =
            unsafe { radgrad_derivatives(lamp, x, n, 0.5, 1e-12, &raw mut slopes, vertices.as_mut_ptr(), emission.as_mut_ptr()) };
        assert_eq!(status, Status::RADGRAD_OK);
        for axis in 0..3 {
            let sum: f64 = (0..4).map(|k| vertices[4 * k + axis]).sum();
            assert!((sum + slopes.answer.gradient[axis]).abs() < 1e-12, "moving all is moving the receiver the other way");
        }
        assert!((0..4).all(|k| vertices[4 * k + 3] < 1e-12) && vertices[16].is_nan(), "{vertices:?}");
        assert!((0..parameters).all(|k| emission[2 * k + 1] < 1e-12) && emission[2 * parameters].is_nan(), "{emission:?}");
        assert!((slopes.reflectance * 0.5 - slopes.answer.radiosity).abs() < 1e-15 && slopes.normal[2] > 0.0);
        let mut alone = Slopes::default();
        // SAFETY: the emitter is whole, and lists that are not wanted are NULL.
        let status = unsafe { radgrad_derivatives(lamp, x, n, 0.5, 1e-12, &raw mut alone, null_mut(), null_mut()) };
        assert_eq!((status, alone), (Status::RADGRAD_OK, slopes));
        // SAFETY: nothing is read or written by way of an address that is NULL.
        unsafe {
            assert_eq!(
                radgrad_derivatives(lamp, x, n, 2.0, 1e-12, &raw mut alone, null_mut(), null_mut()),
                Status::RADGRAD_RECEIVER
            );
            assert_eq!(radgrad_derivatives(lamp, x, n, 0.5, 1e-12, null_mut(), null_mut(), null_mut()), Status::RADGRAD_NULL);
            radgrad_emitter_free(lamp);
        }
    }
}

#[test]
fn a_call_allocates_nothing() {
    const COUNT: usize = 3000;
    let (mut linear, lamp) = (null_mut(), constant());
    // SAFETY: four vertices, a value for each, and room for an address.
    let made = unsafe { radgrad_emitter_linear(SQUARE.as_ptr(), 4, [1.0, 2.0, 3.0, 2.0].as_ptr(), &raw mut linear) };
    assert_eq!(made, Status::RADGRAD_OK);
    // Below the lamp, beside it, up to a hundred thousand sizes away, near its edges, and turned so that the horizon crosses it.
    let (mut position, mut normal) = (vec![0.0; 3 * COUNT], vec![0.0; 3 * COUNT]);
    for i in 0..COUNT {
        let (turn, far) = (0.7 * i as f64, 10_f64.powf(i as f64 / COUNT as f64 * 6.0 - 1.0));
        position[3 * i..3 * i + 3].copy_from_slice(&[
            far * turn.cos(),
            far * turn.sin(),
            0.9 - 0.3 * far * (0.3 * turn).sin().abs(),
        ]);
        normal[3 * i..3 * i + 3].copy_from_slice(&[(1.3 * turn).sin(), (1.7 * turn).cos(), (0.9 * turn).cos() + 0.5]);
    }
    let (mut single_position, mut single_normal) = (vec![0.0; 3 * COUNT], vec![0.0; 3 * COUNT]);
    #[expect(clippy::cast_possible_truncation, reason = "the batch takes numbers of single precision")]
    let narrow = |double: &f64| *double as f32;
    for (single, double) in [(&mut single_position, &position), (&mut single_normal, &normal)] {
        single.iter_mut().zip(double).for_each(|(single, double)| *single = narrow(double));
    }
    let (mut values, mut slopes) = (vec![0.0; COUNT], vec![0.0; 3 * COUNT]);
    let (mut single_values, mut single_slopes) = (vec![0.0; COUNT], vec![0.0; 3 * COUNT]);
    let array = |numbers: &mut Vec<f64>, point_stride| ArrayF64 { data: numbers.as_mut_ptr(), point_stride, component_stride: 1 };
    let single =
        |numbers: &mut Vec<f32>, point_stride| ArrayF32 { data: numbers.as_mut_ptr(), point_stride, component_stride: 1 };
    let (none, no_single) = (array(&mut Vec::new(), 0), single(&mut Vec::new(), 0));
    let (none, no_single) = (ArrayF64 { data: null_mut(), ..none }, ArrayF32 { data: null_mut(), ..no_single });
    let points = PointsF64 { count: COUNT, position: array(&mut position, 3), normal: array(&mut normal, 3), reflectance: none };
    let single_points = PointsF32 {
        count: COUNT,
        position: single(&mut single_position, 3),
        normal: single(&mut single_normal, 3),
        reflectance: no_single,
    };
    let into = AnswersF64 {
        radiosity: array(&mut values, 1),
        gradient: array(&mut slopes, 3),
        radiosity_error: none,
        gradient_error: none,
    };
    let single_into = AnswersF32 {
        radiosity: single(&mut single_values, 1),
        gradient: single(&mut single_slopes, 3),
        radiosity_error: no_single,
        gradient_error: no_single,
    };
    let room = radgrad_room_new();
    let before = ALLOCATIONS.get();
    for lamp in [lamp, linear] {
        // SAFETY: emitters and room are whole, and each array has the points that are stated.
        unsafe {
            for tolerance in [1e-3, 1e-9] {
                assert_eq!(radgrad_batch_f64(room, lamp, points, tolerance, into, null_mut()), Status::RADGRAD_OK);
            }
            assert_eq!(radgrad_batch_f32(room, lamp, single_points, 1e-5, single_into, null_mut()), Status::RADGRAD_OK);
            let mut answer = Answer::default();
            for i in 0..COUNT {
                let (x, n) = (position.as_ptr().add(3 * i), normal.as_ptr().add(3 * i));
                assert_eq!(radgrad_evaluate(lamp, x, n, 1.0, 1e-9, &raw mut answer), Status::RADGRAD_OK);
            }
        }
    }
    assert_eq!(ALLOCATIONS.get() - before, 0);
    assert!(values.iter().filter(|value| **value > 0.0).count() > COUNT / 4 && values.iter().any(|value| *value < 1e-9));
    assert!(single_values.iter().any(|value| *value > 0.1));
    // SAFETY: each was made by the library, and is freed once.
    unsafe {
        radgrad_room_free(room);
        radgrad_emitter_free(lamp);
        radgrad_emitter_free(linear);
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
    // Cargo's path has older libraries of an earlier build before this one.
    let ran = Command::new(&program).env_remove("LD_LIBRARY_PATH").output().unwrap();
    assert!(ran.status.success(), "it ended with {}: {}", ran.status, String::from_utf8_lossy(&ran.stderr));
    let printed = String::from_utf8(ran.stdout).unwrap();
    // 0.8 x 100 x the factor of a unit square from a point 1 below its middle, 0.2394...
    let value: f64 = printed.split([' ', '\n']).find_map(|word| word.parse().ok()).unwrap();
    let exact = 80.0 * 4.0 / std::f64::consts::PI * (0.5 / 1.25_f64.sqrt()) * (0.5 / 1.25_f64.sqrt()).atan();
    assert!((value - exact).abs() < 1e-11, "{printed}: {exact}");
}

#[test]
fn no_numbers_of_a_caller_end_the_program() {
    // Each number of each call is one of these, by xorshift (G. Marsaglia 2003).
    const NUMBERS: [f64; 16] = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        0.5,
        1e-300,
        5e-324,
        1e300,
        f64::MAX,
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        1.0 + f64::EPSILON,
        0.1,
        1e-9,
        3.0,
    ];
    let count = std::env::var("RADGRAD_MUTANTS").ok().and_then(|count| count.parse().ok()).unwrap_or(300);
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut below = |count: u64| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        usize::try_from((state >> 33) % count).unwrap()
    };
    let (mut answered, mut refused) = (0, 0);
    for _ in 0..count {
        let mut vertices = SQUARE;
        let mut given = [0.0, 0.0, 0.25, 0.0, 0.0, 1.0, 1.0, 1e-9, 1.0];
        for _ in 0..below(4) {
            vertices[below(12)] = NUMBERS[below(16)];
            given[below(9)] = NUMBERS[below(16)];
        }
        let corners = if below(8) == 0 { below(5) } else { 4 };
        let (mut lamp, mut answer) = (null_mut(), Answer::default());
        // SAFETY: there are four vertices of three numbers, of which at most as many are named, and room for an address and an answer.
        unsafe {
            let made = match below(3) {
                0 => radgrad_emitter_constant(vertices.as_ptr(), corners, given[8], &raw mut lamp),
                1 => radgrad_emitter_linear(vertices.as_ptr(), corners, given[5..].as_ptr(), &raw mut lamp),
                _ => radgrad_emitter_affine(vertices.as_ptr(), corners, given[8], given[..3].as_ptr(), &raw mut lamp),
            };
            let status = match made {
                Status::RADGRAD_OK => {
                    radgrad_evaluate(lamp, given[..3].as_ptr(), given[3..].as_ptr(), given[6], given[7], &raw mut answer)
                }
                status => status,
            };
            radgrad_emitter_free(if made == Status::RADGRAD_OK { lamp } else { null_mut() });
            assert_ne!(status, Status::RADGRAD_FAULT, "{vertices:?} {given:?}");
            if status == Status::RADGRAD_OK {
                assert!(answer.radiosity.is_finite() && answer.radiosity_error >= 0.0, "{answer:?} {vertices:?} {given:?}");
                answered += 1;
            } else {
                refused += 1;
            }
        }
    }
    assert!(answered > count / 10 && refused > count / 10, "{answered} answered, {refused} refused");
}
