"""Quantities of a scenario as a function of a few of its parameters, for many points on one mesh of polynomials."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.budget import BudgetError
from electrovib.core.errors import ElectrovibError, gathered
from electrovib.scenario import Source, read_scenario
from electrovib.solve.expanded import OF_ELECTRICS, Expanded
from electrovib.solve.one_by_one import ParametricScenario
from electrovib.solve.population.fingers import GRIDS, TOGETHER
from electrovib.solve.quantities.answer import answer, numbers, validity
from electrovib.solve.quantities.cases import FEWEST_POINTS, on_meshes, population_on
from electrovib.solve.quantities.names import DEFAULTS, read_name
from electrovib.solve.quantities.resolve import first_mesh, solved

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from numpy.typing import ArrayLike

    from electrovib.core.arrays import Real
    from electrovib.core.diagnostics import Diagnostic
    from electrovib.scenario import Scenario
    from electrovib.solve.quantities.answer import QuantityNumbers
    from electrovib.solve.quantities.names import Named


def prepare(
    scenario: Source,
    *,
    free: Sequence[str],
    quantity: Sequence[str] = DEFAULTS,
) -> Prepared:
    """Prepare a scenario for repeated evaluation with other values of a few parameters.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        Experiment with the values that stay fixed, as for `electrovib.load`.
    free : sequence of str
        Dotted paths of the parameters that vary, for instance ``["stack.gap.thickness", "friction.coefficient"]``.
    quantity : sequence of str
        Quantities to return, as ``electrovib run --quantity`` names them: ``"mean electrostatic_force"``.

    Returns
    -------
    Prepared
        A function of these parameters.

    Raises
    ------
    InputError
        If a path or a quantity does not exist; names all of them, each with the nearest name.
    """
    return Prepared(read_scenario(scenario), free=free, quantity=quantity)


class Prepared(ParametricScenario):
    """A scenario as a function of some of its parameters.

    Parameters
    ----------
    scenario : Scenario
        Experiment with the values that stay fixed.
    free : sequence of str
        Dotted paths of physical parameters, in the order of the values given as a sequence.
    quantity : sequence of str
        Names of the quantities to return.

    Raises
    ------
    InputError
        If a path or a quantity does not exist; names all of them, each with the nearest name.

    Notes
    -----
    One point after the other, parts of the scenario without a changed value stay the same objects, and results that depend
    on them alone are kept: the pieces of the drive, the modes of the stack unless a layer, the circuit or the contact area
    changes, and the attraction unless one of these, the drive, the law, the load or the motion changes. No electrical
    quantity is recomputed where only friction, fingertip or rig vary. The values are those of `electrovib.sweep`.

    Where arrays exist for all quantities (`method` tells), 32 points or more are evaluated on one mesh of Chebyshev
    polynomials, which is refined until it resolves some of the points to the tolerance of a single run; points that it does
    not resolve get a finer mesh, and the last ones are solved one by one. Both agree to 1e-9 of the largest value of the
    signal. The mesh follows from all points of a call; given the mesh, the number of a point does not depend on the others.

    The values are not judged as they are computed: `diagnostics` judges the last scenario that was made, and `judged` any.
    """

    def __init__(
        self, scenario: Scenario, *, free: Sequence[str], quantity: Sequence[str] = DEFAULTS
    ) -> None:
        problems: list[str] = []
        layers = tuple(scenario.stack.layers)
        self._names: list[Named] = []
        for text in quantity:
            with gathered(problems):
                self._names.append(read_name(" ".join(text.split()), layers))
        super().__init__(scenario, free, problems)
        self._last: Expanded | None = None

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """Diagnostics of the scenario with the values for which it was made last, at first with its own."""
        return validity(self._recent)

    @property
    def quantities(self) -> tuple[str, ...]:
        """Names of the quantities that a call returns."""
        return tuple(each.name for each in self._names)

    @functools.cached_property
    def method(self) -> str:
        """How the quantities of many points are computed, together or one by one, and why."""
        if any(path.partition(".")[0] in GRIDS for path in self.free):
            return "one by one: the grid differs between points"
        try:
            many = population_on(self, self._names, first_mesh(solved(self.base)))
        except ElectrovibError as error:
            return f"one by one: {error.problems[0]}"
        return (
            many.method if many.shares_times else "one by one: the times of the drive differ between points"
        )

    def __call__(
        self,
        values: Mapping[str, ArrayLike] | ArrayLike,
        *,
        progress: Callable[[int, int], None] | None = None,
    ) -> dict[str, Any]:
        """Compute the quantities for one set of values of the free parameters, or for many."""
        given = self.by_path(values)
        columns = np.broadcast_arrays(*[np.asarray(each, dtype=float) for each in given.values()])
        if not columns or columns[0].ndim == 0:
            point = {path: float(each) for path, each in zip(given, columns, strict=True)}
            return dict(self._numbers(point))
        draws = {path: column.ravel() for path, column in zip(given, columns, strict=True)}
        found = self._of_points(draws, columns[0].size, progress)
        return {name: found[name].reshape(columns[0].shape) for name in self.quantities}

    def judged(self, values: Mapping[str, float] | Sequence[float]) -> QuantityNumbers:
        """Compute the quantities for given values of the free parameters, with their diagnostics."""
        return answer(solved(self.scenario(values)), self._names)

    def _numbers(self, point: Mapping[str, float]) -> dict[str, float]:
        """Return the quantities of one point."""
        mechanics = not {each.signal for each in self._names} <= OF_ELECTRICS
        self._last = solved(self.scenario(point), before=self._last, mechanics=mechanics)
        return numbers(self._last, self._names, alone=True)[0]

    def _of_points(
        self, draws: Mapping[str, Real], count: int, progress: Callable[[int, int], None] | None
    ) -> dict[str, Real]:
        """Return the quantities of many points, each of shape (points,)."""
        found, left = {name: np.full(count, np.nan) for name in self.quantities}, np.arange(count)
        report = progress or (lambda _done, _count: None)
        if count >= FEWEST_POINTS and self.method == TOGETHER:
            try:
                left = on_meshes(self, self._names, draws, found, report)
                if len(left) == count:
                    self.method = "one by one: no mesh resolved the points of a call"
            except BudgetError:
                raise
            except ElectrovibError:  # one by one, a point raises its own error
                pass
        for place, point in enumerate(left.tolist()):
            report(count - len(left) + place, count)
            for name, value in self._numbers(_point(draws, point)).items():
                found[name][point] = value
        if count:
            self.scenario(_point(draws, -1))
        return found


def _point(draws: Mapping[str, Real], point: int) -> dict[str, float]:
    """Return the values of one point [SI units]."""
    return {path: float(values[point]) for path, values in draws.items()}
