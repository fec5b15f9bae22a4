"""Measured times as a folder: a page with edges, fits and table, and the numbers as CSV."""

from __future__ import annotations

import csv
import io
import math
from typing import TYPE_CHECKING, Final

from electrovib.core.errors import InputError
from electrovib.data.marks import Form, unsigned
from electrovib.recordings.transitions.table import TimeRow, time_rows
from electrovib.study.reproduction import Page, Table
from electrovib.view.units import pretty_quantity

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from electrovib.recordings.transitions import MeasuredRing, MeasuredTimes
    from electrovib.recordings.transitions.result import DirectionTimes

FILES: Final[dict[str, Form]] = {"report.html": Form.PAGE, "times.csv": Form.TABLE}
"""Files of measured times and their forms."""
REFERENCES: Final = (
    "IEEE Std 181-2011, Transitions, Pulses, and Related Waveforms",
    "K. P. Burnham, D. R. Anderson, Model Selection and Multimodel Inference, 2nd ed., Springer, 2002",
)


def check_times_folder(folder: Path, inputs: Sequence[Path], *, force: bool) -> None:
    """Check, before the computation, that the folder can be written.

    Parameters
    ----------
    folder : Path
        Folder of the results.
    inputs : sequence of Path
        Files that are read; none of them is ever replaced.
    force : bool
        Whether files that this package did not write may be replaced.

    Raises
    ------
    InputError
        If it is a file, or if a file in it would be replaced.
    """
    from electrovib.data.atomic import check_writable

    if folder.exists() and not folder.is_dir():
        raise InputError("is a file, where the folder of the times is to be made", path=folder)
    if folder.is_dir():
        check_writable({folder / name: form for name, form in FILES.items()}, inputs=inputs, force=force)


def write_times(
    folder: Path,
    found: MeasuredTimes,
    ring: MeasuredRing | None = None,
    *,
    source: str = "",
    force: bool = False,
) -> list[Path]:
    """Write measured times into a folder, all files or none.

    Parameters
    ----------
    folder : Path
        Made if it does not exist.
    found : MeasuredTimes
        Times.
    ring : MeasuredRing, optional
        Oscillation after an edge.
    source : str
        Name of the record, for the title.
    force : bool
        Whether files that this package did not write may be replaced.

    Returns
    -------
    paths : list of Path
        ``report.html`` and ``times.csv``.
    """
    from electrovib.data.atomic import writing

    rows = time_rows(found, ring)
    texts = {"report.html": times_page(found, ring, source=source), "times.csv": times_csv(rows)}
    folder.mkdir(parents=True, exist_ok=True)
    outputs = {folder / name: FILES[name] for name in texts}
    with writing(outputs, force=force) as temporary:
        for path, text in zip(outputs, texts.values(), strict=True):
            temporary[path].write_text(text, encoding="utf-8")
    return list(outputs)


def times_csv(rows: Sequence[TimeRow]) -> str:
    """Write the table as CSV, in SI units, with full precision."""
    text = io.StringIO()
    text.write(f"# {unsigned(Form.TABLE)}\n")
    writer = csv.writer(text, lineterminator="\n")
    names = ("value", "lower", "upper", "standard_error", "scatter", "count", "method")
    writer.writerow(("group", "name", "unit", *names, "note"))
    for row in rows:
        cells = [getattr(row.number, name) for name in names]
        shown = [repr(cell) if isinstance(cell, float) else cell for cell in cells]
        writer.writerow((row.group, row.name, row.unit, *shown, row.note))
    return text.getvalue()


def times_page(found: MeasuredTimes, ring: MeasuredRing | None = None, *, source: str = "") -> str:
    """Write the page of measured times.

    Parameters
    ----------
    found : MeasuredTimes
        Times.
    ring : MeasuredRing, optional
        Oscillation after an edge.
    source : str
        Name of the record, for the title.

    Returns
    -------
    html : str
        One file that needs nothing else.
    """
    from electrovib.view import summary
    from electrovib.view.pages import page
    from electrovib.view.reproduced_page import drawn, page_figures
    from electrovib.view.svg import to_svg
    from electrovib.view.times_panels import times_panels

    panels = times_panels(found, ring)
    drawings = {}
    for panel in panels:
        figure = drawn(panel)
        figure.axes[0].set_title("", loc="left")  # on the page it is a heading
        drawings[panel.id] = to_svg(figure)
    words = (*found.words, *(ring.words if ring is not None else ()))
    return page(
        "comparison.html.jinja",
        title=f"Times of {found.signal.replace('_', ' ')}{f' in {source}' if source else ''}",
        answer=_answer(found),
        figures=page_figures(panels, drawings),
        tables=[_table(time_rows(found, ring)), *(_criteria(each) for each in found.directions)],
        pages=[Page("Limits", words)] if words else [],
        references=list(REFERENCES),
        versions=summary.versions(),
    )


def _answer(found: MeasuredTimes) -> str:
    """State the times of each direction in a sentence."""
    shown = " to ".join(f"{100 * each:g} %" for each in found.levels)
    said = []
    for each in found.directions:
        text = f"The {each.direction} edges take {_interval(each.recorded.value, each.recorded.lower, each.recorded.upper)}"
        text += f" between {shown} as recorded"
        own = each.without_sensor
        if found.sensor != "none":
            if own.value == 0 and math.isfinite(own.upper):
                text += (
                    f" and less than {pretty_quantity(own.upper, 's', digits=3)} with the sensor taken out"
                )
            elif math.isfinite(own.value):
                text += f" and {_interval(own.value, own.lower, own.upper)} with the sensor taken out"
            limit = pretty_quantity(each.sensor_limit, "s", digits=3)
            text += f"; an instantaneous change would show {limit} through this sensor"
        said.append(f"{text}.")
        said += [words for words in each.words if words.startswith("Warning")]
    return " ".join(said)


def _interval(value: float, lower: float, upper: float) -> str:
    text = pretty_quantity(value, "s", digits=3)
    if not math.isfinite(upper):
        return f"{text} (no interval)"
    return f"{text} ({pretty_quantity(lower, 's', digits=3)} to {pretty_quantity(upper, 's', digits=3)})"


def _table(rows: Sequence[TimeRow]) -> Table:
    shown = []
    for row in rows:
        value, lower, upper, scatter = (
            pretty_quantity(getattr(row.number, name), row.unit if row.unit != "1" else "", digits=4)
            if math.isfinite(getattr(row.number, name))
            else "none"
            for name in ("value", "lower", "upper", "scatter")
        )
        interval = f"{lower} to {upper}" if upper != "none" else "none"
        shown.append((row.group, row.name, value, interval, scatter, row.number.method, row.note))
    headings = (
        "Edges",
        "Quantity",
        "Value",
        "95 % interval",
        "Scatter between edges",
        "Interval from",
        "Note",
    )
    return Table("Times and parameters", headings, tuple(shown))


def _criteria(found: DirectionTimes) -> Table:
    rows = tuple(
        (name, f"{above:.4g}" if math.isfinite(above) else "rejected", found.rejected.get(name, ""))
        for name, above in found.criteria.items()
    )
    return Table(
        f"Forms of relaxation of the {found.direction} edges",
        ("Form", "AICc above the lowest", "Why it was rejected"),
        rows,
        caption=f"Summed over {len(found.edges)} edge{'s' * (len(found.edges) > 1)}, after the correlation of the noise"
        " has been filtered out.",
    )
