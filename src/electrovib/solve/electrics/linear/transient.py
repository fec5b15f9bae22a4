"""Response over time: exact for straight pieces and sines at any output times, from rest or a given state."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

import numpy as np

from electrovib.physics.drive.parts import Chirped, Part, Smooth, Tones
from electrovib.solve.electrics.linear.break_states import periodic_state
from electrovib.solve.electrics.linear.chirp import chirp_response
from electrovib.solve.electrics.linear.smooth import smooth_states
from electrovib.solve.electrics.linear.straight import chunks, straight_lag, straight_response
from electrovib.solve.stack.harmonics import count_harmonics
from electrovib.solve.stack.integrator import (
    integral_weight,
    refuse_unrepeated,
    settled_integral,
    without_integrators,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Complex, Real
    from electrovib.physics.drive.base import Drive
    from electrovib.solve.stack.transfer import Transfer

K = TypeVar("K")


def transient(
    transfers: Mapping[K, Transfer], drive: Drive, time: Real, *, settled: bool = False
) -> dict[K, Real]:
    """Response of linear quantities to a drive.

    Parameters
    ----------
    transfers : mapping of Key to Transfer
        What to compute.
    drive : Drive
        Off before time 0 when starting from rest.
    time : ndarray, shape (n,)
        Increasing, >= 0 [s]; need not be even.
    settled : bool
        Start from the periodic state instead of rest: the drive has been repeating for ever.

    Returns
    -------
    dict of Key to ndarray, shape (n,)
        At a jump of the drive the value after it.

    Raises
    ------
    InputError
        If the drive has no period but its periodic state is asked for, or has a mean that something integrates.

    Notes
    -----
    x' = rate (v - x) for each mode; y = direct v + slope v' + sum gain x + sum free exp(-rate t). Where the
    response at zero frequency is known apart, y = static v + slope v' + sum gain (x - v) + ...: a small current
    is then not the difference of two large ones. From rest an integrator is exact as one more slow mode; in the
    periodic state its charge is counted from its own mean, because a constant charge is not known from the drive.
    """
    if settled:
        refuse_unrepeated(drive)
    weights = {name: integral_weight(transfer) for name, transfer in transfers.items()} if settled else {}
    if any(weights.values()):
        integral = settled_integral(drive, time)
        fading = {name: without_integrators(transfer) for name, transfer in transfers.items()}
        rest = transient(fading, drive, time, settled=True)
        return {name: row + weights[name] * integral for name, row in rest.items()}
    result: dict[K, Real] = {}
    voltage = drive.voltage(time)
    slope = drive.slope(time) if any(transfer.slope for transfer in transfers.values()) else None
    for names, rates, lag in _groups(transfers):
        gains = np.array([transfers[name].gains for name in names])
        free = np.array([transfers[name].free for name in names])
        modal = np.zeros((len(names), len(time)))
        active = np.any(gains != 0, axis=0) & (rates > 0)
        if np.any(active):
            respond = part_lag if lag else _part_response
            for part in drive.parts():
                modal += respond(part, rates[active], gains[:, active], time, settled=settled)
        kept = free * (rates == 0) if settled else free  # only trapped charge outlasts for ever
        if np.any(kept):
            modal += kept @ np.exp(-np.outer(rates, time))
        for name, row in zip(names, modal, strict=True):
            transfer = transfers[name]
            result[name] = row + (transfer.at_rest() if lag else transfer.direct) * voltage
            if transfer.slope and slope is not None:
                result[name] = result[name] + transfer.slope * slope
    return result


def how_it_begins(drive: Drive, *, settled: bool) -> str:
    """Say from which state a drive begins, and that its parts are exact."""
    count = count_harmonics(drive) if settled else None
    how = f"its {count} harmonics exactly" if count else "straight pieces and sines exactly"
    return f"from {'the periodic state' if settled else 'rest'}, {how}"


def _groups(transfers: Mapping[K, Transfer]) -> list[tuple[list[K], Real, bool]]:
    """Collect quantities with the same modes, so that they are marched once; those as lag x - v apart."""
    groups: list[tuple[list[K], Real, bool]] = []
    for name, transfer in transfers.items():
        lag = transfer.static is not None
        for names, rates, lags in groups:
            if lags == lag and np.array_equal(rates, transfer.rates):
                names.append(name)
                break
        else:
            groups.append(([name], transfer.rates, lag))
    return groups


def _part_response(part: Part, rates: Real, gains: Real, time: Real, *, settled: bool) -> Real:
    if isinstance(part, Tones):
        return _tones(part, rates, gains, time, settled=settled)
    if isinstance(part, Chirped):
        return chirp_response(part, rates, gains, time)
    if isinstance(part, Smooth):
        return gains @ smooth_states(part, rates, time)
    if settled and part.is_step:
        return np.outer(gains.sum(axis=1), np.full(len(time), part.after[0]))
    start = periodic_state(part, rates) if settled else np.zeros(len(rates))
    return straight_response(part, rates, gains, time, start)


def part_lag(part: Part, rates: Real, gains: Real, time: Real, *, settled: bool) -> Real:
    """Response of modes to a part of a drive, less that part.

    Parameters
    ----------
    part : Linear, Tones or Smooth
        The part.
    rates, gains, time
        As for `straight_response`: 1/s, 1, s.
    settled : bool
        In the periodic state instead of from rest.

    Returns
    -------
    ndarray, shape (outputs, n)
        sum gain (x - v), V.
    """
    if isinstance(part, Tones):
        return _tones(part, rates, gains, time, settled=settled, lag=True)
    if isinstance(part, Chirped):
        return chirp_response(part, rates, gains, time, lag=True)
    if isinstance(part, Smooth):
        return gains @ (smooth_states(part, rates, time) - part.value(time))
    if settled and part.is_step:
        return np.zeros((len(gains), len(time)))
    start = periodic_state(part, rates) if settled else np.zeros(len(rates))
    return straight_lag(part, rates, gains, time, start)


def _tones(part: Tones, rates: Real, gains: Real, time: Real, *, settled: bool, lag: bool = False) -> Real:
    """Steady state of each tone, minus what it had to be at the switching times, decaying since."""
    angular = 2 * np.pi * part.frequencies
    response = np.asarray(rates[:, None] / (rates[:, None] + 1j * angular), complex)  # of mode to tone
    steady_response = -1j * angular / (rates[:, None] + 1j * angular) if lag else response
    steady = np.zeros((len(gains), len(time)))
    start = part.start if settled and np.isinf(part.start) else max(part.start, 0.0)
    on = (time >= start) & (time < part.stop)
    for tone, amplitude in enumerate(part.amplitudes):
        wave = amplitude * np.exp(1j * angular[tone] * time)
        steady += np.where(on, ((gains @ steady_response[:, tone])[:, None] * wave).real, 0.0)
    for switched, sign in ((start, -1.0), (part.stop, 1.0)):
        if np.isfinite(switched):
            steady += sign * _fading(part, response, rates, gains, time, switched)
    return steady


def _fading(part: Tones, response: Complex, rates: Real, gains: Real, time: Real, switched: float) -> Real:
    """What modes make of the steady state at a switching time, decaying since then."""
    phasors = part.amplitudes * np.exp(2j * np.pi * part.frequencies * switched)
    then = gains * (response @ phasors).real
    first = int(np.searchsorted(time, switched))
    found = np.zeros((len(gains), len(time)))
    for piece in chunks(len(time) - first, len(rates)):
        since = time[first:][piece] - switched
        found[:, first:][:, piece] = then @ np.exp(-rates[:, None] * since)
    return found
