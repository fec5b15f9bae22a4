"""A finger held near the plate: linear layers under a gap of prescribed thickness, with charge as the state.

Modes are valid for a fixed thickness only; charge between the layers and slow polarisation in them are states for any.
They obey a linear system whose coefficients follow the gap, integrated by Radau collocation of order 5: each step is one
linear equation. Where no layer conducts or relaxes the charges are constant, and the fields are in closed form.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from electrovib.physics.amplifier import IDEAL, Amplifier
from electrovib.physics.drive.parts import Linear
from electrovib.solve.electrics.solution import MOVING_GAP, Solution
from electrovib.solve.electrics.steps import halved, jump_heights, smooth_grid, with_outputs
from electrovib.solve.electrics.transient import transient
from electrovib.solve.meter import Meter
from electrovib.solve.nonlinear.integrate import NODES, WEIGHTS
from electrovib.solve.stack.transfer import Transfer

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.physics.drive.base import Drive
    from electrovib.physics.motion import Distance
    from electrovib.solve.stack.keys import Key
    from electrovib.solve.stack.layer_states import StackStates


TOLERANCE = 1e-8
"""Error of the gap's field, over its largest value, at which the steps are fine enough."""
_ORDER = 3
"""Order that the error estimate assumes; the method has order 5, less under fast modes."""
_BLOCK = 1 << 18


def move_gap(
    space: StackStates,
    drive: Drive,
    time: Real,
    *,
    motion: Distance,
    amplifier: Amplifier = IDEAL,
) -> Solution:
    """Compute the response from rest of linear layers under a gap of prescribed thickness.

    `time` (n,) [s].

    E_k = (D_1 + Q_k - P_k)/(eps0 high_k), where D_1 follows from the sum of all voltages and dq/dt = J_k - J_(k+1).
    Steps are halved until the error is below `TOLERANCE`.
    """
    plate = DrivenPlate(drive, amplifier)
    moves = np.any(space.conductivities) or len(space.rates) or space.resistance
    if not (space.size and moves):
        # no charge can gather or leave between layers, and no voltage drops outside the stack
        states = np.repeat(space.start()[:, None], len(time), axis=1)
        return _moved(_signals(space, plate, time, states, motion), motion, 0, 0.0)
    gaps = motion.gap(np.linspace(0.0, float(time[-1]), 4001))
    extremes = np.array([np.min(gaps), np.max(gaps)])
    matrices, _ = _system(space, extremes, np.zeros(2))
    speed = float(np.max(np.abs(matrices).sum(axis=2))) + 1 / max(float(time[-1]), 1e-12)
    end = float(time[-1])
    grid = smooth_grid(drive, end=end, speed=speed, spans=_spans(motion, end), fastest=motion.fastest)

    def march(grid: Real) -> Real:
        states, voltage = _march(space, plate, grid, motion), plate.at(grid)[0]
        return np.asarray(space.moment(states, voltage=voltage, gap=motion.gap(grid)).field[space.moving])

    grid, _, _, error = halved(grid, march, np.asarray, order=_ORDER, tolerance=TOLERANCE)
    grid = with_outputs(grid, time)
    right = np.clip(np.searchsorted(grid, time), 0, len(grid) - 1)
    around = np.array([np.maximum(right - 1, 0), right])
    places = around[np.argmin(np.abs(grid[around] - time), axis=0), np.arange(len(time))]
    states = _march(space, plate, grid, motion)[:, places]
    return _moved(_signals(space, plate, time, states, motion), motion, len(grid) - 1, error)


def _moved(found: dict[Key, Real], motion: Distance, steps: int, error: float) -> Solution:
    """Return the solution with the reason for this solver and its error."""
    why = f"linear layers and a gap moved by {type(motion).__name__}: the charge is the state, from rest"
    how = f"{steps} steps; by halving them, the error of the gap's field is {error:.1e} of its largest value"
    if steps == 0:
        why, how = f"{why}; no charge gathers or leaves between layers", "so it is constant: closed form"
    reason = f"{why}, {how}"
    return Solution(found=found, method=MOVING_GAP, reason=reason, errors={"step_error": error}, steps=steps)


def _spans(motion: Distance, end: float) -> list[tuple[float, float]]:
    """Return the intervals [s] in which the gap changes, split at the breaks of the motion."""
    marks = [0.0, *(each for each in motion.breaks() if 0 < each < end), end]
    inside = np.linspace(0.0, 1.0, 16, endpoint=False)[1:]
    return [(a, b) for a, b in pairwise(marks) if np.any(motion.rate(a + (b - a) * inside))]


def _system(space: StackStates, gap: Real, closing: Real) -> tuple[Real, Real]:
    """Return matrix (n, size, size) and column (n, size) of rate = matrix state + column voltage over n gaps, without slope."""
    rates = np.empty((len(gap), space.size, space.size + 1))
    for which in range(space.size + 1):  # each state, and the voltage, by itself
        state = np.zeros((space.size, len(gap)))
        state[which : which + 1] = 1.0
        moment = space.moment(state, voltage=float(which == space.size), gap=gap, closing=closing)
        rates[..., which] = space.rate(state, moment, slope=0.0).T
    return rates[..., :-1], rates[..., -1]


def _on_resistance(space: StackStates) -> Real:
    """Return the share of a change of the voltage in each state: all of it in the voltage of a series resistance."""
    share = np.zeros(space.size)
    share[len(space.charges) + len(space.rates) :] = 1.0
    return share


def _march(space: StackStates, plate: DrivenPlate, grid: Real, motion: Distance) -> Real:
    """Return the states at the ends of all steps, after discontinuities of the drive; shape (size, len(grid))."""
    size, heights = space.size, plate.jumps(grid)
    states = np.empty((len(grid), size))
    state = space.start()
    chunk = max(1, _BLOCK // (9 * size**2))
    jumps = _on_resistance(space)
    states[0] = state = state + jumps * heights[0]
    meter = Meter("the moving gap", end=float(grid[-1]), held=(14 + 4 * size) * len(grid))
    for first in range(0, len(grid) - 1, chunk):
        meter.count(float(grid[first]))
        piece = grid[first : first + chunk + 1]
        carried, added = _carry(space, plate, piece, motion)
        pushed = added + np.multiply.outer(heights[first + 1 : first + len(piece)], jumps)
        for index, (carry, push) in enumerate(zip(carried, pushed, strict=True), start=first + 1):
            states[index] = state = carry @ state + push
    return states.T


def _carry(space: StackStates, plate: DrivenPlate, grid: Real, motion: Distance) -> tuple[Real, Real]:
    """Return the matrix and the vector that advance the state over each step."""
    size, steps = space.size, np.diff(grid)
    times = (grid[:-1, None] + steps[:, None] * NODES).ravel()
    matrix, column = _system(space, motion.gap(times), motion.rate(times))
    voltage, slope = (each.reshape(-1, 1) for each in plate.within(grid))
    forced = (column * voltage + _on_resistance(space) * slope).reshape(len(steps), 3, size)
    matrix = matrix.reshape(len(steps), 3, size, size)
    blocks = -np.einsum("n,ij,njab->niajb", steps, WEIGHTS, matrix).reshape(len(steps), 3 * size, 3 * size)
    blocks += np.eye(3 * size)
    right = np.empty((len(steps), 3, size, size + 1))
    right[..., :size] = np.eye(size)
    right[..., size] = np.einsum("n,ij,nja->nia", steps, WEIGHTS, forced)
    found = np.linalg.solve(blocks, right.reshape(len(steps), 3 * size, size + 1))[:, 2 * size :]
    return found[:, :, :size], found[:, :, size]


def _signals(
    space: StackStates, plate: DrivenPlate, time: Real, states: Real, motion: Distance
) -> dict[Key, Real]:
    (voltage, slope), gap = plate.at(time), motion.gap(time)
    moment = space.moment(states, voltage=voltage, gap=gap, closing=motion.rate(time))
    current = space.area * space.density(states, moment, slope=slope)
    return {
        "plate_voltage": voltage,
        "current": current,
        "amplifier_current": current + plate.amplifier.stray_capacitance * slope,
        "gap": gap,
    } | space.named(states, moment, gap=gap)


@dataclass(frozen=True)
class DrivenPlate:
    """Voltage of the plate behind an amplifier without limits."""

    drive: Drive
    amplifier: Amplifier

    @property
    def corner(self) -> float | None:
        """Rate of the amplifier's pole [1/s]; None without one."""
        band = self.amplifier.bandwidth
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
            value = value + np.where(on, part.whenever(times), 0.0)
            slope = slope + np.where(on, part.slope_whenever(times), 0.0)
        if self.corner is None:
            return self.amplifier.gain * value, self.amplifier.gain * slope
        plate = self.lagging(times.ravel()).reshape(times.shape)
        return plate, self.corner * (self.amplifier.gain * value - plate)

    def at(self, times: Real) -> tuple[Real, Real]:
        """Return the voltage and its rate just after some times.

        `times` (n,) [s]; returns `voltage`, `slope` (n,) [V].
        """
        value = self.amplifier.gain * self.drive.voltage(times)
        if self.corner is None:
            return value, self.amplifier.gain * self.drive.slope(times)
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
        return self.amplifier.gain * heights

    def lagging(self, times: Real) -> Real:
        """Return the voltage behind the amplifier's pole.

        `times` (n,) [s]; returns `voltage` (n,) [V].
        """
        assert self.corner is not None
        pole = Transfer(rates=np.array([self.corner]), gains=np.array([self.amplifier.gain]))
        return transient({"v": pole}, self.drive, times)["v"]
