"""Equilibrium states of surface topography, load and attraction: all crossings of two curves over the gap.

Under a voltage that rises and falls slowly the gap follows a branch of states up to its end, then the next branch.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar, TypeAlias

import numpy as np
from numpy.typing import NDArray

from electrovib.core import answer
from electrovib.core.arrays import Real
from electrovib.core.errors import ElectrovibError, InputError
from electrovib.core.units import format_quantity
from electrovib.data.atomic import Form, csv_text
from electrovib.physics.contact.attraction import Attraction, PlateAttraction, RoughAttraction
from electrovib.physics.contact.surface import Surface
from electrovib.physics.roughness import ContactSpots

BEYOND = 1e-6
"""Extension of the range beyond the gap under the load alone, as a share of it; without voltage that gap is the state."""
PARTS = 64
"""Number of parts of the range for an attraction that is not convex."""
NOISE = 64 * 2.0**-52
"""Relative rounding of a value or slope of either curve; the sign of a difference below it is not known."""
MOST_INTERVALS = 20_000
"""Largest number of intervals; only curves that are not smooth may need more."""
SAME = 1e-9
"""Relative distance below which a state counts as that of the previous step."""
BETWEEN = 65
"""Number of gaps between two steps at which the stability of the branch is checked."""
Curve = Callable[[float], tuple[float, float]]
"""Value and slope at a place."""


@dataclass(frozen=True, kw_only=True)
class Equilibrium:
    """One equilibrium state.

    Parameters
    ----------
    gap : float
        Mean gap [m].
    stable : bool
        Whether the state is stable against a small displacement. A fold, where a stable and an unstable state meet, is
        not stable.
    touching : bool
        Whether the gap is closed and the plate itself supports a part of the pressure.
    fold : bool
        Whether two states coincide within rounding, where a branch ends.
    repulsion, attraction : float
        Pressures of the surface topography and of the voltage at this gap [Pa].
    stop : float
        Pressure that the plate itself supports [Pa]; 0 where the gap is open.
    residual : float
        repulsion + stop - load - attraction [Pa], without what contact spots hold of it (`Surface.held`).
    """

    gap: float
    stable: bool
    touching: bool = False
    fold: bool = False
    repulsion: float
    attraction: float
    stop: float = 0.0
    residual: float = 0.0


def attraction_at(
    voltage: float, electrical_thickness: float, surface: Surface, spots: ContactSpots | None
) -> Attraction:
    """Return the attraction of parallel plates, or with contact spots its mean over the gaps of a rough surface."""
    if spots is None:
        return PlateAttraction(voltage, electrical_thickness)
    return RoughAttraction(
        voltage=voltage, electrical_thickness=electrical_thickness, surface=surface, spots=spots
    )


def balance(
    surface: Surface,
    attraction: Attraction,
    *,
    pressure: float,
) -> tuple[Equilibrium, ...]:
    """Return the equilibria of surface topography, load and any attraction.

    All states of a convex attraction are found with certainty. For other attractions two states closer than a
    64th of the range may be missed where the attraction has a point of inflection.
    """
    low, high = _range(surface, attraction, pressure)

    def repels(gap: float) -> tuple[float, float]:
        at = np.asarray(gap)
        return float(surface.pressure(at)), float(surface.slope(at))

    def draws(gap: float) -> tuple[float, float]:
        return pressure + attraction.pressure(gap), attraction.slope(gap)

    states = [
        _state(place, repels(place.place), draws(place.place), attraction.total(place.place))
        for place in crossings(repels, draws, low=low, high=high, parts=1 if attraction.convex else PARTS)
    ]
    lacking = draws(low)[0] - repels(low)[0]
    if low == 0 and lacking > 0:
        closed = Equilibrium(
            gap=0.0,
            stable=True,
            touching=True,
            repulsion=repels(0)[0],
            attraction=attraction.total(0.0),
            stop=lacking,
        )
        states = [closed, *(state for state in states if state.gap > 0)]
    return tuple(states)


def _state(
    found: Crossing, repels: tuple[float, float], draws: tuple[float, float], attraction: float
) -> Equilibrium:
    (repulsion, first), (drawn, second) = repels, draws
    marginal = abs(first - second) <= NOISE * (abs(first) + abs(second))
    return Equilibrium(
        gap=found.place,
        stable=first < second and not found.fold and not marginal,
        fold=found.fold or marginal,
        repulsion=repulsion,
        attraction=attraction,
        residual=repulsion - drawn,
    )


def _range(surface: Surface, attraction: Attraction, pressure: float) -> tuple[float, float]:
    """Return the range that contains every state: the largest gap is that under the load alone."""
    high = float(surface.gap(np.asarray(pressure))) * (1 + BEYOND)
    if not math.isfinite(high):
        raise InputError(
            f"pressure = {pressure} Pa: nothing presses skin and plate together, so the gap has no bound. Give a pressure"
            " above 0"
        )
    low = attraction.smallest_gap
    return low, max(low, high)


@dataclass(frozen=True)
class Crossing:
    """A place where two curves meet.

    Parameters
    ----------
    place : float
        Abscissa of the crossing.
    fold : bool
        Whether the curves touch within rounding, or cross twice within rounding.
    """

    place: float
    fold: bool


@dataclass(frozen=True)
class _Point:
    """Both curves at one place, each with its slope."""

    x: float
    upper: tuple[float, float]
    lower: tuple[float, float]

    @property
    def difference(self) -> float:
        return self.upper[0] - self.lower[0]

    @property
    def noise(self) -> float:
        return NOISE * (abs(self.upper[0]) + abs(self.lower[0]))


def crossings(
    first: Curve, second: Curve, *, low: float, high: float, parts: int = 1
) -> tuple[Crossing, ...]:
    """Return all crossings of two curves.

    Where its slope is monotonic a curve lies between its chord and its tangents at the ends, and its slope
    between those at the ends. The difference is therefore bounded, and an interval is discarded where the
    bounds exclude 0. Where the slopes exclude an extremum, a change of sign is solved by bracketing.
    Otherwise the interval is halved, until the difference is below rounding everywhere in it: there the
    curves touch, which is reported once. Convex curves need one part, and no crossing is missed. For other
    curves a pair of crossings may be missed in a part that contains a point of inflection.
    """
    points = [
        _Point(x, first(x), second(x))
        for x in [*(low + (high - low) * k / parts for k in range(parts)), high]
    ]
    found = [part for ends in pairwise(points) for part in _search(first, second, ends)]
    return tuple(_merged(sorted(found, key=lambda part: part[0]), scale=max(abs(low), abs(high))))


_Ends: TypeAlias = tuple[_Point, _Point]
_Part: TypeAlias = tuple[float, float, Crossing]
"""Both ends of an interval, and the crossing in it."""


def _search(first: Curve, second: Curve, whole: _Ends) -> Iterator[_Part]:
    waiting, opened = [whole], 0
    while waiting:
        (left, right), opened = waiting.pop(), opened + 1
        if opened > MOST_INTERVALS:
            raise ElectrovibError(
                "equilibrium: the search for states does not end; repulsion and attraction have to be smooth over the whole"
                " range of gaps"
            )
        noise = max(left.noise, right.noise)
        below, above = _bounds(left, right)
        if below > noise or above < -noise:
            continue
        if _turns_nowhere(left, right):
            if left.difference * right.difference <= 0:
                yield left.x, right.x, Crossing(_bracketed(first, second, left, right), fold=False)
            continue
        middle = (left.x + right.x) / 2
        if (below >= -noise and above <= noise) or not left.x < middle < right.x:
            nearest = min(left, right, key=lambda point: abs(point.difference))
            yield left.x, right.x, Crossing(nearest.x, fold=True)
            continue
        centre = _Point(middle, first(middle), second(middle))
        waiting += [(left, centre), (centre, right)]


def _bounds(a: _Point, b: _Point) -> tuple[float, float]:
    """Return lower and upper bounds of the difference; both are straight between kinks."""
    below, above = sorted((a.difference, b.difference))
    curves = [(a.x, b.x, a.upper, b.upper), (a.x, b.x, a.lower, b.lower)]
    for x in [_kink(*each) for each in curves] if b.x > a.x else []:
        (least, most), (least_other, most_other) = (_around(x, *each) for each in curves)
        below, above = min(below, least - most_other), max(above, most - least_other)
    return below, above


def _kink(a: float, b: float, at_a: tuple[float, float], at_b: tuple[float, float]) -> float:
    """Return where the tangents at both ends of a curve intersect."""
    bend = at_b[1] - at_a[1]
    if bend == 0:
        return a
    return min(max((at_a[0] - at_b[0] + at_b[1] * b - at_a[1] * a) / bend, a), b)


def _around(
    x: float, a: float, b: float, at_a: tuple[float, float], at_b: tuple[float, float]
) -> tuple[float, float]:
    """Return lower and upper bounds at a place of a curve whose slope is monotonic between two ends."""
    chord = at_a[0] + (at_b[0] - at_a[0]) * ((x - a) / (b - a))
    tangents = at_a[0] + at_a[1] * (x - a), at_b[0] - at_b[1] * (b - x)
    if at_b[1] >= at_a[1]:
        return min(chord, max(tangents)), chord
    return chord, max(chord, min(tangents))


def _turns_nowhere(a: _Point, b: _Point) -> bool:
    """Return whether the slope of the difference cannot be 0."""
    upper, lower = (a.upper[1], b.upper[1]), (a.lower[1], b.lower[1])
    noise = NOISE * (max(map(abs, upper)) + max(map(abs, lower)))
    return min(upper) - max(lower) > noise or max(upper) - min(lower) < -noise


def _bracketed(first: Curve, second: Curve, a: _Point, b: _Point) -> float:
    from scipy.optimize import brentq

    for end in (a, b):
        if end.difference == 0:
            return end.x
    accuracy = {"xtol": 1e-300, "rtol": 4 * 2.0**-52, "maxiter": 500}
    return float(brentq(lambda x: first(x)[0] - second(x)[0], a.x, b.x, **accuracy))


def _merged(found: list[_Part], *, scale: float) -> Iterator[Crossing]:
    """Yield each crossing once: neighbouring intervals may share a crossing at their common end, or parts of a fold."""
    groups: list[list[_Part]] = []
    for part in found:
        begin, _, here = part
        _, end, before = groups[-1][-1] if groups else (0.0, -math.inf, here)
        same = abs(here.place - before.place) <= 4 * 2.0**-52 * scale
        if begin <= end and (same or here.fold or before.fold):
            groups[-1].append(part)
        else:
            groups.append([part])
    for group in groups:
        each = [part[2] for part in group]
        folds = [one for one in each if one.fold]
        yield folds[len(folds) // 2] if folds else each[0]


@dataclass(frozen=True, kw_only=True)
class Path:
    """Gaps along a sequence of voltages.

    Parameters
    ----------
    voltage, gap, attraction : ndarray, shape (n,)
        Voltage [V], gap [m] and attraction per area [Pa].
    jump : ndarray of bool, shape (n,)
        Whether a branch ended between the previous voltage and this one.
    states : tuple of Equilibrium
        The state at each voltage.
    """

    voltage: Real
    gap: Real
    attraction: Real
    jump: NDArray[np.bool_]
    states: tuple[Equilibrium, ...]


@dataclass(frozen=True, repr=False)
class Hysteresis(answer.Answer):
    """Gaps over a rising and then a falling voltage."""

    FILES: ClassVar = {"hysteresis.csv": Form.TABLE}
    up: Path
    down: Path

    @property
    def document(self) -> answer.Document:
        """The gap at both ends, the voltages at which a branch ends, and the gap over the voltage."""
        paths = {"rising": self.up, "falling": self.down}
        first, last = (
            f"{format_quantity(float(self.up.gap[at]), 'm', digits=4)} at"
            f" {format_quantity(float(self.up.voltage[at]), 'V', digits=4)}"
            for at in (0, -1)
        )
        ends = [
            f"under the {name} voltage a branch ends before"
            f" {', '.join(format_quantity(each, 'V', digits=4) for each in path.voltage[path.jump].tolist())}"
            for name, path in paths.items()
            if path.jump.any()
        ]
        curves = tuple(answer.Curve(label=name, x=path.voltage, y=path.gap) for name, path in paths.items())
        panel = answer.Panel(
            id="gap",
            title="Gap over the voltage",
            caption="",
            x=("voltage", "V"),
            y=("gap", "m"),
            curves=curves,
        )
        said = [f"gap: {first}, {last}", *(ends or ["no branch ends: the gap has no hysteresis"])]
        return answer.Document(
            title="Gap under a voltage that rises and falls", sentences=said, figures=[panel]
        )

    def content(self, name: str) -> str:
        """Write every state as CSV, in SI."""
        del name
        rows = [
            (name, *numbers)
            for name, path in (("rising", self.up), ("falling", self.down))
            for numbers in zip(
                *(each.tolist() for each in (path.voltage, path.gap, path.attraction)), strict=True
            )
        ]
        return csv_text(("voltage is", "voltage [V]", "gap [m]", "attraction [Pa]"), rows)


def hysteresis(
    voltages: Sequence[float] | Real,
    *,
    surface: Surface,
    pressure: float,
    electrical_thickness: float,
    spots: ContactSpots | None = None,
) -> Hysteresis:
    """Compute the gap under a voltage that rises and then falls slowly.

    Parameters
    ----------
    voltages : array_like, shape (n,)
        Constant or root-mean-square voltages [V], rising.
    surface : Surface
        Repulsive pressure of the surface topography as a function of the gap.
    pressure : float
        Pressure of the load [Pa].
    electrical_thickness : float
        K, the sum of T/eps over the layers that block [m], above 0.
    spots : ContactSpots, optional
        Averages the attraction over the gaps of the surface, with these spots where it touches; by default the
        gap is the same everywhere.

    Returns
    -------
    Hysteresis
        ``up`` in the order of the voltages, ``down`` in reverse order.

    Raises
    ------
    InputError
        If the voltages do not rise, or a state is outside the range of the surface model.

    Examples
    --------
    >>> from electrovib.physics.contact import LinearSpring
    >>> surface = LinearSpring(stiffness=1e9, free_gap=10e-6)
    >>> found = ev.hysteresis([0, 100, 200], surface=surface, pressure=5e3, electrical_thickness=27e-6)
    >>> found.up.gap.round(8)
    array([5.00e-06, 4.96e-06, 4.83e-06])
    """
    course = np.asarray(voltages, dtype=float)
    if course.ndim != 1 or len(course) < 1 or not np.all(np.diff(course) > 0):
        raise InputError("voltages: expected rising voltages [V], for instance np.linspace(0, 200, 101)")

    def at(voltage: float) -> Attraction:
        return attraction_at(voltage, electrical_thickness, surface, spots)

    up = follow(course, at, surface=surface, pressure=pressure)
    down = follow(course[::-1], at, surface=surface, pressure=pressure, start=float(up.gap[-1]))
    return Hysteresis(up, down)


def follow(
    voltages: Real,
    attraction: Callable[[float], Attraction],
    *,
    surface: Surface,
    pressure: float,
    start: float | None = None,
) -> Path:
    """Compute the gap along a slow sequence of voltages.

    `voltages` (n,) [V].

    At each voltage the gap moves in the direction of the net pressure of surface topography, load and attraction, to the
    first equilibrium. All states lie on one curve V^2(g) = (repulsion - pressure)/(attraction of 1 V); a branch ends
    where that curve has an extremum.
    """
    gap = float(surface.gap(np.asarray(pressure))) if start is None else start
    states, jumps = list[Equilibrium](), []
    for voltage in voltages:
        states.append(_next(gap, surface, attraction(float(voltage)), pressure))
        before, gap = gap, states[-1].gap
        jumps.append(len(states) > 1 and _branch_ends(before, gap, surface, attraction(1.0), pressure))
    gaps, drawn = (np.array([getattr(state, name) for state in states]) for name in ("gap", "attraction"))
    return Path(
        voltage=np.array(voltages, dtype=float),
        gap=gaps,
        attraction=drawn,
        jump=np.array(jumps, dtype=bool),
        states=tuple(states),
    )


def _next(gap: float, surface: Surface, attraction: Attraction, pressure: float) -> Equilibrium:
    states = balance(surface, attraction, pressure=pressure)
    here = [state for state in states if abs(state.gap - gap) <= SAME * gap and state.stable]
    if here:
        return here[0]
    net = float(surface.pressure(np.asarray(gap))) - pressure - attraction.pressure(gap)
    ahead = [state for state in states if (state.gap > gap if net > 0 else state.gap < gap)]
    if not ahead:
        end = (
            "opens beyond every equilibrium" if net > 0 else "closes further than the surface model describes"
        )
        raise InputError(
            f"surface: from a gap of {gap:.3g} m the contact {end}; lower the voltage, or omit 'spots'"
        )
    return min(ahead, key=lambda state: abs(state.gap - gap))


def _branch_ends(start: float, end: float, surface: Surface, one_volt: Attraction, pressure: float) -> bool:
    """Return whether a gap between two states would not be stable under the voltage that balances it."""
    if start == end:
        return False
    for gap in np.linspace(start, end, BETWEEN)[1:-1]:
        net = float(surface.pressure(gap)) - pressure
        squared = net / one_volt.pressure(float(gap))
        if float(surface.slope(gap)) > squared * one_volt.slope(float(gap)):
            return True
    return False
