"""Someone's code, and ours, held to truth of arbitrary precision on random cases of every kind of difficulty."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from typing import Any, Callable, Iterator, Optional, Sequence, Tuple, Union

import numpy as np

from . import _radgrad, _store
from ._evaluate import Emitter, Floats
from ._progress import Progress, watching
from ._shown import pandas
from ._shown import table as shown_table
from ._store import PathLike

#: What `audit` calls: a case in, radiosity out, or radiosity and gradient.
Function = Callable[["Case"], Union[float, Tuple[float, Any]]]


@dataclass(frozen=True)
class Case:
    """A case of the audit: a receiver, an emitter, and the occluders between them."""

    #: ``family:seed:index``: the same case on every machine.
    name: str
    #: (3,)
    position: Floats
    #: (3,), of any length.
    normal: Floats
    #: In [0, 1].
    reflectance: float
    #: Its `vertices` (n, 3), `normal` (3,), and `emission`: a number, (n,), `Affine` or `Polynomial`.
    emitter: Emitter
    #: Vertices of each polygon in between, (n, 3).
    occluders: "list[Floats]"


class AuditReport:
    """Cases counted and errors distributed, family by family: the same wherever its parts were computed.

    `outcomes`, `errors` and `figures` are tables as lists of dictionaries.
    """

    def __init__(self, table: Any) -> None:
        self._table = table

    def __len__(self) -> int:
        """Number of cases."""
        return len(self._table)

    def csv(self, table: str) -> str:
        """A table as CSV: ``outcomes``, ``errors`` (decades), ``figures`` (two digits) or ``histogram``."""
        return self._table.csv(table)

    def _rows(self, table: str) -> "list[dict[str, str]]":
        return list(csv.DictReader(io.StringIO(self.csv(table))))

    @property
    def outcomes(self) -> "list[dict[str, str]]":
        """What became of the cases of each family: measured, refused, unanswered, not finite, without truth."""
        return self._rows("outcomes")

    @property
    def errors(self) -> "list[dict[str, str]]":
        """Median, 99th percentile and worst error of each family and quantity in decades, and the worst case's name."""
        return self._rows("errors")

    @property
    def figures(self) -> "list[dict[str, str]]":
        """The same to two digits."""
        return self._rows("figures")

    def frame(self, table: str = "figures") -> Any:
        """A table as a pandas frame, numbers as numbers."""
        return pandas().read_csv(io.StringIO(self.csv(table)))

    def save(self, file: PathLike) -> None:
        """Keep all tables in a ``.npz``, of which `load` makes the report again."""
        _store.save(file, "AuditReport", {}, {"tables": self._table.to_json().encode()})

    @classmethod
    def load(cls, file: PathLike, budget: int = _store.BUDGET) -> "AuditReport":
        """What `save` wrote. `budget` bytes may be read.

        A `ValueError` if the file is no such file or is damaged, an `OSError` if it cannot be read.
        """
        return _report(_store.load(file, "AuditReport", ("tables",), budget)[1]["tables"].decode())

    def __reduce__(self) -> Any:
        return _report, (self._table.to_json(),)

    def __eq__(self, other: object) -> bool:
        """Whether all counts, errors and worst cases are the same."""
        return self._table.to_json() == other._table.to_json() if isinstance(other, AuditReport) else NotImplemented

    __hash__ = None  # type: ignore[assignment]

    def __str__(self) -> str:
        return self.csv("figures")

    def __repr__(self) -> str:
        families = list(dict.fromkeys(row["family"] for row in self.outcomes))
        return f"<radgrad.AuditReport: {len(self)} cases of {len(families)} families>"

    def _repr_html_(self) -> str:
        rows = [(f"{row['family']}, {row['quantity']}", row["worst"]) for row in self.figures]
        return shown_table(f"{len(self)} cases: worst relative errors", rows)


def _report(tables: str) -> AuditReport:
    return AuditReport(_radgrad.AuditTable.from_json(tables))


def audit_families() -> "list[str]":
    """Names of the families of cases: each one way of being difficult."""
    return _radgrad.audit_families()


def verify(
    cases: int = 42_000, seed: int = 1, families: Sequence[str] = (), progress: Progress = None
) -> AuditReport:
    """Measure our own answers in random cases, as `cargo xtask verify` does. Ctrl-C ends it.

    Parameters
    ----------
    cases : int
        In all, shared among the families; fewer of dear ones.
    seed : int
        The same seed gives the same cases on every machine.
    families : list of str
        Only these: ``radgrad.audit_families()`` has the names.
    progress : bool or callable, optional
        As of `Scene.factors`, by cases.

    Examples
    --------
    >>> import radgrad as rg
    >>> report = rg.verify(cases=6, families=["contact", "far"])
    >>> [row["measured"] for row in report.outcomes]
    ['3', '3']
    """
    _checked(cases, seed)
    with watching(progress, "verify: cases"):
        return AuditReport(_radgrad.merge_shards([_radgrad.audit_shard(cases, seed, list(families), 0, 1)]))


def _checked(cases: int, seed: int) -> None:
    for name, value, least in (("cases", cases, 1), ("seed", seed, 0)):
        if int(value) != value or not least <= value < 2**63:
            raise ValueError(f"{name} is {value}: it must be a whole number of at least {least}")


def cases(count: int, seed: int = 1, families: Sequence[str] = (), occluders: bool = True) -> "Iterator[Case]":
    """Cases of the audit, so many of each family; those that are to be refused are left out.

    With `occluders=False` only cases with nothing in between.
    """
    for family in families or audit_families():
        for index in range(count):
            found = _radgrad.audit_case(f"{family}:{seed}:{index}")
            if found is None:
                continue
            position, normal, reflectance, emitter, hiding = found
            if hiding and not occluders:
                continue
            whole = Emitter(emitter.vertices, emitter.emission, emitter.precision)
            name = f"{family}:{seed}:{index}"
            yield Case(name, np.array(position), np.array(normal), reflectance, whole, hiding)


def audit(
    function: Function,
    cases: int = 20,
    seed: int = 1,
    families: Sequence[str] = (),
    occluders: bool = True,
    worse: Optional[float] = None,
    watch: Optional[Callable[[Case, str, Optional[float], Optional[float]], None]] = None,
) -> AuditReport:
    """Hold someone else's code to truth: `function` is called with each case, and its answers are measured.

    Parameters
    ----------
    function : callable
        Takes a `Case`; returns the radiosity, or the radiosity and the gradient (3,). An exception counts as unanswered, a NaN
        or an infinite number as not finite.
    cases : int
        Of each family.
    seed, families
        As of `verify`.
    occluders : bool
        Whether cases with polygons in between are asked.
    worse : float, optional
        Print the name of each case whose relative error is above this.
    watch : callable, optional
        Called after each case with it, what became of it, and the relative errors of value and gradient.

    Returns
    -------
    AuditReport
        Errors relative to the exact result for the doubles as given.

    Examples
    --------
    >>> import radgrad as rg
    >>> ours = lambda case: float(rg.evaluate(case.position, case.normal, case.emitter, case.occluders, case.reflectance).radiosity)
    >>> report = rg.audit(ours, cases=2, families=["generic", "contact"])
    >>> all(float(row["worst"]) < 1e-12 for row in report.figures)
    True
    """
    _checked(cases, seed)
    if not callable(function):
        raise TypeError(f"function is {type(function).__name__}: expected a function of a Case")
    table = _radgrad.AuditTable()
    for case in _asked(cases, seed, families, occluders):
        try:
            answer = function(case)
            radiosity, gradient = answer if isinstance(answer, tuple) else (answer, None)
            value = float(radiosity)
            slope = None if gradient is None else [float(component) for component in gradient]
        except Exception:
            table.unanswered(case.name)
            outcome: Tuple[str, Optional[float], Optional[float]] = ("unanswered", None, None)
        else:
            outcome = table.record(case.name, value, slope)
        if worse is not None and any(error is not None and not error <= worse for error in outcome[1:]):
            print(f"{case.name}: {outcome[0]}, relative errors {outcome[1]} (value), {outcome[2]} (gradient)")
        if watch is not None:
            watch(case, *outcome)
    return AuditReport(table)


_asked = cases
