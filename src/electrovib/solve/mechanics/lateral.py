"""Friction with memory: as a filter or along the motion, where it is unknown, and what is proportional to it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np

from electrovib.core.errors import InputError
from electrovib.solve.mechanics.filters import Filter
from electrovib.solve.recursion import march

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.physics.drive.base import Drive
    from electrovib.physics.motion import Motion
    from electrovib.scenario import Scenario


Spans: TypeAlias = "tuple[tuple[float, float], ...]"
"""Begin and end of each span [s], the first begin may be minus infinity; the end is excluded."""
COUNTS = 1e-6
"""Largest weight of unknown input in a known output [1]: the tolerance of the mechanics."""
STEPS = 4000
"""Smallest number of time steps, besides the output times."""
TOLERANCE = 1e-6
MOST_HALVINGS = 8
JUST = 1e-13
"""Time before a corner at which the force before it is evaluated, over the whole time."""
BEHIND_FRICTION: Final = frozenset(
    {"lateral_force", "lateral_force_measured", "skin_displacement", "skin_speed"}
)
"""Signals that are linear in the friction of steady sliding, without a digitiser."""
INDEPENDENT: Final = frozenset(
    {
        "electrostatic_force",
        "current",
        "stack_voltage",
        "effective_voltage",
        "interface_field",
        "capacitance",
        "impedance",
    }
)
"""Signals that are independent of the friction."""


def resting(motion: Motion) -> Spans:
    """Return the spans in which a finger touches the plate and does not move."""
    breaks = np.array(motion.breaks())
    begins, ends = np.append(-np.inf, breaks), np.append(breaks, np.inf)
    rests = motion.rests(np.append(breaks[:1] - 1.0, breaks))
    found: list[tuple[float, float]] = []
    for begin, end in zip(begins[rests].tolist(), ends[rests].tolist(), strict=True):
        if found and found[-1][1] == begin:
            found[-1] = (found[-1][0], end)
        else:
            found.append((begin, end))
    return tuple(found)


def not_known(filter_: Filter, spans: Spans, times: Real) -> Real:
    """Return the weight of an unknown input in the output of a filter.

    `times` (n,) [s]; returns `weight` (n,).
    """
    share = abs(filter_.direct) * np.any([(times >= begin) & (times < end) for begin, end in spans], axis=0)
    for pole, gain in zip(filter_.poles, filter_.gains, strict=True):
        weight = abs(gain) * abs(pole) / -pole.real * (2.0 if pole.imag else 1.0)
        share = share + weight * remembered(
            -pole.real * times, [(-pole.real * a, -pole.real * b) for a, b in spans]
        )
    return np.asarray(share / abs(filter_.at_rest()))


def remembered(times: Real, spans: list[tuple[float, float]]) -> Real:
    """Return the weight of spans in an exponential memory.

    `times` (n,); returns `weight` (n,).
    """
    weight = np.zeros(np.shape(times))
    for begin, end in spans:
        inside = times > begin
        last = np.minimum(times, end)
        weight += np.where(inside, np.exp(last - times) - np.exp(np.minimum(begin - times, 0.0)), 0.0)
    return weight


def spans_of(times: Real, wrong: NDArray[np.bool_]) -> Spans:
    """Return the spans in which a condition holds.

    `times` (n,) [s], `wrong` (n,).
    """
    stamps = np.append(times, np.inf)
    return tuple(
        (-np.inf if begin == 0 else float(stamps[begin]), float(stamps[end])) for begin, end in _runs(wrong)
    )


def _runs(true: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return the first index of each run of true values (n,), and the index after its last."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], true, [False]]).astype(int))).tolist()
    return list(zip(edges[::2], edges[1::2], strict=True))


def friction_filter(scenario: Scenario) -> Filter:
    """Return the filter from the steady friction to the friction."""
    speed = scenario.motion.speed
    parts = _memory(scenario, np.array([math.nan if speed is None else speed]))
    shares, rates = np.array([share for share, _ in parts]), np.array([rate[0] for _, rate in parts])
    return Filter(-rates.astype(complex), shares.astype(complex), 1 - float(np.sum(shares)))


def _memory(scenario: Scenario, speeds: Real) -> tuple[tuple[float, Real], ...]:
    """Return the shares of the friction with memory, and their rates [1/s] at speeds [m/s]; empty without memory."""
    friction, path = scenario.friction, f"friction = {type(scenario.friction).__name__}"
    parts = tuple((share, np.asarray(rate, dtype=float)) for share, rate in friction.memory(speeds))
    rates = np.concatenate([rate for _, rate in parts]) if parts else np.ones(1)
    if np.any(np.isnan(rates)):
        raise InputError(f"{path}: its memory needs motion.speed, for instance motion.speed = '50 mm/s'")
    if np.any(rates <= 0):
        slowest = ", the slowest speed of motion.time_profile" if len(speeds) > 1 else ""
        raise InputError(
            f"{path}: its memory has a rate of {np.min(rates):.4g} 1/s at {np.min(speeds):.4g} m/s{slowest}, and must be"
            " above 0; for a FirstOrderLag give friction.cut_off at a speed nearer to it"
        )
    return parts


def memory_changes(scenario: Scenario) -> bool:
    """Return whether the rates of a memory change in time, as they may with the sliding speed."""
    motion = scenario.motion
    if motion.speed is None:
        return False
    speeds = motion.speeds(np.array([time for time, _ in motion.time_profile.corners()]))
    return any(bool(np.any(rate != rate[0])) for _, rate in _memory(scenario, speeds))


@dataclass(frozen=True)
class Lateral:
    """Friction along a motion.

    Parameters
    ----------
    force : callable
        Friction [N] at times [s] up to the last, with a finite value also where it is unknown.
    unknown : tuple of (float, float)
        Spans in which it is unknown [s].
    error : float
        Largest change by the last halving of the steps, over the largest friction [1].
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
    """Compute the friction along a motion that stops, lifts off, or changes the rate of the memory.

    `times` (n,) [s].

    In the time theta = integral of rate dt each part of a memory has a constant rate of 1, so that the exact recursion
    of unequal steps applies. The memory of a new contact starts from 0. With a skin, its spring keeps at rest the force
    of the stop as long as that is below the sliding friction, and follows the sliding friction where that falls below;
    when the bone moves again, the spring is stretched by the distance of the bone until the skin slides. A skin that
    starts at rest is not stretched. Mass and damper of the skin are neglected there.
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
    """Return the friction of a sliding finger with memory [N] at times [s], and the weight of the rest in it [1]."""
    motion, force = scenario.motion, steady_at(grid)
    speeds = motion.speeds(grid) if motion.speed is not None else np.full(len(grid), math.nan)
    parts = _memory(scenario, speeds)
    start = steady_at(np.array([-1.0]))
    output, weight = force * (1 - sum(share for share, _ in parts)), np.zeros(len(grid))
    spans = resting(motion)
    for share, rate in parts:
        steps = np.diff(grid) * (rate[1:] + rate[:-1]) / 2
        theta = np.append(0.0, np.cumsum(steps))
        for first, last in _runs(motion.touches(grid)):
            if last - first == 1:
                continue
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


def _held_by_the_skin(motion: Motion, grid: Real, sliding: Real, stiffness: float) -> Real:
    """Return the friction with the force of the skin's spring [N/m] at rest and until sliding resumes [N]."""
    touches, rests = motion.touches(grid), motion.rests(grid)
    speeds = motion.speeds(grid)
    distance = np.append(0.0, np.cumsum(np.diff(grid) * (speeds[1:] + speeds[:-1]) / 2))
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
            pulled = held + stiffness * (distance[part] - distance[first])
            slips = np.maximum.accumulate(pulled >= sliding[part])
            output[part] = np.where(slips, sliding[part], pulled)
        held, was_at_rest = float(output[last - 1]), bool(kinds[first] == 1)
    return output


def shortest_time(drive: Drive) -> float:
    """Return the shortest time in which the attraction changes [s]: half a period of the drive's fastest oscillation."""
    fastest = drive.highest_frequency
    return 1 / (2 * fastest) if fastest else math.inf


def proportional_to_friction(scenario: Scenario, path: str) -> frozenset[str]:
    """Return the signals that are proportional to a parameter of the friction.

    The friction behind a memory, the motion of the skin and the readings of a sensor are linear filters of
    the friction of steady sliding.
    """
    friction, rig = scenario.friction, scenario.rig
    if friction.deflects:
        return frozenset()
    steady = "friction.steady" if friction.has_memory else "friction"
    parent, _, name = path.rpartition(".")
    if parent != steady or name not in friction.without_memory().proportional_to:
        return frozenset()
    if scenario.moisture is not None or scenario.motion.distance is not None or resting(scenario.motion):
        return frozenset()
    return frozenset() if rig is not None and rig.digitiser is not None else BEHIND_FRICTION
