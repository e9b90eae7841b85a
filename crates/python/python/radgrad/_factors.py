"""Matrices of form factors."""

from __future__ import annotations

import os
import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Optional, Tuple

import numpy as np
from numpy.typing import NDArray

from . import _radgrad, _store
from ._evaluate import Floats, _number, _numbers, _whole
from ._shown import Shown, pandas, table
from ._store import PathLike

if TYPE_CHECKING:
    from scipy.sparse import csr_array as _csr_array  # type: ignore[import-untyped]

    from ._scene import Scene


class ToleranceWarning(UserWarning):
    """What was asked for was not reached: bounds and estimates say what was."""


class ReaderWarning(UserWarning):
    """A reader changed something, or did not use it: `Scene.notes` says what."""


@dataclass(frozen=True, eq=False)
class Rows(Shown):
    """Sums of the rows of factors, one for each face of the scene; of a face that only hides 0."""

    #: Names of their surfaces.
    names: "list[str]"
    #: (faces,): sums of the factors: the share of its view in which a face has others.
    sum: Floats
    #: (faces,): what the proven brackets leave for it.
    lower: Floats
    #: (faces,)
    upper: Floats
    #: (faces,): 1 less the sum, the share that no face has; below 0 where errors make the row more than 1.
    open: Floats

    def _shape(self) -> "Tuple[int, ...]":
        return (len(self.names),)


def settings_of(
    tolerance: Optional[float],
    relative: Optional[float],
    most_cells: Optional[int],
    estimate: Optional[float],
    most_points: Optional[int],
) -> "dict[str, Any]":
    """Settings that are in range; None takes the default."""
    found: "dict[str, Any]" = {}
    for name, value in (("tolerance", tolerance), ("relative", relative), ("estimate", estimate)):
        number = None if value is None else _number(value, name, "finite and not negative")
        if number is not None and not 0.0 <= number < float("inf"):
            raise ValueError(f"{name} is {value}: it must be finite and not negative; 0 asks for as much as the effort gives")
        found[name] = number
    for name, count in (("most_cells", most_cells), ("most_points", most_points)):
        if count is not None and not 0 <= int(count) == count < 2**63:
            raise ValueError(f"{name} is {count}: it must be a whole number that is not negative")
        found[name] = None if count is None else int(count)
    return found


class Factors:
    """Form factors between the faces of a scene: sparse matrices of shape (faces, faces), `F[i, j]` from face i to face j.

    Those of pairs that see nothing of each other are not stored, and are exactly 0. `F @ q` is what each face gets of what all send;
    `values`, `lower` and `upper` are scipy's sparse matrices, `np.asarray(F)` is dense.
    """

    def __init__(self, scene: "Scene", core: Any, settings: "dict[str, Any]", moved: "Tuple[float, float]" = (0.0, 0.0)) -> None:
        self._scene, self._core, self._settings, self._moved = scene, core, settings, (float(moved[0]), float(moved[1]))
        self.indptr, self.indices, self.data = core.csr()
        self._brackets: Any = None
        for array in (self.indptr, self.indices, self.data):
            array.flags.writeable = False

    def _of(self, scene: "Scene") -> "Factors":
        """The same of a scene with other values on the same faces."""
        return Factors(scene, self._core.of(scene._core), self._settings, self._moved)

    def _bracket(self, index: int) -> Any:
        if self._brackets is None:
            self._brackets = self._core.brackets()
            for array in self._brackets:
                array.flags.writeable = False
        return self._brackets[index]

    @property
    def occluders(self) -> "NDArray[Any]":
        """In the order of `data`: how many polygons may be in between."""
        return self._bracket(2)

    def _matrix(self, data: Any) -> "_csr_array":
        try:
            from scipy.sparse import csr_array
        except ImportError:
            raise ImportError("sparse matrices need scipy: pip install radgrad[sparse], or take indptr, indices and data") from None
        return csr_array((data.copy(), self.indices.copy(), self.indptr.copy()), shape=self.shape)

    @property
    def shape(self) -> "Tuple[int, int]":
        """(faces, faces)."""
        return len(self._scene), len(self._scene)

    @property
    def scene(self) -> "Scene":
        """The scene."""
        return self._scene

    @property
    def values(self) -> "_csr_array":
        """The factors, in their brackets."""
        return self._matrix(self.data)

    @property
    def lower(self) -> "_csr_array":
        """Proven lower bounds."""
        return self._matrix(self._bracket(0))

    @property
    def upper(self) -> "_csr_array":
        """Proven upper bounds."""
        return self._matrix(self._bracket(1))

    def __matmul__(self, q: Any) -> Floats:
        """What each face gets: the sums over j of `F[i, j] q[j]`, for (faces,) or (faces, k)."""
        values = _numbers(q, "q")
        if values.ndim not in (1, 2) or values.shape[0] != len(self._scene):
            raise ValueError(f"q has shape {values.shape}: expected ({len(self._scene)},) or ({len(self._scene)}, k), a value a face")
        columns = values.reshape(len(values), -1)
        products = self.data[:, None] * columns[self.indices]
        sums = np.zeros((len(values), columns.shape[1]))
        # Of empty rows `reduceat` takes the next row's first.
        filled = np.flatnonzero(np.diff(self.indptr))
        if filled.size:
            sums[filled] = np.add.reduceat(products, self.indptr[filled], axis=0)
        return sums.reshape(values.shape)

    def __array__(self, dtype: Any = None, copy: Optional[bool] = None) -> Floats:
        if copy is False:
            raise ValueError("a dense matrix of sparse factors is always a copy: leave out copy=False")
        dense = np.zeros(self.shape)
        dense[self._row_of_each(), self.indices] = self.data
        return dense if dtype is None else dense.astype(dtype)

    def _row_of_each(self) -> "NDArray[Any]":
        return np.repeat(np.arange(len(self._scene)), np.diff(self.indptr))

    def __getitem__(self, pair: Any) -> float:
        """The factor from face i to face j."""
        count = len(self._scene)
        if not (isinstance(pair, tuple) and len(pair) == 2 and all(isinstance(face, (int, np.integer)) for face in pair)):
            raise TypeError(f"F[{pair!r}]: expected two faces, F[i, j]; np.asarray(F) and F.values take slices")
        i, j = (int(face) + (count if face < 0 else 0) for face in pair)
        if not (0 <= i < count and 0 <= j < count):
            raise IndexError(f"F[{pair[0]}, {pair[1]}]: the scene has {count} faces, numbered from 0")
        row = self.indices[self.indptr[i] : self.indptr[i + 1]]
        at = int(np.searchsorted(row, j))
        return float(self.data[self.indptr[i] + at]) if at < len(row) and row[at] == j else 0.0

    def __len__(self) -> int:
        """Number of faces."""
        return len(self._scene)

    @property
    def rows(self) -> Rows:
        """Sums of the rows, with what the brackets leave for them and the share that is open, by name."""
        sums, lower, upper = self._core.sums()
        return Rows(self._scene.names, sums, lower, upper, 1.0 - sums)

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
        return Factors(self._scene, core, self._settings, (largest, mean))

    def by_surface(self) -> "tuple[list[str], Floats]":
        """Names of the surfaces and the dense matrix between them: sums over their faces, weighted by area."""
        names, areas = self._scene.names, self._scene.areas
        order = {name: index for index, name in enumerate(dict.fromkeys(names))}
        place, rows = np.array([order[name] for name in names]), self._row_of_each()
        exchanged, whole = np.zeros((len(order), len(order))), np.zeros(len(order))
        np.add.at(whole, place, areas)
        np.add.at(exchanged, (place[rows], place[self.indices]), areas[rows] * self.data)
        return list(order), exchanged / whole[:, None]

    def frame(self) -> Any:
        """The factors between surfaces as a pandas frame, from the row's to the column's."""
        names, dense = self.by_surface()
        return pandas().DataFrame(dense, index=pandas().Index(names, name="from"), columns=pandas().Index(names, name="to"))

    def write(self, file: PathLike, open: bool = False) -> None:
        """Write the factors for other programs, as `radgrad factors --out` does.

        Parameters
        ----------
        file : str or path
            ``.csv`` has a line a factor with its bracket; ``.mtx`` is Matrix Market, by face; ``.txt`` or ``.out`` is View3D's text and
            ``.idf`` EnergyPlus' input, both by surface. Bounds of ``.mtx``, ``.txt`` and ``.out`` go to NAME.bounds with the same ending.
        open : bool
            In a ``.csv`` end the factors of each face with the share of its view that no face has.
        """
        self._core.write(os.fspath(file), bool(open))

    def save(self, file: PathLike) -> None:
        """Keep all of it in a ``.npz``, of which `load` makes it again without computing any factor."""
        about = {"settings": self._settings, "moved": self._moved, "notes": self._scene.notes}
        _store.save(file, "Factors", about, {"scene": self._scene._core.to_bytes(), "pairs": self._pairs()})

    @classmethod
    def load(cls, file: PathLike, budget: int = _store.BUDGET) -> "Factors":
        """What `save` wrote, to the last bit. `budget` bytes may be read.

        A `ValueError` if the file is no such file or is damaged, an `OSError` if it cannot be read.
        """
        from ._scene import _from_bytes

        about, parts = _store.load(file, "Factors", ("scene", "pairs"), budget)
        scene = _from_bytes(parts["scene"], about["notes"])
        return _joined(scene, about["settings"], tuple(about["moved"]), parts["pairs"])

    def _pairs(self) -> bytes:
        return self._core.block().__reduce__()[1][0]

    def __reduce__(self) -> Any:
        return _joined, (self._scene, self._settings, self._moved, self._pairs())

    def __copy__(self) -> "Factors":
        return self

    def __deepcopy__(self, memo: Any) -> "Factors":
        # Nothing of it changes.
        return self

    def tobytes(self) -> bytes:
        """All of it as bytes, to compare."""
        wide = [np.asarray(array, dtype=np.int64) for array in (self.indptr, self.indices, self.occluders)]
        arrays = (wide[0], wide[1], self.data, self._bracket(0), self._bracket(1), wide[2])
        return b"".join(array.tobytes() for array in arrays)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Factors):
            return NotImplemented
        return self._scene == other._scene and self.tobytes() == other.tobytes()

    __hash__ = None  # type: ignore[assignment]

    def _said(self) -> "list[tuple[str, Any]]":
        asked = self._settings["tolerance"]
        return [
            ("faces", len(self)),
            ("factors", self.data.size),
            ("largest bound", f"{self.bound:.3g}" + (f", {self.unmet} above {1e-3 if asked is None else asked:g}" if self.unmet else "")),
            ("closure", f"{self.closure:.3g}"),
        ]

    def __repr__(self) -> str:
        return f"<radgrad.Factors: {', '.join(f'{name} {value}' for name, value in self._said())}>"

    def _repr_html_(self) -> str:
        return table("Form factors", self._said())

    def _warn(self, level: int = 3) -> "Factors":
        """Says so where what was asked for was not met."""
        if self.unmet:
            remedy = "raise most_cells, or ask for less; F.bound is the largest"
            warnings.warn(f"{self.unmet} of {self.data.size} factors have a bound above what was asked for: {remedy}", ToleranceWarning, level)
        return self


def _joined(scene: "Scene", settings: "dict[str, Any]", moved: "Tuple[float, float]", pairs: bytes) -> Factors:
    block = _radgrad.FactorBlock.from_bytes(pairs)
    return Factors(scene, scene._core.join(settings, [block]), settings, moved)


def dense(F: Any) -> Floats:
    """Factors, or a matrix of them, as an array of (n, n)."""
    if hasattr(F, "toarray"):
        F = F.toarray()
    matrix = np.asarray(F) if isinstance(F, Factors) else _numbers(F, "F")
    if matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1]:
        raise ValueError(f"F has shape {matrix.shape}: expected (n, n), the factor from i to j in row i")
    return _whole(matrix)
