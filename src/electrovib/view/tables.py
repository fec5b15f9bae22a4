"""A scenario as tables: parameters with their sources, models, references."""

from __future__ import annotations

import inspect
import re
from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from electrovib.core.answer import Table
from electrovib.core.citation import is_reference
from electrovib.core.discovery import paper
from electrovib.core.formulas import formula_lines
from electrovib.core.model import Model
from electrovib.core.paths import followers
from electrovib.physics.force import ForceLaw
from electrovib.scenario import is_default, paper_named
from electrovib.scenario.sources import BY_THE_USER
from electrovib.view.units import pretty_quantity, typeset

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

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
