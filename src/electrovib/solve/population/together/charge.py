"""Response of the stacks of many fingers to charge at time 0."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.core.arrays import Real
    from electrovib.solve.population.together.series import SeriesParts


class StackCharge:
    """Response of the stacks of many fingers to charge at time 0, as `stack.modes.stack_modes` describes it.

    Parameters
    ----------
    series : SeriesParts
        Layers and body.
    charges : sequence of float or ndarray, shape (fingers,)
        Free charge on the face of each layer towards the finger [C/m2].
    of_body : float or ndarray, shape (fingers,)
        Charge of the body over the contact area [C/m2].

    Attributes
    ----------
    shared : list of int
        Slots where more than one part has a pole.
    """

    def __init__(self, series: SeriesParts, charges: Sequence[Any], of_body: Any) -> None:
        self.series = series
        held = [np.zeros(series.fingers)]
        for charge in charges:
            held.append(held[-1] + charge)
        elastances = [sum(part.residues[1:], start=part.residues[0]) for part in series.parts]
        on_parts = [*held[: len(series.layers)], held[-1] + of_body][: len(series.parts)]
        whole = sum(elastance * on for elastance, on in zip(elastances, on_parts, strict=True))
        image = whole / sum(elastances)
        self.before = [each - image for each in held]
        self.on_parts = [each - image for each in on_parts]
        counts = [sum(slot in mine for mine in series.places) for slot in range(len(series.nodes))]
        self.shared = [slot for slot, count in enumerate(counts) if count > 1]

    @functools.cached_property
    def charged(self) -> Real:
        """Residues of the current density due to charge, shape (roots, fingers)."""
        driving = np.zeros_like(self.series.roots.values)
        for index, (part, on) in enumerate(zip(self.series.parts, self.on_parts, strict=True)):
            driving = driving + on * self.series.of_part(index, part.residues)
        return -driving * self.series.forced

    def left(self, index: int, weights: Sequence[Any]) -> Real:
        """Return amplitudes at time 0 of the response of a layer to charge.

        `weights` (fingers,); returns `left` (modes, fingers).
        """
        series = self.series
        driven = series.of_part(index, weights) * self.charged
        idle = np.zeros((len(self.shared), series.fingers))
        for row, slot in zip(idle, self.shared, strict=True):
            if slot not in series.places[index]:
                continue
            driving = np.zeros(series.fingers)
            for part, mine, on in zip(series.parts, series.places, self.on_parts, strict=True):
                if slot in mine:
                    driving = driving + part.residues[mine.index(slot)] * on
            share = driving / series.total[slot]
            row[:] = weights[series.places[index].index(slot)] * (self.before[index] - share)
        return np.concatenate([driven, idle])

    def delivered(self, interface: int) -> tuple[Real, Real]:
        """Return amplitudes at time 0 of the charge before a layer, and its constant part.

        Returns `left` (roots, fingers) [C/m2], `constant` (fingers,) [C/m2].
        """
        driven = -self.charged / self.series.roots.values
        constant = self.before[interface] - np.add.reduce(driven, axis=0)
        return driven, constant
