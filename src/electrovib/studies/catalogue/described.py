"""Details of one model or paper: parameters, values, claims, what it offers by name, citation."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from types import ModuleType
from typing import Any

from electrovib.core.answer import Table
from electrovib.core.citation import bibtex_of
from electrovib.core.discovery import paper_of
from electrovib.core.model import Model
from electrovib.core.quantity import quantity_of
from electrovib.core.samples import Samples
from electrovib.core.units import format_quantity
from electrovib.studies.catalogue.families import families, first_sentence, plain_text

NAMES = (
    "A skin, a material or a stack of a paper is used by its name, which 'electrovib list PAPER' lists:"
    " --set stack.stratum_corneum.material=gabriel_1996/wet"
)
"""How the name of something that a paper offers is used."""


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
    text = families().get(kind) or first_sentence(kind)
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
    places = {path: place for place, path in enumerate(dict.fromkeys(path for path, _ in found))}
    rows = tuple(
        (path, _several(list(dict.fromkeys(shown))), source)
        for (path, source), shown in sorted(found.items(), key=lambda item: places[item[0][0]])
    )
    return Table("values of its scenarios", ("parameter", "value", "source"), rows) if rows else None


def _several(shown: list[str]) -> str:
    return ", ".join(shown[:3]) + (f" and {len(shown) - 3} more" if len(shown) > 3 else "")


def claims(module: ModuleType) -> dict[str, str]:
    """Read from a paper's docstring what it claims, what it does not claim, and, as ``here``, what is said after that."""
    text = plain_text(inspect.getdoc(module) or "")
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
