"""A stack of dispersive, leaky layers as real modes, with nearly full relative accuracy.

Each layer is a sum of Debye terms and a conduction, so its impedance times area is
z(s) = sum residue/(s + rate). The poles of every field under a voltage drive are the zeros of the whole
impedance. Both steps are secular equations with positive weights, solved between brackets; an eigenvalue
routine would lose the slow modes against the fast ones.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from electrovib.core.constants import VACUUM_PERMITTIVITY as eps0
from electrovib.physics.circuit import SeriesElement
from electrovib.physics.debye_sum import DebyeSum
from electrovib.solve.secular import Roots, secular_roots
from electrovib.solve.transfer import Real, Transfer


@dataclass(frozen=True)
class Slab:
    """A layer ready to be solved.

    Parameters
    ----------
    thickness : float
        m.
    debye : DebyeSum
        Polarisation.
    conductivity : float
        S/m.
    charge : float
        Free charge at time 0 on the face towards the finger [C/m2].
    """

    thickness: float
    debye: DebyeSum
    conductivity: float
    charge: float = 0.0


@dataclass(frozen=True)
class StackModes:
    """Fields of every layer per volt of the drive, over common modes.

    Parameters
    ----------
    rates : ndarray, shape (n,)
        Rates of all modes [1/s], those excited by the drive first, then those only charge excites.
    fields, displacements : tuple of Transfer
        One for each layer, V/m and C/m2 per volt.
    current_density : Transfer
        A/m2 per volt.
    driven : int
        How many of the modes the drive can excite.
    """

    rates: Real
    fields: tuple[Transfer, ...]
    displacements: tuple[Transfer, ...]
    current_density: Transfer
    driven: int


def merged_terms(debye: DebyeSum) -> tuple[Real, Real]:
    """Give relaxation rates, increasing, and strengths; equal rates added, empty terms dropped."""
    totals: dict[float, float] = {}
    for strength, time in zip(debye.strengths, debye.relaxation_times, strict=True):
        if strength > 0:
            totals[1 / time] = totals.get(1 / time, 0.0) + strength
    rates = np.array(sorted(totals))
    return rates, np.array([totals[rate] for rate in rates])


def slab_impedance(slab: Slab) -> tuple[Real, Real]:
    """Expand impedance times area of a slab as sum residue/(s + rate).

    Parameters
    ----------
    slab : Slab
        One layer.

    Returns
    -------
    rates, residues : ndarray
        1/s, increasing, the first 0 if the slab does not conduct; ohm m2/s.
    """
    relaxations, strengths = merged_terms(slab.debye)
    scale = slab.thickness / eps0
    if slab.conductivity > 0:
        nodes = np.concatenate([[0.0], relaxations])
        weights = np.concatenate([[slab.conductivity / eps0], strengths * relaxations])
    else:
        nodes, weights = relaxations, strengths * relaxations
    rates, residues = np.zeros(0), np.zeros(0)
    if len(nodes):
        roots = secular_roots(nodes, weights, slab.debye.high)
        rates, residues = roots.values, scale / (roots.values * roots.slope)
    if slab.conductivity == 0:
        static = slab.debye.high + float(np.sum(strengths))
        rates, residues = np.append(0.0, rates), np.append(scale / static, residues)
    return rates, residues


def stack_modes(slabs: list[Slab], *, area: float, element: SeriesElement, second: float = 0.0) -> StackModes:
    """Solve a stack in series with its surroundings.

    Parameters
    ----------
    slabs : list of Slab
        From the plate to the finger.
    area : float
        Contact area [m2].
    element : SeriesElement
        Source and return path.
    second : float
        First contact area over that of a second, equal stack in the return path; 0 for none.

    Returns
    -------
    StackModes
        Real, non-positive poles.

    Notes
    -----
    E_k T_k = z_k V/Z. Charge Q_k, summed over the interfaces on the plate's side of layer k and put there at
    time 0, adds z_k (Q_k - sum_j z_j Q_j/Z).
    """
    expanded = [slab_impedance(slab) for slab in slabs]
    everything = [rates for rates, _ in expanded]
    if element.elastance > 0:
        everything.append(np.array([element.rate]))
    nodes = np.unique(np.concatenate(everything))
    layers = np.zeros((len(slabs), len(nodes)))
    for row, (rates, residues) in zip(layers, expanded, strict=True):
        row[np.searchsorted(nodes, rates)] = residues
    total = layers.sum(axis=0) * (1 + second)
    sharing = np.count_nonzero(layers, axis=0) * (2 if second else 1)
    if element.elastance > 0:
        total[np.searchsorted(nodes, element.rate)] += area * element.elastance
        sharing[np.searchsorted(nodes, element.rate)] += 1
    resistance = area * element.resistance
    roots = None
    if len(nodes) > 1 or resistance > 0:
        roots = secular_roots(nodes, total, resistance)
    return _assemble(slabs, nodes, layers, total, sharing > 1, resistance, roots)


def _assemble(
    slabs: list[Slab],
    nodes: Real,
    layers: Real,
    total: Real,
    shared: np.ndarray,
    resistance: float,
    roots: Roots | None,
) -> StackModes:
    driven = np.zeros(0) if roots is None else roots.values
    slopes = np.zeros(0) if roots is None else roots.slope
    apart = np.zeros((0, len(nodes))) if roots is None else roots.differences()
    rates = np.concatenate([driven, nodes[shared]])
    idle = np.zeros(int(np.count_nonzero(shared)))
    held = np.concatenate([[0.0], np.cumsum([slab.charge for slab in slabs])[:-1]])  # Q_k
    drops = -(layers @ (1 / apart).T)  # z_k at the zeros of Z, shape (layers, modes)
    charged = held @ drops  # sum_j z_j Q_j there
    trapped = layers[:, shared] * (held[:, None] - (held @ layers[:, shared]) / total[shared])
    limit = np.zeros(len(slabs)) if resistance > 0 else layers.sum(axis=1) / total.sum()
    fields, displacements = [], []
    for k, slab in enumerate(slabs):
        forced = -drops[k] / slopes / slab.thickness
        free = drops[k] * charged / slopes / slab.thickness
        free_idle = trapped[k] / slab.thickness
        direct = float(limit[k]) / slab.thickness
        fields.append(
            Transfer(rates, np.append(forced / driven, idle), direct, 0.0, np.append(free, free_idle))
        )
        bound = _bound(slab, driven, forced, -1 / slopes)
        bound_free = np.append(
            _bound(slab, driven, free, charged / slopes), _bound_idle(slab, nodes[shared], free_idle)
        )
        displacements.append(
            Transfer(rates, np.append(bound / driven, idle), eps0 * slab.debye.high * direct, 0.0, bound_free)
        )
    current = _current(rates, nodes, total, resistance, driven, slopes)
    return StackModes(rates, tuple(fields), tuple(displacements), current, len(driven))


def _bound(slab: Slab, rates: Real, field: Real, current: Real) -> Real:
    """Residues of D from those of E and J: D = eps0 eps_pol E = (J - sigma E)/s, whichever cancels less."""
    conducted = slab.conductivity * field
    relaxations, strengths = merged_terms(slab.debye)
    with np.errstate(divide="ignore", invalid="ignore"):
        polarisation = slab.debye.high + np.sum(
            strengths * relaxations / (relaxations - rates[:, None]), axis=1
        )
        by_field = eps0 * polarisation * field
    by_current = (conducted - current) / rates
    return np.where(np.abs(conducted) <= 0.5 * np.abs(current), by_current, by_field)


def _bound_idle(slab: Slab, rates: Real, field: Real) -> Real:
    """Residues of D at modes in which no outer current flows: sigma E = rate D there."""
    static = eps0 * (slab.debye.high + sum(slab.debye.strengths))
    safe = np.where(rates > 0, rates, 1.0)
    return np.where(rates > 0, slab.conductivity * field / safe, static * field)


def _current(
    rates: Real, nodes: Real, total: Real, resistance: float, driven: Real, slopes: Real
) -> Transfer:
    gains = np.append(-1 / (slopes * driven), np.zeros(len(rates) - len(driven)))
    if resistance > 0:
        return Transfer(rates, gains, 1 / resistance)
    elastance = float(total.sum())
    return Transfer(rates, gains, float(total @ nodes) / elastance**2, 1 / elastance)
