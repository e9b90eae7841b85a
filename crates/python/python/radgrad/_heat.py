"""Heat that grey diffuse bodies exchange by radiation: known temperatures and known net heats side by side."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Optional, Tuple

import numpy as np

from . import _radgrad
from ._evaluate import Floats, _number, _numbers, _whole
from ._factors import Factors, dense
from ._shown import Shown

@dataclass(frozen=True, eq=False)
class Heat(Shown):
    """Temperatures and net heats of grey bodies in balance."""

    #: (n,): temperatures, K.
    T: Floats
    #: (n,): net heats, W/m2: what a body loses by radiation, and so what it has to be given to stay as it is.
    q: Floats
    #: (n,): radiosities, W/m2: what leaves, emitted and reflected.
    radiosity: Floats
    #: (n,): irradiances, W/m2: what arrives.
    irradiance: Floats

    def _shape(self) -> "Tuple[int, ...]":
        return np.shape(self.T)


class _Heat:
    """Steady temperatures and net heats of grey diffuse bodies that exchange heat by radiation.

    Parameters
    ----------
    F : Factors, or (n, n)
        Form factors, from i to j in row i. Of a matrix the areas are those with which it is reciprocal.
    emittance : float, (n,) or a dict of surfaces
        In [0, 1].
    T : (n,) or a dict of surfaces
        Temperatures in K where they are known, None or NaN elsewhere.
    q : (n,) or a dict of surfaces
        Net heats in W/m2 where they are known, None or NaN elsewhere: what is fed in, and leaves by radiation; 0 where a body is adiabatic.
        Each body has one of the two. Of a dict, surfaces that are not named are not known.
    surroundings : float, optional
        Temperature in K of the black surroundings that open rows see. Without it every row must sum to 1 within 0.01,
        and what it lacks counts for nothing.

    Returns
    -------
    Heat
        All `T` and `q`, `radiosity` and `irradiance`.

    Raises
    ------
    ValueError
        If a shape does not fit, a body has both or none of the two, no areas make the matrix reciprocal to 0.01, a row is open and nothing is
        said of what is around, no temperature is known, or a body would have to be below absolute zero.

    Examples
    --------
    A prism of sides 3, 4 and 5, long; the first side is at 300 K, the others are fed 500 and 250 W/m2.

    >>> import radgrad as rg
    >>> F = [[0, 1/3, 2/3], [1/4, 0, 3/4], [2/5, 3/5, 0]]
    >>> rg.heat(F, [0.8, 0.4, 0.6], T=[300, None, None], q=[None, 500, 250]).T.round(2).tolist()
    [300.0, 468.43, 427.66]
    """

    def __call__(self, F: Any, emittance: Any, T: Any = None, q: Any = None, surroundings: Optional[float] = None) -> Heat:
        bodies, count, names = _bodies(F, emittance)
        T_known, q_known = _known(T, "T", count, names), _known(q, "q", count, names)
        is_hot = ~np.isnan(T_known)
        for rule, wrong in (
            ("has both a T and a q: give one of the two", is_hot & ~np.isnan(q_known)),
            ("has neither a T nor a q: give one of the two; q is 0 where it is adiabatic", ~is_hot & np.isnan(q_known)),
        ):
            if wrong.any():
                raise ValueError(f"{_body(int(np.flatnonzero(wrong)[0]), names)} {rule}")
        return Heat(*_radgrad.heat(bodies, T_known, q_known, _around(surroundings)))

    def jacobian(self, F: Any, emittance: Any, T: Any, surroundings: Optional[float] = None) -> Floats:
        """(n, n): derivatives of the net heats by the temperatures, W/m2K, where all temperatures are known: for `scipy.integrate.solve_ivp`.

        With heat capacities C in J/m2K, `C dT/dt = fed - heat(F, e, T).q`, and its Jacobian is `-heat.jacobian(F, e, T) / C[:, None]`.

        >>> import numpy as np, radgrad as rg
        >>> J = rg.heat.jacobian([[0, 1], [1, 0]], 0.5, [300.0, 400.0])
        >>> (J @ [300, 400] / 4).round(6).tolist() == rg.heat([[0, 1], [1, 0]], 0.5, T=[300, 400]).q.round(6).tolist()
        True
        """
        bodies, count, names = _bodies(F, emittance)
        kelvins = _known(T, "T", count, names)
        if np.isnan(kelvins).any():
            raise ValueError(f"T must be known of every body here: that of {_body(int(np.isnan(kelvins).argmax()), names)} is not")
        return _radgrad.heat_jacobian(bodies, kelvins, _around(surroundings)).reshape(count, count)


def _bodies(F: Any, emittance: Any) -> "Tuple[dict[str, Any], int, Optional[list[str]]]":
    """What is radiated between, how many bodies there are, and their names."""
    if isinstance(F, Factors):
        offsets, columns, factors, areas, names = F.indptr, F.indices, F.data, F.scene.areas, F.scene.names
    else:
        matrix = dense(F)
        rows, columns = np.nonzero(matrix)
        offsets, factors, areas, names = np.searchsorted(rows, np.arange(len(matrix) + 1)), matrix[rows, columns], None, None
    count = len(offsets) - 1
    if isinstance(emittance, dict):
        emittance = _by_name(emittance, "emittance", names)
    shares = _numbers(emittance, "emittance")
    if shares.shape not in ((), (count,)):
        raise ValueError(f"emittance has shape {shares.shape}: expected a number or ({count},)")
    bodies = {
        "offsets": offsets.astype(np.int64),
        "columns": columns.astype(np.int64),
        "factors": factors,
        "areas": areas,
        "emittances": _whole(np.broadcast_to(shares, (count,))),
        "names": names,
    }
    return bodies, count, names


def _body(index: int, names: "Optional[list[str]]") -> str:
    return f"body {index}" if names is None else f"face {index} of {names[index]!r}"


def _by_name(values: "dict[Any, Any]", what: str, names: "Optional[list[str]]") -> "list[Any]":
    if names is None:
        raise ValueError(f"{what} is a dict of surfaces, and F a matrix without names: give a number for each body")
    unknown = set(values) - set(names)
    if unknown:
        raise ValueError(f"{what} names {sorted(map(str, unknown))}: the scene's surfaces are {list(dict.fromkeys(names))}")
    return [values.get(name) for name in names]


def _known(values: Any, what: str, count: int, names: "Optional[list[str]]") -> Floats:
    """Numbers, NaN where they are not known."""
    if values is None:
        return np.full(count, np.nan)
    if isinstance(values, dict):
        values = _by_name(values, what, names)
    if isinstance(values, (list, tuple)):
        values = [np.nan if value is None else value for value in values]
    numbers = _numbers(values, what)
    if numbers.shape not in ((), (count,)):
        raise ValueError(f"{what} has shape {numbers.shape}: expected ({count},), None or NaN where it is not known")
    return _whole(np.broadcast_to(numbers, (count,)))


def _around(surroundings: Optional[float]) -> Optional[float]:
    return None if surroundings is None else _number(surroundings, "surroundings", "a temperature in K")


heat = _Heat()
