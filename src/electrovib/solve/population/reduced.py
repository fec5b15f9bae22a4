"""Materials that are reduced to Debye terms once for all fingers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.physics.debye_sum import DebyeSum
from electrovib.solve.one_by_one import value_of
from electrovib.solve.stack.expand import reductions
from electrovib.solve.stack.transfer import NotInArraysError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Real
    from electrovib.physics.material import Material
    from electrovib.scenario import Scenario


AT: Final = 1e3
"""Frequency at which the scale of a permittivity is evaluated [Hz]; any other gives the same."""
_FACTORS: Final = ((0.9, 1.05, 0.97), (1.1, 0.95, 1.08), (0.8, 0.93, 1.02))
_CONSTANT: Final = 1e-13
"""Relative variation over frequency up to which the ratio of two permittivities is constant."""


@dataclass(frozen=True, eq=False)
class SharedReduction:
    """Bound permittivity of a material as Debye terms, which is that of each finger up to a factor.

    Parameters
    ----------
    debye : DebyeSum
        Terms for the values of the scenario.
    level : float
        Modulus of the declared bound permittivity of the scenario at the frequency `AT` [1].
    is_scaled : bool
        Whether the fingers differ by a factor.
    """

    debye: DebyeSum
    level: float
    is_scaled: bool

    def of_fingers(self, material: Material) -> DebyeSum:
        """Return the terms for each finger, with the relaxation times and the relative error of the scenario."""
        known = self.debye
        if not self.is_scaled:
            return known
        factor: Any = np.abs(material.bound_permittivity(np.array([AT]))) / self.level
        strengths = tuple(strength * factor for strength in known.strengths)
        return DebyeSum(known.high * factor, strengths, known.relaxation_times)


def debye_of(
    scenario: Scenario, reduced: Mapping[str, SharedReduction], free: tuple[str, ...]
) -> dict[str, DebyeSum]:
    """Return the relaxations of every layer of a scenario with columns."""
    found = {}
    for name, layer in scenario.stack.layers.items():
        try:
            exact = reduced[name].of_fingers(layer.material) if name in reduced else layer.material.debye()
        except (TypeError, ValueError):
            exact = None
        if exact is None:
            start = f"stack.{name}.material."
            mine = [path for path in free if path.startswith(start)]
            raise NotInArraysError(
                f"{(mine or [start])[0]} is not a term of a finite sum of relaxations, so that each finger needs a"
                " formula of its own"
            )
        found[name] = exact
    return found


def shared_reductions(scenario: Scenario, free: tuple[str, ...], time: Real) -> dict[str, SharedReduction]:
    """Reduce the bound permittivities that are no finite sums of Debye terms, once for all fingers.

    `time` (n,) [s].
    """
    layers = scenario.stack.layers
    scaled = {}
    for name in [name for name, layer in layers.items() if layer.material.debye() is None]:
        start = f"stack.{name}.material."
        changed = [path.removeprefix(start) for path in free if path.startswith(start)]
        shape = [path for path in changed if path != "conductivity"]
        if "conductivity" in changed and not _is_apart(layers[name].material):
            raise NotInArraysError(
                f"the bound permittivity of stack.{name}.material depends on its conductivity"
            )
        if shape and not _is_factor(layers[name].material, shape):
            raise NotInArraysError(
                f"{start}{shape[0]} changes a permittivity that each finger has to reduce by itself"
            )
        scaled[name] = bool(shape)
    if not scaled:
        return {}
    found = reductions(scenario, time)
    return {
        name: SharedReduction(
            found[name].debye,
            float(np.abs(layers[name].material.bound_permittivity(np.array([AT]))[0])),
            is_scaled,
        )
        for name, is_scaled in scaled.items()
    }


def _is_factor(material: Any, paths: list[str]) -> bool:
    """Return whether parameters of a material multiply its bound permittivity by the same number at all frequencies."""
    frequency = np.geomspace(1e-2, 1e8, 41)
    base = material.bound_permittivity(frequency)
    for factors in _FACTORS:
        point = {path: value_of(material, path) * factors[place % 3] for place, path in enumerate(paths)}
        try:
            other = material.replace(point)
        except InputError:
            return False
        ratio = other.bound_permittivity(frequency) / base
        if np.any(np.abs(ratio / np.abs(ratio[0]) - 1) > _CONSTANT):
            return False
        if other.slowest_relaxation != material.slowest_relaxation:
            return False
    return True


def _is_apart(material: Any) -> bool:
    """Return whether the bound permittivity does not depend on the conductivity."""
    frequency = np.geomspace(1e-2, 1e8, 21)
    try:
        other = material.replace({"conductivity": 0.5 * material.conductivity or 1e-6})
    except InputError:
        return False
    one, two = (each.bound_permittivity(frequency) for each in (material, other))
    return bool(np.array_equal(one, two)) and material.slowest_relaxation == other.slowest_relaxation
