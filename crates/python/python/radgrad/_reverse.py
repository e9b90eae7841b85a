"""The product of a vector with the derivatives of `evaluate`, for programs that differentiate backwards: all in arrays of numpy."""

from __future__ import annotations

from typing import Any, Callable, List, Sequence, Tuple

import numpy as np
from numpy.typing import NDArray

from ._derivatives import derivatives
from ._evaluate import Emitter, _check_outline, _check_rows, _common_shape, _numbers, _precision, _sequence, evaluate

Floats = NDArray[np.float64]

#: The arguments of which derivatives are made, in order, but for occluders, which follow.
Arguments = Sequence[Any]
NAMES = ("x", "normal", "vertices", "emission", "reflectance")


def arrays(arguments: Arguments, occluders: Sequence[Any], is_tensor: Callable[[Any], bool]) -> "List[Any]":
    """Arguments, then occluders: tensors as they are, all else as arrays of numpy in their own precision, or an error that names the one."""
    hiding = _sequence(occluders, "occluders")
    given = zip([*arguments, *hiding], [*NAMES, *(f"occluders[{index}]" for index in range(len(hiding)))])
    return [value if is_tensor(value) else _numbers(value, name, _precision(value)) for value, name in given]


def points_shape(arguments: Arguments, occluders: Sequence[Any]) -> "Tuple[int, ...]":
    """The shape of the points, or an error that names the argument of a wrong shape."""
    x, normal, vertices, emission, reflectance = (tuple(of.shape) for of in arguments)
    _check_rows(x, "x")
    _check_rows(normal, "normal")
    _check_outline(vertices, "vertices")
    if emission not in ((), vertices[:1]):
        raise ValueError(f"emission has shape {emission}: expected a number, or {vertices[:1]}, a value a vertex")
    for index, outline in enumerate(occluders):
        _check_outline(tuple(outline.shape), f"occluders[{index}]")
    return _common_shape(x[:-1], normal[:-1], reflectance)


def forward(arguments: Arguments, occluders: Sequence[Any], rtol: float) -> Floats:
    """The radiosity of (x, normal, vertices, emission, reflectance) past occluders: of the shape of the points."""
    x, normal, vertices, emission, reflectance = arguments
    # In double precision whatever they come in; vertices keep theirs, which says how flat they can be.
    found = evaluate(np.asarray(x, np.float64), normal, Emitter(vertices, emission), occluders, reflectance, rtol=rtol)
    return np.asarray(found.radiosity)


def backward(cotangent: Any, arguments: Arguments, occluders: Sequence[Any], rtol: float) -> List[Floats]:
    """The derivatives of `sum(cotangent * forward)` by the five arguments and each occluder, each of its argument's shape."""
    x, normal, vertices, emission, reflectance = arguments
    d = derivatives(x, normal, Emitter(vertices, emission), occluders, reflectance, rtol=rtol)
    given = np.broadcast_to(np.asarray(cotangent, dtype=np.float64), np.shape(d.radiosity))
    # Only the direction of a normal counts; by the largest component first: squares may leave the range of a double.
    largest = np.abs(normal).max(axis=-1, keepdims=True).astype(np.float64)
    length = largest * np.linalg.norm(normal / largest, axis=-1, keepdims=True)
    across = d.normal - np.einsum("...i,...i->...", d.normal, d._normal)[..., np.newaxis] * d._normal

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


def _reduced(derivative: Floats, shape: Tuple[int, ...]) -> Floats:
    """The sum over the axes along which an argument of that shape was repeated."""
    extra = derivative.ndim - len(shape)
    repeated = tuple(axis for axis, size in enumerate(shape, extra) if size == 1 and derivative.shape[axis] != 1)
    return derivative.sum(axis=(*range(extra), *repeated)).reshape(shape)
