"""A comparison of force laws as a page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from electrovib.scenario import Source
    from electrovib.study.compare import Comparison


def compare(
    scenario: Source,
    *,
    set: Mapping[str, Any] | None = None,  # noqa: A002 - the name of the option
    models: Sequence[str] | None = None,
    over: Sequence[str] | Mapping[str, Sequence[float]] = (),
    output: str | Path | None = None,
    force: bool = False,
) -> Comparison:
    """Run every force law on the same finger and plate, and say why they differ.

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
        An HTML file with tables, figures and explanations.
    force : bool
        Whether a file that we did not write may be replaced.

    Returns
    -------
    Comparison
        Numbers, figures as data, and words.

    Raises
    ------
    InputError
        For a scenario, a law or a range that does not fit; nothing has been written then.
    """
    from electrovib.core.errors import InputError, gathered
    from electrovib.core.files import inputs_noted
    from electrovib.scenario import read_scenario
    from electrovib.study.compare import compare as run_all
    from electrovib.study.sweep import parse_over
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
        _write(found, Path(output), force=force)
    return found


def _write(found: Comparison, path: Path, *, force: bool) -> None:
    from electrovib.core.discovery import find_members, paper_of, papers
    from electrovib.data.atomic import write_text
    from electrovib.data.marks import Form
    from electrovib.physics.force import ForceLaw
    from electrovib.study.reproduction import Reproduction
    from electrovib.view.reproduce import _drawn as drawn
    from electrovib.view.reproduce import page_of
    from electrovib.view.svg import to_svg

    drawings = {}
    for panel in found.panels:
        figure = drawn(panel)
        figure.axes[0].set_title("", loc="left")  # on the page it is a heading
        drawings[panel.id] = to_svg(figure)
    told = {paper_of(find_members(ForceLaw)[entry.name]) for entry in found.entries}
    cited = tuple(
        module.CITATION for name, module in papers().items() if name in told or hasattr(module, "DEFECTS")
    )
    title = found.scenario.title or "a stack"
    content = Reproduction(
        paper="comparison",
        citation="",
        rows=(),
        panels=found.panels,
        pages=found.pages,
        tables=found.tables,
        equations={},
        references=cited,
        title=f"Force laws compared: {title}",
    )
    write_text(path, page_of(content, drawings), Form.PAGE, force=force)
