"""Everything that the catalogue knows: what it is, its record, and the texts in which it is searched for."""

from __future__ import annotations

import inspect
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import ModuleType
from typing import Any, Final

from electrovib.core.citation import Citation
from electrovib.core.discovery import find_members, offers, paper_of, papers
from electrovib.core.model import Model
from electrovib.core.quantity import quantity_of
from electrovib.core.search import Searchable
from electrovib.core.units import format_quantity
from electrovib.physics.material import Material
from electrovib.physics.material.library import materials
from electrovib.scenario import Scenario
from electrovib.scenario.sources import note_of
from electrovib.studies.catalogue.families import families, first_sentence, kind_of, plain_text
from electrovib.studies.catalogue.listed import Listed

REMARKS: Final = ("notes", "reference", "claims", "not read", "sources")
"""Labels of texts that mention many things besides what they are about."""
PAPERS, SCENARIOS, LIBRARY = "papers", "scenarios", "material library"
"""Groups of records that are no families of models."""


@dataclass(frozen=True)
class Item:
    """One thing of the catalogue: a model class, the module of a paper, or what a paper offers.

    `aliases` are other names of the same thing, and `texts` are searched by their labels.
    """

    thing: Any
    record: Listed
    texts: Mapping[str, str]
    aliases: tuple[str, ...] = ()

    @property
    def entry(self) -> Searchable:
        """Return what the search takes."""
        return Searchable(
            name=self.record.name,
            kind=self.record.kind,
            meaning=self.record.meaning,
            aliases=self.aliases,
            texts=self.texts,
        )


def everything(*, own: bool = False) -> Iterator[Item]:
    """Yield models by family, parts of a scenario without a choice, papers, and what papers offer ready-made."""
    yield from model_items(own=own)
    yield from _parts()
    yield from paper_items(own=own)
    yield from _library()
    yield from _offered()
    yield from scenario_items()


def is_own(thing: type[Model] | ModuleType) -> bool:
    """Tell whether a model or a paper is of this package, and not contributed by another one."""
    place = thing.__name__ if isinstance(thing, ModuleType) else thing.__module__
    return place.partition(".")[0] == __name__.partition(".")[0]


def model_items(*, own: bool = False) -> Iterator[Item]:
    """Collect the members of every family; `own` as for `everything`."""
    for family, predicts in families().items():
        for _, model in sorted(find_members(family).items()):
            if own and not is_own(model):
                continue
            yield _of_model(model, kind_of(family), predicts)


def _parts() -> Iterator[Item]:
    """Collect models that belong to no family, such as the amplifier."""
    for part in Model.__subclasses__():
        if not part.is_family and part.__module__.startswith("electrovib."):
            yield _of_model(part, "part of a scenario", "parts of a scenario")


def _of_model(model: type[Model], kind: str, group: str) -> Item:
    author_year = paper_of(model)
    count = len(model.checks) + (len(_checks(papers()[author_year])) if author_year else 0)
    record = Listed(
        name=model.__name__,
        kind=kind,
        meaning=first_sentence(model),
        group=group,
        paper=author_year,
        status=model.status,
        checks=count,
    )
    parameters = {name: _meaning(model, name) for name in model.model_fields}
    parameters |= {name: quantity.doc for name, quantity in model.derived.items()}
    texts = {"parameters": ", ".join(f"{name} ({meaning})" for name, meaning in parameters.items())}
    texts |= {"group": f"{kind}, {group}", "notes": inspect.getdoc(model) or "", "reference": model.reference}
    return Item(model, record, texts)


def _meaning(model: type[Model], parameter: str) -> str:
    quantity = quantity_of(model, parameter)
    return quantity.doc if quantity else model.model_fields[parameter].description or ""


def paper_items(*, own: bool = False) -> Iterator[Item]:
    """Collect the papers; `own` as for `everything`."""
    for name, module in papers().items():
        if own and not is_own(module):
            continue
        unread = plain_text(getattr(module, "NOT_READ", ""))
        record = Listed(
            name=name,
            kind="paper",
            meaning=_title(module),
            group=PAPERS,
            paper=name,
            status=getattr(module, "STATUS", ""),
            checks=len(_checks(module)),
            runnable=f"not: {unread}" if _not_runnable(module) else "yes",
        )
        texts = {"citation": module.CITATION, "claims": module.__doc__ or "", "not read": unread}
        yield Item(module, record, texts)


def _title(module: ModuleType) -> str:
    """Return the title of a paper, or what it is about; the whole citation where neither is declared."""
    citations: tuple[Citation, ...] = getattr(module, "CITATIONS", ())
    known = citations[0].title or citations[0].about if citations else ""
    return known or str(module.CITATION)


def _checks(module: ModuleType) -> tuple[Any, ...]:
    return tuple(getattr(module, "CHECKS", ()))


def _not_runnable(module: ModuleType) -> bool:
    return (
        not hasattr(module, "scenarios")
        and not hasattr(module, "skins")
        and bool(getattr(module, "NOT_READ", ""))
    )


def _library() -> Iterator[Item]:
    for substance in materials():
        material = Material.from_offer(substance)
        status = (
            substance.permittivity[0].status if substance.dispersion is None else substance.dispersion.status
        )
        record = Listed(
            name=substance.name,
            kind="material",
            meaning=f"{substance.meaning}: {_content(material)}",
            group=LIBRARY,
            status=status,
        )
        texts = {"kind": substance.kind, "model": type(material).__name__, "source": substance.strength_words}
        yield Item(substance, record, texts, substance.aliases)


def _offered() -> Iterator[Item]:
    for function, kind in (("materials", "material"), ("skins", "skin"), ("stacks", "stack")):
        for name, thing in offers((function,)).items():
            author_year = name.partition("/")[0]
            if kind == "skin":
                meaning, status, source = f"{thing.name}: {thing.note}", thing.status, thing.source
            else:
                meaning, status, source = _content(thing), papers()[author_year].STATUS, ""
            record = Listed(
                name=name, kind=kind, meaning=meaning, group=function, paper=author_year, status=status
            )
            yield Item(thing, record, {"source": source, "model": type(thing).__name__})


def _content(thing: Any) -> str:
    """Describe a material by its parameters, a stack by its layers."""
    if hasattr(thing, "layers"):
        return stack_text(thing)
    numbers = [
        f"{path} {format_quantity(value, quantity.unit)}"
        for path, value, quantity in thing.parameters()
        if value
    ]
    return f"{type(thing).__name__} with {', '.join(numbers)}"


def stack_text(stack: Any) -> str:
    """Describe a stack by the thicknesses and materials of its layers, from the plate to the finger."""
    layers = []
    for name, layer in stack.layers.items():
        permittivity = getattr(layer.material, "permittivity", None)
        shown = "" if permittivity is None else f", permittivity {permittivity:.4g}"
        thickness = format_quantity(layer.thickness, "m")
        filling = getattr(layer.material, "substance", None) or type(layer.material).__name__
        layers.append(f"{name} {thickness} ({filling}{shown})")
    return "; ".join(layers)


def scenario_items() -> Iterator[Item]:
    """Collect the ready-made scenarios of all papers."""
    for name, scenario in offers(("scenarios",)).items():
        author_year = name.partition("/")[0]
        module, note = papers()[author_year], note_of(name)
        record = Listed(
            name=name,
            kind="scenario",
            meaning=scenario.title,
            group=SCENARIOS,
            paper=author_year,
            status=getattr(module, "STATUS", ""),
            reproduces=note.reproduces,
        )
        yield Item(scenario, record, _texts_of(scenario, record, note.keywords, module))


def _texts_of(scenario: Scenario, record: Listed, keywords: str, module: ModuleType) -> dict[str, str]:
    models = (type(part).__name__ for part in (scenario.drive, scenario.force, scenario.friction))
    return {
        "keywords": keywords,
        "reproduces": record.reproduces,
        "stack": stack_text(scenario.stack),
        "models": ", ".join(models),
        "paper": module.CITATION,
        "sources": "; ".join(dict.fromkeys(scenario.sources.values())),
    }
