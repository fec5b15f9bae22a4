"""The exponent of a power law, such as that of force over voltage, with a scatter between sessions; points from tables."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, Final

import numpy as np

from electrovib.core.answer import REFERENCE, Answer, Curve, Document, Panel, Table
from electrovib.core.budget import one_thread
from electrovib.core.errors import InputError, gathered
from electrovib.core.units import KINDS
from electrovib.data.atomic import Form, csv_text
from electrovib.data.recorded import column_of
from electrovib.data.registry import read_recorded
from electrovib.data.unit_words import kind_and_factor
from electrovib.recordings.fit.misfit import RandomEffects, random_effects
from electrovib.recordings.interval import Interval, from_noise

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

    from electrovib.core.arrays import Real
    from electrovib.data.recorded import DataColumn

_FEWEST: Final = 3
_DRAWN: Final = 5
"""Sessions that have a colour each."""


@dataclass(frozen=True, kw_only=True)
class SessionLaw:
    """The law of one session through the points `x`, `y`, shape (n,), in SI.

    `factor` is y at x = 1, and `scatter` the standard deviation of ln y about the law.
    """

    x: Real
    y: Real
    exponent: float
    standard_error: float
    factor: float
    scatter: float

    @property
    def degrees_of_freedom(self) -> int:
        """Points less the two numbers of the law."""
        return self.x.size - 2

    def curves(self, name: str, number: int) -> list[Curve]:
        """The points and the law of a session for a figure, which draws the laws of the first sessions."""
        drawn = number < _DRAWN
        look = number if drawn else REFERENCE
        line = np.geomspace(self.x.min(), self.x.max(), 50)
        return [
            Curve(label=name, x=self.x, y=self.y, kind="points", look=look),
            Curve(
                label=f"{name}: exponent {self.exponent:.3g}",
                x=line,
                y=self.factor * line**self.exponent,
                look=look,
                drawn=drawn,
            ),
        ]


@dataclass(frozen=True, kw_only=True, repr=False)
class PowerLawFit(Answer, Interval):
    """A power law y = c_s x^(n + d_s) whose factor and exponent differ between sessions s.

    `exponent` is n, the mean of the population of sessions; `between` is the spread of the exponent between
    sessions beyond the noise of each, None with one session.
    """

    FILES: ClassVar = {"power_law.csv": Form.TABLE}
    sessions: dict[str, SessionLaw]
    between: RandomEffects | None
    exponent = property(lambda self: self.value)

    @property
    def document(self) -> Document:
        """The exponent with its interval, a row for each session, and points with laws."""
        rows = [
            (
                name,
                *(
                    f"{value:.4g}"
                    for value in (each.exponent, each.standard_error, each.scatter, each.factor)
                ),
            )
            for name, each in self.sessions.items()
        ]
        figure = Panel(
            id="power_law", title="Points and laws", caption="Each session with its own factor and exponent.",
            x=("x", ""), y=("y", ""), log_x=True, log_y=True,
            curves=tuple(
                curve
                for number, (name, each) in enumerate(self.sessions.items())
                for curve in each.curves(name, number)
            ),
        )  # fmt: skip
        headings = ("session", "exponent", "standard error", "scatter of ln y", "y at x = 1, SI")
        return Document(
            title="A power law",
            sentences=[
                f"exponent {self.exponent:.4g}, 95 % interval {self.lower:.4g} to {self.upper:.4g}",
                self.sentence,
            ],
            numbers=[Table("", headings, tuple(rows))],
            figures=[figure],
        )

    def content(self, name: str) -> str:
        """Write the law as CSV, in SI: a row for each session, then the mean over sessions with its interval."""
        del name
        columns = ("exponent", "standard_error", "factor", "scatter", "degrees_of_freedom")
        rows: list[list[object]] = [
            [name, *(getattr(each, column) for column in columns), *[""] * 5]
            for name, each in self.sessions.items()
        ]
        found = self.between
        between = [""] * 3 if found is None else [found.between.value, *found.between.ends]
        mean = "the session" if found is None else "mean of the sessions"
        rows.append([mean, self.exponent, self.standard_error, *[""] * 3, self.lower, self.upper, *between])
        headings = ("session", *columns, "lower", "upper", "between", "between_lower", "between_upper")
        return csv_text(headings, rows, remarks=[self.sentence])

    @property
    def sentence(self) -> str:
        """How much sessions differ, or why that is unknown."""
        if self.between is None:
            return (
                "one session: how much sessions differ is unknown, so that the interval stands on the scatter of its points and"
                " holds for this session only"
            )
        found, spread, freedom = self.between, self.between.between, len(self.sessions) - 1
        compared = (
            f"chi squared {found.chi_squared:.3g} with {freedom} degree{'s' * (freedom > 1)} of freedom"
        )
        words = (
            f"standard deviation {spread.value:.2g}, 95 % interval {spread.lower:.2g} to {spread.upper:.2g}"
        )
        if spread.lower > 0:
            return (
                f"the exponent differs between sessions by more than the noise of their points ({compared}): {words}; an"
                " interval from the points of one session would be too narrow"
            )
        if spread.upper == 0:
            return f"the exponents of the sessions agree better than the noise of their points lets expect ({compared})"
        return f"the noise of the points explains the differences between sessions ({compared}): {words}"


@one_thread(with_scipy=True)
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
        Exponent with its interval, the law of each session, and the spread between them.

    Raises
    ------
    InputError
        If numbers are not positive, or a session has fewer than three points or only one value of x.

    Notes
    -----
    A straight line through the logarithms of each session, with the scatter of its own points. With several sessions the
    interval is that of `random_effects`, which weights them by their noise and the spread between them: the points of one
    session share its mounting and are not independent. With one session it is that of Student's t with two degrees of freedom
    less than points, and holds for that session only.

    Examples
    --------
    >>> found = ev.fit_power_law([10, 20, 40], [1.0, 4.1, 15.8])
    >>> f"{found.exponent:.2f}"
    '1.99'
    """
    voltage, force = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    groups = _groups(voltage, force, session)
    laws = {name: _law(voltage[rows], force[rows]) for name, rows in groups.items()}
    numbers = [(each.exponent, each.standard_error, each.degrees_of_freedom) for each in laws.values()]
    if len(laws) == 1:
        value, error, freedom = numbers[0]
        return PowerLawFit(**vars(from_noise(value, error, freedom=freedom)), sessions=laws, between=None)
    values, errors, freedoms = zip(*numbers, strict=True)
    found = random_effects(values, errors, freedom=freedoms)
    return PowerLawFit(**vars(found.mean), sessions=laws, between=found)


def _law(x: Real, y: Real) -> SessionLaw:
    """Straight line through the logarithms of one session by least squares."""
    along, values = np.log(x), np.log(y)
    (slope, intercept), covariance = np.polyfit(along, values, 1, cov=True)
    left = values - slope * along - intercept
    return SessionLaw(
        x=x, y=y,
        exponent=float(slope),
        standard_error=math.sqrt(covariance[0, 0]),
        factor=math.exp(intercept),
        scatter=math.sqrt(float(left @ left) / (x.size - 2)),
    )  # fmt: skip


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


def read_points(
    files: Sequence[str | Path],
    *,
    x: str,
    y: str,
    session: str = "",
    reader: str = "",
    delimiter: str | None = None,
    decimal_comma: bool | None = None,
    named: tuple[str, str] = ("x", "y"),
    kinds: tuple[str, str] | None = None,
) -> tuple[Real, Real, list[str], int]:
    """Read x, y, both in SI, and the session, by default the file, of each point from tables, and how many rows lack a number.

    Errors call both columns as `named`; `kinds` are their units, of which others are refused.
    """
    problems = [f"{path}: is given twice; omit one" for path in dict.fromkeys(files) if files.count(path) > 1]
    if x == y:
        problems.append(f"{', '.join(named)}: both are the column {x!r}; two are needed")
    rows: list[tuple[Real, Real]] = []
    names: list[str] = []
    omitted = 0
    for path in map(Path, files):
        with gathered(problems):
            recorded = read_recorded(path, reader=reader, delimiter=delimiter, decimal_comma=decimal_comma)
            along, values = (
                _in_si(column_of(recorded, stated, option=option), option, kind)
                for option, stated, kind in zip(named, (x, y), kinds or ("", ""), strict=True)
            )
            kept = np.isfinite(along) & np.isfinite(values)
            own = [path.name if len(files) == 1 or path.name not in names else str(path)] * int(kept.sum())
            if session:
                numbers = column_of(recorded, session, option="session").values
                kept &= np.isfinite(numbers)
                own = [f"{path.name}: {each:g}" if len(files) > 1 else f"{each:g}" for each in numbers[kept]]
            rows.append((along[kept], values[kept]))
            omitted += int(np.sum(~kept))
            names += own
    if problems or not rows:
        raise InputError(problems or "files: name at least one table")
    first, second = (np.concatenate(part) for part in zip(*rows, strict=True))
    return first, second, names, omitted


def _in_si(column: DataColumn, option: str, kind: str) -> Real:
    """Convert a column from its unit, which must be of a kind unless that is empty; one without a unit is taken as SI."""
    if not column.unit:
        return column.values
    known = kind_and_factor(column.unit)
    if known is None:
        raise InputError(f"column '{column.name}': the unit '{column.unit}' is not known")
    if kind and known[0] != kind:
        raise InputError(
            f"{option} = {column.name}: it is in '{column.unit}', but {KINDS[kind][0]} is needed; name another column"
        )
    return np.asarray(column.values * known[1])
