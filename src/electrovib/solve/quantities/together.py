"""Numbers of many scenarios that share parts: what follows from these parts alone is computed once."""

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
MOST: Final = 256
"""Scenarios that are worth answering at once, and as many as are held in memory together."""


class Together:
    """Scenarios of which the same numbers are asked.

    Parameters
    ----------
    members : sequence of Scenario
        Those that differ in their drive alone share all other parts as the same objects.
    names : sequence of Named
        What is asked of each.

    Notes
    -----
    Scenarios that share all but a sine are answered at once, in arrays over all of them; any other one alone, with the
    modes of another one that has the same stack.
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
        """Return the numbers of one of the scenarios.

        Parameters
        ----------
        place : int
            Its number.

        Returns
        -------
        Answer
            With its checks.

        Raises
        ------
        InputError
            If models do not go together.
        """
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
        """Answer all scenarios of a group whose materials are reduced over the band of this one, if that can be."""
        if self._apart or not is_of_sines(expanded.scenario):
            return {}
        some = [place for place in group if _is_like(expanded, self.members[place])][:MOST]
        if len(some) < FEWEST:
            return {}
        try:
            found = answers(expanded, [self.members[place] for place in some], self.names)
        except ElectrovibError:
            found = None  # each says for itself what is wrong
        self._apart = found is None
        return {} if found is None else dict(zip(some, found, strict=True))


def _is_like(expanded: Expanded, member: Scenario) -> bool:
    """Tell whether a scenario under another sine has the modes of an expanded one."""
    return expanded.has_stack_of(member, times_of_window(member))


def _rest(member: Scenario) -> tuple[int, ...]:
    """Identify all parts of a scenario but its drive."""
    return tuple(id(part) for name, part in member if name not in {"drive", "title", "sources"})
