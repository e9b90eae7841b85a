"""View factors between the faces of a room with a cupboard in it, as a sparse matrix with bounds, beside pyViewFactor.

    python view_factors_of_a_room.py
"""

# %% A room of 4 m x 3 m x 2.5 m, and a cupboard that stands in it
import numpy as np

import radgrad as rg


def box(low, high, inward):
    """The corners of a box, and its faces seen from inside or outside."""
    corners = [[x, y, z] for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])]
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return corners, [face if inward else face[::-1] for face in faces]


room, walls = box([0, 0, 0], [4, 3, 2.5], inward=True)
cupboard, sides = box([1, 1, 0.25], [1.5, 2, 2], inward=False)
names = ["floor", "ceiling", "front", "back", "left", "right"] + ["cupboard"] * 6
scene = rg.Scene(room + cupboard, walls + [[8 + corner for corner in face] for face in sides], names=names)
print(f"{len(scene)} faces, warnings: {scene.check()}")

# %% Each factor lies in a proven bracket; rows are not normalised, so that they sum to 1 is evidence
F = scene.factors(tolerance=1e-3)
print(f"{F.data.size} factors, worst bound {F.bound:.1e}")
print(f"closure {F.closure:.1e}, reciprocity {F.reciprocity:.1e}, rows that cannot close: {F.unclosed}")
assert F.unclosed == [] and F.reciprocity < 1e-14 and F.closure < 12 * 1e-3

# %% Rows that sum to 1, by the least change within the brackets
repaired = F.repaired()
print(f"repaired: closure {repaired.closure:.1e}, moved by {repaired.moved[0]:.1e} at most")
assert repaired.closure < 1e-13

# %% By surface
surfaces, matrix = repaired.by_surface()
print("from      " + " ".join(f"{name:>9}" for name in surfaces))
for name, row in zip(surfaces, matrix):
    print(f"{name:<9} " + " ".join(f"{value:9.5f}" for value in row))
assert np.allclose(matrix.sum(axis=1), 1)

# %% The same in free sight by pyViewFactor, where it is installed
try:
    import pyviewfactor as pvf
    import pyvista as pv

    wall = [pv.Rectangle([room[i] for i in walls[face][:3]]) for face in (0, 1)]
    theirs = pvf.compute_viewfactor(wall[0], wall[1])
except Exception as error:  # its interface has changed more than once
    print(f"not compared with pyViewFactor: {type(error).__name__}: {error}")
else:
    empty = rg.Scene(room, walls).factors()
    ours = empty.data[empty.indptr[0] : empty.indptr[1]][0]
    print(f"floor to ceiling without the cupboard: ours {ours:.12f}, pyViewFactor {theirs:.12f}")
