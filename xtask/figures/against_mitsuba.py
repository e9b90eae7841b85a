"""Derivatives of a mean radiosity by Mitsuba and by radgrad against formulas: table and picture of docs/guide/derivatives.md.

A lamp of 0.8 by 0.7, 1 over a diffuse floor, moves along x in free sight; or a screen half way up does, whose edge shades a part of the lamp. Wanted
is the derivative of the mean radiosity of the floor that one pixel sees: Mitsuba's samples begin at edges, and never meet a point. Time is that of
all processors, in units of one point's derivatives by radgrad.

    pip install mitsuba matplotlib; pip install target/python/wheels/radgrad-*.whl
    DRJIT_LIBLLVM_PATH=... python xtask/figures/against_mitsuba.py docs/guide/pictures/mitsuba.png
"""

import sys
import tempfile
import time

import drjit as dr
import matplotlib.pyplot as plt
import mitsuba as mi
import numpy as np

import radgrad as rg

mi.set_variant("llvm_ad_mono")
mi.set_log_level(mi.LogLevel.Error)

LAMP = np.array([[0.1, -0.2, 1.0], [0.1, 0.5, 1.0], [0.9, 0.5, 1.0], [0.9, -0.2, 1.0]])
EDGE = 0.25
SCREEN = np.array([[-1.0, -1.0, 0.5], [-1.0, 1.0, 0.5], [EDGE, 1.0, 0.5], [EDGE, -1.0, 0.5]])
#: The camera looks along x: lines of equal x are rows of its picture.
EYE, TARGET, ANGLE = np.array([-0.9, 0.15, 0.45]), np.array([0.0, 0.15, 0.0]), 24
AHEAD = (TARGET - EYE) / np.linalg.norm(TARGET - EYE)
UP, HALF = np.array([-AHEAD[2], 0.0, AHEAD[0]]), np.tan(np.radians(ANGLE / 2))


def floor(u, v):
    """x and y of what the camera sees at places of its picture, each from -1 to 1."""
    ray = AHEAD + HALF * (v[..., None] * UP + u[..., None] * np.array([0.0, 1.0, 0.0]))
    return (EYE - EYE[2] / ray[..., 2:] * ray)[..., :2]


def slope(x, y, edge):
    """The derivative of the form factor from a point of the floor to the lamp by the x of its far edge (Howell, B-4, differentiated)."""

    def corner(b):
        a = edge - x
        p, q = np.sqrt(1 + a * a), np.sqrt(1 + b * b)
        by_a = np.arctan(b / p) / p**3 - a * a * b / (p**2 * (p * p + b * b)) + b / (q * q + a * a)
        return by_a / (2 * np.pi)

    return corner(0.5 - y) - corner(-0.2 - y)


def truth(shaded):
    """By Gauss's rule between the rows where the edge of the shadow enters and leaves the lamp."""

    def row(x):
        ray = (np.array([x, EYE[1], 0.0]) - EYE) / ((np.array([x, EYE[1], 0.0]) - EYE) @ AHEAD)
        return ray @ UP / HALF

    cuts = sorted({-1.0, 1.0, *(row(2 * EDGE - end) for end in (0.1, 0.9) if shaded and abs(row(2 * EDGE - end)) < 1)})
    nodes, weights = np.polynomial.legendre.leggauss(40)
    total = 0.0
    for low, high in zip(cuts, cuts[1:]):
        v, u = np.meshgrid((low + high) / 2 + (high - low) / 2 * nodes, nodes, indexing="ij")
        x, y = np.moveaxis(floor(u, v), -1, 0)
        seen = 2 * EDGE - x
        by_x = np.where((0.1 < seen) & (seen < 0.9), -2 * slope(x, y, seen), 0.0) if shaded else slope(x, y, 0.9) - slope(x, y, 0.1)
        total += (high - low) / 8 * weights @ by_x @ weights
    return total


def scene(shaded):
    def polygon(vertices, name, **rest):
        mesh = mi.Mesh(name, 4, 2)
        parameters = mi.traverse(mesh)
        parameters["vertex_positions"], parameters["faces"] = vertices.ravel(), [0, 1, 2, 0, 2, 3]
        parameters.update()
        mesh.write_ply(f"{folder}/{name}.ply")
        return {"type": "ply", "filename": f"{folder}/{name}.ply", "face_normals": True, "bsdf": {"type": "diffuse", "reflectance": 0.0}, **rest}

    camera = mi.ScalarTransform4f().look_at(list(EYE), list(TARGET), [0, 0, 1])
    film = {"type": "hdrfilm", "width": 1, "height": 1, "rfilter": {"type": "box"}, "pixel_format": "luminance"}
    with tempfile.TemporaryDirectory() as folder:
        return mi.load_dict({
            "type": "scene",
            "camera": {"type": "perspective", "fov": ANGLE, "to_world": camera, "film": film, "sampler": {"type": "independent"}},
            "floor": {"type": "rectangle", "bsdf": {"type": "diffuse", "reflectance": 1.0}},
            "lamp": polygon(LAMP, "lamp", emitter={"type": "area", "radiance": 1 / np.pi}),
            **({"screen": polygon(SCREEN, "screen")} if shaded else {}),
        })


def by_mitsuba(shaded, guiding, samples, seeds):
    """Derivatives by each seed, and the median of their times; what compiles is not counted."""
    world = scene(shaded)
    integrator = mi.load_dict({"type": "direct_projective", "guiding": guiding, "sppp": 0})
    parameters, name = mi.traverse(world), f"{'screen' if shaded else 'lamp'}.vertex_positions"
    start, found, times = dr.unravel(mi.Point3f, parameters[name]), [], []
    for seed in range(seeds + 1):
        began = time.process_time()
        shift = mi.Float(0.0)
        dr.enable_grad(shift)
        parameters[name] = dr.ravel(start + mi.Vector3f(shift, 0, 0))
        parameters.update()
        picture = mi.render(world, parameters, integrator=integrator, spp=samples, seed=seed)
        dr.forward(shift)
        found.append(np.pi * float(dr.grad(picture).array[0]))
        times.append(time.process_time() - began)
    return np.array(found[1:]), np.median(times[1:])


def by_radgrad(shaded, count):
    """The mean over a lattice of so many points, turned by each of 16 shifts, and the time of one."""
    lattice, found = np.arange(count)[:, None] * [1 / count, (5**0.5 - 1) / 2], []
    began = time.process_time()
    for shift in np.random.default_rng(1).random((16, 2)):
        u, v = np.moveaxis(2 * ((lattice + shift) % 1) - 1, -1, 0)
        d = rg.derivatives(np.column_stack([floor(u, v), np.zeros(count)]), [0, 0, 1], rg.Emitter(LAMP), [SCREEN] if shaded else [])
        found.append((d.occluders[0] if shaded else d.vertices)[..., 0].sum(axis=1).mean())
    return np.array(found), (time.process_time() - began) / 16


def main(out):
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.4), sharey=True, layout="constrained")
    for shaded, axis in zip((False, True), axes):
        exact, unit = truth(shaded), by_radgrad(shaded, 4096)[1] / 4096
        ways = [
            ("radgrad, a lattice of points", [(2**k, *by_radgrad(shaded, 2**k)) for k in range(0, 15, 2)]),
            ("Mitsuba", [(2**k, *by_mitsuba(shaded, "none", 2**k, 8)) for k in range(8, 21, 3)]),
            ("Mitsuba, guided by an octree", [(2**k, *by_mitsuba(shaded, "octree", 2**k, 4)) for k in (14, 20)]),
        ]
        print(f"\n{'screen' if shaded else 'lamp'}: {exact:.12f}, a unit of {1e6 * unit:.2f} us")
        for (name, rows), mark in zip(ways, "os^"):
            error = [np.sqrt(np.mean((found / exact - 1) ** 2)) for _, found, _ in rows]
            axis.loglog([seconds / unit for *_, seconds in rows], error, mark + "-", label=name)
            for (count, found, seconds), off in zip(rows, error):
                print(f"| {name} | {count} | {off:.1e} | {seconds / unit:.2g} | mean {found.mean() / exact - 1:+.1e}")
        axis.set(title="a screen moves" if shaded else "a lamp moves, free sight", xlabel="CPU time / derivatives at a point by radgrad")
        axis.grid(alpha=0.3)
    axes[0].set_ylabel("relative error")
    axes[1].legend(fontsize=8)
    figure.savefig(out, dpi=110)


if __name__ == "__main__":
    print(f"Mitsuba {mi.__version__}, Dr.Jit {dr.__version__}")
    main(sys.argv[1])
