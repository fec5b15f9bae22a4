"""Slow voltages whose force is a target: the inverse of root, leak and dispersion, within limits."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.study.check.series import plate_capacitance
from electrovib.study.design.drive.found import FoundDrive
from electrovib.study.design.drive.played import Played
from electrovib.study.design.drive.response import inverse_of, sample_response
from electrovib.study.design.drive.trade import BestFactor, Trade, best_factor
from electrovib.study.design.gain import carrier_gain, refuse_nonlinear

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario
    from electrovib.study.design.drive.limits import Bounds
    from electrovib.study.design.drive.response import SampleResponse
    from electrovib.study.design.drive.target import Target

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
