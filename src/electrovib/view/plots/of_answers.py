"""Figures of answers: candidates of a plate, Sobol indices, a constant force, a panel of a paper, bands over fingers."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from electrovib.core.answer import REFERENCE
from electrovib.core.errors import InputError, nearest
from electrovib.core.paths import words_at
from electrovib.core.signals import signal as declared
from electrovib.studies.population.result import percentile_words
from electrovib.view.lines import WIDE, Traces, draw, envelope, finish, has, legend_beside_no_curve, lines
from electrovib.view.style import COLOURS, NEUTRAL, PALE, PALETTE, drawing, label_axis, typeset

if TYPE_CHECKING:
    from collections.abc import Sequence

    import xarray
    from matplotlib.axes import Axes
    from matplotlib.typing import LineStyleType

    from electrovib.core.answer import Curve, Panel
    from electrovib.core.arrays import Real
    from electrovib.studies.check import CheckResult
    from electrovib.studies.design.plate.function import PlateCandidate
    from electrovib.studies.design.plate.result import PlateDesign
    from electrovib.studies.sensitivity import Sensitivity

SIZE: Final = (7.2, 4.4)
"""Width and height of the figure [inch]."""
MOST_LIMITS: Final = 2
"""Limits that have a sign of their own; candidates that others forbid share one."""
_SIGNS: Final = ("x", "+", "1")


def trade_off(design: PlateDesign, *, ax: Axes | None = None) -> Axes:
    """Draw the first objective of a design over the second, for every candidate.

    Parameters
    ----------
    design : PlateDesign
        From `electrovib.plan_plate`.
    ax : Axes, optional
        Where to draw; a new figure if None.

    Returns
    -------
    Axes
        Data in SI. With one objective it is drawn over the first varied parameter. Candidates without a finite number are
        omitted; a scale is logarithmic where the values span more than a factor of 30.

    Examples
    --------
    >>> plates = ev.plan_plate("bau_2010/sine", {"drive.amplitude": [50.0, 100.0]}, refine=0)
    >>> ev.plot.trade_off(plates).get_ylabel()
    'mean electrostatic force [mN]'
    """
    first = design.objectives[0]
    across = _across(design)
    points = [(each, _abscissa(each, across[0]), each.values[first.name]) for each in design.candidates]
    known = [point for point in points if math.isfinite(point[1]) and math.isfinite(point[2])]
    with drawing(ax, SIZE) as axes:
        handles, labels = [], []
        for label, colour, sign, chosen in _groups(design):
            kept = {id(each) for each in chosen}
            some = np.array([(x, y) for each, x, y in known if id(each) in kept]).reshape(-1, 2)
            if not len(some):
                continue
            handles += axes.plot(*some.T, linestyle="", marker=sign, markersize=3.5, color=colour, zorder=2)
            labels.append(f"{label}: {len(some)}")
        _front(axes, design, across[0], handles, labels)
        if not known:
            axes.text(0.5, 0.5, "no numbers to draw", transform=axes.transAxes, ha="center", va="center")
        for values, scale in (
            ([x for _, x, _ in known], axes.set_xscale),
            ([y for *_, y in known], axes.set_yscale),
        ):
            if values and min(values) > 0 and max(values) > WIDE * min(values):
                scale("log")
        label_axis(axes.xaxis, *across[1:])
        label_axis(axes.yaxis, words_at(design.base, first.name), first.unit)
        axes.set_title(f"Candidates within and beyond the limits: {len(design.candidates)}")
        if handles:
            legend_beside_no_curve(axes, handles, labels, "")
        return axes


def _across(design: PlateDesign) -> tuple[str, str, str]:
    """Return the name of the abscissa, its words and its unit."""
    if len(design.objectives) > 1:
        second = design.objectives[1]
        return second.name, words_at(design.base, second.name), second.unit
    path = next(iter(design.axes), "")
    return path, words_at(design.base, path) or "candidate", design.units.get(path, "1")


def _abscissa(candidate: PlateCandidate, name: str) -> float:
    return float(candidate.values.get(name, candidate.at.get(name, math.nan)))


def _groups(design: PlateDesign) -> list[tuple[str, str, str, Sequence[PlateCandidate]]]:
    """Return label, colour and sign of the candidates by what forbids them; at most four groups."""
    forbidden = [each for each in design.candidates if not each.is_allowed]
    alone = Counter(each.forbidden_by[0] for each in forbidden if len(each.forbidden_by) == 1)
    named = [name for name, _ in alone.most_common(MOST_LIMITS)]
    groups: list[tuple[str, str, str, Sequence[PlateCandidate]]] = []
    rest = [each for each in forbidden if each.forbidden_by not in {(name,) for name in named}]
    if rest:
        words = "forbidden by several or other limits" if named else "forbidden by several limits"
        groups.append((words, NEUTRAL, _SIGNS[-1], rest))
    for place, name in enumerate(named):
        some = [each for each in forbidden if each.forbidden_by == (name,)]
        groups.append((f"forbidden by {name} alone", (COLOURS[4], COLOURS[3])[place], _SIGNS[place], some))
    groups.append(("within the limits", COLOURS[0], "o", design.allowed))
    return groups


def _front(axes: Axes, design: PlateDesign, across: str, handles: list[Any], labels: list[str]) -> None:
    """Draw the Pareto set as a line, and mark the best candidate."""
    first = design.objectives[0].name
    if len(design.objectives) == 2 and design.pareto:
        points = np.array([(_abscissa(each, across), each.values[first]) for each in design.pareto])
        points = points[np.all(np.isfinite(points), axis=1)]
        points = points[np.argsort(points[:, 0])]
        handles += axes.plot(*points.T, color=COLOURS[1], marker="o", markersize=4, zorder=3)
        labels.append(f"Pareto set: {len(points)}")
    if design.best is not None:
        place = _abscissa(design.best, across), design.best.values[first]
        if all(map(math.isfinite, place)):
            axes.plot(
                *place,
                linestyle="",
                marker="*",
                markersize=13,
                color=COLOURS[1],
                markeredgecolor="#222222",
                zorder=4,
            )
            axes.annotate("best", place, textcoords="offset points", xytext=(-9, 6), ha="right")


_STATES: Final = {"pass": COLOURS[2], "unknown": COLOURS[4], "fail": COLOURS[1]}
_MOST_SHOWN: Final = 3.0
"""Largest value over its limit that a bar shows."""


def limits(found: CheckResult, *, ax: Axes | None = None) -> Axes:
    """Draw every value of a check over its limit.

    Parameters
    ----------
    found : CheckResult
        From `electrovib.check`.
    ax : Axes, optional
        Where to draw; a new figure if None.

    Returns
    -------
    Axes
        A bar for each known limit, in the colour of its state: within, of uncertain standing, or exceeded. Bars end at 3.

    Examples
    --------
    >>> ev.plot.limits(ev.check("bau_2010/sine")).get_xlabel()
    'value over its limit'
    """
    rows = [row for row in found.rows if row.margin is not None]
    with drawing(ax, (_WIDTH, 1.2 + _HEIGHT_OF_INPUT * len(rows))) as axes:
        shares = [min(1 / row.margin, _MOST_SHOWN) if row.margin else _MOST_SHOWN for row in rows]
        for state, words in (("pass", "within"), ("unknown", "of uncertain standing"), ("fail", "exceeded")):
            if some := [place for place, row in enumerate(rows) if row.state == state]:
                axes.barh(some, [shares[place] for place in some], color=_STATES[state], label=words)
        axes.set_yticks(range(len(rows)), [row.quantity for row in rows])
        axes.invert_yaxis()
        axes.axvline(1.0, color="#222222", linestyle="--", label="limit")
        axes.grid(visible=False, axis="y")
        axes.set_xlim(0, max(1.1, axes.get_xlim()[1]))
        axes.set_xlabel("value over its limit")
        axes.set_title("Values over their limits")
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
        return axes


_WIDTH: Final = 7.2
_HEIGHT_OF_INPUT: Final = 0.42
"""Height of the two bars of an input [inch]."""
_BAR: Final = 0.36
"""Height of a bar over the distance of the inputs."""


def indices(found: Sensitivity, *, ax: Axes | None = None) -> Axes:
    """Draw the first-order and the total index of every input, with 95 % intervals.

    Parameters
    ----------
    found : Sensitivity
        Result of `electrovib.sensitivity`.
    ax : Axes, optional
        Where to draw; a new figure if None.

    Returns
    -------
    Axes
        The largest total index on top.

    Examples
    --------
    >>> found = ev.sensitivity("bau_2010/sine", "fingers", quantity="mean electrostatic_force", n=8, seed=1)
    >>> ev.plot.indices(found).get_xlabel()
    'Sobol index (lines: 95 % intervals)'
    """
    with drawing(ax, size_of(found)) as axes:
        places = np.arange(len(found.indices), dtype=float)
        kinds = (
            ("total index", -_BAR / 2, COLOURS[0], [(e.total, e.total_interval) for e in found.indices]),
            ("first-order index", _BAR / 2, COLOURS[4], [(e.first, e.first_interval) for e in found.indices]),
        )
        for label, shift, colour, values in kinds:
            numbers = [value for value, _ in values]
            axes.barh(places + shift, numbers, height=_BAR, color=colour, label=label)
            for place, (_, ends) in zip(places + shift, values, strict=True):
                axes.plot(ends, (place, place), color="#222222", linewidth=1.0)
        axes.set_yticks(places, [words_at(found.scenario, each.name) for each in found.indices])
        axes.invert_yaxis()
        axes.grid(visible=False, axis="y")
        axes.set_xlabel("Sobol index (lines: 95 % intervals)")
        axes.set_xlim(left=min(0.0, axes.get_xlim()[0]))
        axes.legend(loc="lower right")
        axes.set_title(f"Variance of {words_at(None, found.quantity)}")
        return axes


def size_of(found: Sensitivity) -> tuple[float, float]:
    """Return width and height of the figure of `indices` [inch]."""
    return _WIDTH, 1.1 + _HEIGHT_OF_INPUT * len(found.indices)


if TYPE_CHECKING:
    _Dashes: TypeAlias = tuple[LineStyleType, LineStyleType]

_SIZE = (6.4, 3.9)
_SOLID: _Dashes = ("-", "-.")
_MANY_POINTS: Final = 60
_BROKEN: _Dashes = ("--", ":")
_DOTTED: _Dashes = (":", (0, (1, 3)))


def panel(panel: Panel, *, ax: Axes | None = None) -> Axes:
    """Draw one figure of a reproduction.

    Parameters
    ----------
    panel : Panel
        Curves, bands and points as data.
    ax : Axes, optional
        Where to draw; a new figure if None.

    Returns
    -------
    Axes
        Data in SI. Curves that are not to be drawn are omitted.

    Examples
    --------
    >>> found = ev.evidence("israr_2006/cylinder", n=4)
    >>> ev.plot.panel(found.document.figures[1]).get_xlabel()
    'frequency of the sine [Hz]'
    """
    with drawing(ax, _SIZE) as axes:
        if panel.log_x:
            axes.set_xscale("log")
        if panel.log_y:
            axes.set_yscale("log")
        shown = [curve for curve in panel.curves if curve.drawn]
        named = {curve.look for curve in shown if curve.upper is None and curve.look is not None}
        named -= {REFERENCE} - {curve.look for curve in shown if curve.kind == "points"}
        known = {panel.y[0]}  # the axis names a curve of this label
        for curve, (colour, dash) in zip(shown, _looks(shown), strict=True):
            is_spread = curve.upper is not None and curve.look in named  # of what its line or points name
            words = curve.background or curve.label
            label = "_nolegend_" if is_spread or words in known else typeset(words)
            known.add(curve.background)
            _draw(axes, curve, colour, dash, label=label, floor=panel.floor)
        finish(axes, x=panel.x, y=panel.y)
        axes.set_title(typeset(panel.title))
        return axes


def _looks(curves: Sequence[Curve]) -> list[tuple[str, LineStyleType]]:
    """Return colour and dash of every curve: that of its look, or else the next of the palette."""
    found = []
    for number, curve in enumerate(curves):
        dashes = {"dashed": _BROKEN, "dotted": _DOTTED}.get(curve.kind, _SOLID)
        turn, place = divmod(number if curve.look is None else curve.look, len(PALETTE))
        reference = curve.look == REFERENCE
        if curve.background:
            found.append((PALE, dashes[0]))
        else:
            found.append((NEUTRAL, dashes[0]) if reference else (PALETTE[place], dashes[turn % len(dashes)]))
    return found


def _draw(
    ax: Axes, curve: Curve, colour: str, dash: LineStyleType, *, label: str, floor: float | None
) -> None:
    """Draw a line, a band or points; what has a single abscissa as a mark or as a bar from end to end."""
    x, y = (np.asarray(values, dtype=float) for values in (curve.x, curve.y))
    if floor is not None:
        y = np.where(y >= floor, y, np.nan)
    if curve.upper is not None:
        upper = np.asarray(curve.upper, dtype=float)
        if x.size == 1:
            ax.vlines(x, y, upper, color=colour, linewidth=6, alpha=0.35, label=label)
            return
        ax.fill_between(x, y, upper, color=colour, alpha=0.22, linewidth=0, label=label)
        for edge in (y, upper):
            ax.plot(x, edge, color=colour, linewidth=0.7)
    elif curve.kind == "points":
        many = (
            x.size > _MANY_POINTS
        )  # samples of a recording: faint, so that the line of a model shows on them
        size, strength = (2.5, 0.35) if many else (4.0, 1.0)
        ax.plot(
            x, y, color=colour, label=label, linestyle="none", marker="o", markersize=size, alpha=strength
        )
    else:
        width, height = (0.8, 1.5) if curve.background else (2.4 if curve.kind == "bold" else None, 2.0)
        mark = "_" if x.size == 1 else ""
        look: Any = {"linewidth": width, "zorder": height, "marker": mark, "markersize": 14}
        ax.plot(*envelope(x, y), color=colour, label=label, linestyle=dash, **look)


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
    from electrovib.view.style import pretty_quantity

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
