"""What the open tab of a page shows: plots, and the text above and below them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, Any, Final

from electrovib.apps.explorer.further import FELT, FREQUENCY, LAWS, RECORDING, SAFETY, TIME, Further
from electrovib.apps.explorer.page.words import (
    felt_words,
    kept_words,
    law_words,
    safety_words,
    verdict_words,
)
from electrovib.apps.explorer.pictures.felt import felt
from electrovib.apps.explorer.pictures.laws import laws
from electrovib.apps.explorer.pictures.over_frequency import over_frequency
from electrovib.apps.explorer.pictures.over_time import over_time, unknown_signals
from electrovib.apps.explorer.pictures.recorded import recorded

if TYPE_CHECKING:
    import xarray

    from electrovib.apps.explorer.computed import Computed
    from electrovib.apps.explorer.session import Pinned

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
