"""Limits that a drive on the bench has to keep: those of scenario, bench and current limiter, the strictest of each."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity
from electrovib.physics.limits import Limits
from electrovib.study.check import LimitsFrom, cleared_as_played, declared_limits, without_its_limits

if TYPE_CHECKING:
    from electrovib.bench.settings import BenchSettings
    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario
    from electrovib.study.check import CheckResult


_DECLARE: Final = (
    "Declare it in the bench file with its source:"
    ' [edge] time = "10 us" source = "filter in front of the plate, measured"'
)


def cleared(
    scenario: Scenario, settings: BenchSettings, times: Real, voltages: Real
) -> tuple[Limits, CheckResult]:
    """Check what the generator plays against the strictest of all declared limits, or refuse it.

    `times` (n,) [s] at which the points of the generator begin, and their `voltages` (n,) [V] at the input of
    the scenario's amplifier. The limits are the strictest of scenario, bench and current limiter; voltage and
    current are always declared. Refused are a current limiter that allows more than the smallest declared
    current, and every limit that is exceeded or could not be compared.
    """
    limiter = settings.current_limiter
    places = [LimitsFrom("the bench", settings.limits)]
    declared = declared_limits(scenario, places)["current"]
    if limiter.current > declared.value:
        raise InputError(
            f"current_limiter.current = {format_quantity(limiter.current, 'A')}: '{limiter.name}' allows more than the largest"
            f" current that is declared, {format_quantity(declared.value, 'A')} ({declared.source}); software alone does not"
            " protect: set the hardware to that value, or declare a larger limit"
        )
    places.append(LimitsFrom(f"the current limiter ({limiter.name})", Limits(current=limiter.current)))
    consequence, relied_on = "Nothing is played", without_its_limits(scenario)
    if relied_on is not scenario:
        consequence += (
            ". On the bench saturation, current limit and bandwidth of circuit.amplifier do not count"
        )
    result = cleared_as_played(
        relied_on, times=times, voltages=voltages, edge=None if settings.edge is None else settings.edge.time, declare=_DECLARE,
        limits=places, what="a burst on the bench", name="the points of the generator", consequence=consequence,
    )  # fmt: skip
    strict = declared_limits(scenario, places)
    return Limits(**{name: each.value for name, each in strict.items()}), result
