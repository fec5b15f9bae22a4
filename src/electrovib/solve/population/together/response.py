"""Response of many fingers to the drive that they share."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.solve.population.kernels import first_order_hold_many
from electrovib.solve.population.together.refusal import NotTogetherError
from electrovib.solve.population.together.steady_sines import write_sines
from electrovib.solve.recursion.hold import hold_weights
from electrovib.solve.stack.transfer import INTEGRATING

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
    known : dict of (int, int) to ndarray
        States in the periodic state, by the identities of rates and pieces, which both outlive it; extended.

    Attributes
    ----------
    rates, residues, state : ndarray, shape (fingers, modes)
        Rates [1/s], residues, and contribution of each mode to the response at time 0.
    direct : ndarray, shape (fingers,)
        Response at infinite frequency.
    """

    def __init__(self, transfers: Transfers, drive: Excitation, known: dict[tuple[int, int], Real]) -> None:
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
            key = id(transfers.rates), id(period)
            if key not in known:
                known[key] = settled_state(_positive(transfers), period)
            state = state + transfers.residues * known[key]
        if not drive.settled:
            for tone in drive.tones:
                state = state - _decaying(transfers, tone)
        if transfers.free is not None:  # in the periodic state only trapped charge remains
            left = np.where(transfers.rates == 0, transfers.free, 0.0) if drive.settled else transfers.free
            state = state + left
        self.state = np.ascontiguousarray(state.T)
        fades = bool(drive.tones) and not drive.settled and len(state) > 0
        self.is_stepped = drive.is_straight or fades or transfers.free is not None
        phases = [_in_phase_and_behind(transfers, tone) for tone in drive.tones]
        self._in_phase = np.array([each for each, _ in phases]).reshape(len(phases), fingers)
        self._behind = np.array([each for _, each in phases]).reshape(len(phases), fingers)
        self._points: Real | None = None
        self._level = transfers.at(0.0).real * drive.level if drive.level else None

    def write(self, out: Real, some: slice, *, factor: Real | None = None) -> None:
        """Write the response of some fingers.

        `out` (fingers, n), `factor` (rows,).
        """
        if self.is_stepped and not self.drive.tones and self._level is None:
            self._step(out, some, factor)
            return
        start = None
        if self.is_stepped:
            start = np.empty(out.shape)
            self._step(start, some, None)
        cosines, sines = self.drive.waves
        write_sines(
            out,
            start=start,
            in_phase=self._in_phase[:, some],
            behind=self._behind[:, some],
            cosines=cosines,
            sines=sines,
            level=None if self._level is None else self._level[some],
            factor=None if factor is None else factor[some],
        )

    def _step(self, out: Real, some: slice, factor: Real | None) -> None:
        drive = self.drive
        whole = len(drive.places) == len(drive.time) and out.flags.c_contiguous
        found = out if whole else self._memory(out)
        first_order_hold_many(
            self.rates[some],
            self.residues[some],
            self.direct[some],
            self.state[some],
            drive.voltage,
            drive.steps,
            factor=None if factor is None else factor[some],
            dtype=found.dtype,
            out=found,
        )
        if not whole:
            for places, points in drive.runs:
                out[:, places] = found[:, points]

    def _memory(self, out: Real) -> Real:
        """Return memory for responses at all points of the grid, the same for every range of fingers."""
        kind = out.dtype
        if self._points is None or len(self._points) < len(out) or self._points.dtype != kind:
            self._points = np.empty((len(out), len(self.drive.time)), kind)
        return self._points[: len(out)]


def _in_phase_and_behind(transfers: Transfers, tone: Tone) -> tuple[Real, Real]:
    """Return the amplitudes of cosine and sine in the steady response to a sine, shape (fingers,)."""
    gain = transfers.at(tone.frequency)
    return (
        gain.real * tone.cosine + gain.imag * tone.sine,
        gain.real * tone.sine - gain.imag * tone.cosine,
    )


def _positive(transfers: Transfers) -> Real:
    """Return the rates, with 1/s in the place of those of trapped charge, which the drive does not excite."""
    return np.where(transfers.rates > 0, transfers.rates, 1.0)


def settled_state(rates: Real, period: Period) -> Real:
    """Return the state of modes at the beginning of a period, in the periodic state.

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
