"""Error of a response in time due to the reduction of materials to Debye sums.

The change of a linear quantity is itself linear in the drive: D = declared - reduced, the first from impedances at
each frequency, the second from modes. D is fitted by signed relaxations on a fixed dense grid of rates, a linear
least-squares problem, and the response of that fit to the drive is the error. It does not depend on the fit of the
material.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.physics.drive.pieces import Linear
from electrovib.scenario import PeriodicState
from electrovib.solve.diagnostics.difference import _DifferenceFit
from electrovib.solve.diagnostics.judged import Judged, judge, judge_repeating
from electrovib.solve.electrics.attraction import attraction, total_pull
from electrovib.solve.electrics.linear.transient import transient
from electrovib.solve.electrics.wanted import linear_quantities
from electrovib.solve.stack.band import SAME, lowest_frequency, run_band
from electrovib.solve.stack.expand import left_by_charge, phasors
from electrovib.solve.stack.integrator import drive_mean, integral_weight
from electrovib.solve.stack.keys import AmplitudeOf
from electrovib.solve.stack.reduce import reduction_band
from electrovib.solve.stack.transfer import Transfer

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.physics.drive.base import Drive
    from electrovib.scenario import Scenario
    from electrovib.solve.electrics.solution import Solution
    from electrovib.solve.stack.keys import Key
    from electrovib.solve.stack.section import ModalSection

FORCE: Final = "force"
CURRENT: Final = "current"
SAFETY: Final = 1.5
"""Factor on the error found: for what the fit of D omits, and for what lies between two probes."""
SPREAD: Final = 3.0
"""Factor on the largest relative residual of the fit of D: what it may amount to in time."""
SMALLEST: Final = (1e-10, 1e-13)
"""Singular values over the largest below which a combination of relaxations is omitted from the fit of D; of the two fits the
one with the smaller residual is taken. A skin that loses its voltage exponentially needs the second: its D differs from 0 by
the place of one rate, which neighbouring rates of the grid express with large gains of both signs."""
MEASURED: Final = (1e-4,)
"""The same where a material is a measured table, whose noise relaxations cannot follow."""
PROBES: Final = 400
"""Output times at which the response of D is evaluated; between two of them the larger value counts."""
_GOLDEN: Final = 0.6180339887498949


def answer_errors(
    scenario: Scenario, section: ModalSection, answer: Solution, times: Real, *, known: tuple[float, float]
) -> dict[Key, Judged]:
    """Bound the error of a response in time due to the reduction of materials.

    `times` (n,) [s].

    The response of D = declared - reduced to the drive, times `SAFETY`, plus `SPREAD` times the relative
    residual of the fit of D over frequency.
    """
    low, high = run_band(scenario, times)
    low, high = reduction_band(low=low, high=high)
    low, high = max(low, known[0]), min(high, known[1])
    settled = isinstance(scenario.time.initial_state, PeriodicState)
    if settled and lowest_frequency(scenario) < known[0] * (1 - SAME):
        return {}
    lasts = 1 / (2 * np.pi * known[0]) if known[0] and not settled else np.inf
    judged = (times <= lasts) & ~_at_corner(scenario.drive, times, bends=False)
    if not low < high or not np.any(judged):
        return {}
    steady = settled and known[0] == 0 and bool(drive_mean(scenario.drive))
    fit = _DifferenceFit.over(low, high, steady=steady, smallest=MEASURED if known[0] else SMALLEST)
    differences, residuals = _differences(scenario, section, fit, settled=settled)
    probes = np.flatnonzero(judged)[_probes(int(np.count_nonzero(judged)))]
    found = {name: row for name, row in answer.found.items() if name in differences and row.ndim == 1}
    errors = _respond(scenario, differences, times[probes], settled=settled)
    bounds = {
        name: (row, SAFETY * np.abs(errors[name]) + SPREAD * residuals[name] * np.abs(row[probes]))
        for name, row in found.items()
    }
    amplitudes = {name: row[probes] for name, row in found.items() if isinstance(name, AmplitudeOf)}
    if amplitudes and scenario.force.causal:
        bounds[FORCE] = (answer.attraction, _of_force(scenario, times[probes], amplitudes, errors, residuals))
    straight = judged & ~_at_corner(scenario.drive, times, bends=True)
    return {
        name: judge(row, times, probes, bound, straight if name == CURRENT else judged)
        for name, (row, bound) in bounds.items()
    }


def errors_of_sines(
    members: Sequence[Scenario],
    section: ModalSection,
    answer: Solution,
    times: Real,
    *,
    known: tuple[float, float],
    respond: Callable[[dict[Key, Transfer]], dict[Key, Real]],
) -> list[dict[Key, Judged]]:
    """Bound the error of many responses of one stack, each to a sine in its periodic state.

    `times` (cases, n) [s].
    """
    scenario = members[0]
    low, high = run_band(scenario, times[0])
    low, high = reduction_band(low=low, high=high)
    low, high = max(low, known[0]), min(high, known[1])
    if not low < high:
        return [{} for _ in members]
    fit = _DifferenceFit.over(low, high, steady=False, smallest=MEASURED if known[0] else SMALLEST)
    differences, residuals = _differences(scenario, section, fit, settled=True)
    errors = respond(differences)
    bounds = {
        name: (row, SAFETY * np.abs(errors[name]) + SPREAD * residuals[name] * np.abs(row))
        for name, row in answer.found.items()
        if name in differences
    }
    amplitudes = {name: row for name, row in answer.found.items() if isinstance(name, AmplitudeOf)}
    if amplitudes and scenario.force.causal:
        bounds[FORCE] = (
            answer.attraction,
            _of_force(scenario, times.ravel(), amplitudes, errors, residuals),
        )
    judged = {
        name: judge_repeating(row.reshape(times.shape), times, bound.reshape(times.shape))
        for name, (row, bound) in bounds.items()
    }
    unknown = [lowest_frequency(each) < known[0] * (1 - SAME) for each in members]
    return [
        {} if unknown[case] else {name: found[case] for name, found in judged.items()}
        for case in range(len(members))
    ]


def _at_corner(drive: Drive, times: Real, *, bends: bool) -> NDArray[np.bool_]:
    """Return which output times are at a discontinuity of the drive, or with `bends` at any of its corners."""
    if bends and any(isinstance(part, Linear) and part.begins_with(times) for part in drive.parts()):
        return np.ones(len(times), bool)
    marks, heights = drive.corners(float(times[-1]))
    begins = [0.0] if bends or drive.voltage(0.0) else []
    corners = np.sort(np.append(marks if bends else marks[heights != 0], begins))
    near = SAME * corners
    first = np.searchsorted(times, corners - near, side="left")
    last = np.searchsorted(times, corners + near, side="right")
    found = np.zeros(len(times), bool)
    if np.all(last - first <= 1):
        found[first[last > first]] = True
    else:
        for begin, end in zip(first.tolist(), last.tolist(), strict=True):
            found[begin:end] = True
    return found


def _probes(count: int) -> NDArray[np.intp]:
    """Return indices of output times: all of few; of many a nearly even choice that is in step with no periodic drive."""
    if count <= PROBES:
        return np.arange(count)
    share = np.arange(PROBES)
    spread = (share + (share * _GOLDEN) % 1) / PROBES
    slow = np.geomspace(1, count - 1, PROBES // 5)  # the decay at the end, and the times after the beginning
    places = np.concatenate([[0, count - 1], np.floor(spread * count), slow])
    return np.unique(places.astype(np.intp))


def _of_force(
    scenario: Scenario,
    times: Real,
    amplitudes: Mapping[AmplitudeOf, Real],
    errors: Mapping[Key, Real],
    residuals: Mapping[Key, float],
) -> Real:
    """Bound the error of the attraction [N] at times [s] from the errors of the law's amplitudes."""
    now = {name.name: row for name, row in amplitudes.items()}
    off = {name.name: row + errors[name] for name, row in amplitudes.items()}
    pull = total_pull(scenario, now)
    force = attraction(scenario, pull, times)
    residual = 2 * max(residuals[name] for name in amplitudes)
    moved = np.abs(attraction(scenario, total_pull(scenario, off), times) - force)
    left = np.abs(
        attraction(scenario, pull * (1 + residual), times) - force
    )  # more where the area grows with it
    return np.asarray(SAFETY * moved + SPREAD * left)


def _respond(
    scenario: Scenario, transfers: dict[Key, Transfer], times: Real, *, settled: bool
) -> dict[Key, Real]:
    """Return the responses of linear quantities to the drive, without leaks, limits and motion."""
    amplifier, drive = scenario.circuit.amplifier, scenario.drive
    if amplifier is None or drive.quantity == "current":
        return transient(transfers, drive, times, settled=settled)
    if amplifier.is_limited:
        found = transient(transfers, drive, times)
        return {name: amplifier.gain * row for name, row in found.items()}
    from electrovib.solve.electrics.amplifier.amplifier import amplified_response

    return amplified_response(transfers, drive, times, amplifier=amplifier, settled=settled).found


def _differences(
    scenario: Scenario, section: ModalSection, fit: _DifferenceFit, *, settled: bool
) -> tuple[dict[Key, Transfer], dict[Key, float]]:
    """Return the fits of declared - reduced of every linear quantity, and their relative residuals."""
    declared = linear_quantities(scenario, phasors(scenario, fit.frequency, leaks=False))
    reduced = linear_quantities(scenario, section)
    reduced.pop("stack_voltage")  # the sum of the layer voltages, and 0 under a drive of 0 V
    transfers, residuals = {}, {}
    for name in reduced:
        # a current is the rate of change of its charge, which varies far less over frequency
        axis = 2j * np.pi * fit.frequency if name == CURRENT else 1.0
        pair = declared[name] / axis, reduced[name].at(fit.frequency) / axis
        unasked = name == CURRENT or bool(integral_weight(reduced[name]))
        found, residuals[name] = fit.of(*pair, unasked=unasked)
        transfers[name] = _slope(found) if name == CURRENT else found
    if settled or not np.any(section.modes.charges):
        return transfers, residuals
    left = linear_quantities(scenario, left_by_charge(scenario, fit.frequency, section.modes.charges))
    for name in reduced:
        found, residual = fit.of(left[name], reduced[name].free_at(fit.frequency))
        transfers[name] = replace(transfers[name], free=found.gains * found.rates)
        residuals[name] = max(residual, residuals[name])
    return transfers, residuals


def _slope(transfer: Transfer) -> Transfer:
    """Return the transfer function of the rate of change of a quantity: s times that of the quantity."""
    weights = transfer.gains * transfer.rates
    return Transfer(
        rates=transfer.rates, gains=-weights, direct=float(np.sum(weights)), slope=transfer.direct, static=0.0
    )
