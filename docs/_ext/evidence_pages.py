"""The laws against everything that was measured, computed when the site is built: the table of laws, and all measurements."""

from __future__ import annotations

from typing import Any, Final

from rst import folded, hidden_contents, items, joined, plain, shown, title

import electrovib as ev
from electrovib.core.answer import Shown
from electrovib.view.pages import drawn, to_svg

ALL: Final = "evidence_measurements"
INTRODUCTION: Final = (
    "Computed by `electrovib evidence` when this site was built. How the laws are judged, and how to judge them by a"
    " measurement of your own, is in :doc:`/evidence`; every measurement, with its source and its traps, is in"
    f" :doc:`{ALL}`."
)


def pages(measured: str = "", **draws: Any) -> dict[str, str]:
    """Return the page of the laws, that of the measurements and their pictures, by file name; all measurements by default."""
    found = ev.evidence(measured, **draws).document
    tables = [
        part
        for each in (*found.numbers, *found.tables)
        if each.rows
        for part in (title(each.title, "-"), shown(each))
    ]
    details = [
        part
        for each in found.pages
        if each.rows
        for part in (title(each.title, "-"), folded(f"{len(each.rows)} rows", shown(each)))
    ]
    overview, *others = found.figures
    sentences = items(plain(each) for each in found.sentences)
    remarks = items(plain(each) for each in found.remarks)
    pictures = {f"evidence_{each.id}.svg": to_svg(drawn(each)) for each in found.figures}
    return pictures | {
        "evidence.rst": joined(
            [
                title("Laws and measurements"),
                INTRODUCTION,
                sentences,
                title("Each measurement", "-"),
                picture(overview),
                *tables,
                remarks,
                hidden_contents([ALL]),
            ]
        ),
        f"{ALL}.rst": joined(
            [
                title("All measurements"),
                "What :doc:`evidence` is computed from.",
                *([title("Over what was varied", "-")] if others else []),
                *(folded(each.title, picture(each)) for each in others),
                *details,
            ]
        ),
    }


def picture(figure: Shown) -> str:
    """Return a figure with its caption."""
    return (
        f".. figure:: evidence_{figure.id}.svg\n   :alt: {plain(figure.title)}\n\n   {plain(figure.caption)}"
    )
