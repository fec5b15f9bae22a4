"""The laws against everything that was measured, computed when the site is built: the table of laws, and all measurements."""

from __future__ import annotations

from typing import Any, Final

from rst import hidden_contents, items, joined, plain, shown, title

import electrovib as ev

ALL: Final = "evidence_measurements"
INTRODUCTION: Final = (
    "Computed by `electrovib evidence` when this site was built. How the laws are judged, and how to judge them by a"
    " measurement of your own, is in :doc:`/evidence`; every measurement, with its source and its traps, is in"
    f" :doc:`{ALL}`."
)


def pages(measured: str = "", **draws: Any) -> dict[str, str]:
    """Return the page of the laws and that of the measurements, by file name; all measurements by default."""
    found = ev.evidence(measured, **draws).document
    tables = [
        part
        for each in (*found.numbers, *found.tables)
        if each.rows
        for part in (title(each.title, "-"), shown(each))
    ]
    details = [part for each in found.pages if each.rows for part in (title(each.title, "-"), shown(each))]
    sentences = items(plain(each) for each in found.sentences)
    remarks = items(plain(each) for each in found.remarks)
    return {
        "evidence.rst": joined(
            [
                title("Laws and measurements"),
                INTRODUCTION,
                sentences,
                *tables,
                remarks,
                hidden_contents([ALL]),
            ]
        ),
        f"{ALL}.rst": joined([title("All measurements"), "What :doc:`evidence` is computed from.", *details]),
    }
