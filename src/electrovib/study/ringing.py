"""Release of a clutch as its load cell sees it: how much of the ringing a resonance of the cell explains."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.errors import InputError
from electrovib.physics.drive.sampled import Refuse
from electrovib.study.recording import increasing
from electrovib.study.ringing_fit import plain_release, resonant_release
from electrovib.study.ringing_parts import (
    Decay,
    Extremum,
    damped_sine,
    drive_end,
    find_extrema,
    longest_pause,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.physics.drive.sampled import StampTreatment

_REMAINS = 0.05
"""The fit ends when the fitted ringing has fallen to this."""
_CLEAR = 5.0
"""The force falls by this many times the scatter before the release, or there is none."""
_LATER = 0.75
"""The second decay starts this many periods after the first."""
_PERIODS = 4.0
"""Length of a fitted decay, in periods."""


@dataclass(frozen=True)
class Ringing:
    """A release and the ringing after it. Times are s after the drive ends unless they say otherwise.

    Parameters
    ----------
    drive_end : float
        When the drive falls for the last time, on the clock of the record [s].
    delay, fall_time : float
        Of the force behind the drive, and time constant of its fall [s].
    held, after : float
        Force before and long after the release [N].
    frequency, quality : float
        Natural frequency [Hz] and quality factor [1] of the one resonance that fits best.
    misfit, misfit_without : float
        rms of what is left over rms of the force about its last level, after the drive ends [1]: with the
        resonance, and with the best exponential release that the cell would follow at once.
    longest_pause : float
        Of the drive before its end, within the duration that is looked at [s]; 0 if it does not pause.
    scatter : float
        Standard deviation before the release [N].
    extrema : tuple of Extremum
        Turning points that stand out from the scatter.
    early, late : Decay or None
        Damped sines from the first turning point, and from three quarters of a period later.
    time, force, model, model_without : ndarray, shape (n,)
        The samples that were fitted: s after the drive ends, and N.
    words : tuple of str
        What is explained, and what is not.
    """

    drive_end: float
    delay: float
    fall_time: float
    held: float
    after: float
    frequency: float
    quality: float
    misfit: float
    misfit_without: float
    longest_pause: float
    scatter: float
    extrema: tuple[Extremum, ...]
    early: Decay | None
    late: Decay | None
    time: NDArray[np.float64]
    force: NDArray[np.float64]
    model: NDArray[np.float64]
    model_without: NDArray[np.float64]
    words: tuple[str, ...]

    @property
    def half_periods(self) -> tuple[float, ...]:
        """Frequencies [Hz] that successive turning points give."""
        times = [extremum.time for extremum in self.extrema]
        return tuple(1 / (2 * (later - earlier)) for earlier, later in itertools.pairwise(times))

    def to_dict(self) -> dict[str, Any]:
        """Give plain numbers and words for JSON, in SI, without the samples."""
        plain = (
            "drive_end", "delay", "fall_time", "held", "after", "frequency", "quality", "misfit",
            "misfit_without", "longest_pause", "scatter",
        )  # fmt: skip
        return {name: getattr(self, name) for name in plain} | {
            "extrema": [{"time": extremum.time, "force": extremum.force} for extremum in self.extrema],
            "half_periods": list(self.half_periods),
            "early": self.early.to_dict() if self.early else None,
            "late": self.late.to_dict() if self.late else None,
            "words": list(self.words),
        }


def ringing(
    time: NDArray[np.float64],
    force: NDArray[np.float64],
    voltage: NDArray[np.float64],
    *,
    duration: float = 20e-3,
    stamps: StampTreatment | None = None,
) -> Ringing:
    """Fit a release and one resonance of the load cell to a recorded force, and say what is left.

    Parameters
    ----------
    time : ndarray, shape (n,)
        s, increasing; may jitter.
    force : ndarray, shape (n,)
        Load cell [N].
    voltage : ndarray, shape (n,)
        Drive as read back [V]; it may alias, as long as its last fall shows.
    duration : float
        How long after the drive ends to look at most [s].
    stamps : StampTreatment, optional
        What to do with stamps that do not increase; refused if not given.

    Returns
    -------
    Ringing
        The fit, the turning points and the misfit.

    Raises
    ------
    InputError
        If the columns are no record, the drive does not end in it, or the force does not let go.

    Notes
    -----
    The pull goes with V^2, so it ends with the drive; shear is held while the drive pulses and for a `delay`
    after its last fall, then it dies away with `fall_time`. A lag of V^2 that let the force go as fast as this
    would also let it go in every pause of a slow enough drive; the record decides, not the model, and the pauses
    are held through. The cell is y'' + (w/Q) y' + w^2 y = w^2 f. All four are fitted; the two levels follow
    linearly. The fit ends where the fitted ringing has fallen to 5 %.
    """
    since, measured, volts, end = _checked(time, force, voltage, duration, stamps or Refuse())
    scatter = _scatter(since, measured, duration)
    window, fit = duration, None
    for _ in range(6):
        here = (since > -duration / 2) & (since < window)
        fit = resonant_release(since[here], measured[here], window)
        wanted = min(duration, fit[0][0] + np.log(1 / _REMAINS) * fit[0][3] / (np.pi * fit[0][2]))
        if abs(wanted - window) < 0.02 * window:
            break
        window = float(wanted)
    assert fit is not None
    (delay, fall_time, frequency, quality), held, after, misfit, model = fit
    without = plain_release(since[here], measured[here], window)
    extrema = find_extrema(
        since, measured, start=delay, period=1 / frequency, level=after, scatter=scatter, end=duration
    )
    early, late = _decays(since, measured, extrema, 1 / frequency)
    pause = longest_pause(since, volts, since=-duration)
    words = _words(frequency, quality, misfit, without[0], extrema, early, late) + _about_pauses(delay, pause)
    return Ringing(
        end, delay, fall_time, held, after, frequency, quality, misfit, without[0], pause, scatter, tuple(extrema), early,
        late, since[here], measured[here], model, without[1], words,
    )  # fmt: skip


def _checked(
    time: NDArray[np.float64],
    force: NDArray[np.float64],
    voltage: NDArray[np.float64],
    duration: float,
    stamps: StampTreatment,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], float]:
    """Refuse what is no record; give times counted from the end of the drive, forces, voltages, and that end."""
    columns = {
        "time": np.asarray(time, float),
        "force": np.asarray(force, float),
        "voltage": np.asarray(voltage, float),
    }
    problems = []
    if len({values.shape for values in columns.values()}) > 1 or columns["time"].ndim != 1:
        shapes = ", ".join(f"{name} {values.shape}" for name, values in columns.items())
        problems.append(f"time, force and voltage: expected one row each, of one length; they have {shapes}")
    for name, values in columns.items():
        bad = np.flatnonzero(~np.isfinite(values.ravel()))
        if len(bad):
            problems.append(f"{name}: sample {bad[0]} is {values.ravel()[bad[0]]}, not a finite number")
    if not 0 < duration < np.inf:
        problems.append(f"duration = {duration}: expected a time, for instance 20e-3")
    if problems:
        raise InputError(problems)
    kept = increasing(columns["time"], stamps, "time")
    when, measured, volts = (values[kept] for values in columns.values())
    end = drive_end(when, volts)
    counted = when - end
    near = (counted > -duration / 2) & (counted < duration)
    if counted[-1] < duration / 2 or counted[0] > -duration / 4 or np.count_nonzero(near) < 40:
        raise InputError(
            f"the drive ends at {end:.6g} s, but there are only {np.count_nonzero(near)} samples from"
            f" {duration / 2:g} s before to {duration:g} s after; record longer or change duration"
        )
    return counted, measured, volts, end


def _scatter(stamps: NDArray[np.float64], force: NDArray[np.float64], duration: float) -> float:
    """Refuse a force that does not let go; give its scatter before the release."""
    before = force[(stamps > -duration / 2) & (stamps < 0)]
    after = force[(stamps > duration / 2) & (stamps < duration)]
    scatter = float(np.std(before))
    fall = abs(float(np.mean(before) - np.mean(after))) if len(after) else 0.0
    if not fall > _CLEAR * scatter:
        raise InputError(
            f"the force does not let go when the drive ends: it changes by {fall:.3g} N, with a scatter of"
            f" {scatter:.3g} N before. Is force the right column?"
        )
    return scatter


def _decays(
    stamps: NDArray[np.float64], force: NDArray[np.float64], extrema: list[Extremum], period: float
) -> tuple[Decay | None, Decay | None]:
    if not extrema:
        return None, None
    starts = (extrema[0].time, extrema[0].time + _LATER * period)
    early, late = (damped_sine(stamps, force, start=start, end=start + _PERIODS * period) for start in starts)
    return early, late


def _words(
    frequency: float,
    quality: float,
    misfit: float,
    without: float,
    extrema: list[Extremum],
    early: Decay | None,
    late: Decay | None,
) -> tuple[str, ...]:
    """Say what the resonance explains, and what it leaves."""
    said = [
        f"One resonance of {frequency:.0f} Hz, quality {quality:.1f}, leaves {misfit:.1%} of the force after the drive ends;"
        f" the same release without it leaves {without:.1%}."
    ]
    times = [extremum.time for extremum in extrema]
    halves = [1 / (2 * (later - earlier)) for earlier, later in itertools.pairwise(times)]
    if len(halves) >= 2:
        said.append(f"Successive turning points give {', '.join(f'{value:.0f}' for value in halves)} Hz.")
    if early and late:
        said.append(
            f"A damped sine gives {early.frequency:.0f} Hz (quality {early.quality:.1f}) from the first turning point and"
            f" {late.frequency:.0f} Hz (quality {late.quality:.1f}) three quarters of a period later."
        )
        if abs(late.frequency / early.frequency - 1) > 0.05:
            way = "falls" if late.frequency < early.frequency else "rises"
            said.append(
                f"The frequency {way} while the ringing dies away: no single linear resonance does that, so part of the"
                " misfit is that, and not noise."
            )
    return tuple(said)


def _about_pauses(delay: float, pause: float) -> tuple[str, ...]:
    """Say where the release contradicts a pull that only lags behind the square of the voltage."""
    if not pause > delay:
        return ()
    return (
        f"The force lets go {delay * 1e3:.2f} ms after the last fall of the drive, but holds through pauses of"
        f" {pause * 1e3:.2f} ms before: a pull that only lags behind the square of the voltage cannot do both.",
    )
