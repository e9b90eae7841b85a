//! Emitters, made and freed.

#![allow(unsafe_code, reason = "C hands over addresses; functions are called by name")]

use std::cell::RefCell;
use std::ffi::c_char;

use radgrad_core::batch::ReadyEmitter;
use radgrad_core::{DVec3, Emission, Polygon};

use crate::{Status, guarded};

/// A polygon that emits, ready for batches in both precisions.
#[derive(Debug)]
pub struct Emitter {
    pub(crate) double: ReadyEmitter<f64>,
    pub(crate) single: ReadyEmitter<f32>,
}

thread_local! {
    /// Why the last emitter of this thread was refused.
    static MESSAGE: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Makes an emitter.
///
/// # Safety
/// As of the functions that call it.
unsafe fn make(
    (vertices, count): (*const f64, usize),
    emitter: *mut *mut Emitter,
    emission: impl FnOnce() -> Emission,
) -> Status {
    if vertices.is_null() || emitter.is_null() {
        return Status::RADGRAD_NULL;
    }
    guarded(|| {
        // SAFETY: the caller says that there are three numbers for each vertex.
        let numbers = unsafe { std::slice::from_raw_parts(vertices, 3 * count) };
        let corners = numbers.as_chunks::<3>().0.iter().map(|vertex| DVec3::from(*vertex)).collect();
        match Polygon::new(corners).and_then(|polygon| radgrad_core::Emitter::new(polygon, emission())) {
            Ok(made) => {
                let made = Emitter { double: ReadyEmitter::new(made.clone()), single: ReadyEmitter::new(made) };
                // SAFETY: the caller says that an address can be written there.
                unsafe { *emitter = Box::into_raw(Box::new(made)) };
                Status::RADGRAD_OK
            }
            Err(error) => {
                MESSAGE.with_borrow_mut(|message| *message = error.to_string());
                Status::RADGRAD_EMITTER
            }
        }
    })
}

/// Makes an emitter with the same emission everywhere, from `count` vertices of three coordinates each.
///
/// # Safety
/// `vertices` has three times `count` numbers, and `emitter` room for an address, which `radgrad_emitter_free` takes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn radgrad_emitter_constant(
    vertices: *const f64,
    count: usize,
    emission: f64,
    emitter: *mut *mut Emitter,
) -> Status {
    // SAFETY: the caller promises `3 count` numbers and room for an address, which `make` needs.
    unsafe { make((vertices, count), emitter, || Emission::Constant(emission)) }
}

/// Makes an emitter with an emission for each vertex; of more than three they must lie on one affine function.
///
/// # Safety
/// `vertices` has three times `count` numbers, `emission` as many as `count`, and `emitter` room for an address, which
/// `radgrad_emitter_free` takes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn radgrad_emitter_linear(
    vertices: *const f64,
    count: usize,
    emission: *const f64,
    emitter: *mut *mut Emitter,
) -> Status {
    if emission.is_null() {
        return Status::RADGRAD_NULL;
    }
    // SAFETY: the caller says that there is a number for each vertex.
    let values = || Emission::at_vertices(unsafe { std::slice::from_raw_parts(emission, count) }.to_vec());
    // SAFETY: the caller promises `3 count` numbers and room for an address, which `make` needs.
    unsafe { make((vertices, count), emitter, values) }
}

/// Makes an emitter with an emission that is `value` at vertex 0 and has a gradient, of three components.
///
/// # Safety
/// `vertices` has three times `count` numbers, `gradient` three, and `emitter` room for an address, which `radgrad_emitter_free` takes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn radgrad_emitter_affine(
    vertices: *const f64,
    count: usize,
    value: f64,
    gradient: *const f64,
    emitter: *mut *mut Emitter,
) -> Status {
    if gradient.is_null() {
        return Status::RADGRAD_NULL;
    }
    // SAFETY: the caller says that there are three numbers.
    let gradient = unsafe { [*gradient, *gradient.add(1), *gradient.add(2)] };
    // SAFETY: the caller promises `3 count` numbers and room for an address, which `make` needs.
    unsafe { make((vertices, count), emitter, || Emission::gradient(value, DVec3::from(gradient))) }
}

/// Frees an emitter; NULL is none.
///
/// # Safety
/// It was made by a function of this library, and is not used any more.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn radgrad_emitter_free(emitter: *mut Emitter) {
    if !emitter.is_null() {
        // SAFETY: it is the address of a box that was given away.
        drop(unsafe { Box::from_raw(emitter) });
    }
}

/// Writes why the last emitter of this thread was refused: text that ends with a 0, cut to `size` bytes. Returns the bytes of the whole
/// text, without the 0.
///
/// # Safety
/// `text` has room for `size` bytes, or is NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn radgrad_message(text: *mut c_char, size: usize) -> usize {
    MESSAGE.with_borrow(|message| {
        let room = size.saturating_sub(1).min(message.len());
        let length = (0..=room).rev().find(|&end| message.is_char_boundary(end)).unwrap_or(0);
        if !text.is_null() && size > 0 {
            for (index, byte) in message.bytes().take(length).chain([0]).enumerate() {
                // SAFETY: there are at most `size` bytes with the last one.
                unsafe { *text.add(index) = c_char::from_ne_bytes([byte]) };
            }
        }
        message.len()
    })
}
