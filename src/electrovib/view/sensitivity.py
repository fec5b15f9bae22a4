"""A sensitivity analysis as a folder: a page with figure and tables, and the indices as CSV."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import TYPE_CHECKING, Final

from electrovib.core.diagnostics import comment_lines
from electrovib.core.errors import InputError, gathered
from electrovib.core.files import inputs_noted
from electrovib.data.marks import Form, unsigned

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from electrovib.scenario import Source
    from electrovib.scenario.space import SpaceSource
    from electrovib.study.sensitivity import Sensitivity

FILES: Final[dict[str, Form]] = {
    "report.html": Form.PAGE,
    "indices.csv": Form.TABLE,
    "elasticities.csv": Form.TABLE,
    "space.toml": Form.SPACE,
}
"""Files of a sensitivity analysis and their forms."""
REFERENCES: Final = (
    "I. M. Sobol, Global sensitivity indices for nonlinear mathematical models and their Monte Carlo estimates, Math."
    " Comput. Simul. 55, 271 (2001)",
    "A. Saltelli et al., Variance based sensitivity analysis of model output, Comput. Phys. Commun. 181, 259 (2010)",
)


def sensitivity(
    scenario: Source,
    space: SpaceSource,
    *,
    quantity: str,
    n: int,
    seed: int,
    output: str | Path | None = None,
    force: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> Sensitivity:
    """Compute which parameters of a space a quantity depends on: Sobol indices with intervals, and local elasticities.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        Scenario with the values that stay fixed, as for `electrovib.load`.
    space : str, Path, mapping or Space
        Distributions of the others, as for `electrovib.read_space`: ``"fingers"``.
    quantity : str
        Name as for `electrovib.sweep`: ``"mean electrostatic_force"``.
    n : int
        Number of base draws, a power of 2; the scenario is evaluated n (inputs + 2) times.
    seed : int
        Seed of the draws, from 0 to 2**64 - 1.
    output : str or Path, optional
        Folder for ``report.html``, ``indices.csv``, ``elasticities.csv`` and ``space.toml``; all are written, or none.
    force : bool
        Whether files that this package did not write may be replaced.
    progress : callable, optional
        Function of the number of evaluations done and of all evaluations.

    Returns
    -------
    sensitivity : Sensitivity
        Indices, elasticities, the sample of the quantity, and ``answer``, which names what to measure first.

    Raises
    ------
    InputError
        For every mistake in scenario, space and quantity; nothing has been written then.
    """
    from electrovib.scenario import read_scenario
    from electrovib.scenario.space import read_space
    from electrovib.study.sensitivity import analyse

    problems: list[str] = []
    base = known = None
    with inputs_noted() as inputs:
        with gathered(problems):
            base = read_scenario(scenario)
        if base is not None:
            with gathered(problems):
                known = read_space(base, space)
    if output is not None:
        with gathered(problems):
            _check_folder(Path(output), inputs, force=force)
    if problems or base is None or known is None:
        raise InputError(problems)
    found = analyse(base, known, quantity=quantity, n=n, seed=seed, progress=progress)
    if output is not None:
        _write(Path(output), found, force=force)
    return found


def _check_folder(folder: Path, inputs: Sequence[Path], *, force: bool) -> None:
    from electrovib.data.atomic import check_writable

    if folder.exists() and not folder.is_dir():
        raise InputError("is a file, where the folder of a sensitivity analysis is to be made", path=folder)
    if folder.is_dir():
        check_writable({folder / name: form for name, form in FILES.items()}, inputs=inputs, force=force)


def _write(folder: Path, found: Sensitivity, *, force: bool) -> None:
    from electrovib.data.atomic import writing

    texts = {
        "report.html": _page(found),
        "indices.csv": _indices(found),
        "elasticities.csv": _elasticities(found),
        "space.toml": f"# {unsigned(Form.SPACE)}\n{found.space.to_toml()}",
    }
    folder.mkdir(parents=True, exist_ok=True)
    outputs = {folder / name: FILES[name] for name in texts}
    with writing(outputs, force=force) as temporary:
        for path, text in zip(outputs, texts.values(), strict=True):
            temporary[path].write_text(text, encoding="utf-8")


def _page(found: Sensitivity) -> str:
    from electrovib.study.reproduction import Page
    from electrovib.view import summary
    from electrovib.view.pages import markup, page
    from electrovib.view.plots.indices import indices, size_of
    from electrovib.view.report_figures import PageFigure
    from electrovib.view.style import new_figure, style
    from electrovib.view.svg import inline, to_svg

    figure = new_figure(size_of(found))
    with style():
        indices(found, ax=figure.add_subplot()).set_title("", loc="left")  # on the page it is a heading
    title = "Share of each input in the variance"
    svg = markup(inline(to_svg(figure), name="indices", words=title))
    remarks = [Page("The population", tuple(found.space.remarks))] if found.space.remarks else []
    return page(
        "comparison.html.jinja",
        judged={"": found.diagnostics},
        title=f"Sensitivity of {found.quantity}: {found.scenario.title or 'a scenario'}",
        answer=found.answer,
        figures=[PageFigure(title=title, svg=svg, caption="The largest total index on top.")],
        tables=found.tables,
        pages=remarks,
        references=REFERENCES,
        versions=summary.versions(),
    )


def _indices(found: Sensitivity) -> str:
    names = ("input", "parameters", "first", "first_low", "first_high", "total", "total_low", "total_high")
    rows = [
        (each.name, " ".join(each.paths), each.first, *each.first_interval, each.total, *each.total_interval)
        for each in found.indices
    ]
    return _as_csv(found, names, rows)


def _elasticities(found: Sensitivity) -> str:
    rows = [(each.path, each.unit, each.at, each.value) for each in found.elasticities]
    return _as_csv(found, ("parameter", "unit", "at", "elasticity"), rows)


def _as_csv(found: Sensitivity, names: tuple[str, ...], rows: Sequence[tuple[object, ...]]) -> str:
    text = io.StringIO()
    text.write(f"# {unsigned(Form.TABLE)}\n{comment_lines(found.diagnostics)}")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(names)
    for row in rows:
        writer.writerow([repr(cell) if isinstance(cell, float) else cell for cell in row])
    return text.getvalue()
