"""Response over time: exact for straight pieces and sines at any output times, from rest or a given state."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError
from electrovib.physics.drive.parts import Chirped, Linear, Part, Smooth, Tones
from electrovib.solve.chirp import chirp_response
from electrovib.solve.integrator import integral_weight, settled_integral, without_integrators
from electrovib.solve.recursion import hold_weights, march
from electrovib.solve.smooth import smooth_states

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.physics.drive.base import Drive
    from electrovib.solve.transfer import Complex, Real, Transfer

CHUNK = 1 << 16
"""States held at once, so that a million samples need no gigabyte."""
MANY_SAMPLES = 20_000
"""From here on the block scan is faster than the closed form of each segment."""
ROUNDING = 8 * float(np.finfo(float).eps)
"""How far, over the last time, a grid may be off and still count as even."""


def transient(
    transfers: Mapping[str, Transfer], drive: Drive, time: Real, *, settled: bool = False
) -> dict[str, Real]:
    """Response of linear quantities to a drive.

    Parameters
    ----------
    transfers : mapping of str to Transfer
        What to compute.
    drive : Drive
        Off before time 0 when starting from rest.
    time : ndarray, shape (n,)
        Increasing, >= 0 [s]; need not be even.
    settled : bool
        Start from the periodic state instead of rest: the drive has been repeating for ever.

    Returns
    -------
    dict of str to ndarray, shape (n,)
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
    if settled and drive.period is None and not _is_steady(drive):
        raise InputError(
            f"time.initial_state = PeriodicState: {type(drive).__name__} does not repeat. Give it a period,"
            " or start from rest: AtRest"
        )
    weights = {name: integral_weight(transfer) for name, transfer in transfers.items()} if settled else {}
    if any(weights.values()):
        integral = settled_integral(drive, time)
        fading = {name: without_integrators(transfer) for name, transfer in transfers.items()}
        rest = transient(fading, drive, time, settled=True)
        return {name: row + weights[name] * integral for name, row in rest.items()}
    result: dict[str, Real] = {}
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


def _groups(transfers: Mapping[str, Transfer]) -> list[tuple[list[str], Real, bool]]:
    """Collect quantities with the same modes, so that they are marched once; those as lag x - v apart."""
    groups: list[tuple[list[str], Real, bool]] = []
    for name, transfer in transfers.items():
        lag = transfer.static is not None
        for names, rates, lags in groups:
            if lags == lag and np.array_equal(rates, transfer.rates):
                names.append(name)
                break
        else:
            groups.append(([name], transfer.rates, lag))
    return groups


def _is_steady(drive: Drive) -> bool:
    return all(isinstance(part, Linear) and part.is_step for part in drive.parts())


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


def periodic_state(part: Linear, rates: Real) -> Real:
    """State of each mode at the beginning of a period of a drive that has been repeating for ever.

    Parameters
    ----------
    part : Linear
        Straight pieces with a period.
    rates : ndarray, shape (modes,)
        1/s, > 0.

    Returns
    -------
    ndarray, shape (modes,)
        V.

    Notes
    -----
    x0 = (state after one period from rest)/(1 - exp(-rate period)).
    """
    assert part.period is not None
    one = part.until(part.period)
    end = break_states(one, rates, np.zeros(len(rates)))[:, -1]
    state: Real = end / -np.expm1(-rates * part.period)
    return state


def break_states(part: Linear, rates: Real, state: Real) -> Real:
    """States at the breaks of straight pieces.

    Parameters
    ----------
    part : Linear
        Without a period.
    rates, state : ndarray, shape (modes,)
        1/s, > 0; V at time 0.

    Returns
    -------
    ndarray, shape (modes, breaks)
        V.
    """
    if part.is_step:
        return state[:, None]
    identity = np.eye(len(rates))
    steps = np.diff(part.times)
    states, _ = march(-rates, identity, np.zeros(len(rates)), part.after[:-1], part.before[1:], steps, state)
    return states


def straight_response(part: Linear, rates: Real, gains: Real, time: Real, state: Real) -> Real:
    """Response of modes to straight pieces at any times.

    Parameters
    ----------
    part : Linear
        The pieces.
    rates : ndarray, shape (modes,)
        1/s, > 0.
    gains : ndarray, shape (outputs, modes)
        What each output takes of each mode.
    time : ndarray, shape (n,)
        Increasing, from 0 on [s].
    state : ndarray, shape (modes,)
        At time 0.

    Returns
    -------
    ndarray, shape (outputs, n)
        Without the direct part.
    """
    pieces = part.until(float(time[-1]))
    even = _even_step(pieces, time)
    if even is not None:
        before, after = _sides(pieces, time)
        zero = np.zeros(len(gains))
        output, _ = march(-rates, gains, zero, after[:-1], before[1:], even, state)
        return output
    states = break_states(pieces, rates, state)
    index, elapsed = pieces.locate(time)
    now = pieces.value(time)
    result = np.empty((len(gains), len(time)))
    for piece in chunks(len(time), len(rates)):
        decay, begin, end = hold_weights(-rates[:, None] * elapsed[piece])
        began = pieces.after[index[piece]]
        result[:, piece] = gains @ (decay * states[:, index[piece]] + begin * began + end * now[piece])
    return result


def straight_lag(part: Linear, rates: Real, gains: Real, time: Real, state: Real) -> Real:
    """Response of modes to straight pieces less the drive itself, at any times.

    Parameters
    ----------
    part, rates, gains, time, state
        As for `straight_response`: 1/s, 1, s, V.

    Returns
    -------
    ndarray, shape (outputs, n)
        sum gain (x - v), V.

    Notes
    -----
    x - v = exp(-rate t) (x_0 - v_0) - v' (1 - exp(-rate t))/rate since the beginning of a piece. At a break
    the piece before it is used, less the jump: a fast mode has forgotten the rounding of x_0 - v_0 by then.
    """
    pieces = part.until(float(time[-1]))
    even = _even_step(pieces, time)
    slow = rates * (even or 0.0) < 1 if even else np.zeros(len(rates), bool)
    result = np.zeros((len(gains), len(time)))
    if np.any(slow):
        result += straight_response(part, rates[slow], gains[:, slow], time, state[slow])
        result -= np.outer(gains[:, slow].sum(axis=1), pieces.value(time))
    if np.all(slow):
        return result
    rates, gains, state = rates[~slow], gains[:, ~slow], state[~slow]
    return result + lag_since_breaks(pieces, break_states(pieces, rates, state), rates, gains, time)


def lag_since_breaks(pieces: Linear, states: Real, rates: Real, gains: Real, time: Real) -> Real:
    """Response of modes to straight pieces less the drive itself, from the states at the breaks.

    Parameters
    ----------
    pieces : Linear
        Without a period.
    states : ndarray, shape (modes, breaks)
        As from `break_states`.
    rates, gains, time
        As for `straight_response`: 1/s, 1, s.

    Returns
    -------
    ndarray, shape (outputs, n)
        sum gain (x - v), V.
    """
    result, slopes = np.zeros((len(gains), len(time))), pieces.slopes()
    index, elapsed = pieces.locate(time)
    back = (elapsed == 0) & (index > 0)
    before = index - back
    elapsed = np.where(back, pieces.times[index] - pieces.times[before], elapsed)
    jump = np.where(back, pieces.after[index] - pieces.before[index], 0.0)
    for piece in chunks(len(time), len(rates)):
        fallen = np.expm1(-rates[:, None] * elapsed[piece])
        since = states[:, before[piece]] - pieces.after[before[piece]]
        lag = (1 + fallen) * since + slopes[before[piece]] * fallen / rates[:, None] - jump[piece]
        result[:, piece] = gains @ lag
    return result


def chunks(samples: int, modes: int) -> list[slice]:
    """Cut many times into stretches whose states are held at once.

    Parameters
    ----------
    samples, modes : int
        How many.

    Returns
    -------
    list of slice
        Of the times.
    """
    length = max(1, CHUNK // modes)
    return [slice(first, first + length) for first in range(0, samples, length)]


def _even_step(part: Linear, time: Real) -> float | None:
    """Give the step of an even grid that begins at 0 and holds every break, if there are many samples."""
    if len(time) < MANY_SAMPLES or time[0] != 0:
        return None
    end = float(time[-1])
    step, rounding = end / (len(time) - 1), ROUNDING * end
    breaks = part.times[part.times <= end + rounding]
    off = np.max(np.abs(breaks - step * np.round(breaks / step)))
    uneven = np.max(np.abs(time - step * np.arange(len(time))))
    return step if max(off, uneven) <= rounding else None


def _sides(part: Linear, time: Real) -> tuple[Real, Real]:
    """Drive just before and just after each time of a grid that holds every break."""
    step = float(time[-1]) / (len(time) - 1)
    after = part.value(time)
    before = after.copy()
    inside = part.times <= time[-1] * (1 + ROUNDING)
    places = np.round(part.times[inside] / step).astype(int)
    before[places], after[places] = part.before[inside], part.after[inside]
    return before, after


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
    if np.isfinite(start):
        steady -= gains @ _fading(part, response, rates, time, start)
    if np.isfinite(part.stop):
        steady += gains @ _fading(part, response, rates, time, part.stop)
    return steady


def _fading(part: Tones, response: Complex, rates: Real, time: Real, switched: float) -> Real:
    """Steady state at a switching time, decaying since then."""
    phasors = part.amplitudes * np.exp(2j * np.pi * part.frequencies * switched)
    then = (response @ phasors).real
    since = np.maximum(time - switched, 0.0)
    return np.where(time >= switched, then[:, None] * np.exp(-rates[:, None] * since), 0.0)
