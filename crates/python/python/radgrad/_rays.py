"""Factors of very many faces by rays, and their products."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Optional, Tuple

import numpy as np
from numpy.typing import NDArray

from . import _radgrad, _store
from ._evaluate import Floats, _numbers
from ._shown import table
from ._store import PathLike

if TYPE_CHECKING:
    from ._scene import Scene


def ray_settings(
    tolerance: Optional[float],
    confidence: Optional[float],
    rays: Optional[int],
    seed: Optional[int],
    drop_below: Optional[float],
) -> "dict[str, Any]":
    """Settings that are in range; None takes the default."""
    found: "dict[str, Any]" = {}
    for name, value in (("tolerance", tolerance), ("confidence", confidence), ("drop_below", drop_below)):
        if value is not None and not 0.0 < float(value) < 1.0:
            raise ValueError(f"{name} is {value}: it must be above 0 and below 1")
        found[name] = None if value is None else float(value)
    for name, count, least, end in (("rays", rays, 1, 2**30), ("seed", seed, 0, 2**64)):
        if count is not None and not least <= int(count) == count < end:
            raise ValueError(f"{name} is {count}: it must be a whole number from {least} to {end - 1}")
        found[name] = None if count is None else int(count)
    return found


class _Products:
    """Products with the factors of a scene's faces."""

    def __init__(self, scene: "Scene", core: Any) -> None:
        self._scene, self._core = scene, core

    @property
    def scene(self) -> "Scene":
        """The scene."""
        return self._scene

    @property
    def shape(self) -> "Tuple[int, int]":
        """(faces, faces)."""
        return len(self._scene), len(self._scene)

    def __matmul__(self, q: Any) -> Floats:
        """What each face gets: the sums over j of `F[i, j] q[j]`, for (faces,) or (faces, k)."""
        values = _numbers(q, "q")
        count = len(self._scene)
        if values.ndim not in (1, 2) or values.shape[0] != count:
            raise ValueError(f"q has shape {values.shape}: expected ({count},) or ({count}, k), a value a face")
        columns = 1 if values.ndim == 1 else values.shape[1]
        return self._core.apply(np.ascontiguousarray(values).reshape(-1), columns).reshape(values.shape)

    def certified(self, q: Any) -> "Tuple[Floats, Floats]":
        """`F @ q` for (faces,), and the error of each of its numbers, which all hold together with the confidence if q was chosen without looking at
        the factors."""
        values = _numbers(q, "q")
        if values.shape != (len(self._scene),):
            raise ValueError(f"q has shape {values.shape}: expected ({len(self._scene)},), a value a face")
        return self._core.certified(values)

    def _operator(self) -> Any:
        try:
            from scipy.sparse.linalg import LinearOperator  # type: ignore[import-untyped]
        except ImportError:
            raise ImportError("a linear operator needs scipy: pip install radgrad[sparse]") from None
        areas = np.asarray(self._scene.areas)
        found = LinearOperator(
            self.shape,
            matvec=lambda q: self @ np.asarray(q, dtype=float).reshape(-1),
            # A_i F_ij = A_j F_ji
            rmatvec=lambda q: areas * (self @ (np.asarray(q, dtype=float).reshape(-1) / areas)),
            matmat=lambda q: self @ np.asarray(q, dtype=float),
            dtype=np.float64,
        )
        found.factors = self
        return found

    def __len__(self) -> int:
        """Number of faces."""
        return len(self._scene)


class RayFactors(_Products):
    """Form factors by rays: `F[i, j]` from face i to face j, each in an interval that holds with a stated probability, which is no bound.

    Factors are reciprocal, and rows sum to 1 with `open`. Pairs that no ray joined are not stored, and are at most `absent`. `F @ q` is what each face
    gets of what all send; it needs no matrix, and `operator` is the same for scipy's solvers.
    """

    def __init__(self, scene: "Scene", core: Any, settings: "dict[str, Any]") -> None:
        super().__init__(scene, core)
        self._settings = settings
        self._csr: Any = None
        self._ends: Any = None

    @property
    def rays(self) -> int:
        """Rays from each face."""
        return self._core.rays

    @property
    def confidence(self) -> float:
        """The probability with which all intervals hold together."""
        return self._core.confidence

    @property
    def absent(self) -> float:
        """What a factor that is not stored is at most, with that confidence: of a pair the larger one."""
        return self._core.absent

    @property
    def open(self) -> Floats:
        """(faces,): the share of each face's view that no face has, 1 less the sum of its row."""
        return self._core.opened()

    def _matrix(self, data: Any) -> Any:
        try:
            from scipy.sparse import csr_array  # type: ignore[import-untyped]
        except ImportError:
            raise ImportError("sparse matrices need scipy: pip install radgrad[sparse]") from None
        if self._csr is None:
            self._csr = self._core.csr()
        offsets, columns, factors = self._csr
        return csr_array((factors if data is None else data, columns, offsets), shape=self.shape, copy=True)

    def _interval(self, index: int) -> Any:
        if self._ends is None:
            self._ends = self._core.intervals()
        return self._matrix(self._ends[index])

    @property
    def values(self) -> Any:
        """The factors, as a sparse matrix of scipy."""
        return self._matrix(None)

    @property
    def lower(self) -> Any:
        """Lower ends of the intervals."""
        return self._interval(0)

    @property
    def upper(self) -> Any:
        """Upper ends of the intervals."""
        return self._interval(1)

    @property
    def exact(self) -> "NDArray[np.bool_]":
        """In the order of `values.data`: whether a factor is of no ray, but of a near pair in closed form, and its interval a bound."""
        if self._ends is None:
            self._ends = self._core.intervals()
        return self._ends[2]

    @property
    def error(self) -> float:
        """A product errs by at most this times the largest of `abs(q)`, likewise; `certified` has narrower errors."""
        return self._core.error

    @property
    def operator(self) -> Any:
        """The factors as a `scipy.sparse.linalg.LinearOperator`, with `error` and `factors`."""
        found = self._operator()
        found.error = self.error
        return found

    def blocks(self, tolerance: float = 0.002) -> "BlockFactors":
        """The products with far blocks in fewer numbers: of very many faces far less memory and time.

        `tolerance` is the share of what two far parts of the scene exchange that may be elsewhere in them.
        """
        core = _radgrad.BlockCore(self._scene._core, self._core, float(tolerance))
        return BlockFactors(self._scene, core)

    def save(self, file: PathLike) -> None:
        """Keep all of it in a ``.npz``, of which `load` makes it again without any ray."""
        about = {"settings": self._settings, "notes": self._scene.notes}
        _store.save(file, "RayFactors", about, {"scene": self._scene._core.to_bytes(), "rays": self._core.to_bytes()})

    @classmethod
    def load(cls, file: PathLike, budget: int = _store.BUDGET) -> "RayFactors":
        """What `save` wrote, to the last bit. `budget` bytes may be read.

        A `ValueError` if the file is no such file or is damaged, an `OSError` if it cannot be read.
        """
        from ._scene import _from_bytes

        about, parts = _store.load(file, "RayFactors", ("scene", "rays"), budget)
        return _of_bytes(_from_bytes(parts["scene"], about["notes"]), about["settings"], parts["rays"])

    def __reduce__(self) -> Any:
        return _of_bytes, (self._scene, self._settings, self._core.to_bytes())

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, RayFactors):
            return NotImplemented
        return self._scene == other._scene and self._core.to_bytes() == other._core.to_bytes()

    __hash__ = None  # type: ignore[assignment]

    def _said(self) -> "list[tuple[str, Any]]":
        return [
            ("faces", len(self)),
            ("factors", self._core.stored),
            ("rays a face", self.rays),
            ("confidence", self.confidence),
        ]

    def __repr__(self) -> str:
        return f"<radgrad.RayFactors: {', '.join(f'{name} {value}' for name, value in self._said())}>"

    def _repr_html_(self) -> str:
        return table("Form factors by rays", self._said())


class BlockFactors(_Products):
    """Products with factors by rays whose far blocks have fewer numbers: `B @ q` is nearly `F @ q`, and `operator` is the same for scipy's solvers.

    Rows have the sums that they had, and pairs are reciprocal. The factors themselves are not kept.
    """

    @property
    def operator(self) -> Any:
        """The products as a `scipy.sparse.linalg.LinearOperator`, with `factors`, which has `certified`."""
        return self._operator()

    @property
    def bytes(self) -> int:
        """Memory that the blocks take."""
        return self._core.size

    def save(self, file: PathLike) -> None:
        """Keep all of it in a ``.npz``, of which `load` makes it again."""
        parts = {"scene": self._scene._core.to_bytes(), "blocks": self._core.to_bytes()}
        _store.save(file, "BlockFactors", {"notes": self._scene.notes}, parts)

    @classmethod
    def load(cls, file: PathLike, budget: int = _store.BUDGET) -> "BlockFactors":
        """What `save` wrote, to the last bit. `budget` bytes may be read.

        A `ValueError` if the file is no such file or is damaged, an `OSError` if it cannot be read.
        """
        from ._scene import _from_bytes

        about, parts = _store.load(file, "BlockFactors", ("scene", "blocks"), budget)
        return _blocks_of_bytes(_from_bytes(parts["scene"], about["notes"]), parts["blocks"])

    def __reduce__(self) -> Any:
        return _blocks_of_bytes, (self._scene, self._core.to_bytes())

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, BlockFactors):
            return NotImplemented
        return self._scene == other._scene and self._core.to_bytes() == other._core.to_bytes()

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"<radgrad.BlockFactors: faces {len(self)}, bytes {self.bytes}>"


def _blocks_of_bytes(scene: "Scene", blocks: bytes) -> BlockFactors:
    core = _radgrad.BlockCore.from_bytes(blocks)
    if len(core) != len(scene):
        raise ValueError(f"products of {len(core)} faces: the scene has {len(scene)}")
    return BlockFactors(scene, core)


def _of_bytes(scene: "Scene", settings: "dict[str, Any]", rays: bytes) -> RayFactors:
    core = _radgrad.RayCore.from_bytes(rays)
    found = RayFactors(scene, core, settings)
    if len(core.opened()) != len(scene):
        raise ValueError(f"factors of {len(core.opened())} faces: the scene has {len(scene)}")
    return found
