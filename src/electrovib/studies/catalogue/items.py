"""Everything that the catalogue knows: families, entries, their records, and the texts in which they are searched for."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from types import ModuleType
from typing import Any, Final, Self

from electrovib.core.answer import Table
from electrovib.core.citation import Citation
from electrovib.core.discovery import find_members, import_textbook, offers, paper, paper_of, papers
from electrovib.core.model import Model
from electrovib.core.quantity import quantity_of
from electrovib.core.search import Searchable
from electrovib.core.units import format_quantity
from electrovib.physics.circuit import ReturnPath
from electrovib.physics.contact import Contact
from electrovib.physics.drive.base import Drive
from electrovib.physics.force import ForceLaw
from electrovib.physics.friction import Friction
from electrovib.physics.material import Material
from electrovib.physics.material.library import materials
from electrovib.physics.stack import Stack
from electrovib.scenario import Scenario
from electrovib.scenario.sources import note_of


@dataclass(frozen=True, kw_only=True)
class Listed(Searchable):
    """One model, paper, ready-made scenario, skin, material or stack.

    - `name`: what is written to use it; `kind`: ``force law``, ``paper``, ``scenario``; `meaning`: one line.
    - `group`: what the members of its family compute; ``papers`` and ``scenarios`` for these.
    - `paper`: ``author_year``, or empty for a model of the textbook.
    - `status`: how its source was read, one of `electrovib.core.citation.STATUSES`; empty for a definition.
    - `checks`: how many numbers of sources it is checked against.
    - `runnable`: ``"yes"``, or why it cannot be run.
    - `reproduces`: of a scenario, the figure of its paper or the statement; `reason`: why a search found it.
    - `thing`: a model class, the module of a paper, or what a paper offers.
    """

    group: str = ""
    paper: str = ""
    status: str = ""
    checks: int = 0
    runnable: str = "yes"
    reproduces: str = ""
    reason: str = ""
    thing: Any = field(default=None, repr=False)
    aliases: tuple[str, ...] = field(default=(), repr=False)
    texts: Mapping[str, str] = field(default_factory=dict, repr=False)

    def __getstate__(self) -> dict[str, Any]:
        """Return what is pickled or copied: all but a module, which cannot be."""
        return vars(self) | ({"thing": None} if isinstance(self.thing, ModuleType) else {})

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Import the module of a paper again."""
        vars(self).update(state)
        if self.kind == "paper":
            vars(self)["thing"] = paper(self.name)


class Listing(tuple[Listed, ...]):  # noqa: SLOT001  # it holds how it is written
    """Records that show themselves: as the text of the command line in a terminal, as a table in a notebook."""

    text: Callable[[], str]
    table: Callable[[], Table]

    def __new__(
        cls, records: Iterable[Listed], *, text: Callable[[], str], table: Callable[[], Table]
    ) -> Self:
        """Make a tuple of records with the functions that write it."""
        found = super().__new__(cls, records)
        found.text, found.table = text, table
        return found

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle what is written, because the functions that write it cannot be pickled."""
        return _listing, (tuple(self), self.text(), self.table())

    def __repr__(self) -> str:
        return self.text().rstrip("\n")

    def _repr_html_(self) -> str:
        from electrovib.core.answer import as_html

        return as_html(self.table())


def _listing(records: Iterable[Listed], text: str, table: Table) -> Listing:
    """Make a listing of what was written of another."""
    return Listing(records, text=lambda: text, table=lambda: table)


PREDICTS: dict[type[Model], str] = {
    Drive: "voltage or current of the drive",
    Material: "permittivity and conductivity of a layer",
    ReturnPath: "the return path of the current",
    ForceLaw: "attraction of the finger",
    Contact: "contact area",
    Friction: "friction force",
}
"""The main families a user chooses from, in the order in which data flow; others come after them."""
ANY_LAYER: Final = "LAYER"
"""Stands for the name of a layer in a dotted path."""


def families() -> dict[type[Model], str]:
    """Find every family of models and what its members compute, the main families first."""
    import_textbook()
    contributed = {module.__name__ for module in papers().values()}
    others = {
        family: first_sentence(family).lower()
        for family in Model.__subclasses__()
        if family.is_family
        and family not in PREDICTS
        and not family.__module__.startswith("electrovib.scenario")
        and (family.__module__.startswith("electrovib.") or family.__module__ in contributed)
    }
    return PREDICTS | dict(sorted(others.items(), key=lambda item: item[0].__name__))


def places() -> dict[type[Model], str]:
    """Find the dotted path at which a scenario first holds the members of each family, with `ANY_LAYER` for a layer."""
    found: dict[type[Model], str] = {}
    waiting: list[tuple[type[Model], str]] = [(Scenario, "")]
    seen: set[type[Model]] = set()
    while waiting:
        kind, prefix = waiting.pop(0)
        names = (ANY_LAYER,) if kind is Stack else tuple(kind.model_fields)
        for name in names:
            part = kind.part(name)
            if part is None or part in seen:
                continue
            seen.add(part)
            path = f"{prefix}{name}"
            if part.is_family:
                found[part] = path
            inner = find_members(part).values() if part.is_family else (part,)
            waiting += [(member, f"{path}.") for member in inner]
    return found


def kind_of(family: type[Any]) -> str:
    """Write the name of a class as words in small letters, ``ForceLaw`` as ``force law``."""
    return " ".join(re.findall(r"[A-Z][a-z0-9]*", family.__name__)).lower()


def first_sentence(thing: object) -> str:
    """Return the first sentence of a docstring, without its full stop."""
    return re.split(r"(?<!et al)\. ", plain_text(inspect.getdoc(thing) or ""))[0].rstrip(".")


def plain_text(text: str) -> str:
    """Put a text on one line."""
    return " ".join(text.split())


REMARKS: Final = ("notes", "reference", "claims", "not read", "sources")
"""Labels of texts that mention many things besides what they are about."""
PAPERS, SCENARIOS, LIBRARY = "papers", "scenarios", "material library"
"""Groups of records that are no families of models."""


def everything(*, own: bool = False) -> Iterator[Listed]:
    """Yield models by family, parts of a scenario without a choice, papers, and what papers offer ready-made."""
    yield from parts_and_papers(own=own)
    yield from scenario_items()


def parts_and_papers(*, own: bool = False) -> Iterator[Listed]:
    """Yield everything but the scenarios, which take as long to build as all else to import."""
    yield from model_items(own=own)
    yield from _parts()
    yield from paper_items(own=own)
    yield from _library()
    yield from _offered()


def is_own(thing: type[Model] | ModuleType) -> bool:
    """Tell whether a model or a paper is of this package, and not contributed by another one."""
    place = thing.__name__ if isinstance(thing, ModuleType) else thing.__module__
    return place.partition(".")[0] == __name__.partition(".")[0]


def model_items(*, own: bool = False) -> Iterator[Listed]:
    """Collect the members of every family; `own` as for `everything`."""
    for family, predicts in families().items():
        for _, model in sorted(find_members(family).items()):
            if own and not is_own(model):
                continue
            yield _of_model(model, kind_of(family), predicts)


def _parts() -> Iterator[Listed]:
    """Collect models that belong to no family, such as the amplifier."""
    for part in Model.__subclasses__():
        if not part.is_family and part.__module__.startswith("electrovib."):
            yield _of_model(part, "part of a scenario", "parts of a scenario")


def _of_model(model: type[Model], kind: str, group: str) -> Listed:
    author_year = paper_of(model)
    count = len(model.checks) + (len(_checks(papers()[author_year])) if author_year else 0)
    parameters = {name: _meaning(model, name) for name in model.model_fields}
    parameters |= {name: quantity.doc for name, quantity in model.derived.items()}
    texts = {"parameters": ", ".join(f"{name} ({meaning})" for name, meaning in parameters.items())}
    texts |= {"group": f"{kind}, {group}", "notes": inspect.getdoc(model) or "", "reference": model.reference}
    return Listed(
        name=model.__name__,
        kind=kind,
        meaning=first_sentence(model),
        group=group,
        paper=author_year,
        status=model.status,
        checks=count,
        thing=model,
        texts=texts,
    )


def _meaning(model: type[Model], parameter: str) -> str:
    quantity = quantity_of(model, parameter)
    return quantity.doc if quantity else model.model_fields[parameter].description or ""


def paper_items(*, own: bool = False) -> Iterator[Listed]:
    """Collect the papers; `own` as for `everything`."""
    for name, module in papers().items():
        if own and not is_own(module):
            continue
        unread = plain_text(getattr(module, "NOT_READ", ""))
        runs = hasattr(module, "scenarios") or hasattr(module, "skins")
        yield Listed(
            name=name,
            kind="paper",
            meaning=_title(module),
            group=PAPERS,
            paper=name,
            status=getattr(module, "STATUS", ""),
            checks=len(_checks(module)),
            runnable="yes" if runs or not unread else f"not: {unread}",
            thing=module,
            texts={"citation": module.CITATION, "claims": module.__doc__ or "", "not read": unread},
        )


def _title(module: ModuleType) -> str:
    """Return the title of a paper, or what it is about; the whole citation where neither is declared."""
    citations: tuple[Citation, ...] = getattr(module, "CITATIONS", ())
    known = citations[0].title or citations[0].about if citations else ""
    return known or str(module.CITATION)


def _checks(module: ModuleType) -> tuple[Any, ...]:
    return tuple(getattr(module, "CHECKS", ()))


def _library() -> Iterator[Listed]:
    for substance in materials():
        material = Material.from_offer(substance)
        status = (
            substance.permittivity[0].status if substance.dispersion is None else substance.dispersion.status
        )
        yield Listed(
            name=substance.name,
            kind="material",
            meaning=f"{substance.meaning}: {_content(material)}",
            group=LIBRARY,
            status=status,
            thing=substance,
            aliases=substance.aliases,
            texts={
                "kind": substance.kind,
                "model": type(material).__name__,
                "source": substance.strength_words,
            },
        )


def _offered() -> Iterator[Listed]:
    for function, kind in (("materials", "material"), ("skins", "skin"), ("stacks", "stack")):
        for name, thing in offers((function,)).items():
            author_year = name.partition("/")[0]
            if kind == "skin":
                meaning, status, source = f"{thing.name}: {thing.note}", thing.status, thing.source
            else:
                meaning, status, source = _content(thing), papers()[author_year].STATUS, ""
            yield Listed(
                name=name,
                kind=kind,
                meaning=meaning,
                group=function,
                paper=author_year,
                status=status,
                thing=thing,
                texts={"source": source, "model": type(thing).__name__},
            )


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


def scenario_count() -> int:
    """Return the number of ready-made scenarios; those of our papers are not built for it."""
    return sum(
        len(getattr(module, "PRESETS", ()) if is_own(module) else getattr(module, "scenarios", dict)())
        for module in papers().values()
    )


def scenario_items() -> Iterator[Listed]:
    """Collect the ready-made scenarios of all papers."""
    for name, scenario in offers(("scenarios",)).items():
        author_year = name.partition("/")[0]
        module, note = papers()[author_year], note_of(name)
        models = (type(part).__name__ for part in (scenario.drive, scenario.force, scenario.friction))
        yield Listed(
            name=name,
            kind="scenario",
            meaning=scenario.title,
            group=SCENARIOS,
            paper=author_year,
            status=getattr(module, "STATUS", ""),
            reproduces=note.reproduces,
            thing=scenario,
            texts={
                "keywords": note.keywords,
                "reproduces": note.reproduces,
                "stack": stack_text(scenario.stack),
                "models": ", ".join(models),
                "paper": module.CITATION,
                "sources": "; ".join(dict.fromkeys(scenario.sources.values())),
            },
        )
