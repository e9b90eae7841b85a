#ifndef RADGRAD_H
#define RADGRAD_H

/* Made by `cbindgen crates/c --output crates/c/include/radgrad.h`; do not edit. */

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

// The status of a call.
typedef enum radgrad_status {
  // All is answered.
  RADGRAD_OK = 0,
  // A pointer that must not be NULL is.
  RADGRAD_NULL = 1,
  // A position or a normal is not finite, a normal is 0, or a reflectance is not in [0, 1].
  RADGRAD_RECEIVER = 2,
  // The polygon or its emission is refused: `radgrad_message` says why.
  RADGRAD_EMITTER = 3,
  // The tolerance is not in [0, 1].
  RADGRAD_TOLERANCE = 4,
  // A result leaves the range of its type.
  RADGRAD_RANGE = 5,
  // The library failed as it should not: please report it.
  RADGRAD_FAULT = 6,
} radgrad_status;

// A polygon that emits, ready for batches in both precisions.
typedef struct radgrad_emitter radgrad_emitter;

// The memory that batches work in. Made once for each thread.
typedef struct radgrad_room radgrad_room;

// Radiosity and gradient with proven bounds.
typedef struct radgrad_answer {
  // Radiosity.
  double radiosity;
  // Proven bound on its error.
  double radiosity_error;
  // Derivatives with respect to the position at a fixed normal.
  double gradient[3];
  // Proven bound on the Euclidean norm of the error of the gradient.
  double gradient_error;
} radgrad_answer;

// Radiosity and its derivatives by position, normal and reflectance, with proven bounds.
typedef struct radgrad_slopes {
  // Radiosity and gradient.
  struct radgrad_answer answer;
  // Derivatives with respect to the unit normal, in the unit of the emission; as it turns only the part across it counts.
  double normal[3];
  // Proven bound on the Euclidean norm of their error.
  double normal_error;
  // Derivative with respect to the reflectance, in the unit of the emission.
  double reflectance;
  // Proven bound on its error.
  double reflectance_error;
} radgrad_slopes;

// Numbers in memory: that of point `i` and component `k` is `data[i * point_stride + k * component_stride]`.
typedef struct radgrad_array_f64 {
  // The first number. NULL where nothing is given, or nothing is wanted.
  double *data;
  // Numbers from a point to the next one; 0 if all points have the same.
  ptrdiff_t point_stride;
  // Numbers from a component to the next one, of positions, normals and gradients.
  ptrdiff_t component_stride;
} radgrad_array_f64;

// Receivers.
typedef struct radgrad_points_f64 {
  // How many there are.
  size_t count;
  // Their positions, three components.
  struct radgrad_array_f64 position;
  // Their normals, three components, of any length but 0.
  struct radgrad_array_f64 normal;
  // Their reflectances, in [0, 1]; 1 if NULL.
  struct radgrad_array_f64 reflectance;
} radgrad_points_f64;

// Where answers go. Arrays that are NULL are not written.
typedef struct radgrad_answers_f64 {
  // Radiosity.
  struct radgrad_array_f64 radiosity;
  // Gradient, three components.
  struct radgrad_array_f64 gradient;
  // Proven bounds on the errors of the radiosity.
  struct radgrad_array_f64 radiosity_error;
  // Proven bounds on the norms of the errors of the gradient.
  struct radgrad_array_f64 gradient_error;
} radgrad_answers_f64;

// Numbers in memory: that of point `i` and component `k` is `data[i * point_stride + k * component_stride]`.
typedef struct radgrad_array_f32 {
  // The first number. NULL where nothing is given, or nothing is wanted.
  float *data;
  // Numbers from a point to the next one; 0 if all points have the same.
  ptrdiff_t point_stride;
  // Numbers from a component to the next one, of positions, normals and gradients.
  ptrdiff_t component_stride;
} radgrad_array_f32;

// Receivers.
typedef struct radgrad_points_f32 {
  // How many there are.
  size_t count;
  // Their positions, three components.
  struct radgrad_array_f32 position;
  // Their normals, three components, of any length but 0.
  struct radgrad_array_f32 normal;
  // Their reflectances, in [0, 1]; 1 if NULL.
  struct radgrad_array_f32 reflectance;
} radgrad_points_f32;

// Where answers go. Arrays that are NULL are not written.
typedef struct radgrad_answers_f32 {
  // Radiosity.
  struct radgrad_array_f32 radiosity;
  // Gradient, three components.
  struct radgrad_array_f32 gradient;
  // Proven bounds on the errors of the radiosity.
  struct radgrad_array_f32 radiosity_error;
  // Proven bounds on the norms of the errors of the gradient.
  struct radgrad_array_f32 gradient_error;
} radgrad_answers_f32;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Makes an emitter with the same emission everywhere, from `count` vertices of three coordinates each.
//
// # Safety
// `vertices` has three times `count` numbers, and `emitter` room for an address, which `radgrad_emitter_free` takes.
enum radgrad_status radgrad_emitter_constant(const double *vertices,
                                             size_t count,
                                             double emission,
                                             struct radgrad_emitter **emitter);

// Makes an emitter with an emission for each vertex; of more than three they must lie on one affine function.
//
// # Safety
// `vertices` has three times `count` numbers, `emission` as many as `count`, and `emitter` room for an address, which
// `radgrad_emitter_free` takes.
enum radgrad_status radgrad_emitter_linear(const double *vertices,
                                           size_t count,
                                           const double *emission,
                                           struct radgrad_emitter **emitter);

// Makes an emitter with an emission that is `value` at vertex 0 and has a gradient, of three components.
//
// # Safety
// `vertices` has three times `count` numbers, `gradient` three, and `emitter` room for an address, which `radgrad_emitter_free` takes.
enum radgrad_status radgrad_emitter_affine(const double *vertices,
                                           size_t count,
                                           double value,
                                           const double *gradient,
                                           struct radgrad_emitter **emitter);

// Frees an emitter; NULL is none.
//
// # Safety
// It was made by a function of this library, and is not used any more.
void radgrad_emitter_free(struct radgrad_emitter *emitter);

// Writes why the last emitter of this thread was refused: text that ends with a 0, cut to `size` bytes. Returns the bytes of the whole
// text, without the 0.
//
// # Safety
// `text` has room for `size` bytes, or is NULL.
size_t radgrad_message(char *text,
                       size_t size);

// Radiosity and gradient of a receiver due to an emitter, to a relative tolerance. It neither allocates, locks nor unwinds.
//
// # Safety
// `position` and `normal` have three numbers each, `emitter` was made by this library, and `answer` can be written.
enum radgrad_status radgrad_evaluate(const struct radgrad_emitter *emitter,
                                     const double *position,
                                     const double *normal,
                                     double reflectance,
                                     double tolerance,
                                     struct radgrad_answer *answer);

// Derivatives of a receiver's radiosity by everything that shapes it, to a tolerance relative to the largest of their kind. It may
// allocate; it neither locks nor unwinds.
//
// `vertices`, unless it is NULL, gets four numbers for each vertex of the emitter: three derivatives, in the unit of the emission over
// that of length, and a proven bound on the norm of their error. `emission`, unless it is NULL, gets two numbers for each parameter
// of the emission, the derivative and its bound: of a constant emission for the constant; for the value at each vertex; or for the value,
// and then three, in the unit of length, for the gradient. Vertex values move with their vertices, an emission with a gradient moves with
// vertex 0. Of more than three vertices the derivatives are those for motions that keep the polygon flat.
//
// # Safety
// `position` and `normal` have three numbers each, `emitter` was made by this library, `slopes` can be written, and `vertices` and
// `emission` have room for those numbers.
enum radgrad_status radgrad_derivatives(const struct radgrad_emitter *emitter,
                                        const double *position,
                                        const double *normal,
                                        double reflectance,
                                        double tolerance,
                                        struct radgrad_slopes *slopes,
                                        double *vertices,
                                        double *emission);

// Makes a room, of 160 kB. NULL if the library fails as it should not.
struct radgrad_room *radgrad_room_new(void);

// Frees a room; NULL is none.
//
// # Safety
// It was made by `radgrad_room_new`, and is not used any more.
void radgrad_room_free(struct radgrad_room *room);

// Radiosity and gradient of many receivers due to an emitter, to a relative tolerance. It neither allocates, locks nor unwinds.
//
// A receiver that is refused ends it: `failed`, unless it is NULL, is then its place. Answers to points before it may be written already.
//
// # Safety
// `room` and `emitter` were made by this library, and no other thread uses `room`; the arrays of `points` and `answers` have
// `points.count` points, and nobody else uses those of `answers` meanwhile.
enum radgrad_status radgrad_batch_f64(struct radgrad_room *room,
                                      const struct radgrad_emitter *emitter,
                                      struct radgrad_points_f64 points,
                                      double tolerance,
                                      struct radgrad_answers_f64 answers,
                                      size_t *failed);

// The same in single precision, twice as fast to tolerances of 1e-5: bounds hold what its rounding adds, and reach no 1e-7.
//
// A receiver that is refused ends it: `failed`, unless it is NULL, is then its place. Answers to points before it may be written already.
//
// # Safety
// `room` and `emitter` were made by this library, and no other thread uses `room`; the arrays of `points` and `answers` have
// `points.count` points, and nobody else uses those of `answers` meanwhile.
enum radgrad_status radgrad_batch_f32(struct radgrad_room *room,
                                      const struct radgrad_emitter *emitter,
                                      struct radgrad_points_f32 points,
                                      double tolerance,
                                      struct radgrad_answers_f32 answers,
                                      size_t *failed);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* RADGRAD_H */
