"""Target of a drive: the electrostatic force over time, from a text, a file or arrays."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from electrovib.core.answer import REFERENCE, Curve, Panel
from electrovib.core.arrays import Real
from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity
from electrovib.studies.check import first_columns
from electrovib.studies.design.wanted import read_number

TargetSource: TypeAlias = "str | Path | Target | tuple[ArrayLike, ArrayLike]"
"""A text, a file with columns of time and force, a pair of times [s] and forces [N], or a Target."""
HEADINGS: Final = (("time", "force"), ("time", "electrostatic_force"))
"""Headings of time and force that are tried in a file, in this order."""
TEXTS: Final = "'sine 50 Hz 30 mN', 'sine 50 Hz 10 mN to 30 mN for 0.2 s', 'constant 5 mN for 1 s'"
PERIODS: Final = 5
"""Periods of a sine whose duration is not given."""
HOLD: Final = 1.0
"""Duration of a constant target that is not given [s]."""
_VARIANCE: Final = 0.999
"""Share of the variance of a sampled target below its highest frequency [1]; a choice."""
_RESAMPLED: Final = 4096
_QUANTITY: Final = r"([-+]?[\d.]+(?:[eE][-+]?\d+)?\s*[^\s\d]+)"
_SINE: Final = re.compile(
    rf"sine\s+{_QUANTITY}\s+{_QUANTITY}(?:\s+to\s+{_QUANTITY})?(?:\s+for\s+{_QUANTITY})?"
)
_CONSTANT: Final = re.compile(rf"constant\s+{_QUANTITY}(?:\s+for\s+{_QUANTITY})?")


def force_panel(times: Real, wanted: Real, predicted: Real) -> Panel:
    """Show the force over time that is wanted, and that of the full model."""
    curves = (
        Curve(label="predicted", x=times, y=predicted, look=0),
        Curve(label="wanted", x=times, y=wanted, kind="dashed", look=REFERENCE),
    )
    caption = "Means over a period of the carrier, or between samples where there is none."
    return Panel(
        id="force", title="Wanted and predicted force", caption=caption, x=("time", "s"), y=("electrostatic force", "N"),
        curves=curves,
    )  # fmt: skip


@dataclass(frozen=True, eq=False, kw_only=True)
class Target(ABC):
    """A force over time that a drive is to cause; it is never negative, and outside its duration its nearest value.

    `text` says what it is; `highest_frequency` is that which it contains [Hz], 0 for a constant; `frequency` the
    fundamental of a periodic target.
    """

    text: str
    duration: float
    highest_frequency: float
    frequency: float | None = None

    @abstractmethod
    def force(self, time: Real) -> Real:
        """Return the force [N] at times [s] from its beginning on."""

    @abstractmethod
    def _integral_inside(self, time: Real) -> Real:
        """Return the integral of the force from its beginning to times within its duration [N s]."""

    def integral(self, time: Real) -> Real:
        """Return the integral of the force from its beginning to these times [N s]."""
        inside = np.clip(time, 0.0, self.duration)
        return np.asarray(self._integral_inside(inside) + (time - inside) * self.force(time))

    def root(self, time: Real) -> Real:
        """Return a square root of the force at times [s], of either sign [N^(1/2)]."""
        return np.sqrt(self.force(time))

    def means(self, edges: Real) -> Real:
        """Return the mean force over each interval between successive times `edges`."""
        return np.asarray(np.diff(self.integral(edges)) / np.diff(edges))


@dataclass(frozen=True, eq=False, kw_only=True)
class SineTarget(Target):
    """A force that swings sinusoidally between `low` and `high`, and begins at the lower one."""

    frequency: float
    low: float
    high: float

    def force(self, time: Real) -> Real:
        """Return the force [N] at times [s]."""
        turn = 2 * np.pi * self.frequency * np.clip(time, 0.0, self.duration)
        return np.asarray(self.low + (self.high - self.low) / 2 * (1 - np.cos(turn)))

    def _integral_inside(self, time: Real) -> Real:
        turn, half = 2 * np.pi * self.frequency, (self.high - self.low) / 2
        return np.asarray((self.low + half) * time - half * np.sin(turn * time) / turn)

    def root(self, time: Real) -> Real:
        """Return a square root of the force [N^(1/2)]; from 0 N it is the smooth one, whose sign alternates."""
        if self.low:
            return super().root(time)
        inside = np.clip(time, 0.0, self.duration)
        return np.asarray(np.sqrt(self.high) * np.sin(np.pi * self.frequency * inside))


@dataclass(frozen=True, eq=False, kw_only=True)
class SampledTarget(Target):
    """A force of straight lines between samples, whose increasing times begin at 0."""

    times: Real
    forces: Real

    def force(self, time: Real) -> Real:
        """Return the force [N] at times [s]."""
        return np.asarray(np.interp(time, self.times, self.forces))

    def _integral_inside(self, time: Real) -> Real:
        from scipy.interpolate import make_interp_spline

        return np.asarray(make_interp_spline(self.times, self.forces, k=1).antiderivative()(time))


def read_target(source: TargetSource) -> Target:
    """Read a target from a text, a file with columns of time [s] and force [N], or a pair of times and forces.

    ``"sine 50 Hz 30 mN"`` swings between 0 and 30 mN, ``"sine 50 Hz 10 mN to 30 mN for 0.2 s"`` between 10
    and 30 mN, ``"constant 5 mN for 1 s"`` is held. A negative force is refused.
    """
    if isinstance(source, Target):
        return source
    if isinstance(source, str) and (words := source.split()) and words[0].lower() in {"sine", "constant"}:
        return _of_text(" ".join(words))
    if isinstance(source, str | Path):
        found = first_columns(path := Path(source), HEADINGS, {"time": "s", "force": "N"})
        return _of_samples(found["time"], found["force"], f"the force of {path.name}")
    if isinstance(source, Sequence) and len(source) == 2:
        return _of_samples(
            np.asarray(source[0], dtype=float), np.asarray(source[1], dtype=float), "the given force"
        )
    raise InputError(
        f"expected {TEXTS}, a file with the columns time and force, or times and forces", path="target"
    )


def _of_text(text: str) -> Target:
    kind, _, rest = text.partition(" ")
    lowered = kind.lower()
    found = (_SINE if lowered == "sine" else _CONSTANT).fullmatch(f"{lowered} {rest}")

    def read(part: str, unit: str) -> float:
        return read_number(part, unit, "target")

    def refuse(good: bool, wanted: str) -> None:
        if not good:
            raise InputError(f"expected {wanted}", path="target", value=text)

    refuse(found is not None, TEXTS)
    assert found is not None
    if lowered == "constant":
        force, duration = found.groups()
        level, end = read(force, "N"), HOLD if duration is None else read(duration, "s")
        refuse(level >= 0, "a force of 0 N or more")
        refuse(end > 0, "a duration above 0 s")
        words = f"a constant force of {_shown(level, 'N')} for {_shown(end, 's')}"
        times, forces = np.array([0.0, end]), np.array([level, level])
        return SampledTarget(text=words, duration=end, highest_frequency=0.0, times=times, forces=forces)
    often, first, second, duration = found.groups()
    frequency = read(often, "Hz")
    refuse(frequency > 0, "a frequency above 0 Hz")
    low, high = (0.0, read(first, "N")) if second is None else (read(first, "N"), read(second, "N"))
    refuse(0 <= low < high, "forces of 0 N or more, the lower one first")
    end = PERIODS / frequency if duration is None else read(duration, "s")
    refuse(end > 0, "a duration above 0 s")
    lowest = _shown(low, "N")
    words = (
        f"a force between {lowest} and {_shown(high, 'N')} at {_shown(frequency, 'Hz')} for {_shown(end, 's')}, which"
        f" begins at {lowest}"
    )
    return SineTarget(
        text=words, duration=end, highest_frequency=frequency, frequency=frequency, low=low, high=high
    )


def _shown(value: float, unit: str) -> str:
    return format_quantity(value, unit, digits=6)


def _of_samples(times: Real, forces: Real, text: str) -> Target:
    if times.ndim != 1 or times.shape != forces.shape or len(times) < 2:
        raise InputError("times and forces are two arrays of the same length, 2 or more", path="target")
    if not (np.all(np.isfinite(times)) and np.all(np.isfinite(forces)) and np.all(np.diff(times) > 0)):
        raise InputError("times have to increase, and times and forces to be finite", path="target")
    if np.any(forces < 0):
        first = int(np.argmax(forces < 0))
        raise InputError(
            f"the force of sample {first} is {forces[first]:.6g} N: an electrostatic attraction is never negative; add an offset",
            path="target",
        )
    shifted = times - times[0]
    end = float(shifted[-1])
    return SampledTarget(
        text=f"{text}, {_shown(end, 's')}",
        duration=end,
        highest_frequency=_highest_frequency(shifted, forces),
        times=shifted,
        forces=forces,
    )


def _highest_frequency(times: Real, forces: Real) -> float:
    """Return the frequency below which nearly all of the variance lies, the line between the ends removed [Hz]."""
    even = np.linspace(0.0, times[-1], _RESAMPLED)
    values = np.interp(even, times, forces)
    values = values - np.interp(even, [0.0, times[-1]], values[[0, -1]])
    power = np.abs(np.fft.rfft(values))[1:] ** 2
    total = np.cumsum(power)
    if total[-1] <= (1e-9 * max(float(np.max(forces)), 1e-300)) ** 2:
        return 0.0
    return float((1 + np.searchsorted(total, _VARIANCE * total[-1])) / times[-1])
