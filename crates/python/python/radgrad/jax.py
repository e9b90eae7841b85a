"""`evaluate` for JAX: `jax.grad` and `jax.vjp` through it take the exact derivatives of `radgrad.derivatives`.

>>> import jax, radgrad as rg
>>> jax.config.update("jax_enable_x64", True)
>>> lamp = jax.numpy.array([[0.0, 0, 1], [0, 1, 1], [1, 1, 1], [1, 0, 1]])
>>> raised = jax.grad(lambda v: rg.jax.evaluate([0.5, 0.5, 0.0], [0.0, 0, 1], v, 2.0))(lamp)
>>> bool(raised[:, 2].sum() < 0)
True
"""

from __future__ import annotations

import importlib
import os
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from typing import Any, Callable, Sequence

import numpy as np

from ._reverse import arrays, backward, forward, points_shape

__all__ = ["evaluate"]


def evaluate(
    x: Any,
    normal: Any,
    vertices: Any,
    emission: Any = 1.0,
    occluders: Sequence[Any] = (),
    reflectance: Any = 1.0,
    rtol: float = 1e-12,
) -> Any:
    """The radiosity of points due to one emitter, in closed form, that JAX differentiates backwards, under `jax.jit` too.

    Parameters
    ----------
    x, normal, reflectance
        As of `radgrad.evaluate`; they broadcast.
    vertices : (V, 3)
        Of the emitter.
    emission : a number, or (V,)
        The radiosity that it emits, or its value at each vertex, affine in between.
    occluders : sequence of (V_k, 3)
        Polygons that may hide it.
    rtol : float
        Relative error that is asked for, of numbers of double precision. JAX rounds to single by default: set its `jax_enable_x64` for more
        digits.

    Returns
    -------
    array of the shape of the points
    """
    differentiable, jax = _differentiable(), importlib.import_module("jax")
    _worker(os.getpid())

    def is_traced(value: Any) -> bool:
        return any(isinstance(leaf, jax.Array) for leaf in jax.tree_util.tree_leaves(value))

    given = [jax.numpy.asarray(value) for value in arrays((x, normal, vertices, emission, reflectance), occluders, is_traced)]
    floats = [of if jax.numpy.issubdtype(of.dtype, np.floating) else of.astype(float) for of in given]
    points_shape(floats[:5], floats[5:])
    return differentiable(rtol, tuple(floats[:5]), tuple(floats[5:]))


def _started(process: int) -> ThreadPoolExecutor:
    """A thread of a process that computes as its caller does: those of JAX flush subnormal numbers to zero, where no bound holds. A thread has the
    mode of the one that starts it, so this is first asked for outside of JAX."""
    worker = ThreadPoolExecutor(1, "radgrad.jax")
    worker.submit(os.getpid).result()
    return worker


_worker = lru_cache(maxsize=1)(_started)


def _computed(of: Callable[..., Any], *given: Any) -> Any:
    return _worker(os.getpid()).submit(of, *given).result()


def _made() -> Any:
    """A function of a tolerance, the five arguments and the occluders that JAX differentiates."""
    try:
        jax: Any = importlib.import_module("jax")
    except ImportError:
        raise ImportError("radgrad.jax needs JAX: pip install jax") from None

    def value(rtol: float, arguments: Any, occluders: Any) -> Any:
        kind = jax.ShapeDtypeStruct(points_shape(arguments, occluders), jax.numpy.result_type(*arguments, *occluders))

        def call(arguments: Any, occluders: Any) -> Any:
            return _computed(forward, _numpy(arguments), _numpy(occluders), rtol).astype(kind.dtype, copy=False)

        return jax.pure_callback(call, kind, arguments, occluders, vmap_method="sequential")

    def pulled_back(rtol: float, kept: Any, cotangent: Any) -> Any:
        arguments, occluders = kept
        kinds = tuple(jax.ShapeDtypeStruct(of.shape, of.dtype) for of in (*arguments, *occluders))

        def call(cotangent: Any, arguments: Any, occluders: Any) -> Any:
            found = _computed(backward, np.asarray(cotangent), _numpy(arguments), _numpy(occluders), rtol)
            return tuple(of.astype(kind.dtype, copy=False) for of, kind in zip(found, kinds))

        found = jax.pure_callback(call, kinds, cotangent, arguments, occluders, vmap_method="sequential")
        return tuple(found[:5]), tuple(found[5:])

    made = jax.custom_vjp(value, nondiff_argnums=(0,))
    made.defvjp(lambda *given: (made(*given), given[1:]), pulled_back)
    return made


_differentiable = lru_cache(maxsize=1)(_made)


def _numpy(arrays: Any) -> Any:
    """Arrays of numpy where those of JAX lie."""
    return tuple(np.asarray(of) for of in arrays)
