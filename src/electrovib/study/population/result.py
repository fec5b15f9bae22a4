"""The result of a study as named arrays, and as a Dataset."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from electrovib.core.signals import SIGNALS
from electrovib.study.population.reduced import of_blocks

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import xarray
    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.study.population.declared import DeclaredStudy
    from electrovib.study.population.merged import MergedFingers, MergedSignal
    from electrovib.study.population.reduced import Form
    from electrovib.study.population.tile import Evaluator

EXACT: Final = "exact order statistics of float32 values, interpolated linearly"
BINNED: Final = "from a histogram of float32 values, relative error below 0.3 %"
_FINGER: Final = "finger"


class StoredArray(NamedTuple):
    """An array of a result, with its dimensions, unit and meaning."""

    dims: tuple[str, ...]
    values: NDArray[Any]
    attributes: dict[str, str]


def arrays(evaluator: Evaluator, merged: MergedFingers) -> dict[str, StoredArray]:
    """Compute the arrays of a result, except the signals of every finger."""
    declared = evaluator.declared
    axis = SIGNALS[declared.axis]
    found = {
        declared.axis: StoredArray(
            (declared.axis,), evaluator.axis, {"units": axis.unit, "long_name": axis.doc}
        )
    }
    if declared.percentiles:
        values = np.asarray(declared.percentiles)
        found["percentile"] = StoredArray(("percentile",), values, {"units": "%", "long_name": "percentile"})
    for name in declared.signals:
        found |= _of_signal(name, declared, merged)
    if declared.draws:
        found |= _parameters(declared)
    return found


def _of_signal(name: str, declared: DeclaredStudy, merged: MergedFingers) -> dict[str, StoredArray]:
    each, unit, axis = merged.signals[name], SIGNALS[name].unit, declared.axis
    words, found = name.replace("_", " "), dict[str, StoredArray]()

    def put(suffix: str, dims: tuple[str, ...], values: NDArray[Any], unit: str, meaning: str) -> None:
        found[f"{name}_{suffix}"] = StoredArray(dims, values, {"units": unit, "long_name": meaning})

    moments = each.moments
    assert moments is not None
    put("mean", (axis,), moments.mean, unit, f"mean of the {words} over the fingers")
    put("variance", (axis,), moments.variance(), _squared(unit), f"variance of the {words} over the fingers")
    if declared.percentiles:
        bands = _quantiles(each, merged.evaluator)
        put("percentile", ("percentile", axis), bands, unit, f"percentiles of the {words} over the fingers")
    if each.counts.unknown.any():
        put("unknown", (axis,), each.counts.unknown, "1", f"number of fingers whose {words} is not known")
    if levels := declared.thresholds.get(name, ()):
        along = f"{name}_threshold"
        found[along] = StoredArray(
            (along,), np.asarray(levels), {"units": unit, "long_name": f"threshold of the {words}"}
        )
        share = f"probability that the {words} of a finger exceeds the threshold"
        put("exceedance", (along, axis), each.counts.above / declared.fingers, "1", share)
        put(
            "exceedance_anywhere",
            (along,),
            each.counts.anywhere / declared.fingers,
            "1",
            f"{share} at some {axis}",
        )
    return found


def _squared(unit: str) -> str:
    return f"{unit}^2" if unit.isalpha() else f"({unit})^2"


def _quantiles(each: MergedSignal, evaluator: Evaluator) -> Real:
    """Return the percentiles; NaN where the signal of a finger is not known."""
    from electrovib.solve.population.kernels import quantiles

    shares = tuple(percentile / 100 for percentile in evaluator.declared.percentiles)
    if each.values is not None:
        found = quantiles(each.values, shares, threads=evaluator.threads)
    elif each.forms:
        found = _of_forms(each.forms, evaluator, shares)
    else:
        assert each.histogram is not None
        found = each.histogram.quantiles(shares)
    return np.where(each.counts.unknown > 0, np.nan, found)


def _of_forms(forms: Sequence[Form], evaluator: Evaluator, shares: tuple[float, ...]) -> Real:
    """Return the quantiles of signals that are computed again."""
    from electrovib.solve.population.kernels import quantiles, square_quantiles

    whole, known = of_blocks(forms)
    if whole is None:
        return quantiles(np.concatenate(list(known.values())), shares, threads=evaluator.threads)
    voltage, steps, places = evaluator.population.grid
    numbers = whole.rates, whole.residues, whole.direct, whole.state
    return square_quantiles(
        *numbers,
        voltage,
        steps,
        factor=whole.factor,
        outputs=places,
        probabilities=shares,
        known=known,
        threads=evaluator.threads,
    )


def _parameters(declared: DeclaredStudy) -> dict[str, StoredArray]:
    """Return the drawn values of every parameter."""
    from electrovib.core.paths import quantity_at

    drawn = declared.space.draw(declared.seed, 0, declared.fingers)
    found = {}
    for path, values in drawn.items():
        quantity = quantity_at(declared.scenario, path)
        found[path] = StoredArray(
            (_FINGER,), np.asarray(values, float), {"units": quantity.unit, "long_name": quantity.doc}
        )
    return found


def draws_of(name: str, axis: str) -> tuple[tuple[str, str], dict[str, str]]:
    """Return dimensions and attributes of the signals of every finger."""
    known = SIGNALS[name]
    return (_FINGER, axis), {"units": known.unit, "long_name": known.doc}


def dataset(found: Mapping[str, StoredArray], attributes: Mapping[str, Any]) -> xarray.Dataset:
    """Make a Dataset of the arrays of a result."""
    import xarray

    variables = {name: tuple(each) for name, each in found.items()}
    coordinates = {name: each for name, each in variables.items() if each[0] == (name,)}
    others = {name: each for name, each in variables.items() if name not in coordinates}
    return xarray.Dataset(others, coords=coordinates, attrs=dict(attributes))
