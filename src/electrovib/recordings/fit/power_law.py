"""The exponent of a power law, such as that of force over voltage, with a scatter between sessions."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

    from electrovib.core.arrays import Real

_FEWEST: Final = 3
LEVEL: Final = 0.95


@dataclass(frozen=True, kw_only=True)
class PowerLawFit:
    """A power law y = c_s x^(n + d_s) whose factor and exponent differ between sessions s.

    Parameters
    ----------
    exponent : float
        n, the mean over sessions, dimensionless.
    standard_error : float
        Of the exponent; NaN where it cannot be given.
    lower, upper : float
        95 % interval of the exponent by Student's t; NaN where it cannot be given.
    degrees_of_freedom : int
        Of Student's t.
    within : float
        Standard deviation of the exponent of one session by the scatter of its own points, root mean square over sessions.
    between : float
        Standard deviation of the exponent between sessions beyond that; NaN with one session.
    exponents, factors : dict of str to float
        Of each session: exponent, dimensionless, and y at x = 1, in the unit of y.
    scatter : float
        Standard deviation of ln y about the law of each session.
    sentence : str
        Which scatter limits the exponent, or why there is no interval.
    """

    exponent: float
    standard_error: float
    lower: float
    upper: float
    degrees_of_freedom: int
    within: float
    between: float
    exponents: dict[str, float]
    factors: dict[str, float]
    scatter: float
    sentence: str


def fit_power_law(x: ArrayLike, y: ArrayLike, *, session: Sequence[str] | None = None) -> PowerLawFit:
    """Fit a power law to measured points of one or several sessions.

    Parameters
    ----------
    x : array_like, shape (n,)
        For instance the voltage [V], above 0.
    y : array_like, shape (n,)
        For instance the force [N], above 0.
    session : sequence of str, optional
        Session of each point: a day, a finger or a mounting. By default all points are of one.

    Returns
    -------
    law : PowerLawFit
        Exponent with its interval, and both scatters.

    Raises
    ------
    InputError
        If numbers are not positive, or a session has fewer than three points or only one value of x.

    Notes
    -----
    A straight line through the logarithms of each session, with a common scatter of ln y. With several sessions the interval
    stands on the scatter of their exponents, with one degree of freedom less than sessions: the points of one session share
    its mounting and are not independent. With one session it stands on the scatter of the points alone and holds for that
    session only.
    """
    voltage, force = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    groups = _groups(voltage, force, session)
    lines = {name: _line(np.log(voltage[rows]), np.log(force[rows])) for name, rows in groups.items()}
    free = voltage.size - 2 * len(lines)
    variance = sum(each.squares for each in lines.values()) / free
    slopes = np.array([each.slope for each in lines.values()])
    within = math.sqrt(variance * float(np.mean([1 / each.spread for each in lines.values()])))
    mean = float(np.mean(slopes))
    if len(lines) > 1:
        scatter = float(np.var(slopes, ddof=1))
        error, freedom = math.sqrt(scatter / slopes.size), slopes.size - 1
        between = math.sqrt(max(scatter - within**2, 0.0))
    else:
        error, freedom, between = within, free, math.nan
    from scipy.stats import t

    half = float(t.ppf(0.5 + LEVEL / 2, freedom)) * error
    return PowerLawFit(
        exponent=mean,
        standard_error=error,
        lower=mean - half,
        upper=mean + half,
        degrees_of_freedom=freedom,
        within=within,
        between=between,
        exponents={name: each.slope for name, each in lines.items()},
        factors={name: math.exp(each.level) for name, each in lines.items()},
        scatter=math.sqrt(variance),
        sentence=_sentence(within, between),
    )


@dataclass(frozen=True)
class _Line:
    slope: float
    level: float
    squares: float
    spread: float


def _line(x: Real, y: Real) -> _Line:
    """Straight line through points by least squares, with the spread of x about its mean."""
    centred = x - x.mean()
    spread = float(centred @ centred)
    slope = float(centred @ y) / spread
    left = y - y.mean() - slope * centred
    return _Line(slope, float(y.mean() - slope * x.mean()), float(left @ left), spread)


def _groups(x: Real, y: Real, session: Sequence[str] | None) -> dict[str, NDArray[np.intp]]:
    if x.ndim != 1 or x.shape != y.shape:
        raise InputError("x, y: expected two rows of the same length")
    if not (np.isfinite(x).all() and np.isfinite(y).all() and (x > 0).all() and (y > 0).all()):
        raise InputError(
            "x, y: a power law needs finite numbers above 0; subtract the zero of the sensor, and omit points below its noise"
        )
    names = np.asarray(["all"] * x.size if session is None else [str(each) for each in session])
    if names.size != x.size:
        raise InputError(f"session: {names.size} names for {x.size} points")
    found = {str(name): np.flatnonzero(names == name) for name in dict.fromkeys(names.tolist())}
    problems = [
        f"session '{name}': {rows.size} points at {np.unique(x[rows]).size} values of x; a session needs {_FEWEST} points at 2"
        for name, rows in found.items()
        if rows.size < _FEWEST or np.unique(x[rows]).size < 2
    ]
    if problems or not found:
        raise InputError(problems or "x, y: there are no points")
    return found


def _sentence(within: float, between: float) -> str:
    if math.isnan(between):
        return (
            f"one session: its points scatter by {within:.2g} in the exponent; how much sessions differ is unknown, so that the"
            " interval holds for this session only"
        )
    text = f"the exponent scatters by {within:.2g} within a session and by {between:.2g} between sessions"
    if between > within:
        text += ": an interval from the points of one session would be too narrow"
    return text
