"""Limits that a drive on the bench has to keep: those of scenario, bench and current limiter, the strictest of each."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity
from electrovib.physics.limits import Limits
from electrovib.study.check import LimitsFrom, cleared_for_output, declared_limits

if TYPE_CHECKING:
    from electrovib.bench.settings import BenchSettings
    from electrovib.scenario import Scenario
    from electrovib.study.check import CheckResult


_NOT_RELIED_ON: Final = ("bandwidth", "saturation", "source_current", "sink_current")
"""Parameters of an amplifier that reduce voltage or current, and are not those of the amplifier of the bench."""


def cleared(scenario: Scenario, settings: BenchSettings) -> tuple[Limits, CheckResult]:
    """Check the drive of a scenario against the strictest of all declared limits, or refuse it.

    Parameters
    ----------
    scenario : Scenario
        Whose drive is to be played, with its own limits if it declares any.
    settings : BenchSettings
        With limits and the current limiter.

    Returns
    -------
    limits : Limits
        The strictest of scenario, bench and current limiter; voltage and current are always declared.
    result : CheckResult
        In which no limit is exceeded and every declared one was compared.

    Raises
    ------
    InputError
        If the current limiter allows more than the smallest declared current; for every limit that is exceeded or could not be
        compared.
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
    amplifier = scenario.circuit.amplifier
    consequence = "Nothing is played"
    if amplifier is not None and (amplifier.is_limited or amplifier.bandwidth is not None):
        consequence += (
            ". On the bench saturation, current limit and bandwidth of circuit.amplifier do not count"
        )
        scenario = scenario.replace({f"circuit.amplifier.{name}": None for name in _NOT_RELIED_ON})
    result = cleared_for_output(scenario, limits=places, what="a burst on the bench", consequence=consequence)
    strict = declared_limits(scenario, places)
    return Limits(**{name: each.value for name, each in strict.items()}), result
