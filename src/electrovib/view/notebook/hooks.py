"""Display functions, registered with IPython by the names of types, so that nothing is imported before it is shown."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Callable

    import xarray
    from matplotlib.axes import Axes

    from electrovib.scenario import Scenario
    from electrovib.study.compare.materials import MaterialComparison
    from electrovib.study.design.parameter.result import DesignedParameter
    from electrovib.study.percept import Percept
    from electrovib.study.reproduction import Table

_SCENARIO: Final = ("electrovib.scenario.experiment", "Scenario")
_DATASET: Final = ("xarray.core.dataset", "Dataset")
_TABLE: Final = ("electrovib.study.reproduction", "Table")
_MATERIALS: Final = ("electrovib.study.compare.materials", "MaterialComparison")
_DESIGNED: Final = ("electrovib.study.design.parameter.result", "DesignedParameter")
_PERCEPT: Final = ("electrovib.study.percept", "Percept")
_AXES: Final = ("matplotlib.axes._axes", "Axes")


def register() -> bool:
    """Register the display of this package with the IPython that runs.

    Returns
    -------
    bool
        False where no IPython runs; nothing has changed then.
    """
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
        ("text/html", _MATERIALS, _materials),
        ("text/plain", _MATERIALS, _materials_as_text),
        ("text/html", _DESIGNED, _designed),
        ("text/plain", _PERCEPT, _percept_as_text),
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


def _materials(comparison: MaterialComparison) -> str:
    return "".join(map(_table, comparison.tables))


def _materials_as_text(comparison: MaterialComparison, printer: Any, cycle: bool) -> None:
    for table in comparison.tables:
        _table_as_text(table, printer, cycle)
        printer.text("\n")


def _designed(found: DesignedParameter) -> str:
    """Show the answer, the tables, and the other sentences."""
    from html import escape

    answer, *others = [f"<p>{escape(line)}</p>" for line in found.lines]
    return "".join([answer, *map(_table, found.tables), *others])


def _percept_as_text(percept: Percept, printer: Any, cycle: bool) -> None:
    from electrovib.view.percept import percept_lines

    del cycle
    printer.text("\n".join(percept_lines(percept)))


def _picture(axes: Axes) -> tuple[bytes, dict[str, int]] | None:
    """Draw the figure that holds these Axes, unless pyplot shows it by itself."""
    from electrovib.view.notebook.picture import picture

    return picture(axes)
