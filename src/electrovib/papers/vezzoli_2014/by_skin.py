"""Figures 6 and 7 for every skin, and for the Maxwell stress in leaky gaps, computed once for rows, tables and figures."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from electrovib.core.answer import Table
from electrovib.papers.vezzoli_2014 import compute, values
from electrovib.physics.skin import time_constant

if TYPE_CHECKING:
    from electrovib.physics.material import Material
    from electrovib.physics.tabulated import Tabulated


@dataclass(frozen=True)
class TrapeziumForce:
    """Figure 6 with one skin, or with the Maxwell stress in a leaky gap.

    `force` is the peak attraction with the ramp taken here [N], `ramp` the one that would give the paper's
    2.5 mN of attraction [s], `edges` the attraction after the falling edge over that after the rising edge.
    """

    name: str
    force: float
    ramp: float
    edges: float


@dataclass(frozen=True)
class Shape:
    """Figure 7 with one skin: F(10 kHz)/F(100 Hz), F(10 kHz)/largest F and F(5 kHz)/F(10 kHz)."""

    rise: float
    saturation: float
    before: float

    @property
    def words(self) -> str:
        """Verdict on this skin: begins with ``consistent`` or ``open``."""
        if self.rise < 1:
            return "open, falls"
        if self.rise < 1.2:
            return "open, flat"
        if self.saturation < 0.9:
            return "open, peaks and falls again"
        if self.before < 0.95:
            return "open, still rising at 10 kHz"
        return "consistent, rises and saturates"


def shape_of(material: Material) -> Shape:
    """Compute rise and saturation of figure 7 for a skin."""
    return Shape(*compute.rise_and_saturation(material))


@functools.cache
def figure_6() -> tuple[TrapeziumForce, ...]:
    """Compute figure 6 for every skin under the causal law, and for the Maxwell stress in leaky gaps."""
    return tuple(
        TrapeziumForce(
            name,
            compute.peak_force(case, ramp=values.RAMP),
            compute.ramp_for(case, force=values.FORCE_MODEL),
            compute.edge_ratio(case),
        )
        for name, case in compute.figure_6_cases().items()
    )


def cited() -> tuple[TrapeziumForce, ...]:
    """Return the results of figure 6 under law (1) for the skins of other publications."""
    own = {compute.POINT_BY_FORCE, values.skins()["point"].name, *compute.LEAKY_GAPS}
    return tuple(case for case in figure_6() if case.name not in own)


def leaky() -> tuple[TrapeziumForce, ...]:
    """Return the results of figure 6 for the Maxwell stress in leaky gaps."""
    return tuple(case for case in figure_6() if case.name in compute.LEAKY_GAPS)


@functools.cache
def figure_7() -> dict[str, Shape]:
    """Compute figure 7 for every skin that may predict a force."""
    return {name: shape_of(skin.material) for name, skin in compute.force_skins().items()}


def tables(own: Tabulated | None) -> tuple[Table, ...]:
    """Return the results for every skin, and the source status of every skin."""
    return _results(own), _skins(own)


def _results(own: Tabulated | None) -> Table:
    shapes: Mapping[str, Shape] = figure_7()
    skins, lines = compute.force_skins(), []
    for case in figure_6():
        numbers = (f"{case.force / 1e-3:.3g}", f"{case.ramp / 1e-3:.3g}", f"{case.edges:.3g}")
        skin = skins.get(case.name)
        lines.append((case.name, skin.status if skin else "", *numbers, *_shown(shapes.get(case.name))))
    if own is not None:
        lines.append(("your table", "your own", "", "", "", *_shown(shape_of(own))))
    headings = (
        "skin or leaky gap",
        "source status",
        "peak attraction [mN]",
        "ramp for 2.5 mN [ms]",
        "falling/rising",
        "figure 7: rise",
        "saturation",
        "verdict",
    )
    caption = (
        "Figure 6 with ramps of 36 ms and a hold of 100 ms. Figure 7: rise = F(10 kHz)/F(100 Hz), saturation = F(10 kHz)/largest"
        " F. Sources, notes and time constants: skins.csv"
    )
    return Table("Figures 6 and 7 by skin", headings, tuple(lines), caption=caption, id="by_skin")


def _shown(shape: Shape | None) -> tuple[str, str, str]:
    return ("", "", "") if shape is None else (f"{shape.rise:.3g}", f"{shape.saturation:.2f}", shape.words)


def _skins(own: Tabulated | None) -> Table:
    lines = [
        (skin.name, key, *_taus(skin.material), skin.status, skin.note)
        for key, skin in compute.all_skins().items()
    ]
    if own is not None:
        lines.append(("your table", own.file, *_taus(own), "your own", ""))
    headings = ("skin", "path", "tau at 100 Hz [ms]", "1 kHz", "10 kHz", "source status", "note")
    return Table("Skins", headings, tuple(lines), id="skins", on_page=False)


def _taus(material: Material) -> list[str]:
    return [f"{float(time_constant(material, frequency)) / 1e-3:.3g}" for frequency in (100.0, 1e3, 1e4)]
