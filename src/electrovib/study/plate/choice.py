"""The best candidate, the limit that binds there, and what a less strict limit would gain."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.study.plate.pareto import pareto_set

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from electrovib.study.plate.candidates import Candidate
    from electrovib.study.plate.objectives import Objective

RELAXED: Final = 1.1
"""Factor by which the binding limit is relaxed, to state what that gains; a choice."""
SAME: Final = 1e-9
"""Relative difference up to which two values count as equal: rounding."""


@dataclass(frozen=True, kw_only=True)
class Gain:
    """What is reached with one limit relaxed and all others kept.

    Parameters
    ----------
    limits : tuple of str
        Quantities whose limits are relaxed; one, unless no single one gains anything.
    relaxed : Candidate or None
        Best candidate with the limit `RELAXED` times as large; None if no candidate is better than the best one, or
        if there are several limits.
    without : Candidate
        Best candidate without the limit.
    """

    limits: tuple[str, ...]
    relaxed: Candidate | None
    without: Candidate


def best_of(
    candidates: Sequence[Candidate],
    objectives: Sequence[Objective],
    accepted: Callable[[Candidate], bool] = lambda each: each.is_allowed,
) -> Candidate | None:
    """Find the candidate that is best in the first objective; of equal ones, in the next.

    Parameters
    ----------
    candidates : sequence of Candidate
        All candidates.
    objectives : sequence of Objective
        In the order in which they decide.
    accepted : callable
        Whether a candidate may be chosen; by default one within all limits.

    Returns
    -------
    Candidate or None
        None if no candidate is accepted and known.
    """
    left = [each for each in candidates if not math.isnan(each.values[objectives[0].name]) and accepted(each)]
    for objective in objectives:
        costs = [objective.sign * each.values[objective.name] for each in left]
        known = [cost for cost in costs if not math.isnan(cost)]
        if not known:
            continue
        bound = min(known) + SAME * abs(min(known))
        left = [each for each, cost in zip(left, costs, strict=True) if cost <= bound]
    return left[0] if left else None


def is_better(one: Candidate, other: Candidate, objective: Objective) -> bool:
    """Return whether a candidate is better than another in an objective by more than rounding."""
    first, second = (objective.sign * each.values[objective.name] for each in (one, other))
    return first < second - SAME * abs(second)


def gains_of(
    best: Candidate, candidates: Sequence[Candidate], objectives: Sequence[Objective]
) -> list[Gain]:
    """Find the limits that bind: those without which a candidate would be better than the best one.

    Parameters
    ----------
    best : Candidate
        Best within all limits.
    candidates : sequence of Candidate
        All candidates.
    objectives : sequence of Objective
        The first one decides.

    Returns
    -------
    list of Gain
        From the largest to the smallest gain. Where no single limit gains anything, the limits that the best of all
        candidates exceeds together; empty if no candidate is better.
    """
    found = []
    singles = {each.forbidden_by[0]: None for each in candidates if len(each.forbidden_by) == 1}
    for name in singles:
        without = best_of(candidates, objectives, lambda each, name=name: set(each.forbidden_by) <= {name})
        if without is None or not is_better(without, best, objectives[0]):
            continue
        relaxed = best_of(
            candidates, objectives, lambda each, name=name: not each.forbidden_with(name, RELAXED)
        )
        better = relaxed is not None and is_better(relaxed, best, objectives[0])
        found.append(Gain(limits=(name,), relaxed=relaxed if better else None, without=without))
    first = objectives[0]
    found.sort(key=lambda gain: first.sign * gain.without.values[first.name])
    if not found:
        top = best_of(candidates, objectives, lambda each: True)
        if top is not None and is_better(top, best, first):
            found.append(Gain(limits=top.forbidden_by, relaxed=None, without=top))
    return found


def efficient(candidates: Sequence[Candidate], objectives: Sequence[Objective]) -> list[Candidate]:
    """Return the Pareto set of the candidates within all limits, in the order of the first objective.

    Parameters
    ----------
    candidates : sequence of Candidate
        All candidates.
    objectives : sequence of Objective
        Of the trade-off.

    Returns
    -------
    list of Candidate
        From the best to the worst in the first objective.
    """
    allowed = [each for each in candidates if each.is_allowed]
    if not allowed:
        return []
    costs = np.array([[one.sign * each.values[one.name] for one in objectives] for each in allowed])
    kept = [each for each, is_kept in zip(allowed, pareto_set(costs).tolist(), strict=True) if is_kept]
    first = objectives[0]
    return sorted(kept, key=lambda each: first.sign * each.values[first.name])
