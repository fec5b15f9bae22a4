"""The page of one visitor."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, Final

from fastapi import Request
from nicegui import app, ui

from electrovib.apps.explorer.page.bar import Bar
from electrovib.apps.explorer.page.knobs import Knobs
from electrovib.apps.explorer.page.plots import Plots
from electrovib.apps.explorer.session import Session
from electrovib.apps.explorer.state import PageState, read_query
from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from electrovib.apps.explorer.computed import Computed
    from electrovib.apps.explorer.further import Further
    from electrovib.scenario import Scenario

_STYLE: Final = (Path(__file__).parent / "style.css").read_text(encoding="utf-8")
_PRIMARY: Final = "#1c5d94"
"""Dark enough for white text."""
WORKERS: Final = 2
"""Threads in which the simulations of all visitors run."""


def build(own: Mapping[str, Scenario], first: str) -> None:
    """Declare the page.

    Parameters
    ----------
    own : mapping of str to Scenario
        Scenarios that the page was started with, by name.
    first : str
        Name of the scenario that is shown where the address names none.
    """
    executor = ThreadPoolExecutor(WORKERS, thread_name_prefix="explorer")
    app.on_shutdown(lambda: executor.shutdown(wait=False, cancel_futures=True))

    @ui.page("/")
    def page(request: Request) -> None:
        Page(own, first, executor, request.url.query)


class Page:
    """What one visitor sees.

    Parameters
    ----------
    own, first : mapping of str to Scenario, str
        As for `build`.
    executor : ThreadPoolExecutor
        Where simulations run.
    query : str
        Part of the address behind the question mark.
    """

    def __init__(
        self, own: Mapping[str, Scenario], first: str, executor: ThreadPoolExecutor, query: str
    ) -> None:
        mistake = ""
        try:
            state = read_query(query, own=own, default=first)
        except InputError as error:
            state, mistake = (
                PageState(first),
                "The link could not be read: " + "; ".join(map(str, error.problems)),
            )
        self.session = Session(own, state, executor, self._show, self._complain)
        self.client = ui.context.client
        ui.add_css(_STYLE)
        ui.colors(primary=_PRIMARY)
        self.bar = Bar(self.session, ask=self._ask, redraw=self._redraw)
        self.knobs = Knobs(self.session, ask=self._ask)
        with ui.column().classes("w-full gap-2"):
            self.message = ui.label(mistake).props("role=alert").classes("text-negative whitespace-pre-line")
            self.plots = Plots(self.session, is_dark=lambda: self.bar.is_dark)
        self.client.on_disconnect(self.session.stop)
        ui.timer(0.01, lambda: self.session.ask(self.session.state), once=True)

    def _ask(self, state: PageState) -> None:
        """Compute another state, and write it into the address."""
        other = state.preset != self.session.state.preset
        self.session.ask(state)
        if other:
            self.knobs.rebuild()
        with self.client:
            ui.navigate.history.replace(f"/?{state.to_query()}")

    def _show(self, found: Computed, further: Further) -> None:
        with self.client:
            self.knobs.show(found)
            self.plots.show(found, further)

    def _redraw(self) -> None:
        if self.session.computed is not None:
            self._show(self.session.computed, self.session.further)

    def _complain(self, sentence: str) -> None:
        with self.client:
            self.message.set_text(sentence)
