"""The result of a study as named arrays, as a Dataset with its origin, in sentences, and its bands as CSV."""

from __future__ import annotations

import hashlib
import json
import tomllib
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.diagnostics import diagnostics_of
from electrovib.core.errors import printable
from electrovib.core.own_models import origins
from electrovib.core.paths import quantity_at, value_at
from electrovib.core.signals import SIGNALS
from electrovib.core.units import format_quantity, unit_of_files
from electrovib.core.versions import versions
from electrovib.data.atomic import csv_text, plain
from electrovib.scenario import read_scenario
from electrovib.scenario.space import read_space
from electrovib.solve.population.percentiles import quantiles
from electrovib.solve.quantities.answer import validity
from electrovib.studies import widths
from electrovib.studies.population.declared import FORMAT, DeclaredStudy, scenario_text
from electrovib.studies.widths import Width

if TYPE_CHECKING:
    import xarray
    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.studies.population.tiles import Collected, Evaluator


EXACT: Final = "exact order statistics of float32 values, interpolated linearly"
BINNED: Final = "from a histogram of float32 values, relative error below 0.3 %"
_FINGER: Final = "finger"


def arrays(collected: Collected) -> xarray.Dataset:
    """Compute the arrays of a result, except the signals of every finger."""
    import xarray

    evaluator, declared = collected.evaluator, collected.evaluator.declared
    axis, dim = SIGNALS[declared.axis], declared.axis
    found: dict[str, Any] = {dim: (dim, evaluator.axis, {"units": axis.unit, "long_name": axis.doc})}
    if declared.percentiles:
        about = {"units": "%", "long_name": "percentile"}
        found["percentile"] = ("percentile", np.asarray(declared.percentiles), about)
    for name in declared.signals:
        found |= _of_signal(name, collected)
    if declared.records:
        found |= _parameters(declared)
    return xarray.Dataset(found)


def _of_signal(name: str, collected: Collected) -> dict[str, Any]:
    each, declared = collected.statistics[name], collected.evaluator.declared
    unit, axis = SIGNALS[name].unit, declared.axis
    words, found = name.replace("_", " "), dict[str, Any]()

    def put(suffix: str, dims: tuple[str, ...], values: NDArray[Any], unit: str, meaning: str) -> None:
        found[f"{name}_{suffix}"] = (dims, values, {"units": unit, "long_name": meaning})

    squared = unit_of_files(f"{unit}^2" if unit.isalpha() else f"({unit})^2")
    put("mean", (axis,), each.mean, unit, f"mean of the {words} over the fingers")
    put("variance", (axis,), each.variance(), squared, f"variance of the {words} over the fingers")
    if declared.percentiles:
        bands, ends = _quantiles(name, collected)
        put("percentile", ("percentile", axis), bands, unit, f"percentiles of the {words} over the fingers")
        about = f"95 % interval of each percentile of the {words} for the number of fingers"
        put("percentile_interval", ("percentile", "end", axis), ends, unit, about)
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


def _quantiles(name: str, collected: Collected) -> tuple[Real, Real]:
    """Return the percentiles by column, (percentiles, n), and their 95 % intervals for the number of fingers.

    These are the order statistics of the binomial ranks, (percentiles, 2, n), infinite where so few fingers have
    none. All are NaN where the signal of a finger is not known.
    """
    each, evaluator = collected.statistics[name], collected.evaluator
    count = evaluator.declared.fingers
    shares = [percentile / 100 for percentile in evaluator.declared.percentiles]
    ranks = [rank for share in shares for rank in widths.quantile_ranks(share, count)]
    places = [min(max(rank - 1, 0), count - 1) / max(count - 1, 1) for rank in ranks]
    if each.histogram is not None:
        found = each.histogram.quantiles([*shares, *places])
    else:
        found = quantiles(collected.rows[name], [*shares, *places], threads=evaluator.threads)
    middle, ends = np.split(np.where(each.unknown > 0, np.nan, found), [len(shares)])
    ends[[not 0 < rank <= count for rank in ranks]] = np.inf
    return middle, ends.reshape(len(shares), 2, -1)


def _parameters(declared: DeclaredStudy) -> dict[str, Any]:
    """Return the drawn values of every parameter."""
    found = {}
    for path, values in declared.space.draw(declared.seed, 0, declared.fingers).items():
        quantity = quantity_at(declared.scenario, path)
        about = {"units": quantity.unit, "long_name": quantity.doc}
        found[path] = (_FINGER, np.asarray(values, float), about)
    return found


def draws_of(name: str, axis: str) -> tuple[tuple[str, str], dict[str, str]]:
    """Return dimensions and attributes of the signals of every finger."""
    known = SIGNALS[name]
    return (_FINGER, axis), {"units": known.unit, "long_name": known.doc}


def attributes(evaluator: Evaluator) -> dict[str, Any]:
    """Return what a result states about its origin: scenario, space, seed, versions, kernel and methods.

    Its ``validity`` is that of the scenario with its own values; single fingers are not judged.
    """
    declared = evaluator.declared
    return {
        "format": FORMAT,
        "title": declared.scenario.titled(),
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
        "widths": [plain(asdict(each)) for each in _widths(declared)],
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


NOT_JUDGED: Final = (
    "warnings are of the scenario with its own values; single fingers are not judged, neither for their limits nor for a gap"
    " that falls shut under their load"
)
"""What the diagnostics of a study cover."""
_DRAWN: Final = 2000
"""Fingers with which the values of the scenario are compared."""
_FAR: Final = 0.8
"""Share of the fingers on one side from which on a value is named."""


def signal_words(found: xarray.Dataset, name: str) -> list[str]:
    """Report the bands of a signal where its median, or else its mean, is largest in magnitude."""
    mean = found[f"{name}_mean"]
    axis, unit = str(mean.dims[0]), str(mean.attrs["units"])
    middle, kind = _middle(found, name)
    words = name.replace("_", " ")
    if not np.isfinite(middle).any():
        return [f"{words}: not known for some finger at every {axis}"]
    at = int(np.nanargmax(np.abs(middle)))
    where = format_quantity(float(found[axis].values[at]), str(found[axis].attrs["units"]), digits=4)
    bands = found.get(f"{name}_percentile")
    parts = [] if bands is None else [_percentiles_at(bands, at, unit)]
    deviation = float(np.sqrt(found[f"{name}_variance"].values[at]))
    spread = (
        f", standard deviation {format_quantity(deviation, unit, digits=3)}" if np.isfinite(deviation) else ""
    )
    parts.append(f"mean {format_quantity(float(mean.values[at]), unit, digits=3)}{spread}")
    lines = [f"{words} at {where}, where its {kind} is largest: {'; '.join(parts)}"]
    if f"{name}_percentile_interval" in found:
        lines.append(_sampling_words(found, name, at))
    if f"{name}_exceedance_anywhere" in found:
        ever = found[f"{name}_exceedance_anywhere"]
        lines += [
            f"{words} above {format_quantity(float(level), unit, digits=4)} at some {axis}: {100 * float(share):.3g} %"
            f" of the fingers ({_interval_of_share(float(share), int(found.attrs['fingers']))})"
            for level, share in zip(ever[ever.dims[0]].values, ever.values, strict=True)
        ]
    return lines


def _sampling_words(found: xarray.Dataset, name: str, at: int) -> str:
    """State the intervals of the percentiles at one sample for the finite number of fingers."""
    ends, unit = (
        found[f"{name}_percentile_interval"].values[..., at],
        str(found[f"{name}_mean"].attrs["units"]),
    )
    each = (
        f"{percentile_words(float(share))} {' to '.join(widths.shown_end(end, unit) for end in pair)}"
        for share, pair in zip(found["percentile"].values, ends, strict=True)
    )
    return (
        f"width by {widths.SAMPLING}, 95 % intervals for {found.attrs['fingers']} fingers: {'; '.join(each)}"
    )


def _interval_of_share(share: float, count: int) -> str:
    low, high = widths.clopper_pearson(round(share * count), count)
    return f"95 % interval for {count} fingers: {100 * low:.3g} to {100 * high:.3g} %"


def width_words(found: xarray.Dataset) -> list[str]:
    """State by what the bands are uncertain beside the number of fingers."""
    each = widths.sentences(Width(**width) for width in found.attrs.get("widths", []))
    return [f"{said[0].lower()}{said[1:].removesuffix('.')}" for said in each]


def _widths(declared: DeclaredStudy) -> list[Width]:
    """Return by what the bands are uncertain beside the number of fingers, whose intervals are arrays."""
    law = type(declared.scenario.force).__name__
    factors = dict.fromkeys(widths.factor_of(declared.scenario, name) for name in declared.signals)
    return [*(widths.law_width(law, factor) for factor in factors), widths.UNFELT]


def _middle(found: xarray.Dataset, name: str) -> tuple[Real, str]:
    """Return the percentile nearest to the median, or the mean where there is none, and what it is."""
    bands = found.get(f"{name}_percentile")
    if bands is None:
        return np.asarray(found[f"{name}_mean"].values), "mean"
    shares = np.asarray(bands["percentile"].values)
    place = int(np.abs(shares - 50).argmin())
    return np.asarray(bands.values[place]), percentile_words(float(shares[place]))


def _percentiles_at(bands: xarray.DataArray, at: int, unit: str) -> str:
    """List the percentiles at one sample."""
    shares, values = bands["percentile"].values, bands.values[:, at]
    return "; ".join(
        f"{percentile_words(float(share))} {format_quantity(float(value), unit, digits=3)}"
        for share, value in zip(shares, values, strict=True)
    )


def percentile_words(share: float) -> str:
    """Name a percentile: ``median``, ``5th percentile``."""
    if share == 50:
        return "median"
    endings = {1: "st", 2: "nd", 3: "rd"}
    whole = share == int(share) and int(share) % 100 not in {11, 12, 13}
    return f"{share:g}{endings.get(int(share) % 10, 'th') if whole else 'th'} percentile"


def method_words(found: xarray.Dataset) -> list[str]:
    """State the number of fingers, the seed, and how signals and percentiles were computed."""
    attributes = found.attrs
    lines = [
        f"{attributes['fingers']} fingers, seed {attributes['seed']}; {attributes['method']}; kernel: {attributes['kernel']}"
    ]
    if "percentile" in found.dims:
        lines.append(f"percentiles: {attributes['percentiles_from']}")
    return lines


def nominal_words(found: xarray.Dataset) -> list[str]:
    """State which values of the scenario of a study are far from the middle of its population."""
    scenario = read_scenario(tomllib.loads(str(found.attrs["scenario_toml"])))
    space = read_space(scenario, tomllib.loads(str(found.attrs["space_toml"])))
    far = []
    for path, values in space.draw(int(found.attrs["seed"]), 0, _DRAWN).items():
        own = value_at(scenario, path)
        if own is None:
            continue
        below, above = float(np.mean(values > own)), float(np.mean(values < own))
        share, side = max((below, "below"), (above, "above"))
        if share > _FAR:
            shown = format_quantity(own, quantity_at(scenario, path).unit, digits=3)
            far.append((share, f"{path} = {shown} ({side} {100 * share:.3g} % of the fingers)"))
    if not far:
        return []
    listed = ", ".join(text for _, text in sorted(far, reverse=True))
    return [
        f"the scenario with its own values is no typical finger of this population, and may lie outside its bands: {listed}"
    ]


def bands_csv(found: xarray.Dataset) -> str:
    """Write the bands of a study as CSV."""
    columns = _columns(found)
    said = [*method_words(found), *width_words(found)]
    remarks = [found.attrs["title"], *said, *found.attrs["space_remarks"], NOT_JUDGED]
    return csv_text(
        [*columns],
        ([float(value) for value in row] for row in zip(*columns.values(), strict=True)),
        remarks=[printable(line) for line in remarks if line],
        diagnostics=diagnostics_of(found),
    )


def _columns(found: xarray.Dataset) -> dict[str, Real]:
    axis = str(found[f"{found.attrs['signals'][0]}_mean"].dims[0])
    columns = {f"{axis} [{found[axis].attrs['units']}]": np.asarray(found[axis].values)}
    for name in found.attrs["signals"]:
        own = found[f"{name}_mean"].attrs["units"]
        for kind in ("mean", "variance", "percentile", "exceedance", "unknown"):
            if f"{name}_{kind}" not in found:
                continue
            each = found[f"{name}_{kind}"]
            several = [None] if each.ndim == 1 else each[each.dims[0]].values.tolist()
            for level, row in zip(several, each.values.reshape(len(several), -1), strict=True):
                at = "" if level is None else f" {level:g}"
                if kind == "exceedance":
                    at = f" of {format_quantity(level, own)}"
                columns[f"{name} {kind}{at} [{each.attrs['units']}]"] = row
    return columns
