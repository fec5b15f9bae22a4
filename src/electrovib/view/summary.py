"""A Trace in words: diagnostics, key numbers, provenance; its scenario as tables: parameters, models, references."""

from __future__ import annotations

import functools
import inspect
import math
import platform
import re
from collections import Counter
from dataclasses import dataclass
from importlib.metadata import version
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.answer import Table
from electrovib.core.citation import is_reference
from electrovib.core.diagnostics import diagnostics_of
from electrovib.core.discovery import paper
from electrovib.core.errors import ElectrovibError
from electrovib.core.formulas import formula_lines
from electrovib.core.model import Model
from electrovib.core.own_models import ATTRIBUTE as OWN_MODELS
from electrovib.core.own_models import described
from electrovib.core.parsing import read_json
from electrovib.core.paths import followers
from electrovib.core.signals import signal
from electrovib.core.units import KINDS, format_quantity
from electrovib.physics.force import ForceLaw
from electrovib.scenario import is_default, paper_named
from electrovib.scenario.sources import BY_THE_USER
from electrovib.view.lines import scenario_or_none, shown_value, swept_paths, swept_units
from electrovib.view.style import pretty_quantity, typeset

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Mapping

    import xarray

    from electrovib.scenario import Scenario

DEFAULT: Final = "default"
NOT_GIVEN: Final = "not given"


@dataclass(frozen=True, kw_only=True)
class ParameterRow:
    """One physical parameter with its value in each scenario, a dash where it has none; equal sources are given once."""

    path: str
    values: tuple[str, ...]
    meaning: str
    sources: tuple[str, ...]

    @property
    def differs(self) -> bool:
        """Whether the scenarios disagree."""
        return len(set(self.values)) > 1


@dataclass(frozen=True, kw_only=True)
class ModelRow:
    """One model chosen in a scenario: its path, its name and its own description."""

    path: str
    name: str
    meaning: str
    facts: tuple[str, ...]
    equations: tuple[str, ...]
    notes: str
    reference: str


def parameter_rows(
    scenarios: Mapping[str, Scenario], swept: Mapping[str, Mapping[str, str]]
) -> list[ParameterRow]:
    """Collect the parameters of all scenarios, in the order of the first file that has them."""
    found: dict[str, dict[str, tuple[str, str]]] = {}
    meanings: dict[str, str] = {}
    for label, scenario in scenarios.items():
        texts = swept.get(label, {})
        following = {each: f"follows {path}" for path in texts for each in followers(scenario, path)}
        for path, value, quantity in scenario.parameters():
            shown = texts.get(path) or following.get(path) or pretty_quantity(value, quantity.unit, digits=6)
            source = "swept" if path in texts or path in following else source_of(scenario, path, value=value)
            source = f"{source}: {quantity.source}" if source == DEFAULT and quantity.source else source
            found.setdefault(path, {})[label] = (shown, typeset(source))
            meanings.setdefault(path, quantity.doc)
    rows = _model_choices(scenarios)
    for path, by_label in found.items():
        values = tuple(by_label.get(label, ("–", ""))[0] for label in scenarios)
        sources = tuple(dict.fromkeys(source for _, source in by_label.values()))
        rows.append(ParameterRow(path=path, values=values, meaning=meanings[path], sources=sources))
    return rows


def parameter_tables(
    scenarios: Mapping[str, Scenario], swept: Mapping[str, Mapping[str, str]]
) -> list[Table]:
    """Make the table of parameters; of several scenarios what differs, and folded what is the same."""
    rows = parameter_rows(scenarios, swept)
    if len(scenarios) < 2:
        return [_parameters("Parameters", ["value"], rows)] if rows else []
    differing, same = ([row for row in rows if row.differs is differs] for differs in (True, False))
    first = _parameters("Parameters: what differs", list(scenarios), differing)
    none = Table("Parameters: what differs", ("",), (("All parameters are the same.",),))
    return [first if differing else none, _parameters("What is the same", list(scenarios), same, folded=True)]


def _parameters(title: str, labels: list[str], rows: list[ParameterRow], *, folded: bool = False) -> Table:
    cells = tuple((row.path, *row.values, row.meaning, "; ".join(row.sources)) for row in rows)
    looks = {0: "code"} | dict.fromkeys(range(1, len(labels) + 1), "number")
    return Table(title, ("parameter", *labels, "meaning", "source"), cells, looks=looks, folded=folded)


def model_table(scenario: Scenario, label: str) -> Table:
    """Make the table of the models of a scenario, each with its equations, where it is from and its limits."""
    rows = tuple(
        (
            row.path,
            row.name,
            "\n".join(filter(None, (row.meaning, *row.facts, row.reference, row.notes))),
            "\n".join(row.equations),
        )
        for row in model_rows(scenario)
    )
    title = f"Models of {label}" if label else "Models"
    return Table(title, ("place", "model", "what it is", "equations"), rows, looks={0: "code", 3: "code"})


def _model_choices(scenarios: Mapping[str, Scenario]) -> list[ParameterRow]:
    """Return a row for each place at which the scenarios choose different models."""
    chosen = [{row.path: row.name for row in model_rows(scenario)} for scenario in scenarios.values()]
    paths = dict.fromkeys(path for names in chosen for path in names)
    rows = [
        ParameterRow(
            path=f"{path}.model",
            values=tuple(names.get(path, "–") for names in chosen),
            meaning="which model",
            sources=(),
        )
        for path in paths
    ]
    return [row for row in rows if row.differs]


def source_of(scenario: Scenario, path: str, *, value: float | None) -> str:
    """Return the source of a value: that stated for it or for its table, else whether it is the default."""
    parts = path.split(".")
    for length in range(len(parts), 0, -1):
        stated = scenario.sources.get(".".join(parts[:length]))
        if stated:
            return stated
    return DEFAULT if is_default(scenario, path, value) else NOT_GIVEN


def walk_models(model: Model, prefix: str = "") -> Iterator[tuple[str, Model]]:
    """Walk over all models inside a model, with their dotted paths."""
    for name, value in model:
        path = f"{prefix}{name}"
        items = (
            [(path, value)]
            if not isinstance(value, tuple)
            else [(f"{path}.{i}", v) for i, v in enumerate(value)]
        )
        for where, item in items:
            if isinstance(item, Model):
                yield where, item
                yield from walk_models(item, f"{where}.")


def model_rows(scenario: Scenario) -> list[ModelRow]:
    """List the models of a scenario for which there are alternatives: drive, law, materials, return path."""
    rows = []
    for path, model in walk_models(scenario):
        kind = type(model)
        if not kind.is_member:
            continue
        facts = (
            [f"Maxwell stress evaluated in: {kind.evaluation_surface}"] if issubclass(kind, ForceLaw) else []
        )
        facts += [f"source status: {kind.status}"] if kind.status else []
        equations = tuple(
            readable_equation(line)
            for name, text in kind.equation.items()
            for line in formula_lines(name, text)
        )
        meaning, _, rest = inspect.cleandoc(kind.__doc__ or "").partition("\n")
        notes = " ".join(rest.partition("Notes\n-----\n")[2].replace("``", "").split())
        rows.append(
            ModelRow(
                path=path,
                name=kind.__name__,
                meaning=meaning,
                facts=tuple(facts),
                equations=equations,
                notes=notes,
                reference=kind.reference,
            )
        )
    return rows


def readable_equation(text: str) -> str:
    """Write a formula of the code with raised powers, Greek letters and multiplication dots."""
    for word, letter in {"eps0": "ε₀", "pi": "π", "I": "j"}.items():
        text = re.sub(rf"\b{word}\b", letter, text)
    text = re.sub(r"\*\*([23])(?![\d.])", lambda match: "²³"[int(match[1]) - 2], text)
    return text.replace("**", "^").replace("*", "·")


def references(scenarios: Mapping[str, Scenario]) -> list[tuple[str, str]]:
    """Collect the publications that models or values are from, and what is from each."""
    models: dict[str, dict[str, None]] = {}
    values: Counter[str] = Counter()
    for scenario in scenarios.values():
        for _, model in walk_models(scenario):
            own = re.match(r"electrovib\.papers\.(\w+)", type(model).__module__)
            cited = _cited(model.reference, own[1] if own and model.reference else "")
            models.setdefault(cited, {})[type(model).__name__] = None
        if name := paper_named(scenario.title):
            models.setdefault(_cited("", name), {})["the set-up"] = None
        stated = [each for each in scenario.sources.values() if not each.startswith(BY_THE_USER)]
        values.update(_cited(text, paper_named(text)) for text in stated)
    found = {}
    for cited in [each for each in {**models, **values} if is_reference(each)]:
        count = values[cited]
        several = [f"{count} value{'s' if count > 1 else ''}"] if count else []
        found[cited] = ", ".join([*models.get(cited, ()), *several])
    return list(found.items())


def _cited(text: str, name: str) -> str:
    return str(paper(name).CITATION) if name else text


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
    """State for which part of a run a friction is unknown, because the finger rests; empty where it is known."""
    if name not in trace or not any(each.name == "friction at rest" for each in diagnostics_of(trace)):
        return ""
    unknown = trace[name].isnull()
    if not bool(unknown.any()):
        return ""
    when = "" if bool(unknown.all()) else f" for {100 * float(_mean(unknown)):.3g} % of the time"
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
