"""Bands of a signal over the fingers of a study."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import InputError, nearest
from electrovib.core.signals import signal as declared
from electrovib.studies.population.result import percentile_words
from electrovib.view.lines import Traces, envelope, has, lines
from electrovib.view.plots.draw import WIDE, draw, finish
from electrovib.view.style import COLOURS, drawing

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes

    from electrovib.core.arrays import Real

_AXES: Final = {"time": ("time $t$", "s"), "frequency": ("frequency $f$", "Hz")}
_FAINT, _STRONG = 0.18, 0.42
"""Opacity of the widest and of the narrowest band."""
_DEEPEST: Final = 1e-5
"""Lowest value of a logarithmic axis, relative to the highest."""


def bands(
    found: xarray.Dataset, signal: str = "", *, beside: Traces | None = None, ax: Axes | None = None
) -> Axes:
    """Draw the percentiles of a signal over the fingers, pair by pair as bands, and its mean.

    Parameters
    ----------
    found : xarray.Dataset
        Result of `electrovib.study`.
    signal : str
        Of the study; its first one if empty.
    beside : Trace, sequence of Trace or mapping of str to Trace, optional
        Runs and recordings that are drawn over the bands, where they have the signal.
    ax : Axes, optional
        Where to draw; a new figure if None.

    Returns
    -------
    Axes
        Data in SI. The lowest percentile and the highest one bound the widest band, and so on; a percentile between them
        is a line, the mean is dashed. Over frequency the horizontal axis is logarithmic; the vertical one too where the widest
        band would touch 0 at most samples: where its ends differ by more than a factor of 30.

    Raises
    ------
    InputError
        If the study has no such signal.

    Examples
    --------
    >>> found = ev.study("bau_2010/sine", "fingers", n=8, seed=1)
    >>> ev.plot.bands(found, "electrostatic_force").get_ylabel()
    'electrostatic force $f_e$ [N]'
    """
    name = signal or str(found.attrs["signals"][0])
    if name not in found.attrs["signals"]:
        raise InputError(f"signal '{name}': not one of this study.{nearest(name, found.attrs['signals'])}")
    mean = found[f"{name}_mean"]
    axis = str(mean.dims[0])
    x = np.asarray(found[axis].values, dtype=float)
    with drawing(ax) as axes:
        if axis == "frequency":
            axes.set_xscale("log")
        if f"{name}_percentile" in found:
            _draw_bands(axes, x, found[f"{name}_percentile"])
        axes.plot(*envelope(x, np.asarray(mean.values)), color=COLOURS[1], linestyle="--", label="mean")
        drawn = [] if beside is None or not has(beside, name) else lines(beside, name, axis)
        draw(
            axes,
            [
                replace(each, colour=COLOURS[2 + place % (len(COLOURS) - 2)])
                for place, each in enumerate(drawn)
            ],
        )
        _logarithmic_if_near_zero(axes, found, name)
        known = declared(name)
        finish(axes, x=_AXES[axis], y=(f"{name.replace('_', ' ')} ${known.symbol}$", known.unit))
        return axes


def exceedance(found: xarray.Dataset, signal: str = "", *, ax: Axes | None = None) -> Axes:
    """Draw the probability that a finger exceeds each threshold, at every sample.

    Parameters
    ----------
    found, signal, ax
        As for `bands`.

    Returns
    -------
    Axes
        Probability, dimensionless, 0 to 1.

    Raises
    ------
    InputError
        If the study has no such signal, or no threshold of it.

    Examples
    --------
    >>> found = ev.study("bau_2010/sine", "fingers", n=8, seed=1, exceed="1 mN")
    >>> ev.plot.exceedance(found).get_ylabel()
    'exceedance probability'
    """
    from electrovib.view.units import pretty_quantity

    name = signal or str(found.attrs["signals"][0])
    if f"{name}_exceedance" not in found:
        raise InputError(f"signal '{name}': this study has no threshold of it; ask for one with --exceed")
    shares = found[f"{name}_exceedance"]
    along, axis = (str(each) for each in shares.dims)
    x, unit = np.asarray(found[axis].values, dtype=float), str(found[along].attrs["units"])
    with drawing(ax) as axes:
        if axis == "frequency":
            axes.set_xscale("log")
        for place, (level, row) in enumerate(zip(found[along].values, shares.values, strict=True)):
            label = f"above {pretty_quantity(float(level), unit, digits=4)}"
            axes.plot(*envelope(x, np.asarray(row)), color=COLOURS[place % len(COLOURS)], label=label)
        axes.set_ylim(-0.02, 1.02)
        finish(axes, x=_AXES[axis], y=("exceedance probability", "1"))
        return axes


def _logarithmic_if_near_zero(ax: Axes, found: xarray.Dataset, name: str) -> None:
    """Set a logarithmic axis where the lowest percentile is not told from 0 on a linear one."""
    if f"{name}_percentile" not in found:
        return
    rows = np.asarray(found[f"{name}_percentile"].values)
    low, high = rows[0], rows[-1]
    known = np.isfinite(low) & (high > 0)
    if not known.any() or (low[known] < 0).any():
        return
    if np.median(high[known] > WIDE * low[known]) < 1 or not (low[known] > 0).any():
        return
    largest = int(np.nanargmax(np.where(low > 0, rows[len(rows) // 2], -1.0)))
    top = float(high[known].max())
    ax.set_yscale("log")
    ax.set_ylim(max(float(low[largest]) / 3, top * _DEEPEST), 2 * float(ax.dataLim.y1))


def _draw_bands(ax: Axes, x: Real, values: xarray.DataArray) -> None:
    """Fill between the outermost percentiles, then the next pair; draw the one that has no partner as a line."""
    shares, rows = np.asarray(values["percentile"].values), np.asarray(values.values)
    pairs = len(shares) // 2
    for pair in range(pairs):
        low, high = rows[pair], rows[-1 - pair]
        strength = _FAINT + (_STRONG - _FAINT) * pair / max(1, pairs - 1)
        label = f"{shares[pair]:g} to {shares[-1 - pair]:g} % of the fingers"
        ax.fill_between(x, low, high, color=COLOURS[0], alpha=strength, linewidth=0, label=label)
    if len(shares) % 2:
        ax.plot(*envelope(x, rows[pairs]), color=COLOURS[0], label=percentile_words(float(shares[pairs])))
