"""The product of a vector with the derivatives of `evaluate`, for programs that differentiate backwards: all in arrays of numpy."""

from __future__ import annotations

from typing import Any, List, Sequence, Tuple

import numpy as np
from numpy.typing import NDArray

from ._derivatives import derivatives
from ._evaluate import Emitter, evaluate

Floats = NDArray[np.float64]

#: The arguments of which derivatives are made, in order, but for occluders, which follow.
Arguments = Tuple[Any, Any, Any, Any, Any]


def forward(arguments: Arguments, occluders: Sequence[Any], rtol: float) -> Floats:
    """The radiosity of (x, normal, vertices, emission, reflectance) past occluders: of the shape of the points."""
    x, normal, vertices, emission, reflectance = arguments
    found = evaluate(x, normal, Emitter(vertices, _emission(emission)), list(occluders), reflectance, rtol=rtol)
    return np.asarray(found.radiosity, dtype=np.float64)


def backward(cotangent: Any, arguments: Arguments, occluders: Sequence[Any], rtol: float) -> List[Floats]:
    """The derivatives of `sum(cotangent * forward)` by the five arguments and each occluder, each of its argument's shape."""
    x, normal, vertices, emission, reflectance = arguments
    d = derivatives(x, normal, Emitter(vertices, _emission(emission)), list(occluders), reflectance, rtol=rtol)
    given = np.broadcast_to(np.asarray(cotangent, dtype=np.float64), np.shape(d.radiosity))
    # Only the direction of a normal counts.
    length = np.linalg.norm(normal, axis=-1, keepdims=True)
    unit = np.asarray(normal) / length
    across = d.normal - np.einsum("...i,...i->...", d.normal, unit)[..., np.newaxis] * unit

    def summed(derivative: Floats) -> Floats:
        """Over all points, of what is one for all of them."""
        return np.asarray(np.tensordot(given.ravel(), derivative.reshape((given.size, *derivative.shape[given.ndim :])), 1))

    return [
        _reduced(given[..., np.newaxis] * d.gradient, np.shape(x)),
        _reduced(given[..., np.newaxis] * across / length, np.shape(normal)),
        summed(d.vertices),
        summed(d.emission).reshape(np.shape(emission)),
        _reduced(np.asarray(given * d.reflectance), np.shape(reflectance)),
        *(summed(of) for of in d.occluders),
    ]


def _emission(emission: Any) -> Any:
    """A number, or a value a vertex."""
    return float(emission) if np.ndim(emission) == 0 else emission


def _reduced(derivative: Floats, shape: Tuple[int, ...]) -> Floats:
    """The sum over the axes along which an argument of that shape was repeated."""
    extra = derivative.ndim - len(shape)
    repeated = tuple(axis for axis, size in enumerate(shape, extra) if size == 1 and derivative.shape[axis] != 1)
    return derivative.sum(axis=(*range(extra), *repeated)).reshape(shape)
