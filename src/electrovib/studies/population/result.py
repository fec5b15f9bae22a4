"""The result of a study as named arrays and as a Dataset, with what it states about its origin."""

from __future__ import annotations

import hashlib
import json
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from electrovib.core.own_models import origins
from electrovib.core.signals import SIGNALS
from electrovib.core.versions import versions
from electrovib.solve.quantities.answer import validity
from electrovib.studies.population.declared import FORMAT, scenario_text

if TYPE_CHECKING:
    from collections.abc import Mapping

    import xarray
    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.studies.population.declared import DeclaredStudy
    from electrovib.studies.population.fingers import Collected, Evaluator

EXACT: Final = "exact order statistics of float32 values, interpolated linearly"
BINNED: Final = "from a histogram of float32 values, relative error below 0.3 %"
_FINGER: Final = "finger"


class StoredArray(NamedTuple):
    """An array of a result, with its dimensions, unit and meaning."""

    dims: tuple[str, ...]
    values: NDArray[Any]
    attributes: dict[str, str]


def arrays(collected: Collected) -> dict[str, StoredArray]:
    """Compute the arrays of a result, except the signals of every finger."""
    evaluator, declared = collected.evaluator, collected.evaluator.declared
    axis, dim = SIGNALS[declared.axis], declared.axis
    found = {dim: StoredArray((dim,), evaluator.axis, {"units": axis.unit, "long_name": axis.doc})}
    if declared.percentiles:
        values = np.asarray(declared.percentiles)
        found["percentile"] = StoredArray(("percentile",), values, {"units": "%", "long_name": "percentile"})
    for name in declared.signals:
        found |= _of_signal(name, collected)
    if declared.draws:
        found |= _parameters(declared)
    return found


def _of_signal(name: str, collected: Collected) -> dict[str, StoredArray]:
    each, declared = collected.statistics[name], collected.evaluator.declared
    unit, axis = SIGNALS[name].unit, declared.axis
    words, found = name.replace("_", " "), dict[str, StoredArray]()

    def put(suffix: str, dims: tuple[str, ...], values: NDArray[Any], unit: str, meaning: str) -> None:
        found[f"{name}_{suffix}"] = StoredArray(dims, values, {"units": unit, "long_name": meaning})

    squared = f"{unit}^2" if unit.isalpha() else f"({unit})^2"
    put("mean", (axis,), each.mean, unit, f"mean of the {words} over the fingers")
    put("variance", (axis,), each.variance(), squared, f"variance of the {words} over the fingers")
    if declared.percentiles:
        bands = _quantiles(name, collected)
        put("percentile", ("percentile", axis), bands, unit, f"percentiles of the {words} over the fingers")
    if each.unknown.any():
        put("unknown", (axis,), each.unknown, "1", f"number of fingers whose {words} is not known")
    if each.thresholds:
        along = f"{name}_threshold"
        put("threshold", (along,), np.asarray(each.thresholds), unit, f"threshold of the {words}")
        share = f"probability that the {words} of a finger exceeds the threshold"
        put("exceedance", (along, axis), each.above / declared.fingers, "1", share)
        ever = f"{share} at some {axis}"
        put("exceedance_anywhere", (along,), each.anywhere / declared.fingers, "1", ever)
    return found


def _quantiles(name: str, collected: Collected) -> Real:
    """Return the percentiles by column, (percentiles, n); NaN where the signal of a finger is not known."""
    from electrovib.solve.population.kernels import quantiles

    each, evaluator = collected.statistics[name], collected.evaluator
    shares = tuple(percentile / 100 for percentile in evaluator.declared.percentiles)
    if each.histogram is not None:
        found = each.histogram.quantiles(shares)
    else:
        found = quantiles(collected.rows[name], shares, threads=evaluator.threads)
    return np.where(each.unknown > 0, np.nan, found)


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


def attributes(evaluator: Evaluator) -> dict[str, Any]:
    """Return what a result states about its origin: scenario, space, seed, versions, kernel and methods.

    Its ``validity`` is that of the scenario with its own values; single fingers are not judged.
    """
    declared = evaluator.declared
    return {
        "format": FORMAT,
        "title": declared.scenario.title,
        "fingers": declared.fingers,
        "seed": declared.seed,
        "signals": list(declared.signals),
        "definition": definition(declared),
        "method": evaluator.method,
        "kernel": evaluator.kernel,
        "percentiles_from": EXACT if evaluator.exact else BINNED,
        "versions": computing_versions(),
        "scenario": declared.scenario.to_json(),
        "scenario_toml": scenario_text(declared.scenario),
        "space_toml": declared.space.to_toml(),
        "space_remarks": list(declared.space.remarks),
        "own_models": json.dumps(origins(declared.scenario), sort_keys=True),
        "validity": json.dumps([each.to_dict() for each in validity(declared.scenario)]),
    }


def definition(declared: DeclaredStudy) -> dict[str, Any]:
    """Return what distinguishes a study from others; long texts as their SHA-256."""
    found = declared.identity()
    return found | {name: hashlib.sha256(found[name].encode()).hexdigest() for name in ("scenario", "space")}


def computing_versions() -> dict[str, str]:
    """Return the versions of the packages on which the numbers of a study depend."""
    found = versions()
    return {name: found[name] for name in ("electrovib", "numpy", "scipy", "numba") if name in found}
