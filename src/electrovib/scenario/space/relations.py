"""Draws that fulfil relations: those that do not are repeated, each from random numbers of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from typing import Any

    from electrovib.core.arrays import Real
    from electrovib.scenario.space.space import Space

_BLOCK: Final = 4096
"""Draws whose repetitions are computed together."""
_MOST: Final = 4000
"""Repetitions of a draw at most."""
LEAST_SHARE: Final = 0.01
"""Part of all draws that has to fulfil the relations; with it, _MOST repetitions fail once in 1e17 draws."""


def fulfil(space: Space, values: dict[str, Real], *, seed: int, start: int) -> None:
    """Repeat the draws that do not fulfil the relations of a space, in place."""
    count = len(next(iter(values.values())))
    for paths in space.related():
        for first in range(0, count, _BLOCK):
            block = slice(first, min(first + _BLOCK, count))
            _fulfil_block(space, paths, {path: values[path][block] for path in paths}, seed, start + first)


def _fulfil_block(
    space: Space, paths: tuple[str, ...], values: dict[str, Real], seed: int, start: int
) -> None:
    """Repeat the draws of one block; the arrays are views into those of the caller."""
    refused: Any = ~space.allowed(values)
    stop = start + len(refused)
    for attempt in range(1, _MOST + 1):
        wanted = np.flatnonzero(refused)
        if not len(wanted):
            return
        shares = space.shares_of(paths, seed=seed, start=start, stop=stop, attempt=attempt)
        again = space.values({stream: share[wanted] for stream, share in shares.items()})
        for path in paths:
            values[path][wanted] = again[path]
        refused[wanted] = ~space.allowed(again)
    if refused.any():
        raise InputError(_rarely_fulfilled(space, f"draw {start + int(np.argmax(refused))}"))


def check_relations(space: Space) -> None:
    """Refuse relations that too few draws fulfil."""
    for paths in space.related():
        first = space.values(space.shares_of(paths, seed=0, start=0, stop=_BLOCK, attempt=0))
        if np.mean(space.allowed(first)) < LEAST_SHARE:
            raise InputError(_rarely_fulfilled(space, "too few draws are left"))


def _rarely_fulfilled(space: Space, what: str) -> str:
    """Name the relation that the fewest draws fulfil, and their share."""
    found = {}
    for less, more in space.relations:
        paths = next(each for each in space.related() if less in each)
        first = space.values(space.shares_of(paths, seed=0, start=0, stop=_BLOCK, attempt=0))
        found[less, more] = float(np.mean(first[less] < first[more]))
    less, more = min(found, key=lambda pair: found[pair])
    return (
        f"relations: {less} < {more}: {what}; a share of {found[less, more]:.2g} of the draws fulfils this relation, and all"
        f" relations together need {LEAST_SHARE:g}. Choose distributions that overlap less in the wrong order"
    )
