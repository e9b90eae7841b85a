"""What results have in common: equality, a table in a notebook, a frame."""

from __future__ import annotations

import dataclasses
import html
from typing import Any, Tuple

import numpy as np


def table(title: str, rows: "list[tuple[str, Any]]") -> str:
    """A table of names and values as HTML."""
    lines = "".join(f"<tr><th>{html.escape(name)}</th><td>{html.escape(str(value))}</td></tr>" for name, value in rows)
    return f"<table><caption>{html.escape(title)}</caption>{lines}</table>"


def pandas() -> Any:
    """The package that has frames."""
    try:
        import pandas  # type: ignore[import-untyped,unused-ignore]
    except ImportError:
        raise ImportError("frames need pandas: pip install pandas") from None
    return pandas


class Shown:
    """Of a dataclass whose fields are arrays: equal if all bits but those of NaN are."""

    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other):
            return NotImplemented
        return all(_same(a, b) for a, b in zip(self._values(), other._values()))  # type: ignore[attr-defined]

    __hash__ = None  # type: ignore[assignment]

    def _values(self) -> "list[Any]":
        return [getattr(self, field.name) for field in dataclasses.fields(self)]  # type: ignore[arg-type]

    def _shape(self) -> "Tuple[int, ...]":
        """The shape of the points; of fields the first axes."""
        raise NotImplementedError

    def frame(self) -> Any:
        """A pandas frame with a row for each point, in their order; of a field of several numbers a column for each."""
        count, columns = int(np.prod(self._shape())), {}
        for field in dataclasses.fields(self):  # type: ignore[arg-type]
            value = np.asarray(getattr(self, field.name))
            if value.dtype.kind == "O":
                continue
            flat = value.reshape(count, -1)
            for index in range(flat.shape[1]):
                columns[field.name if flat.shape[1] == 1 else f"{field.name}_{index}"] = flat[:, index]
        return pandas().DataFrame(columns)

    def _repr_html_(self) -> str:
        rows = []
        for field, value in zip(dataclasses.fields(self), self._values()):  # type: ignore[arg-type]
            if isinstance(value, np.ndarray) and value.size > 1:
                of = value[np.isfinite(value)] if value.dtype.kind == "f" else value
                span = f", {of.min():.6g} to {of.max():.6g}" if of.size else ""
                rows.append((field.name, f"{value.shape}{span}"))
            else:
                rows.append((field.name, value))
        return table(type(self).__name__, rows)


def _same(a: Any, b: Any) -> bool:
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        a, b = np.asarray(a), np.asarray(b)
        return bool(np.array_equal(a, b, equal_nan=a.dtype.kind == b.dtype.kind == "f"))
    if isinstance(a, list) and isinstance(b, list):
        return len(a) == len(b) and all(_same(*pair) for pair in zip(a, b))
    return bool(a == b)
