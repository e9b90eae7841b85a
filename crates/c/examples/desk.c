/* How bright a desk is below a lamp: a row of points as structures (AoS), the same as columns (SoA), one point by itself, and what
   that gains as a corner of the lamp moves.
   cc desk.c -Iinclude -lradgrad_c -lm */
#include <math.h>
#include <stdio.h>

#include "radgrad.h"

enum { COUNT = 1000 };
struct point { double at[3], normal[3], lux, error; };

int main(void) {
    const double corners[4][3] = {{0, 0, 1}, {0, 1, 1}, {1, 1, 1}, {1, 0, 1}};
    radgrad_emitter *lamp;
    if (radgrad_emitter_constant(&corners[0][0], 4, 100.0, &lamp) != RADGRAD_OK) return 1;

    static struct point desk[COUNT];
    static double x[COUNT], y[COUNT], z[COUNT], columns[3][COUNT];
    for (int i = 0; i < COUNT; i++) {
        desk[i] = (struct point){{i / (double)COUNT, 0.5, 0}, {0, 0, 1}, 0, 0};
        columns[0][i] = desk[i].at[0], columns[1][i] = 0.5, columns[2][i] = 0;
    }
    const ptrdiff_t row = sizeof(struct point) / sizeof(double);
    static double up[3] = {0, 0, 1}, share = 0.8;
    radgrad_room *room = radgrad_room_new();

    const radgrad_points_f64 rows = {COUNT, {desk[0].at, row, 1}, {desk[0].normal, row, 1}, {&share, 0, 0}};
    const radgrad_answers_f64 into = {{&desk[0].lux, row, 0}, {NULL, 0, 0}, {&desk[0].error, row, 0}, {NULL, 0, 0}};
    if (radgrad_batch_f64(room, lamp, rows, 1e-12, into, NULL) != RADGRAD_OK) return 2;

    const radgrad_points_f64 cols = {COUNT, {columns[0], 1, COUNT}, {up, 0, 1}, {&share, 0, 0}};
    const radgrad_answers_f64 slopes = {{x, 1, 0}, {NULL, 0, 0}, {y, 1, 0}, {z, 1, 0}};
    if (radgrad_batch_f64(room, lamp, cols, 1e-12, slopes, NULL) != RADGRAD_OK) return 3;
    for (int i = 0; i < COUNT; i++)
        if (x[i] != desk[i].lux || y[i] != desk[i].error || !(y[i] <= 1e-12 * x[i])) return 4;

    radgrad_answer one;
    if (radgrad_evaluate(lamp, desk[500].at, up, share, 1e-12, &one) != RADGRAD_OK) return 5;
    if (fabs(one.radiosity - x[500]) > one.radiosity_error + y[500]) return 6;
    printf("in the middle of the desk: %.12f +- %.0e\n", one.radiosity, one.radiosity_error);

    radgrad_slopes slopes_there;
    double by_corner[4][4], by_emission[2], sum = 0;
    if (radgrad_derivatives(lamp, desk[500].at, up, share, 1e-12, &slopes_there, &by_corner[0][0], by_emission) != RADGRAD_OK) return 7;
    for (int k = 0; k < 4; k++) sum += by_corner[k][2];
    /* Raising the lamp is lowering the desk; the radiosity is 100 times that of an emission of 1. */
    if (fabs(sum + slopes_there.answer.gradient[2]) > 1e-10 || fabs(100 * by_emission[0] - one.radiosity) > 1e-10) return 8;
    printf("a lamp higher by 1 mm: %+.6f\n", 1e-3 * sum);
    radgrad_room_free(room);
    radgrad_emitter_free(lamp);
    return 0;
}
