"""A scenario whose numbers are columns with one value for each finger."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.model import Model
from electrovib.core.numbers import nested
from electrovib.solve.one_by_one import value_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Real
    from electrovib.core.quantity import Quantity
    from electrovib.scenario import Scenario

M = TypeVar("M", bound=Model)


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
