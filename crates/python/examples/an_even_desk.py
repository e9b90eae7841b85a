"""Design by gradients: where two lamps should hang so that a desk is lit evenly, by scipy's optimiser with exact derivatives.

    python an_even_desk.py
"""

# %% A desk, and two lamps of 30 cm whose places along the room are to be found
import numpy as np

import radgrad as rg

try:
    from scipy.optimize import minimize
except ImportError:
    raise SystemExit("SKIPPED: scipy is not installed")

desk = np.stack(np.meshgrid(np.linspace(0, 1.6, 25), np.linspace(0, 0.8, 13), [0.0]), axis=-1).reshape(-1, 3)
corners = np.array([[-0.15, -0.15, 1.0], [-0.15, 0.15, 1.0], [0.15, 0.15, 1.0], [0.15, -0.15, 1.0]])
lamp = rg.Emitter(corners, 100.0)


# %% A lamp that moves by d gives a point at x what it gave one at x - d before: minus our gradient is what moving the lamp does
def uneven(places):
    """The variance of the radiosity over its squared mean, and its derivatives by the places of the lamps."""
    places = places.reshape(-1, 2)
    value, slopes = np.zeros(len(desk)), []
    for place in places:
        a = rg.evaluate(desk - [*place, 0], [0, 0, 1], lamp)
        value += a.radiosity
        slopes.append(-a.gradient[:, :2])
    mean = value.mean()
    off = value / mean - 1
    # d(mean square of off): each point's slope, less what the mean takes with it.
    derivative = [2 / mean * ((off[:, None] * slope).mean(0) - (off * value / mean).mean() * slope.mean(0)) for slope in slopes]
    return np.mean(off**2), np.concatenate(derivative)


# %% The derivatives are those of differences
start = np.array([0.6, 0.4, 1.0, 0.4])
step = 1e-6
difference = [(uneven(start + step * e)[0] - uneven(start - step * e)[0]) / (2 * step) for e in np.eye(4)]
assert np.allclose(difference, uneven(start)[1], atol=1e-7)

# %% Found in a few steps
found = minimize(uneven, start, jac=True, method="BFGS")
before, after = (np.sqrt(uneven(at)[0]) for at in (start, found.x))
print(f"deviation from the mean: {before:.1%} before, {after:.1%} after, in {found.nfev} evaluations")
print(f"lamps at {found.x.reshape(-1, 2).round(3).tolist()}")
assert after < 0.8 * before and found.nfev < 100
assert np.allclose(found.x[0] + found.x[2], 1.6, atol=1e-3), "what is symmetric is lit symmetrically"
