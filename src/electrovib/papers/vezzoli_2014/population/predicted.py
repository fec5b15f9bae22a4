"""Distributions of the lateral force of figure 6 over a population of fingers, and what its spread is due to."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.units import parse_quantity
from electrovib.papers.vezzoli_2014 import values
from electrovib.papers.vezzoli_2014.population import closed_forms as forms
from electrovib.papers.vezzoli_2014.scenarios import scenarios
from electrovib.scenario.space import Space, read_space
from electrovib.scenario.space.shipped import read_shipped
from electrovib.studies.sensitivity import Indices, sobol

SEED: Final = 2014
SUBJECTS: Final = 8
"""Of the paper."""
_GROUPS_OF_SUBJECTS: Final = 1000
_DRAWS: Final = 2048
_OF_FIGURE_6: Final = (forms.SKIN, forms.PERMITTIVITY, forms.GAP, forms.FRICTION)
_NOMINAL_GAP: Final = 1e-6
"""Gap at which the leak has the time constant of the skin [m]."""


@dataclass(frozen=True, kw_only=True)
class Predicted:
    """The lateral force of figure 6 over a population, under one law.

    `force` of random fingers (n,) [N], n a multiple of `SUBJECTS`; `indices` are the Sobol indices of the
    inputs of `space`.
    """

    law: str
    space: Space
    force: Real
    indices: Indices

    @property
    def spread(self) -> float:
        """Largest over smallest force of `of_subjects`."""
        smallest, largest = self.of_subjects
        return largest / smallest

    @property
    def central(self) -> tuple[float, float]:
        """Quantiles 5 and 95 % [N]."""
        low, high = np.quantile(self.force, [0.05, 0.95])
        return float(low), float(high)

    @property
    def of_subjects(self) -> tuple[float, float]:
        """Smallest and largest force among as many subjects as the paper has, medians over many such groups [N]."""
        groups = self.force.reshape(-1, SUBJECTS)
        return float(np.median(groups.min(axis=1))), float(np.median(groups.max(axis=1)))

    @property
    def shares(self) -> dict[str, tuple[float, float]]:
        """Name of each input to its first-order and its total index."""
        pairs = zip(self.indices.first.tolist(), self.indices.total.tolist(), strict=True)
        return dict(zip(self.space.inputs, pairs, strict=True))


@functools.cache
def predicted(group: str = "") -> tuple[Predicted, Predicted]:
    """Compute the distributions from one population under law (1) and with the Maxwell stress in the gap.

    `group` is ``dry`` or ``moist`` for these fingers alone; all if empty.
    """
    return (
        _predicted("law (1)", population("fig6", group), forms.lateral_by_law),
        _predicted("Maxwell stress in the gap", population("fig6_gap", group), forms.lateral_in_gap),
    )


def _predicted(law: str, space: Space, function: Callable[[Mapping[str, Real]], Real]) -> Predicted:
    drawn = space.draw(SEED, 0, SUBJECTS * _GROUPS_OF_SUBJECTS)
    return Predicted(
        law=law,
        space=space,
        force=function(drawn),
        indices=sobol(space, function, n=_DRAWS, seed=SEED),
    )


def population(figure: str, group: str = "") -> Space:
    """Return the population `fingers` for a scenario of the paper, at the printed contact area.

    `figure` is ``fig6``, ``fig6_gap`` or ``fig7``; `group` as for `predicted`. A leaky gap has in each group
    of moisture the distribution of time constants that the stratum corneum has, at a permittivity of 1560: a
    choice, because no source gives its resistivity.
    """
    shipped = read_shipped("fingers")
    groups = {
        label: {"share": group["share"], "space": _conductivities(group["space"], leaks=figure == "fig6_gap")}
        for label, group in shipped["groups"]["moisture"].items()
    }
    tables: dict[str, Any] = {
        "space": {path: shipped["space"][path] for path in _OF_FIGURE_6},
        "groups": {} if group else {"moisture": groups},
    }
    if group:
        tables["space"] |= groups[group]["space"]
    if figure == "fig7":
        tables["groups"]["sex"] = shipped["groups"]["sex"]
    return read_space(scenarios()[figure], tables)


def _conductivities(table: Mapping[str, Any], *, leaks: bool) -> dict[str, Any]:
    """Return the conductivity of the stratum corneum in a group, and that of a leaky gap with the same time constants."""
    skin = table[forms.CONDUCTIVITY]
    if not leaks:
        return {forms.CONDUCTIVITY: skin}
    ratio = values.FILM_PERMITTIVITY * _NOMINAL_GAP / values.FILM_THICKNESS  # C_i/C_g
    factor = (1 + ratio) / values.SKIN_PERMITTIVITY
    ends = {name: factor * parse_quantity(skin[name], "S/m") for name in ("low", "high")}
    return {forms.CONDUCTIVITY: skin, forms.LEAK: {"model": "LogUniform", **ends}}
