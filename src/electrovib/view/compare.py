"""A comparison of force laws as a page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from electrovib.scenario import Source
    from electrovib.study.compare import Comparison
    from electrovib.study.reproduction import Panel
    from electrovib.view.documents import Document


def compare(
    scenario: Source,
    *,
    set: Mapping[str, Any] | None = None,  # noqa: A002 - the name of the option
    models: Sequence[str] | None = None,
    over: Sequence[str] | Mapping[str, Sequence[float]] = (),
    output: str | Path | None = None,
    force: bool = False,
) -> Comparison:
    """Run every force law on the same finger and plate, and explain why they differ.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        As for `electrovib.load`.
    set : mapping of str to value, optional
        Dotted path to value, put into the scenario: ``{"stack.gap": {"thickness": "5 um"}}``.
    models : sequence of str, optional
        Names of laws; all that need no parameter of their own if absent.
    over : sequence of str, or mapping of str to sequence of float
        ``"path=from:to:n"`` or ``"path=from:to:nlog"``: a figure of the static force over this parameter.
    output : str or Path, optional
        An HTML file with the law to believe, figures, tables and explanations.
    force : bool
        Whether a file that we did not write may be replaced.

    Returns
    -------
    Comparison
        Numbers, figures as data, and explanations.

    Raises
    ------
    InputError
        For a scenario, a law or a range that is not valid; nothing has been written then.
    """
    from electrovib.core.errors import InputError, gathered
    from electrovib.core.files import inputs_noted
    from electrovib.data.atomic import write_text
    from electrovib.data.marks import Form
    from electrovib.scenario import read_scenario
    from electrovib.study.compare import compare as run_all
    from electrovib.study.sweep import parse_over
    from electrovib.view.documents import html
    from electrovib.view.pages import check_page

    problems: list[str] = []
    with inputs_noted() as inputs, gathered(problems):
        experiment = read_scenario(scenario, changes=set)
        axes = over if isinstance(over, Mapping) else parse_over(experiment, over)
    if output is not None:
        with gathered(problems):
            check_page(Path(output), inputs=inputs, force=force)
    if problems:
        raise InputError(problems)
    found = run_all(experiment, models=models, over=axes)
    if output is not None:
        write_text(Path(output), html(_document(found)), Form.PAGE, force=force)
    return found


def _document(found: Comparison) -> Document:
    from electrovib.core.discovery import find_members, paper_of, papers
    from electrovib.physics.force import ForceLaw
    from electrovib.view.documents import Document
    from electrovib.view.few_curves import few_curves

    own = {paper_of(find_members(ForceLaw)[entry.name]) for entry in found.entries}
    return Document(
        title=f"Force laws compared: {found.scenario.title or 'a stack'}",
        answer=found.answer,
        diagnostics=found.diagnostics,
        figures=[part for panel in _answering_first(found) for part in few_curves(panel)],
        tables=found.tables,
        pages=found.pages,
        references=[
            module.CITATION for name, module in papers().items() if name in own or hasattr(module, "DEFECTS")
        ],
    )


def _answering_first(found: Comparison) -> list[Panel]:
    """Order the figures: those over what was asked for first, then the one that belongs to the drive."""
    from electrovib.scenario import PeriodicState

    standard = ("force_over_frequency", "force_over_time")
    if not isinstance(found.scenario.time.initial_state, PeriodicState):
        standard = standard[::-1]
    asked = [panel for panel in found.panels if panel.id not in standard]
    return [
        *asked,
        *sorted((p for p in found.panels if p.id in standard), key=lambda p: standard.index(p.id)),
    ]
