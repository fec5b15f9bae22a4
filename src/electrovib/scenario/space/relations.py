"""Draws of a population: random numbers, groups, parameters that depend on each other, and relations, for which draws repeat."""

from __future__ import annotations

import functools
import hashlib
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from numpy.typing import NDArray

    from electrovib.scenario.distributions import Distribution
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


def connected(names: Sequence[str], links: Iterable[Sequence[str]]) -> tuple[tuple[str, ...], ...]:
    """Split names into the smallest sets that no link joins; sets and names are in the order of `names`."""
    set_of = {name: {name} for name in names}
    for link in links:
        joined = set().union(*(set_of[name] for name in link))
        for name in joined:
            set_of[name] = joined
    found = {id(each): tuple(name for name in names if name in each) for each in set_of.values()}
    return tuple(found.values())


_ROUNDING: Final = 1e-9
"""By how much shares that are written with few digits may miss 1 in sum."""


@dataclass(frozen=True, kw_only=True)
class Group:
    """One group of a population: its share, above 0 and at most 1, and distributions of its own by dotted path."""

    share: float
    distributions: Mapping[str, Distribution]


@dataclass(frozen=True, kw_only=True)
class Grouping:
    """A division of a population into groups, whose shares add up to 1, and of which every finger belongs to one."""

    groups: Mapping[str, Group]

    def __post_init__(self) -> None:
        """Refuse shares that are not those of one whole."""
        shares = {name: group.share for name, group in self.groups.items()}
        for name, share in shares.items():
            if not 0 < share <= 1:
                raise InputError(f"{name}.share = {share:g}: expected more than 0 and at most 1")
        if abs(math.fsum(shares.values()) - 1) > _ROUNDING:
            listed = " + ".join(f"{share:g} ({name})" for name, share in shares.items())
            raise InputError(f"shares {listed} = {math.fsum(shares.values()):g}: expected 1")

    @property
    def paths(self) -> tuple[str, ...]:
        """Dotted paths of the parameters that the groups set, in the order in which they were declared."""
        return tuple(dict.fromkeys(path for group in self.groups.values() for path in group.distributions))

    def chosen(self, share: Real) -> NDArray[Any]:
        """Return the position from 0 of the group at given cumulative probabilities."""
        ends = np.cumsum([group.share for group in self.groups.values()])[:-1]
        return np.searchsorted(ends, share, side="right")

    def values(self, path: str, share: Real, chosen: NDArray[Any], default: Distribution | None) -> Real:
        """Return quantiles of one parameter, each of the distribution of its group or, where that has none, of `default`."""
        found = np.empty(np.shape(share))
        for number, group in enumerate(self.groups.values()):
            distribution = group.distributions.get(path, default)
            members = chosen == number
            if distribution is not None and members.any():
                found[members] = distribution.value(np.asarray(share)[members])
        return found


_WORDS: Final = 4
"""Numbers of 64 bits for each value of the counter of Philox 4x64."""
_DROPPED: Final = 12
"""Bits of a word that a share does not use: 52 bits and a half step keep it inside 0 and 1 without rounding."""
_LARGEST: Final = 2**64


def uniform_shares(stream: str, *, seed: int, start: int, stop: int, attempt: int = 0) -> Real:
    """Return independent uniform numbers, from 2**-53 to 1 - 2**-53, of the draws from `start` to before `stop`.

    Another `stream` or `attempt`, the number of a repetition from 0, gives independent numbers; `seed` is
    below 2**64.
    """
    key = np.array([seed, _key_of(stream)], dtype=np.uint64)
    counter = np.array([start // _WORDS, 0, 0, attempt], dtype=np.uint64)
    skipped = start % _WORDS
    words = np.random.Philox(key=key, counter=counter).random_raw(skipped + stop - start)[skipped:]
    words >>= np.uint64(_DROPPED)
    shares = words.astype(np.float64)
    shares += 0.5
    shares *= 2.0 ** (_DROPPED - 64)
    return shares


def checked_seed(seed: object) -> int:
    """Return a seed, or refuse what is no whole number from 0 to 2**64 - 1."""
    if isinstance(seed, (int, np.integer)) and not isinstance(seed, bool) and 0 <= seed < _LARGEST:
        return int(seed)
    raise InputError(f"seed = {seed!r}: expected a whole number from 0 to 2**64 - 1, for instance 1")


def checked_draws(n: object, *, fewest: int = 2, example: int = 200) -> int:
    """Return a number of draws, or refuse what is no whole number of at least so many."""
    if isinstance(n, (int, np.integer)) and not isinstance(n, bool) and n >= fewest:
        return int(n)
    raise InputError(f"n = {n!r}: expected a whole number of draws, {fewest} or more, for instance {example}")


@functools.cache
def _key_of(stream: str) -> int:
    return int.from_bytes(hashlib.blake2b(stream.encode(), digest_size=8).digest(), "little")
