"""Correlations of parameters by a Gaussian copula."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.errors import InputError
from electrovib.scenario.space.connected import connected

if TYPE_CHECKING:
    from collections.abc import Mapping

_ROUNDING: Final = 1e-12
"""How far below 0 rounding can bring a pivot of a matrix that is positive semidefinite."""
_SMALLEST: Final = 2.0**-53
"""Distance of a share from 0 and 1 at least."""
_TRIALS: Final = np.linspace(-1, 1, 201)
"""Coefficients that are tried in place of one that contradicts the others."""


class Copula:
    """Gaussian copula: normal variables with given correlations make the shares of the parameters dependent.

    `correlations` maps a pair of parameters to the correlation coefficient r of their normal variables; other
    pairs have 0. Where no normal variables have these correlations, the pair whose coefficient has to change
    least is named. The rank correlation is 6/pi asin(r/2) for any distributions. Sums are written out,
    because a product of matrices may round differently for another number of draws.
    """

    def __init__(self, paths: tuple[str, ...], correlations: Mapping[tuple[str, str], float]) -> None:
        self.sets = tuple(
            each
            for each in connected(paths, correlations)
            if any(set(pair) <= set(each) for pair in correlations)
        )
        self._factors = [_factor(each, _matrix(each, correlations)) for each in self.sets]

    def applied(self, shares: Mapping[str, Real]) -> dict[str, Real]:
        """Return dependent shares made of independent ones; each alone is as uniform as before."""
        found = dict(shares)
        for paths, factor in zip(self.sets, self._factors, strict=True):
            if paths[0] in shares:
                found |= _coupled(paths, factor, shares)
        return found


def _coupled(
    paths: tuple[str, ...], factor: list[list[float]], shares: Mapping[str, Real]
) -> dict[str, Real]:
    from scipy.special import ndtr, ndtri

    normal = [np.asarray(ndtri(shares[path])) for path in paths]
    found = {}
    for path, row in zip(paths[1:], factor[1:], strict=True):
        total = np.zeros_like(normal[0])
        for weight, each in zip(row, normal, strict=True):
            if weight:
                total = total + weight * each
        found[path] = np.asarray(np.clip(ndtr(total), _SMALLEST, 1 - _SMALLEST))
    return found


def _matrix(paths: tuple[str, ...], correlations: Mapping[tuple[str, str], float]) -> list[list[float]]:
    matrix = [[float(row == column) for column in range(len(paths))] for row in range(len(paths))]
    for (first, second), value in correlations.items():
        if first in paths:
            row, column = paths.index(first), paths.index(second)
            matrix[row][column] = matrix[column][row] = value
    return matrix


def _factor(paths: tuple[str, ...], matrix: list[list[float]]) -> list[list[float]]:
    """Factorise by Cholesky in floats of Python, which round alike on every machine; a pivot may be 0."""
    size = len(matrix)
    found = [[0.0] * size for _ in range(size)]
    for column in range(size):
        pivot = matrix[column][column] - sum(each * each for each in found[column][:column])
        if pivot < -_ROUNDING:
            raise InputError(_contradiction(paths, matrix))
        found[column][column] = math.sqrt(pivot) if pivot > _ROUNDING else 0.0
        for row in range(column + 1, size):
            inner = sum(a * b for a, b in zip(found[row][:column], found[column][:column], strict=True))
            rest = matrix[row][column] - inner
            if found[column][column]:
                found[row][column] = rest / found[column][column]
            elif abs(rest) > math.sqrt(_ROUNDING):
                raise InputError(_contradiction(paths, matrix))
    return found


def _contradiction(paths: tuple[str, ...], matrix: list[list[float]]) -> str:
    """Write the smallest change of one coefficient that makes the correlations possible, or of all where none does."""
    given = np.array(matrix)
    lowest = float(np.linalg.eigvalsh(given)[0])
    start = (
        f"correlation: no quantities have these correlations with each other (smallest eigenvalue {lowest:.2g}, 0 or more"
        " is needed). "
    )
    changes = []
    for row, column in zip(*np.nonzero(np.triu(given, 1)), strict=True):
        trials = np.repeat(given[None], len(_TRIALS), axis=0)
        trials[:, row, column] = trials[:, column, row] = _TRIALS
        possible = _TRIALS[np.linalg.eigvalsh(trials)[:, 0] >= -_ROUNDING]
        if len(possible):
            best = possible[np.argmin(np.abs(possible - given[row, column]))]
            changes.append((abs(best - given[row, column]), best, row, column))
    if changes:
        _, best, row, column = min(changes)
        return (
            f"{start}The smallest change that is enough: '{paths[row]} ~ {paths[column]}' = {best:.2f} in place of"
            f" {given[row, column]:g}"
        )
    factors = np.linspace(0, 1, 1001)
    scaled = np.eye(len(given)) + factors[:, None, None] * (given - np.eye(len(given)))
    largest = factors[np.linalg.eigvalsh(scaled)[:, 0] >= -_ROUNDING].max()
    return f"{start}No change of a single coefficient is enough; all of them times {np.floor(100 * largest) / 100:g} are possible"
