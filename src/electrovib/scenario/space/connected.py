"""Names that depend on each other, through pairs that link them."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence


def connected(names: Sequence[str], links: Iterable[Sequence[str]]) -> tuple[tuple[str, ...], ...]:
    """Split names into the smallest sets that no link joins; sets and names are in the order of `names`."""
    set_of = {name: {name} for name in names}
    for link in links:
        joined = set().union(*(set_of[name] for name in link))
        for name in joined:
            set_of[name] = joined
    found = {id(each): tuple(name for name in names if name in each) for each in set_of.values()}
    return tuple(found.values())
