"""Evaluation of a tile from the text of its study, as the workers of a cluster do."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING

from electrovib.core.errors import ElectrovibError, InputError
from electrovib.core.versions import versions
from electrovib.study.population.declared import DeclaredStudy
from electrovib.study.population.reduced import TileResult
from electrovib.study.population.tile import Evaluator

if TYPE_CHECKING:
    from collections.abc import Mapping


@functools.lru_cache(maxsize=1)
def _evaluator(text: str, threads: int | None) -> Evaluator:
    return Evaluator(DeclaredStudy.from_text(text), threads=threads)


def tile_on_worker(text: str, start: int, stop: int, expected: Mapping[str, str]) -> TileResult:
    """Evaluate a tile of a study that is given as text; a mistake is part of the result."""
    here = computing_versions()
    differing = [
        f"{name} {here.get(name)} instead of {each}"
        for name, each in expected.items()
        if here.get(name) != each
    ]
    if differing:
        what = ", ".join(differing)
        return TileResult(
            start, stop, problems=[f"workers: one has {what}; install the same versions everywhere"]
        )
    try:
        evaluator = _evaluator(text, _threads())
        found = evaluator.tile(start, stop)
        if evaluator.counted:
            for each in found.reduced.values():
                each.histogram, each.forms = evaluator.histogram_of(each.forms), []
    except ElectrovibError as error:
        return TileResult(start, stop, problems=[str(each) for each in error.problems])
    return found


def _threads() -> int | None:
    """Return the number of threads of the Dask worker that runs this; None elsewhere."""
    from distributed import get_worker

    try:
        return int(get_worker().state.nthreads)
    except ValueError:
        return None


def computing_versions() -> dict[str, str]:
    """Return the versions of the packages on which the numbers of a study depend."""
    found = versions()
    return {name: found[name] for name in ("electrovib", "numpy", "scipy", "numba") if name in found}


def refuse_problems(result: TileResult) -> None:
    """Raise the problems of a tile as an error."""
    if result.problems:
        raise InputError(result.problems)
