"""Display functions, registered with IPython by the names of types, so that nothing is imported before it is shown."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from typing import TypeAlias

    import xarray
    from matplotlib.axes import Axes

    from electrovib.scenario import Scenario
    from electrovib.study.check import CheckResult
    from electrovib.study.compare.entry import Comparison
    from electrovib.study.compare.materials import MaterialComparison
    from electrovib.study.design.result import Designed
    from electrovib.study.percept import Percept
    from electrovib.study.reproduction import Table

    Parts: TypeAlias = tuple[Sequence[str], Sequence[Table]]

_SCENARIO: Final = ("electrovib.scenario.experiment", "Scenario")
_DATASET: Final = ("xarray.core.dataset", "Dataset")
_TABLE: Final = ("electrovib.study.reproduction", "Table")
_MATERIALS: Final = ("electrovib.study.compare.materials", "MaterialComparison")
_LAWS: Final = ("electrovib.study.compare.entry", "Comparison")
_CHECKED: Final = ("electrovib.study.check.result", "CheckResult")
_DESIGNED: Final = ("electrovib.study.design.result", "Designed")
_PERCEPT: Final = ("electrovib.study.percept", "Percept")
_AXES: Final = ("matplotlib.axes._axes", "Axes")


def register() -> bool:
    """Register the display of this package with the IPython that runs; False where none does."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None and hasattr(ipython, "get_ipython") else None
    formatter = getattr(shell, "display_formatter", None)
    if formatter is None:
        return False
    known: tuple[tuple[str, tuple[str, str], Callable[..., Any]], ...] = (
        ("text/html", _SCENARIO, _scenario),
        ("text/html", _DATASET, _dataset),
        ("text/plain", _DATASET, _dataset_as_text),
        ("text/html", _TABLE, _table),
        ("text/plain", _TABLE, _table_as_text),
        *(
            (form, kind, as_form(parts))
            for kind, parts in (
                (_MATERIALS, _of_materials),
                (_LAWS, _of_laws),
                (_CHECKED, _of_check),
                (_DESIGNED, _of_design),
                (_PERCEPT, _of_percept),
            )
            for form, as_form in (("text/html", _in_html), ("text/plain", _in_text))
            if (form, kind) != ("text/plain", _DESIGNED)  # whose sentences are its text
        ),
        ("image/png", _AXES, _picture),
    )
    for form, (module, name), show in known:
        formatter.formatters[form].for_type_by_name(module, name, show)
    return True


def _scenario(scenario: Scenario) -> str:
    from electrovib.view.notebook.scenario import scenario_html

    return scenario_html(scenario)


def _dataset(dataset: xarray.Dataset) -> str:
    """Show a Trace; any other Dataset as xarray does."""
    from electrovib.view.notebook.trace import is_own, trace_html

    return trace_html(dataset) if is_own(dataset) else dataset._repr_html_()


def _dataset_as_text(dataset: xarray.Dataset, printer: Any, cycle: bool) -> None:
    """Write a Trace in a few lines; any other Dataset as xarray does."""
    from electrovib.view.notebook.trace import is_own, trace_text

    del cycle
    printer.text(trace_text(dataset) if is_own(dataset) else repr(dataset))


def _table(table: Table) -> str:
    from electrovib.study.catalogue.columns import as_html

    return as_html(table)


def _table_as_text(table: Table, printer: Any, cycle: bool) -> None:
    from electrovib.study.catalogue.columns import laid_out

    del cycle
    printer.text(laid_out(table).rstrip())


def _of_materials(found: MaterialComparison) -> Parts:
    return [], found.tables


def _of_laws(found: Comparison) -> Parts:
    return [found.answer], found.tables


def _of_check(found: CheckResult) -> Parts:
    from electrovib.view.checked import check_lines, tables_of

    return check_lines(found), tables_of(found)[:1]


def _of_design(found: Designed) -> Parts:
    return found.lines, found.tables


def _of_percept(found: Percept) -> Parts:
    from electrovib.view.percept import percept_lines

    return percept_lines(found), []


def _in_html(parts: Callable[[Any], Parts]) -> Callable[[Any], str]:
    """Return a function that shows a result: its answer, its tables, then its other sentences."""

    def show(found: Any) -> str:
        from html import escape

        lines, tables = parts(found)
        paragraphs = [f"<p>{escape(line)}</p>" for line in lines]
        return "".join([*paragraphs[:1], *map(_table, tables), *paragraphs[1:]])

    return show


def _in_text(parts: Callable[[Any], Parts]) -> Callable[[Any, Any, bool], None]:
    """Return a function that writes a result: its sentences, then its tables."""

    def show(found: Any, printer: Any, cycle: bool) -> None:
        lines, tables = parts(found)
        printer.text("\n".join(lines))
        for table in tables:
            printer.text("\n")
            _table_as_text(table, printer, cycle)

    return show


def _picture(axes: Axes) -> tuple[bytes, dict[str, int]] | None:
    """Draw the figure that holds these Axes, unless pyplot shows it by itself."""
    from electrovib.view.notebook.picture import picture

    return picture(axes)
