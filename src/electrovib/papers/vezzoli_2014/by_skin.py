"""What every skin and plane gives for figures 6 and 7, computed once: for rows, tables and figures."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from electrovib.papers.vezzoli_2014 import compute, values
from electrovib.physics.skin import time_constant
from electrovib.study.reproduction import Table

if TYPE_CHECKING:
    from electrovib.physics.material import Material
    from electrovib.physics.tabulated import Tabulated


@dataclass(frozen=True)
class TrapeziumForce:
    """What one skin or plane makes of figure 6.

    Parameters
    ----------
    name : str
        Of the skin or plane.
    force : float
        Peak attraction with the ramp taken here [N].
    ramp : float
        Ramp that would give the paper's 2.5 mN of attraction [s].
    edges : float
        Attraction after the falling edge over that after the rising edge.
    """

    name: str
    force: float
    ramp: float
    edges: float


@dataclass(frozen=True)
class Shape:
    """What one skin makes of figure 7.

    Parameters
    ----------
    rise, saturation, before : float
        F(10 kHz)/F(100 Hz), F(10 kHz)/largest F, F(5 kHz)/F(10 kHz).
    """

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
    """Measure figure 7 on a skin."""
    return Shape(*compute.rise_and_saturation(material))


@functools.cache
def figure_6() -> tuple[TrapeziumForce, ...]:
    """Compute figure 6 for every skin under the causal law, and for leaky gaps cut in the gap."""
    return tuple(
        TrapeziumForce(
            name,
            compute.peak_force(case, ramp=values.RAMP),
            compute.ramp_for(case, force=values.FORCE_MODEL),
            compute.edge_ratio(case),
        )
        for name, case in compute.figure_6_cases().items()
    )


@functools.cache
def figure_7() -> dict[str, Shape]:
    """Compute figure 7 for every skin that may predict a force."""
    return {name: shape_of(skin.material) for name, skin in compute.force_skins().items()}


def tables(own: Tabulated | None) -> tuple[Table, ...]:
    """Give what each skin and plane gives, and how far each skin can be believed."""
    return _results(own), _skins(own)


def _results(own: Tabulated | None) -> Table:
    shapes: Mapping[str, Shape] = figure_7()
    lines = []
    for case in figure_6():
        numbers = (f"{case.force / 1e-3:.3g}", f"{case.ramp / 1e-3:.3g}", f"{case.edges:.3g}")
        lines.append((case.name, *numbers, *_shown(shapes.get(case.name))))
    if own is not None:
        lines.append(("your table", "-", "-", "-", *_shown(shape_of(own))))
    headings = (
        "skin or plane",
        "peak attraction, ramp of 36 ms [mN]",
        "ramp for 2.5 mN [ms]",
        "force falling/rising",
        "figure 7: rise",
        "saturation",
        "verdict on this skin",
    )
    caption = (
        "Figure 6: 0 to 1000 V on the printed film, hold of 100 ms, neither ramp nor hold printed. Figure 7: rise ="
        " F(10 kHz)/F(100 Hz), saturation = F(10 kHz)/largest F, on a coating of 1 um with eps 3.9, not printed."
    )
    return Table("What every skin and plane gives", headings, tuple(lines), caption=caption)


def _shown(shape: Shape | None) -> tuple[str, str, str]:
    return ("-", "-", "-") if shape is None else (f"{shape.rise:.3g}", f"{shape.saturation:.2f}", shape.words)


def _skins(own: Tabulated | None) -> Table:
    lines = [
        (skin.name, key, *_taus(skin.material), skin.status, skin.note)
        for key, skin in compute.all_skins().items()
    ]
    if own is not None:
        lines.append(("your table", own.file, *_taus(own), "your own", ""))
    headings = ("skin", "path", "tau 100 Hz [ms]", "1 kHz", "10 kHz", "source status", "what it is")
    return Table("The skins used, and how far each can be believed", headings, tuple(lines))


def _taus(material: Material) -> list[str]:
    return [f"{float(time_constant(material, frequency)) / 1e-3:.3g}" for frequency in (100.0, 1e3, 1e4)]
