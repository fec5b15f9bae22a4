"""Mistakes of a space that concern several of its parts."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from electrovib.scenario.space.space import Space


def wrong_groups(space: Space) -> list[str]:
    """List parameters that two divisions set, and those that some groups of a division lack."""
    found = []
    for name, grouping in space.groupings.items():
        for other in [other for other in space.groupings if other < name]:
            both = set(grouping.paths) & set(space.groupings[other].paths)
            found += [f"groups.{name}: {path} is set by groups.{other} too" for path in sorted(both)]
        for label, group in grouping.groups.items():
            missing = [p for p in grouping.paths if p not in {*group.distributions, *space.distributions}]
            found += [
                f"groups.{name}.{label}: {path} is set by other groups; give its distribution here, or in [space] for"
                " the groups that have none"
                for path in missing
            ]
    return found


def wrong_pairs(space: Space) -> list[str]:
    """List relations and correlations that are not between two parameters of the space."""
    found = []
    for first, second in space.relations:
        foreign = [path for path in (first, second) if path not in space.paths]
        found += [f"relations: {first} < {second}: '{path}' is not in the space" for path in foreign]
    for (first, second), value in space.correlations.items():
        pair = f"correlation: {first} ~ {second}"
        foreign = [path for path in (first, second) if path not in space.paths]
        found += [f"{pair}: '{path}' is not in the space" for path in foreign]
        if first == second or (second, first) in space.correlations:
            found.append(f"{pair}: expected each pair of two different parameters once")
        if not -1 <= value <= 1:
            found.append(f"{pair} = {value:g}: expected a coefficient from -1 to 1")
    return found
