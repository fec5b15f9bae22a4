"""A scenario whose numbers are columns with one value for each finger, and its materials, reduced once for all fingers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, TypeVar

import numpy as np

from electrovib.core.errors import InputError, refuse
from electrovib.core.model import Model
from electrovib.core.paths import nested
from electrovib.physics.debye_sum import DebyeSum
from electrovib.solve.one_by_one import value_of
from electrovib.solve.stack.expand import reductions
from electrovib.solve.stack.transfer import NotInArraysError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Real
    from electrovib.core.quantity import Quantity
    from electrovib.physics.material import Material
    from electrovib.scenario import Scenario

M = TypeVar("M", bound=Model)
AT: Final = 1e3
"""Frequency at which the scale of a permittivity is evaluated [Hz]; any other gives the same."""
_FACTORS: Final = ((0.9, 1.05, 0.97), (1.1, 0.95, 1.08), (0.8, 0.93, 1.02))
_CONSTANT: Final = 1e-13
"""Relative variation over frequency up to which the ratio of two permittivities is constant."""


def with_columns(model: M, columns: Mapping[str, Any]) -> M:
    """Return a copy of a model with columns in the place of some numbers; nothing is validated."""
    copied: M = _copied(model, nested(columns))
    return copied


def _copied(model: Any, tree: Mapping[str, Any]) -> Any:
    if isinstance(model, tuple):
        return tuple(
            _copied(each, tree[str(index)]) if str(index) in tree else each
            for index, each in enumerate(model)
        )
    update = {
        key: _copied(getattr(model, key), change) if isinstance(change, dict) else change
        for key, change in tree.items()
    }
    return model.model_copy(update=update)


def check_values(scenario: Scenario, quantities: Mapping[str, Quantity], columns: Mapping[str, Real]) -> None:
    """Refuse values outside the range of their parameters, and those that a model refuses together."""
    problems = []
    for path, values in columns.items():
        quantity = quantities[path]
        wrong = ~((values >= quantity.low) & (values <= quantity.high))
        if np.any(wrong):
            finger = int(np.argmax(wrong))
            problems.append(
                f"{path} = {values[finger]:.6g}: must lie between {quantity.range()} (finger {finger} of the call)"
            )
    refuse(problems)
    problems = [
        why for part, own in _parts(scenario, columns).items() if (why := _refused(scenario, part, own))
    ]
    refuse(problems)


def _parts(scenario: Scenario, columns: Mapping[str, Real]) -> dict[str, dict[str, Real]]:
    """Return the columns within each member of a family that checks parameters together, by the path of the member."""
    found: dict[str, dict[str, Real]] = {}
    for path, values in columns.items():
        keys = path.split(".")
        for place in range(1, len(keys)):
            part = ".".join(keys[:place])
            if checks_together(type(value_of(scenario, part))):
                found.setdefault(part, {})[".".join(keys[place:])] = values
    return found


def checks_together(kind: type) -> tuple[str, ...]:
    """Return the methods of a member of a family that check several of its parameters; none of any other class."""
    if not (issubclass(kind, Model) and kind.is_member):
        return ()
    found = kind.__pydantic_decorators__.model_validators.items()
    return tuple(name for name, each in found if each.info.mode == "after")


def _refused(scenario: Scenario, part: str, columns: Mapping[str, Real]) -> str:
    """Return why a model refuses values, with the first finger; empty if it accepts them all."""
    model = value_of(scenario, part)
    try:  # a check of other parameters than these runs once for all fingers
        _checked(with_columns(model, {path: values[:, None] for path, values in columns.items()}))
    except (TypeError, ValueError, AssertionError):
        pass
    else:
        return ""
    for finger in range(len(next(iter(columns.values())))):
        try:
            _checked(with_columns(model, {path: float(values[finger]) for path, values in columns.items()}))
        except (ValueError, AssertionError) as error:
            return f"{part}: {error} (finger {finger} of the call)"
    return ""


def _checked(model: Model) -> None:
    for name in checks_together(type(model)):
        getattr(model, name)()


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
    return True


def _is_apart(material: Any) -> bool:
    """Return whether the bound permittivity does not depend on the conductivity."""
    frequency = np.geomspace(1e-2, 1e8, 21)
    try:
        other = material.replace({"conductivity": 0.5 * material.conductivity or 1e-6})
    except InputError:
        return False
    one, two = (each.bound_permittivity(frequency) for each in (material, other))
    return bool(np.array_equal(one, two))
