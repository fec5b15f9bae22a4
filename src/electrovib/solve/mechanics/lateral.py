"""Friction behind the force that a law without memory would give: a filter, or a march along the motion."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError
from electrovib.physics.friction import FollowingFriction
from electrovib.solve.mechanics.filters.filter import Filter
from electrovib.solve.mechanics.unknown import COUNTS, remembered, resting, spans_of
from electrovib.solve.recursion import march

if TYPE_CHECKING:
    from collections.abc import Callable

    from electrovib.core.arrays import Real
    from electrovib.physics.drive.base import Drive
    from electrovib.physics.motion import Motion
    from electrovib.scenario import Scenario
    from electrovib.solve.mechanics.unknown import Spans

STEPS = 4000
"""Steps of a march that there are at least, besides the output times."""
TOLERANCE = 1e-6
MOST_HALVINGS = 8
JUST = 1e-13
"""How long before a corner the force before it is looked up, as a share of the whole time."""


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
        If a memory needs a speed, or its rate is not above 0 at it.
    """
    speed = scenario.motion.speed
    parts = _memory(scenario, np.array([math.nan if speed is None else speed]))
    shares, rates = np.array([share for share, _ in parts]), np.array([rate[0] for _, rate in parts])
    return Filter(-rates.astype(complex), shares.astype(complex), 1 - float(np.sum(shares)))


def _memory(scenario: Scenario, speeds: Real) -> tuple[tuple[float, Real], ...]:
    """Parts of the friction that follow, with their rates [1/s] at speeds [m/s]; none of a law without memory."""
    friction, path = scenario.friction, f"friction = {type(scenario.friction).__name__}"
    if not isinstance(friction, FollowingFriction):
        return ()
    parts = tuple((share, np.asarray(rate, dtype=float)) for share, rate in friction.memory(speeds))
    rates = np.concatenate([rate for _, rate in parts]) if parts else np.ones(1)
    if np.any(np.isnan(rates)):
        raise InputError(f"{path}: its memory needs motion.speed, for instance motion.speed = '50 mm/s'")
    if np.any(rates <= 0):
        slowest = ", the slowest speed of motion.time_profile" if len(speeds) > 1 else ""
        raise InputError(
            f"{path}: its memory has a rate of {np.min(rates):.4g} 1/s, which must be above 0, at"
            f" {np.min(speeds):.4g} m/s{slowest}; of a FirstOrderLag give friction.cut_off at a speed nearer to it"
        )
    return parts


def memory_changes(scenario: Scenario) -> bool:
    """Tell whether the rates of a memory change in time, as they may with the sliding speed."""
    motion = scenario.motion
    if motion.speed is None or not isinstance(scenario.friction, FollowingFriction):
        return False
    speeds = motion.speeds(np.array([time for time, _ in motion.time_profile.corners()]))
    return any(bool(np.any(rate != rate[0])) for _, rate in _memory(scenario, speeds))


@dataclass(frozen=True)
class Lateral:
    """Friction along a motion.

    Parameters
    ----------
    force : callable
        N at times [s] up to the last, also where it is not known.
    unknown : tuple of (float, float)
        When it is not known [s].
    error : float
        Largest change by the last halving of the steps, relative.
    """

    force: Callable[[Real], Real]
    unknown: Spans
    error: float


def along_the_motion(
    scenario: Scenario,
    steady_at: Callable[[Real], Real],
    times: Real,
    corners: Real,
    *,
    stiffness: float | None,
) -> Lateral:
    """Friction along a motion that stops, lifts off, or changes how fast the friction follows.

    Parameters
    ----------
    scenario : Scenario
        Its friction and motion.
    steady_at : callable
        Friction without memory, were the finger sliding [N], at increasing times [s]; 0 off the plate.
    times : ndarray, shape (n,)
        Increasing, >= 0 [s].
    corners : ndarray
        Where that may bend or jump [s].
    stiffness : float, optional
        Of the skin against the bone [N/m]: at rest the friction is what its spring holds.

    Returns
    -------
    Lateral
        Force, when it is not known, and error.

    Raises
    ------
    InputError
        If the rate of a memory is not above 0 at some speed that the time profile passes.

    Notes
    -----
    In the time theta = integral of rate dt each part of a memory has a constant rate of 1, so that the exact recursion
    of unequal steps follows it. What a new contact remembers begins at 0. With a skin: at rest its spring keeps the
    force of the stop as long as that is below the friction of sliding, and gives way to that where it falls; when the
    bone sets out again the spring is stretched by its way until the skin slides. A skin that begins at rest is not
    stretched. Mass and damper of the skin are left out of that.
    """
    end, motion = float(times[-1]), scenario.motion
    bends = np.array([time for time in motion.breaks() if 0 < time < end])
    inside = np.concatenate([corners, bends])
    inside = inside[(inside > 0) & (inside <= end)]
    fixed = np.unique(np.concatenate([[0.0], times, inside, np.maximum(inside - JUST * end, 0.0)]))
    count, before, error = STEPS, None, math.inf
    for _ in range(MOST_HALVINGS):
        grid = np.union1d(np.linspace(0.0, end, count + 1), fixed)
        output, weight = _followed(scenario, steady_at, grid)
        if stiffness is not None:
            output = _held_by_the_skin(motion, grid, output, stiffness)
        output = np.where(motion.touches(grid), output, 0.0)
        now = np.interp(times, grid, output)
        if before is not None:
            error = float(np.max(np.abs(now - before))) / (float(np.max(np.abs(now))) or 1.0)
            if error < TOLERANCE:
                break
        before, count = now, 2 * count
    unknown = motion.rests(grid) | ((weight > COUNTS) & motion.touches(grid))
    spans = () if stiffness is not None else spans_of(grid, unknown)
    return Lateral(lambda wanted: np.interp(wanted, grid, output), spans, error)


def _followed(scenario: Scenario, steady_at: Callable[[Real], Real], grid: Real) -> tuple[Real, Real]:
    """Friction behind its memory [N], were the finger sliding, and the weight of the rest in it, at times [s]."""
    motion, force = scenario.motion, steady_at(grid)
    parts = _memory(scenario, motion.speeds(grid)) if motion.speed is not None else _unstated(scenario, grid)
    start = steady_at(np.array([-1.0]))
    output, weight = force * (1 - sum(share for share, _ in parts)), np.zeros(len(grid))
    spans = resting(motion)
    for share, rate in parts:
        steps = np.diff(grid) * (rate[1:] + rate[:-1]) / 2
        theta = np.append(0.0, np.cumsum(steps))
        for first, last in _contacts(motion, grid):
            state = start if first == 0 else np.zeros(1)
            rows, _ = march(
                [-1.0],
                [[1.0]],
                [0.0],
                force[first : last - 1],
                force[first + 1 : last],
                steps[first : last - 1],
                state,
            )
            output[first:last] += share * rows[0]
        ends = [tuple(np.interp(span, grid, theta, left=-math.inf, right=math.inf)) for span in spans]
        weight += share * remembered(theta, [(float(a), float(b)) for a, b in ends])
    return output, weight


def _unstated(scenario: Scenario, grid: Real) -> tuple[tuple[float, Real], ...]:
    """Memory at a speed that is not stated, at times [s]."""
    return _memory(scenario, np.full(len(grid), math.nan))


def _contacts(motion: Motion, grid: Real) -> list[tuple[int, int]]:
    """First and behind the last place of each contact on a grid [s]."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], motion.touches(grid), [False]]).astype(int)))
    pairs = zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
    return [(first, last) for first, last in pairs if last - first > 1]


def _held_by_the_skin(motion: Motion, grid: Real, sliding: Real, stiffness: float) -> Real:
    """Friction where the spring of the skin [N/m] decides at rest and after it, else that of sliding [N]."""
    touches, rests = motion.touches(grid), motion.rests(grid)
    speeds = motion.speeds(grid)
    way = np.append(0.0, np.cumsum(np.diff(grid) * (speeds[1:] + speeds[:-1]) / 2))
    kinds = np.where(touches, np.where(rests, 1, 2), 0)  # off, at rest, sliding
    edges = [0, *(np.flatnonzero(np.diff(kinds)) + 1).tolist(), len(grid)]
    output, held, was_at_rest = np.array(sliding), 0.0, bool(motion.rests(np.array(-1.0)))
    for first, last in pairwise(edges):
        part = slice(first, last)
        if kinds[first] == 0:
            held, was_at_rest = 0.0, False
            continue
        if kinds[first] == 1:
            output[part] = np.minimum(np.minimum.accumulate(sliding[part]), held)
        elif was_at_rest:
            pulled = held + stiffness * (way[part] - way[first])
            slips = np.maximum.accumulate(pulled >= sliding[part])
            output[part] = np.where(slips, sliding[part], pulled)
        held, was_at_rest = float(output[last - 1]), bool(kinds[first] == 1)
    return output


def shortest_time(drive: Drive) -> float:
    """Shortest time in which the attraction under a drive changes [s]: half a period of its fastest oscillation."""
    fastest = drive.highest_frequency
    return 1 / (2 * fastest) if fastest else math.inf
