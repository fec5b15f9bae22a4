"""What there is to choose from: models and papers, with how each was read and how often it is checked."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from dataclasses import dataclass
from types import ModuleType
from typing import Any, get_args

from electrovib.core.discovery import find_members, paper_of, papers
from electrovib.core.errors import InputError, nearest
from electrovib.core.model import Model
from electrovib.core.quantity import quantity_of
from electrovib.core.samples import Samples
from electrovib.core.units import format_quantity
from electrovib.physics.circuit import ReturnPath
from electrovib.physics.contact import Contact
from electrovib.physics.drive.base import Drive
from electrovib.physics.force import ForceLaw
from electrovib.physics.friction import Friction
from electrovib.physics.material import Material
from electrovib.study.reproduction import Table

NAMES = (
    "A skin, a material or a stack of a paper is used by its name, which 'electrovib models PAPER' lists:"
    " --set stack.stratum_corneum.material=gabriel_1996/wet"
)
"""For people who look for one."""

PREDICTS: dict[type[Model], str] = {
    Drive: "voltage or current of the drive",
    Material: "permittivity and conductivity of a layer",
    ReturnPath: "the way back of the current",
    ForceLaw: "attraction of the finger",
    Contact: "contact area",
    Friction: "friction force",
}
"""The main families a user chooses from, in the order in which data flow; others come after them."""


def families() -> dict[type[Model], str]:
    """Find every family of models and what its members predict.

    Returns
    -------
    dict of type to str
        The main families first; the others say it by their docstring.
    """
    find_members(ForceLaw)  # all physics and papers are imported then
    contributed = {module.__name__ for module in papers().values()}
    others = {
        family: _plain(inspect.getdoc(family) or "").split(". ")[0].rstrip(".").lower()
        for family in Model.__subclasses__()
        if family.is_family
        and family not in PREDICTS
        and not family.__module__.startswith("electrovib.scenario")
        and (family.__module__.startswith("electrovib.") or family.__module__ in contributed)
    }
    return PREDICTS | dict(sorted(others.items(), key=lambda item: item[0].__name__))


@dataclass(frozen=True, kw_only=True)
class Listed:
    """One model or paper of the catalogue.

    Parameters
    ----------
    name : str
        What to write after ``model =``, or the paper's name.
    predicts : str
        Group.
    paper : str
        ``author_year``, or empty for a law of the textbook.
    status : str
        How the source was read; empty for a definition.
    checks : int
        Numbers of sources it is checked against.
    runnable : str
        ``"yes"``, or why not.
    """

    name: str
    predicts: str
    paper: str
    status: str
    checks: int
    runnable: str


def is_own(thing: type[Model] | ModuleType) -> bool:
    """Tell whether a model or a paper is of this package, and not contributed by another one."""
    place = thing.__name__ if isinstance(thing, ModuleType) else thing.__module__
    return place.partition(".")[0] == __name__.partition(".")[0]


def models(name: str = "", *, own: bool = False) -> tuple[Listed, ...]:
    """List all models, then all papers.

    Parameters
    ----------
    name : str
        Only this model or paper; all if empty.
    own : bool
        Leave out what other packages contribute.

    Returns
    -------
    tuple of Listed
        Found, never kept in a list of names.

    Raises
    ------
    InputError
        For an unknown name, with the nearest one.
    """
    if name:
        find(name)
        return tuple(entry for entry in models() if entry.name == name)
    found = []
    for family, predicts in families().items():
        for key, model in sorted(find_members(family).items()):
            if own and not is_own(model):
                continue
            author_year = paper_of(model)
            count = len(model.checks) + (len(_checks(papers()[author_year])) if author_year else 0)
            found.append(
                Listed(
                    name=key,
                    predicts=predicts,
                    paper=author_year,
                    status=model.status,
                    checks=count,
                    runnable="yes",
                )
            )
    for key, module in papers().items():
        if own and not is_own(module):
            continue
        runnable = "not: " + _plain(getattr(module, "NOT_READ", "")) if _not_runnable(module) else "yes"
        status = getattr(module, "STATUS", "")
        found.append(
            Listed(
                name=key,
                predicts="papers",
                paper=key,
                status=status,
                checks=len(_checks(module)),
                runnable=runnable,
            )
        )
    return tuple(found)


def _checks(module: ModuleType) -> tuple[Any, ...]:
    return tuple(getattr(module, "CHECKS", ()))


def _not_runnable(module: ModuleType) -> bool:
    return (
        not hasattr(module, "scenarios")
        and not hasattr(module, "skins")
        and bool(getattr(module, "NOT_READ", ""))
    )


def tables(*, own: bool = False) -> Iterator[Table]:
    """Give the catalogue as one table for each thing predicted; `own` as for `models`."""
    everything = models(own=own)
    for group in dict.fromkeys(entry.predicts for entry in everything):
        lines = [entry for entry in everything if entry.predicts == group]
        if group == "papers":
            headings: tuple[str, ...] = ("paper", "how read", "checks", "runnable")
            rows = tuple((e.name, e.status, str(e.checks), e.runnable) for e in lines)
        else:
            headings = ("model", "paper", "how read", "checks")
            rows = tuple((e.name, e.paper or "-", e.status or "definition", str(e.checks)) for e in lines)
        yield Table(group, headings, rows)


def ready_made(module: ModuleType, name: str) -> Iterator[tuple[str, str]]:
    """Give what a paper offers by name: what it is, and how it is written.

    Parameters
    ----------
    module : module
        The paper.
    name : str
        ``author_year``.

    Yields
    ------
    tuple of str
        ``"run"``, ``"skin"``, ``"material"`` or ``"stack"``; ``author_year/name`` with a few words.
    """
    for key, scenario in getattr(module, "scenarios", dict)().items():
        yield "run", f"electrovib run {name}/{key} ({scenario.title})"
    for key, skin in getattr(module, "skins", dict)().items():
        yield "skin", f"{name}/{key}: {skin.name} ({skin.status}): {skin.note}"
    for key, material in getattr(module, "materials", dict)().items():
        yield "material", f"{name}/{key}: {type(material).__name__}"
    for key, stack in getattr(module, "stacks", dict)().items():
        yield "stack", f"{name}/{key}: {', '.join(stack.layers)}"


def find(name: str) -> type[Model] | ModuleType:
    """Find a model or a paper by name.

    Raises
    ------
    InputError
        With the nearest name.
    """
    known: dict[str, Any] = dict(papers())
    for family in families():
        for key, model in find_members(family).items():
            known.setdefault(key, model)
    for part in Model.__subclasses__():  # parts without a choice, such as the amplifier
        if not part.is_family and part.__module__.startswith("electrovib."):
            known.setdefault(part.__name__, part)
    if name not in known:
        raise InputError(f"'{name}' is neither a model nor a paper.{nearest(name, known)}")
    found: type[Model] | ModuleType = known[name]
    return found


def parameters(model: type[Model]) -> Table:
    """Give a model's parameters: unit, range, default, meaning, source of the default."""
    rows = []
    for name, declared in model.model_fields.items():
        quantity = quantity_of(model, name)
        default = None if declared.is_required() else declared.get_default(call_default_factory=True)
        needed = "needed" if declared.is_required() else ""
        if quantity is None:
            meaning = declared.description or _family_of(declared.annotation)
            rows.append((name, "", "", needed or _named(default), meaning, _source(model, default, needed)))
            continue
        shown = needed or ("none" if default is None else format_quantity(default, quantity.unit))
        source = quantity.source or _source(model, default, needed)
        rows.append((name, quantity.unit, quantity.range(" to "), shown, quantity.doc, source))
    return Table("parameters", ("name", "unit", "range", "default", "meaning", "source"), tuple(rows))


def _named(default: Any) -> str:
    if isinstance(default, Samples):
        return "none" if not len(default) else str(default)
    return type(default).__name__ if isinstance(default, Model) else str(default) or "none"


def _family_of(annotation: Any) -> str:
    """Say what a parameter is that is itself a model."""
    known = families()
    return next((known[kind] for kind in (annotation, *get_args(annotation)) if kind in known), "")


def _source(model: type[Model], default: Any, needed: str) -> str:
    if needed:
        return "yours to give"
    if default is None or default in (0.0, "") or (isinstance(default, Samples) and not len(default)):
        return "nothing unless given"
    return (paper_of(model) and model.reference) or "a choice"


def values(module: ModuleType) -> Table | None:
    """Give what a paper's ready-made scenarios are made of, with the source of each value.

    Parameters
    ----------
    module : module
        The paper.

    Returns
    -------
    Table or None
        One row for each parameter and source; None without scenarios.
    """
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
    """Read from a paper's docstring what it claims and what it does not.

    Returns
    -------
    dict of str to str
        ``claims``, ``does not claim``, and ``here``: what the docstring says of our computation after that. A paper
        without the first two is refused by the tests.
    """
    text = _plain(inspect.getdoc(module) or "")
    found = re.search(r"Claims: (.*?)\s*Does not claim: (.*)", text)
    if not found:
        return {}
    without, _, here = found[2].partition(". ")
    said = {"claims": found[1], "does not claim": f"{without.rstrip('.')}."}
    return said | {"here": here} if here else said


def _plain(text: str) -> str:
    return " ".join(text.split())


def bibtex(module: ModuleType, name: str) -> str:
    """Give a paper's citation as a BibTeX entry.

    Parameters
    ----------
    module : module
        The paper.
    name : str
        ``author_year``, the key.

    Returns
    -------
    str
        ``@misc`` with the citation as a note, and the DOI where the citation has one.
    """
    citation = module.CITATION
    note = re.sub(r"(?<!\\)([&%#_])", r"\\\1", citation)
    doi = re.search(r"doi:(10\.\S+?)(?=[\s,;)]|$)", citation)
    year = re.search(r"_(\d{4})", name)
    fields = [f"  note = {{{note}}}"]
    if year:
        fields.append(f"  year = {{{year[1]}}}")
    if doi:
        fields.append(f"  doi = {{{doi[1]}}}")
    return f"@misc{{{name},\n" + ",\n".join(fields) + "\n}"
