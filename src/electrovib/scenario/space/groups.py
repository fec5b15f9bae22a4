"""Groups of a population: mixtures of distributions, such as dry and moist fingers."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from electrovib.scenario.distributions import Distribution

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
        if any(not 0 < share <= 1 for share in shares.values()):
            name = next(name for name, share in shares.items() if not 0 < share <= 1)
            raise InputError(f"{name}.share = {shares[name]:g}: expected more than 0 and at most 1")
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
