"""Friction behind the force that a law without memory would give: a filter, or a lag whose corner changes in time."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError
from electrovib.physics.friction import Creep, FirstOrderLag, FollowingFriction, SteadyFriction
from electrovib.physics.programme import Steady
from electrovib.solve.filters.declared import first_order
from electrovib.solve.filters.filter import Filter
from electrovib.solve.recursion import march

if TYPE_CHECKING:
    from collections.abc import Callable

    from electrovib.physics.drive.base import Drive
    from electrovib.physics.friction import Friction
    from electrovib.solve.scenario import Scenario
    from electrovib.solve.transfer import Real

STEPS = 4000
"""Steps of a lag with a changing corner that there are at least, besides the output times."""
TOLERANCE = 1e-6
MOST_HALVINGS = 8


def steady_law(friction: Friction) -> SteadyFriction:
    """Find the law without memory inside a friction; itself if it has none."""
    if isinstance(friction, SteadyFriction):
        return friction
    assert isinstance(friction, FollowingFriction)
    return friction.steady


def friction_filter(scenario: Scenario) -> Filter:
    """Filter from the steady friction to the friction.

    Parameters
    ----------
    scenario : Scenario
        Its friction and the full sliding speed.

    Returns
    -------
    Filter
        Without dimension.

    Raises
    ------
    InputError
        If the corner of a lag needs a speed, or is not above 0 at it.
    """
    friction = scenario.friction
    if isinstance(friction, Creep):
        shares = np.array([each.share for each in friction.relaxations])
        poles = -1 / np.array([each.time for each in friction.relaxations])
        return Filter(poles.astype(complex), shares.astype(complex), 1 - float(np.sum(shares)))
    if isinstance(friction, FirstOrderLag):
        if friction.renewal_length is not None and scenario.motion.speed is None:
            raise InputError(
                "friction.renewal_length needs motion.speed, for instance motion.speed = '50 mm/s'"
            )
        corner = float(friction.corner(np.asarray(scenario.motion.speed or friction.at_speed)))
        if corner <= 0:
            raise InputError(
                f"friction.cut_off: its straight line gives {corner:.4g} Hz at motion.speed = {scenario.motion.speed} m/s;"
                " give the cut-off at a speed nearer to it"
            )
        return first_order(corner)
    return Filter(np.zeros(0, complex), np.zeros(0, complex), 1.0)


def corner_changes(scenario: Scenario) -> bool:
    """Tell whether the corner of a lag changes in time, as it does with the sliding speed."""
    friction = scenario.friction
    if not isinstance(friction, FirstOrderLag) or friction.renewal_length is None:
        return False
    return not isinstance(scenario.motion.programme, Steady)


def changing_lag(
    scenario: Scenario, steady_at: Callable[[Real], Real], times: Real, corners: Real
) -> tuple[Callable[[Real], Real], float]:
    """Friction behind a lag whose corner follows the sliding speed.

    Parameters
    ----------
    scenario : Scenario
        Its friction and motion.
    steady_at : callable
        Friction without the lag [N] at increasing times [s].
    times : ndarray, shape (n,)
        Increasing, >= 0 [s].
    corners : ndarray
        Where the friction may bend or jump [s].

    Returns
    -------
    friction : callable
        N at times [s] up to the last.
    error : float
        Largest change by the last halving of the steps, relative.

    Raises
    ------
    InputError
        If the corner is not above 0 at some speed that the programme passes.

    Notes
    -----
    In the time theta = integral of 2 pi f_c dt the lag has a constant rate of 1, so that the exact recursion of
    unequal steps follows it; the speed is straight between its corners, so theta is exact.
    """
    friction, motion = scenario.friction, scenario.motion
    assert isinstance(friction, FirstOrderLag)
    end = float(times[-1])
    bends = np.array([time for time, _ in motion.programme.corners() if 0 < time < end])
    fixed = np.unique(np.concatenate([times, corners, bends]))
    lowest = float(np.min(friction.corner(motion.speeds(np.concatenate([[0.0, end], bends])))))
    if lowest <= 0:
        raise InputError(
            f"friction.cut_off: its straight line gives {lowest:.4g} Hz at the slowest speed of motion.programme; give the"
            " cut-off at a lower speed, or leave friction.renewal_length away"
        )
    count, before, error = STEPS, None, math.inf
    for _ in range(MOST_HALVINGS):
        grid = np.union1d(np.linspace(0.0, end, count + 1), fixed)
        rate = 2 * math.pi * friction.corner(motion.speeds(grid))
        steps = np.diff(grid) * (rate[1:] + rate[:-1]) / 2
        force = steady_at(grid)
        start = steady_at(np.array([-1.0]))
        output, _ = march([-1.0], [[1.0]], [0.0], force[:-1], force[1:], steps, start)
        now = np.interp(times, grid, output[0])
        if before is not None:
            error = float(np.max(np.abs(now - before))) / (float(np.max(np.abs(now))) or 1.0)
            if error < TOLERANCE:
                break
        before, count = now, 2 * count
    return (lambda wanted: np.interp(wanted, grid, output[0])), error


def shortest_time(drive: Drive) -> float:
    """Shortest time in which the attraction under a drive changes [s]: half a period of its fastest oscillation."""
    fastest = drive.highest_frequency
    return 1 / (2 * fastest) if fastest else math.inf
