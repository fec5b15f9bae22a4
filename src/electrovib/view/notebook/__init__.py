"""Display of scenarios, Traces, sweeps, tables and plots in notebooks and IPython terminals.

Its functions are registered with IPython by the names of types, so that nothing is imported before it is shown.
"""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Callable

    import xarray
    from matplotlib.axes import Axes

    from electrovib.scenario import Scenario

_SCENARIO: Final = ("electrovib.scenario.experiment", "Scenario")
_DATASET: Final = ("xarray.core.dataset", "Dataset")
_RESOLUTION: Final = 192.0
"""Of the picture of a plot [dots per inch]: twice that at which it is shown, for screens with fine pixels."""
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
        ("image/png", _AXES, _picture),
    )
    for form, (module, name), show in known:
        formatter.formatters[form].for_type_by_name(module, name, show)
    return True


def _scenario(scenario: Scenario) -> str:
    from electrovib.view.notebook.shown import scenario_html

    return scenario_html(scenario)


def _dataset(dataset: xarray.Dataset) -> str:
    """Show a Trace; any other Dataset as it shows itself."""
    from electrovib.view.notebook.shown import is_own, trace_html

    return trace_html(dataset) if is_own(dataset) else dataset._repr_html_()


def _dataset_as_text(dataset: xarray.Dataset, printer: Any, cycle: bool) -> None:
    """Write a Trace in a few lines; any other Dataset as it writes itself."""
    from electrovib.view.notebook.shown import is_own, trace_text

    del cycle
    printer.text(trace_text(dataset) if is_own(dataset) else repr(dataset))


def _picture(axes: Axes) -> tuple[bytes, dict[str, int]] | None:
    """Draw the figure of these Axes as PNG with width and height in pixels; None for one that pyplot shows by itself."""
    from electrovib.view.pages import to_png

    figure = axes.get_figure(root=True)
    if figure is None or figure.canvas.manager is not None:
        return None
    width, height = (round(each * _RESOLUTION / 2) for each in figure.get_size_inches())
    return to_png(figure, resolution=_RESOLUTION), {"width": width, "height": height}
