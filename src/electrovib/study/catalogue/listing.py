"""The list of models and papers, with how each was read and how often it is checked."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from types import ModuleType
from typing import Any

from electrovib.core.discovery import find_members, paper_of, papers
from electrovib.core.errors import InputError, nearest
from electrovib.core.model import Model
from electrovib.core.records import Records
from electrovib.study.catalogue.families import families, plain_text
from electrovib.study.reproduction import Table


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


def is_own(thing: type[Model] | ModuleType) -> bool:
    """Tell whether a model or a paper is of this package, and not contributed by another one."""
    place = thing.__name__ if isinstance(thing, ModuleType) else thing.__module__
    return place.partition(".")[0] == __name__.partition(".")[0]


def models(name: str = "", *, own: bool = False) -> Records[Listed]:
    """List all models, then all papers.

    Parameters
    ----------
    name : str
        Only this model or paper; all if empty.
    own : bool
        Leave out what other packages contribute.

    Returns
    -------
    Records of Listed
        Found, never kept in a list of names.

    Raises
    ------
    InputError
        For an unknown name, with the nearest one.
    """
    if name:
        find(name)
        return Records(entry for entry in models() if entry.name == name)
    found = []
    for family, predicts in families().items():
        for key, model in sorted(find_members(family).items()):
            if own and not is_own(model):
                continue
            author_year = paper_of(model)
            count = len(model.checks) + (len(_checks(papers()[author_year])) if author_year else 0)
            found.append(Listed(key, predicts, author_year, model.status, count, "yes"))
    for key, module in papers().items():
        if own and not is_own(module):
            continue
        runnable = "not: " + plain_text(getattr(module, "NOT_READ", "")) if _not_runnable(module) else "yes"
        status = getattr(module, "STATUS", "")
        found.append(Listed(key, "papers", key, status, len(_checks(module)), runnable))
    return Records(found)


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
            headings: tuple[str, ...] = ("paper", "source status", "checks", "runnable")
            rows = tuple((e.name, e.status, str(e.checks), e.runnable) for e in lines)
        else:
            headings = ("model", "paper", "source status", "checks")
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
    for part in Model.__subclasses__():  # parts without a choice, such as the amplifier
        if not part.is_family and part.__module__.startswith("electrovib."):
            known.setdefault(part.__name__, part)
    if name not in known:
        raise InputError(f"'{name}' is neither a model nor a paper.{nearest(name, known)}")
    found: type[Model] | ModuleType = known[name]
    return found
