"""A lamp over a floor: how bright it is, which way it gets brighter, and how sure that is.

    python a_lamp_and_its_gradient.py [picture.png]
"""

# %% A lamp whose emission rises from one corner to the other
import sys

import numpy as np

import radgrad as rg

lamp = rg.Emitter([[0, 0, 1], [0, 1, 1], [1, 1, 1], [1, 0, 1]], [1, 2, 3, 2])

# %% The floor below it, on a grid
side = np.linspace(-1, 2, 121)
x, y = np.meshgrid(side, side)
floor = np.stack([x, y, np.zeros_like(x)], axis=-1)
a = rg.evaluate(floor, [0, 0, 1], lamp, reflectance=0.8)
print(f"{a.radiosity.size} points, from {a.radiosity.min():.4f} to {a.radiosity.max():.4f}")
print(f"worst bound {np.max(a.radiosity_error / a.radiosity):.0e} of the value")

# %% Where it is brightest, the gradient along the floor vanishes
slope = np.linalg.norm(a.gradient[..., :2], axis=-1)
brightest = np.unravel_index(np.argmax(a.radiosity), a.radiosity.shape)
print(f"brightest at {floor[brightest][:2]}, slope {slope[brightest]:.1e} there and {slope.max():.2f} at most")
assert slope[brightest] < 0.02 * slope.max()

# %% A difference of two values agrees with it
step = 1e-4
here = floor[40, 70]
up, down = (rg.evaluate(here + [s, 0, 0], [0, 0, 1], lamp, reflectance=0.8).radiosity for s in (step, -step))
assert abs((up - down) / (2 * step) - a.gradient[40, 70, 0]) < 1e-7

# %% Drawn
try:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
except ImportError:
    print("no picture: matplotlib is not installed")
else:
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.6), constrained_layout=True)
    for axis, values, title in ((axes[0], a.radiosity, "radiosity"), (axes[1], slope, "slope along the floor")):
        shown = axis.pcolormesh(x, y, values, shading="gouraud")
        figure.colorbar(shown, ax=axis, label=title)
    axes[0].quiver(x[::12, ::12], y[::12, ::12], a.gradient[::12, ::12, 0], a.gradient[::12, ::12, 1], color="white")
    figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "a_lamp_and_its_gradient.png")
