"""A model with some numbers replaced: only the parts that hold them are built and validated again."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeVar

from pydantic import ValidationError

from electrovib.core.model import Model

if TYPE_CHECKING:
    from collections.abc import Mapping

M = TypeVar("M", bound=Model)


def with_numbers(model: M, numbers: Mapping[str, float]) -> M:
    """Return a copy with other numbers at some paths; parts without a change are shared with the original.

    Parameters
    ----------
    model : Model
        The model to copy.
    numbers : mapping of str to float
        Dotted path of a stored physical parameter, as `stored_changes` has it, to its value in SI.

    Returns
    -------
    Model
        Validated, and equal to the result of `Model.replace`, which is slower.

    Raises
    ------
    InputError
        As from `Model.replace`.
    """
    tree: dict[str, Any] = {}
    for path, value in numbers.items():
        *parents, last = path.split(".")
        branch = tree
        for key in parents:
            branch = branch.setdefault(key, {})
        branch[last] = value
    try:
        return _rebuilt(model, tree)
    except (ValidationError, LookupError, TypeError):
        return model.replace(numbers)  # reports what is wrong with them


def _rebuilt(model: M, tree: Mapping[str, Any]) -> M:
    content = dict(model)
    for key, change in tree.items():
        content[key] = _put(content[key], change) if isinstance(change, dict) else change
    return type(model).model_validate(content)


def _put(value: Any, tree: Mapping[str, Any]) -> Any:
    if isinstance(value, tuple):
        return tuple(
            _rebuilt(item, tree[str(index)]) if str(index) in tree else item
            for index, item in enumerate(value)
        )
    return _rebuilt(value, tree)
