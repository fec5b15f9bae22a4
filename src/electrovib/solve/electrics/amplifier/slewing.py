"""Plate, stack and stray capacitance behind an amplifier, from one change of its behaviour to the next.

Seen from the plate the linear layers are branches of a resistance and a capacitor each. While the amplifier gives
its voltage the plate follows a straight line or lags behind it; while it gives its largest current the plate's
voltage relaxes in the modes of branches and stray capacitance, whose rates are roots of a sum of poles. Either
way it is a sum of exponentials and their integrals, and so is every answer of the stack to it.
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
    """What hangs on the plate.

    Parameters
    ----------
    rates, conductances : ndarray, shape (n,)
        Branches of a resistance and a capacitor each: 1/s, 1/ohm, both above 0.
    static : float
        Conductance that never blocks [1/ohm].
    capacitance : float
        Stray capacitance, and that of a stack without resistance [F].
    stray : float
        Of them the stray capacitance [F].
    free_rates, free : ndarray, shape (m,)
        Current that initial charge drives at 0 V, sum free exp(-rate t) [1/s, A].
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
        """Read the branches off the current per volt.

        Parameters
        ----------
        current : Transfer
            A per volt of the plate.
        stray : float
            Stray capacitance [F].

        Returns
        -------
        Network
            The same current, and that into the stray capacitance.
        """
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
        """Conductance to a jump of the voltage [1/ohm], where no capacitance forbids one."""
        return self.static + float(np.sum(self.conductances))

    def current(self, course: Course, states: Real, time: Real) -> Real:
        """Current of the amplifier, without what initial charge drives.

        Parameters
        ----------
        course : Course
            Voltage of the plate.
        states : ndarray, shape (n,)
            Of the branches at the beginning [V].
        time : ndarray, shape (times,)
            Since then [s].

        Returns
        -------
        ndarray, shape (times,)
            A.
        """
        voltage = course.voltage(time)
        lag = self.conductances @ (voltage - course.answer(self.rates, states, time))
        return np.asarray(self.static * voltage + self.capacitance * course.slope(time) + lag)

    def fading(self, time: Real) -> Real:
        """Current that initial charge drives [A] at times since time 0 [s]."""
        return np.asarray(self.free @ np.exp(-np.outer(self.free_rates, time)))

    def slewed(
        self, *, current: float, voltage: float, states: Real, time: float, modes: SlewingModes
    ) -> Course:
        """Course of the plate's voltage under a constant current.

        Parameters
        ----------
        current : float
            Of the amplifier [A].
        voltage : float
            Of the plate at the beginning [V]; of no account where it may jump.
        states : ndarray, shape (n,)
            Of the branches at the beginning [V].
        time : float
            When it begins [s].
        modes : SlewingModes
            As from `modes`.

        Returns
        -------
        Course
            From then on.
        """
        loads = self.conductances / self.rates
        charge = modes.shapes @ (loads * states) + self.capacitance * voltage
        levels, slopes = charge / modes.sizes, current / modes.sizes
        rates = modes.rates
        if self.capacitance == 0:  # what the resistance takes at once
            rates, slopes = np.append(rates, 0.0), np.append(slopes, 0.0)
            levels = np.append(levels, current / self.direct)
        if len(self.free):
            rates, levels, slopes = self._fading(time, modes, rates, levels, slopes)
        return Course(rates, levels, slopes)

    def _fading(
        self, time: float, modes: SlewingModes, rates: Real, levels: Real, slopes: Real
    ) -> tuple[Real, Real, Real]:
        """Add what the current that initial charge drives takes away."""
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
        """Modes of the plate under a given current.

        Returns
        -------
        SlewingModes
            One for each branch and one for the capacitance.

        Notes
        -----
        C + sum a/(q - m) - static/m = 0 for a mode exp(-m t), a branch of conductance a and rate q; the branch
        then is at q/(q - m) of the plate's voltage. Modes are orthogonal in energy, whose size is
        C + sum a q/(q - m)^2.
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
        1/s; F.
    shapes : ndarray, shape (m, n)
        Voltage of each branch over that of the plate.
    """

    rates: Real
    shapes: Real
    sizes: Real
