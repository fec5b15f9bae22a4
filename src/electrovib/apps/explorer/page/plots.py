"""What a tab shows: drawing of the layers, diagnostics, plots, tables and sentences, in which every text is escaped."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from nicegui import ui

from electrovib.apps.explorer import key_figures, pictures
from electrovib.apps.explorer.computed import (
    FADING,
    FELT,
    FREQUENCY,
    LAWS,
    RECORDING,
    SAFETY,
    TABS,
    TIME,
    Further,
)
from electrovib.apps.explorer.fading import animation, why_not
from electrovib.apps.explorer.felt_picture import felt
from electrovib.apps.explorer.key_figures import KeyFigure, answers, drawing
from electrovib.core.diagnostics import STATES, Diagnostic
from electrovib.studies.check.result import HARDWARE
from electrovib.studies.widths import missed_by
from electrovib.view.pages import part
from electrovib.view.style import MOST, pretty_quantity
from electrovib.view.summary import quantities_of_scenario

if TYPE_CHECKING:
    import xarray

    from electrovib.apps.explorer.computed import Computed
    from electrovib.apps.explorer.page.build import VisitorPage
    from electrovib.apps.explorer.session import Earlier
    from electrovib.core.answer import Document, Table


class PulsePlayer(ui.element, component="pulse_player.js"):
    """Layers with their charges beside the force, with a button that plays and a slider of the time."""

    def __init__(self) -> None:
        super().__init__()
        self._props["pulse"] = {}
        self.set_visibility(False)

    def show(self, pulse: Mapping[str, Any]) -> None:
        """Show what `electrovib.apps.explorer.fading.animation` returns, at the present place of the slider; nothing if empty."""
        if pulse and self._props["pulse"] != pulse:
            self._props["pulse"] = dict(pulse)
            self.update()
        self.set_visibility(bool(pulse))


_FEW_PLOTS: Final = 2
"""Plots that are higher than where there are more."""
_LIGHTER: Final = {
    "#0072b2": "#5bb4f0",
    "#d55e00": "#ff8a3c",
    "#009e73": "#35d0a2",
    "#5c4a00": "#d8bd4a",
    "#5e3c99": "#a98be0",
    "#8a8d2e": "#c9cc5a",
    "#6f4e37": "#c59a78",
    "#870f0f": "#ff7a7a",
    "#2222e0": "#8c8cff",
    "#2e6b3a": "#6cc47c",
}
"""Colours of curves that are too dark on a dark page."""
_INK: Final = {False: ("#222222", "#e2e2e2"), True: ("#e6e6e6", "#444444")}
"""Colours of text and grid on a light and on a dark page."""


class Plots:
    """The part of the page that shows results; a plot is drawn when its tab is open.

    `place` is where the controls of the tab for recordings are.
    """

    def __init__(self, page: VisitorPage) -> None:
        self._page, self._session = page, page.session
        self._figures = KeyLine()
        self._tabs = ui.tabs(on_change=lambda e: page.open(e.value))
        with self._tabs.props('dense no-caps outside-arrows align=left aria-label="Results"').classes(
            "w-full"
        ):
            for name in TABS:
                ui.tab(name)
        self.open(page.session.state.tab)
        self.place = ui.column().classes("w-full gap-2")
        with ui.element("div").classes("w-full relative"):
            # which is read out, unlike the panel
            self._status = ui.label().classes("ev-status").props("role=status")
            self._panel = ui.column().classes("w-full gap-2 ev-panel").props("aria-busy=false")
        with self._panel:
            self._lead = _html("w-full text-sm").props("aria-live=polite")
            self._player = PulsePlayer()
            self._grid = ui.element("div").classes("w-full grid grid-cols-1 xl:grid-cols-2 gap-2")
            self._words = _html("w-full text-sm overflow-x-auto")
        with ui.element("div").classes("w-full grid grid-cols-1 lg:grid-cols-2 gap-4"):
            self._stack = _html("w-full max-w-md")
            with ui.column().classes("gap-1"):
                ui.label("Validity").classes("text-base font-bold").props("role=heading aria-level=2")
                self._judged = _html("text-sm").props("aria-live=polite")
        self._plots: list[Any] = []
        self._height = ""

    def show(self, found: Computed, further: Further) -> None:
        """Show a result, and what is known beside it."""
        session = self._session
        self.tell()
        beside: dict[str, Any] = {"earlier": session.earlier, "measured": session.measured}
        shown = content(session.state.tab, found, further, **beside)
        for element, text in (
            (self._stack, drawing(found)),
            (self._judged, judged_words(found.diagnostics)),
            (self._lead, shown.above),
            (self._words, shown.below),
        ):
            if element.content != text:  # what has not changed is not sent
                element.set_content(text)
        self.place.set_visibility(session.state.tab == RECORDING)
        self._player.show(shown.pulse)
        self._make_room(len(shown.figures))
        for plot, figure in zip(self._plots, shown.figures, strict=False):
            if plot.figure != (themed := self._themed(figure)):
                title = figure["layout"]["title"]["text"]
                if plot.props.get("aria-label") != title:
                    plot.props(f'role=img aria-label="{title}"')
                plot.update_figure(themed)

    def tell(self) -> None:
        """Show the key figures, with those of a result that is kept."""
        session = self._session
        assert session.computed is not None
        kept = {} if session.kept is None else _figures(session.kept.computed, session.kept.further)
        self._figures.show(_figures(session.computed, session.further), kept)

    def open(self, tab: str) -> None:
        """Mark the open tab."""
        self._tabs.set_value(tab)

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
        is_dark = self._page.bar.is_dark
        ink, grid = _INK[is_dark]
        layout = figure["layout"]
        looks = (each.get(part, {}) for each in figure["data"] for part in ("line", "marker"))
        for look in looks if is_dark else ():
            if "color" in look:
                look["color"] = _LIGHTER.get(look["color"], look["color"])
        layout |= {"font": {"color": ink}, "paper_bgcolor": "rgba(0,0,0,0)", "plot_bgcolor": "rgba(0,0,0,0)"}
        for axis in ("xaxis", "yaxis"):
            layout[axis] |= {"gridcolor": grid, "linecolor": ink, "tickcolor": ink}
        return figure


def _figures(found: Computed, further: Further) -> dict[str, KeyFigure]:
    return found.figures | answers(further)


class KeyLine:
    """The key figures in a line; one that is not known yet keeps its former value, greyed."""

    def __init__(self) -> None:
        with ui.element("dl").classes("ev-key w-full").props('aria-label="Key figures"'):
            names = (*key_figures.FORCES.values(), key_figures.FELT, key_figures.LIMIT, key_figures.VALIDITY)
            self._places = {name: _html("ev-key-figure") for name in names}
        self.show({}, {})

    def show(self, known: Mapping[str, KeyFigure], kept: Mapping[str, KeyFigure]) -> None:
        """Show what is known of a result, and below each figure that of the one that is kept, if there is one."""
        for name, place in self._places.items():
            if (figure := known.get(name)) is None and place.content:
                place.classes("ev-stale")
                continue
            place.classes(remove="ev-stale")
            beside = kept.get(name, KeyFigure("…")) if kept else None
            text = _part("key_figure", name=name, figure=figure or KeyFigure("…"), kept=beside)
            if place.content != text:
                place.set_content(text)


def _html(classes: str) -> ui.html:
    return ui.html("", sanitize=False).classes(classes)


MOST_PLOTS: Final = 4
"""Plots that are visible at once; more would make a slider lag."""


@dataclass(frozen=True)
class Content:
    """Plots and texts of a tab.

    `figures` are tables for Plotly, `MOST_PLOTS` at most; `above` and `below` are HTML, in which every text
    is escaped. `pulse` is an animation, as `PulsePlayer.show` takes it.
    """

    figures: list[dict[str, Any]]
    above: str = ""
    below: str = ""
    pulse: dict[str, Any] = field(default_factory=dict)


def content(
    tab: str,
    found: Computed,
    further: Further,
    *,
    earlier: Earlier | None = None,
    measured: xarray.Dataset | None = None,
) -> Content:
    """Return what a tab shows.

    A sentence above takes the place of a plot or table that cannot be shown.
    """
    above = paragraphs(further.problems)
    shown = Content([], above)
    if tab == TIME:
        unknown = pictures.unknown_signals(found)
        lacking = [f"The {each} is not shown: it has no value in this scenario." for each in unknown]
        shown = Content(pictures.over_time(found, earlier), above + paragraphs(lacking))
    elif tab == FADING:
        return Content([], above + paragraphs([why_not(found)]), pulse=animation(found))
    elif tab == FREQUENCY:
        figures = pictures.over_frequency(found, earlier, band=further.band)
        said, below = answer_words(further.population)
        shown = Content(figures, above + said, below)
    elif tab == LAWS:
        figures = pictures.laws(found, further.laws, further.measured)
        shown = Content(figures, above, law_words(found, further))
    elif tab == FELT and (percept := further.percept) is not None:
        said, below = answer_words(percept.document, skipped=bool(percept.title))
        shown = Content(felt(percept, found.scenario), above + said, below)
    elif tab == SAFETY and further.check is not None:
        said, below = answer_words(further.check.document, further.check.state)
        shown = Content([], above + said, below)
    elif tab == RECORDING and measured is not None:
        figures = pictures.recorded(found, measured)
        lacking = [] if figures else ["No signal of this recording is over time or over frequency."]
        shown = Content(figures, above + paragraphs(lacking))
    return Content(shown.figures[:MOST_PLOTS], shown.above, shown.below)


def paragraphs(sentences: Iterable[str]) -> str:
    """Write each sentence as a paragraph."""
    return _part("paragraphs", sentences=sentences)


_part: Final = functools.partial(part, "explorer.html.jinja")


_OF_FIT: Final = ("Parameter", "Estimate", "95 % interval", "Determined", "Note")
"""Columns of the estimates that the page has room for."""


def fit_content(document: Document) -> str:
    """Write the sentences of a fit, and its estimates in a table, which takes the place of the sentences on each."""
    (estimates,) = (each for each in document.tables if each.title == "Parameters")
    places = [estimates.headings.index(name) for name in _OF_FIT]
    rows = [[row[place] for place in places] for row in estimates.rows]
    stated = {row[0] for row in estimates.rows}
    others = [each for each in document.sentences if each.partition(":")[0] not in stated]
    return paragraphs(others) + _part("table", headings=_OF_FIT, rows=rows)


def judged_words(diagnostics: Sequence[Diagnostic]) -> str:
    """List what limits the validity of a result, the worst first, and count what is in order."""
    worst_first = sorted(diagnostics, key=lambda each: -STATES.index(each.state))
    fine = [each.name for each in diagnostics if each.state == "ok"]
    return _part("judged", diagnostics=[each for each in worst_first if each.state != "ok"], fine=fine)


def law_words(found: Computed, further: Further) -> str:
    """Tabulate the largest force of each law over that of the law of the page, below what was measured."""
    own, rows = _peak(found), []
    for name, case in {type(found.scenario.force).__name__: found, **further.laws}.items():
        peak, law = _peak(case), case.scenario.force
        ratio = f"{peak / own:.3g}" if own > 0 and np.isfinite(peak) else "–"
        largest = pretty_quantity(peak, "N", digits=3)
        rows.append((name, _plain(law.evaluation_surface), law.status, largest, ratio, missed_by(name)))
    rows += [(name, "", "", "cannot run here", why, "") for name, why in further.left_out.items()]
    headings = (
        *("law", "stress evaluated in", "source status", "largest force", "relative to this law"),
        "measured forces missed by",
    )
    cut = len(further.laws) >= MOST
    more = [further.measured.words] if further.measured else []
    more += ["The curves are those of this law, and of the four that miss measured forces the least."] * cut
    return paragraphs(more) + _part("table", headings=headings, rows=rows)


def answer_words(document: Document | None, outcome: str = "unknown", *, skipped: int = 0) -> tuple[str, str]:
    """Write what stands above figures and tables of an answer, and these with the rest; nothing where there is none.

    Above are the first sentence that is not skipped, in the colour of its outcome, and what protects a person.
    """
    if document is None:
        return "", ""
    first, *others = document.sentences[skipped:]
    said = _part("first", sentence=first, outcome=outcome)
    said += paragraphs(each for each in others if each == HARDWARE)
    tables = "".join(map(_of_answer, (*document.numbers, *document.tables)))
    captions = (each.caption for each in document.figures if each.caption)
    below = paragraphs([*captions, *(each for each in others if each != HARDWARE)])
    return said, tables + below + _part("listed", remarks=document.remarks)


def _peak(found: Computed) -> float:
    """Return the largest attraction of a run; at the output times alone for a solver that advances in steps."""
    if not found.has("electrostatic_force"):
        return float("nan")
    name = "peak electrostatic_force"
    largest = float(np.nanmax(np.abs(found.values("electrostatic_force"))))
    return quantities_of_scenario(found.scenario, (name,), quick=True).get(name, largest)


def _plain(name: str) -> str:
    """Write a name of the program in words."""
    return name.replace("_", " ")


def _of_answer(table: Table) -> str:
    """Write a table of an answer, without the margins, for which a phone has no room; the states of limits have their colours."""
    kept = [place for place, name in enumerate(table.headings) if name != "limit/value"]
    rows = [[row[place] for place in kept] for row in table.rows]
    headings = [table.headings[place] for place in kept]
    return _part("table", headings=headings, rows=rows, states=table.looks.get(0) == "state")
