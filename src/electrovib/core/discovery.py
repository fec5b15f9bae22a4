"""Models and papers are found, never listed: subclasses, the folder `papers/`, entry points of others."""

from __future__ import annotations

import functools
import importlib
import pkgutil
from types import ModuleType
from typing import TYPE_CHECKING, TypeVar

from electrovib.core.errors import ElectrovibError, InputError, nearest

if TYPE_CHECKING:
    from collections.abc import Mapping

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
    _import_folder("electrovib.physics")
    members = _leaves(family)
    if wanted is None or wanted not in members:
        papers()
        members = _leaves(family)
    return members


def _leaves(family: type[M]) -> dict[str, type[M]]:
    found: dict[str, type[M]] = {}
    for member in family.__subclasses__():
        if member.is_family:
            found |= _leaves(member)
        elif member.__name__ in found and found[member.__name__] is not member:
            names = f"{member.__module__} and {found[member.__name__].__module__}"
            raise ElectrovibError(f"two models are called {member.__name__}: {names}; rename one")
        else:
            found[member.__name__] = member
    return found


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
    """
    from importlib.metadata import entry_points

    found = {name: paper(name) for name in paper_names()}
    for entry in entry_points(group=ENTRY_POINT_GROUP):
        found[entry.name] = entry.load()
    return dict(sorted(found.items()))


@functools.cache
def paper_names() -> tuple[str, ...]:
    """List the papers in our own folder without importing them."""
    root = importlib.import_module("electrovib.papers")
    return tuple(sorted(info.name for info in pkgutil.iter_modules(root.__path__)))


def paper(name: str) -> ModuleType:
    """Import one paper by its file name.

    Raises
    ------
    InputError
        If there is none; the message has the nearest name.
    """
    if name in paper_names():
        return importlib.import_module(f"electrovib.papers.{name}")
    from importlib.metadata import entry_points

    contributed = {entry.name: entry for entry in entry_points(group=ENTRY_POINT_GROUP)}
    if name in contributed:
        module = contributed[name].load()
        assert isinstance(module, ModuleType)
        return module
    known = nearest(name, [*paper_names(), *contributed])
    raise InputError(f"'{name}' is neither a file nor a paper.{known}")
