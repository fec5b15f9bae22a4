"""The result of a design of a drive."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.diagnostics import warning_lines
from electrovib.core.units import format_quantity
from electrovib.study.design.drive.harmonics import harmonics

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.core.diagnostics import Diagnostic
    from electrovib.scenario import Scenario
    from electrovib.study.check import CheckResult, DeclaredLimit, LimitsSource
    from electrovib.study.design.drive.found import FoundDrive
    from electrovib.study.design.drive.target import Target

TRACKED: Final = 0.01
"""Misfit up to which a target counts as followed [1]."""
_BINDING: Final = 0.99
"""Share of a limit from which on it counts as binding [1]."""
_NEGLIGIBLE: Final = 1e-6
"""Relative amplitude below which harmonics are not listed [1]."""
_SLOW: Final = 10.0
"""Carrier over the highest frequency of the target below which a warning is given."""


@dataclass(frozen=True, kw_only=True)
class DesignedDrive:
    """A drive for a target of the force, with the force that the full model predicts.

    - `scenario`: experiment under the drive, from rest; it can be simulated, checked and exported.
    - `target`, `method`: as they were asked for.
    - `solution`: samples of the drive, and what limits it.
    - `predicted`: force by the full model, averaged over each interval [N].
    - `bounds`: limits that the design held; `limits`: further limits that were given.
    - `check`: comparison of the drive with the limits and with breakdown.
    """

    scenario: Scenario
    target: Target
    method: str
    solution: FoundDrive
    predicted: Real
    bounds: dict[str, DeclaredLimit]
    limits: tuple[LimitsSource, ...]
    check: CheckResult

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
    def lines(self) -> tuple[str, ...]:
        """Sentences and numbers for people, the answer first."""
        return (*self.notes, *self._doubts(), *warning_lines(self.diagnostics, brief=True))

    verdict = lines

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """Diagnostics of the scenario under the drive, beyond those that the check states."""
        return self.check.diagnostics

    @property
    def notes(self) -> tuple[str, ...]:
        """What the drive is, its misfit and what bounds it, as a file of the drive states it."""
        return (*self._drive_lines(), *self._misfit_lines(), *self._limit_lines())

    def to_dict(self) -> dict[str, Any]:
        """Return everything as nested tables with numbers in SI."""
        return {
            "method": self.method,
            "target": self.target.text,
            "quantity": self.quantity,
            "carrier": self.carrier,
            "rate": self.rate,
            "misfit": self.misfit,
            "scale": self.scale if math.isfinite(self.scale) else None,
            "achieved": self.is_achieved,
            "binding": list(self.binding),
            "limited_share": self.limited_share,
            "searches": {"made": self.solution.searches, "agreeing": self.solution.agreeing},
            "harmonics": {str(order): value for order, value in self.harmonics.items()},
            "lines": list(self.lines),
            "diagnostics": [each.to_dict() for each in self.diagnostics],
            "samples": {"time": self.times.tolist(), self.quantity: self.values.tolist()},
            "force": {
                "edges": self.edges.tolist(),
                "wanted": self.wanted.tolist(),
                "predicted": self.predicted.tolist(),
            },
        }

    def _drive_lines(self) -> list[str]:
        unit = "V" if self.quantity == "voltage" else "A"
        peak = format_quantity(float(np.max(np.abs(self.values))), unit, digits=4)
        carried = ramps = ""
        if self.carrier is not None:
            carried = f" with a carrier of {format_quantity(self.carrier, 'Hz', digits=6)}"
        else:
            lead = format_quantity(float(self.edges[0]), "s", digits=4)
            ramps = f"; straight ramps of {lead} from and to 0 V before and after the target"
        return [
            f"target: {self.target.text}",
            f"drive by method {self.method}{carried}: largest {self.quantity} {peak}, {len(self.times)} samples at"
            f" {format_quantity(self.rate, 'Hz', digits=6)}{ramps}",
        ]

    def _misfit_lines(self) -> list[str]:
        over = "each interval between samples" if self.carrier is None else "each period of the carrier"
        off = np.abs(self.predicted - self.wanted)
        found = [
            f"predicted force, averaged over {over}: departs from the target by {100 * self.misfit:.3g} % (root mean square over"
            f" that of the target), {format_quantity(float(np.max(off)), 'N', digits=3)} at most"
        ]
        if self.harmonics:
            first, *others = self.harmonics.values()
            listed = f"below {100 * _NEGLIGIBLE:g} %"
            if max(others, default=0.0) >= _NEGLIGIBLE:
                listed = ", ".join(f"{100 * each:.2g} %" for each in others)
            found.append(
                f"amplitude of the predicted force at the frequency of the target: {100 * first:.4g} % of the wanted one; at"
                f" 2 to {len(others) + 1} times that frequency: {listed}"
            )
        return found

    def _limit_lines(self) -> list[str]:
        if not self.binding:
            if math.isfinite(self.scale):
                return [f"no limit binds: up to {self.scale:.4g} times the target is within the limits"]
            return ["no limit binds" if self.bounds else "no limit was declared that the design has to hold"]
        which = "; ".join(f"limits.{name} ({self.bounds[name].source})" for name in self.binding)
        return [
            f"the target is not within the limits: {which} prevents it in {100 * self.limited_share:.3g} % of the time. This"
            f" drive has the smallest mean square of the departure that was found; {self.scale:.4g} times the target would be"
            " within the limits",
            *self._search_lines(),
        ]

    def _search_lines(self) -> list[str]:
        searches, agreeing = self.solution.searches, self.solution.agreeing
        if not searches:
            return []
        sentence = f"{agreeing} of {searches} searches from different starts end within 1 % of the smallest misfit among them"
        if agreeing < 2:
            sentence += ": another drive may follow the target better"
        return [sentence]

    def _doubts(self) -> list[str]:
        found = [row.text for row in self.check.failed]
        if missing := [name for name in ("voltage", "current") if name not in self.bounds]:
            named = " and ".join(f"limits.{name}" for name in missing)
            found.append(
                f"{named} not declared: the drive was not designed to hold it, and cannot be written as a waveform"
            )
        if self.carrier is not None and self.carrier < _SLOW * self.target.highest_frequency * (1 - 1e-9):
            found.append(
                "the carrier is below ten times the highest frequency of the target: within a period of the carrier the target"
                " changes much"
            )
        return found
