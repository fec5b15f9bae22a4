"""The result of a study in sentences."""

from __future__ import annotations

import tomllib
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.paths import quantity_at, value_at
from electrovib.core.units import format_quantity
from electrovib.scenario import read_scenario
from electrovib.scenario.space import read_space

if TYPE_CHECKING:
    import xarray

    from electrovib.core.arrays import Real

NOT_JUDGED: Final = "validity of the scenario with its own values; single fingers are not judged:"
"""Heading of the diagnostics of a study."""
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
    if f"{name}_exceedance_anywhere" in found:
        ever = found[f"{name}_exceedance_anywhere"]
        lines += [
            f"{words} above {format_quantity(float(level), unit, digits=4)} at some {axis}: {100 * float(share):.3g} %"
            " of the fingers"
            for level, share in zip(ever[ever.dims[0]].values, ever.values, strict=True)
        ]
    return lines


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
