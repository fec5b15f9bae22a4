"""Check of samples as an output plays them: held, with edges between the levels, and without the scenario's amplifier."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.core.units import format_quantity
from electrovib.physics.drive.held import Held
from electrovib.studies.check.drive import sampled, with_drive
from electrovib.studies.check.function import cleared_for_output, declared_limits, holds_limits

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario
    from electrovib.studies.check.declared import LimitsSource
    from electrovib.studies.check.result import CheckResult

REDUCING: Final = ("bandwidth", "saturation", "source_current", "sink_current")
"""Parameters of an amplifier that reduce voltage or current."""
_SHORTEST: Final = 1e-9
"""Shortest edge that is sought, over the interval between two samples."""
_RESISTANCES: Final = (1.0, 1e10)
"""Range in which a series resistor is sought [ohm]."""
_CLOSE: Final = 1.01
"""Ratio of the bounds at which a search ends."""


def without_its_limits(scenario: Scenario) -> Scenario:
    """Return a scenario whose amplifier, if it has one, reduces neither voltage nor current."""
    amplifier = scenario.circuit.amplifier
    if amplifier is None or not (amplifier.is_limited or amplifier.bandwidth is not None):
        return scenario
    return scenario.replace({f"circuit.amplifier.{name}": None for name in REDUCING})


def cleared_as_played(
    scenario: Scenario,
    *,
    times: Real,
    voltages: Real,
    edge: float | None,
    declare: str,
    limits: LimitsSource | Sequence[LimitsSource] = None,
    what: str,
    name: str,
    consequence: str = "Nothing was written",
) -> CheckResult:
    """Check samples that are held from one to the next, or refuse them with the filter or resistor that helps.

    The samples are evenly spaced from 0. `edge` is the height of a step over its steepest slope [s], at most
    their interval; None is 0, with `declare` in the message.
    """
    interval, declared = float(np.min(np.diff(times))), declared_limits(scenario, limits)

    def under(lasting: float, resistance: float | None = None) -> Scenario:
        table = {"samples": sampled(times, voltages), "edge": min(lasting, interval)}
        found = with_drive(scenario, read_model(Held, table))
        return found if resistance is None else found.replace({"circuit.source_resistance": resistance})

    def holds(lasting: float, resistance: float | None = None) -> bool:
        return holds_limits(under(lasting, resistance), declared)

    try:
        return cleared_for_output(
            under(edge or 0.0), limits=limits, what=what, name=name, consequence=consequence
        )
    except InputError as error:
        if not holds(interval):
            raise
        played = (
            "no edge is declared, so that they follow each other as steps"
            if edge is None
            else f"the declared edge takes {format_quantity(edge, 's', digits=4)}"
        )
        shortest = _smallest(holds, _SHORTEST * interval, interval)
        pole = _two_digits(1 / (2 * math.pi * shortest), math.floor)
        held, takes = (format_quantity(each, "s", digits=4) for each in (interval, shortest))
        remedy = (
            f"{name} are held for {held} each, and {played}. A filter in front of the plate whose edge takes at least {takes},"
            f" such as one pole at {format_quantity(pole, 'Hz', digits=3)} or below, would hold the limits"
        )
        resistance = _smallest(lambda value: holds(edge or 0.0, value), *_RESISTANCES)
        if resistance < _RESISTANCES[1]:
            remedy += (
                f"; so would a resistor of {format_quantity(resistance, 'ohm', digits=3)} between amplifier and plate"
                " (circuit.source_resistance)"
            )
        raise InputError([*error.problems, f"{remedy}. {declare}"]) from None


def _smallest(holds: Callable[[float], bool], low: float, high: float) -> float:
    """Return the smallest value that holds the limits, rounded up to two digits; the highest if none below it does."""
    if not holds(high):
        return high
    top = high
    while high > _CLOSE * low:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if holds(middle) else (middle, high)
    return min(_two_digits(high, math.ceil), top)


def _two_digits(value: float, rounding: Callable[[float], int]) -> float:
    step = 10.0 ** (math.floor(math.log10(value)) - 1)
    return rounding(value / step) * step
