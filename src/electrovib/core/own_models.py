"""Models of a user: their file is imported, and a Trace that needs them names it with its SHA-256."""

from __future__ import annotations

import functools
import hashlib
import importlib.util
import re
import sys
import traceback
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any, Final

from electrovib.core.discovery import find_member, find_members
from electrovib.core.errors import ElectrovibError, InputError
from electrovib.core.files import kind_of
from electrovib.core.model import Model
from electrovib.core.parsing import read_json

ATTRIBUTE: Final = "own_models"
"""Attribute of a Trace that lists the models which are not part of electrovib, with the files that define them."""
_OURS: Final = __name__.partition(".")[0]
_used: dict[Path, ModuleType] = {}


def use_models(file: str | Path) -> ModuleType:
    """Import, once, a file that defines models, which can then be named like those of electrovib."""
    path = Path(file).resolve()
    imported = sys.modules.get(path.stem)
    if path not in _used and getattr(imported, "__file__", None) == str(path) and imported is not None:
        _used[path] = imported  # by another file
    if path in _used:
        return _used[path]
    if (kind := kind_of(path)) != "file":
        what = "is a folder" if kind == "folder" else "there is no such file"
        raise InputError(f"--models {file}: {what}; expected a Python file that defines models")
    spec = importlib.util.spec_from_file_location(_module_name(path), path)
    if spec is None or spec.loader is None:
        raise InputError(f"--models {file}: expected a Python file, which ends in .py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[module.__name__] = module
    if str(path.parent) not in sys.path:
        sys.path.append(str(path.parent))
    _used[path] = module
    try:
        spec.loader.exec_module(module)
        _check(module, file)
    except BaseException as error:
        del _used[path], sys.modules[module.__name__]
        if isinstance(error, ElectrovibError) or not isinstance(error, Exception):
            raise
        raise InputError(_told(error, path, file)) from None
    return module


def used_files() -> list[str]:
    """List the files that `use_models` has imported, with their folders."""
    return [str(path) for path in _used]


def _module_name(path: Path) -> str:
    """Name a module after its file, so that other files of the user import the same one, unless the name is taken."""
    name = path.stem if path.stem.isidentifier() else "own_models"
    taken = name in sys.modules
    if not taken and (spec := importlib.util.find_spec(name)) is not None:
        taken = spec.origin != str(path)
    return f"{name}_models" if taken else name


def _check(module: ModuleType, file: str | Path) -> None:
    """Refuse a file without models, or with a model whose name is taken."""
    found = [
        each
        for each in vars(module).values()
        if isinstance(each, type) and issubclass(each, Model) and each.__module__ == module.__name__
    ]
    members = [each for each in found if each.is_member]
    if not members:
        raise InputError(
            f"--models {file}: defines no model; expected a subclass of a family, for instance"
            " 'class MyLaw(ForceLaw)' with 'from electrovib.physics.force import ForceLaw'"
        )
    for member in members:
        find_members(family_of(member))


def family_of(member: type[Model]) -> type[Model]:
    """Family of a model: the widest one that is no plain Model."""
    return [each for each in member.__mro__ if issubclass(each, Model) and each is not Model][-1]


def _told(error: Exception, path: Path, file: str | Path) -> str:
    """State file, line and kind of an error of a user's file."""
    line, what = _line(error, path), str(error)
    if isinstance(error, SyntaxError):
        line, what = error.lineno if error.filename == str(path) else line, error.msg
    where = f"{file}, line {line}" if line else str(file)
    return f"{where}: {type(error).__name__}: {what}"


def _line(error: BaseException, path: Path) -> int | None:
    frames = traceback.extract_tb(error.__traceback__)
    return next((each.lineno for each in reversed(frames) if Path(each.filename) == path), None)


def fault(error: Exception) -> str:
    """Describe an error that comes from a file of `use_models`, with its line; empty if no such file is at fault."""
    for path, module in reversed(_used.items()):
        if _line(error, path) is not None:
            return _told(error, path, path.name)
        own = [name for name, each in vars(module).items() if isinstance(each, type)]
        named = [name for name in own if re.search(rf"\b{name}\b", str(error))]
        if named:
            return f"{path.name}, {named[0]}: {type(error).__name__}: {error}"
    return ""


def origins(model: Model) -> list[dict[str, str]]:
    """List the models in a tree that are not part of electrovib, and the files that define them.

    For each class once: ``model``, ``family``, ``file`` (name without folder; empty for an interactive
    session) and ``sha256`` of the file as it is now (empty without a file).
    """
    kinds = dict.fromkeys(type(each) for each in _tree(model))
    return [_origin(kind) for kind in kinds if kind.__module__.partition(".")[0] != _OURS]


def _tree(model: Model) -> Iterator[Model]:
    yield model
    for _, value in model:
        for each in value if isinstance(value, tuple) else (value,):
            if isinstance(each, Model):
                yield from _tree(each)


def described(attribute: str) -> str:
    """Write the attribute of a Trace that lists own models as text; a damaged one is returned as it is."""
    try:
        return "; ".join(
            f"{each['family']} {each['model']}, {each['file'] or 'without a file'}"
            + (f" (SHA-256 {each['sha256']})" if each["sha256"] else "")
            for each in read_json(attribute)
        )
    except (ValueError, TypeError, KeyError):
        return attribute


def _origin(kind: type[Model]) -> dict[str, str]:
    file = getattr(sys.modules.get(kind.__module__), "__file__", None)
    path = Path(file) if file else None
    return {
        "model": kind.__name__,
        "family": family_of(kind).__name__,
        "file": path.name if path else "",
        "sha256": _digest(path, path.stat().st_mtime_ns) if path and path.is_file() else "",
    }


@functools.cache
def _digest(path: Path, changed: int) -> str:
    del changed
    return hashlib.sha256(path.read_bytes()).hexdigest()


def missing_models(
    kind: type[Model] | None, content: Any, path: str = ""
) -> Iterator[tuple[str, type[Model], str]]:
    """Find path, family and name of the models that nested tables name and that no loaded file defines."""
    if isinstance(content, (list, tuple)):
        for index, item in enumerate(content):
            yield from missing_models(kind, item, f"{path}.{index}")
    if kind is None or not isinstance(content, Mapping):
        return
    name = content.get("model")
    if kind.is_family and isinstance(name, str) and find_member(kind, name) is None:
        yield path, kind, name
    chosen = kind.chosen(content)
    if chosen is None:
        return
    for key, item in content.items():
        yield from missing_models(chosen.part(str(key)), item, f"{path}.{key}".removeprefix("."))
