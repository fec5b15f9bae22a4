"""One visitor of the page: what is shown, what it is compared with, its computation, and what can be taken away."""

from __future__ import annotations

import asyncio
import functools
import logging
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Final, TypeVar

from electrovib.apps.explorer import runner
from electrovib.apps.explorer.computed import Computed, Further, Slice, compute, slices, with_answers
from electrovib.apps.explorer.runner import InterruptedWorkError, LatestOnly, Presence, Workers, apart
from electrovib.apps.explorer.state import PageState, scenario_of
from electrovib.core.budget import BudgetError, budget
from electrovib.core.errors import ElectrovibError, InputError

if TYPE_CHECKING:
    from concurrent.futures import Executor

    import xarray

    from electrovib.scenario import Scenario

R = TypeVar("R")
REST: Final = 0.4
"""Time for which no slider moves before the key figures that take longer are computed [s]: a moving one is not held up."""
GESTURE: Final = 2.0
"""Time after a result from which the next position of the same slider begins another change [s]."""


@dataclass(frozen=True)
class Earlier:
    """A result behind the present one: that before the last change or, kept until it is dropped, the one called A."""

    computed: Computed
    state: PageState
    further: Further = field(default_factory=Further)
    is_kept: bool = False

    @property
    def name(self) -> str:
        """Scenario and changes."""
        changes = [f"{path} = {value}" for path, value in self.state.changes.items()]
        return ", ".join([self.state.preset, *changes])


@dataclass
class Session:
    """What a page shows; another tab of the browser shares none of it but the workers.

    `own` are the scenarios that the page was started with. `show` is called with every new result, and again
    when more is known beside it; `complain` with a sentence when a scenario cannot be computed, empty when it
    can again; `busy` with True when a computation takes longer than a moment, and with False when it has
    ended; `tell` when key figures follow a result. A change begins with another parameter, or after a pause.
    """

    own: Mapping[str, Scenario]
    state: PageState
    workers: Workers
    show: Callable[[Computed, Further], None]
    complain: Callable[[str], None]
    busy: Callable[[bool], object] = bool
    tell: Callable[[], object] = bool
    computed: Computed | None = None
    further: Further = field(default_factory=Further)
    earlier: Earlier | None = None
    measured: xarray.Dataset | None = None

    def __post_init__(self) -> None:
        """Prepare the queue of one."""
        self._updates: LatestOnly[PageState] = LatestOnly(self._update, self._failed, self.busy)
        self.shown: PageState | None = None
        self._presence = Presence()
        self._reported = self._is_reading = False
        self._moved, self._drawn = set[str](), 0.0

    @property
    def is_idle(self) -> bool:
        """Whether what is shown is up to date."""
        return self._updates.is_idle

    def ask(self, state: PageState) -> None:
        """Show another state as soon as it is computed; states that arrive faster replace each other."""
        self._keep_former(state)
        self.state = state
        if not self._presence.has_left:
            self._updates.ask(state)

    def _keep_former(self, state: PageState) -> None:
        """Keep the present result beside the next ones where a change begins; that of another scenario is forgotten."""
        if self.kept is not None:
            return
        if state.preset != self.state.preset:
            self.earlier = None
            return
        before, after = self.state.changes, state.changes
        moved = {each for each in {*before, *after} if before.get(each) != after.get(each)}
        if not moved:
            return
        if moved != self._moved or monotonic() - self._drawn > GESTURE:
            self.earlier = None if self.computed is None else Earlier(self.computed, self.state)
        self._moved = moved

    @property
    def kept(self) -> Earlier | None:
        """The result that is kept as A."""
        return self.earlier if self.earlier is not None and self.earlier.is_kept else None

    def keep(self) -> None:
        """Keep what is shown, in place of what was kept before."""
        if self.computed is not None and self.shown is not None:
            self.earlier = Earlier(self.computed, self.shown, self.further, is_kept=True)

    def stop(self) -> None:
        """Cancel what runs, when the visitor has left, and forget what was kept."""
        self._presence.leave()
        self._updates.stop()
        self.computed = self.earlier = self.measured = None
        self.further = Further()

    async def work(self, work: Callable[[], R]) -> R:
        """Run work of many seconds in a thread, outside of the event loop, and return what it returns.

        An `ElectrovibError` is raised as it is; any other exception becomes one with a sentence, and is
        logged. Where the visitor has left meanwhile, the task that waits is cancelled: its page is no more.
        """
        try:
            return await apart(self.workers.patient, functools.partial(self._limited, work))
        except ElectrovibError:
            raise
        except InterruptedWorkError as error:
            raise InputError(str(error)) from None
        except Exception as error:
            logging.getLogger(__name__).exception("the page could not do what was asked")
            raise InputError(_mistake_of_ours(error)) from None
        finally:
            if self._presence.has_left:
                raise asyncio.CancelledError

    def _limited(self, work: Callable[[], R], is_in_vain: Callable[[], bool] = bool) -> R:
        """Do work in a thread, within the budget of a visitor."""
        within = budget(time=runner.LONGEST_RUN, memory=runner.LARGEST_RUN)
        with within, self._presence.working(is_in_vain):
            return work()

    async def read(self, work: Callable[[], R]) -> R:
        """Read a file of the visitor as `work`; while another file of this visitor is being read, it is refused."""
        if self._is_reading:
            raise InputError("Another file is still being read. Drop this one again when it has been read.")
        self._is_reading = True
        try:
            return await self.work(work)
        finally:
            self._is_reading = False

    def _failed(self, error: Exception) -> None:
        """Report a mistake of the program as a sentence; the page goes on."""
        logging.getLogger(__name__).error("the page could not compute a scenario", exc_info=error)
        self._report(_mistake_of_ours(error))

    def _report(self, sentence: str) -> None:
        """Show a sentence; an empty one only takes back what this session has reported itself."""
        if sentence or self._reported:
            self.complain(sentence)
        self._reported = bool(sentence)

    async def _update(self, state: PageState) -> None:
        if self.shown is None or state.tab != self.shown.tab:
            self.further = Further()
        if self.shown is None or self.computed is None or not state.has_scenario_of(self.shown):
            try:
                await self._simulate(state)
            except InterruptedWorkError:
                return
            except ElectrovibError as error:
                self._report(str(error))
                return
        else:
            self.shown = state
            self.show(self.computed, self.further)
        if self.computed is not None:
            await self._compute_further(self.computed)

    async def _simulate(self, state: PageState) -> None:
        """Simulate a scenario and show it; one that takes long among long work."""

        def run(longest: float, is_in_vain: Callable[[], bool] = bool) -> Computed:
            with self._presence.working(is_in_vain):
                return compute(scenario_of(state, own=self.own), longest=longest)

        begun = monotonic()

        def is_in_vain() -> bool:
            # a shorter run is shown in any case, so that the curves follow a slider while it moves
            return self._updates.is_stale and monotonic() - begun > runner.LONGEST_QUICK_RUN

        try:
            found = await apart(self.workers.quick, lambda: run(runner.LONGEST_SHORT_RUN))
        except BudgetError:
            found = await apart(self.workers.patient, lambda: run(runner.LONGEST_RUN, is_in_vain))
        self._display(state, found)

    def _display(self, state: PageState, found: Computed) -> None:
        self.computed, self.shown, self._drawn = found, state, monotonic()
        self.further = Further(band=self.further.band, population=self.further.population)
        self._report("")
        self.show(found, self.further)

    async def _compute_further(self, found: Computed) -> None:
        """Compute what the open tab needs, a slice at a time, and the key figures; stop as soon as something newer waits."""
        for each in slices(self.state.tab, found):
            if not await self._compute_slice(each, self.workers.patient):
                return
            self.show(found, self.further)
        if await self._updates.rests(REST):
            answer = functools.partial(with_answers, found=found)
            if await self._compute_slice(answer, self.workers.quick):
                self.tell()

    async def _compute_slice(self, work: Slice, executor: Executor) -> bool:
        """Compute something more beside the result, and return whether it is still wanted."""
        if self._updates.is_stale:
            return False
        try:
            piece = functools.partial(work, self.further)
            self.further = await apart(executor, lambda: self._limited(piece, lambda: self._updates.is_stale))
        except InterruptedWorkError:
            return False
        if self.earlier is not None and self.earlier.computed is self.computed:
            self.earlier = replace(self.earlier, further=self.further)
        return not self._updates.is_stale


def _mistake_of_ours(error: Exception) -> str:
    return (
        f"The program failed ({type(error).__name__}: {error}). This is a mistake of electrovib; please report it with the"
        " address of this page."
    )


@dataclass(frozen=True)
class Download:
    """One kind of file; `make` takes a `Computed` and returns the bytes."""

    label: str
    name: str
    media_type: str
    make: Callable[[Computed], bytes]


def _saved(shown: Computed, name: str) -> bytes:
    """Return the file as which a Trace is saved under this name."""
    from electrovib.exports.save import save

    with tempfile.TemporaryDirectory(prefix="electrovib-") as folder:
        (path,) = save(shown.trace, Path(folder) / name)
        return path.read_bytes()


def _bibliography(shown: Computed) -> bytes:
    """Write the papers whose models and values the scenario has, as BibTeX, and the other sources as comments."""
    from electrovib.core.discovery import paper_of, papers
    from electrovib.studies.catalogue import bibtex
    from electrovib.view.summary import references, walk_models

    known = papers()
    models = {paper_of(type(model)) for _, model in walk_models(shown.scenario)}
    named = {name for name in known if any(name in text for text in shown.scenario.sources.values())}
    entries = [bibtex(module, name) for name, module in known.items() if name in models | named]
    remarks = [f"% {reference} ({what})" for reference, what in references({"": shown.scenario})]
    return "\n\n".join([*entries, "\n".join(remarks)]).encode() + b"\n"


DOWNLOADS: Final = (
    Download(
        "Scenario (TOML)",
        "scenario.toml",
        "application/toml",
        lambda shown: shown.scenario.to_toml().encode(),
    ),
    *(
        Download(label, name, kind, functools.partial(_saved, name=name))
        for label, name, kind in (
            ("Numbers over time (CSV)", "trace.csv", "text/csv"),
            ("Trace (netCDF)", "trace.nc", "application/x-netcdf"),
            ("Figures (PNG)", "figures.png", "image/png"),
            ("Figures (SVG)", "figures.svg", "image/svg+xml"),
            ("Figures (PDF)", "figures.pdf", "application/pdf"),
            ("Report (HTML)", "report.html", "text/html"),
        )
    ),
    Download("References (BibTeX)", "references.bib", "application/x-bibtex", _bibliography),
)
