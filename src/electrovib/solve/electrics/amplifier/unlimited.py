"""Response of a stack behind an amplifier while no limit is met, in closed form for repeated evaluation at any time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.physics.drive.pieces import Linear
from electrovib.solve.electrics.straight import BreakStates, chunks, lag_since_breaks
from electrovib.solve.electrics.transient import part_lag, transient
from electrovib.solve.stack.transfer import Transfer

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Real
    from electrovib.physics.amplifier import Amplifier
    from electrovib.physics.drive.base import Drive

_SAME_RATE = 1e-8
"""Relative distance below which the amplifier's corner is moved away from a rate of the stack."""


def corner_apart(amplifier: Amplifier, rates: Real) -> float | None:
    """Return the angular corner frequency of an amplifier, moved away from rates that almost equal it.

    `rates` (n,).
    """
    if amplifier.bandwidth is None:
        return None
    corner = 2 * np.pi * amplifier.bandwidth
    if np.any(np.abs(rates - corner) < _SAME_RATE * corner):
        corner *= 1 + 2 * _SAME_RATE
    return corner


def behind(transfer: Transfer, amplifier: Amplifier) -> Transfer:
    """Multiply a linear quantity of the plate's voltage by gain and pole of an amplifier."""
    gain, corner = amplifier.gain, corner_apart(amplifier, transfer.rates)
    if corner is None:
        static = None if transfer.static is None else transfer.static * gain
        return Transfer(
            rates=transfer.rates,
            gains=transfer.gains * gain,
            direct=transfer.direct * gain,
            slope=transfer.slope * gain,
            free=transfer.free,
            static=static,
        )
    apart = corner - transfer.rates
    direct = transfer.direct if transfer.static is None else transfer.static - float(np.sum(transfer.gains))
    own = direct - transfer.slope * corner - float(np.sum(transfer.gains * transfer.rates / apart))
    return Transfer(
        rates=np.append(transfer.rates, corner),
        gains=gain * np.append(transfer.gains * corner / apart, own),
        direct=gain * transfer.slope * corner,
        slope=0.0,
        free=np.append(transfer.free, 0.0),
        static=None if transfer.static is None else gain * transfer.static,
    )


def amplified(transfers: Mapping[Any, Transfer], amplifier: Amplifier) -> dict[Any, Transfer]:
    """Return quantities per volt of the drive from those per volt of the plate, with those of the plate itself."""
    none = np.zeros(0)
    own = {
        "plate_voltage": Transfer(rates=none, gains=none, direct=1.0),
        "stray current": Transfer(
            rates=none, gains=none, direct=0.0, slope=amplifier.stray_capacitance, static=0.0
        ),
    }
    return {name: behind(transfer, amplifier) for name, transfer in (dict(transfers) | own).items()}


def without_limits(
    transfers: Mapping[Any, Transfer],
    drive: Drive,
    time: Real,
    *,
    amplifier: Amplifier,
    settled: bool = False,
) -> dict[str, Real]:
    """Compute the response behind gain and pole of quantities that are linear in the plate's voltage.

    `time` (n,) [s].
    """
    found = transient(amplified(transfers, amplifier), drive, time, settled=settled)
    found["amplifier_current"] = found.pop("stray current") + found["current"]
    return found


class Lags:
    """Lag x - u of modes x' = rate (u - x) behind a drive u, from rest.

    Parameters
    ----------
    drive : Drive
        Off before time 0 [V].
    rates : ndarray, shape (modes,)
        Rates of the modes [1/s], > 0.
    """

    def __init__(self, drive: Drive, rates: Real) -> None:
        self.rates = rates
        self.smooth = [part for part in drive.parts() if not isinstance(part, Linear)]
        pieces = [part for part in drive.parts() if isinstance(part, Linear)]
        self.straight = [BreakStates(each, rates, np.zeros(len(rates))) for each in pieces]

    def of(self, gains: Real, time: Real) -> Real:
        """Compute the sum of gain (x - u) over modes.

        `gains` (outputs, modes), `time` (n,) [s]; returns `lags` (outputs, n) [V].
        """
        found = np.zeros((len(gains), len(time)))
        if not len(self.rates):
            return found
        for piece in chunks(len(time), len(self.rates)):
            some = time[piece]
            for part in self.smooth:
                found[:, piece] += part_lag(part, self.rates, gains, some, settled=False)
            for states in self.straight:
                found[:, piece] += lag_since_breaks(states, gains, some)
        return found


class Unlimited:
    """Plate, modes and current behind an amplifier that never meets a limit.

    Parameters
    ----------
    drive : Drive
        Off before time 0.
    gain : float
        Gain of the amplifier.
    corner : float or None
        Pole of the amplifier [rad/s], different from all rates; None without a pole.
    rates : ndarray, shape (modes,)
        Rates of the modes of the stack [1/s], > 0.
    current : Transfer
        Current of the amplifier per volt of the drive [A/V].
    """

    def __init__(
        self, drive: Drive, *, gain: float, corner: float | None, rates: Real, current: Transfer
    ) -> None:
        self.drive, self.gain, self.corner, self.current_per_volt = drive, gain, corner, current
        self.rates = rates
        self.modes = Lags(drive, rates if corner is None else np.append(rates, corner))
        driven = (current.gains != 0) & (current.rates > 0)
        self.flows, self.weights = Lags(drive, current.rates[driven]), current.gains[None, driven]

    def current(self, time: Real) -> Real:
        """Compute the current of the amplifier.

        `time` (n,) [s]; returns `current` (n,) [A].
        """
        per_volt = self.current_per_volt
        found = per_volt.at_rest() * self.drive.voltage(time) + self.flows.of(self.weights, time)[0]
        if per_volt.slope:
            found = found + per_volt.slope * self.drive.slope(time)
        left = per_volt.free != 0
        if np.any(left):
            found = found + per_volt.free[left] @ np.exp(-np.outer(per_volt.rates[left], time))
        return np.asarray(found)

    def state(self, time: float) -> tuple[float, Real]:
        """Return the voltage of the plate just before a time, and the states of the modes.

        Returns `modes` (modes,) [V].
        """
        at = np.array([time])
        lags = self.modes.of(np.eye(len(self.modes.rates)), at)[:, 0]
        now = float(self.drive.voltage(at)[0])
        if self.corner is None:
            before = sum(float(part.value_before(at)[0]) for part in self.drive.parts()) if time > 0 else 0.0
            return self.gain * before, self.gain * (now + lags)
        lags, own = lags[:-1], float(lags[-1])
        lags = (self.corner * lags - self.rates * own) / (self.corner - self.rates)
        return self.gain * (now + own), self.gain * (now + lags)
