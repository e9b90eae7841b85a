"""Design by gradients: where two lamps hang, how they are turned and how large they are so that a desk is lit evenly and to 300 lux, by scipy's
optimiser with exact derivatives, inside bounds.

    python an_even_desk.py
"""

# %% A desk, and what may change of each lamp: its place along and across, a turn about the vertical, a tilt, and its half length
import numpy as np

import radgrad as rg

try:
    from scipy.optimize import minimize
except ImportError:
    raise SystemExit("SKIPPED: scipy is not installed")

desk = np.stack(np.meshgrid(np.linspace(0, 1.6, 17), np.linspace(0, 0.8, 9), [0.0]), axis=-1).reshape(-1, 3)
HEIGHT, HALF_WIDTH, EMITTED, WANTED = 1.0, 0.06, 8000.0, 300.0
low, high = np.array([0.0, 0.0, -1.5, -0.4, 0.1] * 2), np.array([1.6, 0.8, 1.5, 0.4, 0.5] * 2)


def outline(x, y, turn, tilt, half):
    """The vertices of a lamp, and their derivatives by its five parameters: (5, 4, 3)."""
    along = np.array([np.cos(turn), np.sin(turn), 0])
    across = np.array([-np.sin(turn) * np.cos(tilt), np.cos(turn) * np.cos(tilt), np.sin(tilt)])
    by_tilt = np.array([np.sin(turn) * np.sin(tilt), -np.cos(turn) * np.sin(tilt), np.cos(tilt)])
    about = np.array([-along[1], along[0], 0]), np.array([-across[1], across[0], 0])
    a, b = np.array([[-1.0], [-1], [1], [1]]), np.array([[-1.0], [1], [1], [-1]]) * HALF_WIDTH
    by = [np.tile([1.0, 0, 0], (4, 1)), np.tile([0, 1.0, 0], (4, 1)), a * half * about[0] + b * about[1], b * by_tilt, a * along]
    return [x, y, HEIGHT] + a * half * along + b * across, np.array(by)


# %% Each lamp's derivatives by its vertices, times what moves these
def unsuited(parameters):
    """The mean square of how far the desk is off 300 lux, relative, and its derivatives."""
    value, slopes = np.zeros(len(desk)), []
    for vertices, by in (outline(*lamp) for lamp in parameters.reshape(2, 5)):
        d = rg.derivatives(desk, [0, 0, 1], rg.Emitter(vertices, EMITTED))
        value += d.radiosity
        slopes.append(np.einsum("nvi,pvi->np", d.vertices, by))
    off = value / WANTED - 1
    return np.mean(off**2), 2 * off @ np.hstack(slopes) / (len(desk) * WANTED)


# %% The derivatives are those of differences
start = np.array([0.5, 0.3, 0.3, 0.0, 0.3, 1.1, 0.5, -0.2, 0.1, 0.2])
step = 1e-6
difference = [(unsuited(start + step * e)[0] - unsuited(start - step * e)[0]) / (2 * step) for e in np.eye(10)]
assert np.allclose(difference, unsuited(start)[1], atol=1e-6)

# %% Found in some steps
found = minimize(unsuited, start, jac=True, bounds=list(zip(low, high)), method="L-BFGS-B", options={"maxiter": 200})
before, after = (np.sqrt(unsuited(at)[0]) for at in (start, found.x))
print(f"off {WANTED:.0f} lux: {before:.1%} before, {after:.1%} after, in {found.nfev} evaluations")
for x, y, turn, tilt, half in found.x.reshape(2, 5):
    print(f"a lamp of {2 * half:.2f} m at ({x:.2f}, {y:.2f}), turned by {np.degrees(turn):.0f} and tilted by {np.degrees(tilt):.0f} degrees")
assert after < 0.09 < 0.4 < before and found.nfev < 100 and np.all((low <= found.x) & (found.x <= high))
assert np.allclose(found.x[[0, 1, 4]], [1.6 - found.x[5], found.x[6], found.x[9]], atol=0.01), "what is symmetric is lit symmetrically"
