"""Responses over time of linear quantities of many fingers to the drive that they share."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.solve.population.kernels import first_order_hold_many
from electrovib.solve.recursion.hold import hold_weights
from electrovib.solve.stack.section import total_of
from electrovib.solve.stack.transfer import NotInArraysError, Transfer, integral_weight, without_integrators

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence
    from typing import TypeVar

    from electrovib.core.arrays import Complex, Real
    from electrovib.solve.population.drives import Excitation

    K = TypeVar("K")


def respond(transfers: Mapping[K, Transfer], terms: Sequence[tuple[Any, Excitation]]) -> dict[K, Real]:
    """Compute the response of linear quantities to a sum of drives with factors.

    `terms` are factors, 1 or a column (fingers, 1), and drives with common moments; returns rows (fingers, n), or
    (1, n) for what does not differ.
    """
    known: dict[Any, Real] = {}
    found = {}
    for key, transfer in transfers.items():
        total = total_of(
            _driven(transfer if np.ndim(factor) == 0 else transfer * factor, drive, known)
            for factor, drive in terms
        )
        found[key] = total + _left(transfer, terms[0][1]) if np.any(transfer.free) else total
    return found


def some_of(transfers: Mapping[K, Transfer], part: slice) -> dict[K, Transfer]:
    """Return the transfer functions of some fingers; what several have in common stays common."""
    known: dict[int, Any] = {}

    def some(number: Any) -> Any:
        if np.ndim(number) < 2:
            return number
        return known.setdefault(id(number), number[part])

    names = ("rates", "gains", "direct", "slope", "free", "static")
    return {
        key: replace(each, **{name: some(getattr(each, name)) for name in names})
        for key, each in transfers.items()
    }


def joined(parts: Iterable[Real]) -> Real:
    """Return rows of ranges of fingers below each other."""
    found = list(parts)
    return found[0] if len(found) == 1 else np.concatenate(found)


def _rows(*arrays: Real) -> list[Real]:
    """Return arrays (modes,) and (fingers, modes) as arrays of one shape (fingers, modes)."""
    shape = np.broadcast_shapes(*(np.atleast_2d(each).shape for each in arrays))
    return [np.broadcast_to(each, shape) for each in arrays]


def _driven(transfer: Transfer, drive: Excitation, known: dict[Any, Real]) -> Real:
    """Return the response to a drive, without that to charge, shape (fingers or 1, n)."""
    moments, lags = drive.moments, transfer.static is not None
    if moments.settled and np.any(weight := integral_weight(transfer)):
        if drive.mean:
            raise NotInArraysError("the integral of a drive with a mean has no period")
        relaxing = _driven(without_integrators(transfer), drive, known)
        return np.asarray(relaxing + weight * drive.integral)
    at_once = np.atleast_2d(transfer.direct if transfer.static is None else transfer.static)
    rates, gains = _rows(transfer.rates, transfer.gains, at_once * np.ones(transfer.rates.shape[-1]))[:2]
    active = np.any(gains != 0, axis=0)
    rates, gains = rates[:, active], gains[:, active]
    state = sum(
        (gains * each[:, active] for each in _settled(transfer, drive, known)), start=np.zeros(rates.shape)
    )
    if lags:  # gain (x - v) in the place of gain x
        state = state - gains * drive.voltage[0]
    steady = zip(moments.frequencies.tolist(), drive.tones.tolist(), strict=True)
    for frequency, tone in () if moments.settled else steady:
        state = state - gains * (rates * tone / (rates + 2j * np.pi * frequency)).real
    if not (moments.is_straight or np.any(state)):
        found = np.zeros((len(rates), len(moments.outputs)))
    else:
        direct = np.broadcast_to(at_once, (len(rates), 1))[:, 0]
        found = _stepped(drive, rates, gains if lags else gains * rates, direct, state, lags=lags)
        if np.any(transfer.slope):
            found = found + transfer.slope * drive.slopes
    if drive.level:
        found = found + np.atleast_1d(transfer.at(0.0)).real[:, None] * drive.level
    if len(moments.frequencies):
        found = found + in_tones(transfer, moments.frequencies, drive.tones, moments.waves)
    return found


def in_tones(transfer: Transfer, frequencies: Real, tones: Complex, waves: Real) -> Real:
    """Return the response to sines that have always been on, shape (fingers or 1, n).

    `frequencies` (tones,) or (tones, fingers) [Hz]; `tones` (tones,) or (fingers, tones) [V]; `waves` (2 tones, n) or
    (fingers, 2 tones, n), cosines and minus sines at the outputs.
    """
    gain = np.stack([np.atleast_1d(transfer.at(each)) for each in frequencies], axis=1)
    own = gain * tones
    shares = np.concatenate([own.real, own.imag], axis=1)
    return np.asarray(shares @ waves if waves.ndim == 2 else (shares[:, None] @ waves)[:, 0])


def _settled(transfer: Transfer, drive: Excitation, known: dict[Any, Real]) -> list[Real]:
    """Return the states of all modes at the beginning of each repeated part, computed once for modes in common."""
    found = []
    for place, period in enumerate(drive.periods()):
        key = id(transfer.rates), id(drive), place
        if key not in known:
            known[key] = settled_state(np.atleast_2d(transfer.rates), *period)
        found.append(known[key])
    return found


def _left(transfer: Transfer, drive: Excitation) -> Real:
    """Return the response to charge at time 0; in the periodic state only trapped charge remains."""
    rates, free = _rows(transfer.rates, transfer.free)
    left = np.where(rates == 0, free, 0.0) if drive.moments.settled else free
    nothing = replace(drive, row=np.zeros(len(drive.row)))
    return _stepped(nothing, rates, np.zeros(rates.shape), np.zeros(len(rates)), left, lags=False)


def _stepped(
    drive: Excitation, rates: Real, residues: Real, direct: Real, state: Real, *, lags: bool
) -> Real:
    """Return the response of modes to the straight pieces of a drive at its outputs."""
    moments, rises = drive.moments, drive.rises if lags else None
    return first_order_hold_many(
        rates, residues, direct, state, drive.voltage, moments.steps, rises=rises, places=moments.places
    )


def settled_state(rates: Real, lengths: Real, begins: Real, ends: Real) -> Real:
    """Return rate times the state of modes at the beginning of a period, in the periodic state.

    `rates` (...) [1/s], `lengths`, `begins`, `ends` (pieces,).
    """
    positive = np.where(rates > 0, rates, 1.0)  # the drive does not excite trapped charge
    state = np.zeros(rates.shape)
    for length, begin, end in zip(lengths.tolist(), begins.tolist(), ends.tolist(), strict=True):
        decay, first, last = hold_weights(-positive * length)
        state = decay * state + first * begin + last * end
    return np.asarray(state / -np.expm1(-positive * float(np.sum(lengths))))
