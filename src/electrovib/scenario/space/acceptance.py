"""Acceptance of a space by a scenario, which may refuse parameters that it sets by other means."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.errors import InputError
from electrovib.scenario.space.groups import Group, Grouping

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from electrovib.scenario.experiment import Scenario
    from electrovib.scenario.space.space import Space


def accepted(space: Space, scenario: Scenario) -> Space:
    """Try the medians of a space in a scenario, and omit optional entries that the scenario refuses."""
    middle = {stream: np.array([0.5]) for stream in space.streams}
    medians = {path: float(value[0]) for path, value in space.values(middle).items()}
    try:
        scenario.replace(medians)
    except InputError as error:
        refused = {
            path: why
            for path in medians
            if _is_optional(space, path) and (why := _reason(scenario, path, medians[path]))
        }
        if not refused:
            raise InputError(
                f"with the medians of the space, {problem}" for problem in error.problems
            ) from None
        return accepted(_reduced(space, refused), scenario)
    return space


def _reason(scenario: Scenario, path: str, value: float) -> str:
    """Return why a scenario refuses a value; empty if it takes it."""
    try:
        scenario.replace({path: value})
    except InputError as error:
        return error.problems[0].reason
    return ""


def _is_optional(space: Space, path: str) -> bool:
    return any(origin.optional for where, origin in space.origins.items() if _belongs(where, path))


def _belongs(where: str, path: str) -> bool:
    return where == path or (where.startswith("groups.") and where.endswith(f".{path}"))


def _reduced(space: Space, refused: Mapping[str, str]) -> Space:
    """Return a space without some paths; a division into groups that sets nothing else goes with them."""
    groupings = {
        name: Grouping(
            groups={
                label: Group(share=group.share, distributions=_lacking(group.distributions, refused))
                for label, group in grouping.groups.items()
            }
        )
        for name, grouping in space.groupings.items()
        if set(grouping.paths) - set(refused)
    }
    gone = [
        where
        for where in space.origins
        if any(_belongs(where, path) for path in refused)
        or (where.startswith("groups.") and where.split(".")[1] not in groupings)
    ]
    return dataclasses.replace(
        space,
        distributions=_lacking(space.distributions, refused),
        groupings=groupings,
        correlations={pair: r for pair, r in space.correlations.items() if not set(pair) & set(refused)},
        relations=tuple(pair for pair in space.relations if not set(pair) & set(refused)),
        origins=_lacking(space.origins, gone),
        units=_lacking(space.units, refused),
        omitted={**space.omitted, **refused},
    )


def _lacking(mapping: Mapping[str, Any], names: Collection[str]) -> dict[str, Any]:
    return {name: each for name, each in mapping.items() if name not in names}
