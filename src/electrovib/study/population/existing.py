"""Stores that exist: whether a study may be written there or continued."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from electrovib.core.allowance import megabytes
from electrovib.core.errors import InputError
from electrovib.study.population.folder import (
    COMPLETE,
    PARTIAL,
    SUFFIX,
    require_zarr,
    written,
)
from electrovib.study.population.groups import METADATA, read_group, refuse_irregular
from electrovib.study.population.lock import NAME as LOCK
from electrovib.study.population.opened import study_attributes
from electrovib.study.population.origin import attributes, definition

if TYPE_CHECKING:
    from electrovib.study.population.declared import DeclaredStudy
    from electrovib.study.population.tile import Evaluator

_SAME: Final = "an unfinished study continues only with the same, because its numbers have to be the same to the last bit"


def state_of(path: Path, declared: DeclaredStudy) -> str:
    """Return the state of a store: ``absent``, ``begun`` or ``complete``."""
    if path.suffix.lower() != SUFFIX:
        raise InputError(
            f"a study is stored in a folder whose name ends in {SUFFIX}, not in '{path.suffix}'", path=path
        )
    require_zarr()
    with written(path):
        if not path.exists():
            return "absent"
        if not path.is_dir():
            raise InputError("is a file; a study is stored in a folder. Give another name.", path=path)
        refuse_irregular(path)
        if not (path / METADATA).exists():
            if all(each.name == LOCK or each.name.endswith(PARTIAL) for each in path.iterdir()):
                return "absent"
            raise InputError("exists already and is no study of electrovib; give another name.", path=path)
    found = study_attributes(path)
    ours, theirs = definition(declared), found["definition"]
    differing = [
        _difference(name, theirs.get(name), value)
        for name, value in ours.items()
        if theirs.get(name) != value
    ]
    if differing:
        raise InputError(
            f"holds another study: {'; '.join(differing)}. Give another name, or remove that folder.",
            path=path,
        )
    return "complete" if found.get(COMPLETE) else "begun"


def _difference(name: str, theirs: Any, ours: Any) -> str:
    if name in {"scenario", "space"}:
        return f"its {name} is not the same"
    return f"{name} is {json.dumps(theirs)} there and {json.dumps(ours)} here"


def refuse_other_kernel(path: Path, evaluator: Evaluator) -> None:
    """Refuse to continue a study that was begun with another kernel, version or method."""
    theirs, ours = read_group(path), attributes(evaluator)
    pairs = [
        (name, theirs.get(name), ours[name])
        for name in ("kernel", "method", "percentiles_from", "own_models")
    ]
    versions = theirs["versions"]
    pairs += [(name, versions.get(name), each) for name, each in ours["versions"].items()]
    differing = [f"{name.replace('_', ' ')} '{was}', here '{now}'" for name, was, now in pairs if was != now]
    if differing:
        raise InputError(
            f"was begun with {'; with '.join(differing)}: {_SAME}. Continue it there, or give another name.",
            path=path,
        )


def refuse_full_disk(path: Path, evaluator: Evaluator) -> None:
    """Refuse a study whose kept signals exceed the free space of the disk."""
    declared = evaluator.declared
    needed = 4.0 * declared.fingers * evaluator.numbers if declared.draws else 0.0
    folder = next((each for each in (path, *path.resolve().parents) if each.exists()), Path())
    free = shutil.disk_usage(folder).free
    if needed > free:
        raise InputError(
            f"the signals of all fingers take {megabytes(needed)}, and {megabytes(free)} are free; omit --draws, or draw"
            " fewer fingers",
            path=path,
        )
