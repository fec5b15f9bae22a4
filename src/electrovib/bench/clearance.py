"""Limits that a drive on the bench has to keep: those of scenario, bench and current limiter, the strictest of each."""

from __future__ import annotations

from typing import TYPE_CHECKING

from electrovib.core.diagnostics import read_diagnostics
from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity
from electrovib.physics.limits import WORDS, Limits, broken
from electrovib.solve.simulate import simulate

if TYPE_CHECKING:
    import xarray

    from electrovib.bench.settings import BenchSettings
    from electrovib.scenario import Scenario


def strictest(scenario: Scenario, settings: BenchSettings) -> Limits:
    """Combine the limits of scenario, bench and current limiter; of each quantity the smallest counts.

    Parameters
    ----------
    scenario : Scenario
        With its own limits, if it declares any.
    settings : BenchSettings
        With limits and the current limiter.

    Returns
    -------
    Limits
        Voltage and current are always declared.

    Raises
    ------
    InputError
        If the current limiter allows more than the smallest declared current.
    """
    found = {}
    for name in WORDS:
        values = [getattr(each, name) for each in (scenario.limits, settings.limits)]
        declared = [value for value in values if value is not None]
        found[name] = min(declared) if declared else None
    largest, hardware = found["current"], settings.current_limiter.current
    assert largest is not None
    if hardware > largest:
        raise InputError(
            f"current_limiter.current = {format_quantity(hardware, 'A')}: '{settings.current_limiter.name}' allows more than"
            f" the largest current that is declared, {format_quantity(largest, 'A')} (limits.current): software alone does not"
            " protect; set the hardware to that value, or declare a larger limit"
        )
    return Limits(**(found | {"current": min(largest, hardware)}))


def refuse_exceeding(scenario: Scenario, limits: Limits) -> xarray.Dataset:
    """Compute the response to a drive and refuse it if it exceeds a limit, or if a limit cannot be judged.

    Parameters
    ----------
    scenario : Scenario
        Whose drive is to be played.
    limits : Limits
        As from `strictest`.

    Returns
    -------
    xarray.Dataset
        The predicted Trace.

    Raises
    ------
    InputError
        With one sentence for each limit.
    """
    trace = simulate(scenario.replace({"limits": limits.to_dict()}))
    diagnostics = read_diagnostics(str(trace.attrs["validity"]))
    problems = [each.text for each in broken(diagnostics)]
    names = {name.replace("_", " ") for name, value in limits if value is not None}
    problems += [
        f"{each.name} cannot be judged: {each.text}"
        for each in diagnostics
        if each.name in names and each.state == "unknown"
    ]
    judged = {each.name for each in diagnostics}
    problems += [
        f"{name} was not judged for this scenario" for name in ("voltage", "current") if name not in judged
    ]
    if problems:
        raise InputError(f"the drive is not played: {each}" for each in problems)
    return trace
