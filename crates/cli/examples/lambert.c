/* The radiosity of a point due to a polygon of constant emission by Lambert's sum, as most programs have it:
 *
 *     B = rho / (2 pi) sum_i angle(r_i, r_{i+1}) n . (r_i x r_{i+1}) / |r_i x r_{i+1}|
 *
 * with the angle from the arc cosine of a scalar product. Cases are read as JSON Lines and answered in the format of `radgrad eval`:
 *
 *     cc -O2 -o lambert lambert.c -lm
 *     radgrad audit --program ./lambert
 *
 * The audit shows where the digits go: all of them far away, where the terms cancel and the arc cosine of a number next to 1 has
 * half its digits to begin with; half of them next to an edge and its line, where an angle is next to pi or to 0.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MOST 64
#define LONGEST (1 << 20)

typedef struct { double x, y, z; } V;

static V sub(V a, V b) { return (V){a.x - b.x, a.y - b.y, a.z - b.z}; }
static V add(V a, double t, V b) { return (V){a.x + t * b.x, a.y + t * b.y, a.z + t * b.z}; }
static double dot(V a, V b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static V cross(V a, V b) { return (V){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }

/* What follows a key in the line, or NULL. */
static const char *after(const char *line, const char *key) {
    const char *at = strstr(line, key);
    return at ? at + strlen(key) : NULL;
}

static const char *number(const char *at, double *value) {
    while (*at == '[' || *at == ',' || *at == ' ') at++;
    char *end;
    *value = strtod(at, &end);
    return end == at ? NULL : end;
}

static const char *vector(const char *at, V *v) {
    if ((at = number(at, &v->x)) && (at = number(at, &v->y))) at = number(at, &v->z);
    return at;
}

/* The part of the polygon above the horizon, relative to the receiver (Sutherland and Hodgman 1974). */
static int above(const V *r, int count, V n, V *out) {
    int kept = 0;
    for (int i = 0; i < count; i++) {
        V a = r[i], b = r[(i + 1) % count];
        double p = dot(n, a), q = dot(n, b);
        if (p > 0) out[kept++] = a;
        if ((p > 0) != (q > 0)) out[kept++] = add(a, p / (p - q), sub(b, a));
    }
    return kept;
}

static double lambert(const V *r, int count, V n) {
    double sum = 0;
    for (int i = 0; i < count; i++) {
        V a = r[i], b = r[(i + 1) % count], w = cross(a, b);
        double cosine = dot(a, b) / sqrt(dot(a, a) * dot(b, b)), length = sqrt(dot(w, w));
        if (length > 0) sum += acos(fmax(-1, fmin(1, cosine))) * dot(n, w) / length;
    }
    return -sum;
}

static char line[LONGEST];

int main(void) {
    const double pi = 3.14159265358979323846;
    while (fgets(line, sizeof line, stdin)) {
        const char *id = after(line, "\"id\":\""), *end = id ? strchr(id, '"') : NULL;
        int length = end ? (int)(end - id) : 0;
        const char *at = after(line, "\"vertices\":["), *position = after(line, "\"position\":");
        const char *normal = after(line, "\"normal\":"), *emission = after(line, "\"constant\":");
        const char *rho = after(line, "\"reflectance\":"), *occluders = after(line, "\"occluders\":[");
        V vertices[MOST], r[MOST], seen[2 * MOST], x, n, n2 = {0, 0, 0};
        double emitted, reflectance = 1;
        int count = 0;
        if (!emission || !position || !normal || !at || (occluders && *occluders != ']')) {
            printf("{\"id\":\"%.*s\",\"error\":\"only constant emission in free sight\"}\n", length, id ? id : "");
            fflush(stdout);
            continue;
        }
        vector(position, &x);
        vector(normal, &n);
        number(emission, &emitted);
        if (rho) number(rho, &reflectance);
        while (at && *at != ']' && count < MOST) {
            at = vector(at, &vertices[count++]);
            /* Past the end of the vertex, to the next one or the end of the list. */
            while (at && *at == ']' && at[1] == ',') at += 2;
            if (at && *at == ']') at++;
        }
        for (int i = 0; i < count; i++) {
            r[i] = sub(vertices[i], x);
            n2 = add(n2, 1, cross(sub(vertices[i], vertices[0]), sub(vertices[(i + 1) % count], vertices[0])));
        }
        double size = sqrt(dot(n, n)), sum = 0;
        n = (V){n.x / size, n.y / size, n.z / size};
        if (dot(n2, r[0]) < 0) sum = lambert(seen, above(r, count, n, seen), n);
        printf("{\"id\":\"%.*s\",\"radiosity\":%.17g}\n", length, id ? id : "", reflectance * emitted * sum / (2 * pi));
        fflush(stdout);
    }
    return 0;
}
