"""Slow voltages whose force is a target: the inverse of root, leak and dispersion, within limits."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from scipy.linalg import cho_factor, cho_solve, toeplitz

from electrovib.core.errors import InputError
from electrovib.solve.electrics.attraction import attraction, total_pull
from electrovib.solve.stack.keys import AmplitudeOf
from electrovib.study.check.series import plate_capacitance
from electrovib.study.design.drive.played import Played
from electrovib.study.design.drive.solution import Solution
from electrovib.study.design.drive.trade import Trade, best_factor
from electrovib.study.design.gain import carrier_gain, refuse_nonlinear

if TYPE_CHECKING:
    from electrovib.core.arrays import Indices, Real
    from electrovib.scenario import Scenario
    from electrovib.study.design.drive.limits import Bounds
    from electrovib.study.design.drive.target import Target

INTERVALS: Final = 40
"""Intervals between samples in a period of the highest frequency of the target; a choice."""
FEWEST: Final = 200
MOST: Final = 1500
"""Fewest and most intervals that are chosen for a target."""
MOST_GIVEN: Final = 4000
"""Most intervals at a given rate: the inverse is a matrix of that size."""
_SMOOTH: Final = 1e-7
"""Weight of the second differences of the voltage over that of the amplitude of the force; a choice."""
_BESIDE: Final = 1e-3
"""Distance from a kink at which the current on either side of it is evaluated, over the interval."""
_LEAD_SHARE: Final = 0.5
"""Share of the limits of current and slew rate that the ramps at both ends may take."""
_ROUNDED: Final = 1e-3
_LAGS: Final = 5.0
"""Duration of the ramps over the lag of series resistance and amplifier, at least."""
_TRIALS: Final = 4
_MARGIN: Final = 1e-6


@dataclass(frozen=True, kw_only=True)
class Response:
    """Linear response to the samples of a drive in the window of the target, its ramps at both ends included.

    Parameters
    ----------
    lead : int
        Intervals of the ramps before and after the window.
    spread : ndarray, shape (samples, unknowns)
        All samples from those in the window.
    knots, middles : ndarray, shape (intervals + 1, unknowns) and (intervals, unknowns)
        Amplitude of the force law at the samples of the window, and between them, in its unit per volt.
    currents : ndarray, shape (rows, unknowns)
        Current of the amplifier on both sides of all samples [A/V].
    body_currents : ndarray, shape (rows, unknowns)
        The same through the finger [A/V].
    per_square : float
        Force over the squared amplitude, in N over the square of its unit.
    """

    lead: int
    spread: Real
    knots: Real
    middles: Real
    currents: Real
    body_currents: Real
    per_square: float


def design_direct(scenario: Scenario, target: Target, bounds: Bounds, *, rate: float | None) -> Solution:
    """Design a slow voltage whose predicted force is the target.

    Parameters
    ----------
    scenario : Scenario
        With a linear stack, under a voltage.
    target : Target
        Force over time.
    bounds : Bounds
        Limits that the drive holds.
    rate : float or None
        Samples per second [Hz]; chosen if None.

    Returns
    -------
    Solution
        Samples from 0 V to 0 V, with ramps before and after the target.

    Raises
    ------
    InputError
        If the force law has more than one amplitude, or the limits cannot be held.

    Notes
    -----
    With the amplitude E = M v of the law at the samples and between them, linear and causal in the voltages v, and F = c E^2,
    the voltage minimises |M v - sqrt(F*/c)|^2 + w |second differences of v|^2: the penalty matters only where M has no stable
    inverse.
    The drive times the gain of an amplifier is held within the limit of the voltage, whatever its bandwidth. Where a limit
    binds, E = s sqrt(F*/c) with a factor s(t) of straight lines that minimises the mean square of F - F* over
    the target under the limits.
    """
    refuse_nonlinear(scenario)
    _refuse_charge(scenario)
    count = _intervals(target, rate)
    played = Played(scenario, count / target.duration if rate is None else rate)
    step = 1 / played.rate
    edges = played.times(count + 1)
    wanted = target.means(edges)
    response = _response(played, count, 1)
    root = np.sqrt(target.force(edges) / response.per_square)
    inverse = _inverse(response)
    lead = _lead(scenario, bounds, step, volts=float(np.max(np.abs((inverse @ root)[[0, -1]]))))
    if lead > 1:
        response = _response(played, count, lead)
        inverse = _inverse(response)
    shrink = 1 - _MARGIN
    for _ in range(_TRIALS):
        trade = _trade(response, inverse * root, wanted, bounds, scenario, step, shrink)
        scale = trade.scale(np.ones(len(root)))
        factor = np.ones(len(root)) if scale >= 1 else best_factor(trade, scale)
        values = response.spread @ (inverse @ (root * factor))
        values = _tidied(values)
        ratios = bounds.overload(played.scenario(values))
        worst = max((each for each in ratios.values() if not math.isnan(each)), default=0.0)
        if worst <= 1:
            break
        shrink *= (1 - _MARGIN) / worst
    if worst > 1:
        over = ", ".join(f"limits.{name}" for name, each in ratios.items() if each > 1)
        raise InputError(f"no voltage was found that holds {over}; raise the limit or lower the target")
    if "voltage" in ratios and (amplifier := scenario.circuit.amplifier) is not None:
        limit = bounds.declared["voltage"].value
        ratios["voltage"] = max(
            ratios["voltage"], abs(amplifier.gain) * float(np.max(np.abs(values))) / limit
        )
    force = played.force(values)
    return Solution(
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


def _response(played: Played, count: int, lead: int) -> Response:
    """Return the linear response to the samples in a window, from the response to one hat."""
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
    return Response(
        lead=lead,
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
    """Return the matrix from samples to a response, whose column i is the response to a hat at sample i.

    Parameters
    ----------
    row : ndarray, shape (n,)
        Response to the hat at sample 1, in any unit.
    total : int
        Number of intervals.

    Returns
    -------
    matrix : ndarray, shape (n, total + 1)
        In the same unit per volt; the column of sample 0, which is 0 V, is 0.
    """
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


def _inverse(response: Response) -> Real:
    """Return the regularised inverse of a response, from the amplitude at the samples to their voltages.

    The amplitude between two samples is to be the mean of both, so that no oscillation between samples is free.
    """
    size = response.knots.shape[1]
    matrix = np.concatenate([response.knots, response.middles])
    halves = (np.eye(size)[:-1] + np.eye(size)[1:]) / 2
    weight = (_SMOOTH * float(np.max(np.abs(matrix)))) ** 2
    second = np.diff(np.eye(size), n=2, axis=0) if size > 2 else np.zeros((1, size))
    factor = cho_factor(matrix.T @ matrix + weight * (second.T @ second))
    return np.asarray(cho_solve(factor, matrix.T @ np.concatenate([np.eye(size), halves])))


def _trade(
    response: Response,
    exact: Real,
    wanted: Real,
    bounds: Bounds,
    scenario: Scenario,
    step: float,
    shrink: float,
) -> Trade:
    """Return the compromise between the target and the limits, for factors of the amplitude at the samples."""
    amplifier = scenario.circuit.amplifier
    gain = 1.0 if amplifier is None else abs(amplifier.gain)
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
