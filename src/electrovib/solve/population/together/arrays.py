"""A scenario whose numbers are columns with one value for each finger, and the Debye sums of its materials."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from electrovib.core.changes import stored_path
from electrovib.core.errors import InputError
from electrovib.core.model import Model
from electrovib.solve.population.together.refusal import NotTogetherError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Complex, Real
    from electrovib.core.quantity import Quantity
    from electrovib.physics.material import Material
    from electrovib.scenario import Scenario

M = TypeVar("M", bound=Model)

Column = Any
"""A number that all fingers share, or a column of shape (fingers, 1)."""


def with_columns(model: M, columns: Mapping[str, Any]) -> M:
    """Return a copy of a model with columns in the place of some numbers; nothing is validated."""
    tree: dict[str, Any] = {}
    for path, column in columns.items():
        *parents, last = path.split(".")
        branch = tree
        for key in parents:
            branch = branch.setdefault(key, {})
        branch[last] = column
    copied: M = _copied(model, tree)
    return copied


def _copied(model: Any, tree: Mapping[str, Any]) -> Any:
    if isinstance(model, tuple):
        return tuple(
            _copied(each, tree[str(index)]) if str(index) in tree else each
            for index, each in enumerate(model)
        )
    content = dict(model)
    update = {
        key: _copied(content[key], change) if isinstance(change, dict) else change
        for key, change in tree.items()
    }
    if not set(update) & set(model.__pydantic_extra__ or {}):
        return model.model_copy(update=update)
    # layers are the extra fields of a stack
    copied = model.model_copy()
    object.__setattr__(copied, "__pydantic_extra__", {**model.__pydantic_extra__, **update})
    return copied


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
    if problems:
        raise InputError(problems)
    problems = [
        why for part, own in _parts(scenario, columns).items() if (why := _refused(scenario, part, own))
    ]
    if problems:
        raise InputError(problems)


def _parts(scenario: Scenario, columns: Mapping[str, Real]) -> dict[str, dict[str, Real]]:
    """Return the columns within each member of a family that checks parameters together, by the path of the member."""
    found: dict[str, dict[str, Real]] = {}
    for path, values in columns.items():
        keys = stored_path(scenario, path).split(".")
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
class ManyDebye:
    """Debye terms of the bound permittivity of a layer, each number shared or a column.

    Parameters
    ----------
    high : float or ndarray, shape (fingers, 1)
        Relative permittivity far above all relaxations [1].
    strengths, relaxation_times : tuple of float or ndarray, shape (fingers, 1)
        Strength [1] and time [s] of each relaxation.
    """

    high: Column
    strengths: tuple[Column, ...] = ()
    relaxation_times: tuple[Column, ...] = ()


class ManyMaterial:
    """A material whose parameters are columns: its formulas, with its Debye terms.

    Parameters
    ----------
    material : Material
        Copy of the material with columns, as `with_columns` makes it.
    debye : ManyDebye or None
        Its Debye terms; None if it is no finite sum of them.
    free : tuple of str
        Paths of the columns in the material.
    """

    def __init__(self, material: Material, debye: ManyDebye | None, free: tuple[str, ...] = ()) -> None:
        self._material, self._debye, self._free = material, debye, free
        self._known: dict[str, tuple[Real, Complex]] = {}

    def __getattr__(self, name: str) -> Any:
        """Return an attribute of the material with columns."""
        return getattr(self._material, name)

    def debye(self) -> ManyDebye | None:
        """Return the Debye terms; None if the material is no finite sum of them."""
        return self._debye

    def bound_permittivity(self, frequency: Real) -> Complex:
        """Return the relative permittivity of the bound charge [1] at frequencies [Hz], a row for each finger that differs."""
        return self._over(frequency, "bound_permittivity")

    def complex_permittivity(self, frequency: Real) -> Complex:
        """Return the relative permittivity with conduction [1] at frequencies [Hz], a row for each finger that differs."""
        return self._over(frequency, "complex_permittivity")

    def _over(self, frequency: Real, name: str) -> Complex:
        """Return a permittivity, computed once for the same array of frequencies."""
        known = self._known.get(name)
        if known is None or known[0] is not frequency:
            known = self._known[name] = frequency, self._rows(frequency, name)
        return known[1]

    def _rows(self, frequency: Real, name: str) -> Complex:
        formula: Any = getattr(self._material, name)
        if not self._free:
            return np.asarray(formula(frequency))
        rows = [value_of(self._material, path) for path in self._free]
        shape = len(rows[0]), len(frequency)
        for axis in (frequency, np.broadcast_to(frequency, shape)):
            try:
                found = np.asarray(formula(axis))
            except (TypeError, ValueError):
                continue
            if found.shape == shape:
                return found
        # a formula of numbers, not of arrays
        single = (
            {path: float(row[finger, 0]) for path, row in zip(self._free, rows, strict=True)}
            for finger in range(shape[0])
        )
        return np.array([getattr(with_columns(self._material, point), name)(frequency) for point in single])


def value_of(model: Any, path: str) -> Any:
    """Return what a model has at a dotted path of stored parameters."""
    for key in path.split("."):
        model = model[int(key)] if isinstance(model, tuple) else getattr(model, key)
    return model


def debye_of(path: str, material: Any, free: tuple[str, ...]) -> ManyDebye | None:
    """Return the Debye terms of a material with columns."""
    try:
        exact = material.debye()
    except (TypeError, ValueError):
        raise NotTogetherError(
            f"{path}.material.{free[0]} is not a term of a finite sum of relaxations, so that each finger needs a"
            " formula of its own"
        ) from None
    return None if exact is None else ManyDebye(exact.high, exact.strengths, exact.relaxation_times)


def free_of_material(free: tuple[str, ...], name: str) -> tuple[str, ...]:
    """Return the free parameters of the material of a layer, by their paths in the material."""
    start = f"stack.{name}.material."
    return tuple(path.removeprefix(start) for path in free if path.startswith(start))


def flat(value: Column) -> Any:
    """Return a shared number as it is, and a column (fingers, 1) as a contiguous row (fingers,)."""
    return np.ascontiguousarray(value[:, 0]) if isinstance(value, np.ndarray) and value.ndim == 2 else value


def stored_columns(scenario: Scenario, columns: Mapping[str, Real]) -> dict[str, Real]:
    """Return the values of fingers as columns, by the paths under which the scenario stores them."""
    return {
        stored_path(scenario, path): np.ascontiguousarray(values, dtype=float)[:, None]
        for path, values in columns.items()
    }
