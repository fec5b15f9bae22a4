"""Sources of the values of a ready-made scenario: which are found in its paper, and which are not."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from electrovib.core.units import format_quantity

if TYPE_CHECKING:
    from electrovib.core.model import Model
    from electrovib.scenario.experiment import Scenario

BY_THE_USER = "set by the user"
"""Source of a value that the user has changed."""


def is_default(model: Model, path: str, value: Any) -> bool:
    """Return whether a value is the default of its model."""
    owner: Any = model
    *parents, name = path.split(".")
    for part in parents:
        owner = owner[int(part)] if isinstance(owner, tuple) else getattr(owner, part)
    return bool(type(owner).model_fields[name].default == value)


def not_in_paper(scenario: Scenario, paper: str) -> dict[str, str]:
    """Find the values, as text by dotted path, of a paper's scenario that are not found in the paper.

    A value is found in the paper if its source begins with author and year, as in ``Vezzoli 2014, section
    4``. Values that the user has set, and defaults of 0, which switch an effect off, are left out.
    """
    author, _, year = paper.partition("_")
    printed = f"{author.capitalize()} {year}"
    found = {}
    for path, value, quantity in scenario.parameters():
        source = scenario.sources.get(path)
        if source is None or value is None or source.startswith((BY_THE_USER, printed)):
            continue
        if value != 0 or not is_default(scenario, path, value):
            found[path] = format_quantity(value, quantity.unit, digits=4)
    return found
