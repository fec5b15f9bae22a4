"""Quantities of many scenarios that share parts; results that depend on these parts alone are computed once."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from electrovib.core.errors import ElectrovibError
from electrovib.solve.quantities.answer import Answer, answer
from electrovib.solve.quantities.resolve import solved, times_of_window
from electrovib.solve.quantities.sines import answers, is_of_sines

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.scenario import Scenario
    from electrovib.solve.expanded import Expanded
    from electrovib.solve.quantities.names import Named


FEWEST: Final = 2
"""Smallest number of scenarios that are computed at once."""
MOST: Final = 256
"""Largest number of scenarios that are held in memory together."""


class Together:
    """Scenarios of which the same quantities are requested.

    Parameters
    ----------
    members : sequence of Scenario
        Those that differ only in their drive share all other parts as the same objects.
    names : sequence of Named
        Quantities of each.

    Notes
    -----
    Scenarios that differ only in a sine are computed at once, in arrays over all of them; any other one separately, with
    the modes of a previous one that has the same stack.
    """

    def __init__(self, members: Sequence[Scenario], names: Sequence[Named]) -> None:
        self.members, self.names = members, names
        self._found: dict[int, Answer] = {}
        self._groups: dict[tuple[int, ...], list[int]] = {}
        for place, member in enumerate(members):
            self._groups.setdefault(_rest(member), []).append(place)
        self._expanded: dict[tuple[int, ...], Expanded] = {}
        self._apart = False

    def answer(self, place: int) -> Answer:
        """Return the quantities of one of the scenarios."""
        if place not in self._found:
            rest = _rest(self.members[place])
            group = self._groups[rest]
            expanded = solved(self.members[place], before=self._expanded.pop(rest, None))
            self._found |= self._at_once(expanded, group)
            if place not in self._found:
                self._found[place] = answer(expanded, self.names)
            group[:] = [each for each in group if each not in self._found]
            if group:
                self._expanded[rest] = expanded
        return self._found.pop(place)

    def _at_once(self, expanded: Expanded, group: list[int]) -> dict[int, Answer]:
        """Return the quantities of the scenarios of a group that share the band of this one; empty where none can be."""
        if self._apart or not is_of_sines(expanded.scenario):
            return {}
        some = [place for place in group if _is_like(expanded, self.members[place])][:MOST]
        if len(some) < FEWEST:
            return {}
        try:
            found = answers(expanded, [self.members[place] for place in some], self.names)
        except ElectrovibError:
            found = None  # computed separately, each scenario raises its own error
        self._apart = found is None
        return {} if found is None else dict(zip(some, found, strict=True))


def _is_like(expanded: Expanded, member: Scenario) -> bool:
    """Return whether a scenario under another sine has the modes of an expanded one."""
    return expanded.has_stack_of(member, times_of_window(member))


def _rest(member: Scenario) -> tuple[int, ...]:
    """Return the identities of all parts of a scenario except its drive."""
    return tuple(id(part) for name, part in member if name not in {"drive", "title", "sources"})
