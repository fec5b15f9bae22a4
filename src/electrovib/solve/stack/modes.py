"""Real relaxation modes of a stack of dispersive, conducting layers, with nearly full relative accuracy.

Each layer is a sum of Debye terms and a conduction, so its impedance times area is
z(s) = sum residue/(s + rate). The poles of every field under a voltage drive are the zeros of the total
impedance. Both steps are secular equations with positive weights, solved between brackets; an eigenvalue
routine would lose the slow modes by rounding against the fast ones.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.constants import eps0
from electrovib.solve.stack.few_poles import Roots
from electrovib.solve.stack.secular import secular_roots
from electrovib.solve.stack.slab import Slab, bound_residues, slab_impedance
from electrovib.solve.stack.transfer import Transfer

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.physics.circuit import SeriesElement


@dataclass(frozen=True)
class StackModes:
    """Fields of every layer per volt of the drive, over common modes.

    Parameters
    ----------
    rates : ndarray, shape (n,)
        Rates of all modes [1/s], those excited by the drive first, then those that only charge excites.
    fields, displacements : tuple of Transfer
        Field [V/m] and bound displacement [C/m2] of each layer, per volt.
    current_density : Transfer
        Total current density [A/m2], per volt.
    driven : int
        Number of modes that the drive can excite.
    charges : ndarray, shape (layers + 1,)
        Displacement due to the initial charges before each layer, and after the last, at 0 V [C/m2].
    """

    rates: Real
    fields: tuple[Transfer, ...]
    displacements: tuple[Transfer, ...]
    current_density: Transfer
    driven: int
    charges: Real


def stack_modes(slabs: list[Slab], *, area: float, element: SeriesElement, second: float = 0.0) -> StackModes:
    """Return the modes of a stack in series with source and return path.

    E_k T_k = z_k V/Z. Charge Q_k, summed over the electrode and the interfaces on the plate's side of part k
    of the circuit, adds z_k (Q_k - sum_j z_j Q_j/Z) to it, and -sum_j z_j Q_j/Z to the current density.
    Before time 0 the plate is at 0 V and carries the image of the charges between the layers, so that the
    voltages across all parts add up to 0 and no current flows initially. A floating body is one more part; it
    is neutral at time 0 unless `SeriesElement.charge` declares a charge.
    """
    expansion = _expand(slabs, area, element, second)
    nodes, resistance = expansion.nodes, expansion.resistance
    roots = (
        secular_roots(nodes, expansion.total, constant=resistance)
        if len(nodes) > 1 or resistance > 0
        else None
    )
    return _assemble(slabs, expansion, roots)


@dataclass(frozen=True)
class _Expansion:
    """Impedances times area as sums over common nodes, z = sum residue/(s + node) + resistance."""

    nodes: Real
    layers: Real  # (layers, nodes), of z_k
    bound: Real  # (layers, nodes), of eps0 eps_pol z_k/T_k: displacement per current
    total: Real  # (nodes,), of the whole circuit
    body: Real  # (nodes,), of the capacitor of the body
    shared: NDArray[np.bool_]  # (nodes,), where more than one part has a pole
    resistance: float
    charges: Real  # (layers + 1,), before each layer and after the last
    of_body: float  # charge of a floating body over the contact area


def _expand(slabs: list[Slab], area: float, element: SeriesElement, second: float) -> _Expansion:
    expanded = [slab_impedance(slab) for slab in slabs]
    everything = [rates for rates, _ in expanded]
    if element.elastance > 0:
        everything.append(np.array([element.rate]))
    nodes = np.unique(np.concatenate(everything))
    layers, bound = np.zeros((2, len(slabs), len(nodes)))
    for k, (slab, (rates, residues)) in enumerate(zip(slabs, expanded, strict=True)):
        places = np.searchsorted(nodes, rates)
        layers[k, places] = residues
        bound[k, places] = bound_residues(slab, rates, residues)
    body = np.zeros(len(nodes))
    sharing = np.count_nonzero(layers, axis=0) * (2 if second else 1)
    if element.elastance > 0:
        place = np.searchsorted(nodes, element.rate)
        body[place] = area * element.elastance
        sharing[place] += 1
    total = layers.sum(axis=0) * (1 + second) + body
    charges = _charges(slabs, layers, body, element.charge / area)
    return _Expansion(
        nodes,
        layers,
        bound,
        total,
        body,
        sharing > 1,
        area * element.resistance,
        charges,
        element.charge / area,
    )


def _charges(slabs: list[Slab], layers: Real, body: Real, of_body: float) -> Real:
    """Return the displacement before each layer and after the last, with the image of the charges on the plate at 0 V."""
    held = np.concatenate([[0.0], np.cumsum([slab.charge for slab in slabs])])
    if not (np.any(held) or of_body):
        return held
    elastances = np.append(layers.sum(axis=1), body.sum())  # at infinite frequency, before any relaxation
    on_parts = held + np.append(np.zeros(len(slabs)), of_body)
    return np.asarray(held - float(elastances @ on_parts) / float(elastances.sum()))


def _assemble(slabs: list[Slab], expansion: _Expansion, roots: Roots | None) -> StackModes:
    nodes, shared = expansion.nodes, expansion.shared
    driven = np.zeros(0) if roots is None else roots.values
    slopes = np.zeros(0) if roots is None else roots.slope
    apart = np.zeros((0, len(nodes))) if roots is None else roots.differences()
    rates = np.concatenate([driven, nodes[shared]])
    held = expansion.charges[:-1]  # Q_k
    on_body = expansion.charges[-1] + expansion.of_body
    drops = -(expansion.layers @ (1 / apart).T)  # z_k at the zeros of Z, shape (layers, modes)
    bound = -(expansion.bound @ (1 / apart).T)
    forced = -1 / slopes  # residues of 1/Z
    driving = held @ drops - on_body * (expansion.body @ (1 / apart).T)
    charged = -driving * forced  # residues of the current due to initial charge
    driving = held @ expansion.layers[:, shared] + on_body * expansion.body[shared]
    shares = driving / expansion.total[shared]
    limit = expansion.layers.sum(axis=1) / expansion.total.sum() * (expansion.resistance == 0)
    thickness = np.array([[slab.thickness] for slab in slabs])
    idle = held[:, None] - shares
    direct = limit / thickness[:, 0]
    at_once = direct * np.array([eps0 * slab.debye.high for slab in slabs])
    gains, bound_gains = _gains(drops * forced / thickness, rates), _gains(bound * forced, rates)
    free = np.hstack([drops * charged, expansion.layers[:, shared] * idle]) / thickness
    bound_free = np.hstack([bound * charged, expansion.bound[:, shared] * idle])
    fields = _each(rates, gains, direct, free)
    displacements = _each(rates, bound_gains, at_once, bound_free)
    free = np.append(charged, np.zeros(len(rates) - len(driven)))
    current = _current(expansion, rates, _gains(forced, rates), free)
    charges = expansion.charges
    return StackModes(rates, tuple(fields), tuple(displacements), current, len(driven), charges)


def _each(rates: Real, gains: Real, direct: Real, free: Real) -> list[Transfer]:
    """Return the transfer function of each layer."""
    return [
        Transfer(rates=rates, gains=row, direct=at_once, free=left)
        for row, at_once, left in zip(gains, direct.tolist(), free, strict=True)
    ]


def _gains(residues: Real, rates: Real) -> Real:
    """Return residues over rates for the driven modes, and 0 for the others."""
    driven = residues.shape[-1]
    gains = np.zeros((*residues.shape[:-1], len(rates)))
    gains[..., :driven] = residues / rates[:driven]
    return gains


def _current(expansion: _Expansion, rates: Real, gains: Real, free: Real) -> Transfer:
    """Return the current density; without resistance a part is proportional to the rate of change of the drive."""
    nodes, total, resistance = expansion.nodes, expansion.total, expansion.resistance
    static = 1 / (resistance + float(np.sum(total / nodes))) if nodes.all() else 0.0
    if resistance > 0:
        return Transfer(rates=rates, gains=gains, direct=1 / resistance, slope=0.0, free=free, static=static)
    elastance = float(total.sum())
    return Transfer(
        rates=rates,
        gains=gains,
        direct=float(total @ nodes) / elastance**2,
        slope=1 / elastance,
        free=free,
        static=static,
    )
