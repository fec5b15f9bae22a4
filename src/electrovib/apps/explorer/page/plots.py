"""Drawing of the layers, diagnostics, and plots in tabs; a plot is drawn when its tab is open."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, Any, Final

from nicegui import ui

from electrovib.apps.explorer.drawing import drawing
from electrovib.apps.explorer.further import FELT, FREQUENCY, LAWS, RECORDING, SAFETY, TABS, TIME, Further
from electrovib.apps.explorer.page.words import (
    felt_words,
    judged_words,
    kept_words,
    law_words,
    safety_words,
    verdict_words,
)
from electrovib.apps.explorer.pictures import (
    felt,
    laws,
    over_frequency,
    over_time,
    recorded,
    unknown_signals,
)

if TYPE_CHECKING:
    import xarray

    from electrovib.apps.explorer.computed import Computed
    from electrovib.apps.explorer.session import Pinned, Session

_FEW_PLOTS: Final = 2
"""Plots that are higher than where there are more."""
_LIGHTER: Final = {
    "#0072b2": "#5bb4f0",
    "#d55e00": "#ff8a3c",
    "#009e73": "#35d0a2",
    "#333333": "#d0d0d0",
    "#5e3c99": "#a98be0",
    "#8a8d2e": "#c9cc5a",
    "#6f4e37": "#c59a78",
    "#870f0f": "#ff7a7a",
    "#b0009a": "#ff6be8",
    "#2222e0": "#8c8cff",
    "#2e6b3a": "#6cc47c",
}
"""Colours of curves that are too dark on a dark page."""
_INK: Final = {False: ("#222222", "#e2e2e2"), True: ("#e6e6e6", "#444444")}
"""Colours of text and grid on a light and on a dark page."""


class Plots:
    """The part of the page that shows results.

    `make_recording` makes the controls of the tab for recordings, and returns their element.
    """

    def __init__(
        self, session: Session, *, is_dark: Callable[[], bool], make_recording: Callable[[], Any]
    ) -> None:
        self._session, self._is_dark = session, is_dark
        with ui.element("div").classes("w-full grid grid-cols-1 lg:grid-cols-2 gap-4"):
            self._stack = ui.html("", sanitize=False).classes("w-full max-w-md")
            with ui.column().classes("gap-1"):
                ui.label("Validity").classes("text-base font-bold").props("role=heading aria-level=2")
                self._judged = ui.html("", sanitize=False).classes("text-sm").props("aria-live=polite")
        tabs = ui.tabs(on_change=lambda e: session.open(e.value))
        with tabs.props('dense no-caps outside-arrows align=left aria-label="Results"').classes("w-full"):
            for name in TABS:
                ui.tab(name)
        tabs.set_value(TABS[0])
        self._recording = make_recording()
        with ui.element("div").classes("w-full relative"):
            self._status = (
                ui.label().classes("ev-status").props("role=status")
            )  # which is read out, unlike the panel
            self._panel = ui.column().classes("w-full gap-2 ev-panel").props("aria-busy=false")
        with self._panel:
            self._lead = ui.html("", sanitize=False).classes("w-full text-sm").props("aria-live=polite")
            self._grid = ui.element("div").classes("w-full grid grid-cols-1 xl:grid-cols-2 gap-2")
            self._words = ui.html("", sanitize=False).classes("w-full text-sm overflow-x-auto")
        self._plots: list[Any] = []
        self._sent: dict[Any, str] = {}
        self._height = ""

    def show(self, found: Computed, further: Further) -> None:
        """Show a result, and what is known beside it."""
        self._set(self._stack, drawing(found))
        self._set(self._judged, judged_words(found.diagnostics))
        self._recording.set_visibility(self._session.tab == RECORDING)
        session = self._session
        open_tab = content(session.tab, found, further, pinned=session.pinned, measured=session.measured)
        figures = open_tab.figures
        self._set(self._lead, open_tab.above)
        self._set(self._words, open_tab.below)
        self._make_room(len(figures))
        for plot, figure in zip(self._plots, figures, strict=False):
            if plot.figure != (themed := self._themed(figure)):
                title = figure["layout"]["title"]["text"]
                if plot.props.get("aria-label") != title:
                    plot.props(f'role=img aria-label="{title}"')
                plot.update_figure(themed)

    def busy(self, is_busy: bool) -> None:
        """Show whether the open tab is being computed."""
        self._panel.props(f"aria-busy={str(is_busy).lower()}")
        self._status.set_text("Computing …" if is_busy else "")

    def _make_room(self, count: int) -> None:
        """Make the elements of some plots, higher ones where there are few, and remove the others."""
        height = "h-64" if count > _FEW_PLOTS else "h-96"
        kept = count if height == self._height else 0  # the framework does not resize a plot
        for plot in self._plots[kept:]:
            plot.delete()
        del self._plots[kept:]
        self._height = height
        while len(self._plots) < count:
            with self._grid:
                self._plots.append(ui.plotly({"data": [], "layout": {}}).classes(f"w-full {height}"))

    def _themed(self, figure: dict[str, Any]) -> dict[str, Any]:
        ink, grid = _INK[self._is_dark()]
        layout = figure["layout"]
        if self._is_dark():
            for each in figure["data"]:
                for part in ("line", "marker"):
                    drawn = each.get(part, {})
                    if drawn.get("color") in _LIGHTER:
                        each[part] = {**drawn, "color": _LIGHTER[drawn["color"]]}
        layout |= {"font": {"color": ink}, "paper_bgcolor": "rgba(0,0,0,0)", "plot_bgcolor": "rgba(0,0,0,0)"}
        for axis in ("xaxis", "yaxis"):
            layout[axis] |= {"gridcolor": grid, "linecolor": ink, "tickcolor": ink}
        return figure

    def _set(self, element: Any, content: str) -> None:
        """Send a text only if it has changed."""
        if self._sent.get(element.id) != content:
            self._sent[element.id] = content
            element.set_content(content)


MOST_PLOTS: Final = 4
"""Plots that are visible at once; more would make a slider lag."""


@dataclass(frozen=True)
class Content:
    """Plots and texts of a tab.

    `figures` are tables for Plotly, `MOST_PLOTS` at most; `above` and `below` are HTML, in which every text
    is escaped.
    """

    figures: list[dict[str, Any]]
    above: str = ""
    below: str = ""


def content(
    tab: str,
    found: Computed,
    further: Further,
    *,
    pinned: Sequence[Pinned] = (),
    measured: xarray.Dataset | None = None,
) -> Content:
    """Return what a tab shows.

    A sentence above takes the place of a plot or table that cannot be shown.
    """
    above = "".join(f"<p>{escape(each)}</p>" for each in further.problems)
    kept = [each.computed for each in pinned]
    shown = Content([], above)
    if tab == TIME:
        above += "".join(f"<p>{escape(_unknown(each))}</p>" for each in unknown_signals(found))
        shown = Content(over_time(found, kept), above + kept_words([each.name for each in pinned]))
    elif tab == FREQUENCY:
        figures = over_frequency(found, kept, band=further.band)
        shown = Content(
            figures, above + kept_words([each.name for each in pinned]), f"<p>{escape(further.drawn)}</p>"
        )
    elif tab == LAWS:
        shown = Content(laws(found, further.laws), above, law_words(found, further))
    elif tab == FELT and further.percept is not None:
        percept = further.percept
        shown = Content(felt(percept, found.scenario), above + verdict_words(percept), felt_words(percept))
    elif tab == SAFETY and further.check is not None:
        shown = Content([], above, safety_words(further.check))
    elif tab == RECORDING and measured is not None:
        figures = recorded(found, measured)
        lacking = "" if figures else "<p>No signal of this recording is over time or over frequency.</p>"
        shown = Content(figures, above + lacking)
    return Content(shown.figures[:MOST_PLOTS], shown.above, shown.below)


def _unknown(signal: str) -> str:
    return f"The {signal} is not shown: it has no value in this scenario."
