"""Predictions without physics, which a law has to exceed: what other groups measured, whatever the set-up is."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.errors import ElectrovibError
from electrovib.studies.evidence.measurement import divisor
from electrovib.studies.evidence.predicted import ModelPrediction
from electrovib.studies.evidence.score import DECADE, LEVEL

if TYPE_CHECKING:
    from electrovib.studies.evidence.measurement import Measurement

CONSTANT, SQUARE, RANGE = "a constant", "a constant times V^2", "log-uniform"
NULLS: Final = {
    CONSTANT: "geometric mean and deviation of what other groups measured of this quantity, each group counting once; of a"
    " force, over its area, whatever the voltage; log-uniform where there is no other group; of one quantity under two conditions"
    " that both are alike",
    SQUARE: "the same of a force over its area and the square of the largest voltage; of other quantities as the constant",
    RANGE: "log-uniform over all that was ever measured of this quantity, at least a decade",
}
"""Null models, with what they predict."""
_STRESS: Final = "force over area"


@dataclass(frozen=True)
class _Known:
    """A measurement: logarithms of its values over `unit`, and of the squares of its voltages, where it has any.

    Of a quotient of one quantity under two conditions (`quotient`) the squares are those of one over the other.
    """

    quantity: object
    group: str
    logs: Real
    unit: float
    squares: Real | None
    quotient: bool = False


def null_predictions(
    measured: Mapping[str, Measurement], known: Mapping[str, Measurement], *, n: int
) -> Iterator[tuple[str, ModelPrediction]]:
    """Predict each measurement by every null model, from it and the known ones; no constant is taken from the own group."""
    found = {id(each): _known(each) for each in (*known.values(), *measured.values())}
    for name, each in measured.items():
        for null, logs in _logs(found[id(each)], list(found.values()), n).items():
            values = found[id(each)].unit * np.exp(np.broadcast_to(logs, (n, len(each.values))))
            yield name, ModelPrediction(null, values, values, values)


def _logs(own: _Known, known: Sequence[_Known], n: int) -> dict[str, Real]:
    """Return evenly spaced quantiles of the logarithm at each point, (n, points) or (n, 1), by null model."""
    alike = [each for each in known if each.quantity == own.quantity]
    others = [(each.group, each.logs) for each in alike if each.group != own.group]
    within = _over_range(np.concatenate([each.logs for each in alike]), n)
    if own.quotient:  # what is constant, or constant over the square of the voltage, leaves nothing open
        constant = np.zeros((n, 1))
        square = constant if own.squares is None else constant + own.squares
        return {CONSTANT: constant, SQUARE: square, RANGE: within}
    constant = _around(others, n) if others else within
    squared = [
        (each.group, each.logs - each.squares)
        for each in alike
        if each.group != own.group and each.squares is not None
    ]
    square = constant if own.squares is None or not squared else _around(squared, n) + own.squares
    return {CONSTANT: constant, SQUARE: square, RANGE: within}


def _known(measured: Measurement) -> _Known:
    logs = np.log(np.array(measured.values))
    if measured.per_changes:
        squares, under = _squares(measured, {}), _squares(measured, measured.per_changes)
        squares = None if squares is None or under is None else squares - under
        alike = (measured.quantity, divisor(measured), *measured.per_changes)
        return _Known(alike, measured.group, logs, 1.0, squares, quotient=True)
    if measured.unit not in {"N", "Pa"}:
        return _Known((measured.quantity, measured.per), measured.group, logs, 1.0, None)
    path, area = measured.scenario.circuit.return_path, 1.0
    if measured.unit == "N":
        area = measured.scenario.contact_area + getattr(path, "area", 0.0)
    return _Known(_STRESS, measured.group, logs - np.log(area), area, _squares(measured, {}))


def _squares(measured: Measurement, under: Mapping[str, Any]) -> Real | None:
    """Return the logarithm of the square of the largest voltage at each point; None for a current or an unknown voltage."""
    if any(f"drive.{height}" in measured.unknown for height in ("amplitude", "level", "high")):
        return None
    changes = [{measured.over: value, **under} for value in measured.at] if measured.over else [under]
    try:
        largest = [measured.scenario.replace(each).drive.largest() for each in changes]
    except ElectrovibError:
        return None
    return 2 * np.log(largest) if min(largest) > 0 else None


def _around(found: Sequence[tuple[str, Real]], n: int) -> Real:
    """Return quantiles (n, 1) of a normal distribution with mean and deviation of all, in which every group counts once."""
    from scipy.special import ndtri

    groups = [group for group, _ in found]
    shares = [np.full(len(each), 1 / (len(each) * groups.count(group))) for group, each in found]
    weights, logs = np.concatenate(shares), np.concatenate([each for _, each in found])
    middle = np.average(logs, weights=weights)
    deviation = np.sqrt(np.average((logs - middle) ** 2, weights=weights))
    least = DECADE / (2 * ndtri((1 + LEVEL) / 2))  # a decade between the ends of the interval
    quantiles: Real = middle + max(deviation, least) * ndtri((np.arange(n)[:, None] + 0.5) / n)
    return quantiles


def _over_range(logs: Real, n: int) -> Real:
    """Return quantiles (n, 1) of a uniform distribution over all, at least over a decade."""
    middle, length = (logs.min() + logs.max()) / 2, max(logs.max() - logs.min(), DECADE)
    quantiles: Real = middle + length * ((np.arange(n)[:, None] + 0.5) / n - 0.5)
    return quantiles
