"""One layer with non-ohmic conduction: linear modes and one scalar nonlinear branch.

All linear parts keep their modes and their exact response to the drive. The leak is a current density J(E) in parallel
with one layer. Within a step it is taken as linear in time and the modes respond to it exactly; the field at the end of
the step follows from one scalar equation E + weight J(E) = known, which has one root because J never decreases. The
error is of second order in the step; it is measured by halving all steps, and reported. The returned response is
extrapolated from the last two step sizes, which makes it a hundred times better where the field crosses no kink of J.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.budget import Meter
from electrovib.physics.drive.pieces import Linear
from electrovib.solve.costs import SHORTER, leak_step
from electrovib.solve.electrics.leaks.steps import jump_heights, step_grid
from electrovib.solve.electrics.linear.straight import straight_response
from electrovib.solve.electrics.linear.transient import transient
from electrovib.solve.electrics.methods import LEAK
from electrovib.solve.electrics.solution import Solution
from electrovib.solve.recursion import hold_weights

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Real
    from electrovib.physics.conduction import Conduction
    from electrovib.physics.drive.base import Drive
    from electrovib.solve.stack.keys import FieldOf, Key
    from electrovib.solve.stack.transfer import Transfer

TOLERANCE = 2e-5
"""Error of the layer's field over its largest value, before extrapolation, at which the steps are fine enough."""
MOST_HALVINGS = 4
_CHUNK = 1 << 14
_ROUNDING = 16 * float(np.finfo(float).eps)
_ROOT = float(np.sqrt(np.finfo(float).eps)) / 4


def leaky_response(
    driven: Mapping[Key, Transfer],
    leaking: Mapping[Key, Transfer],
    drive: Drive,
    time: Real,
    *,
    leak: Conduction,
    control: FieldOf,
) -> Solution:
    """Compute the response from rest of quantities that are linear in a drive and in one leak.

    `time` (n,) [s].

    Steps are halved until the error is below `TOLERANCE`, `MOST_HALVINGS` times at most.
    """
    grid = step_grid(drive, time, driven[control], leaking[control], leak=leak)
    meter = Meter(
        "the leaking layer", end=float(time[-1]), each=leak_step(len(driven[control].rates)), remedy=SHORTER
    )
    meter.expect(len(grid))
    coarse = follow(driven[control], leaking[control], drive, grid, leak=leak)
    fine, error = coarse, 0.0
    for _ in range(MOST_HALVINGS):
        coarse = fine
        meter.expect(2 * len(grid))
        grid = np.unique(np.concatenate([grid, (grid[:-1] + grid[1:]) / 2]))
        fine = follow(driven[control], leaking[control], drive, grid, leak=leak)
        error = fine.distance(coarse)
        if error < TOLERANCE:
            break
    found = transient(driven, drive, time)
    for name, transfer in leaking.items():
        answers = [_under(march.flow(), transfer, time) for march in (fine, coarse)]
        found[name] = found[name] + answers[0] + (answers[0] - answers[1]) / 3
    why = (
        f"layer '{control.layer}' leaks by {type(leak).__name__}, which is non-ohmic: linear modes and one nonlinear branch"
        f" from rest, {len(grid) - 1} steps; by halving them, the error of its field before extrapolation is {error:.1e} of"
        " its largest value"
    )
    return Solution(found=found, method=LEAK, reason=why, errors={"step_error": error}, steps=len(grid) - 1)


def _under(flow: Linear, transfer: Transfer, time: Real) -> Real:
    """Return the response to the leak's current density, which is linear in time within each step."""
    active = transfer.gains != 0
    direct: Real = transfer.direct * flow.value(time)
    if not np.any(active):
        return direct
    rest = np.zeros(int(np.count_nonzero(active)))
    gains = transfer.gains[None, active]
    modal: Real = straight_response(flow, transfer.rates[active], gains, time, rest)[0]
    return direct + modal


@dataclass(frozen=True, kw_only=True)
class LeakMarch:
    """Field and current density of the leaking layer at the ends of all steps, before and after drive discontinuities."""

    grid: Real
    before: Real
    after: Real
    flow_before: Real
    flow_after: Real

    def flow(self) -> Linear:
        """Return the leak's current density, linear in time within each step."""
        return Linear(self.grid, self.flow_before, self.flow_after)

    def distance(self, coarser: LeakMarch) -> float:
        """Return the error of this integration from one with steps twice as long: a third of the difference."""
        common = np.searchsorted(self.grid, coarser.grid)
        moved = np.abs([self.before[common] - coarser.before, self.after[common] - coarser.after])
        return float(np.max(moved)) / 3 / (float(np.max(np.abs([self.before, self.after]))) or 1.0)


def follow(driven: Transfer, leaking: Transfer, drive: Drive, grid: Real, *, leak: Conduction) -> LeakMarch:
    """Integrate the field of a leaking layer over given steps.

    `grid` (n,) [s].
    """
    free = transient({"field": driven}, drive, grid)["field"]
    jumps = driven.direct * jump_heights(drive, grid)
    active = leaking.gains != 0
    rates, gains = leaking.rates[active], leaking.gains[active]
    before, after, flow_before, flow_after = np.zeros((4, len(grid)))
    after[0] = free[0]
    flow_after[0] = leak.current_density(free[0])
    state, density, field, trend = np.zeros(len(rates)), float(flow_after[0]), float(after[0]), 0.0
    for begin in range(0, len(grid) - 1, _CHUNK):
        steps = np.diff(grid[begin : begin + _CHUNK + 1])
        decays, firsts, lasts = hold_weights(-np.outer(steps, rates))
        weights = -(lasts @ gains)
        for index, weight in enumerate(weights.tolist()):
            now = begin + index + 1
            state = decays[index] * state + firsts[index] * density
            known = float(free[now] - jumps[now] + gains @ state)
            last, size = field, float(steps[index])
            field = field_under_leak(leak, known=known, weight=weight, guess=last + trend * size)
            trend, density = (field - last) / size, float(leak.current_density(field))
            state = state + lasts[index] * density
            before[now], flow_before[now] = field, density
            if jumps[now]:
                field = field + float(jumps[now])
                density = float(leak.current_density(field))
            after[now], flow_after[now] = field, density
    return LeakMarch(grid=grid, before=before, after=after, flow_before=flow_before, flow_after=flow_after)


def field_under_leak(leak: Conduction, *, known: float, weight: float, guess: float | None = None) -> float:
    """Solve E + weight J(E) = known for the field E.

    Newton's method within a shrinking bracket.
    """
    low, high = sorted((0.0, known))
    field = known if guess is None else min(max(guess, low), high)
    for _ in range(200):
        excess = field + weight * float(leak.current_density(field)) - known
        low, high = (low, min(high, field)) if excess > 0 else (max(low, field), high)
        step = excess / (1 + weight * float(leak.slope(field)))
        if low == high:
            break
        inside = low <= field - step <= high
        field = field - step if inside else (low + high) / 2
        if abs(step) <= (_ROOT if inside else _ROUNDING) * abs(field):  # the next step is its square
            break
    return field
