//! Vectors with one component a lane, and sums over lanes in order.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x4, mask64x4};
use glam::DVec3;

use crate::vec3::Vec3;

/// The components of a vector, and 0, one a lane.
#[inline(always)]
pub fn row<S: Simd>(simd: S, [x, y, z]: [f64; 3]) -> f64x4<S> {
    f64x4::load_array(simd, [x, y, z, 0.0])
}

/// One vector where the mask is set, the other elsewhere.
#[inline(always)]
pub fn chosen<S: Simd>(mask: mask64x4<S>, set: Vec3<f64x4<S>>, unset: Vec3<f64x4<S>>) -> Vec3<f64x4<S>> {
    Vec3::new(mask.select(set.x, unset.x), mask.select(set.y, unset.y), mask.select(set.z, unset.z))
}

/// The same vector in all lanes.
#[inline(always)]
pub fn splat_vector<S: Simd>(simd: S, v: DVec3) -> Vec3<f64x4<S>> {
    Vec3::new(f64x4::splat(simd, v.x), f64x4::splat(simd, v.y), f64x4::splat(simd, v.z))
}

/// A sum with the terms of the first lanes, one after the other.
#[inline(always)]
pub fn plus_first<S: Simd>(sum: Vec3<f64>, terms: Vec3<f64x4<S>>, count: usize) -> Vec3<f64> {
    let (x, y, z) = (terms.x.as_array(), terms.y.as_array(), terms.z.as_array());
    let term = |i: usize| Vec3::new(x[i], y[i], z[i]);
    match count {
        3 => sum + term(0) + term(1) + term(2),
        4 => sum + term(0) + term(1) + term(2) + term(3),
        2 => sum + term(0) + term(1),
        _ => sum + term(0),
    }
}

/// The same of a number.
#[inline(always)]
pub fn number_plus_first<S: Simd>(sum: f64, terms: f64x4<S>, count: usize) -> f64 {
    let t = terms.as_array();
    match count {
        3 => sum + t[0] + t[1] + t[2],
        4 => sum + t[0] + t[1] + t[2] + t[3],
        2 => sum + t[0] + t[1],
        _ => sum + t[0],
    }
}
