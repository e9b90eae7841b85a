"""Points and emitters: what users call, and the shapes of it."""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal, localcontext
from typing import Any, Sequence, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _radgrad
from ._progress import Progress, watching
from ._radgrad import Affine, Polynomial
from ._shown import Shown, table

#: What may answer, the cheapest first; `Answer.method` names one of these for each point.
METHODS: Tuple[str, ...] = ("zero", "quadrature", "closed-form", "double-double", "arbitrary-precision", "on-surface")

Floats = NDArray[Any]


def _numbers(value: Any, what: str, dtype: Any = np.float64) -> Floats:
    """An array of numbers, or an error that names it."""
    if isinstance(value, np.ma.MaskedArray):
        raise ValueError(f"{what} is a masked array: fill it ({what}.filled(...)) or leave out what is masked ({what}.compressed())")
    try:
        given = np.asarray(value)
        if given.dtype.kind == "c" or (given.dtype.kind == "O" and any(isinstance(one, complex) for one in given.flat)):
            raise ValueError(f"{what} is complex: expected real numbers; take the real part ({what}.real) if that is what is meant")
        if given.dtype.kind not in "biufO":
            raise ValueError(f"{what}: expected numbers, found an array of {given.dtype}: convert it first ({what}.astype(float))")
        array = given.astype(dtype, copy=False)
    except (TypeError, ValueError) as error:
        if str(error).startswith(what):
            raise
        raise ValueError(f"{what}: expected numbers: {error}") from None
    return array


def _number(value: Any, what: str, rule: str = "a number") -> float:
    """A number, or an error that names it."""
    array = _numbers(value, what)
    if array.ndim != 0:
        raise ValueError(f"{what} has shape {array.shape}: it must be {rule}")
    return float(array)


def _whole(array: Floats) -> Floats:
    """The same as one stretch of memory at an address that numbers have; what comes out of a message or a file may be at any."""
    return np.require(array, requirements=["C_CONTIGUOUS", "ALIGNED"])


def _precision(value: Any) -> Any:
    """Single for an array of it, double for all else."""
    return np.float32 if getattr(value, "dtype", None) == np.float32 else np.float64


def _rows(value: Any, what: str, dtype: Any = np.float64) -> Floats:
    """An array whose last axis has three entries."""
    array = _numbers(value, what, dtype)
    _check_rows(array.shape, what)
    return array


def _check_rows(shape: "Tuple[int, ...]", what: str) -> None:
    if not shape or shape[-1] != 3:
        raise ValueError(f"{what} has shape {shape}: expected (..., 3)")


def _check_outline(shape: "Tuple[int, ...]", what: str) -> None:
    if len(shape) != 2 or shape[-1] != 3:
        raise ValueError(f"{what} has shape {shape}: expected (vertices, 3)")


def _outline(vertices: Any, what: str) -> "Tuple[Floats, float]":
    """The vertices of a polygon, and the length by which each coordinate may be off: in single precision a turn and a shift leave up to eight
    roundings of the largest; numbers of double precision are as they are."""
    array = _numbers(vertices, what)
    _check_outline(array.shape, what)
    off = 2.0**-21 * np.abs(array).max(initial=0.0) if _precision(vertices) == np.float32 else 0.0
    # A vertex that is not finite is refused by its own rule.
    return _whole(array), float(off) if np.isfinite(off) else 0.0


class Emitter(_radgrad.Emitter):
    """A polygon that emits to the side from which its vertices are counter-clockwise.

    Parameters
    ----------
    vertices : (n, 3)
        A simple planar polygon, in the unit of length.
    emission : float, (n,), Affine or Polynomial
        Emitted radiosity: the same everywhere, a value at each vertex (for more than three they lie on one affine function), or a
        function of the position.
    precision : float, optional
        Length by which each coordinate of a vertex may be off: the polygon may be off a plane by as much as that explains, and what it
        leaves open is in every bound. 0 unless given; 2^-21 of the largest coordinate for an array of single precision.

    Raises
    ------
    ValueError
        If the vertices are no such polygon, or the emission is not finite, not affine or of another length.

    Examples
    --------
    >>> import radgrad as rg
    >>> lamp = rg.Emitter([[0, 0, 1], [0, 1, 1], [1, 1, 1], [1, 0, 1]], [1, 2, 3, 2])
    >>> lamp.area, lamp.normal.tolist()
    (1.0, [0.0, 0.0, -1.0])
    """

    def __new__(
        cls, vertices: ArrayLike, emission: Union[ArrayLike, Affine, Polynomial] = 1.0, precision: Union[float, None] = None
    ) -> "Emitter":
        if not isinstance(emission, (Affine, Polynomial)):
            values = _numbers(emission, "emission")
            if values.ndim > 1:
                raise ValueError(f"emission has shape {values.shape}: expected a number, or (vertices,)")
            emission = float(values) if values.ndim == 0 else _whole(values)
        outline, rounding = _outline(vertices, "vertices")
        return super().__new__(cls, outline, emission, rounding if precision is None else _number(precision, "precision", "a length"))

    def emission_at(self, points: ArrayLike) -> Floats:
        """Emission at points of the emitter's plane, of shape (..., 3): an array of shape (...)."""
        rows = _rows(points, "points")
        return super().emission_at(_whole(rows)).reshape(rows.shape[:-1])

    def __repr__(self) -> str:
        precision = f", precision={self.precision!r}" if self.precision else ""
        return f"Emitter({self.vertices.tolist()}, {self.emission!r}{precision})"

    def _repr_html_(self) -> str:
        return table("Emitter", [("vertices", self.vertices.tolist()), ("emission", self.emission), ("area", f"{self.area:.6g}")])


Emitters = Union[Emitter, Sequence[Emitter]]


@dataclass(frozen=True, eq=False)
class Answer(Shown):
    """Radiosity and gradient with proven bounds. `S` is the shape of the points."""

    #: `S`: radiosity, in the unit of the emission.
    radiosity: Floats
    #: `S`: proven bounds on the errors of the radiosity.
    radiosity_error: Floats
    #: `S + (3,)`: derivatives with respect to the position at a fixed normal, in that unit over the unit of length.
    gradient: Floats
    #: `S`: proven bounds on the Euclidean norms of the errors of the gradient.
    gradient_error: Floats
    #: `S`: places in `METHODS` of what answered; of several emitters the dearest.
    method_code: NDArray[np.uint8]

    def _shape(self) -> "Tuple[int, ...]":
        return np.shape(self.radiosity)

    @property
    def method(self) -> NDArray[np.str_]:
        """`S`: names of what answered."""
        return np.asarray(METHODS)[self.method_code]


@dataclass(frozen=True)
class Digits:
    """Radiosity and gradient of a point in decimal digits, with proven bounds that include the rounding of the digits."""

    #: Radiosity, in the unit of the emission.
    radiosity: Decimal
    #: Its derivatives with respect to x, y and z.
    gradient: Tuple[Decimal, Decimal, Decimal]
    #: Proven bound on the error of the radiosity.
    error: Decimal
    #: Proven bound on the Euclidean norm of the error of the gradient.
    gradient_error: Decimal


@dataclass(frozen=True, eq=False)
class Hessian(Shown):
    """Second derivatives with a proven bound. `S` is the shape of the points."""

    #: `S + (3, 3)`: in the unit of the emission over the unit of length squared.
    matrix: Floats
    #: `S`: proven bounds on the Frobenius norms of the errors.
    error: Floats
    #: `S`: places in `METHODS` of what answered.
    method_code: NDArray[np.uint8]

    def _shape(self) -> "Tuple[int, ...]":
        return np.shape(self.error)


@dataclass(frozen=True, eq=False)
class Total(Shown):
    """What points get from very many emitters. `S` is the shape of the points."""

    #: `S`: radiosity, in the unit of the emission.
    radiosity: Floats
    #: `S`: proven bounds on its errors.
    radiosity_error: Floats
    #: What became of the emitters, summed over the points: `below` the horizon, `behind` themselves, too `weak` to count, answered
    #: `together` as far fields, or `alone`.
    counts: "dict[str, int]"

    def _shape(self) -> "Tuple[int, ...]":
        return np.shape(self.radiosity)


def _sequence(given: Any, what: str) -> "list[Any]":
    """As a list, or an error that names it."""
    try:
        return list(given)
    except TypeError:
        raise TypeError(f"{what} is {type(given).__name__}: expected a list, which may be empty") from None


def _listed(emitters: Any) -> "list[Any]":
    """Emitters of a list, or the one."""
    if isinstance(emitters, _radgrad.Emitter):
        return [emitters]
    listed = _sequence(emitters, "emitters")
    for index, emitter in enumerate(listed):
        if not isinstance(emitter, _radgrad.Emitter):
            raise TypeError(f"emitters[{index}] is {type(emitter).__name__}: expected radgrad.Emitter")
    return listed


def _hiding(occluders: Any) -> "list[tuple[Floats, float]]":
    """Occluders as arrays of vertices, each with its precision. Emitters hide too."""
    return [
        (o.vertices, o.precision) if isinstance(o, _radgrad.Emitter) else _outline(o, f"occluders[{index}]")
        for index, o in enumerate(_sequence(occluders, "occluders"))
    ]


def _broadcast(x: Any, normal: Any, reflectance: Any, single: bool) -> "tuple[tuple[int, ...], Floats, Floats, Floats]":
    """The shape of the points, and rows of positions, normals and reflectances: of the latter as many, or one for all."""
    dtype = _precision(x) if single else np.float64
    positions, normals = _rows(x, "x", dtype), _rows(normal, "normal", dtype)
    shares = _numbers(reflectance, "reflectance", dtype)
    shape = _common_shape(positions.shape[:-1], normals.shape[:-1], shares.shape)
    count = int(np.prod(shape, dtype=np.int64))

    def spread(array: Floats, tail: "tuple[int, ...]") -> Floats:
        one = array.size == (3 if tail else 1) and count != 0
        whole = array.reshape((1, *tail)) if one else np.broadcast_to(array, shape + tail)
        return _whole(whole.reshape((-1, *tail)))

    rows = _whole(np.broadcast_to(positions, (*shape, 3)).reshape(-1, 3))
    return shape, rows, spread(normals, (3,)), spread(shares, ())


def _common_shape(x: "Tuple[int, ...]", normal: "Tuple[int, ...]", reflectance: "Tuple[int, ...]") -> "Tuple[int, ...]":
    try:
        return np.broadcast_shapes(x, normal, reflectance)
    except ValueError:
        raise ValueError(f"x {x}, normal {normal} and reflectance {reflectance} cannot be broadcast together") from None


def _relative(rtol: Any, dtype: Any) -> float:
    return _number(rtol, "rtol", "a number from 0 to 1") if rtol is not None else (1e-5 if dtype == np.float32 else 1e-12)


def evaluate(
    x: ArrayLike,
    normal: ArrayLike,
    emitters: Emitters,
    occluders: Sequence[Any] = (),
    reflectance: ArrayLike = 1.0,
    rtol: Union[float, None] = None,
    progress: Progress = None,
) -> Answer:
    """Radiosity and its gradient at points due to emitters, with proven bounds.

    `x`, `normal` and `reflectance` broadcast to one shape `S`; a list of emitters adds up. Arrays `x` of single precision are answered
    in it, twice as fast.

    Parameters
    ----------
    x : (..., 3)
        Positions.
    normal : (..., 3)
        Normals of the receivers, of any length but 0.
    emitters : Emitter or list of Emitter
        What emits.
    occluders : list of (n, 3)
        Polygons in between, opaque from both sides.
    reflectance : (...)
        In [0, 1]. With 1 and an emission of 1 the radiosity is the form factor of the point.
    rtol : float, optional
        Relative error that is asked of each emitter's value and gradient (of its norm): 1e-12 unless given, 1e-5 in single precision.
        Where nothing meets it, the bounds say what was reached.
    progress : bool or callable, optional
        Tell how far it is: by a line, or by a call with a `Step`. By default a line after two seconds in a terminal or a notebook.

    Returns
    -------
    Answer
        Arrays `radiosity` (S), `radiosity_error` (S), `gradient` (S + (3,)), `gradient_error` (S), `method` (S).

    Raises
    ------
    ValueError
        If shapes do not broadcast, a number is not finite, a normal is 0, a reflectance or the tolerance is not in [0, 1], or a result
        leaves the range of a double.

    Examples
    --------
    >>> import numpy as np, radgrad as rg
    >>> lamp = rg.Emitter([[0, 0, 1], [0, 1, 1], [1, 1, 1], [1, 0, 1]], 1.0)
    >>> x = np.column_stack([np.linspace(0, 1, 5), np.full(5, 0.5), np.zeros(5)])
    >>> a = rg.evaluate(x, [0, 0, 1], lamp, reflectance=0.5)
    >>> a.radiosity.round(6).tolist()
    [0.090184, 0.111483, 0.119728, 0.111483, 0.090184]
    >>> a.gradient.shape, bool(np.all(a.radiosity_error <= 1e-12 * a.radiosity))
    ((5, 3), True)
    """
    listed, hiding = _listed(emitters), _hiding(occluders)
    shape, positions, normals, shares = _broadcast(x, normal, reflectance, single=True)
    tolerance = _relative(rtol, positions.dtype)
    with watching(progress, "evaluate"):
        found = _radgrad.evaluate(positions, normals, shares, listed, hiding, tolerance, list(shape))
    return _answer(found, shape)


def _answer(found: Any, shape: "tuple[int, ...]") -> Answer:
    radiosity, radiosity_error, gradient, gradient_error, method = found
    return Answer(
        radiosity.reshape(shape)[()],
        radiosity_error.reshape(shape)[()],
        gradient.reshape((*shape, 3)),
        gradient_error.reshape(shape)[()],
        method.reshape(shape)[()],
    )


def each(
    x: ArrayLike, normal: ArrayLike, emitters: Sequence[Emitter], reflectance: ArrayLike = 1.0, rtol: float = 1e-12
) -> Answer:
    """Radiosity and gradient at points due to each emitter by itself.

    Parameters are those of `evaluate`, without occluders.

    Returns
    -------
    Answer
        With one axis more, of the emitters: `radiosity` (S + (m,)), `gradient` (S + (m, 3)).

    Examples
    --------
    >>> import radgrad as rg
    >>> lamps = [rg.Emitter([[i, 0, 2], [i, 0.5, 2], [i + 0.5, 0, 2]]) for i in range(3)]
    >>> rg.each([0, 0, 0], [0, 0, 1], lamps).radiosity.round(4).tolist()
    [0.0096, 0.0055, 0.0021]
    """
    listed = _listed(emitters)
    shape, positions, normals, shares = _broadcast(x, normal, reflectance, single=False)
    found = _radgrad.each(positions, normals, shares, listed, _relative(rtol, None), list(shape))
    return _answer(found, (*shape, len(listed)))


def digits(
    x: ArrayLike,
    normal: ArrayLike,
    emitters: Emitters,
    occluders: Sequence[Any] = (),
    reflectance: float = 1.0,
    digits: int = 50,
) -> Digits:
    """Radiosity and gradient of one point to as many digits as are asked for: the exact result for the doubles as given.

    Parameters
    ----------
    x, normal : (3,)
        Position and normal of the receiver.
    emitters, occluders, reflectance
        As of `evaluate`.
    digits : int
        Significant digits of each emitter's value and gradient, 1 to 1000.

    Returns
    -------
    Digits
        `radiosity`, `gradient`, `error` and `gradient_error`, of type `decimal.Decimal`.

    Raises
    ------
    ValueError
        As `evaluate` does, and if the receiver is on the surface of an emitter that is not flat.

    Examples
    --------
    >>> import radgrad as rg
    >>> lamp = rg.Emitter([[0, 0, 1], [0, 1, 1], [1, 1, 1], [1, 0, 1]], 1.0)
    >>> str(rg.digits([0, 0, 0], [0, 0, 1], lamp, digits=30).radiosity)[:32]
    '0.138531605994892996780769708634'
    """
    listed, hiding = _listed(emitters), _hiding(occluders)
    shape, position, normals, shares = _broadcast(x, normal, reflectance, single=False)
    if shape != ():
        raise ValueError(f"x, normal and reflectance have the shape {shape} together: digits takes one point")
    if not (isinstance(digits, (int, np.integer)) and 1 <= digits <= 1000):
        raise ValueError(f"digits is {digits!r}: it must be a whole number from 1 to 1000")
    sums = [Decimal(0)] * 6
    with localcontext() as context:
        # Sums of doubles' decimals are exact in so many digits.
        context.prec = 4000
        for emitter in listed:
            value, gradient, error, slope = _radgrad.digits(position, normals, shares, emitter, hiding, int(digits))
            sums = [a + Decimal(b) for a, b in zip(sums, (value, *gradient, error, slope))]
    return Digits(sums[0], (sums[1], sums[2], sums[3]), sums[4], sums[5])


def hessian(
    x: ArrayLike,
    normal: ArrayLike,
    emitters: Emitters,
    occluders: Sequence[Any] = (),
    reflectance: ArrayLike = 1.0,
    rtol: float = 1e-12,
) -> Hessian:
    """Second derivatives of the radiosity with respect to the position.

    Parameters are those of `evaluate`; `rtol` is over the Frobenius norm.

    Returns
    -------
    Hessian
        `matrix` (S + (3, 3)), `error` (S); the error is infinite where an edge is seen through a vertex, since there is no second
        derivative there.

    Raises
    ------
    ValueError
        As `evaluate` does.

    Examples
    --------
    >>> import numpy as np, radgrad as rg
    >>> lamp = rg.Emitter([[0, 0, 1], [0, 1, 1], [1, 1, 1], [1, 0, 1]], 1.0)
    >>> h = rg.hessian([0.5, 0.5, 0], [0, 0, 1], lamp).matrix
    >>> bool(np.allclose(h, h.T)), bool(h[0, 0] < 0 < h[2, 2])
    (True, True)
    """
    listed, hiding = _listed(emitters), _hiding(occluders)
    shape, positions, normals, shares = _broadcast(x, normal, reflectance, single=False)
    matrix, error, method = _radgrad.hessian(positions, normals, shares, listed, hiding, _relative(rtol, None), list(shape))
    return Hessian(matrix.reshape((*shape, 3, 3)), error.reshape(shape)[()], method.reshape(shape)[()])


def irradiance_vector(x: ArrayLike, normal: ArrayLike, emitters: Emitters) -> Floats:
    """Irradiance vectors: integrals of emission times direction over the part above the horizon, in the unit of the emission.

    The radiosity is `reflectance / pi` times its product with the normal, and its derivative with respect to the normal is
    `reflectance / pi` times it.

    Parameters
    ----------
    x, normal : (..., 3)
        Positions and normals; they broadcast to a shape `S`.
    emitters : Emitter or list of Emitter
        What emits; a list adds up.

    Returns
    -------
    array of shape S + (3,)

    Examples
    --------
    >>> import numpy as np, radgrad as rg
    >>> lamp = rg.Emitter([[0, 0, 1], [0, 1, 1], [1, 1, 1], [1, 0, 1]], 1.0)
    >>> e = rg.irradiance_vector([0, 0, 0], [0, 0, 1], lamp)
    >>> bool(abs(e[2] / np.pi - rg.evaluate([0, 0, 0], [0, 0, 1], lamp).radiosity) < 1e-15)
    True
    """
    listed = _listed(emitters)
    shape, positions, normals, _ = _broadcast(x, normal, 1.0, single=False)
    return _radgrad.irradiance_vector(positions, normals, listed, list(shape)).reshape((*shape, 3))


class EmitterTree:
    """Very many emitters, to be answered together within an absolute error.

    Parameters
    ----------
    emitters : list of Emitter
        Making the tree takes about as long as a hundred points take without it.

    Examples
    --------
    >>> import radgrad as rg
    >>> c = [[0, 0, 1], [0, 0.02, 1], [0.02, 0.02, 1], [0.02, 0, 1]]
    >>> ceiling = [rg.Emitter([[x + 0.02 * i, y + 0.02 * j, z] for x, y, z in c]) for i in range(50) for j in range(50)]
    >>> t = rg.EmitterTree(ceiling).total([0, 0, 0], [0, 0, 1], atol=1e-5)
    >>> bool(abs(t.radiosity - 0.138531605994893) <= t.radiosity_error <= 1e-5)
    True
    """

    def __init__(self, emitters: Sequence[Emitter]) -> None:
        self._emitters = _listed(emitters)
        self._tree = _radgrad.Tree(self._emitters)

    def __len__(self) -> int:
        return len(self._tree)

    def __repr__(self) -> str:
        return f"<radgrad.EmitterTree: {len(self)} emitters>"

    def _repr_html_(self) -> str:
        return table("EmitterTree", [("emitters", len(self))])

    def __reduce__(self) -> Any:
        return EmitterTree, (self._emitters,)

    def total(self, x: ArrayLike, normal: ArrayLike, atol: float, reflectance: ArrayLike = 1.0) -> Total:
        """What points get from all emitters together.

        `x` (..., 3), `normal` (..., 3) and `reflectance` (...) broadcast to a shape `S`. `atol`, in the unit of the emission, is the
        error that is asked for: a `ValueError` if it is not a positive number. The bounds say what was reached.
        """
        shape, positions, normals, shares = _broadcast(x, normal, reflectance, single=False)
        radiosity, error, counts = self._tree.total(positions, normals, shares, _number(atol, "atol"), list(shape))
        return Total(radiosity.reshape(shape)[()], error.reshape(shape)[()], counts)
