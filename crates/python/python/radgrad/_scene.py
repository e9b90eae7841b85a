"""Scenes, their form factors and their solutions."""

from __future__ import annotations

import hashlib
import json
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Callable, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _radgrad
from ._evaluate import Floats, _numbers, _rows, _whole

if TYPE_CHECKING:
    from scipy.sparse import csr_array as _csr_array  # type: ignore[import-untyped]

PathLike = Union[str, "os.PathLike[str]"]

#: Bytes that reading a file may take unless others are asked for.
BUDGET = 256 << 20


class Round(NamedTuple):
    """How far a solution has come."""

    #: From 1.
    round: int
    elements: int
    links: int
    #: Estimate of the error of the mean over what errors are relative to.
    estimate: float


class Scene:
    """Named surfaces of one-sided polygons, each with a reflectance and an emission in each channel.

    Parameters
    ----------
    vertices : (n, 3), or a mesh
        Vertices; or anything with `vertices` and `faces` (trimesh), or with `points` and `faces` (pyvista).
    faces : (m, 3) or (m, 4), or a list of lists of indices
        Corners of each face, counter-clockwise seen from the side that gives and takes light.
    reflectance : float, (m,) or (m, channels)
        In [0, 1].
    emission : float, (m,) or (m, channels)
        Emitted radiosity, pi times the radiance.
    names : list of str, optional
        Name of the surface of each face: faces with one name are of one surface. Else each face is a surface.
    channels : list of str, optional
        Names of the channels: ``grey`` of one, ``r``, ``g``, ``b`` of three unless given.
    drop_degenerate : bool
        Leave out faces that are no polygon with an area, with a note, instead of refusing them.
    precision : float
        By how much coordinates may be off, in their unit: vertices are then moved back onto the planes of their faces, with a note.

    Raises
    ------
    ValueError
        If a shape does not fit, an index is out of range, a face is no polygon, or a reflectance or emission is out of range.

    Examples
    --------
    >>> import numpy as np, radgrad as rg
    >>> v = np.array([[x, y, z] for z in (0.0, 1.0) for y in (0.0, 1.0) for x in (0.0, 1.0)])
    >>> f = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]  # seen from inside
    >>> room = rg.Scene(v, f, reflectance=0.5, emission=[0, 1, 0, 0, 0, 0])
    >>> len(room), room.check(), room.factors().closure < 1e-12
    (6, [], True)
    """

    def __init__(
        self,
        vertices: Any,
        faces: Any = None,
        reflectance: ArrayLike = 0.5,
        emission: ArrayLike = 0.0,
        names: Optional[Sequence[str]] = None,
        channels: Optional[Sequence[str]] = None,
        drop_degenerate: bool = False,
        precision: float = 0.0,
    ) -> None:
        if faces is None:
            vertices, faces = _mesh(vertices)
        points = _rows(vertices, "vertices")
        if points.ndim != 2:
            raise ValueError(f"vertices have shape {points.shape}: expected (n, 3)")
        outlines = [_corners(face, index) for index, face in enumerate(faces)]
        count = len(outlines)
        shares, emitted = _numbers(reflectance, "reflectance"), _numbers(emission, "emission")
        width = max(_width(shares, "reflectance"), _width(emitted, "emission"))
        if channels is None:
            channels = {1: ["grey"], 3: ["r", "g", "b"]}.get(width, [f"c{index}" for index in range(width)])
        if width not in (1, len(channels)):
            raise ValueError(f"{width} values a face for {len(channels)} channels: {', '.join(map(repr, channels))}")
        if names is not None and len(names) != count:
            raise ValueError(f"{len(names)} names for {count} faces: give one for each")
        named = [str(name) for name in names] if names is not None else [f"face {index}" for index in range(count)]
        self._core = _radgrad.SceneCore.from_arrays(
            _whole(points),
            np.array([len(outline) for outline in outlines], dtype=np.int64),
            np.concatenate([np.zeros(0, dtype=np.int64), *outlines]),
            _per_face(shares, "reflectance", count, len(channels)),
            _per_face(emitted, "emission", count, len(channels)),
            named,
            list(channels),
            bool(drop_degenerate),
            float(precision),
        )

    @classmethod
    def _of(cls, core: Any) -> "Scene":
        scene = cls.__new__(cls)
        scene._core = core
        return scene

    @classmethod
    def read(
        cls,
        file: PathLike,
        drop_degenerate: bool = False,
        allow_outside: bool = False,
        budget: int = BUDGET,
        need_materials: bool = True,
        overlaps: str = "nested",
        precision: Optional[float] = None,
    ) -> "Scene":
        """Read a scene: ``.obj`` with its ``.mtl``, ``.gltf``, ``.glb``, ``.vs3``, ``.stl`` or ``.ply``.

        Parameters
        ----------
        file : str or path
            The file. What it names (materials, textures) is read too, in its own folder unless `allow_outside`.
        drop_degenerate : bool
            Leave out faces whose outline crosses itself, with a note, instead of refusing the file. Faces without area are left out.
        allow_outside : bool
            Read files that the scene names also where they lie outside its folder.
        budget : int
            Bytes that reading may take.
        need_materials : bool
            Refuse a scene whose materials are missing; else they are black. Form factors need none.
        overlaps : str
            Faces that overlap in one plane: ``nested`` cuts a face around those that lie in it and refuses the others, ``cut`` cuts the
            larger one however they overlap, ``refuse`` refuses all.
        precision : float, optional
            By how much coordinates may be off, in their unit; by default it is told from how the file writes them.

        Raises
        ------
        ValueError
            If something in a file is wrong, with file, line and what was expected.

        Examples
        --------
        >>> import radgrad as rg
        >>> rg.Scene.read("room.skp")
        Traceback (most recent call last):
        ...
        ValueError: `room.skp` is no scene that is read here: expected a name ending in .obj, .gltf, .glb, .vs3, .stl or .ply
        """
        given = None if precision is None else float(precision)
        core = _radgrad.SceneCore.read(
            os.fspath(file), drop_degenerate, allow_outside, int(budget), need_materials, overlaps, given
        )
        return cls._of(core)

    def __reduce__(self) -> Any:
        return _from_bytes, (self._core.to_bytes(), self._core.notes)

    def __len__(self) -> int:
        """Number of faces."""
        return len(self._core)

    @property
    def digest(self) -> str:
        """A name of the scene's content: SHA-256 of the bytes that are sent of it, in hexadecimal digits."""
        return hashlib.sha256(self._core.to_bytes()).hexdigest()

    @property
    def notes(self) -> "list[str]":
        """What the reader split, left out or did not use, with its place."""
        return self._core.notes

    @property
    def channels(self) -> "list[str]":
        """Names of the channels."""
        return self._core.channels

    @property
    def names(self) -> "list[str]":
        """Name of the surface of each face."""
        return self._core.names

    @property
    def areas(self) -> Floats:
        """(faces,): areas, in the unit of length squared."""
        return self._core.areas

    @property
    def outlines(self) -> "list[Floats]":
        """The vertices of each face, (n, 3)."""
        return self._core.outlines

    @property
    def reflectance(self) -> Floats:
        """(faces, channels): means of the reflectance over each face."""
        return self._core.means(False).reshape(-1, len(self.channels))

    @property
    def emission(self) -> Floats:
        """(faces, channels): means of the emitted radiosity over each face."""
        return self._core.means(True).reshape(-1, len(self.channels))

    def check(self) -> "list[str]":
        """Warnings about properties that are probably not meant: lamps that light nothing, surfaces that see nothing, a scene without lamps or inside out.

        A `ValueError` if the scene is refused as a whole, as where faces in one plane overlap.
        """
        return self._core.check()

    def capped(self, most: float) -> "Scene":
        """The same with no reflectance above `most`, with a note for each material that is changed."""
        return self._of(self._core.capped(float(most)))

    def factors(
        self,
        tolerance: Optional[float] = None,
        relative: Optional[float] = None,
        most_cells: Optional[int] = None,
        estimate: Optional[float] = None,
        most_points: Optional[int] = None,
    ) -> "Factors":
        """Form factors between all faces, with occlusion, each in a proven bracket.

        Parameters
        ----------
        tolerance : float, default 1e-3
            Bound that is asked of a factor past occluders. In free sight factors are exact to rounding.
        relative : float, default 0
            The same over the factor; the larger of the two counts.
        most_cells : int
            Pairs of cells that the bracket of one factor may take.
        estimate : float
            Error down to which an obstructed factor is integrated.
        most_points : int
            Points that this may take.

        Returns
        -------
        Factors

        Raises
        ------
        ValueError
            If the scene is refused, as where faces overlap.
        """
        settings = _settings(tolerance, relative, most_cells, estimate, most_points)
        return Factors(self, self._core.factors(settings))

    def solve(
        self,
        error: float = 0.001,
        degree: Optional[int] = None,
        seconds: Optional[float] = None,
        most_elements: Optional[int] = None,
        divide: str = "residual",
        progress: Union[bool, Callable[[Round], None]] = False,
    ) -> "Solution":
        """The radiosity everywhere, reflections included. Ctrl-C lets the round end and gives what was reached.

        Parameters
        ----------
        error : float
            Estimate of the error of the mean radiosity over the mean that is reflected, at most.
        degree : int, optional
            Of the polynomials on elements, 0 to 4. If none is given 2; 1 from a thousand faces on; 4 where few faces face each
            other at about their width.
        seconds : float, optional
            In which to be done: no round is begun that would probably end later.
        most_elements : int, optional
            Beyond which none is divided any more.
        divide : "residual", "gradient" or "shadows"
            Divide the elements that add most to the error of gathers; those whose polynomials are off most; or the same after
            faces were cut along shadow lines.
        progress : bool or callable
            Print a line after each round, or call with a `Round`.

        Returns
        -------
        Solution

        Raises
        ------
        ValueError
            If an argument is out of range, the scene is refused, or light is emitted in a closed space whose faces reflect all.
        """
        request = {
            "error": float(error),
            "degree": degree,
            "seconds": seconds,
            "most_elements": most_elements,
            "divide": divide,
            "rounds": None,
        }
        return Solution(self, request, _watching(progress))


def _from_bytes(content: bytes, notes: "list[str]") -> Scene:
    return Scene._of(_radgrad.SceneCore.from_bytes(content, notes))


def _settings(
    tolerance: Optional[float],
    relative: Optional[float],
    most_cells: Optional[int],
    estimate: Optional[float],
    most_points: Optional[int],
) -> "dict[str, Any]":
    for name, value in (("tolerance", tolerance), ("relative", relative), ("estimate", estimate)):
        if value is not None and not 0.0 <= value < float("inf"):
            raise ValueError(f"{name} is {value}: it must be finite and not negative")
    return {
        "tolerance": tolerance,
        "relative": relative,
        "most_cells": most_cells,
        "estimate": estimate,
        "most_points": most_points,
    }


def _watching(progress: Any) -> Optional[Callable[..., None]]:
    if progress is False or progress is None:
        return None

    def told(*fields: Any) -> None:
        of = Round(*fields)
        if callable(progress):
            progress(of)
        else:
            print(f"round {of.round}: {of.elements} elements, {of.links} links, estimate {of.estimate:.3%}", flush=True)

    return told


def _mesh(mesh: Any) -> "tuple[Any, Any]":
    """Vertices and faces of another library's mesh."""
    faces = getattr(mesh, "faces", None)
    if faces is not None and hasattr(mesh, "vertices"):
        return mesh.vertices, faces
    if faces is not None and hasattr(mesh, "points"):
        # VTK's list: the number of corners of a face, then the corners.
        padded, outlines, at = np.asarray(faces), [], 0
        while at < len(padded):
            end = at + 1 + int(padded[at])
            outlines.append(padded[at + 1 : end])
            at = end
        return mesh.points, outlines
    raise ValueError(f"{type(mesh).__name__} has no vertices and faces: expected those of a mesh, or two arrays")


def _corners(face: Any, index: int) -> "NDArray[np.int64]":
    corners = np.asarray(face)
    if corners.ndim != 1 or corners.dtype.kind not in "iu":
        raise ValueError(f"faces[{index}] is {face!r}: expected indices of vertices")
    return corners.astype(np.int64)


def _width(values: Floats, what: str) -> int:
    if values.ndim > 2:
        raise ValueError(f"{what} has shape {values.shape}: expected a number, (faces,) or (faces, channels)")
    return values.shape[1] if values.ndim == 2 else 1


def _per_face(values: Floats, what: str, faces: int, channels: int) -> Floats:
    """A value for each face and channel, row by row."""
    column = values[:, None] if values.ndim == 1 else values
    try:
        whole = np.broadcast_to(column, (faces, channels))
    except ValueError:
        raise ValueError(f"{what} has shape {values.shape}: expected ({faces},) or ({faces}, {channels})") from None
    return _whole(whole).reshape(-1)


class Factors:
    """Form factors between the faces of a scene: sparse matrices of shape (faces, faces), `F[i, j]` from face i to face j.

    Those of pairs that see nothing of each other are not stored, and are exactly 0. `values`, `lower` and `upper` need scipy.
    """

    def __init__(self, scene: Scene, core: Any, moved: "Tuple[float, float]" = (0.0, 0.0)) -> None:
        self._scene, self._core, self._moved = scene, core, moved
        self.indptr, self.indices, self.data, self._lower, self._upper, self.occluders = core.csr()

    def _matrix(self, data: Any) -> "_csr_array":
        try:
            from scipy.sparse import csr_array
        except ImportError:
            raise ImportError("sparse matrices need scipy: pip install radgrad[sparse], or take indptr, indices and data") from None
        return csr_array((data, self.indices, self.indptr), shape=(len(self._scene), len(self._scene)))

    @property
    def values(self) -> "_csr_array":
        """The factors, in their brackets."""
        return self._matrix(self.data)

    @property
    def lower(self) -> "_csr_array":
        """Proven lower bounds."""
        return self._matrix(self._lower)

    @property
    def upper(self) -> "_csr_array":
        """Proven upper bounds."""
        return self._matrix(self._upper)

    @property
    def closure(self) -> float:
        """Largest `|1 - sum|` of a row: in a closed scene its error."""
        return self._core.closure

    @property
    def reciprocity(self) -> float:
        """Largest `|A_i F_ij - A_j F_ji|` over the smaller of the two areas: a few roundings."""
        return self._core.reciprocity

    @property
    def bound(self) -> float:
        """Largest bound on the error of a factor."""
        return self._core.bound

    @property
    def unmet(self) -> int:
        """How many factors have a bound above what was asked for."""
        return self._core.unmet

    @property
    def unclosed(self) -> "list[int]":
        """Faces whose rows cannot sum to 1 within their brackets: none in a closed scene."""
        return self._core.unclosed

    @property
    def moved(self) -> "Tuple[float, float]":
        """How far `repaired` moved factors: most, and in the mean."""
        return self._moved

    def repaired(self) -> "Factors":
        """The same, moved the least within the brackets and reciprocal, so that every row sums to 1.

        A `ValueError` if some row cannot: the scene is not closed there.
        """
        core, largest, mean = self._core.repaired()
        return Factors(self._scene, core, (largest, mean))

    def by_surface(self) -> "tuple[list[str], Floats]":
        """Names of the surfaces and the dense matrix between them: sums over their faces, weighted by area."""
        names, areas = self._scene.names, self._scene.areas
        order = list(dict.fromkeys(names))
        place = np.array([order.index(name) for name in names]) if len(order) < 50 else _places(names, order)
        rows = np.repeat(np.arange(len(names)), np.diff(self.indptr))
        exchanged, whole = np.zeros((len(order), len(order))), np.zeros(len(order))
        np.add.at(whole, place, areas)
        np.add.at(exchanged, (place[rows], place[self.indices]), areas[rows] * self.data)
        return order, exchanged / whole[:, None]

    def tobytes(self) -> bytes:
        """All of it as bytes, to compare."""
        arrays = (self.indptr, self.indices, self.data, self._lower, self._upper, self.occluders)
        return b"".join(array.tobytes() for array in arrays)


def _places(names: "list[str]", order: "list[str]") -> "NDArray[np.int64]":
    at = {name: index for index, name in enumerate(order)}
    return np.array([at[name] for name in names])


@dataclass(frozen=True)
class Gathered:
    """Radiosity and irradiance at points, each with an estimate of its error. `S` is the shape of the points."""

    #: `S + (channels,)`: radiosity, in the unit of the emission; in free space that of a white surface, which is the irradiance.
    radiosity: Floats
    #: `S + (channels,)`: estimates of its errors.
    estimate: Floats
    #: `S + (channels,)`: irradiance, what arrives, in the same unit.
    irradiance: Floats
    #: `S + (channels,)`: estimates of its errors.
    irradiance_estimate: Floats
    #: `S`: faces that the points are on; -1 in free space.
    face: "NDArray[np.int64]"


@dataclass(frozen=True)
class Slopes:
    """Gradients of radiosity and irradiance at points, each with an estimate of its error. `S` is the shape of the points.

    They are with respect to the position, the normal kept: in the unit of the emission over the scene's unit of length. On a face they are
    within its plane.
    """

    #: `S + (channels, 3)`: gradient of the radiosity; in free space that of the irradiance.
    radiosity: Floats
    #: `S + (channels,)`: estimates of the lengths of its errors.
    radiosity_estimate: Floats
    #: `S + (channels, 3)`: gradient of the irradiance.
    irradiance: Floats
    #: `S + (channels,)`: estimates of the lengths of its errors.
    irradiance_estimate: Floats


@dataclass(frozen=True)
class Picture:
    """What a camera sees of a solution: 0 beside all faces and on their backs."""

    #: (height, width, channels): radiosity, in the unit of the emission.
    radiosity: Floats
    #: (height, width, channels): estimates of its errors.
    estimate: Floats


@dataclass(frozen=True)
class Certificate:
    """Intervals that hold with a stated probability, whatever the scene: made by random walks on it that know nothing of the solution."""

    #: Probability that any of the intervals fails.
    confidence: float
    #: Seed of the random numbers: the same gives the same bytes.
    seed: int
    #: (channels, 2): ends of the interval of the mean radiosity over all area; the upper is infinite where nothing bounds it. Of points
    #: (..., channels, 2): of the radiosity on faces, of the irradiance in space.
    interval: Floats
    #: (..., channels, 2): of points, the ends of the irradiance; None of the mean.
    irradiance: Optional[Floats] = None


class Solution:
    """A solved scene. Made by `Scene.solve`."""

    def __init__(self, scene: Scene, request: "dict[str, Any]", watch: Optional[Callable[..., None]] = None) -> None:
        self._scene, self._request = scene, request
        self._core = _radgrad.SolutionCore(scene._core, request, watch)
        self._certificate: Optional[Certificate] = None

    def __reduce__(self) -> Any:
        # Solving again gives the same digits, and takes no more than the scene to send.
        return _solved_again, (self._scene, self._again(), self.digest)

    def _again(self) -> "dict[str, Any]":
        """What gives the same solution on any machine: the same rounds, however long they take."""
        return {**self._request, "seconds": None, "rounds": self._core.rounds}

    @property
    def scene(self) -> Scene:
        """The scene."""
        return self._scene

    @property
    def digest(self) -> str:
        """A name of the solution's content: SHA-256 of its values on every element."""
        return hashlib.sha256(self._core.values().tobytes()).hexdigest()

    @property
    def summary(self) -> "dict[str, Any]":
        """What was reached: `rounds`, `elements`, `links`, `estimate`, `seconds`, `warnings`; of each of `channels` its mean with its
        estimate and, once it was certified, the interval; of each of `surfaces` its area, and mean, least and largest in each channel.
        Radiosities in the unit of the emission, `estimate` over the mean."""
        return json.loads(self._core.summary())

    def certify(
        self,
        width: Optional[float] = None,
        delta: Optional[float] = None,
        seed: Optional[int] = None,
        rays: Optional[int] = None,
        points: Optional[Tuple[ArrayLike, ArrayLike]] = None,
    ) -> Certificate:
        """Certify the mean radiosity over all area, or points, by random walks on the scene alone.

        Parameters
        ----------
        width : float, optional
            Half the width of the interval, over the mean radiosity that is reflected, or over a point's irradiance, at which walks end. By
            default a third of the `error` of the solve.
        delta : float, optional
            Probability that any of the intervals fails; 1e-6 by default.
        seed : int, optional
            Of the random numbers; 1 by default.
        rays : int, optional
            After which walks end in any case; for each point the same again. By default as many as take about a third of the time of the
            solve, 200 million where a width is given, and 100,000 for each point.
        points : (points, normals), optional
            As for `gather`: certify these instead of the mean.

        Returns
        -------
        Certificate
            That of the mean is `certified` from then on, and in `summary` and files.

        Raises
        ------
        ValueError
            If an argument is out of range, or a point has no certificate.
        """
        wished = (None if width is None else float(width), None if delta is None else float(delta), seed, rays)
        channels = len(self._scene.channels)
        if points is not None:
            shape, rows, directions = _pairs(*points)
            *columns, confidence, seed = self._core.certify_points((rows, directions, None, list(shape)), wished)
            interval, irradiance = (column.reshape((*shape, channels, 2)) for column in columns)
            return Certificate(confidence, seed, interval, irradiance)
        ends, confidence, seed, _, _ = self._core.certify(wished)
        self._certificate = Certificate(confidence, seed, ends.reshape((channels, 2)))
        return self._certificate

    @property
    def certified(self) -> Floats:
        """(channels, 2): the interval of the mean radiosity that `certify` found last; it is asked when this is first read."""
        return (self._certificate or self.certify()).interval

    @property
    def confidence(self) -> float:
        """The probability that `certified` fails."""
        return (self._certificate or self.certify()).confidence

    def gather(self, points: ArrayLike, normals: ArrayLike, on: Optional[str] = None) -> Gathered:
        """Radiosity and irradiance at points anywhere, each by one exact gather.

        Parameters
        ----------
        points, normals : (..., 3)
            They broadcast to a shape `S`. A point within a millionth of the scene's extent of a face is on it, and the face faces along
            the normal; others are sensors in free space, that see the half space before the normal and hide nothing.
        on : "face" or "free", optional
            Where all points are taken to be, instead.

        Returns
        -------
        Gathered
            `radiosity` and `estimate`, and the same of the `irradiance`, each S + (channels,).

        Raises
        ------
        ValueError
            If a point is near a face, and none there faces along the normal; or not finite.
        """
        shape, rows, directions = _pairs(points, normals)
        return _gathered(self._core.gather((rows, directions, _on_face(on), list(shape))), shape, len(self._scene.channels))

    def gradient(self, points: ArrayLike, normals: ArrayLike, on: Optional[str] = None) -> Slopes:
        """Gradients of radiosity and irradiance at points anywhere.

        They are off by more than values are: in the Cornell box by less than 1 % at 95 of a hundred places if the scene is solved to an
        `error` of 1e-3, and at 99 if it is solved to 2e-4.

        Parameters
        ----------
        points, normals, on
            As for `gather`.

        Returns
        -------
        Slopes
            Gradients of the `radiosity` and of the `irradiance`, S + (channels, 3), with estimates, S + (channels,).

        Raises
        ------
        ValueError
            If a point is near a face, and none there faces along the normal; or not finite.
        """
        shape, rows, directions = _pairs(points, normals)
        columns = self._core.gradient((rows, directions, _on_face(on), list(shape)))
        channels = len(self._scene.channels)
        slopes = [column.reshape((*shape, channels, 3)) for column in columns[::2]]
        estimates = [column.reshape((*shape, channels)) for column in columns[1::2]]
        return Slopes(slopes[0], estimates[0], slopes[1], estimates[1])

    def to_vtu(self, file: PathLike) -> None:
        """Write the solution for ParaView: radiosity and gradient with estimates of their errors at vertices, where these come from on cells."""
        if not os.fspath(file).lower().endswith(".vtu"):
            raise ValueError(f"{os.fspath(file)!r}: expected a name ending in .vtu")
        self._core.write(os.fspath(file))

    def to_ply(self, file: PathLike) -> None:
        """Write the elements as polygons with colours."""
        if not os.fspath(file).lower().endswith(".ply"):
            raise ValueError(f"{os.fspath(file)!r}: expected a name ending in .ply")
        self._core.write(os.fspath(file))

    def image(
        self,
        camera: Sequence[Any],
        size: "Tuple[int, int]" = (512, 512),
        file: Optional[PathLike] = None,
        samples: int = 4,
        exposure: float = 0.0,
        tone: str = "reinhard",
        gather: bool = False,
    ) -> Picture:
        """What a camera sees.

        Parameters
        ----------
        camera : (eye, target, up, degrees)
            Three points and the vertical field of view in degrees, or the ten numbers of these.
        size : (width, height)
            In pixels.
        file : str or path, optional
            Write it too: ``.exr`` (radiosity and estimate) or ``.png`` (tone-mapped).
        samples : int
            Rays a pixel, of which the mean is taken.
        exposure : float
            Stops by which a ``.png`` is brighter, each twice as bright.
        tone : "reinhard" or "linear"
            Tone curve of a ``.png``.
        gather : bool
            One exact gather a ray instead of the polynomials.

        Returns
        -------
        Picture
            `radiosity` and `estimate`, each (height, width, channels).

        Raises
        ------
        ValueError
            If the camera sees nothing by its making, or the file cannot be written.
        """
        numbers = np.concatenate([_numbers(part, "camera").reshape(-1) for part in camera])
        if numbers.size != 10:
            raise ValueError(f"camera has {numbers.size} numbers: expected ten, eye, target, up and field of view")
        options = [f"--camera={' '.join(map(repr, numbers.tolist()))}", f"--size={int(size[0])}x{int(size[1])}"]
        options += [f"--samples={int(samples)}", f"--exposure={float(exposure)!r}", f"--tone={tone}"]
        options += ["--gather"] * bool(gather)
        if file is not None:
            options.append(f"--view={os.fspath(file)}")
        (width, height), radiosity, estimate = self._core.picture(options)
        shape = (height, width, len(self._scene.channels))
        return Picture(radiosity.reshape(shape), estimate.reshape(shape))


def _on_face(on: Optional[str]) -> Optional[bool]:
    if on not in (None, "face", "free"):
        raise ValueError(f'on is {on!r}: it must be "face", "free" or None')
    return None if on is None else on == "face"


def _gathered(columns: Any, shape: "tuple[int, ...]", channels: int) -> Gathered:
    *numbers, face = columns
    found = [column.reshape((*shape, channels)) for column in numbers]
    return Gathered(found[0], found[1], found[2], found[3], face.reshape(shape)[()])


def _pairs(points: Any, normals: Any) -> "tuple[tuple[int, ...], Floats, Floats]":
    """The shape of points and normals together, and rows of each."""
    positions, directions = _rows(points, "points"), _rows(normals, "normals")
    try:
        shape = np.broadcast_shapes(positions.shape[:-1], directions.shape[:-1])
    except ValueError:
        shapes = f"points {positions.shape[:-1]} and normals {directions.shape[:-1]}"
        raise ValueError(f"{shapes} cannot be broadcast together") from None
    rows = [_whole(np.broadcast_to(array, (*shape, 3)).reshape(-1, 3)) for array in (positions, directions)]
    return shape, rows[0], rows[1]


def _solved_again(scene: Scene, request: "dict[str, Any]", digest: str) -> Solution:
    solution = Solution(scene, request)
    if solution.digest != digest:
        raise RuntimeError(f"the solution of {scene.digest} is {solution.digest} on this machine, and was {digest} where it came from")
    return solution
