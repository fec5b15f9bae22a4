"""Design of a drive for a target of the electrostatic force, in words, and the largest constant force that drives hold."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from electrovib.core.answer import Document
from electrovib.core.arrays import Real
from electrovib.core.errors import InputError, nearest
from electrovib.core.units import format_quantity
from electrovib.physics.drive.current import CurrentSine
from electrovib.physics.drive.sines import Sine
from electrovib.scenario import Scenario, Source, read_scenario
from electrovib.studies.check import NEEDED, CheckResult, DeclaredLimit, LimitsSource, checked, several_limits
from electrovib.studies.check.amplifier import LARGEST, without_its_limits
from electrovib.studies.check.result import not_shown
from electrovib.studies.design.drive.carrier import FoundDrive, Played, design_carrier
from electrovib.studies.design.drive.direct import design_direct
from electrovib.studies.design.drive.target import Target, TargetSource, force_panel, read_target
from electrovib.studies.design.limits import Bounds
from electrovib.studies.design.result import Designed
from electrovib.studies.design.wanted import read_number

METHODS: Final = {
    "dc": "a slow voltage without a carrier, by the inverse of root, leak and dispersion",
    "carrier": "a carrier whose envelope is corrected until its mean force over each period is the target",
    "sqrt-am": "a carrier whose envelope is the square root of the target over the gain at the carrier, not corrected",
    "current": "as carrier, with a prescribed current",
}
"""Methods with their meanings."""


def drive_for_force(
    scenario: Source,
    *,
    target: TargetSource,
    method: str,
    carrier: float | str | None = None,
    rate: float | str | None = None,
    limits: LimitsSource | Sequence[LimitsSource] = None,
    set: Mapping[str, Any] | None = None,  # noqa: A002 - the name of the option
) -> DesignedDrive:
    """Find the drive whose predicted electrostatic force is a target, or that follows it best within the limits.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        As for `electrovib.load`; its drive is replaced.
    target : str, Path, Target or pair of array_like
        Force over time, which is never negative: ``"sine 50 Hz 30 mN"`` (between 0 and 30 mN), ``"sine 50 Hz 10 mN to 30 mN
        for 0.2 s"``, ``"constant 5 mN for 1 s"``, a file with the columns time and force, or times [s] and forces [N].
    method : str
        ``"dc"``, a slow voltage; ``"carrier"``, a carrier whose envelope is corrected; ``"sqrt-am"``, one that is not; or
        ``"current"``, a carrier of a prescribed current.
    carrier : float or str, optional
        Frequency of the carrier [Hz]; by default the one that allows the largest force, from the larger of 1 kHz and ten
        times the highest frequency of the target on.
    rate : float or str, optional
        Samples per second [Hz]; by default 64 in a period of the carrier, or 40 in one of the target.
    limits : str, Path, mapping, Limits, or a list of them, optional
        Further limits beside those of the scenario; the strictest counts.
    set : mapping of str to value, optional
        Dotted path to value, put into the scenario.

    Returns
    -------
    DesignedDrive
        Samples, the force that the full model predicts, and what bounds it; `scenario` has the drive.

    Raises
    ------
    InputError
        For mistakes, a set-up whose force does not follow the square of the drive, and limits that no drive holds.

    Examples
    --------
    >>> import electrovib as ev
    >>> limits = {"voltage": "1 kV", "current": "1 mA"}
    >>> found = ev.drive_for_force("bau_2010/sine", target="sine 5 Hz 1 mN", method="carrier", limits=limits)
    >>> found.is_achieved
    True
    """
    base = read_scenario(scenario, changes=set)
    if method not in METHODS:
        raise InputError(
            f"expected one of {', '.join(METHODS)}.{nearest(str(method), METHODS)}",
            path="method",
            value=str(method),
        )
    wanted = read_target(target)
    frequency = None if carrier is None else read_number(carrier, "Hz", "carrier")
    samples = None if rate is None else read_number(rate, "Hz", "rate")
    if method == "dc" and frequency is not None:
        raise InputError("method 'dc' has no carrier; omit it, or take another method", path="carrier")
    bounds = Bounds.of(base, limits)
    of_current, of_voltage = CurrentSine(amplitude=1e-6, frequency=1e3), Sine(amplitude=1.0, frequency=1e3)
    prescribed = of_current if method == "current" else of_voltage
    own = base.model_copy(update={"drive": prescribed})  # which the design replaces
    linear = without_its_limits(own, LARGEST)
    if method == "dc":
        found = design_direct(linear, wanted, bounds, rate=samples)
    else:
        corrected = method != "sqrt-am"
        found = design_carrier(linear, wanted, bounds, carrier=frequency, rate=samples, corrected=corrected)
    played = Played(own, found.rate)
    several = several_limits(limits)
    if own is not linear:
        found = replace(found, predicted=_predicted(played, found))
    return DesignedDrive(
        **vars(found),
        target=wanted,
        method=method,
        bounds=bounds.declared,
        limits=several,
        check=checked(played.scenario(found.values), limits=list(several), name="the designed drive"),
    )


def _predicted(played: Played, found: FoundDrive) -> Real:
    """Return the mean forces of the full model with the limits of the amplifier [N]."""
    edges = found.edges
    width = round(float(edges[1] - edges[0]) * played.rate)
    first = round(float(edges[0]) * played.rate)
    return played.means(played.force(found.values), first, len(edges) - 1, width)


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
class DesignedDrive(Designed, FoundDrive):
    """A drive for a target of the force, with the force that the full model predicts.

    - `target`, `method`: as they were asked for.
    - `bounds`: limits that the design held.
    - `check`: comparison of the drive with the limits and with breakdown.
    """

    form = "drive"
    target: Target
    method: str
    bounds: dict[str, DeclaredLimit]
    check: CheckResult

    @property
    def scenario(self) -> Scenario:
        """Experiment under the drive, from rest; it can be simulated, checked and exported."""
        return self.check.scenario

    @property
    def quantity(self) -> str:
        """What the drive prescribes, ``"voltage"`` or ``"current"``."""
        return self.scenario.drive.quantity

    @functools.cached_property
    def misfit(self) -> float:
        """Root mean square of predicted less wanted force over that of the wanted one [1]."""
        size = float(np.mean(self.wanted**2))
        off = float(np.mean((self.predicted - self.wanted) ** 2))
        return math.sqrt(off / size) if size else (math.inf if off else 0.0)

    @property
    def binding(self) -> tuple[str, ...]:
        """Names of the limits that prevent the target; empty where none does."""
        if not np.any(self.limited):
            return ()
        return tuple(name for name, ratio in self.ratios.items() if ratio >= _BINDING)

    @property
    def limited_share(self) -> float:
        """Share of the time in which a limit prevents the target [1]."""
        return float(np.mean(self.limited))

    @property
    def is_achieved(self) -> bool:
        """Whether the predicted force follows the target to 1 % and no row of the check fails."""
        return self.misfit <= TRACKED and not self.failed

    @functools.cached_property
    def harmonics(self) -> dict[int, float]:
        """Amplitudes at multiples of the target's frequency, over the wanted one at it; empty for a target without one."""
        return harmonics(self.edges, self.predicted, self.wanted, self.target.frequency)

    @property
    def document(self) -> Document:
        """The target, the drive, its misfit, the limits that shaped it, and what is in doubt; wanted and predicted force."""
        panel = force_panel((self.edges[:-1] + self.edges[1:]) / 2, self.wanted, self.predicted)
        return self._document((*self.notes, *_doubts(self)), figures=[panel])

    @property
    def notes(self) -> tuple[str, ...]:
        """What the drive is, its misfit and what bounds it, as a file of the drive states it."""
        return (f"target: {self.target.text}", _drive(self), *_misfit(self), *_limits(self))

    def numbers(self) -> dict[str, Any]:
        """Return all numbers as nested tables."""
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
            "searches": {"made": self.searches, "agreeing": self.agreeing},
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
    searches, agreeing = found.searches, found.agreeing
    if searches:
        doubt = ": another drive may follow the target better" if agreeing < 2 else ""
        lines.append(
            f"{agreeing} of {searches} searches from different starts end within 1 % of the smallest misfit among them{doubt}"
        )
    return lines


def _doubts(found: DesignedDrive) -> list[str]:
    lines = [row.text for row in found.failed]
    lines += [text for text in not_shown(found.check.rows) if "is not declared" not in text]
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
