"""The families of models, and what the members of each predict."""

from __future__ import annotations

import inspect

from electrovib.core.discovery import find_members, papers
from electrovib.core.model import Model
from electrovib.physics.circuit import ReturnPath
from electrovib.physics.contact import Contact
from electrovib.physics.drive.base import Drive
from electrovib.physics.force import ForceLaw
from electrovib.physics.friction import Friction
from electrovib.physics.material import Material

PREDICTS: dict[type[Model], str] = {
    Drive: "voltage or current of the drive",
    Material: "permittivity and conductivity of a layer",
    ReturnPath: "the return path of the current",
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
        family: plain_text(inspect.getdoc(family) or "").split(". ")[0].rstrip(".").lower()
        for family in Model.__subclasses__()
        if family.is_family
        and family not in PREDICTS
        and not family.__module__.startswith("electrovib.scenario")
        and (family.__module__.startswith("electrovib.") or family.__module__ in contributed)
    }
    return PREDICTS | dict(sorted(others.items(), key=lambda item: item[0].__name__))


def plain_text(text: str) -> str:
    """Put a text on one line."""
    return " ".join(text.split())
