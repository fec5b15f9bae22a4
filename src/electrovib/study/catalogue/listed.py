"""One entry of the catalogue, and a list of them that shows itself as the command line prints it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, overload

if TYPE_CHECKING:
    from electrovib.study.reproduction import Table


@dataclass(frozen=True, kw_only=True)
class Listed:
    """One model, paper, ready-made scenario, skin, material or stack.

    Parameters
    ----------
    name : str
        What is written to use it.
    kind : str
        What it is: ``force law``, ``paper``, ``scenario``.
    meaning : str
        One line.
    group : str
        What the members of its family compute; ``papers`` and ``scenarios`` for these.
    paper : str
        ``author_year``, or empty for a model of the textbook.
    status : str
        How its source was read, one of `electrovib.core.status.STATUSES`; empty for a definition.
    checks : int
        How many numbers of sources it is checked against.
    runnable : str
        ``"yes"``, or why it cannot be run.
    reproduces : str
        Of a scenario: the figure of its paper, or the statement.
    reason : str
        Of the result of a search: why it was found.
    """

    name: str
    kind: str
    meaning: str
    group: str = ""
    paper: str = ""
    status: str = ""
    checks: int = 0
    runnable: str = "yes"
    reproduces: str = ""
    reason: str = ""


class Listing(Sequence[Listed]):
    """Listing that show themselves: as text in a terminal, as a table in a notebook.

    Parameters
    ----------
    records : iterable of Listed
        What is listed.
    text : callable
        Takes nothing and returns the text that the command line prints.
    table : callable
        Takes nothing and returns the table that a notebook shows.
    """

    def __init__(
        self, records: Iterable[Listed], *, text: Callable[[], str], table: Callable[[], Table]
    ) -> None:
        self._records, self._text, self._table = tuple(records), text, table

    @overload
    def __getitem__(self, place: int) -> Listed: ...
    @overload
    def __getitem__(self, place: slice) -> tuple[Listed, ...]: ...
    def __getitem__(self, place: int | slice) -> Listed | tuple[Listed, ...]:
        """Return one record, or several."""
        return self._records[place]

    def __len__(self) -> int:
        """Return how many records there are."""
        return len(self._records)

    def __repr__(self) -> str:
        """Write what the command line prints."""
        return self._text().rstrip("\n")

    __str__ = __repr__

    def _repr_html_(self) -> str:
        from electrovib.study.catalogue.columns import as_html

        return as_html(self._table())
