"""The page of one visitor."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, Final

from fastapi import Request
from nicegui import app, events, ui

from electrovib.apps.explorer.page.bar import Bar
from electrovib.apps.explorer.page.knobs import Knobs
from electrovib.apps.explorer.page.plots import Plots
from electrovib.apps.explorer.page.recording import DROPPED, RecordingPanel
from electrovib.apps.explorer.runner import Workers, end_work
from electrovib.apps.explorer.session import Session
from electrovib.apps.explorer.state import PageState, read_query
from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from electrovib.apps.explorer.computed import Computed
    from electrovib.apps.explorer.further import Further
    from electrovib.scenario import Scenario

_STYLE: Final = (Path(__file__).parent / "style.css").read_text(encoding="utf-8")
_BACK: Final = (
    "window.addEventListener('popstate', () => emitEvent('explorer_back', window.location.search));"
)
_PRIMARY: Final = "#1c5d94"
"""Dark enough for white text."""
WORKERS: Final = 2
"""Threads in which the simulations of all visitors run."""
PATIENT_WORKERS: Final = 4
"""Threads in which their long simulations, fits, reports and uploads run."""


def build(own: Mapping[str, Scenario], first: str) -> None:
    """Declare the page; `first` is the name of the scenario that is shown where the address names none."""
    workers = Workers(
        ThreadPoolExecutor(WORKERS, thread_name_prefix="explorer"),
        ThreadPoolExecutor(PATIENT_WORKERS, thread_name_prefix="explorer-patient"),
    )

    def close() -> None:
        end_work()
        for each in (workers.quick, workers.patient):
            each.shutdown(wait=False, cancel_futures=True)

    app.on_shutdown(close)

    @ui.page("/")
    def page(request: Request) -> None:
        VisitorPage(own, first, workers, request.url.query)


class VisitorPage:
    """What one visitor sees; `query` is the part of the address behind the question mark."""

    def __init__(self, own: Mapping[str, Scenario], first: str, workers: Workers, query: str) -> None:
        mistake = ""
        try:
            state = read_query(query, own=own, default=first)
        except InputError as error:
            state, mistake = (
                PageState(first),
                "The link could not be read: " + "; ".join(map(str, error.problems)),
            )
        self.session = Session(own, state, workers, self._show, self._complain, self._busy)
        self.client, self.first = ui.context.client, first
        ui.add_css(_STYLE)
        ui.colors(primary=_PRIMARY)
        self.bar = Bar(
            self.session, ask=self._ask, reset=self._reset, redraw=self._redraw, toggle=self._toggle
        )
        self.knobs = Knobs(self.session, ask=self._ask)
        with ui.column().classes("w-full gap-2"):
            self.message = ui.label(mistake).props("role=alert").classes("text-negative whitespace-pre-line")
            self.plots = Plots(
                self.session,
                is_dark=lambda: self.bar.is_dark,
                make_recording=lambda: self._recording().element,
            )
        self.client.on_delete(self._leave)
        ui.on("explorer_back", self._went_back)
        ui.timer(0.01, lambda: ui.run_javascript(_BACK), once=True)
        ui.timer(0.01, lambda: self.session.ask(self.session.state), once=True)

    def _toggle(self) -> None:
        self.knobs.toggle()

    def _leave(self) -> None:
        self.session.stop()
        self.recording.stop()

    def _recording(self) -> RecordingPanel:
        self.recording = RecordingPanel(
            self.session, ask=self._ask, redraw=self._redraw, complain=self._complain, take=self._take
        )
        return self.recording

    def _take(self, scenario: Scenario) -> None:
        """Show a scenario that was dropped on the page."""
        self.session.own = {**self.session.own, DROPPED: scenario}
        self.bar.offer(DROPPED)
        self.session.state = PageState(self.session.state.preset)
        self._ask(PageState(DROPPED))

    def _ask(self, state: PageState, is_step: bool = True) -> None:
        """Compute another state, and write it into the address.

        `is_step`: the button `back` of the browser leads to the present state; not while a slider moves.
        """
        history = ui.navigate.history
        with self.client:
            (history.push if is_step else history.replace)(f"/?{state.to_query()}")
        self._change(state)

    def _reset(self) -> None:
        """Take all changes back, with the models and materials that replaced others."""
        self._ask(self.session.state.reset())
        self.knobs.rebuild()

    def _change(self, state: PageState) -> None:
        other = state.preset != self.session.state.preset
        self.session.ask(state)
        self.message.set_text("")
        if other:
            self.knobs.rebuild()

    def _went_back(self, event: events.GenericEventArguments) -> None:
        """Show the state of an address to which the visitor went back or forward."""
        try:
            state = read_query(str(event.args).removeprefix("?"), own=self.session.own, default=self.first)
        except InputError as error:
            self._complain(f"The link could not be read: {'; '.join(map(str, error.problems))}")
            return
        self.session.state = state
        self.bar.show(state.preset)
        self.session.ask(state)
        self.message.set_text("")
        self.knobs.rebuild()

    def _show(self, found: Computed, further: Further) -> None:
        with self.client:
            self.knobs.show(found)
            self.plots.show(found, further)

    def _busy(self, is_busy: bool) -> None:
        with self.client:
            self.plots.busy(is_busy)

    def _redraw(self) -> None:
        if self.session.computed is not None:
            self._show(self.session.computed, self.session.further)

    def _complain(self, sentence: str) -> None:
        with self.client:
            self.message.set_text(sentence)
