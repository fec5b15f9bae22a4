"""Values over which parameters are swept, read from texts."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.errors import InputError
from electrovib.core.paths import quantity_at
from electrovib.core.units import expected, parse_quantity

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.scenario import Scenario

_RANGE = re.compile(r"([^=]+)=(.+):(.+):(\d+)(log)?")
_FORM = "expected PATH=FROM:TO:N or PATH=FROM:TO:Nlog, for instance drive.rise=1ms:100ms:30log"


def parse_over(scenario: Scenario, texts: Sequence[str]) -> dict[str, Real]:
    """Read ``path=from:to:n``, or ``path=from:to:nlog`` for even spacing in the logarithm, as values in SI by path."""
    found: dict[str, Real] = {}
    problems: list[str] = []
    for text in texts:
        try:
            path, values = _parse_one(scenario, text)
            if path in found:
                problems.append(f"--over {text}: '{path}' is swept twice")
            found[path] = values
        except InputError as error:
            problems += error.problems
    if problems:
        raise InputError(problems)
    return found


def _parse_one(scenario: Scenario, text: str) -> tuple[str, Real]:
    match = _RANGE.fullmatch(text.strip())
    if match is None:
        raise InputError(f"--over {text}: {_FORM}")
    path, count = match[1].strip(), int(match[4])
    quantity = quantity_at(scenario, path)
    if path.startswith("frequency."):
        raise InputError(f"--over {path}: all cases share the grid of frequencies; use --set")
    if not 2 <= count <= 10**5:
        raise InputError(f"--over {text}: n must be a whole number from 2 to 100000")
    ends = []
    for end in (match[2], match[3]):
        try:
            ends.append(parse_quantity(end, quantity.unit))
        except ValueError:
            raise InputError(f"--over {path}: '{end}': {expected(quantity.unit)}") from None
    if match[5] and min(ends) <= 0:
        raise InputError(f"--over {text}: a logarithmic range needs both ends above 0")
    spacing = np.geomspace if match[5] else np.linspace
    return path, spacing(ends[0], ends[1], count)
