"""Heat that grey diffuse bodies exchange by radiation: known temperatures and known net heats side by side."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Optional, Tuple

import numpy as np

from ._evaluate import Floats, _number, _numbers
from ._factors import Factors, dense
from ._shown import Shown

#: Of Stefan and Boltzmann, W/m2K4 (CODATA 2018, exact to the digits that are given).
STEFAN_BOLTZMANN = 5.670374419e-8

#: How far a row may be from a sum of 1 where nothing is said of what is around.
CLOSED = 1e-6


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
        Form factors, from i to j in row i.
    emittance : float, (n,) or a dict of surfaces
        In [0, 1].
    T : (n,) or a dict of surfaces
        Temperatures in K where they are known, None or NaN elsewhere.
    q : (n,) or a dict of surfaces
        Net heats in W/m2 where they are known, None or NaN elsewhere: what is fed in, and leaves by radiation; 0 where a body is adiabatic.
        Each body has one of the two. Of a dict, surfaces that are not named are not known.
    surroundings : float, optional
        Temperature in K of the black surroundings that open rows see. Without it every row must sum to 1 within 1e-6.

    Returns
    -------
    Heat
        All `T` and `q`, `radiosity` and `irradiance`.

    Raises
    ------
    ValueError
        If a shape does not fit, a body has both or none of the two, a row is open and nothing is said of what is around, no temperature is
        known, or a body would have to be below absolute zero.

    Examples
    --------
    A prism of sides 3, 4 and 5, long; the first side is at 300 K, the others are fed 500 and 250 W/m2.

    >>> import radgrad as rg
    >>> F = [[0, 1/3, 2/3], [1/4, 0, 3/4], [2/5, 3/5, 0]]
    >>> rg.heat(F, [0.8, 0.4, 0.6], T=[300, None, None], q=[None, 500, 250]).T.round(2).tolist()
    [300.0, 468.43, 427.66]
    """

    def __call__(self, F: Any, emittance: Any, T: Any = None, q: Any = None, surroundings: Optional[float] = None) -> Heat:
        matrix, names = dense(F), F.scene.names if isinstance(F, Factors) else None
        count = len(matrix)
        shares = _shares(emittance, count, names)
        T_known, q_known = _known(T, "T", count, names), _known(q, "q", count, names)
        is_hot = ~np.isnan(T_known)
        for rule, wrong in (
            ("has both a T and a q: give one of the two", is_hot & ~np.isnan(q_known)),
            ("has neither a T nor a q: give one of the two; q is 0 where it is adiabatic", ~is_hot & np.isnan(q_known)),
            ("has a T that is negative or infinite: temperatures are in K", is_hot & ~((T_known >= 0) & (T_known < np.inf))),
            ("has an infinite q", np.isinf(q_known)),
            ("has an emittance of 0 and a q that is not: a perfect mirror neither gives nor takes heat", ~is_hot & (shares == 0) & (q_known != 0)),
        ):
            if wrong.any():
                raise ValueError(f"{_body(int(np.flatnonzero(wrong)[0]), names)} {rule}")
        around, is_open = _around(matrix, surroundings, names)
        if not (is_hot & (shares > 0)).any() and not is_open:
            raise ValueError("no temperature is known, and any level would do: give T of a body whose emittance is above 0")
        # Of a body of known temperature `B = e s T^4 + (1 - e) G`, of one of known heat `B = q + G`, with `G = F B` and what is around.
        reflected = np.where(is_hot, 1.0 - shares, 1.0)
        given = np.where(is_hot, shares * STEFAN_BOLTZMANN * np.where(is_hot, T_known, 0.0) ** 4, np.where(is_hot, 0.0, q_known))
        try:
            radiosity = np.linalg.solve(np.eye(count) - reflected[:, None] * matrix, given + reflected * around)
        except np.linalg.LinAlgError:
            raise ValueError("the balance has no answer: some bodies see none whose temperature is known; give T of one of them") from None
        irradiance = matrix @ radiosity + around
        net = np.where(is_hot, radiosity - irradiance, q_known)
        held = np.divide(1.0 - shares, shares, out=np.zeros(count), where=shares > 0)
        power = radiosity + held * net
        if not (power[~is_hot] >= -1e-12 * np.abs(radiosity).max()).all():
            at = int(np.flatnonzero(~is_hot & ~(power >= 0))[0])
            raise ValueError(f"{_body(at, names)} would have to be below absolute zero: more heat is taken from it than reaches it")
        found = (np.maximum(power, 0.0) / STEFAN_BOLTZMANN) ** 0.25
        return Heat(np.where(is_hot, T_known, found), net, radiosity, irradiance)

    def jacobian(self, F: Any, emittance: Any, T: Any, surroundings: Optional[float] = None) -> Floats:
        """(n, n): derivatives of the net heats by the temperatures, W/m2K, where all temperatures are known: for `scipy.integrate.solve_ivp`.

        With heat capacities C in J/m2K, `C dT/dt = fed - heat(F, e, T).q`, and its Jacobian is `-heat.jacobian(F, e, T) / C[:, None]`.

        >>> import numpy as np, radgrad as rg
        >>> J = rg.heat.jacobian([[0, 1], [1, 0]], 0.5, [300.0, 400.0])
        >>> (J @ [300, 400] / 4).round(6).tolist() == rg.heat([[0, 1], [1, 0]], 0.5, T=[300, 400]).q.round(6).tolist()
        True
        """
        matrix, names = dense(F), F.scene.names if isinstance(F, Factors) else None
        shares, hot = _shares(emittance, len(matrix), names), _known(T, "T", len(matrix), names)
        if not (hot >= 0).all() or np.isinf(hot).any():
            raise ValueError("T must be known of every body here, in K: finite and not negative")
        _around(matrix, surroundings, names)
        one = np.eye(len(matrix))
        inside = np.linalg.solve(one - (1.0 - shares)[:, None] * matrix, np.diag(4.0 * shares * STEFAN_BOLTZMANN * hot**3))
        return (one - matrix) @ inside


def _body(index: int, names: "Optional[list[str]]") -> str:
    return f"body {index}" if names is None else f"face {index} of {names[index]!r}"


def _by_name(values: "dict[Any, Any]", what: str, names: "Optional[list[str]]") -> "list[Any]":
    if names is None:
        raise ValueError(f"{what} is a dict of surfaces, and F a matrix without names: give a number for each body")
    unknown = set(values) - set(names)
    if unknown:
        raise ValueError(f"{what} names {sorted(map(str, unknown))}: the scene's surfaces are {list(dict.fromkeys(names))}")
    return [values.get(name) for name in names]


def _shares(emittance: Any, count: int, names: "Optional[list[str]]") -> Floats:
    given = _by_name(emittance, "emittance", names) if isinstance(emittance, dict) else emittance
    values = _numbers(given, "emittance")
    if values.shape not in ((), (count,)):
        raise ValueError(f"emittance has shape {values.shape}: expected a number or ({count},)")
    shares = np.broadcast_to(values, (count,))
    wrong = np.flatnonzero(~((shares >= 0) & (shares <= 1)))
    if wrong.size:
        raise ValueError(f"the emittance of {_body(int(wrong[0]), names)} is {shares[wrong[0]]}: it must be between 0 and 1")
    return shares


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
    return np.broadcast_to(numbers, (count,))


def _around(matrix: Floats, surroundings: Optional[float], names: "Optional[list[str]]") -> "Tuple[Floats, bool]":
    """What comes in from around, W/m2, and whether anything is open."""
    if not (np.isfinite(matrix).all() and (matrix >= 0).all()):
        raise ValueError("F has a factor that is negative or no finite number")
    free = 1.0 - matrix.sum(axis=1)
    if (free < -CLOSED).any():
        at = int(np.argmin(free))
        raise ValueError(f"the row of {_body(at, names)} sums to {1.0 - free[at]:.9g}, above 1: faces overlap, or take F.repaired()")
    if surroundings is None:
        if (free > CLOSED).any():
            at = int(np.argmax(free))
            remedy = "give surroundings=, the temperature in K of what is around, or in a closed scene take F.repaired()"
            raise ValueError(f"the row of {_body(at, names)} sums to {1.0 - free[at]:.9g}, below 1: {remedy}")
        return np.zeros(len(matrix)), False
    level = _number(surroundings, "surroundings", "a temperature in K")
    if not 0 <= level < np.inf:
        raise ValueError(f"surroundings is {surroundings}: it must be a temperature in K, finite and not negative")
    return np.maximum(free, 0.0) * STEFAN_BOLTZMANN * level**4, bool((free > CLOSED).any())


heat = _Heat()
