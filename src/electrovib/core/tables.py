"""A value finds its place: from ``PATH=VALUE`` as it was typed into nested tables around a frozen tree of models.

From top to bottom: the text is split at its first equals sign; one walk goes down the dotted paths, and on it a text becomes
the number that its parameter is, a name the table that it stands for, and a parameter that a model derives those that it
stores. The tables of a file are read by the end of the same walk. At last: what an unknown path may mean.
"""

from __future__ import annotations

import contextlib
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final, TypeAlias

from pydantic import BaseModel
from pydantic_core import PydanticCustomError

from electrovib.core.discovery import find_members
from electrovib.core.errors import ElectrovibError, InputError, Problem, closest, nearest, question, refuse
from electrovib.core.mistakes import shown
from electrovib.core.parsing import read_toml
from electrovib.core.quantity import Quantity, quantity_of
from electrovib.core.samples import Samples

if TYPE_CHECKING:
    from electrovib.core.model import Model

_NOTHING: Final = object()
Given: TypeAlias = Mapping[Any, Any]
"""Values by dotted path from one place on; a value in the place of what is there has the path None."""


def read_changes(
    changes: Mapping[str, Any] | Iterable[str] | None, problems: list[str] | None = None
) -> dict[str, Any]:
    """Read ``path=value`` texts; a value that begins with a brace or a bracket is TOML, any other stays a text.

    A mapping of values by path is taken as it is. One sentence on each text that cannot be read is added to the `problems`,
    without which all are refused at once.
    """
    if isinstance(changes, Mapping):
        return dict(changes)
    found: dict[str, Any] = {}
    wrong = [] if problems is None else problems
    for text in changes or ():
        path, sign, value = (part.strip() for part in text.partition("="))
        if not sign or not path:
            wrong.append(f"--set {text}: expected PATH=VALUE, for instance drive.high='150 V'")
        elif path in found:
            wrong.append(f"--set {text}: '{path}' is set twice")
        else:
            try:
                found[path] = read_toml(f"value = {value}")["value"] if value[:1] in {"{", "["} else value
            except ValueError as error:
                wrong.append(f"--set {text}: not valid TOML: {error}")
    if problems is None:
        refuse(wrong)
    return found


@dataclass
class Changed:
    """One change of a model, or of nested tables: the walk, and what it finds beside the new tables.

    `stored` has the changes by the paths of the parameters that are stored; `offers` the names that stood in the place of
    tables, by path, with the kind of model of each; `unread` the tables whose file has not been read.
    """

    model: Model | None = None
    stored: dict[str, Any] = field(default_factory=dict)
    offers: dict[str, tuple[type[Model], str]] = field(default_factory=dict)
    unread: list[tuple[str, type[Model], dict[str, Any]]] = field(default_factory=list)
    problems: list[Problem] = field(default_factory=list)
    _around: str = ""

    def within(
        self, given: Given, here: Any, kind: type[Model] | None = None, path: str = "", *, fresh: bool = False
    ) -> Any:
        """Return what stands at a path after what is given there; parts of a model without a change stay what they are.

        In a `fresh` table every name may be set, and validation follows; elsewhere only those that are there.
        """
        if None in given:
            return self._whole(given, kind, path)
        if here is None and (fresh or kind is not None):
            return self._in_nothing(given, kind, path, fresh=fresh)
        inner: dict[str, dict[str | None, Any]] = {}
        for each, value in given.items():
            name, dot, further = each.partition(".")
            inner.setdefault(name, {})[further if dot else None] = value
        if not isinstance(here, (BaseModel, Mapping)):
            return self._in_list(inner, here, kind, path, fresh=fresh)
        own, owner, content = self._table(path, kind, here, given.get("model", _NOTHING))
        fresh, own_parameters = fresh or (owner is None and isinstance(here, BaseModel)), dict[str, Any]()
        for name, values in ((_present(owner, each, inner.keys()), values) for each, values in inner.items()):
            where, is_derived = _joined(path, name), None in values and name in getattr(own, "derived", {})
            is_fresh = fresh or (name not in content and not is_derived)
            if is_fresh and name not in content and own is not None:
                content = own.with_place(content, name, _table_of(values))
            if not (fresh or is_derived or name in content):
                self._refuse(content, path, name, values)
                continue
            part, is_own = own.part(name) if own is not None else None, owner is not None and not is_fresh
            try:
                if is_own and values.get(None) is not None and (quantity := _quantity(own, name)) is not None:
                    values[None] = quantity.read(values[None])
            except PydanticCustomError as error:
                self.problems.append(Problem(error.message(), path=where, value=shown(values[None])))
                continue
            found = self.within(values, content.get(name), part, where, fresh=is_fresh)
            is_parameter = is_own and None in values
            (own_parameters if is_parameter else content)[name] = found
            self.stored |= {where: found} if None in values and not is_parameter else {}
        return _read_anew(content | self._stored_by(owner, path, own_parameters, given), given)

    def opened(self, kind: type[Model] | None, value: Any, path: str) -> Any:
        """Copy what is given for a part, names replaced by the tables that they stand for, texts by the numbers that they are.

        What cannot be read is kept for validation to refuse.
        """
        if kind is not None and isinstance(value, str) and kind.is_offer(value):
            try:
                found = kind.from_offer(kind.offer(value))
            except ElectrovibError:
                return value
            self.offers[path] = kind, value
            return found.to_dict()
        if isinstance(value, (list, tuple)) and kind is not None:
            return [self.opened(kind, each, _joined(path, place)) for place, each in enumerate(value)]
        if not isinstance(value, Mapping):
            return value
        own, table = kind.chosen(value) if kind is not None else None, dict(value)
        if own is None:
            return table
        for name, each in value.items():
            if (quantity := _quantity(own, str(name))) is None:
                table[name] = self.opened(own.part(str(name)), each, _joined(path, name))
                continue
            with contextlib.suppress(PydanticCustomError):
                table[name] = quantity.read(each)
        if own.file_columns(table):
            self.unread.append((path, own, table))
        return table

    def _table(
        self, path: str, kind: type[Model] | None, here: Any, model: Any
    ) -> tuple[Any, Any, dict[str, Any]]:
        """Return the class of a part, the model that it is, if it is one, and its table; a new model keeps nothing of it."""
        owner = here if isinstance(here, BaseModel) else None
        own: Any = type(owner) if owner is not None else kind.chosen(here) if kind is not None else None
        content = ({"model": own.__name__} if getattr(owner, "is_member", False) else {}) | dict(here)
        if model is _NOTHING or (content and content.get("model", model) == model):
            return own, owner, content
        if content and self._around:
            why = f"is set beside the table '{self._around}', which it would replace as a whole; give one of the two"
            self.problems.append(Problem(why, path=f"{path}.model"))
        return kind.chosen({"model": model}) if kind is not None else None, None, {"model": model}

    def _whole(self, given: Given, kind: type[Model] | None, path: str) -> Any:
        """Return a value or a table that is given in the place of what is there, with what is given within it."""
        found, around = self.opened(kind, given[None], path), self._around
        if within := {rest: value for rest, value in given.items() if rest is not None}:
            self._around = path if isinstance(given[None], Mapping) else ""
            found = self.within(within, found, kind, path, fresh=True)
            self._around = around
        return found

    def _in_nothing(self, given: Given, kind: type[Model] | None, path: str, *, fresh: bool) -> Any:
        """Return a table in the place of nothing; of a family a model has to be chosen."""
        if kind is None or not kind.is_family or fresh or "model" in given:
            return self.within(given, {}, kind, path, fresh=True)
        known = ", ".join(sorted(find_members(kind)))
        why = f"'{path}' is not given; choose its model too, {path}.model, one of: {known}"
        self.problems += [Problem(why, path=each) for each in _paths(path, given)]
        return None

    def _in_list(
        self, inner: Mapping[str, Given], here: Any, kind: type[Model] | None, path: str, *, fresh: bool
    ) -> Any:
        """Return a list with what is given within it; refuse what is given in a value."""
        is_list = isinstance(here, (list, tuple))
        places = list(here) if is_list else here
        for name, each in inner.items():
            place = place_of(here, name) if is_list else None
            if place is None:
                self._refuse(places, path, name, each)
                continue
            where = _joined(path, name)
            places[place] = self.within(each, here[place], kind, where, fresh=fresh)
            if None in each:
                self.stored[where] = places[place]
        return places

    def _stored_by(self, owner: Any, path: str, read: dict[str, Any], given: Given) -> dict[str, Any]:
        """Return parameters of a model as those that it stores; what is refused is shown as it was given."""
        try:
            kept: dict[str, Any] = owner.stored(read) if read else {}
        except InputError as error:
            self.problems += [
                Problem(
                    each.reason,
                    path=_joined(path, each.path),
                    value=shown(given[each.path]) if each.value and each.path in given else each.value,
                )
                for each in error.problems
            ]
            kept = {name: value for name, value in read.items() if name not in owner.derived}
        self.stored |= {_joined(path, name): value for name, value in kept.items()}
        return kept

    def _refuse(self, table: Any, path: str, name: str, given: Given) -> None:
        """Refuse what is given under a name that is not there, with how to add it or what may be meant."""
        for where in _paths(_joined(path, name), given):
            problem = unknown(table, path, name, where)
            if self.model is not None:
                how = type(self.model).how_to_add(self.model.to_dict(), where)
                problem = explained_path(self.model, Problem(how, path=where) if how else problem)
            self.problems.append(problem)


def _table_of(values: Given) -> dict[str, Any]:
    """Return the values below a place, whether they were given as a table or one by one."""
    whole = values.get(None)
    return {**(whole if isinstance(whole, Mapping) else {}), **values}


def _joined(path: str, name: object) -> str:
    return f"{path}.{name}" if path else str(name)


def _paths(path: str, given: Given) -> Iterator[str]:
    """Iterate over the whole dotted paths of what is given from a path on."""
    return (path if rest is None else _joined(path, rest) for rest in given)


def _quantity(own: type[Model], name: str) -> Quantity | None:
    """Return the declaration of a physical parameter of a model, stored or derived; None for anything else."""
    return quantity_of(own, name) or own.derived.get(name)


def _present(owner: Any, name: str, names: Container[str]) -> str:
    """Return the present name of a parameter of a model; a former one warns, unless the present one is given beside it."""
    former = getattr(owner, "former", {})
    return owner.present(name) if name in former and former[name].now not in names else name


def _read_anew(content: dict[str, Any], given: Given) -> dict[str, Any]:
    """Return a table without what was read from its file, where that is named or read otherwise."""
    if not (content.get("file") and any(map(_says_how_to_read, _paths("", given)))):
        return content
    return {
        name: each.to_dict() if isinstance(each, BaseModel) else each  # type: ignore[attr-defined]
        for name, each in content.items()
        if not isinstance(each, Samples)
    }


def _says_how_to_read(path: str) -> bool:
    """Tell whether a change is one of how a file is read, so that what was read from it is not kept."""
    last = path.rpartition(".")[2]
    return last in {"file", "model", "column", "unit"} or last.endswith(("_column", "_unit"))


def place_of(table: Sequence[Any], key: str) -> int | None:
    """Return the index that a key names, or None; only decimal notation is read, so that each entry has one path."""
    known = key.isascii() and key.isdecimal() and len(key) < 10 and str(int(key)) == key
    return int(key) if known and int(key) < len(table) else None


def unknown(table: Any, where: str, key: str, path: str) -> Problem:
    """Return the problem of a path that does not exist, from the table at which it ends."""
    if isinstance(table, list):
        why = f"'{where}' has entries 0 to {len(table) - 1}"
    elif table is None:
        why = f"'{where}' is not given, so without parameters of its own; if it is a table, set it whole"
    elif not isinstance(table, dict):
        why = f"'{where}' is a single value, without parameters of its own"
    else:
        owner = f" of {table['model']}" if "model" in table else f" in '{where}'" if where else ""
        why = f"unknown parameter '{key}'{owner}.{nearest(key, table)}"
    return Problem(why, path=path)


def stored_changes(model: Model, changes: Mapping[str, Any]) -> tuple[dict[str, Any], list[Problem]]:
    """Return changes by the paths of the parameters that a model stores, and a problem for each that is refused."""
    found = Changed(model)
    found.within(changes, model)
    return found.stored, found.problems


def present_path(model: Any, path: str) -> str:
    """Return a dotted path with the present names of the parameters in it; former ones warn."""
    owner, keys = model, list[str]()
    for key in path.split("."):
        keys.append(type(owner).present(key) if hasattr(owner, "present") else key)
        owner = stored_at(owner, keys[-1:])
    return ".".join(keys)


def derived_at(model: BaseModel, path: str) -> tuple[Any, str] | None:
    """Return the model that derives the parameter at a dotted path, and the parameter's name; None for a stored one."""
    *parents, last = path.split(".")
    owner = stored_at(model, parents)
    return (owner, last) if last in getattr(type(owner), "derived", {}) else None


def is_stored_as_given(model: BaseModel, path: str, kind: type[BaseModel]) -> bool:
    """Return whether a parameter is stored and, by the default `stored` of `kind`, its change alters no other parameter."""
    *parents, last = path.split(".")
    owner = stored_at(model, parents)
    plain = getattr(type(owner), "stored", None) is kind.stored  # type: ignore[attr-defined]
    return plain and last not in getattr(type(owner), "derived", {})


def stored_at(model: Any, keys: list[str]) -> Any:
    """Return what is stored at the end of keys; None where they lead to nothing."""
    owner = model
    for key in keys:
        if isinstance(owner, BaseModel):
            owner = dict(owner).get(key)
        elif isinstance(owner, tuple) and (place := place_of(owner, key)) is not None:
            owner = owner[place]
        else:
            owner = None
    return owner


_MOST: Final = 3
_MOST_MODELS: Final = 8


def meant(model: Model, path: str) -> str:
    """Write which parameters of a model, or which other models, have what an unknown path names; empty where none has."""
    owner, _, name = path.rpartition(".")
    if owner:
        return _of_other_models(model, owner.split("."), name)
    return _with_the_word(model, name)


def explained_path(model: Model, problem: Problem) -> Problem:
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
    return question([f"'{path}' ({meaning})" for path, meaning in found[:_MOST]] if word else [])


def _of_other_models(model: Model, owner: list[str], name: str) -> str:
    """Name the members of a family that have a parameter which the chosen member does not have."""
    holder, held = stored_at(model, owner[:-1]), stored_at(model, owner)
    family = holder.part(owner[-1]) if hasattr(holder, "part") else None
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
