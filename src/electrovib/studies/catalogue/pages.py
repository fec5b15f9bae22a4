"""One entry of the catalogue in full: equation, parameters, claims, what it offers by name, limits, checks, sources."""

from __future__ import annotations

import inspect
import re
import textwrap
from collections.abc import Iterable, Iterator
from types import ModuleType
from typing import Any, Final

from electrovib.core.answer import Table, laid_out, terminal_width
from electrovib.core.citation import Check, bibtex_of, counted, status_text
from electrovib.core.discovery import paper_of, papers
from electrovib.core.errors import ElectrovibError
from electrovib.core.formulas import formula_lines
from electrovib.core.model import Model
from electrovib.core.quantity import quantity_of
from electrovib.core.samples import Samples
from electrovib.core.units import format_quantity
from electrovib.physics.material.library import SourcedValue, Substance
from electrovib.scenario import Scenario
from electrovib.studies.catalogue import items
from electrovib.studies.catalogue.items import Listed

_LABEL: Final = 16
"""Width of the first column, characters."""


def page(item: Listed) -> str:
    """Write everything that is known of one entry."""
    thing, name = item.thing, item.name
    title = f"{name} ({item.kind})"
    lines = [title, "=" * len(title)]
    if isinstance(thing, ModuleType):
        lines += _of_paper(thing, name)
    elif isinstance(thing, type):
        lines += _of_model(thing)
    elif isinstance(thing, Substance):
        lines += _of_substance(thing)
    elif isinstance(thing, Scenario):
        lines += _of_scenario(thing, item)
    else:
        lines += _of_offer(item)
    return "\n".join(lines) + "\n"


def _of_model(model: type[Model]) -> list[str]:
    formulas = [line for name, text in model.equation.items() for line in formula_lines(name, text)]
    before = [*_written_as(model), *(("equation", formula) for formula in formulas)]
    table = parameters(model)
    facts = [] if table.rows else [("parameters", "none")]
    facts += [("both pairs", model.derived_note), ("source status", status_text(model.status))]
    facts.append(("reference", model.reference))
    if name := paper_of(model):
        module = papers()[name]
        facts += [("paper", name), *claims(module).items(), *_disagreements(module)]
        facts += _checks(getattr(module, "CHECKS", ()))
    return [
        (inspect.getdoc(model) or "").replace("``", "'"),
        "",
        *_labelled(before),
        *(["", laid_out(table)] if table.rows else []),
        *_labelled([*facts, *_checks(model.checks)]),
        *_beside_the_stress_in_the_gap(model),
    ]


def _written_as(model: type[Model]) -> Iterator[tuple[str, str]]:
    """Show how a scenario file names a member of a family, and from which class a model of one's own is derived."""
    for family, place in items.places().items():
        if model.is_member and issubclass(model, family):
            yield "in a scenario", f'{place} = {{ model = "{model.__name__}", ... }}'
            named = f"from {family.__module__} import {family.__name__}"
            yield "own model", f"a subclass of {family.__name__}: {named}"
            return


def _beside_the_stress_in_the_gap(model: type[Model]) -> list[str]:
    """Compare a force law with the Maxwell stress in the gap on the film of Vezzoli et al. 2014."""
    from electrovib.physics.force import ForceLaw
    from electrovib.studies.compare import compare
    from electrovib.studies.surfaces import FILM

    if not issubclass(model, ForceLaw):
        return []
    try:
        found = compare(FILM.scenario("MaxwellStressInGap"), models=["MaxwellStressInGap", model.__name__])
    except ElectrovibError:
        return []
    for entry in found.entries:
        if entry.name == model.__name__:
            force = format_quantity(entry.static, "N", digits=4)
            return ["", f"On the film of Vezzoli et al. 2014 at 1000 V: {force}. {entry.why}."]
    return ["", f"On the film of Vezzoli et al. 2014: {found.left_out[model.__name__]}"]


def _of_paper(module: ModuleType, name: str) -> list[str]:
    facts = [("source status", status_text(module.STATUS)), *claims(module).items()]
    facts += [("not read", items.plain_text(getattr(module, "NOT_READ", ""))), *ready_made(module, name)]
    table, checks = values(module), getattr(module, "CHECKS", ())
    after = [*_disagreements(module), ("checked", counted(checks)), *_checks(checks)]
    shown = ["", laid_out(table)] if table else []
    return [module.CITATION, "", *_labelled(facts), *shown, *_labelled(after)]


def _of_scenario(scenario: Scenario, item: Listed) -> list[str]:
    module = papers()[item.paper]
    facts = {
        "what it is": scenario.title,
        "reproduces": item.reproduces,
        "keywords": item.texts["keywords"],
        "drive": type(scenario.drive).__name__,
        "stack": items.stack_text(scenario.stack),
        "force": type(scenario.force).__name__,
        "friction": type(scenario.friction).__name__,
        "paper": module.CITATION,
        "source status": status_text(module.STATUS),
        "run it": f"electrovib run {item.name}",
        "change it": f"electrovib init {item.name} -o my.toml",
    }
    return _labelled(facts.items())


def _of_substance(substance: Substance) -> list[str]:
    facts = [("what it is", f"{substance.meaning}; also called {', '.join(substance.aliases)}")]
    facts.append(("in a scenario", f'stack.LAYER.material = "{substance.name}"'))
    facts += [("permittivity", _sourced(value)) for value in substance.permittivity]
    if substance.dispersion:
        model = substance.dispersion
        facts.append(("dispersion", f"{model.model} ({status_text(model.status)}; {model.source})"))
    known = {"conductivity": substance.conductivity, "at most": substance.conductivity_bound}
    facts += [(label, _sourced(value)) for label, value in known.items() if value]
    if not any(known.values()):
        facts.append(("conductivity", "not found, taken as 0"))
    facts += [("breakdown", f"{_sourced(value)}, {value.measured_at}") for value in substance.strengths]
    return _labelled(facts)


def _sourced(value: SourcedValue) -> str:
    conditions = f", {value.conditions}" if value.conditions else ""
    shown = format_quantity(value.value, value.unit, digits=4)
    return f"{shown}{conditions} ({status_text(value.status)}; {value.source})"


def _of_offer(item: Listed) -> list[str]:
    where = "stack" if item.kind == "stack" else "stack.LAYER.material"
    facts = {
        "what it is": item.meaning,
        "source status": status_text(item.status),
        "source": item.texts["source"] or papers()[item.paper].CITATION,
        "in a scenario": f'{where} = "{item.name}"',
    }
    return _labelled(facts.items())


def _labelled(pairs: Iterable[tuple[str, str]]) -> list[str]:
    return [line for label, text in pairs for line in labelled(label, text)]


def labelled(label: str, text: str, width: int = _LABEL) -> list[str]:
    """Write a label and its text, wrapped beside it; nothing for an empty text."""
    room = terminal_width() - width
    parts = textwrap.wrap(text, room, break_long_words=False, break_on_hyphens=False)
    return [f"{label if place == 0 else '':<{width}}{part}" for place, part in enumerate(parts)]


def _disagreements(module: Any) -> list[tuple[str, str]]:
    return [("disagrees", text) for text in getattr(module, "DEFECTS", ())]


def _checks(checks: Iterable[Check]) -> list[tuple[str, str]]:
    return [
        (
            "check",
            f"{each.name}: {each.expect:g} within {100 * each.rtol:.2g} % ({status_text(each.status)}; {each.source})",
        )
        for each in checks
    ]


def ready_made(module: ModuleType, name: str) -> Iterator[tuple[str, str]]:
    """Yield what a paper offers by name: ``run``, ``skin``, ``material`` or ``stack``, and its name with a few words."""
    for key, scenario in getattr(module, "scenarios", dict)().items():
        yield "run", f"electrovib run {name}/{key} ({scenario.title})"
    for key, skin in getattr(module, "skins", dict)().items():
        yield "skin", f"{name}/{key}: {skin.name} ({skin.status}): {skin.note}"
    for key, material in getattr(module, "materials", dict)().items():
        yield "material", f"{name}/{key}: {type(material).__name__}"
    for key, stack in getattr(module, "stacks", dict)().items():
        yield "stack", f"{name}/{key}: {', '.join(stack.layers)}"


def parameters(model: type[Model]) -> Table:
    """Return the table of a model's parameters: unit, range, default, meaning, source of the default."""
    rows = []
    for name, declared in model.model_fields.items():
        quantity = quantity_of(model, name)
        default = None if declared.is_required() else declared.get_default(call_default_factory=True)
        needed = "required" if declared.is_required() else ""
        if quantity is None:
            meaning = declared.description or _part_of(model, name)
            rows.append((name, "", "", needed or _named(default), meaning, _source(model, default, needed)))
            continue
        shown = needed or ("none" if default is None else format_quantity(default, quantity.unit))
        source = quantity.source or _source(model, default, needed)
        rows.append((name, quantity.unit, quantity.range(" to "), shown, quantity.doc, source))
    for name, quantity in model.derived.items():
        rows.append((name, quantity.unit, quantity.range(" to "), "derived", quantity.doc, quantity.source))
    return Table("parameters", ("name", "unit", "range", "default", "meaning", "source"), tuple(rows))


def _named(default: Any) -> str:
    if isinstance(default, Samples):
        return "none" if not len(default) else str(default)
    return type(default).__name__ if isinstance(default, Model) else str(default) or "none"


def _part_of(model: type[Model], name: str) -> str:
    """Return what the models compute, or are, that a parameter holds; empty for a parameter that holds none."""
    kind = model.part(name)
    if kind is None:
        return ""
    text = items.families().get(kind) or items.first_sentence(kind)
    return f"{text[:1].lower()}{text[1:]}"


def _source(model: type[Model], default: Any, needed: str) -> str:
    if needed:
        return "no default"
    if default is None or default in (0.0, "") or (isinstance(default, Samples) and not len(default)):
        return "absent or 0 by default"
    return (paper_of(model) and model.reference) or "a choice"


def values(module: ModuleType) -> Table | None:
    """Return the values of a paper's ready-made scenarios with the source of each, or None without scenarios."""
    found: dict[tuple[str, str], list[str]] = {}
    for scenario in getattr(module, "scenarios", dict)().values():
        for path, value, quantity in scenario.parameters():
            if path in scenario.sources and value is not None:
                shown = found.setdefault((path, scenario.sources[path]), [])
                shown.append(format_quantity(value, quantity.unit))
    places = list(dict.fromkeys(path for path, _ in found))
    rows = []
    for (path, source), several in sorted(found.items(), key=lambda item: places.index(item[0][0])):
        shown = list(dict.fromkeys(several))
        more = f" and {len(shown) - 3} more" if len(shown) > 3 else ""
        rows.append((path, ", ".join(shown[:3]) + more, source))
    return Table("values of its scenarios", ("parameter", "value", "source"), tuple(rows)) if rows else None


def claims(module: ModuleType) -> dict[str, str]:
    """Read from a paper's docstring what it claims, what it does not claim, and, as ``here``, what is said after that."""
    text = items.plain_text(inspect.getdoc(module) or "")
    found = re.search(r"Claims: (.*?)\s*Does not claim: (.*)", text)
    if not found:
        return {}
    without, _, here = found[2].partition(". ")
    said = {"claims": found[1], "does not claim": f"{without.rstrip('.')}."}
    return said | {"here": here} if here else said


def bibtex(module: ModuleType, name: str) -> str:
    """Write a paper's citations as BibTeX entries, the first with the key `name`."""
    citations = getattr(module, "CITATIONS", ())
    if not citations:
        return bibtex_of(module.CITATION, name)
    return "\n\n".join(citation.bibtex(name) for citation in citations)
