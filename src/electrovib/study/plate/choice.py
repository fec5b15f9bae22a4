"""The best candidate, the limit that binds there, and what a less strict limit would gain."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.study.plate.pareto import pareto_set

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from electrovib.study.plate.candidates import PlateCandidate
    from electrovib.study.plate.objectives import Objective

RELAXED: Final = 1.1
"""Factor by which the binding limit is relaxed, to state what that gains; a choice."""
SAME: Final = 1e-9
"""Relative difference up to which two values count as equal: rounding."""


@dataclass(frozen=True, kw_only=True)
class Gain:
    """What is reached with one limit relaxed and all others kept, or with several if no single one gains anything.

    `relaxed` is the best candidate with the limit `RELAXED` times as large, None if it gains nothing or there
    are several; `without` is that without the limit.
    """

    limits: tuple[str, ...]
    relaxed: PlateCandidate | None
    without: PlateCandidate


def best_of(
    candidates: Sequence[PlateCandidate],
    objectives: Sequence[Objective],
    *,
    relaxed: Collection[str] = (),
    factor: float = math.inf,
) -> PlateCandidate | None:
    """Find the candidate within the limits that is best in the first objective; of equal ones, in the next.

    Limits of the `relaxed` quantities are multiplied by `factor`, or omitted where it is infinite.
    """
    name = objectives[0].name
    left = [
        each
        for each in candidates
        if not math.isnan(each.values[name]) and each.is_allowed_with(relaxed, factor)
    ]
    for objective in objectives:
        costs = [objective.sign * each.values[objective.name] for each in left]
        known = [cost for cost in costs if not math.isnan(cost)]
        if not known:
            continue
        bound = min(known) + SAME * abs(min(known))
        left = [each for each, cost in zip(left, costs, strict=True) if cost <= bound]
    return left[0] if left else None


def is_better(one: PlateCandidate, other: PlateCandidate, objective: Objective) -> bool:
    """Return whether a candidate is better than another in an objective by more than rounding."""
    first, second = (objective.sign * each.values[objective.name] for each in (one, other))
    return first < second - SAME * abs(second)


def gains_of(
    best: PlateCandidate, candidates: Sequence[PlateCandidate], objectives: Sequence[Objective]
) -> list[Gain]:
    """Find the limits that bind: those without which a candidate would be better in the first objective than the best one.

    The largest gain comes first. Where no single limit gains anything, the limits that the best of all
    candidates exceeds together are returned.
    """
    found = []
    singles = {each.forbidden_by[0]: None for each in candidates if len(each.forbidden_by) == 1}
    for name in singles:
        without = best_of(candidates, objectives, relaxed=[name])
        if without is None or not is_better(without, best, objectives[0]):
            continue
        relaxed = best_of(candidates, objectives, relaxed=[name], factor=RELAXED)
        better = relaxed is not None and is_better(relaxed, best, objectives[0])
        found.append(Gain(limits=(name,), relaxed=relaxed if better else None, without=without))
    first = objectives[0]
    found.sort(key=lambda gain: first.sign * gain.without.values[first.name])
    if not found:
        every = {name for each in candidates for name in each.forbidden_by}
        top = best_of(candidates, objectives, relaxed=every)
        if top is not None and is_better(top, best, first):
            found.append(Gain(limits=top.forbidden_by, relaxed=None, without=top))
    return found


def efficient(candidates: Sequence[PlateCandidate], objectives: Sequence[Objective]) -> list[PlateCandidate]:
    """Return the Pareto set of the candidates within all limits, from the best to the worst in the first objective."""
    allowed = [each for each in candidates if each.is_allowed]
    if not allowed:
        return []
    costs = np.array([[one.sign * each.values[one.name] for one in objectives] for each in allowed])
    kept = [each for each, is_kept in zip(allowed, pareto_set(costs).tolist(), strict=True) if is_kept]
    first = objectives[0]
    return sorted(kept, key=lambda each: first.sign * each.values[first.name])
