"""Derivatives by everything that shapes a point's light."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Sequence, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _radgrad
from ._evaluate import METHODS, Affine, Emitter, Floats, Polynomial, _broadcast, _hiding, _numbers, _relative
from ._shown import Shown

#: Above the rounding of a product of three vectors, relative to the sizes of its factors.
_ROUNDING = 16 * 2.0**-53


@dataclass(frozen=True, eq=False)
class Derivatives(Shown):
    """Derivatives of the radiosity with proven bounds. `S` is the shape of the points, `V` the number of vertices.

    Vertex values move with their vertices, an `Affine` emission with vertex 0; a `Polynomial` stays where it is. A polygon of more than
    three vertices stays flat only along some motions: the derivatives are those for motions that keep it flat.
    """

    #: `S`: the radiosity itself, in the unit of the emission.
    radiosity: Floats
    #: `S`: proven bounds on its errors; likewise of what follows, of vectors on the Euclidean norms.
    radiosity_error: Floats
    #: `S + (3,)`: by the position at a fixed normal.
    gradient: Floats
    gradient_error: Floats
    #: `S + (V, 3)`: by each vertex of the emitter, in the unit of the emission over that of length.
    vertices: Floats
    vertices_error: Floats
    #: `S + (V, 3)` of each occluder: by its vertices.
    occluders: "list[Floats]"
    occluders_error: "list[Floats]"
    #: `S + (P,)`: by the constant; by the value at each vertex; by value and gradient; or by the coefficients.
    emission: Floats
    emission_error: Floats
    #: `S + (3,)`: by the unit normal; as that turns only the part across it counts.
    normal: Floats
    normal_error: Floats
    #: `S`: by the reflectance.
    reflectance: Floats
    reflectance_error: Floats
    #: `S`: places in `METHODS` of what answered.
    method_code: NDArray[np.uint8]
    _position: Floats = field(repr=False)
    _normal: Floats = field(repr=False)

    def _shape(self) -> "Tuple[int, ...]":
        return np.shape(self.radiosity)

    @property
    def method(self) -> NDArray[np.str_]:
        """`S`: names of what answered."""
        return np.asarray(METHODS)[self.method_code]

    @property
    def translation(self) -> Floats:
        """`S + (3,)`: by a shift of the emitter with its emission and of all occluders together; off by at most `gradient_error`."""
        return -self.gradient

    def rotation(self, about: ArrayLike) -> "Tuple[Floats, Floats]":
        """By a turn of emitter and occluders together around a point, and bounds: the component along an axis is that by the angle.

        Returns
        -------
        arrays of shape S + (3,) and S
        """
        arm = self._position - _point(about)
        turned = np.cross(arm, self.gradient) + np.cross(self._normal, self.normal)
        reach = np.linalg.norm(arm, axis=-1)
        size = reach * np.linalg.norm(self.gradient, axis=-1) + np.linalg.norm(self.normal, axis=-1)
        return -turned, (reach * self.gradient_error + self.normal_error + _ROUNDING * size) * (1 + _ROUNDING)

    def scale(self, about: ArrayLike) -> "Tuple[Floats, Floats]":
        """By the logarithm of a scale of emitter and occluders together around a point, and bounds.

        Returns
        -------
        two arrays of shape S
        """
        arm = self._position - _point(about)
        reach, steep = np.linalg.norm(arm, axis=-1), np.linalg.norm(self.gradient, axis=-1)
        error = (reach * self.gradient_error + _ROUNDING * reach * steep) * (1 + _ROUNDING)
        return -np.einsum("...i,...i->...", arm, self.gradient)[()], error


def _point(about: Any) -> Floats:
    point = _numbers(about, "about")
    if point.shape != (3,):
        raise ValueError(f"about has shape {point.shape}: expected (3,)")
    return point


def _parameters(emitter: Emitter) -> int:
    """How many the emission has."""
    emission = emitter.emission
    if isinstance(emission, Affine):
        return 4
    return len(emission.terms) if isinstance(emission, Polynomial) else np.size(emission)


def derivatives(
    x: ArrayLike,
    normal: ArrayLike,
    emitter: Emitter,
    occluders: Sequence[Any] = (),
    reflectance: ArrayLike = 1.0,
    rtol: Union[float, None] = None,
) -> Derivatives:
    """Derivatives of the radiosity at points by the vertices of an emitter and of what hides it, by emission, normal and reflectance.

    Parameters
    ----------
    x, normal, occluders, reflectance
        As of `evaluate`.
    emitter : Emitter
        What emits.
    rtol : float, optional
        Relative error that is asked of the derivatives of each kind, over the largest of the kind: 1e-12 unless given. Where nothing
        meets it, the bounds say what was reached.

    Returns
    -------
    Derivatives
        `vertices` (S + (V, 3)), `occluders` (a list of S + (V, 3)), `emission` (S + (P,)), `normal` (S + (3,)), `reflectance` (S), each
        with its `..._error`; `translation`, `rotation(about)` and `scale(about)` of all together.

    Raises
    ------
    ValueError
        As `evaluate` does, or if a point is on the surface of an emitter that is not flat.

    Examples
    --------
    >>> import numpy as np, radgrad as rg
    >>> lamp = rg.Emitter([[0, 0, 1], [0, 1, 1], [1, 1, 1], [1, 0, 1]], [1, 2, 3, 2])
    >>> d = rg.derivatives([0.5, 0.5, 0], [0, 0, 1], lamp)
    >>> d.vertices.shape, d.emission.shape
    ((4, 3), (4,))
    >>> bool(np.allclose(d.vertices.sum(axis=0), d.translation)), bool(np.isclose(d.emission @ [1, 2, 3, 2], d.radiosity))
    (True, True)
    """
    if not isinstance(emitter, _radgrad.Emitter):
        raise TypeError(f"emitter is {type(emitter).__name__}: expected radgrad.Emitter")
    hiding = _hiding(occluders)
    shape, positions, normals, shares = _broadcast(x, normal, reflectance, single=False)
    found = _radgrad.derivatives(positions, normals, shares, emitter, hiding, _relative(rtol, None), list(shape))
    radiosity, gradient, vertices, screens, emission, by_normal, by_reflectance, method = found

    def vectors(pair: Any, count: Union[int, None] = None) -> "Tuple[Floats, Floats]":
        inner = () if count is None else (count,)
        return pair[0].reshape((*shape, *inner, 3)), pair[1].reshape((*shape, *inner))[()]

    def numbers(pair: Any) -> "Tuple[Floats, Floats]":
        return pair[0].reshape(shape)[()], pair[1].reshape(shape)[()]

    of_screens = [vectors(pair, len(outline)) for pair, (outline, _) in zip(screens, hiding)]
    parameters = _parameters(emitter)
    # By the largest component first: squares may leave the range of a double.
    scaled = normals / np.abs(normals).max(axis=-1, keepdims=True)
    units = scaled / np.linalg.norm(scaled, axis=-1, keepdims=True)
    return Derivatives(
        *numbers(radiosity),
        *vectors(gradient),
        *vectors(vertices, len(emitter.vertices)),
        [values for values, _ in of_screens],
        [errors for _, errors in of_screens],
        emission[0].reshape((*shape, parameters)),
        emission[1].reshape((*shape, parameters)),
        *vectors(by_normal),
        *numbers(by_reflectance),
        method.reshape(shape)[()],
        positions.reshape((*shape, 3)),
        np.broadcast_to(units, (len(positions), 3)).reshape((*shape, 3)),
    )
