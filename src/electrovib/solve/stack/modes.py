"""Real relaxation modes of a stack of dispersive, conducting layers, with nearly full relative accuracy.

Each layer is a sum of Debye terms and a conduction, so its impedance times area is
z(s) = sum residue/(s + rate). The poles of every field under a voltage drive are the zeros of the total
impedance. Both steps are secular equations with positive weights, solved between brackets; an eigenvalue
routine would lose the slow modes by rounding against the fast ones.

A number that differs between cases is a column of shape (cases, 1), and arrays of what depends on it have a leading axis of
cases. A pole that differs has a slot of its own, because the order of the rates differs between cases; poles at a rate
that all cases share have one slot.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.constants import eps0
from electrovib.physics.debye_sum import DebyeSum
from electrovib.solve.stack.secular import Roots, secular_roots
from electrovib.solve.stack.transfer import Column, NotInArraysError, Transfer, row_of, side_by_side, summed

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from electrovib.core.arrays import Indices
    from electrovib.physics.circuit import SeriesElement


@dataclass(frozen=True)
class Slab:
    """A layer as Debye terms and a conductivity; each number may be a column (cases, 1).

    Parameters
    ----------
    thickness : float
        Thickness [m].
    debye : DebyeSum
        Bound permittivity.
    conductivity : float
        Conductivity [S/m]; a column is above 0 in every case.
    charge : float
        Free charge at time 0 on the face towards the finger [C/m2].
    """

    thickness: Column
    debye: DebyeSum
    conductivity: Column
    charge: Column = 0.0


def is_there(number: Column) -> bool:
    """Return whether a number is not 0, in every case or in none."""
    if isinstance(number, np.ndarray) and np.any(number) and not np.all(number):
        raise NotInArraysError("a number that is 0 in some cases gives these fewer modes")
    return bool(np.any(number))


def merged_terms(debye: DebyeSum) -> tuple[Real, Real]:
    """Return relaxation rates [1/s] and strengths [1]; equal shared rates are merged, shared terms of strength 0 omitted.

    Each is (terms,), increasing, or (cases, terms).
    """
    totals: dict[Any, Any] = {}
    terms: list[tuple[Column, Column]] = list(zip(debye.strengths, debye.relaxation_times, strict=True))
    for place, (strength, time) in enumerate(terms):
        if not is_there(strength):
            continue
        if np.ndim(time):
            totals[place, "column"] = 1 / time, strength
        else:
            totals[1 / time] = 1 / time, totals.get(1 / time, (0.0, 0.0))[1] + strength
    merged = sorted(totals.values(), key=_first)
    rates, strengths = ([row_of(each[side]) for each in merged] for side in (0, 1))
    return side_by_side(np.zeros(0), *rates), side_by_side(np.zeros(0), *strengths)


def _first(term: tuple[Column, Column]) -> float:
    """Return the rate of a term, that of the first case."""
    return float(row_of(term[0]).flat[0])


def slab_impedance(slab: Slab) -> tuple[Real, Real]:
    """Return the impedance times area of a slab as sum residue/(s + rate), each (poles,) or (cases, poles)."""
    rates, shares = relaxations(slab.debye, slab.conductivity)
    return rates, slab.thickness / eps0 / shares


def relaxations(debye: DebyeSum, conductivity: Column) -> tuple[Real, Real]:
    """Return the rates of a material's impedance [1/s], and thickness/eps0 over each residue, for any thickness."""
    numbers = (debye.high, *debye.strengths, *debye.relaxation_times, conductivity)
    is_column = any(np.ndim(number) for number in numbers)
    return (_relaxations if is_column else _shared_relaxations)(debye, conductivity)


def _relaxations(debye: DebyeSum, conductivity: Column) -> tuple[Real, Real]:
    nodes, strengths = merged_terms(debye)
    weights = strengths * nodes
    if is_there(conductivity):
        nodes = side_by_side(np.zeros(1), nodes)
        weights = side_by_side(row_of(conductivity / eps0), weights)
    rates, shares = np.zeros(0), np.zeros(0)
    if nodes.shape[-1]:
        lead = np.broadcast_shapes(nodes.shape[:-1], weights.shape[:-1], np.shape(debye.high)[:-1])
        roots = secular_roots(np.broadcast_to(nodes, (*lead, nodes.shape[-1])), weights, constant=debye.high)
        rates, shares = roots.values, roots.values * roots.slope
    if not is_there(conductivity):
        rates = side_by_side(np.zeros(1), rates)
        shares = side_by_side(row_of(debye.high + summed(strengths)), shares)
    return rates, shares


@functools.lru_cache(maxsize=256)
def _shared_relaxations(debye: DebyeSum, conductivity: float) -> tuple[Real, Real]:
    """Return the same for numbers that all cases share, each (poles,), read-only."""
    found = _relaxations(debye, conductivity)
    for array in found:
        array.flags.writeable = False
    return found


def bound_residues(slab: Slab, rates: Real, residues: Real) -> Real:
    """Return the residues of the bound displacement per current density of a slab, shape of `rates` and `residues`."""
    if is_there(slab.conductivity):
        return np.asarray(slab.conductivity * residues / (slab.thickness * rates))
    return np.where(rates == 0, 1.0, 0.0)  # without conduction the displacement is the charge


@dataclass(frozen=True)
class StackModes:
    """Fields of every layer per volt of the drive, over common modes.

    Parameters
    ----------
    rates : ndarray, shape (n,) or (cases, n)
        Rates of all modes [1/s], those excited by the drive first, then those that only charge excites.
    fields, displacements : tuple of Transfer
        Field [V/m] and bound displacement [C/m2] of each layer, per volt.
    current_density : Transfer
        Total current density [A/m2], per volt.
    driven : int
        Number of modes that the drive can excite.
    charges : ndarray, shape (layers + 1,) or (cases, layers + 1)
        Displacement due to the initial charges before each layer, and after the last, at 0 V [C/m2].
    """

    rates: Real
    fields: tuple[Transfer, ...]
    displacements: tuple[Transfer, ...]
    current_density: Transfer
    driven: int
    charges: Real


def stack_modes(
    slabs: Sequence[Slab], *, area: Column, element: SeriesElement, second: Column = 0.0
) -> StackModes:
    """Return the modes of a stack in series with source and return path.

    E_k T_k = z_k V/Z. Charge Q_k, summed over the electrode and the interfaces on the plate's side of part k
    of the circuit, adds z_k (Q_k - sum_j z_j Q_j/Z) to it, and -sum_j z_j Q_j/Z to the current density.
    Before time 0 the plate is at 0 V and carries the image of the charges between the layers, so that the
    voltages across all parts add up to 0 and no current flows initially. A floating body is one more part; it
    is neutral at time 0 unless `SeriesElement.charge` declares a charge.
    """
    parts = _in_series(slabs, area, element, second)
    resistance = area * element.resistance if is_there(element.resistance) else 0.0
    roots = None
    if parts.nodes.shape[-1] > 1 or is_there(resistance):
        lead = np.broadcast_shapes(parts.nodes.shape[:-1], parts.total.shape[:-1], np.shape(resistance)[:-1])
        nodes = np.broadcast_to(parts.nodes, (*lead, parts.nodes.shape[-1]))
        roots = secular_roots(nodes, parts.total, constant=resistance)
    return _assembled(slabs, parts, roots, resistance)


@dataclass(frozen=True)
class _InSeries:
    """Impedances times area as sums over common nodes, z = sum residue/(s + node) + resistance; cases first."""

    nodes: Real  # (nodes,)
    layers: Real  # (layers, nodes), of z_k
    bound: Real  # (layers, nodes), of eps0 eps_pol z_k/T_k: displacement per current
    body: Real  # (nodes,), of the capacitor of the body
    total: Real  # (nodes,), of the whole circuit
    shared: list[int]  # nodes at which more than one part has a pole
    blocks: bool  # whether a part holds back a constant current
    charges: Real  # (layers + 1,), before each layer and after the last
    on_body: Column  # charge of a floating body over the contact area
    has_charge: bool


def _in_series(slabs: Sequence[Slab], area: Column, element: SeriesElement, second: Column) -> _InSeries:
    expanded = [slab_impedance(slab) for slab in slabs]
    all_rates = [rates for rates, _ in expanded]
    has_body = is_there(element.elastance)
    if has_body:
        all_rates.append(row_of(element.rate))
    nodes, places = slots(all_rates)
    count = nodes.shape[-1]
    rows = [spread(residues, mine, count) for (_, residues), mine in zip(expanded, places, strict=False)]
    bound = [
        spread(bound_residues(slab, *each), mine, count)
        for slab, each, mine in zip(slabs, expanded, places, strict=False)
    ]
    body = spread(row_of(area * element.elastance), places[-1], count) if has_body else np.zeros(count)
    layers = stacked(rows)
    total = layers.sum(axis=-2) * (1 + second) + body
    sharing = np.bincount(np.concatenate(places), minlength=count)
    if is_there(second):
        sharing = sharing + np.bincount(np.concatenate(places[: len(slabs)]), minlength=count)
    charges, on_body = [slab.charge for slab in slabs], element.charge / area
    return _InSeries(
        nodes=nodes,
        layers=layers,
        bound=stacked(bound),
        body=body,
        total=total,
        shared=np.flatnonzero(sharing > 1).tolist(),
        blocks=bool(np.any(blocked(nodes))),
        charges=_before_layers(charges, layers, body, on_body),
        on_body=on_body,
        has_charge=any(is_there(each) for each in (*charges, on_body)),
    )


def slots(rates: Sequence[Real]) -> tuple[Real, list[Indices]]:
    """Return common nodes, (nodes,) or (cases, nodes), and the place of each pole of each part among them."""
    shared = [each if each.ndim == 1 else np.zeros(int(np.any(blocked(each)))) for each in rates]
    nodes = np.unique(np.concatenate([np.zeros(0), *shared]))
    columns, places, count = [nodes], [], len(nodes)
    for each in rates:
        if each.ndim == 1:
            places.append(np.searchsorted(nodes, each))
            continue
        own = ~blocked(each)  # a rate of 0 is that of every layer that does not conduct
        places.append(np.where(own, count - 1 + np.cumsum(own), 0))
        columns.append(each[:, own])
        count += int(np.count_nonzero(own))
    return side_by_side(*columns), places


def blocked(rates: Real) -> NDArray[np.bool_]:
    """Return which rates are 0 in every case, (n,)."""
    return np.asarray(np.all(np.atleast_2d(rates) == 0, axis=0))


def spread(values: Real, places: Indices, count: int) -> Real:
    """Return values at places among `count`, (..., count), and 0 elsewhere."""
    found = np.zeros((*values.shape[:-1], count))
    found[..., places] = values
    return found


def stacked(rows: Sequence[Any]) -> Any:
    """Return rows (n,) or (cases, n) as one array (layers, n) or (cases, layers, n)."""
    if all(row.ndim == 1 for row in rows):
        return np.array(rows)
    lead = np.broadcast_shapes(*(row.shape for row in rows))
    return np.stack([np.broadcast_to(row, lead) for row in rows], axis=-2)


def _before_layers(charges: Sequence[Column], layers: Real, body: Real, of_body: Column) -> Real:
    """Return the displacement before each layer and after the last, with the image of the charges on the plate at 0 V."""
    held = np.cumsum(side_by_side(np.zeros(1), *(row_of(each) for each in charges)), axis=-1)
    if not (np.any(held) or np.any(of_body)):
        return held
    # at infinite frequency, before any relaxation
    elastances = side_by_side(layers.sum(axis=-1), row_of(summed(body)))
    on_parts = side_by_side(held[..., :-1], row_of(held[..., -1:] + of_body))
    return np.asarray(held - _column(elastances * on_parts) / _column(elastances))


def _column(rows: Real) -> Real:
    """Return the sum over the last axis, which it keeps."""
    return np.asarray(rows.sum(axis=-1, keepdims=True))


def _over_layers(weights: Real, rows: Real) -> Real:
    """Return sum over layers of weight times row: (..., layers) and (..., layers, n) give (..., n)."""
    return np.asarray((weights[..., :, None] * rows).sum(axis=-2))


def _assembled(
    slabs: Sequence[Slab], parts: _InSeries, roots: Roots | None, resistance: Column
) -> StackModes:
    nothing, shared = np.zeros(0), parts.shared
    driven = nothing if roots is None else roots.values
    inverse = np.zeros((len(nothing), parts.nodes.shape[-1])) if roots is None else 1 / roots.differences()
    forced = nothing if roots is None else -1 / roots.slope  # residues of 1/Z
    rates = side_by_side(driven, parts.nodes[..., shared])
    across = np.swapaxes(inverse, -1, -2)
    drops, bound = -(parts.layers @ across), -(parts.bound @ across)  # z_k at the zeros of Z, (layers, modes)
    thickness = stacked([row_of(slab.thickness) for slab in slabs])
    limit: Any = 0.0
    if not is_there(resistance):
        limit = _column(parts.layers) / _column(parts.total)[..., None, :]
    direct = limit / thickness  # (..., layers, 1)
    left = np.zeros(rates.shape[-1])
    free = bound_free = np.zeros((len(slabs), rates.shape[-1]))
    if parts.has_charge:
        held = parts.charges[..., :-1]  # Q_k
        on_body = parts.charges[..., -1:] + parts.on_body
        of_body = -(parts.body[..., None, :] @ across)[..., 0, :]
        charged = -forced * (_over_layers(held, drops) + on_body * of_body)  # residues of the current
        driving = _over_layers(held, parts.layers[..., shared]) + on_body * parts.body[..., shared]
        idle = held[..., :, None] - (driving / parts.total[..., shared])[..., None, :]
        left = side_by_side(charged, np.zeros(len(shared)))
        charged = charged[..., None, :]
        free = side_by_side(drops * charged, parts.layers[..., shared] * idle) / thickness
        bound_free = side_by_side(bound * charged, parts.bound[..., shared] * idle)
    share = forced[..., None, :]
    gains = _gains(drops * share / thickness, rates[..., None, :])
    instantaneous = [eps0 * slab.debye.high for slab in slabs]
    fields = _each(rates, gains, direct, free, [1.0 for _ in slabs])
    displacements = _each(
        rates, _gains(bound * share, rates[..., None, :]), direct, bound_free, instantaneous
    )
    current = _current(parts, rates, _gains(forced, rates), left, resistance)
    return StackModes(rates, fields, displacements, current, driven.shape[-1], parts.charges)


def _each(
    rates: Real, gains: Real, direct: Real, free: Real, factors: Sequence[Column]
) -> tuple[Transfer, ...]:
    """Return the transfer function of each layer, with a factor of its direct response."""
    found = []
    for place, factor in enumerate(factors):
        instantaneous = direct[..., place, :]
        level = float(instantaneous[0]) if instantaneous.ndim == 1 else instantaneous
        found.append(
            Transfer(rates=rates, gains=gains[..., place, :], direct=level * factor, free=free[..., place, :])
        )
    return tuple(found)


def _gains(residues: Real, rates: Real) -> Real:
    """Return residues over rates for the driven modes, and 0 for the others."""
    driven = residues.shape[-1]
    return side_by_side(residues / rates[..., :driven], np.zeros(rates.shape[-1] - driven))


def _current(parts: _InSeries, rates: Real, gains: Real, free: Real, resistance: Column) -> Transfer:
    """Return the current density; without resistance a part is proportional to the rate of change of the drive."""
    static = 0.0 if parts.blocks else 1 / (resistance + summed(parts.total / parts.nodes))
    if is_there(resistance):
        return Transfer(rates=rates, gains=gains, direct=1 / resistance, free=free, static=static)
    elastance = summed(parts.total)
    return Transfer(
        rates=rates,
        gains=gains,
        direct=summed(parts.total * parts.nodes) / elastance**2,
        slope=1 / elastance,
        free=free,
        static=static,
    )
