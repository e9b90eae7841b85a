"""Solutions of scenes, and what they are asked."""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
import time
import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Callable, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _mesh, _radgrad, _store
from ._evaluate import Floats, _number, _numbers, _rows, _whole
from ._factors import ToleranceWarning
from ._progress import QUIET, Progress, is_seen, watching
from ._shown import Shown, pandas, table
from ._store import PathLike

if TYPE_CHECKING:
    from ._scene import Scene


class Round(NamedTuple):
    """How far a solution has come."""

    #: From 1.
    round: int
    elements: int
    links: int
    #: Estimate of the error of the mean over what errors are relative to.
    estimate: float


@dataclass(frozen=True, eq=False)
class Gathered(Shown):
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

    def _shape(self) -> "Tuple[int, ...]":
        return np.shape(self.face)


@dataclass(frozen=True, eq=False)
class Slopes(Shown):
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

    def _shape(self) -> "Tuple[int, ...]":
        return np.shape(self.radiosity)[:-2]


@dataclass(frozen=True, eq=False)
class Sensitivity(Shown):
    """Derivatives of a weighted sum of radiosities by the emission, the reflectance and the vertices of every face. Light of one channel
    makes none in another."""

    #: (faces, channels): by the emission of each face, in the unit in which `Scene` takes it.
    emission: Floats
    #: (faces, channels): by the reflectance of each face.
    reflectance: Floats
    #: (faces, channels): estimates of the errors of `emission`.
    emission_estimate: Floats
    #: (faces, channels): estimates of the errors of `reflectance`.
    reflectance_estimate: Floats
    #: (channels,): the sum itself.
    value: Floats
    #: Of each face (vertices, channels, 3): by the places of its vertices, in the order of `Scene.outlines`; None unless asked for.
    vertices: "Optional[list[Floats]]" = None
    #: Of each face (vertices, channels): estimates of the lengths of the errors of `vertices`.
    vertices_estimate: "Optional[list[Floats]]" = None
    #: Of each face (vertices, 3): where they are.
    outlines: "Optional[list[Floats]]" = None

    def _shape(self) -> "Tuple[int, ...]":
        return np.shape(self.emission)[:1]

    def translation(self, faces: Sequence[int]) -> Floats:
        """(channels, 3): by moving these faces together along each axis."""
        return sum((by.sum(0) for by, _ in self._vertices_of(faces)), np.zeros((len(self.value), 3)))

    def rotation(self, faces: Sequence[int], about: ArrayLike) -> Floats:
        """(channels, 3): by turning these faces together about each axis through a point, for an angle in radians."""
        turned = (np.cross(arms[:, np.newaxis], by).sum(0) for by, arms in self._vertices_of(faces, about))
        return sum(turned, np.zeros((len(self.value), 3)))

    def scale(self, faces: Sequence[int], about: ArrayLike) -> Floats:
        """(channels,): by scaling these faces together from a point, for the logarithm of the scale."""
        scaled = (np.einsum("vci,vi->c", by, arms) for by, arms in self._vertices_of(faces, about))
        return sum(scaled, np.zeros(len(self.value)))

    def _vertices_of(self, faces: Sequence[int], about: ArrayLike = (0.0, 0.0, 0.0)) -> "list[tuple[Floats, Floats]]":
        """Of each of these faces: the derivatives by its vertices, and where they are from a point."""
        if self.vertices is None or self.outlines is None:
            raise ValueError("there are no derivatives by vertices: ask for them by derivative(..., vertices=True)")
        return [(self.vertices[face], self.outlines[face] - _numbers(about, "about")) for face in faces]

    def frame(self) -> Any:
        """A pandas frame with a row for each face: its derivatives by channel."""
        columns = {}
        for name in ("emission", "reflectance"):
            for channel in range(len(self.value)):
                columns[name if len(self.value) == 1 else f"{name}_{channel}"] = getattr(self, name)[:, channel]
        return pandas().DataFrame(columns)


@dataclass(frozen=True, eq=False)
class Picture(Shown):
    """What a camera sees of a solution: 0 beside all faces and on their backs."""

    #: (height, width, channels): radiosity, in the unit of the emission.
    radiosity: Floats
    #: (height, width, channels): estimates of its errors.
    estimate: Floats

    def _shape(self) -> "Tuple[int, ...]":
        return np.shape(self.radiosity)[:-1]


@dataclass(frozen=True, eq=False)
class Certificate(Shown):
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

    def _shape(self) -> "Tuple[int, ...]":
        return np.shape(self.interval)[:-2]


class Solution:
    """A solved scene. Made by `Scene.solve`."""

    def __init__(self, scene: "Scene", request: "dict[str, Any]", core: Any) -> None:
        self._scene, self._request, self._core = scene, request, core
        self._certificate: Optional[Certificate] = None

    @classmethod
    def _made(cls, scene: "Scene", request: "dict[str, Any]", watch: Optional[Callable[..., None]] = None) -> "Solution":
        """Solves."""
        return cls(scene, request, _radgrad.SolutionCore(scene._core, request, watch))

    def _warn(self) -> "Solution":
        """Says so where what was asked for was not reached."""
        reached, asked = self.summary["estimate"], self._request["error"]
        if not reached <= asked:
            remedy = "give it more seconds or most_elements, or ask for less"
            warnings.warn(f"the estimate is {reached:.3g}, above the error of {asked:g} that was asked for: {remedy}", ToleranceWarning, 3)
        return self

    def save(self, file: PathLike) -> None:
        """Keep all of it in a ``.npz``, of which `load` makes it again without solving: what is asked of it has the same bytes."""
        about = {"request": self._request, "notes": self._scene.notes, "certificate": self._core.certificate()}
        _store.save(file, "Solution", about, {"scene": self._scene._core.to_bytes(), "state": self._core.to_bytes()})

    @classmethod
    def load(cls, file: PathLike, budget: int = _store.BUDGET) -> "Solution":
        """What `save` wrote. `budget` bytes may be read.

        A `ValueError` if the file is no such file or is damaged, an `OSError` if it cannot be read.
        """
        from ._scene import _from_bytes

        about, parts = _store.load(file, "Solution", ("scene", "state"), budget)
        return _kept(_from_bytes(parts["scene"], about["notes"]), about["request"], parts["state"], about["certificate"])

    def __reduce__(self) -> Any:
        return _kept, (self._scene, self._request, self._core.to_bytes(), self._core.certificate())

    def __copy__(self) -> "Solution":
        return self

    def __deepcopy__(self, memo: Any) -> "Solution":
        # Nothing of it changes but the certificate that was asked for last.
        return self

    def __eq__(self, other: object) -> bool:
        """Whether both are of one scene, and have the same values on every element."""
        if not isinstance(other, Solution):
            return NotImplemented
        return self._scene == other._scene and self.digest == other.digest

    def __hash__(self) -> int:
        return hash(self.digest)

    def _said(self) -> "list[tuple[str, Any]]":
        summary = self.summary
        means = ", ".join(f"{of['name']} {of['mean']:.6g} within about {of['estimate']:.2g}" for of in summary["channels"])
        return [("mean", means), ("rounds", summary["rounds"]), ("elements", summary["elements"]), ("estimate", f"{summary['estimate']:.3g}")]

    def __repr__(self) -> str:
        return f"<radgrad.Solution: {'; '.join(f'{name} {value}' for name, value in self._said())}>"

    def _repr_html_(self) -> str:
        return table("Solution", self._said())

    def by_surface(self) -> "dict[str, Floats]":
        """(channels,) for each surface that exchanges light: the mean radiosity over it, in the unit of the emission."""
        return {of["name"]: np.array(of["mean"]) for of in self.summary["surfaces"] if of["mean"]}

    def frame(self) -> Any:
        """A pandas frame with a row for each surface: area, and of each channel the mean, least and largest radiosity."""
        rows = []
        for of in self.summary["surfaces"]:
            row = {"surface": of["name"], "area": of.get("area")}
            for what in ("mean", "least", "largest"):
                row.update({f"{what}_{channel}": value for channel, value in zip(self._scene.channels, of[what])})
            rows.append(row)
        return pandas().DataFrame(rows).set_index("surface")

    def to_pyvista(self) -> Any:
        """As `pyvista.UnstructuredGrid`: what `to_vtu` writes."""
        pyvista = _mesh._needed("pyvista", "radgrad[vtk]")
        with tempfile.TemporaryDirectory() as folder:
            self.to_vtu(os.path.join(folder, "solution.vtu"))
            return pyvista.read(os.path.join(folder, "solution.vtu"))

    @property
    def scene(self) -> "Scene":
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
        asked = [None if value is None else _number(value, what) for value, what in ((width, "width"), (delta, "delta"))]
        wished = (asked[0], asked[1], seed, rays)
        channels = len(self._scene.channels)
        if points is not None:
            shape, rows, directions = _pairs(*points)
            with watching(None, "certify points"):
                *columns, confidence, seed = self._core.certify_points((rows, directions, None, list(shape)), wished)
            interval, irradiance = (column.reshape((*shape, channels, 2)) for column in columns)
            return Certificate(confidence, seed, interval, irradiance)
        with watching(None, "certify"):
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

    def gather(
        self, points: ArrayLike, normals: ArrayLike, on: Optional[str] = None, progress: Progress = None
    ) -> Gathered:
        """Radiosity and irradiance at points anywhere, each by one exact gather.

        Parameters
        ----------
        points, normals : (..., 3)
            They broadcast to a shape `S`. A point within a millionth of the scene's extent of a face is on it, and the face faces along
            the normal; others are sensors in free space, that see the half space before the normal and hide nothing.
        on : "face" or "free", optional
            Where all points are taken to be, instead.
        progress : bool or callable, optional
            As of `Scene.factors`, by points.

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
        with watching(progress, "gather: points"):
            found = self._core.gather((rows, directions, _on_face(on), list(shape)))
        return _gathered(found, shape, len(self._scene.channels))

    def gradient(
        self, points: ArrayLike, normals: ArrayLike, on: Optional[str] = None, progress: Progress = None
    ) -> Slopes:
        """Gradients of radiosity and irradiance at points anywhere.

        They are off by more than values are: in the Cornell box by less than 1 % at 95 of a hundred places if the scene is solved to an
        `error` of 1e-3, and at 99 if it is solved to 2e-4.

        Parameters
        ----------
        points, normals, on, progress
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
        with watching(progress, "gradient: points"):
            columns = self._core.gradient((rows, directions, _on_face(on), list(shape)))
        channels = len(self._scene.channels)
        slopes = [column.reshape((*shape, channels, 3)) for column in columns[::2]]
        estimates = [column.reshape((*shape, channels)) for column in columns[1::2]]
        return Slopes(slopes[0], estimates[0], slopes[1], estimates[1])

    def derivative(
        self,
        weights: "Union[ArrayLike, dict[str, ArrayLike]]",
        points: Optional[Tuple[ArrayLike, ArrayLike]] = None,
        vertices: bool = False,
    ) -> Sensitivity:
        """Derivatives of a weighted sum of radiosities by the emission and the reflectance of every face, and by all vertices.

        All together cost as much as one solution of the linear system, however many faces there are; with those by vertices about as much as
        the solution of the scene.

        Parameters
        ----------
        weights : (surfaces,) or (surfaces, channels), or a dict of names of surfaces
            Of the mean radiosity of each surface, in the order of `summary["surfaces"]`; a dict has those that are not 0. With `points`
            (n,) or (n, channels), of each point.
        points : positions and normals, each (n, 3), optional
            On faces the radiosity is summed, elsewhere the irradiance, as by `gather`. A point on a face goes with its plane along the
            normal, and stays within it; others stay where they are.
        vertices : bool
            Whether derivatives by vertices are asked for.

        Returns
        -------
        Sensitivity
            `emission` and `reflectance`, each (faces, channels), with estimates of their errors, and the `value` of the sum; `vertices`, for
            each face (vertices, channels, 3), from which `translation`, `rotation` and `scale` of faces follow. Vertices of several faces that
            are at one place move together: add them up.

        Raises
        ------
        ValueError
            If weights do not fit the surfaces or points, or a point is near a face, and none there faces along the normal.

        Examples
        --------
        >>> import radgrad as rg
        >>> v = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
        >>> f = [[0, 1, 2, 3], [7, 6, 5, 4]]
        >>> s = rg.Scene(v, f, reflectance=0.5, emission=[0, 1], names=["floor", "ceiling"]).solve(error=0.01)
        >>> d = s.derivative({"floor": 1.0})
        >>> bool(abs(d.value[0] - d.emission[1, 0]) < 0.01)
        True
        >>> raised = s.derivative({"floor": 1.0}, vertices=True).translation([1])[0, 2]
        >>> bool(raised < 0)
        True
        """
        channels = len(self._scene.channels)
        if points is None:
            names = [of["name"] for of in self.summary["surfaces"]]
            count, what = len(names), "surface"
            if isinstance(weights, dict):
                unknown = [name for name in weights if name not in names]
                if unknown:
                    raise ValueError(f"weights: no surface is called {unknown[0]!r}: expected some of {', '.join(names[:12])}")
                given = {name: np.broadcast_to(_numbers(of, "weights"), (channels,)) for name, of in weights.items()}
                weights = np.array([given.get(name, np.zeros(channels)) for name in names])
            places = None
        else:
            if not hasattr(points, "__len__") or len(points) != 2:
                raise ValueError("points: expected positions and normals, each (n, 3): points=(positions, normals)")
            shape, *rows = _pairs(*points)
            if len(shape) != 1:
                raise ValueError(f"points has shape {(*shape, 3)}: expected (n, 3)")
            count = shape[0]
            what, places = "point", (rows[0], rows[1])
        table = _numbers(weights, "weights")
        if table.shape == (count,):
            table = np.repeat(table[:, np.newaxis], channels, axis=1)
        if table.shape != (count, channels):
            raise ValueError(f"weights has shape {table.shape}: expected ({count},) or ({count}, {channels}), one for each {what}")
        with watching(None, "derivative"):
            value, estimate, emission, reflectance, *by_vertices = self._core.derivative(table.tolist(), places, vertices)
        emission, reflectance = (column.reshape((-1, channels)) for column in (emission, reflectance))
        moved: "Tuple[Any, ...]" = ()
        if vertices:
            outlines = self._scene.outlines
            ends = np.cumsum([len(outline) for outline in outlines])[:-1]
            shapes = ((-1, channels, 3), (-1, channels))
            moved = (*(np.split(column.reshape(shape), ends) for column, shape in zip(by_vertices, shapes)), outlines)
        return Sensitivity(emission, reflectance, abs(emission) * estimate, abs(reflectance) * estimate, value, *moved)

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
            One exact gather a ray, instead of some that pixels share.

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
        with watching(None, "image"):
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


def watching_rounds(progress: Any) -> "Optional[Callable[..., None]]":
    """Who is told of rounds."""
    if progress is False:
        return None
    if not (progress is None or progress is True or callable(progress)):
        raise ValueError(f"progress is {progress!r}: it must be True, False, None or a function that takes a radgrad.Round")
    start = time.monotonic()

    def told(*fields: Any) -> None:
        of = Round(*fields)
        if callable(progress):
            progress(of)
        elif progress or (time.monotonic() - start >= QUIET and is_seen()):
            print(f"round {of.round}: {of.elements} elements, {of.links} links, estimate {of.estimate:.3%}", flush=True)

    return told


def _kept(scene: "Scene", request: "dict[str, Any]", state: bytes, certificate: Any) -> Solution:
    made = None if certificate is None else tuple(certificate)
    solution = Solution(scene, request, _radgrad.SolutionCore.from_bytes(scene._core, request, state, made))
    if made is not None:
        solution._certificate = Certificate(made[3], made[4], np.array(made[0]))
    return solution
