"""What is computed for a page when a parameter changes."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.apps.explorer.limits import LARGEST_RUN, LONGEST_RUN
from electrovib.core.budget import budget
from electrovib.solve.expanded import Expanded
from electrovib.solve.meter import measured
from electrovib.solve.simulate import Simulated, provenance

if TYPE_CHECKING:
    import xarray
    from numpy.typing import NDArray

    from electrovib.core.diagnostics import Diagnostic
    from electrovib.scenario import Scenario


@dataclass(frozen=True, eq=False)
class Computed:
    """A scenario as the page shows it, with its signals and their validity."""

    scenario: Scenario
    found: Simulated

    @functools.cached_property
    def trace(self) -> xarray.Dataset:
        """What `electrovib.simulate` returns for the scenario; made when it is first asked for."""
        return self.found.trace(provenance(self.scenario))

    @property
    def diagnostics(self) -> list[Diagnostic]:
        """Statements on the validity."""
        return list(self.found.diagnostics)

    def has(self, name: str) -> bool:
        """Return whether there is a signal of this name."""
        return name in self.found.variables

    def dimensions(self, name: str) -> tuple[str, ...]:
        """Return the names of the dimensions of a signal."""
        return tuple(self.found.variables[name][0])

    def values(self, name: str, *, layer: str = "") -> NDArray[Any]:
        """Return the array of a signal, or of one of its dimensions, in SI, without a copy; `layer` picks one row."""
        if name in self.found.coordinates:
            return self.found.coordinates[name]
        dimensions, values = self.found.variables[name]
        if not layer:
            return np.asarray(values)
        row = list(self.found.coordinates["layer"]).index(layer)
        rows: NDArray[Any] = np.moveaxis(np.asarray(values), list(dimensions).index("layer"), 0)
        return np.asarray(rows[row])


def compute(scenario: Scenario, *, longest: float = LONGEST_RUN) -> Computed:
    """Simulate a scenario within the time and memory that a page allows; a run that takes more is refused or ended.

    `longest` is the largest computing time [s].
    """
    with budget(time=longest, memory=LARGEST_RUN), measured():
        return Computed(scenario, Simulated.of(Expanded(scenario)))
