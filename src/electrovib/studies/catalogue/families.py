"""The families of models: what the members of each compute, and where a scenario holds them."""

from __future__ import annotations

import inspect
import re
from typing import Any, Final

from electrovib.core.discovery import find_members, papers
from electrovib.core.model import Model
from electrovib.physics.circuit import ReturnPath
from electrovib.physics.contact import Contact
from electrovib.physics.drive.base import Drive
from electrovib.physics.force import ForceLaw
from electrovib.physics.friction import Friction
from electrovib.physics.material import Material
from electrovib.physics.stack import Stack
from electrovib.scenario import Scenario

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
    find_members(ForceLaw)  # all physics and papers are imported then
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
