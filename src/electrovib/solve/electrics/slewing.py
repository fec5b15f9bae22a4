"""A plate under a constant current: its voltage as a sum of exponentials, and the response of the stack to it.

Seen from the plate the linear layers are branches of a resistance and a capacitor each. While an amplifier supplies its
largest current, the plate's voltage relaxes in the modes of branches and stray capacitance, whose rates are roots of a sum
of poles. It is a sum of exponentials and their integrals, and so is every response of the stack to it.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from electrovib.solve.electrics.straight import chunks
from electrovib.solve.electrics.transient import SAME_RATE, Response, amplified, moved_corner
from electrovib.solve.stack.secular import secular_roots
from electrovib.solve.stack.transfer import Transfer

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.physics.amplifier import Amplifier
    from electrovib.physics.drive.base import Drive


@dataclass(frozen=True, eq=False)
class Course:
    """Voltage of the plate from some time on: sum of level exp(-rate t) + slope (1 - exp(-rate t))/rate.

    Parameters
    ----------
    rates, levels, slopes : ndarray, shape (n,)
        Rates [1/s], >= 0; levels [V]; slopes [V/s].
    """

    rates: Real
    levels: Real
    slopes: Real

    def voltage(self, time: Real) -> Real:
        """Return the voltage [V] at times since the beginning [s]."""
        falling = np.exp(-np.outer(self.rates, time))
        return np.asarray(self.levels @ falling + self.slopes @ _risen(self.rates, time))

    def slope(self, time: Real) -> Real:
        """Return the rate of change [V/s] at times since the beginning [s]."""
        return np.asarray((self.slopes - self.rates * self.levels) @ np.exp(-np.outer(self.rates, time)))

    def answer(self, rates: Real, state: Real, time: Real) -> Real:
        """Compute the states x of x' = rate (v - x) under this voltage v.

        `rates`, `state` (m,) [V], `time` (times,) [s]; returns `states` (m, times) [V].
        """
        found = state[:, None] * np.exp(-np.outer(rates, time))
        for piece in chunks(len(time), len(rates) * len(self.rates) + 1):
            some = time[piece]
            shared = overlap(rates, self.rates, some)
            found[:, piece] += np.einsum("n,mnt->mt", self.levels, shared) * rates[:, None]
            found[:, piece] += self.slopes @ _risen(self.rates, some)
            found[:, piece] -= np.einsum("n,mnt->mt", self.slopes, shared)
        return np.asarray(found)


def overlap(first: Real, second: Real, time: Real) -> Real:
    """Compute the integral over s from 0 to t of exp(-first (t - s)) exp(-second s), without cancellation.

    `first` (m,), `second` (n,) [1/s], `time` (times,) [s]; returns `integral` (m, n, times) [s].
    """
    slower = np.minimum(first[:, None], second)[..., None]
    apart = np.abs(first[:, None] - second)[..., None] * time
    share = np.ones_like(apart)
    np.divide(-np.expm1(-apart), apart, out=share, where=apart > 0)
    return np.asarray(time * np.exp(-slower * time) * share)


def _risen(rates: Real, time: Real) -> Real:
    """Compute the integral of exp(-rate t) from 0 to each time [s], shape (rates, times)."""
    return overlap(rates, np.zeros(1), time)[:, 0]


class SlewingModes(NamedTuple):
    """Modes of a plate under a given current: rates (m,) [1/s], norms (m,) [F], and shapes (m, n).

    A shape is the voltage of each branch over that of the plate.
    """

    rates: Real
    shapes: Real
    sizes: Real


@dataclass(frozen=True, eq=False, kw_only=True)
class Network:
    """The network between plate and ground.

    Parameters
    ----------
    rates, conductances : ndarray, shape (n,)
        Rates [1/s] and conductances [1/ohm] of branches of a resistance and a capacitor each, above 0.
    static : float
        Conductance at zero frequency [1/ohm].
    capacitance : float
        Stray capacitance plus that of a stack without resistance [F].
    stray : float
        Stray capacitance alone [F].
    free_rates, free : ndarray, shape (m,)
        Rates [1/s] and amplitudes [A] of the current that initial charge drives at 0 V, sum free exp(-rate t).
    """

    rates: Real
    conductances: Real
    static: float
    capacitance: float
    stray: float
    free_rates: Real
    free: Real

    @classmethod
    def of(cls, current: Transfer, *, stray: float) -> Network:
        """Return the network of a stack from its current per volt."""
        on, left = current.gains < 0, current.free != 0
        return cls(
            rates=current.rates[on],
            conductances=-current.gains[on],
            static=current.at_rest(),
            capacitance=stray + current.slope,
            stray=stray,
            free_rates=current.rates[left],
            free=current.free[left],
        )

    @property
    def direct(self) -> float:
        """Conductance at a discontinuity of the voltage [1/ohm], where no capacitance forbids one."""
        return self.static + float(np.sum(self.conductances))

    def current(self, course: Course, states: Real, time: Real) -> Real:
        """Compute the current of the amplifier [A], without the part that initial charge drives.

        `states` (n,) [V] of the branches at the beginning, `time` (times,) [s].
        """
        voltage = course.voltage(time)
        lag = self.conductances @ (voltage - course.answer(self.rates, states, time))
        return np.asarray(self.static * voltage + self.capacitance * course.slope(time) + lag)

    def fading(self, time: Real) -> Real:
        """Return the current that initial charge drives [A] at times since time 0 [s]."""
        return np.asarray(self.free @ np.exp(-np.outer(self.free_rates, time)))

    def slewed(self, *, current: float, voltage: float, states: Real, time: float) -> Course:
        """Compute the plate's voltage under a constant current, from states (n,) [V] of the branches at a time [s]."""
        modes, loads = self.modes, self.conductances / self.rates
        charge = modes.shapes @ (loads * states) + self.capacitance * voltage
        levels, slopes, rates = charge / modes.sizes, current / modes.sizes, modes.rates
        # what initial charge still drives
        now, fading = self.free * np.exp(-self.free_rates * time), _apart_from(rates, self.free_rates)
        weights = now / (rates[:, None] - fading) / modes.sizes[:, None]
        levels, taken = levels + weights.sum(axis=1), -weights.sum(axis=0)
        if self.capacitance == 0:  # the voltage over the resistance follows at once
            rates, slopes = np.append(rates, 0.0), np.append(slopes, 0.0)
            levels, taken = np.append(levels, current / self.direct), taken - now / self.direct
        return Course(
            np.append(rates, fading), np.append(levels, taken), np.append(slopes, np.zeros(len(fading)))
        )

    @functools.cached_property
    def modes(self) -> SlewingModes:
        """Compute the modes of the plate under a given current.

        C + sum a/(q - m) - static/m = 0 for a mode exp(-m t) and branches of conductance a and rate q; the
        voltage of a branch is then q/(q - m) of the plate's voltage. Modes are orthogonal with respect to
        energy; the norm is C + sum a q/(q - m)^2.
        """
        leaks = self.static > 0
        if not leaks and not len(self.rates):
            return SlewingModes(np.zeros(1), np.ones((1, 0)), np.array([self.capacitance]))
        nodes = np.append(0.0, self.rates) if leaks else self.rates
        weights = np.append(self.static, self.conductances) if leaks else self.conductances
        order = np.argsort(nodes)
        found = secular_roots(nodes[order], weights[order], constant=self.capacitance)
        apart = -found.differences()[:, np.argsort(order)][
            :, int(leaks) :
        ]  # rate of branch less that of mode
        rates, shapes, sizes = found.values, self.rates / apart, found.values * found.slope
        if not leaks:
            rates, shapes = np.append(0.0, rates), np.vstack([np.ones(len(self.rates)), shapes])
            sizes = np.append(self.capacitance + float(np.sum(self.conductances / self.rates)), sizes)
        return SlewingModes(rates, shapes, sizes)


def _apart_from(rates: Real, fading: Real) -> Real:
    """Return rates moved slightly away from equal rates of another set; t exp(-rate t) is then exact to about 1e-8."""
    near = np.abs(rates[:, None] - fading) <= SAME_RATE * fading
    positive = rates[rates > 0]
    step = np.where(fading > 0, fading, np.min(positive) if len(positive) else 1.0)
    return np.where(np.any(near, axis=0), fading + 2 * SAME_RATE * step, fading)


class Unlimited:
    """Plate, modes and current behind an amplifier that never meets a limit.

    Parameters
    ----------
    drive : Drive
        Off before time 0.
    amplifier : Amplifier
        Gain, pole and stray capacitance.
    rates : ndarray, shape (modes,)
        Rates of the modes of the stack [1/s], > 0.
    current : Transfer
        Current into the stack per volt of the plate [A/V].

    Attributes
    ----------
    amplifier : Amplifier
        The same with a pole that differs from all rates.
    corner : float or None
        That pole [rad/s].
    """

    def __init__(self, drive: Drive, amplifier: Amplifier, rates: Real, current: Transfer) -> None:
        self.parts, self.corner = drive.parts(), moved_corner(amplifier, rates)
        if self.corner is not None:
            amplifier = amplifier.model_copy(update={"bandwidth": self.corner / (2 * np.pi)})
        self.amplifier = amplifier
        supplied = amplified({"current": current}, amplifier)
        modes = [Transfer(rates=rates, gains=row, static=1.0) for row in np.eye(len(rates))]
        behind_it = amplified(dict(enumerate(modes)) | {"current": current}, amplifier)
        self._states = Response({each: behind_it[each] for each in range(len(rates))}, self.parts)
        self._supplied = Response({"current": supplied["amplifier_current"]}, self.parts)
        self._plate = Response({"voltage": supplied["plate_voltage"]}, self.parts)

    def current(self, time: Real) -> Real:
        """Compute the current of the amplifier [A] at increasing times [s]."""
        return self._supplied.at(time)["current"]

    def state(self, time: float) -> tuple[float, Real]:
        """Return the voltage of the plate just before a time [V], and the states of the modes (modes,) [V]."""
        at = np.array([time])
        states = np.array([row[0] for row in self._states.at(at).values()])
        if self.corner is not None:
            return float(self._plate.at(at)["voltage"][0]), states
        before = sum(float(part.value_before(at)[0]) for part in self.parts) if time > 0 else 0.0
        return self.amplifier.gain * before, states
