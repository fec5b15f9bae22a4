"""Response over time: exact for piecewise linear drives and sines at any output times, from rest or a given state."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, TypeVar

import numpy as np

from electrovib.physics.drive.parts import Chirped, Part, Tones, circling
from electrovib.physics.drive.pieces import Linear
from electrovib.solve.electrics.formulas import chirp_response, smooth_states
from electrovib.solve.electrics.straight import fading, periodic_state, straight_response
from electrovib.solve.recursion.blocks import PRODUCT
from electrovib.solve.stack.harmonics import count_harmonics, refuse_unrepeated, settled_integral
from electrovib.solve.stack.transfer import integral_weight, without_integrators

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from electrovib.core.arrays import Indices, Real
    from electrovib.physics.drive.base import Drive
    from electrovib.solve.stack.transfer import Transfer


K = TypeVar("K")
_MANY: Final = 10_000
"""Number of times from which it saves work to find outputs that are multiples of others."""
_SAME: Final = 4 * float(np.finfo(float).eps)


def transient(
    transfers: Mapping[K, Transfer], drive: Drive, time: Real, *, settled: bool = False
) -> dict[K, Real]:
    """Compute the response of linear quantities to a drive.

    `time` (n,) [s].

    x' = rate (v - x) for each mode; y = direct v + slope v' + sum gain x + sum free exp(-rate t). Where the
    response at zero frequency is known separately, y = static v + slope v' + sum gain (x - v) + ...: a small current
    is then not the difference of two large ones. From rest an integrator is exact as one more slow mode; in the
    periodic state its charge is counted from its own mean, because the drive does not determine a constant charge.
    """
    if settled:
        refuse_unrepeated(drive)
    weights = {name: integral_weight(transfer) for name, transfer in transfers.items()} if settled else {}
    if any(weights.values()):
        integral = settled_integral(drive, time)
        relaxing = {name: without_integrators(transfer) for name, transfer in transfers.items()}
        rest = transient(relaxing, drive, time, settled=True)
        return {name: row + weights[name] * integral for name, row in rest.items()}
    result: dict[K, Real] = {}
    slope = drive.slope(time) if any(transfer.slope for transfer in transfers.values()) else None
    for names, rates in _groups(transfers):
        group = [transfers[name] for name in names]
        lag = np.array([transfer.static is not None for transfer in group])
        direct = np.array(
            [transfer.direct if transfer.static is None else transfer.static for transfer in group]
        )
        gains = np.array([transfer.gains for transfer in group])
        free = np.array([transfer.free for transfer in group])
        active = np.any(gains != 0, axis=0) & (rates > 0)
        output = _Output(rates[active], gains[:, active], direct, lag)
        modal = output.of(drive.parts(), time, settled=settled)
        kept = free * (rates == 0) if settled else free  # only trapped charge remains in the periodic state
        if np.any(kept):
            modal = [row + left for row, left in zip(modal, fading(kept, rates, time), strict=True)]
        for name, transfer, row in zip(names, group, modal, strict=True):
            result[name] = row
            if transfer.slope and slope is not None:
                result[name] += transfer.slope * slope
    return result


def how_it_begins(drive: Drive, *, settled: bool) -> str:
    """Return in words from which state a response begins, and for which drives it is exact."""
    count = count_harmonics(drive) if settled else None
    how = f"exact (harmonics of the drive: {count})" if count else "exact for straight pieces and sines"
    return f"from {'the periodic state' if settled else 'rest'}, {how}"


def _groups(transfers: Mapping[K, Transfer]) -> list[tuple[list[K], Real]]:
    """Collect quantities with the same modes, so that these are computed once."""
    groups: list[tuple[list[K], Real]] = []
    for name, transfer in transfers.items():
        for names, rates in groups:
            if rates is transfer.rates or np.array_equal(rates, transfer.rates):
                names.append(name)
                break
        else:
            groups.append(([name], transfer.rates))
    return groups


@dataclass(frozen=True)
class _Output:
    """Quantities that share their modes.

    Parameters
    ----------
    rates : ndarray, shape (modes,)
        Rates of the modes [1/s], > 0.
    gains : ndarray, shape (outputs, modes)
        Weight of each mode x, or of its lag x - v, in each quantity.
    direct : ndarray, shape (outputs,)
        Weight of the drive v itself in each quantity.
    lag : ndarray of bool, shape (outputs,)
        Which quantities take the lags.
    """

    rates: Real
    gains: Real
    direct: Real
    lag: NDArray[np.bool_]

    def of(self, parts: Sequence[Part], time: Real, *, settled: bool) -> list[Real]:
        """Return the response to the sum of some parts of a drive [V], each output in an array of its own."""
        if len(time) < _MANY:
            return self._sum(parts, time, settled=settled)
        first, share = self._multiples()
        own, place = np.unique(first, return_inverse=True)
        alone = _Output(self.rates, self.gains[own], self.direct[own], self.lag[own])
        found = alone._sum(parts, time, settled=settled)
        return [
            found[among] if here == place_of else found[among] * factor
            for here, (among, factor, place_of) in enumerate(
                zip(place.tolist(), share.tolist(), first.tolist(), strict=True)
            )
        ]

    def _multiples(self) -> tuple[Indices, Real]:
        """Return for each output the first one of which it is a multiple, and the factor: D = eps0 eps E of a layer."""
        rows = np.concatenate([self.direct[:, None], self.gains], axis=1)
        first, share = np.arange(len(rows)), np.ones(len(rows))
        for later in range(1, len(rows)):
            for earlier in np.unique(first[:later]).tolist():
                top = int(np.argmax(np.abs(rows[earlier])))
                if self.lag[later] != self.lag[earlier] or not rows[earlier, top]:
                    continue
                factor = float(rows[later, top] / rows[earlier, top])
                if np.all(np.abs(rows[later] - factor * rows[earlier]) <= _SAME * np.abs(rows[later])):
                    first[later], share[later] = earlier, factor
                    break
        return first, share

    def _sum(self, parts: Sequence[Part], time: Real, *, settled: bool) -> list[Real]:
        """Return the response to the sum of some parts [V], without use of multiples."""
        total: list[Real] = []
        for part in parts:
            found = self._of_part(part, time, settled=settled)
            total = (
                [np.add(row, more, out=row) for row, more in zip(total, found, strict=True)]
                if total
                else found
            )
        return total or [np.zeros(len(time)) for _ in self.direct]

    def _of_part(self, part: Part, time: Real, *, settled: bool) -> list[Real]:
        """Return the response to one part [V]."""
        if not len(self.rates):
            return list(np.outer(self.direct, part.value(time)))
        match part:
            case Tones():
                return _tones(part, self, time, settled=settled)
            case Linear() if settled and part.is_step:  # a constant to which the modes have settled
                reached = self.direct + np.where(self.lag, 0.0, self.gains.sum(axis=1))
                return list(np.outer(reached, part.value(time)))
            case Linear():
                start = periodic_state(part, self.rates) if settled else np.zeros(len(self.rates))
                return straight_response(
                    part, self.rates, self.gains, time, start, direct=self.direct, lag=self.lag
                )
        now, chirp = part.value(time), part if isinstance(part, Chirped) else None
        found = np.outer(self.direct, now)
        states = smooth_states(part, self.rates, time) if chirp is None else now
        for lag in {*self.lag.tolist()}:
            some = self.lag == lag
            if chirp is None:
                found[some] += self.gains[some] @ (states - now if lag else states)
            else:
                found[some] += chirp_response(chirp, self.rates, self.gains[some], time, lag=lag)
        return list(found)


def part_lag(part: Part, rates: Real, gains: Real, time: Real) -> Real:
    """Compute the response from rest of modes to a part of a drive, less that part, shape (outputs, n) [V]."""
    lag = np.ones(len(gains), bool)
    return np.array(_Output(rates, gains, np.zeros(len(gains)), lag).of([part], time, settled=False))


def _tones(part: Tones, output: _Output, time: Real, *, settled: bool) -> list[Real]:
    """Return the steady state of each tone, minus its modes' value at the switching times, which decays from there."""
    angular = 2j * np.pi * part.frequencies
    response = np.asarray(
        output.rates[:, None] / (output.rates[:, None] + angular), complex
    )  # of mode to tone
    lagging = -angular / (output.rates[:, None] + angular)
    modal = np.where(output.lag[:, None], output.gains @ lagging, output.gains @ response)
    steady = (output.direct[:, None] + modal) * part.amplitudes
    start = part.start if settled and np.isinf(part.start) else max(part.start, 0.0)
    on = slice(*np.searchsorted(time, [start, part.stop]))
    found = [np.empty(len(time)) for _ in steady]
    for row in found:
        row[: on.start] = row[on.stop :] = 0.0
    waves = [wave for frequency in part.frequencies.tolist() for wave in circling(frequency, time[on])]
    shares = np.stack([steady.real, -steady.imag], axis=2).reshape(len(steady), -1)
    length = max(1, PRODUCT // max(1, shares.size))
    for first in range(on.start, on.stop, length):
        some = slice(first, min(first + length, on.stop))
        seen = [wave[some.start - on.start : some.stop - on.start] for wave in waves]
        for row, each in zip(found, shares @ np.stack(seen), strict=True):
            row[some] = each
    for switched, sign in ((start, -1.0), (part.stop, 1.0)):
        if np.isfinite(switched):
            phasors = part.amplitudes * np.exp(angular * switched)
            then = sign * output.gains * (response @ phasors).real
            first = int(np.searchsorted(time, switched))
            for row, left in zip(found, fading(then, output.rates, time[first:] - switched), strict=True):
                row[first:] += left
    return found
