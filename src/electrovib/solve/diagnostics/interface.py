"""Which layer is the film, the gap or the skin, and the field where the finger separates from the plate."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from electrovib.core.constants import eps0

if TYPE_CHECKING:
    from electrovib.solve.scenario import Scenario
    from electrovib.solve.transfer import Real


class Sides(NamedTuple):
    """Names of the layers of the plate, of the gap if there is one, and of the finger."""

    plate: tuple[str, ...]
    gap: str | None
    finger: tuple[str, ...]


def layers_of(scenario: Scenario) -> Sides:
    """Tell which layers belong to the plate, to the gap and to the finger."""
    names = list(scenario.stack.layers)
    gap = "gap" if "gap" in names else None
    plate = tuple(name for name in names if name == "insulator")
    finger = tuple(name for name in names if name == "stratum_corneum")
    return Sides(plate, gap, finger)


def interface_field(scenario: Scenario, found: dict[str, Real]) -> Real:
    """Give the field of the gap, or of a vanishing one.

    Parameters
    ----------
    scenario : Scenario
        Stack.
    found : dict of str to ndarray, shape (n,)
        What a solver found.

    Returns
    -------
    ndarray, shape (n,)
        V/m; NaN where it is not known.
    """
    known = found.get("interface_field")
    if known is not None:
        return known
    gap = layers_of(scenario).gap
    if gap is not None:
        return found[f"field {gap}"]
    if "displacement insulator" in found:
        return found["displacement insulator"] / eps0
    return np.full(len(found["stack_voltage"]), np.nan)
