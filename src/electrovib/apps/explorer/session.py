"""One visitor of the page: what is shown, what is pinned, and its computation."""

from __future__ import annotations

import functools
import logging
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from electrovib.apps.explorer.computed import Computed, compute
from electrovib.apps.explorer.further import TABS, Further, slices
from electrovib.apps.explorer.limits import MOST_PINNED
from electrovib.apps.explorer.runner import LatestOnly, apart
from electrovib.apps.explorer.state import PageState, scenario_of
from electrovib.core.errors import ElectrovibError, InputError

if TYPE_CHECKING:
    import xarray

    from electrovib.scenario import Scenario


@dataclass(frozen=True)
class Pinned:
    """A result that is kept for comparison.

    Parameters
    ----------
    name : str
        For the list of pinned curves.
    computed : Computed
        Scenario and Trace.
    """

    name: str
    computed: Computed


@dataclass
class Session:
    """What one visitor sees; no other visitor shares any of it.

    Parameters
    ----------
    own : mapping of str to Scenario
        Scenarios that the page was started with, by name.
    state : PageState
        What is shown first.
    executor : Executor
        Where simulations run, outside of the event loop.
    patient : Executor
        Where work of many seconds runs, such as fits and reports.
    show : callable
        Called with every new result, and again when more is known beside it.
    complain : callable
        Called with a sentence when a scenario cannot be computed; empty when it can again.
    """

    own: Mapping[str, Scenario]
    state: PageState
    executor: Executor
    patient: Executor
    show: Callable[[Computed, Further], None]
    complain: Callable[[str], None]
    tab: str = TABS[0]
    computed: Computed | None = None
    further: Further = field(default_factory=Further)
    pinned: list[Pinned] = field(default_factory=list)
    measured: xarray.Dataset | None = None

    def __post_init__(self) -> None:
        """Prepare the queue of one."""
        self._updates: LatestOnly[PageState] = LatestOnly(self._update, self._failed)
        self._shown: PageState | None = None
        self._reported = False

    @property
    def is_idle(self) -> bool:
        """Whether what is shown is up to date."""
        return self._updates.is_idle

    def ask(self, state: PageState) -> None:
        """Show another state as soon as it is computed; states that arrive faster replace each other."""
        self.state = state
        self._updates.ask(state)

    def open(self, tab: str) -> None:
        """Show another tab, and compute what it needs beside the Trace."""
        self.tab = tab
        self.further = Further()
        self._updates.ask(self.state)

    def pin(self) -> None:
        """Keep the present result for comparison; the oldest one is dropped beyond `MOST_PINNED`."""
        if self.computed is not None:
            changed = ", ".join(f"{path} = {value}" for path, value in self.state.changes.items())
            name = self.state.preset + (f": {changed}" if changed else "")
            self.pinned = [*self.pinned, Pinned(name, self.computed)][-MOST_PINNED:]

    def unpin(self) -> None:
        """Forget the results that were kept."""
        self.pinned = []

    def stop(self) -> None:
        """Cancel what runs, when the visitor has left."""
        self._updates.stop()

    def _failed(self, error: Exception) -> None:
        """Report a mistake of the program as a sentence; the page goes on."""
        logging.getLogger(__name__).error("the page could not compute a scenario", exc_info=error)
        self._report(
            f"The program failed at this scenario ({type(error).__name__}: {error}). This is a mistake of electrovib; please"
            " report it with the address of this page."
        )

    def _report(self, sentence: str) -> None:
        """Show a sentence; an empty one only takes back what this session has reported itself."""
        if sentence or self._reported:
            self.complain(sentence)
        self._reported = bool(sentence)

    async def _update(self, state: PageState) -> None:
        if state != self._shown or self.computed is None:
            try:
                self.computed = await apart(self.executor, lambda: compute(scenario_of(state, own=self.own)))
            except InputError as error:
                self._report("\n".join(str(problem) for problem in error.problems))
                return
            except ElectrovibError as error:
                self._report(str(error))
                return
            self._shown = state
            self.further = Further(band=self.further.band, drawn=self.further.drawn)
            self._report("")
        self.show(self.computed, self.further)
        await self._compute_further(self.computed)

    async def _compute_further(self, found: Computed) -> None:
        """Compute what the open tab needs, a slice at a time; stop as soon as something newer waits."""
        for each in slices(self.tab, found):
            if self._updates.is_stale:
                return
            known = self.further
            self.further = await apart(self.executor, functools.partial(each, known))
            if not self._updates.is_stale:
                self.show(found, self.further)
