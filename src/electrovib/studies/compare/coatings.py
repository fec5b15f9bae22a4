"""Which of several coatings to take: force for 90 % of the people, margins with the gap open and closed and of the amplifier."""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from electrovib.core.answer import Drawing
from electrovib.core.arrays import Real
from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity
from electrovib.physics.safety import FILM, GAP_CLOSED
from electrovib.scenario import Scenario
from electrovib.scenario.space import read_space
from electrovib.solve.prepare import Prepared
from electrovib.studies.check import CheckResult, checked
from electrovib.studies.check.amplifier import LARGEST, without_its_limits
from electrovib.studies.check.result import ASKED, FAIL, PASS
from electrovib.studies.widths import TYPICAL_FACTORS, law_width, quantile_ranks

SHARE: Final = 0.9
"""Of the people, who have at least the force that is stated."""
PEOPLE, DRAWS, SEED = "fingers", 200, 0
"""Population, number of its fingers that are drawn, and their seed."""
FORCE: Final = "peak electrostatic_force"
OF_PEOPLE: Final = f"force for {100 * SHARE:g} % of the people"
"""What is not in a comparison of stacks in which people do not differ."""
MARGINS: Final = ("gap open", "gap closed", "amplifier")
_SIGNS: Final[tuple[dict[str, Any], ...]] = (
    {"marker": "o", "markersize": 10, "markerfacecolor": "none"},
    {"marker": "s", "markersize": 5},
    {"marker": "^"},
)
MOST: Final = 5
"""Coatings that are compared for people."""


@dataclass(frozen=True, kw_only=True)
class Coating:
    """One coating: `force` over the fingers in ascending order [N], and `check` of the scenario with it."""

    name: str
    layer: str
    force: Real
    check: CheckResult

    @property
    def for_most(self) -> tuple[float, float, float]:
        """Force that 90 % of the fingers have at least, between the ends of its 95 % interval [N]."""
        ranks = quantile_ranks(1 - SHARE, len(self.force))
        low, high = (self.force[min(max(rank, 1), len(self.force)) - 1] for rank in ranks)
        return float(low), float(np.quantile(self.force, 1 - SHARE)), float(high)

    @property
    def margins(self) -> tuple[float, float, float]:
        """Limit over value of the film with the gap open and closed, and of the amplifier; NaN where one is not known."""
        film = f"{FILM}, {self.layer}"
        known = {row.quantity: row.margin for row in self.check.rows if row.margin is not None}
        amplifier = [margin for name, margin in known.items() if name.startswith(ASKED)]
        open_gap = known.get(film, math.nan)
        return open_gap, known.get(film + GAP_CLOSED, open_gap), min(amplifier, default=math.nan)


def coatings_of(cases: dict[str, Scenario], layer: str) -> tuple[Coating, ...]:
    """Compute force and margins of each coating, by the scenario with it."""
    found = []
    for name, case in cases.items():
        space = read_space(case, PEOPLE)
        whole = without_its_limits(case, LARGEST)  # with them every finger would be marched by itself
        force = Prepared(whole, free=space.paths, quantity=[FORCE])(space.draw(SEED, 0, DRAWS))[FORCE]
        if not np.isfinite(force).all():
            raise InputError(
                f"{name}: the force is not known of {np.sum(~np.isfinite(force))} of {DRAWS} fingers"
            )
        found.append(Coating(name=name, layer=layer, force=np.sort(force), check=checked(case)))
    return tuple(sorted(found, key=lambda each: -each.for_most[1]))


def recommended(coatings: Sequence[Coating]) -> list[str]:
    """Recommend one coating with the reason, or say why none is."""
    safe = [each for each in coatings if each.check.state == PASS]
    best = (safe or coatings)[0]
    low, force, high = (format_quantity(each, "N", digits=3) for each in best.for_most)
    margins = ", ".join(f"{name} {_shown(each)}" for name, each in zip(MARGINS, best.margins, strict=True))
    if safe:
        head = f"Take {best.name}: {'the only one' if len(safe) == 1 else 'the most force of those'} within all limits."
    elif all(each.check.state == FAIL for each in coatings):
        head = "Take none: each exceeds a limit."
    else:
        head = "Take none yet: no coating is shown to be safe."
    amplifier = best.check.scenario.circuit.amplifier
    more = " Limits are judged with the finger of the scenario."
    more += " The force is without the limits of the amplifier." if amplifier and amplifier.is_limited else ""
    more += "" if safe else f" It is {best.check.verdict}."
    reason = (
        f"{best.name}, {'chosen' if safe else 'with the most force'}: 90 % of the people have at least {force} ({low} to {high},"
        f" 95 % interval for {DRAWS} drawn fingers). Limit over value: {margins}.{more}"
    )
    more_force = [
        f"{each.name} gives {format_quantity(each.for_most[1], 'N', digits=3)}, but is {each.check.verdict}."
        for each in coatings[: coatings.index(best)]
    ]
    law = type(best.check.scenario.force).__name__
    return [head, reason, *more_force, law_width(law, TYPICAL_FACTORS.get(law)).sentence]


def _shown(margin: float) -> str:
    """Write a margin, or that it is not known."""
    return "not known" if math.isnan(margin) else f"{margin:.3g}"


def coating_figure(coatings: Sequence[Coating]) -> Drawing:
    """Show force and margins."""
    return Drawing(
        id="coatings",
        title=f"{OF_PEOPLE.capitalize()}, and margins",
        plot=functools.partial(_draw, coatings=coatings),
        size=(9.4, 1.5 + 0.55 * len(coatings)),
        caption=f"Left: peak attraction that 90 % of {DRAWS} drawn fingers have at least (dot), and 90 % of the fingers (bar)."
        " Right: limit over value; left of 1 it is exceeded, and what is not known has no sign.",
    )


def _draw(figure: Any, *, coatings: Sequence[Coating]) -> None:
    """Draw the force over the fingers, and the margins, of each coating in its colour."""
    from matplotlib.ticker import EngFormatter

    left, right = figure.subplots(1, 2)
    for place, each in enumerate(coatings):
        force, colour = each.for_most[1], f"C{place}"
        left.plot(np.quantile(each.force, [0.05, 0.95]), [place, place], color=colour, linewidth=5, alpha=0.3)
        left.plot(force, place, "o", color=colour)
        above = {"xytext": (0, 7), "textcoords": "offset points", "ha": "left"}
        left.annotate(format_quantity(force, "N", digits=3), (force, place), **above)
        for margin, sign in zip(each.margins, _SIGNS, strict=True):
            right.plot(margin, place, color=colour, linestyle="none", **sign)
    left.plot([], [], color="#555555", linewidth=5, alpha=0.3, label="90 % of the fingers")
    left.plot([], [], "o", color="#555555", label="90 % have at least")
    left.legend(loc="upper left", bbox_to_anchor=(0.0, -0.25), ncols=2)
    known = [
        not all(map(math.isnan, margins))
        for margins in zip(*(each.margins for each in coatings), strict=True)
    ]
    for name, sign in itertools.compress(zip(MARGINS, _SIGNS, strict=True), known):
        right.plot([], [], color="#555555", label=name, linestyle="none", **sign)
    right.axvline(1.0, color="#222222", linestyle="--", linewidth=1, label="limit")
    right.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    for ax, words in ((left, "peak electrostatic force"), (right, "limit over value")):
        ax.set_xlabel(words)
        ax.set_yticks(range(len(coatings)), [each.name for each in coatings])
        ax.set_ylim(len(coatings) - 0.5, -0.6)
        ax.grid(visible=False, axis="y")
    left.set_xlim(left=0.0)
    left.locator_params(axis="x", nbins=4)
    left.xaxis.set_major_formatter(EngFormatter("N"))
    right.set_xscale("log")
    right.xaxis.set_major_formatter("{x:g}")
