"""Plots of other force laws on the same finger and plate."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final

from electrovib.apps.explorer.pictures.axis import Axis
from electrovib.apps.explorer.pictures.figure import PlottedCurve, figure
from electrovib.apps.explorer.pictures.over_frequency import FREQUENCY
from electrovib.apps.explorer.pictures.over_time import TIME
from electrovib.view.style import COLOURS, FURTHER_COLOURS

if TYPE_CHECKING:
    from electrovib.apps.explorer.computed import Computed

_COLOURS: Final = (*COLOURS, *FURTHER_COLOURS)


def laws(shown: Computed, others: Mapping[str, Computed]) -> list[dict[str, Any]]:
    """Plot the force of each law over time and over frequency; the law of the page has a solid line."""
    cases = {type(shown.scenario.force).__name__: shown, **others}
    plots = []
    for title, signal, coordinate, x in (
        ("Electrostatic force of each law", "electrostatic_force", "time", TIME),
        ("Mean force of each law under a sine", "mean_force", "frequency", FREQUENCY),
    ):
        curves = [
            PlottedCurve(
                case.values(coordinate),
                case.values(signal),
                name,
                _COLOURS[index % len(_COLOURS)],
                "dash" if index else "solid",
            )
            for index, (name, case) in enumerate(cases.items())
            if case.has(signal)
        ]
        if curves:
            plots.append(
                figure(title, x, Axis("force", "N", is_logarithmic=coordinate == "frequency"), curves)
            )
    return plots
