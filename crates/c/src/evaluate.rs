//! One receiver, and very many.

#![allow(unsafe_code, reason = "C hands over addresses; functions are called by name")]

use radgrad_core::batch::{Answers, Engine, Precision, ReadyEmitter, Receivers};
use radgrad_core::{DVec3, Derivative, Error, Receiver};

use crate::arrays::{AnswersF32, AnswersF64, PointsF32, PointsF64};
use crate::{Emitter, Status, guarded};

/// Radiosity and gradient with proven bounds.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Answer {
    /// Radiosity.
    pub radiosity: f64,
    /// Proven bound on its error.
    pub radiosity_error: f64,
    /// Derivatives with respect to the position at a fixed normal.
    pub gradient: [f64; 3],
    /// Proven bound on the Euclidean norm of the error of the gradient.
    pub gradient_error: f64,
}

/// Radiosity and gradient of a receiver due to an emitter, to a relative tolerance. It neither allocates, locks nor unwinds.
///
/// # Safety
/// `position` and `normal` have three numbers each, `emitter` was made by this library, and `answer` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn radgrad_evaluate(
    emitter: *const Emitter,
    position: *const f64,
    normal: *const f64,
    reflectance: f64,
    tolerance: f64,
    answer: *mut Answer,
) -> Status {
    // SAFETY: the caller says so of them.
    let given = unsafe { given(emitter, position, normal) };
    let Some((emitter, position, normal)) = given.filter(|_| !answer.is_null()) else { return Status::RADGRAD_NULL };
    guarded(|| {
        let receiver = Receiver::new(position, normal, reflectance);
        match receiver.and_then(|receiver| radgrad_core::evaluate_to(&receiver, emitter, [], tolerance)) {
            Ok(computed) => {
                let gradient = computed.gradient.to_array();
                let radgrad_core::Answer { radiosity, radiosity_error, gradient_error, .. } = computed;
                // SAFETY: the caller says that it can be written.
                unsafe { *answer = Answer { radiosity, radiosity_error, gradient, gradient_error } };
                Status::RADGRAD_OK
            }
            Err(error) => Status::from_error(&error),
        }
    })
}

/// Radiosity and its derivatives by position, normal and reflectance, with proven bounds.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Slopes {
    /// Radiosity and gradient.
    pub answer: Answer,
    /// Derivatives with respect to the unit normal, in the unit of the emission; as it turns only the part across it counts.
    pub normal: [f64; 3],
    /// Proven bound on the Euclidean norm of their error.
    pub normal_error: f64,
    /// Derivative with respect to the reflectance, in the unit of the emission.
    pub reflectance: f64,
    /// Proven bound on its error.
    pub reflectance_error: f64,
}

/// Derivatives of a receiver's radiosity by everything that shapes it, to a tolerance relative to the largest of their kind. It may
/// allocate; it neither locks nor unwinds.
///
/// `vertices`, unless it is NULL, gets four numbers for each vertex of the emitter: three derivatives, in the unit of the emission over
/// that of length, and a proven bound on the norm of their error. `emission`, unless it is NULL, gets two numbers for each parameter
/// of the emission, the derivative and its bound: of a constant emission for the constant; for the value at each vertex; or for the value,
/// and then three, in the unit of length, for the gradient. Vertex values move with their vertices, an emission with a gradient moves with
/// vertex 0. Of more than three vertices the derivatives are those for motions that keep the polygon flat.
///
/// # Safety
/// `position` and `normal` have three numbers each, `emitter` was made by this library, `slopes` can be written, and `vertices` and
/// `emission` have room for those numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn radgrad_derivatives(
    emitter: *const Emitter,
    position: *const f64,
    normal: *const f64,
    reflectance: f64,
    tolerance: f64,
    slopes: *mut Slopes,
    vertices: *mut f64,
    emission: *mut f64,
) -> Status {
    // SAFETY: the caller says so of them.
    let given = unsafe { given(emitter, position, normal) };
    let Some((emitter, position, normal)) = given.filter(|_| !slopes.is_null()) else { return Status::RADGRAD_NULL };
    guarded(|| {
        let receiver = Receiver::new(position, normal, reflectance);
        let derivatives = match receiver.and_then(|receiver| radgrad_core::derivatives(&receiver, emitter, [], tolerance)) {
            Ok(derivatives) => derivatives,
            Err(error) => return Status::from_error(&error),
        };
        let answer = Answer {
            radiosity: derivatives.radiosity.value,
            radiosity_error: derivatives.radiosity.error,
            gradient: derivatives.gradient.value.to_array(),
            gradient_error: derivatives.gradient.error,
        };
        let written = Slopes {
            answer,
            normal: derivatives.normal.value.to_array(),
            normal_error: derivatives.normal.error,
            reflectance: derivatives.reflectance.value,
            reflectance_error: derivatives.reflectance.error,
        };
        let of_vertex = |vertex: &Derivative<DVec3>| [vertex.value.x, vertex.value.y, vertex.value.z, vertex.error];
        // SAFETY: the caller says that all can be written, and has room for so many numbers.
        unsafe {
            *slopes = written;
            write(vertices, derivatives.vertices.iter().flat_map(of_vertex));
            write(emission, derivatives.emission.iter().flat_map(|parameter| [parameter.value, parameter.error]));
        }
        Status::RADGRAD_OK
    })
}

/// The emitter, and the receiver's position and normal, unless one is NULL.
///
/// # Safety
/// `position` and `normal` have three numbers each, and `emitter` was made by this library and is there as long as the result.
unsafe fn given<'a>(
    emitter: *const Emitter,
    position: *const f64,
    normal: *const f64,
) -> Option<(&'a radgrad_core::Emitter, DVec3, DVec3)> {
    if emitter.is_null() || position.is_null() || normal.is_null() {
        return None;
    }
    // SAFETY: the caller says that they point to three numbers each.
    let vector = |numbers: *const f64| unsafe { DVec3::new(*numbers, *numbers.add(1), *numbers.add(2)) };
    // SAFETY: the caller says that it is an emitter of this library.
    Some((unsafe { &*emitter }.double.emitter(), vector(position), vector(normal)))
}

/// Writes numbers one after the other, unless nothing is wanted.
///
/// # Safety
/// There is room for as many.
unsafe fn write(to: *mut f64, numbers: impl Iterator<Item = f64>) {
    if !to.is_null() {
        for (place, number) in numbers.enumerate() {
            // SAFETY: the caller says that there is room.
            unsafe { *to.add(place) = number };
        }
    }
}

/// Points that are answered at a time.
const CHUNK: usize = 1024;

/// No fewer receivers are handed on: fewer than a vector holds take a longer way.
const LEAST: usize = 16;

/// Columns of one precision.
#[derive(Debug)]
struct Columns<F> {
    position: [Vec<F>; 3],
    normal: [Vec<F>; 3],
    reflectance: Vec<F>,
    answers: Answers<F>,
}

impl<F: Precision + Copy> Columns<F> {
    fn new() -> Self {
        let column = || vec![F::default(); CHUNK];
        let room = || Vec::with_capacity(CHUNK);
        Self {
            position: [column(), column(), column()],
            normal: [column(), column(), column()],
            reflectance: column(),
            answers: Answers {
                radiosity: room(),
                gradient: [room(), room(), room()],
                radiosity_error: room(),
                gradient_error: room(),
                method: Vec::with_capacity(CHUNK),
                ..Answers::new()
            },
        }
    }

    /// Answers the first so many.
    fn answer(&mut self, count: usize, emitter: &ReadyEmitter<F>, engine: Engine, tolerance: f64) -> Result<(), Error> {
        let [position, normal] = [&self.position, &self.normal].map(|columns| columns.each_ref().map(|column| &column[..count]));
        let receivers = Receivers::new(position, normal, &self.reflectance[..count])?;
        engine.evaluate_ready(&receivers, emitter, tolerance, &mut self.answers)
    }
}

/// The memory that batches work in. Made once for each thread.
#[derive(Debug)]
pub struct Room {
    engine: Engine,
    double: Columns<f64>,
    single: Columns<f32>,
}

/// Makes a room, of 160 kB. NULL if the library fails as it should not.
#[unsafe(no_mangle)]
pub extern "C" fn radgrad_room_new() -> *mut Room {
    let made = std::panic::catch_unwind(|| Room { engine: Engine::new(), double: Columns::new(), single: Columns::new() });
    made.map_or(std::ptr::null_mut(), |room| Box::into_raw(Box::new(room)))
}

/// Frees a room; NULL is none.
///
/// # Safety
/// It was made by `radgrad_room_new`, and is not used any more.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn radgrad_room_free(room: *mut Room) {
    if !room.is_null() {
        // SAFETY: it is the address of a box that was given away.
        drop(unsafe { Box::from_raw(room) });
    }
}

/// One function for both precisions, whose arrays have types of their own.
macro_rules! batch {
    ($room:expr, $columns:ident, $emitter:expr, $points:expr, $tolerance:expr, $answers:expr, $failed:expr) => {{
        if $room.is_null() || $emitter.is_null() || !$points.is_whole() {
            return Status::RADGRAD_NULL;
        }
        // SAFETY: the caller says that both were made by this library, and that nobody else uses the room.
        let (room, emitter) = unsafe { (&mut *$room, &(*$emitter).$columns) };
        guarded(|| {
            for first in (0..$points.count).step_by(CHUNK) {
                let count = CHUNK.min($points.count - first);
                let columns = &mut room.$columns;
                let length = count.max(LEAST);
                // SAFETY: the caller says that the arrays have so many points.
                unsafe {
                    $points.read(first, [&mut columns.position, &mut columns.normal], &mut columns.reflectance[..length]);
                }
                if let Err(error) = columns.answer(length, emitter, room.engine, $tolerance) {
                    let place = if let Error::InBatch { index, .. } = error { index.min(count - 1) } else { 0 };
                    if !$failed.is_null() {
                        // SAFETY: the caller says that it can be written.
                        unsafe { *$failed = first + place };
                    }
                    return Status::from_error(&error);
                }
                // SAFETY: the caller says that the arrays have so many points, and that nobody else uses them.
                unsafe { $answers.write(first, count, &columns.answers) };
            }
            Status::RADGRAD_OK
        })
    }};
}

/// Radiosity and gradient of many receivers due to an emitter, to a relative tolerance. It neither allocates, locks nor unwinds.
///
/// A receiver that is refused ends it: `failed`, unless it is NULL, is then its place. Answers to points before it may be written already.
///
/// # Safety
/// `room` and `emitter` were made by this library, and no other thread uses `room`; the arrays of `points` and `answers` have
/// `points.count` points, and nobody else uses those of `answers` meanwhile.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn radgrad_batch_f64(
    room: *mut Room,
    emitter: *const Emitter,
    points: PointsF64,
    tolerance: f64,
    answers: AnswersF64,
    failed: *mut usize,
) -> Status {
    batch!(room, double, emitter, points, tolerance, answers, failed)
}

/// The same in single precision, twice as fast to tolerances of 1e-5: bounds include its rounding, and reach no 1e-7.
///
/// A receiver that is refused ends it: `failed`, unless it is NULL, is then its place. Answers to points before it may be written already.
///
/// # Safety
/// `room` and `emitter` were made by this library, and no other thread uses `room`; the arrays of `points` and `answers` have
/// `points.count` points, and nobody else uses those of `answers` meanwhile.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn radgrad_batch_f32(
    room: *mut Room,
    emitter: *const Emitter,
    points: PointsF32,
    tolerance: f64,
    answers: AnswersF32,
    failed: *mut usize,
) -> Status {
    batch!(room, single, emitter, points, tolerance, answers, failed)
}
