"""Discovery of models and papers: subclasses, the folder `papers/`, and entry points of other packages."""

from __future__ import annotations

import functools
import importlib
import pkgutil
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, TypeVar

from electrovib.core.errors import LONGEST_QUOTED, ElectrovibError, InputError, nearest, shortened
from electrovib.core.files import kind_of
from electrovib.core.search import Searchable, asked, closest_entries, near

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Mapping
    from importlib.metadata import EntryPoint

    from electrovib.core.model import Model

ENTRY_POINT_GROUP = "electrovib.models"
_TEXTBOOK = f"{__name__.partition('.')[0]}.physics"
M = TypeVar("M", bound="Model")


def find_members(family: type[M], *, wanted: str | None = None) -> Mapping[str, type[M]]:
    """Return the final classes of a family by name; papers are imported only if none loaded so far has the name `wanted`."""
    _import_beside(family)
    members = _by_name(family)
    if wanted is None or wanted not in members:
        papers()
        members = _by_name(family)
    return members


def find_member(family: type[M], name: str) -> type[M] | None:
    """Return the final class of a family with a name, which may be a former one; None if there is none."""
    name = family.present(name)
    return find_members(family, wanted=name).get(name)


def _by_name(family: type[M]) -> dict[str, type[M]]:
    found: dict[str, type[M]] = {}
    for member in _leaves(family):
        other = found.setdefault(member.__name__, member)
        if other is not member:
            names = f"{other.__module__} and {member.__module__}"
            raise ElectrovibError(f"two models are called {member.__name__}: {names}; rename one")
    return found


def _leaves(family: type[M]) -> Iterator[type[M]]:
    for member in family.__subclasses__():
        if member.is_family:
            yield from _leaves(member)
        else:
            yield member


def _import_beside(family: type[Model]) -> None:
    """Import the folder of a family in `physics`; a family outside such a folder has its members beside it in one module."""
    folder = ".".join(family.__module__.split(".")[:3])
    if folder.startswith(f"{_TEXTBOOK}.") and folder != family.__module__:
        _import_folder(folder)


def import_textbook() -> None:
    """Import all of `physics`."""
    _import_folder(_TEXTBOOK)


@functools.cache
def _import_folder(package: str) -> tuple[ModuleType, ...]:
    root = importlib.import_module(package)
    names = [info.name for info in pkgutil.walk_packages(root.__path__, f"{package}.")]
    return tuple(importlib.import_module(name) for name in names)


@functools.cache
def papers() -> Mapping[str, ModuleType]:
    """Import every paper, those of electrovib and those that other packages contribute."""
    found = {name: paper(name) for name in paper_names()}
    for entry in _contributed():
        if entry.name in found:
            raise ElectrovibError(
                f"two papers are called '{entry.name}', one of them {entry.value}: rename one"
            )
        found[entry.name] = _load(entry)
    return dict(sorted(found.items()))


def _contributed() -> tuple[EntryPoint, ...]:
    """Return the entry points of other packages in the group `ENTRY_POINT_GROUP`."""
    from importlib.metadata import entry_points

    return tuple(entry_points(group=ENTRY_POINT_GROUP))


def _load(entry: EntryPoint) -> ModuleType:
    try:
        module = entry.load()
    except Exception as error:
        why = f"{type(error).__name__}: {error}"
        raise ElectrovibError(
            f"the paper '{entry.name}' of another package ({entry.value}): {why}"
        ) from error
    if not isinstance(module, ModuleType):
        raise ElectrovibError(f"the paper '{entry.name}' of another package ({entry.value}) is not a module")
    return module


@functools.cache
def paper_names() -> tuple[str, ...]:
    """Return the names of the papers of electrovib, without importing them."""
    root = importlib.import_module("electrovib.papers")
    return tuple(sorted(info.name for info in pkgutil.iter_modules(root.__path__)))


def paper_folders() -> tuple[Path, ...]:
    """Return the folders in which the modules of papers lie, those of other packages included."""
    root = Path(importlib.import_module("electrovib.papers").__path__[0])
    others = (_load(entry) for entry in _contributed())
    places = (Path(getattr(each, "__path__", [each.__file__])[0] or "") for each in others)
    return tuple(dict.fromkeys([root, *(each.parent for each in places)]))


def is_paper(name: str) -> bool:
    """Return whether a paper of electrovib or of another package has a name, without importing it."""
    return name in paper_names() or any(entry.name == name for entry in _contributed())


def paper(name: str) -> ModuleType:
    """Import one paper by its name."""
    if name in paper_names():
        return importlib.import_module(f"electrovib.papers.{name}")
    contributed = {entry.name: entry for entry in _contributed()}
    if name in contributed:
        return _load(contributed[name])
    what = "a file, not" if kind_of(name) == "file" else "neither a file nor"
    raise InputError(f"'{name}' is {what} a paper.{_near_papers(name, [*paper_names(), *contributed])}")


def _near_papers(name: str, known: Collection[str]) -> str:
    """Ask for the three papers that a wrong name is most like, with what each is about; only these are imported."""
    entries = (Searchable(name=author_year, kind="paper", meaning="") for author_year in known)
    found = [match.entry.name for match in closest_entries(name, entries)]
    about = ((paper(each).__doc__ or "").strip().split("\n")[0] for each in found)
    return asked(zip(found, about, strict=True)) or nearest(name, known)


def offers(functions: Collection[str]) -> dict[str, Any]:
    """Collect what the functions of all papers, such as ``("skins",)``, offer, as ``author_year/name`` to object."""
    found: dict[str, Any] = {}
    for author_year in papers():
        for function in functions:
            for name, thing in offered_by(author_year, function).items():
                found.setdefault(f"{author_year}/{name}", thing)
    return found


def offered_by(author_year: str, function: str) -> Mapping[str, Any]:
    """Return what a function of a paper offers by name; nothing where the paper does not have the function."""
    found: Mapping[str, Any] = getattr(paper(author_year), function, dict)()
    return found


def find_offer(name: str, functions: Collection[str]) -> Any:
    """Return what a paper offers as ``author_year/name``."""
    author_year, _, key = name.partition("/")
    for function in functions if is_paper(author_year) else ():
        if key in (found := offered_by(author_year, function)):
            return found[key]
    offered = offers(functions)
    most_like = near(name, {key: _named(thing) for key, thing in offered.items()}, kind="offer")
    raise InputError(f"no paper offers '{shortened(name, LONGEST_QUOTED)}'.{most_like}")


def _named(offer: Any) -> str:
    """Return what something that a paper offers is called: the title of a scenario, the name of a skin, or its class."""
    return getattr(offer, "title", "") or getattr(offer, "name", "") or type(offer).__name__


def paper_of(model: type[Model]) -> str:
    """Return the name of the paper that contributes a model; empty for a model of the textbook."""
    for name, module in papers().items():
        if model.__module__ == module.__name__ or model.__module__.startswith(f"{module.__name__}."):
            return name
    return ""
