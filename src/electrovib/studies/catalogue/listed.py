"""One entry of the catalogue, and a list of them that shows itself as the command line prints it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, overload

if TYPE_CHECKING:
    from electrovib.core.answer import Table


@dataclass(frozen=True, kw_only=True)
class Listed:
    """One model, paper, ready-made scenario, skin, material or stack.

    - `name`: what is written to use it; `kind`: ``force law``, ``paper``, ``scenario``; `meaning`: one line.
    - `group`: what the members of its family compute; ``papers`` and ``scenarios`` for these.
    - `paper`: ``author_year``, or empty for a model of the textbook.
    - `status`: how its source was read, one of `electrovib.core.citation.STATUSES`; empty for a definition.
    - `checks`: how many numbers of sources it is checked against.
    - `runnable`: ``"yes"``, or why it cannot be run.
    - `reproduces`: of a scenario, the figure of its paper or the statement; `reason`: why a search found it.
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
    """Records that show themselves: as the text of the command line in a terminal, as a table in a notebook."""

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
        return len(self._records)

    def __repr__(self) -> str:
        return self._text().rstrip("\n")

    __str__ = __repr__

    def _repr_html_(self) -> str:
        from electrovib.core.answer import as_html

        return as_html(self._table())
