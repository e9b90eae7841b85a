//! Arrays of C with strides, as columns.
//!
//! One type describes both layouts: points one after the other (`point_stride` 3, `component_stride` 1), and a column for each
//! coordinate (1, and the number of points). Strides are in numbers, not bytes, and may be negative or 0.

#![allow(unsafe_code, reason = "C hands over addresses and strides; what is read and written is what its caller says is there")]

use radgrad_core::batch::Answers;

/// Numbers in memory: that of point `i` and component `k` is `data[i * point_stride + k * component_stride]`.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct ArrayF64 {
    /// The first number. NULL where nothing is given, or nothing is wanted.
    pub data: *mut f64,
    /// Numbers from a point to the next one; 0 if all points have the same.
    pub point_stride: isize,
    /// Numbers from a component to the next one, of positions, normals and gradients.
    pub component_stride: isize,
}

/// Receivers.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct PointsF64 {
    /// How many there are.
    pub count: usize,
    /// Their positions, three components.
    pub position: ArrayF64,
    /// Their normals, three components, of any length but 0.
    pub normal: ArrayF64,
    /// Their reflectances, in [0, 1]; 1 if NULL.
    pub reflectance: ArrayF64,
}

/// Where answers go. Arrays that are NULL are not written.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct AnswersF64 {
    /// Radiosity.
    pub radiosity: ArrayF64,
    /// Gradient, three components.
    pub gradient: ArrayF64,
    /// Proven bounds on the errors of the radiosity.
    pub radiosity_error: ArrayF64,
    /// Proven bounds on the norms of the errors of the gradient.
    pub gradient_error: ArrayF64,
}

/// Numbers in memory: that of point `i` and component `k` is `data[i * point_stride + k * component_stride]`.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct ArrayF32 {
    /// The first number. NULL where nothing is given, or nothing is wanted.
    pub data: *mut f32,
    /// Numbers from a point to the next one; 0 if all points have the same.
    pub point_stride: isize,
    /// Numbers from a component to the next one, of positions, normals and gradients.
    pub component_stride: isize,
}

/// Receivers.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct PointsF32 {
    /// How many there are.
    pub count: usize,
    /// Their positions, three components.
    pub position: ArrayF32,
    /// Their normals, three components, of any length but 0.
    pub normal: ArrayF32,
    /// Their reflectances, in [0, 1]; 1 if NULL.
    pub reflectance: ArrayF32,
}

/// Where answers go. Arrays that are NULL are not written.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct AnswersF32 {
    /// Radiosity.
    pub radiosity: ArrayF32,
    /// Gradient, three components.
    pub gradient: ArrayF32,
    /// Proven bounds on the errors of the radiosity.
    pub radiosity_error: ArrayF32,
    /// Proven bounds on the norms of the errors of the gradient.
    pub gradient_error: ArrayF32,
}

macro_rules! strides {
    ($number:ty, $array:ident, $points:ident, $answers:ident) => {
        impl $array {
            /// The number of a point and a component.
            ///
            /// # Safety
            /// It must be there.
            unsafe fn read(&self, point: usize, component: usize) -> $number {
                // SAFETY: the caller of the library says that its arrays have as many points as it states, with these strides.
                unsafe { *self.data.wrapping_offset(self.offset(point, component)) }
            }

            /// Writes it, if it is wanted.
            ///
            /// # Safety
            /// It must be there, and nobody else may use it meanwhile.
            unsafe fn write(&self, point: usize, component: usize, value: $number) {
                if !self.data.is_null() {
                    // SAFETY: as for reading; the header forbids that another thread reads or writes the array meanwhile.
                    unsafe { *self.data.wrapping_offset(self.offset(point, component)) = value }
                }
            }

            const fn offset(&self, point: usize, component: usize) -> isize {
                let [point, component] = [point.cast_signed(), component.cast_signed()];
                point.wrapping_mul(self.point_stride).wrapping_add(component.wrapping_mul(self.component_stride))
            }
        }

        impl $points {
            /// Whether no required array is NULL.
            pub(crate) const fn is_whole(&self) -> bool {
                self.count == 0 || !(self.position.data.is_null() || self.normal.data.is_null())
            }

            /// Reads points from `first` on as columns; the last one again and again where they are fewer than the columns are long.
            ///
            /// # Safety
            /// The arrays must have `count` points.
            pub(crate) unsafe fn read(
                &self,
                first: usize,
                [position, normal]: [&mut [Vec<$number>; 3]; 2],
                reflectance: &mut [$number],
            ) {
                for (entry, share) in reflectance.iter_mut().enumerate() {
                    let point = (first + entry).min(self.count - 1);
                    for axis in 0..3 {
                        // SAFETY: `point` is below the count.
                        position[axis][entry] = unsafe { self.position.read(point, axis) };
                        // SAFETY: the same.
                        normal[axis][entry] = unsafe { self.normal.read(point, axis) };
                    }
                    // SAFETY: the same.
                    *share = if self.reflectance.data.is_null() { 1.0 } else { unsafe { self.reflectance.read(point, 0) } };
                }
            }
        }

        impl $answers {
            /// Writes the first answers to the points from `first` on.
            ///
            /// # Safety
            /// The arrays must have as many points, and nobody else may use them meanwhile.
            pub(crate) unsafe fn write(&self, first: usize, count: usize, answers: &Answers<$number>) {
                for entry in 0..count {
                    let point = first + entry;
                    // SAFETY: the caller says that these points are there.
                    unsafe {
                        self.radiosity.write(point, 0, answers.radiosity[entry]);
                        self.radiosity_error.write(point, 0, answers.radiosity_error[entry]);
                        for axis in 0..3 {
                            self.gradient.write(point, axis, answers.gradient[axis][entry]);
                        }
                        self.gradient_error.write(point, 0, answers.gradient_error[entry]);
                    }
                }
            }
        }
    };
}

strides!(f64, ArrayF64, PointsF64, AnswersF64);
strides!(f32, ArrayF32, PointsF32, AnswersF32);
