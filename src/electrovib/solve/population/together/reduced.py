"""Materials that are reduced to Debye terms once for all fingers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.errors import InputError
from electrovib.solve.population.together.refusal import NotTogetherError
from electrovib.solve.stack.expand import reductions

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Real
    from electrovib.physics.debye_sum import DebyeSum
    from electrovib.scenario import Scenario


def shared_reductions(scenario: Scenario, free: tuple[str, ...], time: Real) -> dict[str, DebyeSum]:
    """Return the bound permittivities that are no finite sums of Debye terms, reduced to such sums.

    Parameters
    ----------
    scenario : Scenario
        Experiment with the values that all fingers share.
    free : tuple of str
        Paths that differ between fingers.
    time : ndarray, shape (n,)
        Output times [s].

    Returns
    -------
    reduced : dict of str to DebyeSum
        Name of a layer to its reduced permittivity, which is that of every finger, with the same error.

    Raises
    ------
    NotTogetherError
        If the permittivity differs between fingers.
    """
    dispersive = [name for name, layer in scenario.stack.layers.items() if layer.material.debye() is None]
    for name in dispersive:
        start = f"stack.{name}.material."
        changed = [path.removeprefix(start) for path in free if path.startswith(start)]
        if any(path != "conductivity" for path in changed):
            raise NotTogetherError(
                f"{start}{changed[0]} changes a permittivity that each finger has to reduce by itself"
            )
        material = scenario.stack.layers[name].material
        if changed and not _is_apart(material):
            raise NotTogetherError(
                f"the bound permittivity of stack.{name}.material depends on its conductivity"
            )
    if not dispersive:
        return {}
    found = reductions(scenario, time)
    return {name: found[name].debye for name in dispersive}


def count_poles(scenario: Scenario, reduced: Mapping[str, DebyeSum]) -> int:
    """Return the number of poles of all layers of a scenario, with its reduced permittivities."""
    sums = [reduced.get(name) or layer.material.debye() for name, layer in scenario.stack.layers.items()]
    return sum(1 + len(each.strengths) for each in sums if each is not None)


def _is_apart(material: Any) -> bool:
    """Return whether the bound permittivity does not depend on the conductivity."""
    frequency = np.geomspace(1e-2, 1e8, 21)
    try:
        other = material.replace({"conductivity": 0.5 * material.conductivity or 1e-6})
    except InputError:
        return False
    one, two = (each.bound_permittivity(frequency) for each in (material, other))
    return bool(np.array_equal(one, two)) and material.slowest_relaxation == other.slowest_relaxation
