"""How well an answer is known as far as materials go, and from when on it is not."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.units import format_quantity
from electrovib.scenario import PeriodicState
from electrovib.solve.diagnostics.judged import LARGEST, TAIL
from electrovib.solve.diagnostics.memory import CURRENT, FORCE
from electrovib.solve.stack.band import SAME, lowest_frequency, shortest_time

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario
    from electrovib.solve.diagnostics.judged import Judged
    from electrovib.solve.electrics.solution import Method
    from electrovib.solve.stack.keys import Key


def known_band(scenario: Scenario) -> tuple[float, float]:
    """Give the lowest and the highest frequency at which all materials are known [Hz].

    Parameters
    ----------
    scenario : Scenario
        Its layers; a formula is known everywhere, a table between its ends.

    Returns
    -------
    tuple of float
        Hz.
    """
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
    """Say how far an answer in time is off because materials were reduced, and from when on it is not known.

    Parameters
    ----------
    scenario : Scenario
        Everything.
    errors : mapping of Key to Judged
        From `answer_errors`.
    times : ndarray, shape (n,)
        Output times [s].
    known : tuple of float
        Lowest and highest frequency at which all materials are known [Hz].
    method : Method
        By which it was answered.

    Returns
    -------
    list of Diagnostic
        None where every layer is a sum of Debye terms as declared.
    """
    layers = scenario.stack.layers
    reduced = [name for name, layer in layers.items() if layer.material.debye() is None]
    if not reduced:
        return []
    return [*_of_error(reduced, errors, method), *_beyond_tables(scenario, times, known)]


def worst_of(errors: Mapping[Key, Judged]) -> float:
    """Give the largest error of what pulls and of what stands across the layers; the current is told apart."""
    return max((found.error for name, found in errors.items() if name != CURRENT), default=0.0)


def _of_error(reduced: list[str], errors: Mapping[Key, Judged], method: Method) -> list[Diagnostic]:
    if not errors:
        return []
    names, worst = " and ".join(f"'{name}'" for name in reduced), worst_of(errors)
    told = {"fields and voltages": worst}
    told |= {
        what: errors[name].error
        for name, what in ((FORCE, "the attraction"), (CURRENT, "the current"))
        if name in errors
    }
    parts = ", ".join(f"{what} by at most {100 * error:.2g} %" for what, error in told.items())
    change = f"{parts}, of the value at that time while that is above {TAIL:g} of its peak"
    if not method.by_modes:  # else the error found bounds the answer, which is linear in the drive
        text = (
            f"{names} stands as a sum of relaxations: without leak, motion, limits and renewal that changes {change};"
            f" what it does to the answer of the solver '{method.name}' is not known"
        )
        return [Diagnostic("memory", "unknown", text)]
    text = f"{names} stands as a sum of relaxations, which changes {change}"
    judged = {name: found for name, found in errors.items() if name != CURRENT}
    share, lost = max(found.share for found in judged.values()), min(found.lost for found in judged.values())
    if np.isfinite(lost):
        first = next(name for name, found in judged.items() if found.lost == lost)
        text += (
            f"; '{first}' is not known to {100 * LARGEST:g} % of what is left of it from"
            f" {format_quantity(lost, 's', digits=3)} on"
        )
    state = "warning" if np.isfinite(lost) else "ok"
    return [Diagnostic("memory", state, text, value=share, limit=LARGEST, unit="1")]


def _beyond_tables(scenario: Scenario, times: Real, known: tuple[float, float]) -> list[Diagnostic]:
    """Say which part of an answer rests on frequencies that no table holds."""
    (low, high), said = known, []
    last = 1 / (2 * np.pi * low) if low else np.inf
    first = 1 / (2 * np.pi * high)
    if isinstance(scenario.time.initial_state, PeriodicState):
        slowest = lowest_frequency(scenario)
        if slowest < low * (1 - SAME):
            said.append(f"the drive has {format_quantity(slowest, 'Hz', digits=3)}, below the table")
    elif times[-1] > last:
        said.append(f"the answer is not known from {format_quantity(last, 's', digits=3)} on")
    if shortest_time(scenario, times) < first * (1 - SAME):
        said.append(f"nor is it within {format_quantity(first, 's', digits=3)} after a corner of the drive")
    if not said:
        return []
    tables = " and ".join(
        f"'{name}'" for name, layer in scenario.stack.layers.items() if np.isfinite(layer.material.band[1])
    )
    ends = " to ".join(format_quantity(end, "Hz", digits=3) for end in known)
    text = f"{tables} is measured from {ends} only: {', '.join(said).removeprefix('nor is it')}"
    return [Diagnostic("measured band", "unknown", text, value=float(times[-1]), limit=last, unit="s")]
