"""Diagnostics of the error that the representation of materials causes, and of the time from which a result is unknown."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.units import format_quantity
from electrovib.solve.diagnostics.memory import CURRENT, FORCE, LARGEST
from electrovib.solve.stack.reduce import SAME, lowest_frequency, shortest_time

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Real
    from electrovib.physics.force import ForceLaw
    from electrovib.scenario import Scenario
    from electrovib.solve.diagnostics.memory import Judged
    from electrovib.solve.electrics.solution import Method
    from electrovib.solve.stack.keys import Key
    from electrovib.solve.stack.section import ModalSection, PhasorSection


def known_band(scenario: Scenario) -> tuple[float, float]:
    """Return the band in which the permittivities of all layers are known."""
    bands = [layer.material.band for layer in scenario.stack.layers.values()]
    return max(low for low, _ in bands), min(high for _, high in bands)


def memory_diagnostics(
    scenario: Scenario,
    errors: Mapping[Key, Judged],
    times: Real,
    *,
    known: tuple[float, float],
    method: Method,
) -> list[Diagnostic]:
    """Return the error of a response in time due to the Debye sums of materials, and the time from which it is unknown.

    `times` (n,) [s].
    """
    layers = scenario.stack.layers
    reduced = [name for name, layer in layers.items() if layer.material.debye() is None]
    if not reduced:
        return []
    return [*_of_error(reduced, errors, method, times, known), *_beyond_tables(scenario, times, known)]


def worst_of(errors: Mapping[Key, Judged]) -> float:
    """Return the largest relative error of fields, voltages and attraction [1]; that of the current is reported apart."""
    return max((found.error for name, found in errors.items() if name != CURRENT), default=0.0)


def attraction_error(errors: Mapping[Key, Judged]) -> dict[str, float]:
    """Return the largest error of the attraction over its peak [1] by its name in a Trace; empty where it is not known."""
    return {"attraction_error": errors[FORCE].of_peak} if FORCE in errors else {}


def _of_error(
    reduced: list[str],
    errors: Mapping[Key, Judged],
    method: Method,
    times: Real,
    known: tuple[float, float],
) -> list[Diagnostic]:
    if not errors:
        return []
    names = " and ".join(f"'{name}'" for name in reduced)
    judged = {name: found for name, found in errors.items() if name != CURRENT}
    largest = {"fields and voltages": max(found.of_peak for name, found in judged.items() if name != FORCE)}
    largest |= {
        what: errors[name].of_peak
        for name, what in ((FORCE, "the attraction"), (CURRENT, "the current"))
        if name in errors
    }
    parts = ", ".join(f"{what} by at most {100 * error:.2g} %" for what, error in largest.items())
    change = f"{parts} of their peak"
    stands = f"{names} {'is' if len(reduced) == 1 else 'are'} represented by a sum of Debye relaxations"
    if not method.by_modes:  # else the error found bounds the response, which is linear in the drive
        text = (
            f"{stands}: without leak, motion, limits and renewal that changes {change};"
            f" its effect on the result of the solver '{method.name}' is not known"
        )
        return [Diagnostic("memory", "unknown", text)]
    text = f"{stands}, which changes {change}"
    share, lost = max(found.share for found in judged.values()), min(found.lost for found in judged.values())
    if np.isfinite(lost):
        first = next(name for name, found in judged.items() if found.lost == lost)
        called = first.replace("_", " ") if isinstance(first, str) else str(first)
        text += (
            f"; the {called} is not known to {100 * LARGEST:g} % of its remaining amplitude from"
            f" {format_quantity(lost, 's', digits=3)} on"
        )
        if np.isfinite(known[1]):
            text += f"; {_better_table(times, known)}"
    state = "warning" if np.isfinite(lost) else "ok"
    return [Diagnostic("memory", state, text, value=share, limit=LARGEST, unit="1")]


def _better_table(times: Real, known: tuple[float, float]) -> str:
    """State how a table has to be measured so that the response of a run is known."""
    lowest = min(known[0], 1 / (2 * np.pi * float(times[-1])))
    ends = " to ".join(format_quantity(end, "Hz", digits=3) for end in (lowest, known[1]))
    return f"measure the table from {ends} with three rows a decade or more, or fit a dispersion to it (electrovib fit)"


def _beyond_tables(scenario: Scenario, times: Real, known: tuple[float, float]) -> list[Diagnostic]:
    """Return which times of a response depend on frequencies outside the tables of materials."""
    (low, high), said = known, []
    last = 1 / (2 * np.pi * low) if low else np.inf
    first = 1 / (2 * np.pi * high)
    if scenario.time.settled:
        slowest = lowest_frequency(scenario)
        if slowest < low * (1 - SAME):
            said.append(f"the drive contains {format_quantity(slowest, 'Hz', digits=3)}, below the table")
    elif times[-1] > last:
        said.append(f"the response is not known from {format_quantity(last, 's', digits=3)} on")
    if shortest_time(scenario, times) < first * (1 - SAME):
        moment = format_quantity(first, "s", digits=3)
        said.append(f"the response is not known within {moment} after a corner of the drive")
    if not said:
        return []
    tables = " and ".join(
        f"'{name}'" for name, layer in scenario.stack.layers.items() if np.isfinite(layer.material.band[1])
    )
    ends = " to ".join(format_quantity(end, "Hz", digits=3) for end in known)
    text = f"{tables} is measured from {ends} only: {', and '.join(said)}"
    return [Diagnostic("measured band", "unknown", text, value=float(times[-1]), limit=last, unit="s")]


def transfer_error(
    law: ForceLaw, section: ModalSection, exact: PhasorSection, known: tuple[float, float]
) -> float:
    """Return the largest error of a law's amplitudes over frequency, with materials as sums of Debye terms."""
    reduced, declared = law.amplitudes(section), law.amplitudes(exact)
    inside = (exact.frequency >= known[0]) & (exact.frequency <= known[1])
    if not np.any(inside):
        return math.nan
    errors = []
    for name, value in declared.items():
        scale = float(np.max(np.abs(value)))
        difference = reduced[name].at(exact.frequency[inside]) - value[inside]
        errors.append(float(np.max(np.abs(difference))) / (scale or 1.0))
    return max(errors)
