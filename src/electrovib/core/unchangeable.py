"""Results that cannot be changed after they were checked: their mappings, lists and arrays neither, however deep."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, is_dataclass
from typing import Any, NoReturn, TypeVar

import numpy as np

from electrovib.core.errors import InputError

K = TypeVar("K")
V = TypeVar("V")


class FrozenDict(dict[K, V]):
    """A dict that refuses every change; ``dict(...)`` and ``|`` make one that can be changed."""

    def _refuse(self, *given: Any, **named: Any) -> NoReturn:
        """Refuse a change."""
        del given, named
        raise InputError(
            "what was checked or computed is not changed in place; replace returns a changed scenario, and dict(...) a copy"
        )

    __setitem__ = __delitem__ = __ior__ = _refuse
    clear = pop = popitem = setdefault = update = _refuse

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[dict[K, V]]]:
        """Copy and pickle it without an assignment."""
        return type(self), (dict(self),)


class Unchangeable:
    """A frozen dataclass whose members cannot be changed in place."""

    __slots__ = ()

    def __post_init__(self) -> None:
        """Freeze what was given."""
        _freeze(self)


def _freeze(result: Any) -> None:
    for each in fields(result):
        object.__setattr__(result, each.name, frozen(getattr(result, each.name)))


def frozen(value: Any) -> Any:
    """Return a value that cannot be changed in place: a read-only view of an array, a tuple for a list, a `FrozenDict`."""
    if isinstance(value, np.ndarray):
        value = value.view()
        value.flags.writeable = False
    elif type(value) in (list, tuple):
        return tuple(map(frozen, value))
    elif type(value) is dict:
        return FrozenDict({name: frozen(each) for name, each in value.items()})
    elif is_dataclass(value) and not isinstance(value, type) and value.__dataclass_params__.frozen:  # type: ignore[attr-defined]
        _freeze(value)
    return value
