"""Inverse design: the paints of a room and the power of its lamp from forty measured values, by exact derivatives through all reflections.

    python paints_from_measurements.py
"""

# %% A room with a table; faces of one paint, and a lamp
import numpy as np

import radgrad as rg

try:
    from scipy.optimize import least_squares
except ImportError:
    raise SystemExit("SKIPPED: scipy is not installed")


def box(low, high, inward):
    """Six faces: floor, ceiling, and four walls."""
    v = np.array([[x, y, z] for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])])
    f = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return v, f if inward else [face[::-1] for face in f]


room, inside = box([0, 0, 0], [4, 3, 2.5], True)
table, outside = box([1.2, 0.8, 0.7], [2.4, 1.6, 0.75], False)
lamp = np.array([[1.8, 1.3, 2.4], [1.8, 1.7, 2.4], [2.2, 1.7, 2.4], [2.2, 1.3, 2.4]])
vertices = np.concatenate([room, table, lamp])
faces = inside + [[8 + i for i in face] for face in outside] + [[16, 17, 18, 19]]
paint = np.array([0, 1, 2, 2, 3, 3] + [4] * 6 + [5])
is_lamp = paint == 5


def solved(parameters):
    """The room with five reflectances and the lamp's emission, in units of 100."""
    reflectance = np.append(parameters[:5], 0.0)[paint]
    return rg.Scene(vertices, faces, reflectance=reflectance, emission=100 * parameters[5] * is_lamp).solve(error=2e-3)


# %% Forty sensors: most on walls, where they read the radiosity, some above the floor, where they read the irradiance
random = np.random.default_rng(4)
u = random.uniform(0.1, 0.9, (40, 2))
points, normals = np.zeros((40, 3)), np.zeros((40, 3))
for i, (a, b) in enumerate(u):
    wall = i % 5
    points[i] = [[4 * a, 3 * b, 0.0], [4 * a, 3 * b, 2.5], [4 * a, 0.0, 2.5 * b], [0.0, 3 * a, 2.5 * b], [4 * a, 3 * b, 1.2]][wall]
    normals[i] = [[0, 0, 1], [0, 0, -1], [0, 1, 0], [1, 0, 0], [0, 0, 1]][wall]

truth = np.array([0.25, 0.8, 0.55, 0.4, 0.35, 1.5])
measured = solved(truth).gather(points, normals).radiosity[:, 0] * random.normal(1, 0.002, 40)


# %% Each sensor's derivatives by all faces at once; faces of one paint add up
def fit(parameters):
    """Relative differences from what was measured, and their derivatives by the parameters."""
    s = solved(parameters)
    rows = [s.derivative(weight, points=(points, normals)) for weight in np.eye(40)]
    by_paint = np.array([[d.reflectance[paint == p, 0].sum() for p in range(5)] for d in rows])
    by_lamp = np.array([[100 * d.emission[is_lamp, 0].sum()] for d in rows])
    value = np.array([d.value[0] for d in rows])
    return value / measured - 1, np.hstack([by_paint, by_lamp]) / measured[:, None]


class Memory:
    """Both answers of one solution."""

    def __call__(self, parameters):
        self.at, (self.off, self.slopes) = parameters.copy(), fit(parameters)
        return self.off

    def jacobian(self, parameters):
        if not np.array_equal(parameters, self.at):
            self(parameters)
        return self.slopes


memory = Memory()
found = least_squares(memory, [0.5] * 5 + [1.0], memory.jacobian, bounds=([0] * 6, [0.95] * 5 + [10]), xtol=1e-4, ftol=1e-5)
print(f"{found.nfev} solutions; found {found.x.round(3).tolist()}, painted {truth.tolist()}")
assert found.nfev <= 15 and np.abs(found.x / truth - 1).max() < 0.05
