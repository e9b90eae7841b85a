"""How far work has come that takes long: told by the extension module twenty times a second, in the thread that asked for the work."""

from __future__ import annotations

import sys
import threading
from contextlib import contextmanager
from typing import Any, Callable, Iterator, NamedTuple, Optional, SupportsIndex, Union

from . import _radgrad

#: Seconds after which work that nobody asked about is told of, where somebody looks; and between two lines.
QUIET, PAUSE = 2.0, 0.5


class Step(NamedTuple):
    """How far a computation has come."""

    #: Rows, points or cases that are done, and all of them; 0 where they are not counted.
    done: int
    all: int
    #: Since it began.
    seconds: float


#: Whether to tell, or whom: None tells after two seconds where somebody looks.
Progress = Union[None, bool, Callable[[Step], None]]

_asked = threading.local()


@contextmanager
def watching(progress: Progress, what: str) -> "Iterator[None]":
    """Within it, work of this thread is told of as `progress` says."""
    if not (progress is None or isinstance(progress, bool) or callable(progress)):
        raise ValueError(f"progress is {progress!r}: it must be True, False, None or a function that takes a radgrad.Step")
    before = getattr(_asked, "of", None)
    _asked.of = (progress, what, [0.0])
    try:
        yield
    finally:
        _asked.of = before


def is_seen() -> bool:
    """Whether somebody looks: a terminal or a notebook."""
    if "IPython" in sys.modules:
        shell = sys.modules["IPython"].get_ipython()
        if shell is not None and hasattr(shell, "kernel"):
            return True
    return bool(sys.stderr and sys.stderr.isatty())


def _told(seconds: float, done: int, all: int, ended: bool) -> None:
    progress, what, last = getattr(_asked, "of", None) or (None, "computing", [0.0])
    if callable(progress):
        progress(Step(done, all, seconds))
        return
    if progress is False or (progress is None and not (seconds >= QUIET and is_seen())):
        return
    if not ended and seconds < last[0] + PAUSE:
        return
    last[0] = seconds
    part = f"{done} of {all}, " if all else f"{done}, " if done else ""
    print(f"\r{what}: {part}{seconds:.0f} s", end="\n" if ended else "", file=sys.stderr, flush=True)


_radgrad.watched_by(_told)


class threads:
    """How many threads computations use that begin from now on; as a context, only within it. For the whole process.

    Parameters
    ----------
    count : int, optional
        At most 1024; 0 for one a core, unless the environment's `RAYON_NUM_THREADS` says otherwise. None only asks.

    Examples
    --------
    >>> import radgrad as rg
    >>> with rg.threads(2) as two:
    ...     two.count
    2
    """

    def __init__(self, count: Optional[int] = None) -> None:
        if count is not None and (isinstance(count, bool) or not isinstance(count, (SupportsIndex, float)) or not (count >= 0 and count % 1 == 0)):
            raise ValueError(f"count is {count!r}: it must be a number of threads, or 0 for one a core")
        self._before = _radgrad.threads()
        #: How many there are.
        self.count: int = self._before if count is None else _radgrad.threads(int(count))

    def __enter__(self) -> "threads":
        return self

    def __exit__(self, *_: Any) -> None:
        _radgrad.threads(self._before)

    def __int__(self) -> int:
        return self.count

    def __index__(self) -> int:
        return self.count

    def __repr__(self) -> str:
        return f"<radgrad: {self.count} threads>"
