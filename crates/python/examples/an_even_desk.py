"""Design by derivatives: two lamps are moved, turned and sized until a desk is lit evenly, light by way of walls and ceiling included.

    python an_even_desk.py [PICTURE.png]
"""

# %% A room with a desk, and two lamps that hang in it
import sys

import numpy as np

import radgrad as rg

try:
    from scipy.optimize import minimize
except ImportError:
    raise SystemExit("SKIPPED: scipy is not installed")

low, high = np.array([0, 0, 0]), np.array([4.0, 3.0, 2.5])
room = np.array([[x, y, z] for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])])
desk = np.array([[1.0, 0.8, 0.75], [3.0, 0.8, 0.75], [3.0, 1.8, 0.75], [1.0, 1.8, 0.75]])
walls = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
faces = [*walls, [8, 9, 10, 11], [12, 13, 14, 15], [16, 17, 18, 19]]
lamps = [7, 8]
reflectance = [0.3, 0.8, 0.6, 0.6, 0.6, 0.6, 0.4, 0.0, 0.0]
emission = [0.0] * 7 + [400.0] * 2

# %% A lamp has four parameters: where it hangs, how it is turned, and the logarithm of its size. It gives light downward.
flat = np.array([[-0.3, -0.1], [-0.3, 0.1], [0.3, 0.1], [0.3, -0.1]])


def lamp(parameters):
    """Its corners, and their derivatives by the parameters: (4, 3) and (4, 3, 4)."""
    x, y, angle, size = parameters
    turned = np.exp(size) * flat @ np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    corners = np.column_stack([turned + [x, y], np.full(4, 2.2)])
    slopes = np.zeros((4, 3, 4))
    slopes[:, 0, 0] = slopes[:, 1, 1] = 1
    slopes[:, :2, 2] = np.column_stack([-turned[:, 1], turned[:, 0]])
    slopes[:, :2, 3] = turned
    return corners, slopes


# %% How uneven the light on the desk is, and all its derivatives from one solution
points = np.stack(np.meshgrid(np.linspace(1.05, 2.95, 9), np.linspace(0.85, 1.75, 5), [0.75]), axis=-1).reshape(-1, 3)
up = np.tile([0.0, 0, 1], (len(points), 1))


def light(parameters):
    """The solved room and the radiosity of the points of the desk."""
    vertices = np.concatenate([room, desk, *(lamp(of)[0] for of in parameters.reshape(2, 4))])
    s = rg.Scene(vertices, faces, reflectance=reflectance, emission=emission).solve(error=0.02)
    return s, s.gather(points, up).radiosity[:, 0]


def uneven(parameters):
    """The variance of the radiosity over its squared mean, and its slopes, which are those of a weighted sum: one importance has them all."""
    s, b = light(parameters)
    mean = b.mean()
    off = b / mean - 1
    weights = 2 / (len(b) * mean) * (off - (off * b / mean).mean())
    d = s.derivative(weights, points=(points, up), vertices=lamps)
    slopes = [np.einsum("vi,vip->p", by[:, 0], lamp(of)[1]) for by, of in zip(d.vertices, parameters.reshape(2, 4))]
    return np.mean(off**2), np.concatenate(slopes)


# %% Beside a difference, along the steepest way
start = np.array([1.6, 1.2, 0.0, 0.0, 2.4, 1.6, 0.0, 0.0])
slopes = uneven(start)[1]
along, step = slopes / np.linalg.norm(slopes), 0.05
difference = (uneven(start + step * along)[0] - uneven(start - step * along)[0]) / (2 * step)
print(f"along the steepest way: {slopes @ along:.5f}, by a difference {difference:.5f}")
assert abs(slopes @ along - difference) < 0.05 * abs(difference)

# %% Inside bounds: the lamps stay over the room, no more than half as large again
bounds = [(0.5, 3.5), (0.5, 2.5), (-1.6, 1.6), (-0.4, 0.4)] * 2
found = minimize(uneven, start, jac=True, method="L-BFGS-B", bounds=bounds, options={"maxiter": 12, "ftol": 1e-4})
(_, before), (_, after) = light(start), light(found.x)


def uniformity(b):
    """The least over the mean, as standards of lighting ask for."""
    return b.min() / b.mean()


print(f"least over mean: {uniformity(before):.3f} before, {uniformity(after):.3f} after, in {found.nfev} solutions")
print(f"lamps (x, y, turn, log size): {found.x.reshape(2, 4).round(3).tolist()}")
assert uniformity(after) > uniformity(before) + 0.05 and after.std() / after.mean() < 0.5 * before.std() / before.mean()
assert all(a - 1e-9 <= x <= b + 1e-9 for x, (a, b) in zip(found.x, bounds))

# %% A picture of the desk before and after, if one is asked for
if len(sys.argv) > 1:
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(1, 2, figsize=(9, 2.8), constrained_layout=True)
    for axis, b, parameters, title in zip(axes, (before, after), (start, found.x), ("before", "after")):
        drawn = axis.contourf(*points[:, :2].T.reshape(2, 5, 9), (b / b.mean()).reshape(5, 9), np.linspace(0.6, 1.3, 15), extend="both")
        for of in parameters.reshape(2, 4):
            axis.plot(*lamp(of)[0][[0, 1, 2, 3, 0], :2].T, "w-")
        axis.set(title=f"{title}: least over mean {uniformity(b):.2f}", xlabel="x, m", ylabel="y, m", aspect="equal")
    figure.colorbar(drawn, ax=axes, label="radiosity over mean")
    figure.savefig(sys.argv[1], dpi=110)
