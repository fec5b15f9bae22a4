"""Predictions after calibration: draws weighted by how well they agree with another measurement of the same set-up."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from electrovib.core.answer import Table
from electrovib.core.arrays import Real
from electrovib.core.errors import ElectrovibError, InputError
from electrovib.core.paths import quantity_at
from electrovib.core.units import format_quantity
from electrovib.data.atomic import csv_text
from electrovib.scenario.space.reading import read_space
from electrovib.studies.evidence.measurement import Measurement, numbers_of
from electrovib.studies.evidence.predicted import ModelPrediction, candidates, set_up, values_of
from electrovib.studies.evidence.standing import NOTHING, Score, judge, typical_factor

LEAST: Final = 5.0
"""Effective number of draws below which a calibration is not trusted."""
ENOUGH: Final = 20.0
"""Effective number from which on no more are drawn."""
TIMES: Final = (1, 4, 16, 64)
"""Numbers of draws, over that of a prediction, one after the other until there are enough that agree."""
HOPELESS: Final = 10.0
"""Deviations of the closest draw, beyond which larger numbers than the second are not tried."""
UNLIKELY: Final = 1e-3
"""Probability of a worse misfit, by the spread of the measurement, below which the closest draw contradicts it."""


@dataclass(frozen=True)
class Calibrated:
    """A candidate on a measurement before and after calibration.

    - `measurement`, `by`, `model`: names of what is predicted, of what calibrates, and of the candidate.
    - `prior`, `score`: the score on the same values without and with the calibration, which is None if it is not possible.
    - `draws`, `effective`: number of draws that were weighted, and how many of equal weight are worth as much.
    - `why`: why it is not possible.
    """

    measurement: str
    by: str
    model: str
    prior: Score
    score: Score | None
    draws: int
    effective: float
    why: str


@dataclass(frozen=True)
class _Weighted:
    """Draws (n,) by path, each as often as its weight has it, and their ranges; of how many, and how many of them count."""

    tables: Mapping[str, Any]
    columns: Mapping[str, Real]
    draws: int
    effective: float
    why: str


_NONE: Final = _Weighted({}, {}, 0, 0.0, "")


def calibrated_predictions(
    measured: Mapping[str, Measurement],
    found: Mapping[str, Sequence[ModelPrediction]],
    *,
    n: int,
    seed: int,
) -> Iterator[Calibrated]:
    """Predict what declares a calibration, by every candidate that predicts it without one."""
    known: dict[tuple[str, str], _Weighted] = {}
    for name, each in measured.items():
        for label, by, rest, kept in _sets(name, each):
            for one in found[name]:
                weighted, score, why = _NONE, None, ""
                try:
                    if (label, one.model) not in known:
                        known[label, one.model] = _weighted(by, one.model, n=n, seed=seed)
                    weighted = known[label, one.model]
                    why = weighted.why
                    score = None if why else _score(name, rest, one.model, weighted, n=n, seed=seed)
                except ElectrovibError as error:
                    why = error.problems[0].reason
                prior = judge(name, rest, ModelPrediction(one.model, one.values[:, kept]))
                yield Calibrated(
                    name, label, one.model, prior, score, weighted.draws, weighted.effective, why
                )


def _sets(name: str, measured: Measurement) -> Iterator[tuple[str, Measurement, Measurement, list[int]]]:
    """Return what calibrates, with its name, and what is predicted, with the places of its values."""
    everything = list(range(len(measured.values)))
    for label, by in measured.calibrated_by.items():
        yield label, by, measured, everything
    if measured.calibrated_at:
        own = [place for place in everything if measured.at[place] in measured.calibrated_at]
        others = [place for place in everything if place not in own]
        unit = quantity_at(measured.scenario, measured.over).unit
        at = ", ".join(format_quantity(each, unit) for each in measured.calibrated_at)
        yield f"{name} at {at}", _part(measured, own), _part(measured, others), others


def _part(measured: Measurement, places: Sequence[int]) -> Measurement:
    columns = (measured.at, measured.values, measured.spread)
    at, values, spread = (tuple(column[place] for place in places) for column in columns)
    return replace(measured, at=at, values=values, spread=spread, calibrated_at=(), calibrated_by={})


def _weighted(by: Measurement, model: str, *, n: int, seed: int) -> _Weighted:
    """Draw what is not printed of a candidate until enough of it agrees with a measurement."""
    from scipy.special import chdtrc

    if model in by.made:
        raise InputError("it was made from the numbers that calibrate")
    scenario, tables = set_up(by, model, candidates(by)[model])
    if not tables:
        raise InputError("nothing is open that could be calibrated")
    count_of = len(numbers_of("", by))
    space, squares = read_space(scenario, {"space": tables}), np.empty(0)
    for times in TIMES:
        count = times * n - len(squares)
        values = values_of(by, scenario, space.draw(seed, len(squares), times * n), count)
        squares = np.append(squares, _squares(by, values))
        weights = np.exp(-0.5 * (squares - squares.min()))
        weights /= weights.sum()
        effective = float(1 / np.sum(weights**2))
        off = math.sqrt(squares.min() / count_of)
        contradicted = chdtrc(count_of, squares.min()) < UNLIKELY
        if (times > 1 and off > HOPELESS) if contradicted else effective >= ENOUGH:
            break
    why = ""
    if contradicted:
        why = f"it contradicts all {len(squares)} draws: the closest is {off:.2g} deviations off"
    elif effective < LEAST:
        why = f"{effective:.2g} effective of {len(squares)} draws are too few to be trusted"
    chosen = np.searchsorted(np.cumsum(weights), (np.arange(n) + 0.5) / n).clip(max=len(squares) - 1)
    columns = {path: column[chosen] for path, column in space.draw(seed, 0, len(squares)).items()}
    return _Weighted(tables, columns, len(squares), effective, why)


def _squares(by: Measurement, values: Real) -> Real:
    """Sum the squares of the deviations of each draw over the spread; points that share their errors count as one."""
    widths = np.sqrt(np.log1p(np.array(by.spread) ** 2))
    off = np.log(np.maximum(np.nan_to_num(values, posinf=0.0), NOTHING)) - np.log(np.array(by.values))
    found: Real = np.mean((off / widths) ** 2, axis=1) * len(numbers_of("", by))
    return found


def _score(name: str, measured: Measurement, model: str, weighted: _Weighted, *, n: int, seed: int) -> Score:
    """Judge a prediction in which what was calibrated is drawn by weight, and anything else from its range."""
    scenario, tables = set_up(measured, model, candidates(measured)[model])
    common = [path for path, each in tables.items() if weighted.tables.get(path) == each]
    if not common:
        raise InputError("no range of what is not printed is the same as in what calibrates")
    draws = read_space(scenario, {"space": tables}).draw(seed, 0, n)
    values = values_of(measured, scenario, draws | {path: weighted.columns[path] for path in common}, n)
    if not np.all(np.isfinite(values)):
        raise InputError("the law gives no number for some of the calibrated draws")
    return judge(name, measured, ModelPrediction(model, values))


def sentence(found: Sequence[Calibrated]) -> str:
    """Say how many calibrations are possible, and the medians of factor and width without and with them."""
    both = [(each.prior, each.score) for each in found if each.score]
    said = f"Calibrated on a part of their set-up, {len(both)} of {len(found)} predictions are possible"
    if not both:
        return f"{said}."
    numbers = np.median([[(_factor(one), one.width) for one in each] for each in both], axis=0)
    (factor, width), (factor_after, width_after) = numbers
    return (
        f"{said}; medians of their typical factor {factor:.3g} before and {factor_after:.3g} after, of their width"
        f" {width:.2g} decades before and {width_after:.2g} after."
    )


def table(found: Sequence[Calibrated]) -> Table:
    """Set every candidate without and with its calibration side by side."""

    def both(number: Callable[[Score], str]) -> Callable[[Calibrated], str]:
        return lambda each: f"{number(each.prior)} → {number(each.score) if each.score else '–'}"

    columns: dict[str, Callable[[Calibrated], str]] = {
        "measurement": lambda each: each.measurement,
        "calibrated by": lambda each: each.by,
        "law or model": lambda each: each.model,
        "typical factor": both(lambda each: f"{_factor(each):.3g}"),
        "width": both(lambda each: f"{each.width:.2f}"),
        "within 90 %": both(lambda each: f"{100 * each.covered:.0f} %"),
        "score": both(lambda each: f"{each.score:.2f}"),
        "effective draws, or why not": lambda each: each.why or f"{each.effective:.3g} of {each.draws}",
    }
    caption = "Before, with what is not printed drawn from its ranges → after, weighted by what calibrates."
    looks = {7: "words"}
    return Table.of("Calibrated predictions", found, columns, caption=caption, looks=looks, folded=True)


def _factor(each: Score) -> float:
    return typical_factor([each])


def csv_of(found: Sequence[Calibrated]) -> str:
    """Write the scores without and with the calibration, NaN where it is not possible, as CSV."""
    own = ["measurement", "by", "model", "draws", "effective", "why"]
    numbers = ["ratio", "low", "high", "width", "covered", "score"]
    rows = [
        [getattr(each, name) for name in own]
        + [getattr(one, name, math.nan) for one in (each.prior, each.score) for name in numbers]
        for each in found
    ]
    return csv_text([*own, *(f"{name}_{when}" for when in ("before", "after") for name in numbers)], rows)
