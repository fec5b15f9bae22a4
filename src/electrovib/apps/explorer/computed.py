"""What is computed for a page when a parameter changes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.apps.explorer.limits import LARGEST_RUN, LONGEST_RUN
from electrovib.core.budget import budget
from electrovib.core.diagnostics import Diagnostic, read_diagnostics
from electrovib.solve.simulate import simulate

if TYPE_CHECKING:
    import xarray
    from numpy.typing import NDArray

    from electrovib.scenario import Scenario


@dataclass(frozen=True)
class Computed:
    """A scenario with its Trace.

    Parameters
    ----------
    scenario : Scenario
        As the page shows it.
    trace : xarray.Dataset
        What `electrovib.simulate` returns for it.
    """

    scenario: Scenario
    trace: xarray.Dataset

    @property
    def diagnostics(self) -> list[Diagnostic]:
        """Statements on the validity of the Trace."""
        return read_diagnostics(self.trace.attrs["validity"])

    def has(self, name: str) -> bool:
        """Return whether the Trace has a signal."""
        return name in self.trace.variables

    def values(self, name: str, *, layer: str = "") -> NDArray[Any]:
        """Return the array of a signal.

        Parameters
        ----------
        name : str
            A signal of the Trace, or one of its coordinates.
        layer : str
            Name of a layer, for a signal that has one row for each; empty for all rows.

        Returns
        -------
        values : ndarray
            In SI, without a copy.

        Notes
        -----
        ``trace[name]`` makes a DataArray with its coordinates, which takes longer than to draw a curve.
        """
        variable = self.trace.variables[name]
        if not layer:
            return np.asarray(variable.values)
        row = list(self.trace.variables["layer"].values).index(layer)
        rows: NDArray[Any] = np.moveaxis(np.asarray(variable.values), variable.dims.index("layer"), 0)
        return np.asarray(rows[row])


def compute(scenario: Scenario, *, longest: float = LONGEST_RUN) -> Computed:
    """Simulate a scenario within the time and memory that a page allows.

    Parameters
    ----------
    scenario : Scenario
        Experiment.
    longest : float
        Estimated time above which the run is refused [s].

    Returns
    -------
    Computed
        Scenario and Trace.

    Raises
    ------
    InputError
        If models cannot be combined.
    BudgetError
        If the run would take more time or memory than a page allows.
    """
    with budget(time=longest, memory=LARGEST_RUN):
        return Computed(scenario, simulate(scenario))
