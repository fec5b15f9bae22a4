"""The result of a design of a drive."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.units import format_quantity
from electrovib.studies.check.declared import NEEDED
from electrovib.studies.design.result import Designed

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.core.diagnostics import Diagnostic
    from electrovib.scenario import Scenario
    from electrovib.studies.check import CheckResult, DeclaredLimit
    from electrovib.studies.design.drive.played import FoundDrive
    from electrovib.studies.design.drive.target import Target

TRACKED: Final = 0.01
"""Misfit up to which a target counts as followed [1]."""
MOST: Final = 5
"""Highest multiple of the frequency of the target whose amplitude is stated."""
_BINDING: Final = 0.99
"""Share of a limit from which on it counts as binding [1]."""
_NEGLIGIBLE: Final = 1e-6
"""Relative amplitude below which harmonics are not listed [1]."""
_SLOW: Final = 10.0
"""Carrier over the highest frequency of the target below which a warning is given."""


@dataclass(frozen=True, kw_only=True, repr=False)
class DesignedDrive(Designed):
    """A drive for a target of the force, with the force that the full model predicts.

    - `target`, `method`: as they were asked for.
    - `solution`: samples of the drive, and what limits it.
    - `predicted`: force by the full model, averaged over each interval [N].
    - `bounds`: limits that the design held.
    - `check`: comparison of the drive with the limits and with breakdown.
    """

    form = "drive"
    target: Target
    method: str
    solution: FoundDrive
    predicted: Real
    bounds: dict[str, DeclaredLimit]
    check: CheckResult

    @property
    def scenario(self) -> Scenario:
        """Experiment under the drive, from rest; it can be simulated, checked and exported."""
        return self.check.scenario

    @property
    def times(self) -> Real:
        """Times of the samples [s], from 0."""
        return self.solution.times

    @property
    def values(self) -> Real:
        """Samples of the drive [V; A of a current drive]."""
        return self.solution.values

    @property
    def quantity(self) -> str:
        """What the drive prescribes, ``"voltage"`` or ``"current"``."""
        return self.scenario.drive.quantity

    @property
    def rate(self) -> float:
        """Samples per second [Hz]."""
        return self.solution.rate

    @property
    def carrier(self) -> float | None:
        """Frequency of the carrier [Hz]; None without one."""
        return self.solution.carrier

    @property
    def edges(self) -> Real:
        """Ends of the intervals over which forces are averaged [s], the periods of a carrier; shape (n + 1,)."""
        return self.solution.edges

    @property
    def wanted(self) -> Real:
        """Target averaged over each interval [N], shape (n,)."""
        return self.solution.wanted

    @functools.cached_property
    def misfit(self) -> float:
        """Root mean square of predicted less wanted force over that of the wanted one [1]."""
        size = float(np.mean(self.wanted**2))
        off = float(np.mean((self.predicted - self.wanted) ** 2))
        return math.sqrt(off / size) if size else (math.inf if off else 0.0)

    @property
    def scale(self) -> float:
        """Largest multiple of the target that is within the limits without a compromise [1]; infinite without limits."""
        return self.solution.scale

    @property
    def binding(self) -> tuple[str, ...]:
        """Names of the limits that prevent the target; empty where none does."""
        if not np.any(self.solution.limited):
            return ()
        return tuple(name for name, ratio in self.solution.ratios.items() if ratio >= _BINDING)

    @property
    def limited_share(self) -> float:
        """Share of the time in which a limit prevents the target [1]."""
        return float(np.mean(self.solution.limited))

    @property
    def is_achieved(self) -> bool:
        """Whether the predicted force follows the target to 1 % and no row of the check fails."""
        return self.misfit <= TRACKED and not self.check.failed

    @functools.cached_property
    def harmonics(self) -> dict[int, float]:
        """Amplitudes at multiples of the target's frequency, over the wanted one at it; empty for a target without one."""
        return harmonics(self.edges, self.predicted, self.wanted, self.target.frequency)

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """Diagnostics of the scenario under the drive, beyond those that the check states."""
        return self.check.diagnostics

    @property
    def sentences(self) -> tuple[str, ...]:
        """What the drive is, its misfit, what bounds it, and what makes it doubtful."""
        return (*self.notes, *_doubts(self))

    @property
    def notes(self) -> tuple[str, ...]:
        """What the drive is, its misfit and what bounds it, as a file of the drive states it."""
        return (f"target: {self.target.text}", _drive(self), *_misfit(self), *_limits(self))

    def numbers(self) -> dict[str, Any]:
        """Return all numbers as nested tables."""
        solution = self.solution
        return {
            "method": self.method,
            "target": self.target.text,
            "quantity": self.quantity,
            "carrier": self.carrier,
            "rate": self.rate,
            "misfit": self.misfit,
            "scale": self.scale,
            "binding": self.binding,
            "limited_share": self.limited_share,
            "searches": {"made": solution.searches, "agreeing": solution.agreeing},
            "harmonics": self.harmonics,
            "samples": {"time": self.times, self.quantity: self.values},
            "force": {"edges": self.edges, "wanted": self.wanted, "predicted": self.predicted},
        }


def _drive(found: DesignedDrive) -> str:
    unit = "V" if found.quantity == "voltage" else "A"
    peak = format_quantity(float(np.max(np.abs(found.values))), unit, digits=4)
    carried = ramps = ""
    if found.carrier is not None:
        carried = f" with a carrier of {format_quantity(found.carrier, 'Hz', digits=6)}"
    else:
        lead = format_quantity(float(found.edges[0]), "s", digits=4)
        ramps = f"; straight ramps of {lead} from and to 0 V before and after the target"
    return (
        f"drive by method {found.method}{carried}: largest {found.quantity} {peak}, {len(found.times)} samples at"
        f" {format_quantity(found.rate, 'Hz', digits=6)}{ramps}"
    )


def _misfit(found: DesignedDrive) -> list[str]:
    over = "each interval between samples" if found.carrier is None else "each period of the carrier"
    most = format_quantity(float(np.max(np.abs(found.predicted - found.wanted))), "N", digits=3)
    lines = [
        f"predicted force, averaged over {over}: departs from the target by {100 * found.misfit:.3g} % (root mean square over"
        f" that of the target), {most} at most"
    ]
    if found.harmonics:
        first, *others = found.harmonics.values()
        listed = f"below {100 * _NEGLIGIBLE:g} %"
        if max(others, default=0.0) >= _NEGLIGIBLE:
            listed = ", ".join(f"{100 * each:.2g} %" for each in others)
        lines.append(
            f"amplitude of the predicted force at the frequency of the target: {100 * first:.4g} % of the wanted one; at"
            f" 2 to {len(others) + 1} times that frequency: {listed}"
        )
    return lines


def _limits(found: DesignedDrive) -> list[str]:
    if not found.binding:
        if math.isfinite(found.scale):
            return [f"no limit binds: up to {found.scale:.4g} times the target is within the limits"]
        return ["no limit binds" if found.bounds else "no limit was declared that the design has to hold"]
    which = "; ".join(f"limits.{name} ({found.bounds[name].source})" for name in found.binding)
    lines = [
        f"the target is not within the limits: {which} prevents it in {100 * found.limited_share:.3g} % of the time. This"
        f" drive has the smallest mean square of the departure that was found; {found.scale:.4g} times the target would be"
        " within the limits"
    ]
    searches, agreeing = found.solution.searches, found.solution.agreeing
    if searches:
        doubt = ": another drive may follow the target better" if agreeing < 2 else ""
        lines.append(
            f"{agreeing} of {searches} searches from different starts end within 1 % of the smallest misfit among them{doubt}"
        )
    return lines


def _doubts(found: DesignedDrive) -> list[str]:
    lines = [row.text for row in found.check.failed]
    if missing := [f"limits.{name}" for name in NEEDED if name not in found.bounds]:
        lines.append(
            f"{' and '.join(missing)} not declared: the drive was not designed to hold it, and cannot be written as a waveform"
        )
    if found.carrier is not None and found.carrier < _SLOW * found.target.highest_frequency * (1 - 1e-9):
        lines.append(
            "the carrier is below ten times the highest frequency of the target: within a period of the carrier the target"
            " changes much"
        )
    return lines


def harmonics(edges: Real, predicted: Real, wanted: Real, frequency: float | None) -> dict[int, float]:
    """Return amplitudes at 1 to 5 times a frequency, over the wanted amplitude at that frequency.

    They are fitted to means over intervals by least squares of a constant and all sines over the last whole
    periods, without the first one if there are several; a multiple needs intervals shorter than half its
    period.
    """
    if frequency is None:
        return {}
    whole = math.floor(float(edges[-1] - edges[0]) * frequency * (1 + 1e-9))
    if whole < 1:
        return {}
    middles = (edges[1:] + edges[:-1]) / 2
    kept = middles >= edges[-1] - max(1, whole - 1) / frequency
    interval = float(edges[1] - edges[0])
    orders = [each for each in range(1, MOST + 1) if 2 * each * frequency * interval < 1]
    if not orders:
        return {}
    first = _amplitudes(middles[kept], wanted[kept], [frequency])[0]
    if first <= 0:
        return {}
    found = _amplitudes(middles[kept], predicted[kept], [each * frequency for each in orders])
    return {order: float(each / first) for order, each in zip(orders, found, strict=True)}


def _amplitudes(times: Real, values: Real, frequencies: list[float]) -> Real:
    """Return the amplitudes of sines and a constant fitted together, of the sines alone."""
    turns = 2 * np.pi * np.array(frequencies) * times[:, None]
    basis = np.column_stack([np.ones(len(times)), np.cos(turns), np.sin(turns)])
    found = np.linalg.lstsq(basis, values, rcond=None)[0][1:].reshape(2, -1)
    return np.asarray(np.hypot(*found))
