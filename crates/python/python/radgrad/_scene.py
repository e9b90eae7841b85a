"""Scenes."""

from __future__ import annotations

import hashlib
import os
import warnings
import weakref
from typing import Any, Callable, Literal, Optional, Sequence, Union, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _mesh, _radgrad
from ._evaluate import Floats, _number, _numbers, _rows, _whole
from ._factors import Factors, ReaderWarning, settings_of
from ._progress import Progress, watching
from ._rays import RayFactors, ray_settings
from ._shown import table
from ._solution import Round, Solution, watching_rounds
from ._store import PathLike

#: Bytes that reading a file may take unless others are asked for.
BUDGET = 256 << 20


class Scene:
    """Named surfaces of one-sided polygons, each with a reflectance and an emission in each channel.

    Parameters
    ----------
    vertices : (n, 3), or a mesh
        Vertices; or a mesh: of trimesh (a `Trimesh`, or a `Scene` whose nodes are the surfaces), of pyvista (`PolyData`, `UnstructuredGrid`,
        `StructuredGrid`, or a `MultiBlock` whose blocks are the surfaces) or of meshio.
    faces : (m, 3) or (m, 4), or a list of lists of indices
        Corners of each face, counter-clockwise seen from the side that gives and takes light.
    reflectance : float, (m,) or (m, channels)
        In [0, 1].
    emission : float, (m,) or (m, channels)
        Emitted radiosity, pi times the radiance.
    names : list of str, or str, optional
        Name of the surface of each face: faces with one name are of one surface. Of a mesh also the name of the cell array that has them.
        Else each face is a surface.
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
        names: Union[None, str, Sequence[str]] = None,
        channels: Optional[Sequence[str]] = None,
        drop_degenerate: bool = False,
        precision: float = 0.0,
    ) -> None:
        notes: "list[str]" = []
        if faces is None:
            mesh = _mesh.taken(vertices, names)
            vertices, faces, notes = np.concatenate([np.zeros((0, 3)), *mesh.vertices]), mesh.faces, mesh.notes
            names = mesh.names if names is None or isinstance(names, str) else names
        elif isinstance(names, str):
            raise ValueError(f"names is {names!r}: expected a list of {len(faces)} names; a text names the cell array of a mesh")
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
            _number(precision, "precision", "a length"),
        )
        if notes:
            self._core = self._core.noted(notes)
        self._kept: "weakref.WeakValueDictionary[Any, Factors]" = weakref.WeakValueDictionary()
        _warn_of(self)

    @classmethod
    def _of(cls, core: Any, kept: Any = None) -> "Scene":
        scene = cls.__new__(cls)
        scene._core = core
        scene._kept = weakref.WeakValueDictionary() if kept is None else kept
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
        given = None if precision is None else _number(precision, "precision", "a length")
        core = _radgrad.SceneCore.read(
            os.fspath(file), drop_degenerate, allow_outside, int(budget), need_materials, overlaps, given
        )
        scene = cls._of(core)
        _warn_of(scene)
        return scene

    def __reduce__(self) -> Any:
        return _from_bytes, (self._core.to_bytes(), self._core.notes)

    def __len__(self) -> int:
        """Number of faces."""
        return len(self._core)

    def __copy__(self) -> "Scene":
        return self

    def __deepcopy__(self, memo: Any) -> "Scene":
        # Nothing of it changes.
        return self

    def __eq__(self, other: object) -> bool:
        """Whether both have the same content, names and places of faces included."""
        return self._core.to_bytes() == other._core.to_bytes() if isinstance(other, Scene) else NotImplemented

    def __hash__(self) -> int:
        return hash(self.digest)

    def _said(self) -> "list[tuple[str, Any]]":
        surfaces = list(dict.fromkeys(self.names))
        named = ", ".join(surfaces[:6]) + (f" and {len(surfaces) - 6} more" if len(surfaces) > 6 else "")
        said = [("faces", len(self)), ("surfaces", named), ("channels", ", ".join(self.channels)), ("area", f"{self.areas.sum():.6g}")]
        return said + ([("notes", len(self.notes))] if self.notes else [])

    def __repr__(self) -> str:
        return f"<radgrad.Scene: {'; '.join(f'{name} {value}' for name, value in self._said())}>"

    def _repr_html_(self) -> str:
        return table("Scene", self._said())

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
        return self._of(self._core.capped(_number(most, "most", "at least 0 and below 1")), self._kept)

    def replaced(self, reflectance: Optional[ArrayLike] = None, emission: Optional[ArrayLike] = None) -> "Scene":
        """The same faces with other values: factors that were computed of either are those of both, and are not computed again.

        Parameters
        ----------
        reflectance, emission : float, (faces,) or (faces, channels), optional
            As of `Scene`; textures give way to them. What is not given stays.
        """
        values: "list[Optional[Floats]]" = []
        for given, what in ((reflectance, "reflectance"), (emission, "emission")):
            values.append(None if given is None else _per_face(_numbers(given, what), what, len(self), len(self.channels)))
        return self._of(self._core.replaced(*values), self._kept)

    def to_pyvista(self) -> Any:
        """As `pyvista.PolyData`: cells have `surface`, `surface_index`, `reflectance` and `emission`."""
        return _mesh.to_pyvista(self)

    def to_meshio(self) -> Any:
        """As `meshio.Mesh`: cells have `surface_index`, `reflectance` and `emission`. Triangles come first, then quads, then others."""
        return _mesh.to_meshio(self)

    def to_trimesh(self) -> Any:
        """As `trimesh.Scene`: a mesh of triangles for each surface, by its name."""
        return _mesh.to_trimesh(self)

    @overload
    def factors(
        self,
        tolerance: Optional[float] = ...,
        relative: Optional[float] = ...,
        most_cells: Optional[int] = ...,
        estimate: Optional[float] = ...,
        most_points: Optional[int] = ...,
        progress: Progress = ...,
        method: Literal["brackets"] = ...,
    ) -> Factors: ...

    @overload
    def factors(
        self,
        tolerance: Optional[float] = ...,
        *,
        progress: Progress = ...,
        method: Literal["rays"],
        confidence: Optional[float] = ...,
        rays: Optional[int] = ...,
        seed: Optional[int] = ...,
        drop_below: Optional[float] = ...,
    ) -> RayFactors: ...

    def factors(
        self,
        tolerance: Optional[float] = None,
        relative: Optional[float] = None,
        most_cells: Optional[int] = None,
        estimate: Optional[float] = None,
        most_points: Optional[int] = None,
        progress: Progress = None,
        method: str = "brackets",
        *,
        confidence: Optional[float] = None,
        rays: Optional[int] = None,
        seed: Optional[int] = None,
        drop_below: Optional[float] = None,
    ) -> Union[Factors, RayFactors]:
        """Form factors between all faces, with occlusion: each in a proven bracket, or by rays.

        Parameters
        ----------
        tolerance : float, default 1e-3
            Bound that is asked of a factor past occluders. In free sight factors are exact to rounding. By rays, by default 0.01, half the width of
            the widest interval.
        relative : float, default 0
            The same over the factor; the larger of the two counts.
        most_cells : int
            Pairs of cells that the bracket of one factor may take.
        estimate : float
            Error down to which an obstructed factor is integrated.
        most_points : int
            Points that this may take.
        progress : bool or callable, optional
            Tell how many rows are done: by a line, or by a call with a `Step`. By default a line after two seconds in a terminal or a
            notebook.
        method : str
            ``"brackets"`` proves bounds. ``"rays"`` takes far less time for very many faces: each factor is in an interval that holds with a stated
            probability, which is no bound.
        confidence : float, default 0.99
            By rays, the probability with which all intervals hold together. The number of rays follows from it and from `tolerance`.
        rays : int
            Rays from each face, in place of that number.
        seed : int, default 1
            Of the rays' random numbers: answers depend on it, and on no division of the work.
        drop_below : float
            By rays, leave out pairs both of whose factors are below this; rows still sum to 1 with what is open, and pairs are reciprocal.

        Returns
        -------
        Factors
            With a `ToleranceWarning` where a bound is above what was asked for. By rays, `RayFactors`.

        Raises
        ------
        ValueError
            If the scene is refused, as where faces overlap.
        """
        of_brackets = {"relative": relative, "most_cells": most_cells, "estimate": estimate, "most_points": most_points}
        of_rays = {"confidence": confidence, "rays": rays, "seed": seed, "drop_below": drop_below}
        others = {"brackets": of_rays, "rays": of_brackets}.get(method)
        if others is None:
            raise ValueError(f"method is {method!r}: it must be 'brackets' or 'rays'")
        for name, value in others.items():
            if value is not None:
                raise ValueError(f"{name} is {value}: it does not go with method={method!r}; leave one of them out")
        if method == "rays":
            return self._by_rays(ray_settings(tolerance, confidence, rays, seed, drop_below), progress)
        settings = settings_of(tolerance, relative, most_cells, estimate, most_points)
        key = tuple(settings.values())
        known = self._kept.get(key)
        if known is None:
            with watching(progress, "factors: rows"):
                found = Factors(self, self._core.factors(settings), settings)
            self._kept[key] = found
        else:
            # Of this scene, or of the same faces with other values.
            found = known if known.scene is self else known._of(self)
        return found._warn()

    def _by_rays(self, settings: "dict[str, Any]", progress: Progress) -> RayFactors:
        with watching(progress, "factors: rows"):
            return RayFactors(self, _radgrad.RayCore(self._core, settings), settings)

    def operator(
        self,
        tolerance: Optional[float] = None,
        confidence: Optional[float] = None,
        rays: Optional[int] = None,
        seed: Optional[int] = None,
        progress: Progress = None,
    ) -> Any:
        """The form factors of very many faces as a `scipy.sparse.linalg.LinearOperator`: `op @ q` is what each face gets of what all send.

        `op.error` times the largest of `abs(q)` limits `abs(F q - op q)` in every face with the probability `confidence`, for a q that was chosen
        without looking at `op`; `op.factors` is a `RayFactors`, which has `certified`, `save` and `load`. Parameters are those of
        `factors(method="rays")`.
        """
        return self._by_rays(ray_settings(tolerance, confidence, rays, seed, None), progress).operator

    def solve(
        self,
        error: float = 0.001,
        degree: Optional[int] = None,
        seconds: Optional[float] = None,
        most_elements: Optional[int] = None,
        divide: str = "residual",
        progress: Union[None, bool, Callable[[Round], None]] = None,
    ) -> Solution:
        """The radiosity everywhere, reflections included. Ctrl-C lets the round end and gives what was reached.

        Parameters
        ----------
        error : float
            Estimate of the error of the mean radiosity over the mean that is reflected, at most.
        degree : int, optional
            Of the polynomials on elements, 0 to 4. If none is given 2; 1 from a thousand faces on, 0 from twenty thousand; 4 where few faces face each
            other at about their width.
        seconds : float, optional
            In which to be done: no round is begun that would probably end later.
        most_elements : int, optional
            Beyond which none is divided any more.
        divide : "residual", "gradient" or "shadows"
            Divide the elements that add most to the error of gathers; those whose polynomials are off most; or the same after
            faces were cut along shadow lines.
        progress : bool or callable
            Print a line after each round, or call with a `Round`. By default lines after two seconds in a terminal or a notebook.

        Returns
        -------
        Solution
            With a `ToleranceWarning` where its estimate is above `error`.

        Raises
        ------
        ValueError
            If an argument is out of range, the scene is refused, or light is emitted in a closed space whose faces reflect all.
        """
        request = {
            "error": _number(error, "error", "above 0 and at most 1"),
            "degree": degree,
            "seconds": seconds,
            "most_elements": most_elements,
            "divide": divide,
        }
        return Solution._made(self, request, watching_rounds(progress))._warn()


def _from_bytes(content: bytes, notes: "list[str]") -> Scene:
    return Scene._of(_radgrad.SceneCore.from_bytes(content, notes))


def _warn_of(scene: Scene) -> None:
    """Says that the reader changed something, once."""
    notes = scene.notes
    if notes:
        more = f" (and {len(notes) - 1} more in scene.notes)" if len(notes) > 1 else ""
        warnings.warn(f"{notes[0]}{more}", ReaderWarning, stacklevel=3)


def _corners(face: Any, index: int) -> "NDArray[np.int64]":
    if isinstance(face, np.ma.MaskedArray):
        raise ValueError(f"faces[{index}] is a masked array: leave out what is masked (faces[{index}].compressed())")
    corners = np.asarray(face)
    if corners.ndim != 1 or corners.dtype.kind not in "iu":
        raise ValueError(f"faces[{index}] is {face!r}: expected indices of vertices, whole numbers of an integer type (faces.astype(int))")
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
