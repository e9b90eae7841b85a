"""Radiosity and its gradient from polygonal emitters, in closed form, with a proven bound on every number.

- `evaluate`: what points get from emitters, with gradients and bounds; `digits`, `hessian`, `irradiance_vector`, `each`, `EmitterTree`;
  `derivatives` by vertices, occluders, emission, normal and reflectance.
- `Scene`: surfaces with materials, from files or arrays; its form factors (`Scene.factors`) and its radiosity (`Scene.solve`).
- `heat`: temperatures of grey bodies that exchange heat by radiation.
- `audit`: someone else's code held to truth; `verify`: ours.
- `radgrad.distributed`: the same on a Dask cluster; `radgrad.jax`, `radgrad.torch`: `evaluate` that JAX and PyTorch differentiate.

Lengths are in one unit of the caller's choice, emission in any unit. Radiosity is in the unit of the emission, gradients in that over
the unit of length. An emitter emits to the side from which its vertices are counter-clockwise. An invalid input is a
`ValueError` with the value, its place and the rule.

>>> import radgrad as rg
>>> lamp = rg.Emitter([[0, 0, 1], [0, 1, 1], [1, 1, 1], [1, 0, 1]], 1.0)
>>> a = rg.evaluate([0, 0, 0], [0, 0, 1], lamp)
>>> round(float(a.radiosity), 12), bool(a.radiosity_error <= 1e-12 * a.radiosity)
(0.138531605995, True)
"""

from ._audit import AuditReport, Case, audit, audit_families, cases, verify
from ._derivatives import Derivatives, derivatives
from ._evaluate import (
    METHODS,
    Affine,
    Answer,
    Digits,
    Emitter,
    EmitterTree,
    Hessian,
    Polynomial,
    Total,
    digits,
    each,
    evaluate,
    hessian,
    irradiance_vector,
)
from ._factors import Factors, ReaderWarning, Rows, ToleranceWarning
from ._heat import Heat, heat
from ._progress import Step, threads
from ._rays import BlockFactors, RayFactors
from ._scene import Scene
from ._solution import Certificate, Gathered, Picture, Round, Sensitivity, Slopes, Solution

__all__ = [
    "METHODS",
    "Affine",
    "Answer",
    "AuditReport",
    "BlockFactors",
    "Case",
    "Certificate",
    "Derivatives",
    "Digits",
    "Emitter",
    "EmitterTree",
    "Factors",
    "Gathered",
    "Heat",
    "Hessian",
    "Picture",
    "Polynomial",
    "RayFactors",
    "ReaderWarning",
    "Round",
    "Rows",
    "Scene",
    "Sensitivity",
    "Slopes",
    "Solution",
    "Step",
    "ToleranceWarning",
    "Total",
    "audit",
    "audit_families",
    "cases",
    "derivatives",
    "digits",
    "distributed",
    "each",
    "evaluate",
    "heat",
    "hessian",
    "irradiance_vector",
    "threads",
    "verify",
]


def __getattr__(name: str) -> object:
    # What needs another package is imported when it is asked for.
    if name in ("distributed", "jax", "torch"):
        import importlib

        return importlib.import_module(f".{name}", __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
