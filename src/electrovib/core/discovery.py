"""Models and papers are found, never listed: subclasses, the folder `papers/`, entry points of others."""

from __future__ import annotations

import functools
import importlib
import pkgutil
from types import ModuleType
from typing import TYPE_CHECKING, Any, TypeVar

from electrovib.core.errors import LONGEST_QUOTED, ElectrovibError, InputError, nearest, shortened

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Mapping
    from importlib.metadata import EntryPoint

    from electrovib.core.model import Model

ENTRY_POINT_GROUP = "electrovib.models"
M = TypeVar("M", bound="Model")


def find_members(family: type[M], *, wanted: str | None = None) -> Mapping[str, type[M]]:
    """Find the final classes of a family.

    Parameters
    ----------
    family : type
        An abstract model class.
    wanted : str, optional
        A name; papers are imported only when it is not among what is already loaded, or when None.

    Returns
    -------
    mapping of str to type
        Class name to class.
    """
    _import_beside(family)
    members = _by_name(family)
    if wanted is None or wanted not in members:
        papers()
        members = _by_name(family)
    return members


def find_member(family: type[M], name: str) -> type[M] | None:
    """Find the final class of a family by its name, or by one that it had; None if there is none."""
    members = find_members(family, wanted=name)
    former = (member for member in members.values() if name in member.former_names)
    return members.get(name) or next(former, None)


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
    """Import the room of a family of our own, `electrovib.physics` for instance: there its members are, and in papers."""
    own, *room = family.__module__.split(".")[:2]
    if own == __name__.partition(".")[0]:
        _import_folder(".".join([own, *room]))


@functools.cache
def _import_folder(package: str) -> tuple[ModuleType, ...]:
    """Import every module of a package, folders included."""
    root = importlib.import_module(package)
    names = [info.name for info in pkgutil.walk_packages(root.__path__, f"{package}.")]
    return tuple(importlib.import_module(name) for name in names)


@functools.cache
def papers() -> Mapping[str, ModuleType]:
    """Import every paper, ours and those other packages contribute.

    Returns
    -------
    mapping of str to module
        ``author_year`` to module, sorted.

    Raises
    ------
    ElectrovibError
        If a contributed paper has the name of another, or cannot be imported.
    """
    found = {name: paper(name) for name in paper_names()}
    for entry in _contributed():
        if entry.name in found:
            raise ElectrovibError(
                f"two papers are called '{entry.name}', one of them {entry.value}: rename one"
            )
        found[entry.name] = _load(entry)
    return dict(sorted(found.items()))


def _contributed() -> tuple[EntryPoint, ...]:
    """List what other packages offer under our entry-point group."""
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
    """List the papers in our own folder without importing them."""
    root = importlib.import_module("electrovib.papers")
    return tuple(sorted(info.name for info in pkgutil.iter_modules(root.__path__)))


def paper(name: str) -> ModuleType:
    """Import one paper by its file name.

    Parameters
    ----------
    name : str
        ``author_year``, ours or contributed.

    Returns
    -------
    module
        With its citation, models and checks.

    Raises
    ------
    InputError
        If there is none; the message has the nearest name.
    """
    if name in paper_names():
        return importlib.import_module(f"electrovib.papers.{name}")
    contributed = {entry.name: entry for entry in _contributed()}
    if name in contributed:
        return _load(contributed[name])
    known = nearest(name, [*paper_names(), *contributed])
    raise InputError(f"'{name}' is neither a file nor a paper.{known}")


def offers(functions: Collection[str], *, of: str = "") -> dict[str, Any]:
    """Collect what papers offer ready-made.

    Parameters
    ----------
    functions : collection of str
        Names of functions of a paper that give it, each a mapping of name to thing; ``("skins",)`` for instance.
    of : str, optional
        Only what this paper offers, without importing the others.

    Returns
    -------
    dict of str to object
        ``author_year/name`` to thing; the first function wins where two offer one name.
    """
    found: dict[str, Any] = {}
    for author_year, module in ({of: paper(of)} if of else papers()).items():
        for function in functions:
            for name, thing in getattr(module, function, dict)().items():
                found.setdefault(f"{author_year}/{name}", thing)
    return found


def name_of_today(module: ModuleType, name: str) -> str:
    """Return the present name of what a paper offers, from its table ``FORMER_NAMES`` of former and present names."""
    former: Mapping[str, str] = getattr(module, "FORMER_NAMES", {})
    return former.get(name, name)


def find_offer(name: str, functions: Collection[str]) -> Any:
    """Find what a paper offers under ``author_year/name``.

    Raises
    ------
    InputError
        If no paper does; the message has the nearest name.
    """
    author_year = name.partition("/")[0]
    if author_year in {*paper_names(), *(entry.name for entry in _contributed())}:
        found = offers(functions, of=author_year)
        today = f"{author_year}/{name_of_today(paper(author_year), name.partition('/')[2])}"
        if today in found:
            return found[today]
    raise InputError(
        f"no paper offers '{shortened(name, LONGEST_QUOTED)}'.{nearest(name, offers(functions))}"
    )


def paper_of(model: type[Model]) -> str:
    """Give the name of the paper that contributes a model; empty for a law of the textbook."""
    for name, module in papers().items():
        if model.__module__ == module.__name__ or model.__module__.startswith(f"{module.__name__}."):
            return name
    return ""
