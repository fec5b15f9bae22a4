"""A Trace in words: diagnostics, key numbers, provenance."""

from __future__ import annotations

import platform
import re
from importlib.metadata import version
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.own_models import ATTRIBUTE as OWN_MODELS
from electrovib.core.own_models import described
from electrovib.core.parsing import read_json
from electrovib.core.signals import signal
from electrovib.core.units import KINDS, format_quantity
from electrovib.view.lines import shown_value, swept_paths, swept_units
from electrovib.view.units import pretty_quantity

if TYPE_CHECKING:
    import xarray

    from electrovib.scenario import Scenario

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
    "quadrature_error": "error of the mean over the contact",
    "own_models": "models that are not part of electrovib",
    "dropped_samples": "samples of the measured drive that were dropped",
}
_LONGEST: Final = 400


def diagnostics(trace: xarray.Dataset) -> list[dict[str, str]]:
    """Read the validity diagnostics.

    Returns
    -------
    list of dict
        ``name``, ``state`` and ``text`` of each; empty where there are none.
    """
    try:
        found = read_json(trace.attrs.get("validity", "[]"))
        return [{key: str(diagnostic[key]) for key in ("name", "state", "text")} for diagnostic in found]
    except (TypeError, ValueError, KeyError):
        return []


def opening(trace: xarray.Dataset) -> str:
    """State the result and its validity in one line.

    Parameters
    ----------
    trace : Trace
        Computed, measured or swept.

    Returns
    -------
    str
        The largest attraction, or the first quantity of a sweep; then how many diagnostics are in which state, with the names
        of those that warn or are unknown. Empty where there is neither.
    """
    numbers = key_numbers(trace)
    names = quantities_of(trace)[:1] if is_sweep(trace) else ["largest electrostatic force"]
    parts = [
        f"{name[:1].upper()}{name[1:].replace('_', ' ')}: {numbers[name]}."
        for name in names
        if name in numbers
    ]
    found = diagnostics(trace)
    states = []
    for state in ("ok", "warning", "unknown"):
        of = [each["name"] for each in found if each["state"] == state]
        if of:
            words = "warnings" if state == "warning" and len(of) > 1 else state
            states.append(f"{len(of)} {words}" + ("" if state == "ok" else f" ({'; '.join(of)})"))
    if states:
        parts.append(f"Validity: {', '.join(states)}.")
    return " ".join(parts)


def key_numbers(trace: xarray.Dataset) -> dict[str, str]:
    """Return the largest and mean values of a Trace; of a sweep, the range of its quantities.

    Returns
    -------
    dict of str to str
        Name of the number, and its value with unit.
    """
    if is_sweep(trace):
        return quantity_ranges(trace)
    peaks = {
        "drive_voltage": "largest drive voltage",
        "effective_voltage": "largest effective voltage",
        "electrostatic_force": "largest electrostatic force",
        "lateral_force": "largest lateral force",
        "current": "largest current into the contact",
        "amplifier_current": "largest current of the amplifier",
    }
    found = {}
    for name, words in peaks.items():
        if name in trace:
            found[words] = _range(_largest(abs(trace[name]), "time"), signal(name).unit)
            if name == "lateral_force" and (missing := not_known(trace, name)):
                some = bool(trace[name].notnull().any())
                found[words] = f"{found[words]} ({missing})" if some else missing
        if name == "electrostatic_force" and name in trace:
            found["mean electrostatic force over the record"] = _range(_mean(trace[name]), "N")
    if "field" in trace:
        for layer in trace["layer"].values:
            largest = _largest(abs(trace["field"].sel(layer=layer)), "time")
            found[f"largest field, {str(layer).replace('_', ' ')}"] = _range(largest, "V/m")
    return found


def not_known(trace: xarray.Dataset, name: str) -> str:
    """State the share of the times at which a friction is unknown, because the finger rests.

    Parameters
    ----------
    trace : Trace
        Computed or measured.
    name : str
        Of the signal.

    Returns
    -------
    str
        For instance ``not known at 40 % of the times (the finger rests)``; empty where it is known, or where the
        Trace has no diagnostic that the finger rests.
    """
    if name not in trace or not any(
        diagnostic["name"] == "friction at rest" for diagnostic in diagnostics(trace)
    ):
        return ""
    share = float(trace[name].isnull().mean())
    if not share:
        return ""
    when = "" if share == 1 else f" at {100 * share:.3g} % of the times"
    return f"not known{when} (the finger rests)"


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
    """Write smallest and largest value of each quantity of a sweep, and where they occur.

    Parameters
    ----------
    trace : xarray.Dataset
        From `electrovib.sweep`.
    plain : bool
        Units in letters that every terminal has: ``uA``.
    named : bool
        Name the parameter before each value of a place.

    Returns
    -------
    dict of str to str
        Name to text.
    """
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


def _largest(values: xarray.DataArray, along: str) -> xarray.DataArray:
    return values.max(along, skipna=True)


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


def swept_texts(trace: xarray.Dataset) -> dict[str, str]:
    """Return for each swept path its first and last value and their number."""
    units = swept_units(trace)
    texts = {}
    for path in swept_paths(trace):
        values = trace[path].values
        first, last = (shown_value(value, units.get(path, "")) for value in (values[0], values[-1]))
        texts[path] = f"{first} … {last} ({len(values)} values)"
    return texts


def provenance(trace: xarray.Dataset) -> dict[str, str]:
    """Return the provenance of a Trace: solver, errors, hash, and every other attribute.

    Returns
    -------
    dict of str to str
        Words to text.
    """
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
