"""A sensitivity analysis as a folder: a page with figure and tables, and the indices as CSV."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final

from electrovib.core.errors import InputError, gathered
from electrovib.core.files import inputs_noted
from electrovib.data.atomic import check_folder, write_folder
from electrovib.data.csv_text import csv_text
from electrovib.data.marks import Form, unsigned
from electrovib.study.reproduction import Page
from electrovib.view.documents import Document, Drawing, html

if TYPE_CHECKING:
    from collections.abc import Callable

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
            check_folder(Path(output), FILES, inputs=inputs, force=force)
    if problems or base is None or known is None:
        raise InputError(problems)
    found = analyse(base, known, quantity=quantity, n=n, seed=seed, progress=progress)
    if output is not None:
        write_folder(Path(output), _contents(found), FILES, force=force)
    return found


def _contents(found: Sensitivity) -> dict[str, str]:
    return {
        "report.html": html(_document(found)),
        "indices.csv": csv_text(*_indices(found), diagnostics=found.diagnostics),
        "elasticities.csv": csv_text(*_elasticities(found), diagnostics=found.diagnostics),
        "space.toml": f"# {unsigned(Form.SPACE)}\n{found.space.to_toml()}",
    }


def _document(found: Sensitivity) -> Document:
    from electrovib.view.plots.indices import indices, size_of

    figure = Drawing(
        id="indices",
        title="Share of each input in the variance",
        caption="The largest total index on top.",
        draw=lambda axes: indices(found, ax=axes),
        size=size_of(found),
    )
    return Document(
        title=f"Sensitivity of {found.quantity}: {found.scenario.title or 'a scenario'}",
        answer=found.answer,
        diagnostics=found.diagnostics,
        figures=[figure],
        tables=found.tables,
        pages=[Page("The population", tuple(found.space.remarks))] if found.space.remarks else [],
        references=REFERENCES,
    )


def _indices(found: Sensitivity) -> tuple[tuple[str, ...], list[tuple[object, ...]]]:
    names = ("input", "parameters", "first", "first_low", "first_high", "total", "total_low", "total_high")
    rows: list[tuple[object, ...]] = [
        (each.name, " ".join(each.paths), each.first, *each.first_interval, each.total, *each.total_interval)
        for each in found.indices
    ]
    return names, rows


def _elasticities(found: Sensitivity) -> tuple[tuple[str, ...], list[tuple[object, ...]]]:
    rows: list[tuple[object, ...]] = [
        (each.path, each.unit, each.at, each.value) for each in found.elasticities
    ]
    return ("parameter", "unit", "at", "elasticity"), rows
