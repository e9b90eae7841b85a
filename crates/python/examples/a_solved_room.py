"""The light in a room, reflections included: solved, asked for at points on a desk, written for ParaView and drawn by pyvista.

    python a_solved_room.py [folder]
"""

# %% A room with a lamp in its ceiling
import pathlib
import sys

import numpy as np

import radgrad as rg

folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".")


def rectangle(origin, along, across):
    origin, along, across = map(np.array, (origin, along, across))
    return [origin, origin + along, origin + along + across, origin + across]


W, D, H = 4.0, 3.0, 2.5
outlines = {
    "floor": rectangle([0, 0, 0], [W, 0, 0], [0, D, 0]),
    "ceiling": rectangle([0, 0, H], [0, D, 0], [W, 0, 0]),
    "front": rectangle([0, 0, 0], [0, 0, H], [W, 0, 0]),
    "back": rectangle([0, D, 0], [W, 0, 0], [0, 0, H]),
    "left": rectangle([0, 0, 0], [0, D, 0], [0, 0, H]),
    "right": rectangle([W, 0, 0], [0, 0, H], [0, D, 0]),
    "lamp": rectangle([1.5, 1, H - 0.05], [0, 1, 0], [1, 0, 0]),
}
vertices = np.concatenate([np.array(outline, dtype=float) for outline in outlines.values()])
faces = np.arange(len(vertices)).reshape(-1, 4)
share = {"floor": 0.2, "ceiling": 0.7, "lamp": 0.0}
scene = rg.Scene(
    vertices,
    faces,
    reflectance=[share.get(name, 0.5) for name in outlines],
    emission=[3000.0 if name == "lamp" else 0.0 for name in outlines],
    names=list(outlines),
)
print(scene.check())

# %% Solved to an estimate of 2 % of the mean
s = scene.solve(error=0.02, progress=True)
print({name: s.summary[name] for name in ("elements", "links", "estimate")})

# %% What a sensor on a desk reads, 0.75 m above the floor
x = np.linspace(0.25, W - 0.25, 8)
desk = np.column_stack([x, np.full_like(x, 1.5), np.full_like(x, 0.75)])
b = s.gather(desk, [0, 0, 1])
for at, lux, estimate in zip(x, b.irradiance[:, 0], b.irradiance_estimate[:, 0]):
    print(f"{at:.2f} m: {lux:6.1f} +- {estimate:.1f} lx")
assert np.all(b.irradiance[:, 0] > 50) and b.irradiance[:, 0].argmax() in (3, 4)

# %% For ParaView, and as a picture
s.to_vtu(folder / "room.vtu")
view = s.image(([0.3, 0.3, 1.6], [4, 3, 0.8], [0, 0, 1], 75), size=(160, 120), file=folder / "room.png")
print(f"picture: {view.radiosity.shape}, up to {view.radiosity.max():.0f}")

# %% Drawn by pyvista
try:
    import pyvista
except ImportError:
    print("no pyvista: room.vtu is there for another program")
else:
    grid = pyvista.read(folder / "room.vtu")
    name = next(name for name in grid.point_data if "radiosity" in name)
    print(f"pyvista reads {grid.n_cells} cells, {name}: {grid.point_data[name].min():.0f} to {grid.point_data[name].max():.0f}")
    # grid.plot(scalars=name)
