"""The design of a plate for people and programs: table of all candidates, page and figure."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from electrovib.core.errors import InputError, gathered
from electrovib.core.files import inputs_noted
from electrovib.data.atomic import check_writable, writing
from electrovib.data.csv_text import csv_text
from electrovib.data.marks import Form
from electrovib.study.design.plate import MAXIMISED, MINIMISED, ROUNDS, PlateDesign, find_plate
from electrovib.study.reproduction import Page
from electrovib.view.documents import Document, Drawing, drawn, html

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from electrovib.core.arrays import Real
    from electrovib.scenario import Source
    from electrovib.study.check import CheckRow, LimitsSource

FORMS: Final[dict[str, Form | None]] = {".csv": Form.TABLE, ".html": Form.PAGE, ".png": None, ".svg": None}
"""Suffix to form; figures carry no mark."""


def design_plate(
    scenario: Source,
    over: Sequence[str] | Mapping[str, Sequence[float] | Real] = (),
    *,
    materials: Sequence[str] = (),
    layer: str = "",
    maximise: Sequence[str] = MAXIMISED,
    minimise: Sequence[str] = MINIMISED,
    limits: LimitsSource | Sequence[LimitsSource] = None,
    set: Mapping[str, Any] | None = None,  # noqa: A002 - the name of the option
    refine: int = ROUNDS,
    output: str | Path | None = None,
    force: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> PlateDesign:
    """Find the plate and the drive that give the most force within breakdown, current and perception, and the Pareto set.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        As for `electrovib.load`.
    over : sequence of str, or mapping of str to sequence of float
        Parameters that are varied: ``"stack.insulator.thickness=1um:20um:10log"``, or dotted path to values in SI or with
        units; thickness, permittivity (``stack.insulator.material.permittivity``), amplitude, frequency. Every
        combination is a candidate.
    materials : sequence of str
        Materials of the insulator, each combined with all values: ``["silica", "parylene C"]``; that of the scenario if
        empty.
    layer : str
        Layer whose material is varied; the only one of the plate if empty.
    maximise, minimise : sequence of str
        Objectives: quantities as for `electrovib.sweep`, the largest values that `electrovib.check` compares with limits
        (``"peak voltage"``, ``"peak current"``, ``"charge"``, ``"stored energy"``, ``"peak body current"``), or varied
        paths. The first one decides which candidate is the best.
    limits : str, Path, mapping, Limits, or a list of them, optional
        Further limits beside those of the scenario, as for `electrovib.check`; the strictest counts.
    set : mapping of str to value, optional
        Dotted path to value, put into the scenario.
    refine : int
        Rounds in which candidates are added around the best one, and around the best one with the binding limit relaxed by
        10 %; each halves the distance of the values there. 0 keeps to the given values.
    output : str or Path, optional
        ``.csv`` with every candidate and every limit, ``.html`` with figure and tables, ``.png`` or ``.svg``, the figure.
    force : bool
        Whether a file that was not written by electrovib may be replaced; a figure carries no mark, so it always needs it.
    progress : callable, optional
        Function of the number of candidates that are solved and of all.

    Returns
    -------
    PlateDesign
        Candidates with every margin, the Pareto set, and ``answer``: the best plate, what binds there, and what a less
        strict limit would gain.

    Raises
    ------
    InputError
        Every mistake at once; nothing has been written then.
    BudgetError
        If all candidates would take more time or memory than `electrovib.budget` allows.

    Notes
    -----
    A candidate is forbidden by a declared limit that it exceeds, by a field above the strength of its film (also an
    unverified one, which the row states), by Paschen's law in the gap, and where the scenario calibrates a detection
    threshold, by a change of friction below it. The best candidate is compared with all limits again by `electrovib.check`.
    """
    problems: list[Any] = []
    with inputs_noted() as inputs:
        if output is not None:
            with gathered(problems):
                check_writable({Path(output): _form(Path(output))}, inputs=inputs, force=force)
        if problems:
            raise InputError(problems)
        found = find_plate(
            scenario,
            over,
            materials=materials,
            layer=layer,
            maximise=maximise,
            minimise=minimise,
            limits=limits,
            set=set,
            refine=refine,
            progress=progress,
        )
    if output is not None:
        check_writable({Path(output): _form(Path(output))}, inputs=inputs, force=force)
        write_plate(found, output, force=force)
    return found


def write_plate(found: PlateDesign, path: str | Path, *, force: bool = False) -> Path:
    """Write the design of a plate."""
    from electrovib.view.svg import to_png, to_svg

    place = Path(path)
    form = _form(place)
    suffix = place.suffix.lower()
    if suffix == ".png":
        content = to_png(figure_of(found))
    elif suffix == ".svg":
        content = to_svg(figure_of(found)).encode()
    else:
        content = (as_csv(found) if suffix == ".csv" else as_html(found)).encode()
    with writing({place: form}, force=force) as temporary:
        temporary[place].write_bytes(content)
    return place


def figure_of(found: PlateDesign) -> Figure:
    """Return the figure of all candidates with the Pareto set."""
    return drawn(_drawing(found))


def _drawing(found: PlateDesign) -> Drawing:
    from electrovib.view.plots.trade_off import SIZE, trade_off

    caption = (
        "Every sign is one candidate. No candidate on the line can be improved in one objective without loss in the other;"
        " the star is the best one in the first objective."
    )
    return Drawing(
        id="pareto",
        title="Candidates and Pareto set",
        caption=caption,
        draw=lambda axes: trade_off(found, ax=axes),
        size=SIZE,
    )


def as_csv(found: PlateDesign) -> str:
    """Return a row for each candidate, with every objective and every limit, in SI at 17 digits."""
    rows = list(dict.fromkeys(row.quantity for each in found.candidates for row in each.rows))
    units = {row.quantity: row.unit for each in found.candidates for row in each.rows}
    headings = [
        "material",
        *(f"{path} [{found.units[path]}]" for path in found.axes),
        *(f"{each.name} [{each.unit}]" for each in found.objectives),
        *(head for name in rows for head in _limit_heads(name, units[name])),
        *("within the limits", "forbidden by", "Pareto set", "best", "refined", "strength in doubt"),
    ]
    efficient = {id(each) for each in found.pareto}
    cells = []
    for each in found.candidates:
        by_quantity = {row.quantity: row for row in each.rows}
        cells.append(
            [
                each.material,
                *(each.at[path] for path in found.axes),
                *(each.values[one.name] for one in found.objectives),
                *(cell for name in rows for cell in _limit_cells(by_quantity.get(name))),
                _yes(each.is_allowed),
                "; ".join(each.forbidden_by),
                *(_yes(value) for value in (id(each) in efficient, each is found.best, each.refined)),
                "; ".join(each.doubts),
            ]
        )
    return csv_text(headings, cells, remarks=[found.answer, *found.notes], diagnostics=found.diagnostics)


def _limit_heads(name: str, unit: str) -> tuple[str, ...]:
    return f"{name} [{unit}]", f"limit of {name} [{unit}]", f"{name}: limit/value", f"{name}: state"


def _limit_cells(row: CheckRow | None) -> tuple[object, ...]:
    return ("", "", "", "") if row is None else (row.value, row.limit, row.margin, row.state)


def _yes(value: bool) -> str:
    return "yes" if value else "no"


def as_html(found: PlateDesign) -> str:
    """Return a page that begins with the answer and the figure."""
    notes = [*found.notes, *(found.check.notes if found.check is not None else ())]
    document = Document(
        title=f"Design of the plate: {found.base.title or 'a scenario'}",
        answer=found.answer,
        diagnostics=found.diagnostics,
        figures=[_drawing(found)],
        tables=found.tables,
        pages=[Page(id="", title="Notes", paragraphs=tuple(notes))],
    )
    return html(document)


def _form(path: Path) -> Form | None:
    if path.suffix.lower() not in FORMS:
        raise InputError(
            f"the design of a plate is written as {', '.join(FORMS)}, not as '{path.suffix}'", path=path
        )
    return FORMS[path.suffix.lower()]
