"""Voltage of the plate behind an amplifier without limits, within the steps of a time integration."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.physics.drive.parts import Tones
from electrovib.physics.drive.pieces import Linear
from electrovib.solve.electrics.leaks.steps import jump_heights
from electrovib.solve.electrics.linear.transient import transient
from electrovib.solve.stack.transfer import Transfer

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.physics.amplifier import Amplifier
    from electrovib.physics.drive.base import Drive
from electrovib.solve.nonlinear.radau import NODES


@dataclass(frozen=True)
class DrivenPlate:
    """Voltage of the plate behind an amplifier without limits."""

    drive: Drive
    amplifier: Amplifier | None

    @property
    def gain(self) -> float:
        """Gain of the amplifier, 1 without one."""
        return 1.0 if self.amplifier is None else self.amplifier.gain

    @property
    def corner(self) -> float | None:
        """Rate of the amplifier's pole [1/s]; None without one."""
        band = None if self.amplifier is None else self.amplifier.bandwidth
        return None if band is None else 2 * np.pi * band

    def within(self, grid: Real) -> tuple[Real, Real]:
        """Return the voltage and its rate at the nodes of each step; at the end of a step, the values just before it.

        `grid` (steps + 1,) [s]; returns `voltage`, `slope` (steps, 3) [V].
        """
        begins, steps = grid[:-1, None], np.diff(grid)[:, None]
        times, middle = begins + steps * NODES, begins + steps / 2
        value, slope = np.zeros((2, *times.shape))
        for part in self.drive.parts():
            if isinstance(part, Linear):
                rise = part.slope(middle)
                value, slope = value + part.value(middle) + rise * (times - middle), slope + rise
                continue
            on = (middle >= part.start) & (middle < part.stop)
            always = Tones(part.frequencies, part.amplitudes) if isinstance(part, Tones) else None
            value = value + np.where(on, always.value(times) if always else part.formula(times), 0.0)  # type: ignore[union-attr]
            slope = slope + np.where(on, always.slope(times) if always else part.derivative(times), 0.0)  # type: ignore[union-attr]
        if self.corner is None:
            return self.gain * value, self.gain * slope
        plate = self.lagging(times.ravel()).reshape(times.shape)
        return plate, self.corner * (self.gain * value - plate)

    def at(self, times: Real) -> tuple[Real, Real]:
        """Return the voltage and its rate just after some times.

        `times` (n,) [s]; returns `voltage`, `slope` (n,) [V].
        """
        value = self.gain * self.drive.voltage(times)
        if self.corner is None:
            return value, self.gain * self.drive.slope(times)
        plate = self.lagging(times)
        return plate, self.corner * (value - plate)

    def jumps(self, grid: Real) -> Real:
        """Return the heights of the voltage steps at the ends of time steps, that of switching on included.

        `grid` (n,) [s]; returns `heights` (n,) [V].
        """
        if self.corner is not None:
            return np.zeros(len(grid))
        heights = jump_heights(self.drive, grid)
        heights[0] = self.drive.voltage(np.zeros(1))[0]
        return self.gain * heights

    def lagging(self, times: Real) -> Real:
        """Return the voltage behind the amplifier's pole.

        `times` (n,) [s]; returns `voltage` (n,) [V].
        """
        assert self.corner is not None
        pole = Transfer(rates=np.array([self.corner]), gains=np.array([self.gain]))
        return transient({"v": pole}, self.drive, times)["v"]
