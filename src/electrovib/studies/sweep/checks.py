"""Diagnostics of many cases as one list: each with its largest value and the case in which it occurs."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final, TypeAlias

from electrovib.core.diagnostics import STATES, Diagnostic

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

SAME: Final = 1e-9
"""Relative difference up to which two values count as equal: rounding."""
Judged: TypeAlias = "tuple[Mapping[str, float], Sequence[Diagnostic]]"
"""Values of the swept parameters of a case, and its diagnostics."""


def over_all(cases: Sequence[Judged], *, words: Callable[[Mapping[str, float]], str]) -> list[dict[str, Any]]:
    """Keep of each diagnostic the case with the largest value relative to the limit.

    Each has ``at``, the parameters of that case, and ``cases``, the number in its state; diagnostics of one
    name are identified by their order, and one that was judged in some cases only has two entries.
    """
    found: dict[tuple[str, int], list[tuple[Mapping[str, float], Diagnostic]]] = {}
    for at, diagnostics in cases:
        seen: dict[str, int] = {}
        for diagnostic in diagnostics:
            place = seen[diagnostic.name] = seen.get(diagnostic.name, -1) + 1
            found.setdefault((diagnostic.name, place), []).append((at, diagnostic))
    return [told for group in found.values() for told in _of_one_check(group, len(cases), words)]


def _of_one_check(
    group: Sequence[tuple[Mapping[str, float], Diagnostic]],
    count: int,
    words: Callable[[Mapping[str, float]], str],
) -> list[dict[str, Any]]:
    told = []
    measured = [
        (at, diagnostic)
        for at, diagnostic in group
        if diagnostic.value is not None and diagnostic.limit is not None
    ]
    if measured:
        at, diagnostic = max(measured, key=lambda pair: share_of_limit(pair[1]))
        alike = [other for _, other in measured if other.state == diagnostic.state]
        lowest = min(share_of_limit(other) for _, other in measured)
        if count == 1:
            tail = ""
        elif len(measured) == count and share_of_limit(diagnostic) - lowest <= SAME * abs(
            share_of_limit(diagnostic)
        ):
            tail = f"; the same in all {count} cases"
        else:
            tail = f"; largest at {words(at)}"
            tail += (
                f", {diagnostic.state} in {len(alike)} of {count} cases"
                if diagnostic.state == "warning"
                else ""
            )
        told.append(_as_told(diagnostic, at, len(alike), tail))
    plain = [
        (at, diagnostic) for at, diagnostic in group if diagnostic.value is None or diagnostic.limit is None
    ]
    plain = [pair for pair in plain if not measured or pair[1].state != "ok"]
    if plain:
        worst = max(STATES.index(diagnostic.state) for _, diagnostic in plain)
        alike = [diagnostic for _, diagnostic in plain if STATES.index(diagnostic.state) == worst]
        at, diagnostic = next(pair for pair in plain if STATES.index(pair[1].state) == worst)
        if len(alike) < count:
            tail = f"; in {len(alike)} of {count} cases, the first at {words(at)}"
        else:
            same = len({each.text for each in alike}) == 1
            tail = "" if same else f"; in all cases, this is the one at {words(at)}"
        told.append(_as_told(diagnostic, at, len(alike), tail))
    return told


def _as_told(diagnostic: Diagnostic, at: Mapping[str, float], cases: int, tail: str) -> dict[str, Any]:
    return diagnostic.to_dict() | {"text": diagnostic.text + tail, "at": dict(at), "cases": cases}


def share_of_limit(diagnostic: Diagnostic) -> float:
    """Return value over limit of a diagnostic that has both, dimensionless; minus infinity for NaN."""
    assert diagnostic.value is not None
    assert diagnostic.limit is not None
    if math.isnan(diagnostic.value) or math.isnan(diagnostic.limit):
        return -math.inf
    if diagnostic.limit == 0:
        return math.inf if diagnostic.value > 0 else 0.0
    return diagnostic.value / diagnostic.limit
