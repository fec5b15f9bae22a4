"""Slow voltages whose force is a target: the regularised inverse of root, leak and dispersion, within limits."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.solve.electrics.attraction import attraction, total_pull
from electrovib.solve.stack.keys import AmplitudeOf
from electrovib.studies.check.series import plate_capacitance
from electrovib.studies.design.drive.played import FoundDrive, Played
from electrovib.studies.design.drive.trade import BestFactor, Trade, best_factor
from electrovib.studies.design.gain import carrier_gain, refuse_nonlinear
from electrovib.studies.design.limits import Bounds, refuse_exceeded, worst_of

if TYPE_CHECKING:
    from electrovib.core.arrays import Indices, Real
    from electrovib.scenario import Scenario
    from electrovib.studies.design.drive.target import Target

INTERVALS: Final = 40
"""Intervals between samples in a period of the highest frequency of the target; a choice."""
FEWEST: Final = 200
MOST: Final = 1500
"""Fewest and most intervals that are chosen for a target."""
MOST_GIVEN: Final = 4000
"""Most intervals at a given rate: the inverse is a matrix of that size."""
_LEAD_SHARE: Final = 0.5
"""Share of the limits of current and slew rate that the ramps at both ends may take."""
_ROUNDED: Final = 1e-3
_LAGS: Final = 5.0
"""Duration of the ramps over the lag of series resistance and amplifier, at least."""
_TRIALS: Final = 4
_MARGIN: Final = 1e-6
_SMOOTH: Final = 1e-7
"""Weight of the second differences of the voltage over that of the amplitude of the force; a choice."""
_BESIDE: Final = 1e-3
"""Distance from a kink at which the current on either side of it is evaluated, over the interval."""


def design_direct(scenario: Scenario, target: Target, bounds: Bounds, *, rate: float | None) -> FoundDrive:
    """Design a slow voltage, from 0 V to 0 V, whose predicted force is the target.

    With the amplitude E = M v of the law at the samples and between them, linear and causal in the voltages
    v, and F = c E^2, the voltage minimises |M v - sqrt(F*/c)|^2 + w |second differences of v|^2: the penalty
    matters only where M has no stable inverse. The drive times the gain of an amplifier is held within the
    limit of the voltage, whatever its bandwidth. Where a limit binds, E = s sqrt(F*/c) with a factor s(t) of
    straight lines that minimises the mean square of F - F* over the target under the limits. A law with more
    than one amplitude is refused.
    """
    refuse_nonlinear(scenario)
    _refuse_charge(scenario)
    count = _intervals(target, rate)
    played = Played(scenario, count / target.duration if rate is None else rate)
    step = 1 / played.rate
    edges = played.times(count + 1)
    wanted = target.means(edges)
    response = sample_response(played, count, 1)
    root = np.sqrt(target.force(edges) / response.per_square)
    inverse = inverse_of(response)
    lead = _lead(scenario, bounds, step, volts=float(np.max(np.abs((inverse @ root)[[0, -1]]))))
    if lead > 1:
        response = sample_response(played, count, lead)
        inverse = inverse_of(response)
    shrink = 1 - _MARGIN
    for _ in range(_TRIALS):
        trade = _trade(response, inverse * root, wanted, bounds, scenario, step, shrink)
        scale = trade.scale(np.ones(len(root)))
        best = BestFactor(factor=np.ones(len(root)), searches=0, agreeing=0)
        if scale < 1:
            best = best_factor(trade, scale)
        factor = best.factor
        values = response.spread @ (inverse @ (root * factor))
        values = _tidied(values)
        ratios = bounds.overload(played.scenario(values))
        if (worst := worst_of(ratios)) <= 1:
            break
        shrink *= (1 - _MARGIN) / worst
    refuse_exceeded(ratios, "voltage")
    if "voltage" in ratios and (amplifier := scenario.circuit.amplifier) is not None:
        limit = bounds.declared["voltage"].value
        ratios["voltage"] = max(
            ratios["voltage"], abs(amplifier.gain) * float(np.max(np.abs(values))) / limit
        )
    force = played.force(values)
    return FoundDrive(
        times=played.times(len(values)),
        rate=played.rate,
        values=values,
        edges=edges + lead * step,
        wanted=wanted,
        predicted=played.means(force, lead, count, 1),
        carrier=None,
        scale=scale,
        limited=np.abs(factor - 1) > 1e-3,
        ratios=ratios,
        searches=best.searches,
        agreeing=best.agreeing,
    )


def _tidied(values: Real) -> Real:
    """Return samples without the rounding below 0 V, from 0 V to 0 V."""
    found = np.where((values < 0) & (values > -_ROUNDED * np.max(values)), 0.0, values)
    found[[0, -1]] = 0.0
    return found


def _refuse_charge(scenario: Scenario) -> None:
    """Refuse a charge at time 0, whose force the drive does not cause."""
    charged = [name for name, layer in scenario.stack.layers.items() if layer.initial_charge]
    if charged or scenario.circuit.element().charge:
        where = f"stack.{charged[0]}.initial_charge" if charged else "circuit.return_path.charge"
        raise InputError(
            "has to be 0 for method 'dc', whose force is that of the drive alone; neutralise it, or take method 'carrier'",
            path=where,
        )


def _intervals(target: Target, rate: float | None) -> int:
    if rate is None:
        return int(np.clip(math.ceil(INTERVALS * target.duration * target.highest_frequency), FEWEST, MOST))
    count = math.ceil(target.duration * rate * (1 - 1e-9))
    if not 2 <= count <= MOST_GIVEN:
        why = f"gives {count} intervals for {target.duration:g} s, and 2 to {MOST_GIVEN} are allowed with method 'dc'"
        raise InputError(why, path="rate", value=f"{rate:g}")
    return count


def _lead(scenario: Scenario, bounds: Bounds, step: float, *, volts: float) -> int:
    """Return the number of intervals of the ramps: several lags of the circuit, within a share of current and slew rate."""
    gain = carrier_gain(scenario, [1e3])
    ceiling = bounds.value("voltage")
    if ceiling is not None:
        volts = min(volts, ceiling / float(gain.voltage[0]))
    amplifier = scenario.circuit.amplifier
    lag = scenario.circuit.element().resistance * plate_capacitance(scenario)
    if amplifier is not None and amplifier.bandwidth is not None:
        lag += 1 / (2 * math.pi * amplifier.bandwidth)
    times = [step, _LAGS * lag]
    for name, each in (("current", gain.current), ("body_current", gain.body_current)):
        limit = bounds.value(name)
        if limit is not None:
            times.append(float(each[0]) / (2 * math.pi * 1e3) * volts / (_LEAD_SHARE * limit))
    slew = bounds.slew(scenario)
    if slew is not None:
        times.append(volts / (_LEAD_SHARE * slew))
    return math.ceil(max(times) / step * (1 - 1e-9))


def _trade(
    response: SampleResponse,
    exact: Real,
    wanted: Real,
    bounds: Bounds,
    scenario: Scenario,
    step: float,
    shrink: float,
) -> Trade:
    """Return the compromise between the target and the limits, for factors of the amplitude at the samples."""
    gain = abs(scenario.circuit.supply.gain)
    rows = []
    volts = response.spread @ exact
    for name, matrix in (
        ("voltage", volts * gain),
        ("current", response.currents @ exact),
        ("body_current", response.body_currents @ exact),
        ("slew_rate", np.diff(volts, axis=0) * (gain / step)),
    ):
        limit = bounds.value(name)
        if limit is not None:
            rows.append(matrix / (limit * shrink))
    return Trade(
        knots=response.knots @ exact * math.sqrt(response.per_square),
        middles=response.middles @ exact * math.sqrt(response.per_square),
        wanted=wanted,
        bounded=np.concatenate(rows) if rows else np.zeros((0, exact.shape[1])),
    )


@dataclass(frozen=True, kw_only=True)
class SampleResponse:
    """Linear response to the samples of a drive in the window of the target, its ramps of `lead` intervals included.

    - `spread`, shape (samples, unknowns): all samples from those in the window.
    - `knots`, `middles`, shapes (intervals + 1, unknowns) and (intervals, unknowns): amplitude of the force
      law at the samples of the window and between them, in its unit per volt.
    - `currents`, `body_currents`: of amplifier and finger on both sides of all samples [A/V].
    - `per_square`: force over the squared amplitude.
    """

    spread: Real
    knots: Real
    middles: Real
    currents: Real
    body_currents: Real
    per_square: float


def sample_response(played: Played, count: int, lead: int) -> SampleResponse:
    """Return the linear response to the samples in a window of `count` intervals, from the response to one hat."""
    total = count + 2 * lead
    hat = np.zeros(total + 1)
    hat[1] = 1.0
    beside = _BESIDE / played.rate
    times = np.unique(
        np.concatenate(
            [played.halves(total + 1), (times := played.times(total + 1))[1:] - beside, times[:-1] + beside]
        )
    )
    record = played.expanded(hat).at(times)
    amplitudes = {key: row for key, row in record.solution.found.items() if isinstance(key, AmplitudeOf)}
    if len(amplitudes) != 1:
        law = type(played.base.force).__name__
        raise InputError(
            f"{law} has {len(amplitudes)} amplitudes, and method 'dc' inverts one; use a law with the field in the gap, or"
            " method 'carrier'"
        )
    (key, row), found = next(iter(amplitudes.items())), record.solution.found
    per_square = float(attraction(played.base, total_pull(played.base, {key.name: np.array([1.0])}))[0])
    spread = _spread(count, lead)
    at = np.searchsorted(times, played.halves(total + 1) - 1e-9 / played.rate)
    knots = _shifted(row[at[::2]], total) @ spread
    middles = _shifted(row[at[1::2]], total)[:total] @ spread
    window = slice(lead, lead + count + 1)
    amplified = found.get("amplifier_current", found["current"])
    return SampleResponse(
        spread=spread,
        knots=knots[window],
        middles=middles[lead : lead + count],
        currents=_on_both_sides(amplified, at, total) @ spread,
        body_currents=_on_both_sides(found["current"], at, total) @ spread,
        per_square=per_square,
    )


def _on_both_sides(row: Real, at: Indices, total: int) -> Real:
    """Return the matrix from all samples to a current before and after each sample."""
    before = np.append(0.0, row[at[2::2] - 1])
    after = np.append(row[at[:-1:2] + 1], 0.0)
    return np.concatenate([_shifted(before, total), _shifted(after, total)[:-1]])


def _shifted(row: Real, total: int) -> Real:
    """Return the matrix whose column i is the response to a hat at sample i, from that at sample 1; column 0 is 0."""
    from scipy.linalg import toeplitz

    first = np.zeros(total + 1)
    first[0] = row[0]
    matrix = np.zeros((len(row), total + 1))
    matrix[:, 1:] = toeplitz(row, first)[:, :total]
    return matrix


def _spread(count: int, lead: int) -> Real:
    """Return the matrix from the samples of the window to all samples, with straight ramps from and to 0 V."""
    spread = np.zeros((count + 2 * lead + 1, count + 1))
    ramp = np.arange(lead + 1) / lead
    spread[lead : lead + count + 1] = np.eye(count + 1)
    spread[: lead + 1, 0] = ramp
    spread[lead + count :, -1] = ramp[::-1]
    return spread


def inverse_of(response: SampleResponse) -> Real:
    """Return the regularised inverse of a response, from amplitudes at the samples to their voltages.

    The amplitude between two samples is to be the mean of both, so that no oscillation between them is free.
    """
    from scipy.linalg import cho_factor, cho_solve

    size = response.knots.shape[1]
    matrix = np.concatenate([response.knots, response.middles])
    halves = (np.eye(size)[:-1] + np.eye(size)[1:]) / 2
    weight = (_SMOOTH * float(np.max(np.abs(matrix)))) ** 2
    second = np.diff(np.eye(size), n=2, axis=0) if size > 2 else np.zeros((1, size))
    factor = cho_factor(matrix.T @ matrix + weight * (second.T @ second))
    return np.asarray(cho_solve(factor, matrix.T @ np.concatenate([np.eye(size), halves])))
