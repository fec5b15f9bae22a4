"""Parameters that a dotted path which does not exist may mean."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from electrovib.core.discovery import find_members
from electrovib.core.errors import Problem, closest
from electrovib.core.tables import place_of

if TYPE_CHECKING:
    from electrovib.core.model import Model

_MOST: Final = 3
_MOST_MODELS: Final = 8


def meant(model: Model, path: str) -> str:
    """Write which parameters of a model, or which other models, have what an unknown path names; empty where none has."""
    owner, _, name = path.rpartition(".")
    if owner:
        return _of_other_models(model, owner.split("."), name)
    return _with_the_word(model, name)


def explained(model: Model, problem: Problem) -> Problem:
    """Return the problem of an unknown path with what it may mean, in the place of a name that is only spelled similarly."""
    asked = meant(model, problem.path)
    if not asked:
        return problem
    reason = problem.reason.partition(" Did you mean ")[0]
    return Problem(f"{reason}{asked}", path=problem.path, value=problem.value)


def _with_the_word(model: Model, word: str) -> str:
    """Ask for the parameters with a word as the last part of their paths, as another part, or in their meaning."""
    given = [(path, quantity.doc) for path, value, quantity in model.parameters() if value is not None]
    found = [item for item in given if item[0].rpartition(".")[2] == word]
    if not found and closest(word, type(model).model_fields) is None:
        found = [item for item in given if word in item[0].split(".")]
        found = found or [item for item in given if word in item[1].split()]
    shown = [f"'{path}' ({meaning})" for path, meaning in found[:_MOST]]
    if not word or not shown:
        return ""
    return f" Did you mean {' or '.join([*([', '.join(shown[:-1])] if shown[1:] else []), shown[-1]])}?"


def _of_other_models(model: Model, owner: list[str], name: str) -> str:
    """Name the members of a family that have a parameter which the chosen member does not have."""
    *outer, last = owner
    holder: Any = model
    for key in outer:
        holder = _inner(holder, key)
    held = _inner(holder, last)
    family = holder.part(last) if hasattr(holder, "part") else None
    if family is None or not family.is_family or held is None:
        return ""
    here = {*type(held).model_fields, *type(held).derived}
    if closest(name, here):
        return ""
    others = [key for key, member in sorted(find_members(family).items()) if name in member.model_fields]
    if not others:
        return ""
    more = ", ..." if len(others) > _MOST_MODELS else ""
    return f" Models with '{name}': {', '.join(others[:_MOST_MODELS])}{more}; to take one, set {'.'.join(owner)}.model as well."


def _inner(holder: Any, key: str) -> Any:
    if isinstance(holder, tuple):
        return None if (place := place_of(holder, key)) is None else holder[place]
    return getattr(holder, key, None)
