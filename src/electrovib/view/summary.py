"""A Trace in words: diagnostics, key numbers, provenance."""

from __future__ import annotations

import functools
import math
import platform
import re
from importlib.metadata import version
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.diagnostics import diagnostics_of
from electrovib.core.errors import ElectrovibError
from electrovib.core.own_models import ATTRIBUTE as OWN_MODELS
from electrovib.core.own_models import described
from electrovib.core.parsing import read_json
from electrovib.core.signals import signal
from electrovib.core.units import KINDS, format_quantity
from electrovib.view.lines import scenario_or_none, shown_value, swept_paths, swept_units
from electrovib.view.units import pretty_quantity

if TYPE_CHECKING:
    from collections.abc import Collection

    import xarray

    from electrovib.scenario import Scenario


def is_sweep(trace: xarray.Dataset) -> bool:
    """Return whether a Dataset holds numbers for each case of a sweep."""
    return "quantities" in trace.attrs


def quantities_of(trace: xarray.Dataset) -> list[str]:
    """List the quantities of a sweep, in the order asked for."""
    try:
        return [str(name) for name in read_json(trace.attrs.get("quantities", "[]"))]
    except (TypeError, ValueError):
        return []


def quantity_ranges(trace: xarray.Dataset, *, plain: bool = False, named: bool = True) -> dict[str, str]:
    """Write smallest and largest value of each quantity of a sweep and where they occur; `plain` writes ``uA``."""
    units, found = swept_units(trace), {}
    for name in quantities_of(trace):
        unit = str(trace[name].attrs.get("units", ""))
        values = np.asarray(trace[name].values, dtype=float)
        known = np.isfinite(values)
        if not known.any():
            found[name] = "not known" if np.isnan(values).all() else str(values.flat[0])
            continue
        ends = []
        for place in (
            int(np.argmin(np.where(known, values, np.inf))),
            int(np.argmax(np.where(known, values, -np.inf))),
        ):
            at = np.unravel_index(place, values.shape)
            where = ", ".join(
                (f"{path} = " if named else "")
                + swept_value(trace[path].values[i], units.get(str(path), ""), plain=plain)
                for path, i in zip(trace[name].dims, at, strict=True)
            )
            number = swept_value(values.flat[place], unit, plain=plain)
            ends.append(f"{number} (at {where})" if where else number)
        text = ends[0] if values.size == 1 else " to ".join(ends)
        lost = int(np.count_nonzero(~known))
        found[name] = text + (f"; not known in {lost} of {values.size} cases" if lost else "")
    return found


def swept_value(value: object, unit: str, *, plain: bool) -> str:
    """Write a number with its unit, or a word; with plain units in letters that every terminal has."""
    if plain and unit in KINDS and not isinstance(value, str):
        return format_quantity(float(value), unit, digits=4)  # type: ignore[arg-type]
    return shown_value(value, unit)


def swept_texts(trace: xarray.Dataset) -> dict[str, str]:
    """Return for each swept path its first and last value and their number."""
    units = swept_units(trace)
    texts = {}
    for path in swept_paths(trace):
        values = trace[path].values
        ends = " … ".join(shown_value(values[at], units.get(path, "")) for at in (0, -1) if len(values))
        texts[path] = f"{ends} ({len(values)} values)".strip()
    return texts


PARTS: Final = ("electrovib", "numpy", "scipy", "xarray", "pydantic", "matplotlib")
_SHOWN_ELSEWHERE: Final = frozenset(
    {"format", "title", "scenario", "validity", "over", "quantities", "records"}
)
_WORDS: Final = {
    "electrovib": "computed by electrovib",
    "scenario_hash": "hash of the scenario",
    "taken_over": "numbers of each case are taken over",
    "solver": "solver",
    "solver_reason": "why this solver",
    "reduction_error": "largest error of a material reduced to relaxations",
    "transfer_error": "largest error of fields, voltages and attraction through it, in time and over frequency",
    "attraction_error": "largest error of the attraction through it in time, over its peak",
    "quadrature_error": "error of the mean over the contact",
    "own_models": "models that are not part of electrovib",
    "dropped_samples": "samples of the measured drive that were dropped",
}
_LONGEST: Final = 400


def opening(trace: xarray.Dataset) -> str:
    """State the result and its validity in one line."""
    numbers = key_numbers(trace)
    names = quantities_of(trace)[:1] if is_sweep(trace) else ["largest electrostatic force"]
    parts = [
        f"{name[:1].upper()}{name[1:].replace('_', ' ')}: {numbers[name]}."
        for name in names
        if name in numbers
    ]
    found = diagnostics_of(trace)
    states = []
    for state in ("ok", "warning", "unknown"):
        of = [each.name for each in found if each.state == state]
        if of:
            words = "warnings" if state == "warning" and len(of) > 1 else state
            states.append(f"{len(of)} {words}" + ("" if state == "ok" else f" ({'; '.join(of)})"))
    if states:
        parts.append(f"Validity: {', '.join(states)}.")
    return " ".join(parts)


def key_numbers(trace: xarray.Dataset, *, quick: bool = False) -> dict[str, str]:
    """Return the largest and mean values of a Trace; of a sweep, the range of its quantities.

    Of a run they are its quantities, independent of the output times; where these cannot be computed, or
    would take as long as the run with `quick`, the largest values at the output times, and the text says so.
    """
    if is_sweep(trace):
        return quantity_ranges(trace)
    signals = {
        "drive_voltage": "drive voltage",
        "effective_voltage": "effective voltage",
        "electrostatic_force": "electrostatic force",
        "lateral_force": "lateral force",
        "current": "current into the contact",
        "amplifier_current": "current of the amplifier",
    }
    wanted = {f"peak {name}": (f"largest {words}", name, "") for name, words in signals.items()}
    wanted["mean electrostatic_force"] = ("mean electrostatic force", "electrostatic_force", "")
    for layer in trace["layer"].values if "field" in trace else ():
        words = f"largest field, {str(layer).replace('_', ' ')}"
        wanted[f"peak field in {layer}"] = (words, "field", str(layer))
    wanted = {name: each for name, each in wanted.items() if each[1] in trace}
    values = quantities_of_run(trace, tuple(wanted), quick=quick)
    recorded = "solver" not in trace.attrs
    found = {}
    for name, (words, of, layer) in wanted.items():
        unit, value = signal(of).unit, values.get(name, math.nan)
        if math.isfinite(value):
            found[words] = pretty_quantity(value, unit, digits=4)
            continue
        shown = trace[of].sel(layer=layer) if layer else trace[of]
        if name.startswith("peak"):
            missing = not_known(trace, of)
            found[words] = _range(abs(shown).max("time", skipna=True), unit)
            found[words] += "" if recorded or missing else " at the output times"
            if missing:
                found[words] = f"{found[words]} ({missing})" if bool(shown.notnull().any()) else missing
        elif recorded:
            found[words] = _range(_mean(shown), unit)
    return found


def quantities_of_run(
    trace: xarray.Dataset, names: Collection[str], *, quick: bool = False
) -> dict[str, float]:
    """Compute quantities of the scenario of a Trace, which do not depend on its output times, where that is possible.

    With `quick` nothing is computed for a solver that advances in steps.
    """
    scenario = scenario_or_none(trace) if "solver" in trace.attrs else None
    if scenario is None or not trace.sizes.get("time"):
        return {}
    first, last = trace["time"].values[[0, -1]]
    end = scenario.time.duration or scenario.drive.duration
    if first != 0 or not math.isclose(last, end, rel_tol=1e-9):
        return {}
    return quantities_of_scenario(scenario, tuple(names), quick=quick)


@functools.lru_cache(maxsize=16)
def quantities_of_scenario(
    scenario: Scenario, names: tuple[str, ...], *, quick: bool = False
) -> dict[str, float]:
    """Compute quantities of a scenario over its whole time."""
    from electrovib.solve.choice import chosen
    from electrovib.solve.quantities.answer import numbers
    from electrovib.solve.quantities.names import read_name
    from electrovib.solve.quantities.resolve import solved

    try:
        if quick and chosen(scenario).method.is_marched:
            return {}
        layers = tuple(scenario.stack.layers)
        return numbers(solved(scenario), [read_name(name, layers) for name in names])[0]
    except ElectrovibError:
        return {}


def not_known(trace: xarray.Dataset, name: str) -> str:
    """State the share of the times at which a friction is unknown, because the finger rests; empty where it is known."""
    if name not in trace or not any(each.name == "friction at rest" for each in diagnostics_of(trace)):
        return ""
    share = float(trace[name].isnull().mean())
    if not share:
        return ""
    when = "" if share == 1 else f" at {100 * share:.3g} % of the times"
    return f"not known{when} (the finger rests)"


def _mean(values: xarray.DataArray) -> xarray.DataArray:
    """Average over time without missing samples, uneven time stamps weighted by their distance."""
    time = values["time"]
    if time.size < 2:
        return values.mean("time")
    weights = np.gradient(np.asarray(time.values, dtype=float))
    weights[[0, -1]] /= 2
    return values.weighted(time.copy(data=weights)).mean("time", skipna=True)


def _range(values: xarray.DataArray, unit: str) -> str:
    numbers = np.asarray(values.values, dtype=float).ravel()
    numbers = numbers[np.isfinite(numbers)]
    if not numbers.size:
        return "no numbers"
    low, high = (pretty_quantity(float(bound), unit, digits=4) for bound in (numbers.min(), numbers.max()))
    return low if low == high else f"{low} … {high}"


def provenance(trace: xarray.Dataset) -> dict[str, str]:
    """Return the provenance of a Trace: solver, errors, hash, and every other attribute."""
    found = {}
    for name in [*_WORDS, *(key for key in trace.attrs if key not in _WORDS)]:
        value = trace.attrs.get(name)
        if value is None or name in _SHOWN_ELSEWHERE or (name == "dropped_samples" and not value):
            continue
        text = f"{100 * float(value):.2g} %" if name.endswith("_error") else str(value)
        text = described(text) if name == OWN_MODELS else text
        found[_WORDS.get(str(name), str(name))] = text if len(text) <= _LONGEST else f"{text[:_LONGEST]} …"
    return found


def versions() -> dict[str, str]:
    """Return the versions of the packages that made a page."""
    return {"Python": platform.python_version()} | {name: version(name) for name in PARTS}


def scenario_text(scenario: Scenario) -> str:
    """Write a scenario as the TOML file that repeats it; long packed samples are omitted."""
    from electrovib.scenario.toml import to_toml

    return re.sub(r'"zlib\+base64:[^"]{80,}"', '"(measured samples, omitted here)"', to_toml(scenario))
