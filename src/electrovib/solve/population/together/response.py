"""Response of many fingers to the drive that they share."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.physics.drive.parts import circling
from electrovib.solve.population.kernels import first_order_hold_many
from electrovib.solve.population.together.refusal import NotTogetherError
from electrovib.solve.recursion.hold import hold_weights
from electrovib.solve.stack.integrator import INTEGRATING

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.solve.population.together.excitation import Excitation, Period, Tone
    from electrovib.solve.population.together.transfers import Transfers


class Response:
    """Response of one linear quantity of many fingers to a drive, as arguments of the kernel.

    Parameters
    ----------
    transfers : Transfers
        The quantity, per volt.
    drive : Excitation
        The drive.

    Attributes
    ----------
    rates, residues, state : ndarray, shape (fingers, modes)
        Rates [1/s], residues, and contribution of each mode to the response at time 0.
    direct : ndarray, shape (fingers,)
        Response at infinite frequency.
    """

    def __init__(self, transfers: Transfers, drive: Excitation) -> None:
        if drive.settled and np.any(transfers.rates == INTEGRATING):
            raise NotTogetherError(
                "every layer up to the interface conducts, and the charge there has no period"
            )
        self.transfers, self.drive = transfers, drive
        self.rates = np.ascontiguousarray(transfers.rates.T)
        self.residues = np.ascontiguousarray(transfers.residues.T)
        fingers = self.rates.shape[0]
        self.direct = np.ascontiguousarray(np.broadcast_to(transfers.direct, fingers), dtype=float)
        state = np.zeros(transfers.rates.shape)
        for period in drive.periods:
            state = state + transfers.residues * settled_state(_positive(transfers), period)
        if not drive.settled:
            for tone in drive.tones:
                state = state - _decaying(transfers, tone)
        if transfers.free is not None:  # in the periodic state only trapped charge remains
            left = np.where(transfers.rates == 0, transfers.free, 0.0) if drive.settled else transfers.free
            state = state + left
        self.state = np.ascontiguousarray(state.T)
        fades = bool(drive.tones) and not drive.settled and len(state) > 0
        self.is_stepped = drive.is_straight or fades or transfers.free is not None

    def at(self, some: slice, time: Real, *, threads: int | None = None) -> Real:
        """Return the response of some fingers.

        Parameters
        ----------
        some : slice
            Range of the fingers.
        time : ndarray, shape (n,)
            Output times [s].
        threads : int, optional
            Threads of the kernel.

        Returns
        -------
        response : ndarray, shape (fingers, n)
            In the unit of the quantity.
        """
        drive = self.drive
        if self.is_stepped:
            grid = drive.time if drive.is_straight else np.concatenate([[0.0], time])
            voltage = drive.voltage if drive.is_straight else np.zeros(len(grid))
            numbers = (each[some] for each in (self.rates, self.residues, self.direct, self.state))
            found: Real = first_order_hold_many(*numbers, voltage, grid, threads=threads)
            if not drive.is_straight:
                found = found[:, 1:]
            elif not drive.has_every_point:
                found = found[:, drive.places]
        else:
            found = np.zeros((len(self.direct[some]), len(time)))
        for tone in drive.tones:
            gain = self.transfers.at(tone.frequency)[some]
            self._add(found, gain, tone, time)
        if drive.level:
            found += (self.transfers.at(0.0)[some].real * drive.level)[:, None]
        return found

    @staticmethod
    def _add(found: Real, gain: Any, tone: Tone, time: Real) -> None:
        """Add the steady response to a sine."""
        cosine, sine = circling(tone.frequency, time)
        in_phase = gain.real * tone.cosine + gain.imag * tone.sine
        behind = gain.real * tone.sine - gain.imag * tone.cosine
        found += in_phase[:, None] * cosine
        found += behind[:, None] * sine


def _positive(transfers: Transfers) -> Real:
    """Return the rates, with 1/s in the place of those of trapped charge, which the drive does not excite."""
    return transfers.rates if transfers.free is None else np.where(transfers.rates > 0, transfers.rates, 1.0)


def settled_state(rates: Real, period: Period) -> Real:
    """Return the state of modes at the beginning of a period, in the periodic state.

    Parameters
    ----------
    rates : ndarray, any shape
        Rates of the modes, above 0 [1/s].
    period : Period
        Straight pieces of the drive [V].

    Returns
    -------
    state : ndarray, shape of the rates
        Solution of x' = v - rate x [V s].

    Notes
    -----
    x0 = (state after one period from rest)/(1 - exp(-rate period)).
    """
    state = np.zeros(rates.shape)
    for length, begin, end in zip(
        period.lengths.tolist(), period.begins.tolist(), period.ends.tolist(), strict=True
    ):
        decay, first, last = hold_weights(-rates * length)
        state = decay * state + first * begin + last * end
    return np.asarray(state / -np.expm1(-rates * float(np.sum(period.lengths))) / rates)


def _decaying(transfers: Transfers, tone: Tone) -> Real:
    """Return the contribution of each mode to the steady response to a sine at time 0, which decays from there."""
    angular = 2 * np.pi * tone.frequency
    return np.asarray(
        transfers.residues
        * (transfers.rates * tone.cosine - angular * tone.sine)
        / (transfers.rates**2 + angular**2)
    )
