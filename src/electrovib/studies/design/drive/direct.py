"""Slow voltages whose force is a target: the regularised inverse of root, leak and dispersion, traded against the limits."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from electrovib.core.arrays import Indices, Real
from electrovib.core.errors import InputError
from electrovib.physics.limits import limited
from electrovib.scenario import Scenario
from electrovib.solve.electrics.attraction import attraction, total_pull
from electrovib.solve.stack.keys import AmplitudeOf
from electrovib.studies.check.series import plate_capacitance
from electrovib.studies.design.drive.carrier import FoundDrive, Played, carrier_gain, refuse_nonlinear
from electrovib.studies.design.drive.target import Target
from electrovib.studies.design.limits import Bounds, refuse_exceeded, worst_of

MOST_UNKNOWNS: Final = 80
"""Most values of the factor that are free; a choice."""
_LEVELS: Final = (1.0, math.sqrt(2 / 3))
"""Factors that are held from the beginning at a start of the search; the second gives the most where a charge is spent."""
_FEW_UNKNOWNS: Final = 16
"""Values of the factor up to which a search is quick, so that many of them are made."""
_PRIMES: Final = (2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0, 23.0, 29.0, 31.0, 37.0, 41.0, 43.0, 47.0, 53.0)
_EVEN: Final = 5
"""Starts that fill the range of the factor evenly."""
_AGREES: Final = 1.01
_HIGHEST: Final = 3.0
"""Largest factor [1]."""
_ITERATIONS: Final = 150
_PRECISION: Final = 1e-10


@dataclass(frozen=True, kw_only=True)
class Trade:
    """A force that is quadratic in a factor of each sample, with limits that are linear in it.

    From the factors, `knots` and `middles` give the root of the force at the samples and between them
    [N^(1/2)], and `bounded` quantities over their limits, between -1 and 1; `wanted` is the mean force over
    each interval.
    """

    knots: Real
    middles: Real
    wanted: Real
    bounded: Real

    @property
    def size(self) -> int:
        """Number of factors."""
        return int(self.knots.shape[1])

    def scale(self, factor: Real) -> float:
        """Return the largest multiple of the force of a factor that the limits allow [1]; infinite without limits."""
        reached = float(np.max(np.abs(self.bounded @ factor), initial=0.0))
        return 1 / reached**2 if reached else math.inf

    def means(self, factor: Real) -> Real:
        """Return the mean force over each interval [N] for factors at the samples [1]."""
        at, between = (self.knots @ factor) ** 2, (self.middles @ factor) ** 2
        return np.asarray((at[:-1] + 4 * between + at[1:]) / 6)

    def misfit(self, factor: Real) -> float:
        """Return the sum of squares of the departures over that of the target [1]."""
        return float(np.sum((self.means(factor) - self.wanted) ** 2) / np.sum(self.wanted**2))

    def slope(self, factor: Real) -> Real:
        """Return the derivative of `misfit` by the factors [1]."""
        at, between = self.knots @ factor, self.middles @ factor
        off = 2 * (self.means(factor) - self.wanted) / np.sum(self.wanted**2) / 6
        ends = np.append(off, 0.0) + np.append(0.0, off)
        return np.asarray(2 * ((ends * at) @ self.knots + (4 * off * between) @ self.middles))

    def reduced(self, spread: Real) -> Trade:
        """Return the same for fewer unknowns, from which `spread` (samples, unknowns) gives the factors."""
        return Trade(
            knots=self.knots @ spread,
            middles=self.middles @ spread,
            wanted=self.wanted,
            bounded=self.bounded @ spread,
        )


@dataclass(frozen=True, kw_only=True)
class BestFactor:
    """Factor of the amplitude at each sample with the smallest misfit, and how many of the searches agree on it."""

    factor: Real
    searches: int
    agreeing: int


def best_factor(trade: Trade, scale: float) -> BestFactor:
    """Return the factor of the amplitude at each sample that follows the target best within the limits.

    The misfit has local minima: parts of the target compete for the same charge and voltage. Sequential quadratic programming
    over at most 16 values of the factor therefore begins at several points, the same at each call; with more samples it is
    repeated over at most 80 values, from the first three starts and the best result for few values.
    """
    factor, misfits = _best(trade, scale, _FEW_UNKNOWNS, _further_starts)
    if len(factor) > _FEW_UNKNOWNS:
        factor, _ = _best(trade, scale, MOST_UNKNOWNS, lambda many: [_at_even_places(factor, many.size)])
    agreeing = int(np.sum(misfits <= _AGREES * np.min(misfits)))
    return BestFactor(factor=factor, searches=len(misfits), agreeing=agreeing)


def _best(trade: Trade, scale: float, most: int, further: Callable[[Trade], list[Real]]) -> tuple[Real, Real]:
    """Return the best factor that has so many free values at most, and the root misfit that each search has reached.

    Searches begin at the scaled target, at factors that are held from the beginning as long as the limits
    allow, and at further starts.
    """
    spread = _straight_lines(trade.size, min(trade.size, most))
    few = trade.reduced(spread)
    starts = [np.full(few.size, math.sqrt(scale)), *(_held(few, level) for level in _LEVELS), *further(few)]
    found = [_searched(few, start) for start in starts]
    best = min((*found, *(_within(few, start) for start in starts)), key=few.misfit)
    return np.asarray(spread @ best), np.sqrt([few.misfit(each) for each in found])


def _at_even_places(values: Real, count: int) -> Real:
    places = np.linspace(0, len(values) - 1, count)
    return np.interp(places, np.arange(len(values)), values)


def _straight_lines(size: int, count: int) -> Real:
    """Return the matrix from values at even places to straight lines between them, shape (size, count)."""
    places = np.linspace(0, size - 1, count)
    return np.array([np.interp(np.arange(size), places, row) for row in np.eye(count)]).T


def _within(trade: Trade, factor: Real) -> Real:
    """Return a factor scaled back into the limits."""
    return np.asarray(factor * min(1.0, math.sqrt(trade.scale(factor))))


def _searched(trade: Trade, start: Real) -> Real:
    """Return the local minimum of the misfit that a search from a start finds within the limits."""
    from scipy.optimize import minimize

    rows = np.concatenate([-trade.bounded, trade.bounded])
    rows = rows[np.any(rows != 0, axis=1)]
    found = minimize(
        trade.misfit,
        start,
        jac=trade.slope,
        method="SLSQP",
        bounds=[(0.0, _HIGHEST)] * len(start),
        constraints=[{"type": "ineq", "fun": lambda s: 1 + rows @ s, "jac": lambda _: rows}],
        options={"maxiter": _ITERATIONS, "ftol": _PRECISION},
    ).x
    return _within(trade, np.maximum(found, 0.0))


def _further_starts(trade: Trade) -> list[Real]:
    """Return factors that are held for a part of the time, and factors that fill the range evenly, within the limits."""
    count = trade.size
    share = (np.arange(count) + 0.5) / count
    parts = [(share > quarter / 4) & (share < (quarter + 1) / 4) for quarter in range(4)]
    parts += [share > 0.5, share > 0.25]
    # multiples of square roots of primes fill the range without repeating
    even = [(number * np.sqrt(_PRIMES[:count])) % 1.0 for number in range(1, _EVEN + 1)]
    return [_within(trade, np.asarray(each, dtype=float)) for each in (*parts, *even)]


def _held(trade: Trade, level: float) -> Real:
    """Return a factor that is held at a level [1] from the beginning as long as the limits allow, and is 0 after it."""
    held = level * np.tri(trade.size + 1, trade.size, -1)
    fits = np.max(np.abs(held @ trade.bounded.T), axis=1, initial=0.0) <= 1
    return np.asarray(held[np.argmin(np.append(fits, False)) - 1])


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
_TRIALS: Final = 8
_MARGIN: Final = 1e-6
_SMOOTH: Final = 1e-7
"""Weight of the second differences of the voltage over that of the amplitude of the force; a choice."""
_BESIDE: Final = 1e-3
"""Distance from a kink at which the current on either side of it is evaluated, over the interval."""


def design_direct(scenario: Scenario, target: Target, bounds: Bounds, *, rate: float | None) -> FoundDrive:
    """Design a slow voltage, from 0 V to 0 V, whose predicted force is the target.

    With the amplitude E = M v of the law at the samples and between them, linear and causal in the voltages v, and F = c E^2,
    the voltage minimises |M v - sqrt(F*/c)|^2 + w |second differences of v|^2: the penalty matters only where M has no stable
    inverse. The drive times the gain of an amplifier is held within the limit of the voltage, whatever its bandwidth. Where a
    limit binds, E = s sqrt(F*/c) with a factor s(t) of straight lines that minimises the mean square of F - F* under the limits.
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
    shrink, ceiling = 1 - _MARGIN, math.inf
    for _ in range(_TRIALS):
        trade = _trade(response, inverse * root, wanted, bounds, shrink=shrink, ceiling=ceiling)
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
        linear = worst_of({name: each for name, each in ratios.items() if name in response.bounded})
        shrink *= (1 - _MARGIN) / max(linear, 1 - _MARGIN)
        if linear < worst:  # the voltage is lowered for a limit of which the response says nothing
            ceiling = float(np.max(np.abs(values))) * (1 - _MARGIN) / worst
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
        volts = min(volts, ceiling / float(gain.peaks["voltage"][0]))
    amplifier = scenario.circuit.amplifier
    lag = scenario.circuit.element().resistance * plate_capacitance(scenario)
    if amplifier is not None and amplifier.bandwidth is not None:
        lag += 1 / (2 * math.pi * amplifier.bandwidth)
    times = [step, _LAGS * lag]
    for name, each in gain.peaks.items():
        limit = bounds.value(name)
        if limit is not None and limited(name).of_rate:
            times.append(float(each[0]) / (2 * math.pi * 1e3) * volts / (_LEAD_SHARE * limit))
    return math.ceil(max(times) / step * (1 - 1e-9))


def _trade(
    response: SampleResponse,
    exact: Real,
    wanted: Real,
    bounds: Bounds,
    *,
    shrink: float,
    ceiling: float,
) -> Trade:
    """Return the compromise between the target and the limits, for factors of the amplitude at the samples.

    Limits are multiplied by `shrink`, and the drive is not above the `ceiling` [V].
    """
    rows = [response.spread @ exact / ceiling] if math.isfinite(ceiling) else []
    for name, matrix in response.bounded.items():
        if (limit := bounds.value(name)) is not None:
            rows.append(matrix @ exact / (limit * shrink))
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
    - `bounded`: quantities that follow the samples linearly, by the name of their limit; currents on both sides of all samples.
    - `per_square`: force over the squared amplitude.
    """

    spread: Real
    knots: Real
    middles: Real
    bounded: Mapping[str, Real]
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
    gain = abs(played.base.circuit.supply.gain)
    return SampleResponse(
        spread=spread,
        knots=knots[window],
        middles=middles[lead : lead + count],
        bounded={
            "voltage": spread * gain,
            "current": _on_both_sides(amplified, at, total) @ spread,
            "body_current": _on_both_sides(found["current"], at, total) @ spread,
            "slew_rate": np.diff(spread, axis=0) * (gain * played.rate),
        },
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
