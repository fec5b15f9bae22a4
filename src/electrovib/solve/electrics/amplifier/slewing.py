"""Plate, stack and stray capacitance behind an amplifier, from one change of its regime to the next.

Seen from the plate the linear layers are branches of a resistance and a capacitor each. While the amplifier supplies
its voltage the plate follows a straight line or lags behind it; while it supplies its largest current the plate's
voltage relaxes in the modes of branches and stray capacitance, whose rates are roots of a sum of poles. In both cases
it is a sum of exponentials and their integrals, and so is every response of the stack to it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.solve.electrics.amplifier.course import Course, _apart_from
from electrovib.solve.stack.secular import secular_roots

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.solve.stack.transfer import Transfer


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
        """Compute the current of the amplifier, without the part that initial charge drives.

        `states` (n,) [V], `time` (times,) [s]; returns `current` (times,) [A].
        """
        voltage = course.voltage(time)
        lag = self.conductances @ (voltage - course.answer(self.rates, states, time))
        return np.asarray(self.static * voltage + self.capacitance * course.slope(time) + lag)

    def fading(self, time: Real) -> Real:
        """Return the current that initial charge drives [A] at times since time 0 [s]."""
        return np.asarray(self.free @ np.exp(-np.outer(self.free_rates, time)))

    def slewed(
        self, *, current: float, voltage: float, states: Real, time: float, modes: SlewingModes
    ) -> Course:
        """Compute the plate's voltage under a constant current.

        `states` (n,) [V].
        """
        loads = self.conductances / self.rates
        charge = modes.shapes @ (loads * states) + self.capacitance * voltage
        levels, slopes = charge / modes.sizes, current / modes.sizes
        rates = modes.rates
        if self.capacitance == 0:  # the voltage over the resistance follows at once
            rates, slopes = np.append(rates, 0.0), np.append(slopes, 0.0)
            levels = np.append(levels, current / self.direct)
        if len(self.free):
            rates, levels, slopes = self._fading(time, modes, rates, levels, slopes)
        return Course(rates, levels, slopes)

    def _fading(
        self, time: float, modes: SlewingModes, rates: Real, levels: Real, slopes: Real
    ) -> tuple[Real, Real, Real]:
        """Add the response to the current that initial charge drives."""
        now, fading = self.free * np.exp(-self.free_rates * time), _apart_from(modes.rates, self.free_rates)
        apart = modes.rates[:, None] - fading
        weights = now / apart / modes.sizes[:, None]
        levels = levels.copy()
        levels[: len(modes.rates)] += weights.sum(axis=1)
        taken = -weights.sum(axis=0)
        if self.capacitance == 0:
            taken = taken - now / self.direct
        return (
            np.append(rates, fading),
            np.append(levels, taken),
            np.append(slopes, np.zeros(len(fading))),
        )

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
        rates, shapes = found.values, self.rates / apart
        sizes = rates * found.slope
        if not leaks:
            rates = np.append(0.0, rates)
            shapes = np.vstack([np.ones(len(self.rates)), shapes])
            total = self.capacitance + float(np.sum(self.conductances / self.rates))
            sizes = np.append(total, sizes)
        return SlewingModes(rates, shapes, sizes)


@dataclass(frozen=True, eq=False)
class SlewingModes:
    """Modes of a plate under a given current.

    Parameters
    ----------
    rates, sizes : ndarray, shape (m,)
        Rates [1/s] and norms [F].
    shapes : ndarray, shape (m, n)
        Voltage of each branch over that of the plate, dimensionless.
    """

    rates: Real
    shapes: Real
    sizes: Real
