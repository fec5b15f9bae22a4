"""The separation of the unknowns in which all predictions are linear from the search for the others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import ElectrovibError

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.recordings.fit.least_squares import FreeParameter
    from electrovib.recordings.fit.problem import WeightedProblem


class OutsideBoundsError(ElectrovibError):
    """A linear unknown whose best value is not between its bounds."""


class Separated:
    """A weighted problem as a function of the unknowns that are not linear in it, with the best values of the others.

    `fixed` values are in SI. Linear unknowns are kept `within_bounds`; else a best value outside them is an
    error. For given values of the other unknowns the best values of the linear ones solve a linear
    least-squares problem with the columns G. The derivatives of the remaining residual are those of the
    predictions at these values, less their projection on G (Golub and Pereyra 1973, in the form of Kaufman
    1975); columns of unknowns on a bound are omitted from G. The minimum is that of all unknowns together.
    """

    def __init__(
        self,
        problem: WeightedProblem,
        free: Mapping[str, FreeParameter],
        fixed: Mapping[str, float],
        *,
        within_bounds: bool = False,
    ) -> None:
        self._problem, self._fixed, self._within_bounds = problem, dict(fixed), within_bounds
        prediction = problem.prediction
        by_name = {each.name: each for each in prediction.unknowns}
        rows = {name: prediction.linear_rows(by_name[name]) for name in free}
        found = {name: row for name, row in rows.items() if row is not None}
        self._factors = {name: row for name, row in found.items() if not by_name[name].is_offset}
        overlapping = sum(
            (row.astype(int) for row in self._factors.values()), np.zeros(problem.data.size, int)
        )
        if np.any(overlapping > 1) or any(free[name].start <= 0 for name in self._factors):
            found = {name: row for name, row in found.items() if name not in self._factors}
            self._factors = {}
        self._rows = found
        self.linear: tuple[str, ...] = tuple(found)
        self.others = {name: each for name, each in free.items() if name not in found}
        self._free = dict(free)
        self._reference = {name: free[name].start if name in self._factors else 0.0 for name in self.linear}

    @property
    def is_useful(self) -> bool:
        """Whether there are linear unknowns and others beside them."""
        return bool(self.linear) and bool(self.others)

    def best(self, values: Mapping[str, float]) -> tuple[dict[str, float], Real, Real]:
        """Return the best values of the linear unknowns, orthonormal columns of those inside their bounds, and the residual.

        The columns, shape (n, inside), span the weighted derivatives; the residual is NaN where the models
        refuse the values.
        """
        problem = self._problem
        left = problem.residual(self._fixed | dict(values) | self._reference)
        if not self.linear:
            return {}, np.zeros((left.size, 0)), left
        whole = left + problem.data * problem.weights
        columns = np.stack([self._column(name, whole) for name in self.linear], axis=1)
        rest = whole.copy()
        for rows in self._factors.values():
            rest[rows] = 0.0
        wanted = problem.data * problem.weights - rest
        if not np.isfinite(whole).all():
            return dict(self._reference), columns, np.full(whole.shape, np.nan)
        orthonormal, triangle = np.linalg.qr(columns)
        share = orthonormal.T @ wanted
        found = np.linalg.solve(triangle, share)
        linear = dict(zip(self.linear, found.tolist(), strict=True))
        for name, value in linear.items():
            if not self._free[name].lower < value < self._free[name].upper:
                if self._within_bounds:
                    return self._best_within_bounds(columns, wanted)
                raise OutsideBoundsError(f"{name} = {value:g} is outside its bounds")
        return linear, orthonormal, orthonormal @ share - wanted

    def _best_within_bounds(self, columns: Real, wanted: Real) -> tuple[dict[str, float], Real, Real]:
        """Compute the same for unknowns of which at least one is on a bound."""
        from scipy.optimize import lsq_linear

        size = np.linalg.norm(columns, axis=0)
        ends = np.array([(self._free[name].lower, self._free[name].upper) for name in self.linear])
        solved = lsq_linear(columns / size, wanted, bounds=(ends * size[:, None]).T, method="bvls")
        orthonormal = np.linalg.qr(columns[:, solved.active_mask == 0])[0]
        linear = dict(zip(self.linear, (solved.x / size).tolist(), strict=True))
        return linear, orthonormal, columns @ (solved.x / size) - wanted

    def _column(self, name: str, whole: Real) -> Real:
        rows = self._rows[name]
        column = np.zeros(whole.size)
        column[rows] = (
            whole[rows] / self._reference[name] if name in self._factors else self._problem.weights[rows]
        )
        return column

    def residual(self, values: Mapping[str, float]) -> Real:
        """Return the weighted residual with the best linear unknowns, shape (n,), dimensionless."""
        return self.best(values)[2]

    def derivatives(self, values: Mapping[str, float]) -> Real:
        """Return its derivatives after the other unknowns, shape (n, others), in 1 over the unit of each."""
        linear, orthonormal, _ = self.best(values)
        names: Sequence[str] = tuple(self.others)
        slopes = self._problem.derivatives(self._fixed | dict(values) | self._reference, names=names)
        for name, rows in self._factors.items():
            slopes[rows] *= linear[name] / self._reference[name]
        return np.asarray(slopes - orthonormal @ (orthonormal.T @ slopes))
