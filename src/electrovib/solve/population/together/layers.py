"""Impedances of the layers of many fingers as sums of poles, with one slot for each pole."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.constants import eps0
from electrovib.physics.debye_sum import DebyeSum
from electrovib.solve.population.together.arrays import ManyDebye, flat
from electrovib.solve.population.together.roots import roots_of
from electrovib.solve.stack.modes import Slab, merged_terms, slab_impedance

if TYPE_CHECKING:
    from collections.abc import Sequence


@dataclass(frozen=True, eq=False, kw_only=True)
class ManySlab:
    """A layer as Debye terms and a conductivity, each number shared or one for each finger.

    Parameters
    ----------
    thickness : float or ndarray, shape (fingers,)
        Thickness [m].
    debye : ManyDebye
        Bound permittivity.
    conductivity : float or ndarray, shape (fingers,)
        Conductivity [S/m].
    charge : float or ndarray, shape (fingers,)
        Free charge at time 0 on the face towards the finger [C/m2].
    """

    thickness: Any
    debye: ManyDebye
    conductivity: Any
    charge: Any = 0.0

    @property
    def conducts(self) -> bool:
        """Whether the layer conducts, in every finger whose own numbers do not say otherwise."""
        return isinstance(self.conductivity, np.ndarray) or self.conductivity > 0


@dataclass(frozen=True, eq=False, kw_only=True)
class Poles:
    """Impedance times area of a layer as sum residue/(s + rate).

    Parameters
    ----------
    rates : tuple of float or ndarray, shape (fingers,)
        Rate of each pole, >= 0 [1/s].
    residues : tuple of float or ndarray, shape (fingers,)
        Residue of each pole [ohm m2/s].
    bound : tuple of float or ndarray, shape (fingers,)
        Bound displacement per current density of each pole, as for `slab.bound_residues` [1].
    regular : ndarray of bool, shape (fingers,)
        Fingers whose numbers have this form; false for a conductivity or strength of 0, or equal relaxations.
    """

    rates: tuple[Any, ...]
    residues: tuple[Any, ...]
    bound: tuple[Any, ...]
    regular: Any


def poles_of(slab: ManySlab, fingers: int) -> Poles:
    """Return the poles of a layer."""
    rates, shares, regular = _relaxations(slab, fingers)
    residues = tuple(slab.thickness / eps0 / share for share in shares)
    if slab.conducts:
        bound = tuple(
            slab.conductivity * residue / (slab.thickness * rate)
            for rate, residue in zip(rates, residues, strict=True)
        )
    else:
        bound = tuple(1.0 if isinstance(rate, float) and rate == 0 else 0.0 for rate in rates)
    return Poles(rates=rates, residues=residues, bound=bound, regular=regular)


def _relaxations(slab: ManySlab, fingers: int) -> tuple[tuple[Any, ...], tuple[Any, ...], Any]:
    """Return rates, thickness/eps0 over each residue, and which fingers have this form."""
    debye, sigma = slab.debye, slab.conductivity
    regular = np.ones(fingers, bool)
    if slab.conducts and isinstance(sigma, np.ndarray):
        regular = sigma > 0
    high = flat(debye.high)
    strengths, times = (
        [flat(each) for each in debye.strengths],
        [flat(each) for each in debye.relaxation_times],
    )
    if not any(isinstance(each, np.ndarray) for each in (high, sigma, *strengths, *times)):
        known = DebyeSum(high, tuple(strengths), tuple(times))
        rates, residues = slab_impedance(Slab(1.0, known, sigma))
        shares = 1 / eps0 / residues
        return tuple(rates.tolist()), tuple(shares.tolist()), regular
    if not strengths:
        return ((sigma / eps0 / high) if slab.conducts else 0.0,), (high,), regular
    return _of_relaxing(slab, high, strengths, times, regular)


def _of_relaxing(
    slab: ManySlab, high: Any, strengths: list[Any], times: list[Any], regular: Any
) -> tuple[tuple[Any, ...], tuple[Any, ...], Any]:
    """Return the same for relaxations of which some number differs between fingers."""
    if not any(isinstance(each, np.ndarray) for each in times):
        if not any(isinstance(each, np.ndarray) for each in strengths):
            slow, strong = merged_terms(DebyeSum(1.0, tuple(strengths), tuple(times)))
            strengths, times = strong.tolist(), (1 / slow).tolist()
        else:
            strengths, times = _merged(strengths, times)
    count = len(regular)
    begin = int(slab.conducts)
    nodes, weights = np.empty((2, begin + len(times), count))
    for row, heavy, strength, time in zip(nodes[begin:], weights[begin:], strengths, times, strict=True):
        row[:], heavy[:] = 1 / time, strength / time
    regular = regular & np.all(weights[begin:] > 0, axis=0)
    if slab.conducts:
        nodes[0], weights[0] = 0.0, slab.conductivity / eps0
    found, apart = roots_of(nodes, weights, np.broadcast_to(high, count), regular)
    rates, shares = list(found.values), list(found.values * found.slope)
    if not slab.conducts:
        rates.insert(0, 0.0)
        shares.insert(0, sum(strengths, start=high))
    return tuple(rates), tuple(shares), regular & apart


def _merged(strengths: list[Any], times: list[float]) -> tuple[list[Any], list[Any]]:
    """Merge relaxations of equal shared times."""
    totals: dict[float, Any] = {}
    for strength, time in zip(strengths, times, strict=True):
        totals[time] = totals[time] + strength if time in totals else strength
    return list(totals.values()), list(totals)


def common_slots(parts: Sequence[Poles]) -> tuple[list[Any], list[list[int]]]:
    """Collect the poles of parts in series; poles at the same shared rate have one slot."""
    rates: list[Any] = []
    known: dict[float, int] = {}
    places = []
    for part in parts:
        mine = []
        for rate in part.rates:
            shared = isinstance(rate, float)
            place = known.get(rate, len(rates)) if shared else len(rates)
            if place == len(rates):
                rates.append(rate)
                if shared:
                    known[rate] = place
            mine.append(place)
        places.append(mine)
    return rates, places
