"""A frozen tree of models, or nested tables, changed by dotted paths: one walk from the top to each value.

During the walk a text becomes the number that its parameter is, a name the table that it stands for, and a parameter that a
model derives those that it stores.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

from pydantic import BaseModel
from pydantic_core import PydanticCustomError

from electrovib.core.discovery import find_members
from electrovib.core.errors import ElectrovibError, InputError, Problem, closest, nearest, question
from electrovib.core.mistakes import shown
from electrovib.core.quantity import quantity_of
from electrovib.core.samples import Samples

if TYPE_CHECKING:
    from electrovib.core.model import Model

_NOTHING: Final = object()


@dataclass
class _Given:
    """What is given at one place: a value in the place of what is there, changes within it, or both."""

    value: Any = _NOTHING
    within: dict[str, _Given] = field(default_factory=dict)

    def paths(self, path: str) -> Iterator[str]:
        """Iterate over the dotted paths that were given, from this place on."""
        if self.value is not _NOTHING:
            yield path
        for name, each in self.within.items():
            yield from each.paths(_joined(path, name))

    @property
    def table(self) -> Mapping[str, Any]:
        """The values within, whether they were given as a table or one by one."""
        whole = self.value if isinstance(self.value, Mapping) else {}
        return {**whole, **{name: each.value for name, each in self.within.items()}}


def _joined(path: str, name: object) -> str:
    return f"{path}.{name}" if path else str(name)


@dataclass
class Changed:
    """Nested tables in which changes are put, or what is wrong with them.

    Parts of a model without a change stay the models that they are. `stored` has the changes by the paths of the parameters
    that are stored; `offers` the names that stood in the place of tables, by path, with the kind of model of each; `unread`
    the tables whose file has not been read.
    """

    model: Model | None = None
    content: Any = None
    stored: dict[str, Any] = field(default_factory=dict)
    offers: dict[str, tuple[type[Model], str]] = field(default_factory=dict)
    unread: list[tuple[str, type[Model], dict[str, Any]]] = field(default_factory=list)
    problems: list[Problem] = field(default_factory=list)
    _around: str = ""

    def opened(self, kind: type[Model] | None, value: Any, path: str) -> Any:
        """Copy what is given for a part, names replaced by the tables that they stand for; an unknown name is kept."""
        if kind is not None and isinstance(value, str) and kind.is_offer(value):
            try:
                found = kind.from_offer(kind.offer(value))
            except ElectrovibError:
                return value  # validation refuses it
            self.offers[path] = kind, value
            return found.to_dict()
        if isinstance(value, Mapping):
            own = kind.chosen(value) if kind is not None else None
            if own is None:
                return dict(value)
            table = {
                name: self._read(own, str(name), each, _joined(path, name)) for name, each in value.items()
            }
            if own.file_columns(table):
                self.unread.append((path, own, table))
            return table
        if isinstance(value, (list, tuple)) and kind is not None:
            return [self.opened(kind, each, _joined(path, place)) for place, each in enumerate(value)]
        return value

    def _read(self, own: type[Model], name: str, value: Any, path: str) -> Any:
        """Return a number, or a part, of a table; what cannot be read is kept for validation to refuse."""
        if (quantity := quantity_of(own, name) or own.derived.get(name)) is None:
            return self.opened(own.part(name), value, path)
        try:
            return quantity.read(value)
        except PydanticCustomError:
            return value

    def within(self, path: str, kind: type[Model] | None, here: Any, given: _Given, *, fresh: bool) -> Any:
        """Return what stands at a path after what is given there and within.

        In a `fresh` table every name may be set, and validation follows; elsewhere only those that are there.
        """
        if given.value is not _NOTHING:
            return self._whole(path, kind, given)
        if not isinstance(here, (BaseModel, Mapping)):
            return self._within_other(path, kind, here, given, fresh=fresh)
        model = given.within["model"].value if "model" in given.within else _NOTHING
        own, owner, content = self._table(path, kind, here, model)
        fresh = fresh or (owner is None and isinstance(here, BaseModel))
        numbers, typed = dict[str, Any](), dict[str, Any]()
        for typed_name, each in given.within.items():
            name = _present(owner, typed_name, given.within.keys())
            where, new = _joined(path, name), name not in content
            derived = each.value is not _NOTHING and name in getattr(own, "derived", {})
            if new and not derived and own is not None:
                content = own.with_place(content, name, each.table)
            if not (fresh or derived or name in content):
                self._refuse(content, path, name, each)
                continue
            part, is_fresh = own.part(name) if own is not None else None, fresh or (new and not derived)
            typed[name] = each.value
            if part is None and own is not None:
                each.value = self._number(own, name, each.value, where, fresh=fresh)
            if each.value is _NOTHING and not each.within:
                continue  # refused
            found = self.within(where, part, content.get(name), each, fresh=is_fresh)
            if owner is None or is_fresh or typed[name] is _NOTHING:
                content[name] = found
                self._store(where, each, found)
            else:
                numbers[name] = found
        if numbers:
            content |= self._stored_by(owner, path, numbers, typed)
        return _read_anew(content, given)

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

    def _whole(self, path: str, kind: type[Model] | None, given: _Given) -> Any:
        """Return a value or a table that is given in the place of what is there, with what is given within it."""
        found, around = self.opened(kind, given.value, path), self._around
        if given.within:
            self._around = path if isinstance(given.value, Mapping) else ""
            found = self.within(path, kind, found, _Given(within=given.within), fresh=True)
            self._around = around
        return found

    def _within_other(
        self, path: str, kind: type[Model] | None, here: Any, given: _Given, *, fresh: bool
    ) -> Any:
        """Return a list with what is given within it, or a table in the place of nothing; refuse what is given in a value."""
        if here is None and kind is not None and kind.is_family and not fresh and "model" not in given.within:
            known = ", ".join(sorted(find_members(kind)))
            why = f"'{path}' is not given; choose its model too, {path}.model, one of: {known}"
            self.problems += [Problem(why, path=each) for each in given.paths(path)]
            return None
        if here is None and (fresh or kind is not None):
            return self.within(path, kind, {}, given, fresh=True)
        is_list = isinstance(here, (list, tuple))
        places = list(here) if is_list else here
        for name, each in given.within.items():
            place = place_of(here, name) if is_list else None
            if place is None:
                self._refuse(places, path, name, each)
            else:
                places[place] = self.within(_joined(path, name), kind, here[place], each, fresh=fresh)
                self._store(_joined(path, name), each, places[place])
        return places

    def _number(self, own: type[Model], name: str, value: Any, where: str, *, fresh: bool) -> Any:
        """Read a physical parameter; what cannot be read is refused, by validation where a table is `fresh`."""
        quantity = quantity_of(own, name) or own.derived.get(name)
        if quantity is None or value is None or value is _NOTHING:
            return value
        try:
            return quantity.read(value)
        except PydanticCustomError as error:
            if fresh:
                return value
            self.problems.append(Problem(error.message(), path=where, value=shown(value)))
            return _NOTHING

    def _stored_by(
        self, owner: Any, path: str, given: dict[str, Any], typed: Mapping[str, Any]
    ) -> dict[str, Any]:
        """Return given parameters of a model as those that it stores; what it refuses is shown as it was `typed`."""
        try:
            kept: dict[str, Any] = owner.stored(given)
        except InputError as error:
            self.problems += [
                Problem(
                    each.reason,
                    path=_joined(path, each.path),
                    value=shown(typed[each.path]) if each.value and each.path in typed else each.value,
                )
                for each in error.problems
            ]
            kept = {name: value for name, value in given.items() if name not in owner.derived}
        self.stored |= {_joined(path, name): value for name, value in kept.items()}
        return kept

    def _store(self, path: str, given: _Given, value: Any) -> None:
        if given.value is not _NOTHING:
            self.stored[path] = value

    def _refuse(self, table: Any, path: str, name: str, given: _Given) -> None:
        """Refuse what is given under a name that is not there, with how to add it or what may be meant."""
        for where in given.paths(_joined(path, name)):
            problem = unknown(table, path, name, where)
            if self.model is not None:
                how = type(self.model).how_to_add(self.model.to_dict(), where)
                problem = explained_path(self.model, Problem(how, path=where) if how else problem)
            self.problems.append(problem)


def changed(
    here: Model | Mapping[str, Any], changes: Mapping[str, Any], kind: type[Model] | None = None
) -> Changed:
    """Put changes by dotted path into a model, or into the tables of a `kind` of model, in which missing ones are made."""
    found, root = Changed(None if isinstance(here, Mapping) else here), _Given()
    for path, value in changes.items():
        place = root
        for key in path.split("."):
            place = place.within.setdefault(key, _Given())
        place.value = value
    found.content = found.within("", kind, here, root, fresh=found.model is None)
    return found


def _present(owner: Any, name: str, names: Container[str]) -> str:
    """Return the present name of a parameter of a model; a former one warns, unless the present one is given beside it."""
    former = getattr(owner, "former", {})
    return owner.present(name) if name in former and former[name].now not in names else name


def _read_anew(content: dict[str, Any], given: _Given) -> dict[str, Any]:
    """Return a table without what was read from its file, where that is named or read otherwise."""
    if not (content.get("file") and any(map(_says_how_to_read, given.paths("")))):
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
    found = changed(model, changes)
    return found.stored, found.problems


def present_path(model: Any, path: str) -> str:
    """Return a dotted path with the present names of the parameters in it; former ones warn."""
    owner, keys = model, list[str]()
    for key in path.split("."):
        keys.append(type(owner).present(key) if hasattr(owner, "present") else key)
        owner = _descended(owner, keys[-1:])
    return ".".join(keys)


def derived_at(model: BaseModel, path: str) -> tuple[Any, str] | None:
    """Return the model that derives the parameter at a dotted path, and the parameter's name; None for a stored one."""
    *parents, last = path.split(".")
    owner = _descended(model, parents)
    return (owner, last) if last in getattr(type(owner), "derived", {}) else None


def number_at(model: BaseModel, path: str) -> float | None:
    """Return the number that is stored at a dotted path; None for a text, a table, an absent value or no such path."""
    *parents, last = path.split(".")
    owner = _descended(model, parents)
    found = dict(owner).get(last) if isinstance(owner, BaseModel) else None
    return found if isinstance(found, float) else None


def is_stored_as_given(model: BaseModel, path: str, kind: type[BaseModel]) -> bool:
    """Return whether a parameter is stored and, by the default `stored` of `kind`, its change alters no other parameter."""
    *parents, last = path.split(".")
    owner = _descended(model, parents)
    plain = getattr(type(owner), "stored", None) is kind.stored  # type: ignore[attr-defined]
    return plain and last not in getattr(type(owner), "derived", {})


def _descended(model: Any, keys: list[str]) -> Any:
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
    holder, held = _descended(model, owner[:-1]), _descended(model, owner)
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
