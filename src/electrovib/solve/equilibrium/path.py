"""The gap under a voltage that rises and falls slowly: along a branch of states up to its end, then on the next branch."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from electrovib.core.arrays import Real
from electrovib.core.errors import InputError
from electrovib.physics.contact.attraction import Attraction
from electrovib.physics.contact.surface import Surface
from electrovib.physics.roughness import ContactSpots
from electrovib.solve.equilibrium.states import Equilibrium, attraction_at, balance

SAME = 1e-9
"""Relative distance below which a state counts as that of the previous step."""
BETWEEN = 65
"""Number of gaps between two steps at which the stability of the branch is checked."""


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


@dataclass(frozen=True)
class Hysteresis:
    """Gaps over a rising and then a falling voltage."""

    up: Path
    down: Path


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
    states, jumps = [], []
    for index, voltage in enumerate(voltages):
        state = _next(gap, surface, attraction(float(voltage)), pressure)
        moved = index > 0 and _branch_ends(gap, state.gap, surface, attraction(1.0), pressure)
        states.append(state)
        jumps.append(moved)
        gap = state.gap
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
