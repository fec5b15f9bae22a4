"""What there is to choose from: models and papers, with how each was read and how often it is checked."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from dataclasses import dataclass
from types import ModuleType
from typing import Any

from electrovib.core.discovery import find_members, paper_of, papers
from electrovib.core.errors import InputError, nearest
from electrovib.core.model import Model, quantity_of
from electrovib.core.units import format_quantity
from electrovib.physics.circuit import ReturnPath
from electrovib.physics.contact import Contact
from electrovib.physics.drive.base import Drive
from electrovib.physics.force import ForceLaw
from electrovib.physics.friction import Friction
from electrovib.physics.material import Material
from electrovib.study.reproduction import Table

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
        and family.__module__ != "electrovib.solve.scenario"
        and (family.__module__.startswith("electrovib.") or family.__module__ in contributed)
    }
    return PREDICTS | dict(sorted(others.items(), key=lambda item: item[0].__name__))


@dataclass(frozen=True)
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


def models() -> tuple[Listed, ...]:
    """List all models, then all papers.

    Returns
    -------
    tuple of Listed
        Found, never kept in a list of names.
    """
    found = []
    for family, predicts in families().items():
        for name, model in sorted(find_members(family).items()):
            author_year = paper_of(model)
            count = len(model.checks) + (len(_checks(papers()[author_year])) if author_year else 0)
            found.append(Listed(name, predicts, author_year, model.status, count, "yes"))
    for name, module in papers().items():
        runnable = "not: " + _plain(getattr(module, "NOT_READ", "")) if _not_runnable(module) else "yes"
        status = getattr(module, "STATUS", "")
        found.append(Listed(name, "papers", name, status, len(_checks(module)), runnable))
    return tuple(found)


def _checks(module: ModuleType) -> tuple[Any, ...]:
    return tuple(getattr(module, "CHECKS", ()))


def _not_runnable(module: ModuleType) -> bool:
    return (
        not hasattr(module, "scenarios")
        and not hasattr(module, "skins")
        and bool(getattr(module, "NOT_READ", ""))
    )


def tables() -> Iterator[Table]:
    """Give the catalogue as one table for each thing predicted."""
    everything = models()
    for group in dict.fromkeys(entry.predicts for entry in everything):
        lines = [entry for entry in everything if entry.predicts == group]
        if group == "papers":
            headings: tuple[str, ...] = ("paper", "how read", "checks", "runnable")
            rows = tuple((e.name, e.status, str(e.checks), e.runnable) for e in lines)
        else:
            headings = ("model", "paper", "how read", "checks")
            rows = tuple((e.name, e.paper or "-", e.status or "definition", str(e.checks)) for e in lines)
        yield Table(group, headings, rows)


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
    if name not in known:
        raise InputError(f"'{name}' is neither a model nor a paper.{nearest(name, known)}")
    found: type[Model] | ModuleType = known[name]
    return found


def parameters(model: type[Model]) -> Table:
    """Give a model's parameters: unit, range, default, meaning."""
    rows = []
    for name, declared in model.model_fields.items():
        quantity = quantity_of(model, name)
        if quantity is None:
            default = (
                "needed" if declared.is_required() else str(declared.get_default(call_default_factory=True))
            )
            rows.append((name, "", "", default[:40], declared.description or ""))
            continue
        default = "needed" if declared.is_required() else _shown(declared.default, quantity.unit)
        rows.append((name, quantity.unit, quantity.range(), default, quantity.doc))
    return Table("parameters", ("name", "unit", "range", "default", "meaning"), tuple(rows))


def _shown(value: float | None, unit: str) -> str:
    return "none" if value is None else format_quantity(value, unit)


def claims(module: ModuleType) -> dict[str, str]:
    """Read from a paper's docstring what it claims and what it does not.

    Returns
    -------
    dict of str to str
        ``claims`` and ``does not claim``; a paper without them is refused by the tests.
    """
    text = _plain(inspect.getdoc(module) or "")
    found = re.search(r"Claims: (.*?)\s*Does not claim: (.*)", text)
    return {"claims": found[1], "does not claim": found[2]} if found else {}


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
    doi = re.search(r"doi:(10\.\S+?)(?=[\s,;)]|$)", citation)
    year = re.search(r"_(\d{4})", name)
    fields = [f"  note = {{{citation}}}"]
    if year:
        fields.append(f"  year = {{{year[1]}}}")
    if doi:
        fields.append(f"  doi = {{{doi[1]}}}")
    return f"@misc{{{name},\n" + ",\n".join(fields) + "\n}"
