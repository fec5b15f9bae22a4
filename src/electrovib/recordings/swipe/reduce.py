"""Reduction of a recorded swipe to normal force, lateral force and friction, with the uncertainty of the baseline."""

from __future__ import annotations

import functools
import json
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.signals import make_trace
from electrovib.recordings.interval import Interval, stuck
from electrovib.recordings.recording import at_extreme, omitted_rows, recording_of
from electrovib.recordings.swipe.result import (
    SHORTEST,
    SwipeResult,
    Swipes,
    find_contacts,
    find_slides,
    middle,
    plain,
    sliding_speed,
    travel,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

    import xarray

    from electrovib.core.arrays import Real
    from electrovib.recordings.recording import Channels, Recorded, Recording, Span
    from electrovib.recordings.swipe.result import Touch

_MOST = 0.5
"""Largest fraction of a window at the end of the range with which a force is still computed."""
_BEST_FIRST = ("interpolated", "before", "after")


def reduce_swipe(
    recording: Recorded,
    *,
    channels: Channels | None = None,
    speed: float | str | None = None,
) -> SwipeResult:
    """Reduce the longest swipe of a recording to forces and friction.

    Parameters
    ----------
    recording : Recording, Trace, str or Path
        A Trace with a normal and a lateral force, or its file; with `channels` a file of an instrument.
    channels : TribometerChannels, mapping, str or Path, optional
        Columns of the file and their calibration, or the TOML file that holds them.
    speed : float or str, optional
        Set sliding speed [m/s], or as text with a unit, of a Trace without `sliding_speed`.

    Returns
    -------
    SwipeResult
        Result for the swipe of the longest distance, or of the longest time if no position is recorded; its remarks state
        how many swipes there are.

    Raises
    ------
    InputError
        If no contact, no section free of load or no motion is found.
    """
    found = reduce_swipes(recording, channels=channels, speed=speed)
    return max(found, key=lambda swipe: swipe.distance or swipe.window[1] - swipe.window[0])


def reduce_swipes(
    recording: Recorded,
    *,
    channels: Channels | None = None,
    speed: float | str | None = None,
) -> Swipes:
    """Reduce every swipe of a recording to forces and friction.

    Parameters
    ----------
    recording : Recording, Trace, str or Path
        A Trace with a normal and a lateral force, or its file; with `channels` a file of an instrument.
    channels : TribometerChannels, mapping, str or Path, optional
        Columns of the file and their calibration, or the TOML file that holds them.
    speed : float or str, optional
        Set sliding speed [m/s], or as text with a unit, of a Trace without `sliding_speed`.

    Returns
    -------
    swipes : Swipes
        A tuple of at least one SwipeResult, in the order of time.

    Raises
    ------
    InputError
        If no contact, no section free of load or no motion is found, or if a sensor is at the end of its range for most
        of a window.

    Notes
    -----
    The zero of a sensor is the median of the nearest section free of load, at most as long as the window. The zero before
    the contact, the zero after it, the mean of both and the straight line between them give four values of each result.
    The line is exact for a drift proportional to time; the interval contains any drift that lies between the two
    zeros at the time of the swipe. The statistical error is that of the means of ten parts of the window, so a
    friction that changes along the plate counts as scatter.
    """
    recording = recording_of(recording, channels=channels, speed=speed)
    contacts = find_contacts(recording)
    pairs = [(contact, slide) for contact in contacts for slide in find_slides(recording, contact)]
    windows = [(contact, slide, middle(recording, slide, contact)) for contact, slide in pairs]
    windows = [
        (contact, slide, window) for contact, slide, window in windows if window[1] - window[0] >= 2 * BLOCKS
    ]
    if not windows:
        raise InputError(
            f"{recording.source}: no motion found during contact: {_stillness(recording, contacts)}"
        )
    return Swipes(
        _Swipe(recording=recording, contact=contact, slide=slide, window=window).reduced(len(windows))
        for contact, slide, window in windows
    )


def _stillness(recording: Recording, contacts: list[Touch]) -> str:
    """Return why no motion was found."""
    if recording.position is None:
        return (
            "the lateral force does not exceed its noise while the finger presses. Is lateral.column right?"
        )
    distance = max(float(np.ptp(recording.position[slice(*contact.span)])) for contact in contacts)
    return f"the carriage moves by {distance:.3g} m while the finger presses. Are encoder.column and encoder.step right?"


@dataclass(frozen=True, kw_only=True)
class _Swipe:
    """One slide of a recording, with the contact to which it belongs and the samples over which forces are averaged."""

    recording: Recording
    contact: Touch
    slide: Span
    window: Span

    def reduced(self, swipes: int) -> SwipeResult:
        """Reduce the swipe, one of a number of them, to forces and friction."""
        recording, (first, last) = self.recording, self.slide
        if recording.position is not None:
            forwards = recording.position[last - 1] > recording.position[first]
        else:
            zero = np.mean([zero.level[1] for zero in self.zeros.values()])
            forwards = np.mean(recording.lateral_force[slice(*self.window)]) > zero
        inside, inner = recording.ends(self.window), travel(recording, self.window)
        estimates = self.estimates()
        remarks = self.remarks(estimates, swipes)
        result = dict(zip(("normal_force", "lateral_force", "friction"), estimates, strict=True))
        return SwipeResult(
            **result,
            direction=1 if forwards else -1,
            speed=recording.channels.speed if inner is None else inner / (inside[1] - inside[0]),
            distance=travel(recording, self.slide),
            contact=recording.ends(self.contact.span),
            window=inside,
            remarks=remarks,
            trace=self.trace({name: plain(value) for name, value in result.items()}, remarks),
        )

    @functools.cached_property
    def zeros(self) -> dict[str, Zero]:
        """Zeros before and after the contact from the nearest samples free of load."""
        recording, contact, window = self.recording, self.contact, self.window
        longest, sides = window[1] - window[0], {}
        if contact.before is not None:
            sides["before"] = (max(contact.before[0], contact.before[1] - longest), contact.before[1])
        if contact.after is not None:
            sides["after"] = (contact.after[0], min(contact.after[1], contact.after[0] + longest))
        if not sides:
            raise InputError(
                f"{recording.source}: no section of {SHORTEST:g} s is free of load before or after the contact that begins at"
                f" {recording.time[contact.span[0]]:.3g} s, so the zero of the sensors is unknown."
            )
        return {
            name: Zero(
                time=float(np.mean(recording.time[slice(*span)])),
                level=np.median(recording.forces[:, slice(*span)], axis=1),
                error=standard_error(_detrended(block_means(recording.forces, span, median=True))),
            )
            for name, span in sides.items()
        }

    def baseline(self, at: Real | float) -> Real:
        """Return the straight line between the zeros of both forces, shape (2, n)."""
        stamps, levels = zip(*((zero.time, zero.level) for zero in self.zeros.values()), strict=True)
        return np.array([np.interp(at, stamps, each) for each in np.transpose(levels)])

    def estimates(self) -> tuple[Interval, Interval, Interval]:
        """Compute normal force, lateral force and friction."""
        recording, window, zeros = self.recording, self.window, self.zeros
        choices = {name: zero.level for name, zero in zeros.items()}
        if len(zeros) == 2:
            at = float(np.mean(recording.time[slice(*window)]))
            choices |= {"mean": (choices["before"] + choices["after"]) / 2, "interpolated": self.baseline(at)}
        means = block_means(recording.forces, window)
        best = next(name for name in _BEST_FIRST if name in choices)
        mean = means.mean(axis=1)
        side = float(np.sign(mean[1] - choices[best][1])) or 1.0
        pressed = {name: float(mean[0] - zero[0]) for name, zero in choices.items()}
        if min(pressed.values()) <= 0:
            raise InputError(
                f"{recording.source}: the zero of the normal force drifts by more than the load, {pressed[best]:.3g} N, so the"
                " friction cannot be determined."
            )
        pulled = {name: side * float(mean[1] - zero[1]) for name, zero in choices.items()}
        ratio = {name: pulled[name] / pressed[name] for name in choices}
        # a drift is no scatter: the line between the zeros is subtracted before the parts of the window are compared
        normal, lateral = means - self.baseline(block_means(recording.time, window))
        normal_zero, lateral_zero = np.max([zero.error for zero in zeros.values()], axis=0)
        # error of the ratio of means: scatter of lateral - ratio * normal, in which common variations cancel
        of_ratio = standard_error(side * lateral - ratio[best] * normal)
        return (
            over_baselines(pressed, best, math.hypot(standard_error(normal), normal_zero)),
            over_baselines(pulled, best, math.hypot(standard_error(lateral), lateral_zero)),
            over_baselines(
                ratio,
                best,
                math.hypot(of_ratio, lateral_zero, ratio[best] * normal_zero) / min(pressed.values()),
            ),
        )

    def rails(self) -> list[str]:
        """Refuse forces beyond the range of a sensor for most of the window, and state where part of the samples used are."""
        recording, contact, window, said = self.recording, self.contact, self.window, []
        for name, railed in recording.at_rail.items():
            places = {
                "the window": window,
                "the unloaded part before the contact": contact.before,
                "the unloaded part after the contact": contact.after,
            }
            shares = {
                where: np.mean(railed[slice(*span)]) for where, span in places.items() if span is not None
            }
            if shares["the window"] > _MOST:
                raise InputError(
                    f"{recording.source}: the sensor of the {name} force is at its rail (its highest or lowest reading, repeated"
                    f" exactly) for {shares['the window']:.0%} of the time from {recording.time[window[0]]:.2f} to"
                    f" {recording.time[window[1] - 1]:.2f} s, so the force is beyond its range and cannot be determined."
                    f" Is {name}.column the right one? Otherwise record with a larger range."
                )
            force = getattr(recording, f"{name}_force")
            still = at_extreme(force)[slice(*window)] & ~railed[slice(*window)]
            if held := float(np.mean(stuck(force)[slice(*window)] & ~railed[slice(*window)])):
                said.append(
                    f"Warning: the {name} force repeats one reading for {held:.1%} of the window: its sensor or its record is"
                    " stuck there, and values derived from it have an error of unknown size."
                )
            elif np.any(still):
                said.append(
                    f"Warning: the {name} force is exactly its highest or lowest reading for {np.mean(still):.1%} of the window:"
                    " its sensor is at its rail there, or the force is constant within the resolution."
                )
            for where, share in shares.items():
                if share > 0:
                    said.append(
                        f"Warning: the sensor of the {name} force is at its rail, or in a dead band, for {share:.1%} of"
                        f" {where}: values derived from it have an error of unknown size."
                    )
        return said

    def remarks(self, estimates: tuple[Interval, Interval, Interval], swipes: int) -> tuple[str, ...]:
        """State what was measured, and what limits it."""
        recording, zeros = self.recording, self.zeros
        normal, lateral, friction = estimates
        (first, last), window = (recording.ends(span) for span in (self.contact.span, self.window))
        said = [
            f"The finger presses from {first:.2f} to {last:.2f} s and {_slide(recording, travel(recording, self.slide))};"
            f" the forces are averaged from {window[0]:.2f} to {window[1]:.2f} s.",
            f"Normal force {normal.value:.3f} N, lateral force {lateral.value:.3f} N, friction {friction.value:.3f}"
            f" ({friction.ends[0]:.3f} to {friction.ends[1]:.3f}; due to the choice of the baseline alone"
            f" {friction.choice_ends[0]:.3f} to {friction.choice_ends[1]:.3f}).",
        ]
        if len(zeros) == 2:
            drift = zeros["after"].level[1] - zeros["before"].level[1]
            said.append(
                f"The zero of the lateral force changes by {drift * 1e3:.0f} mN from before to after the contact."
            )
        else:
            said.append(
                f"The sensors are free of load only {next(iter(zeros))} the contact: their drift is unknown and not included"
                " in the interval."
            )
        said += omitted_rows(recording.missing)
        if recording.wraps:
            said.append(f"The encoder wrapped {recording.wraps} time{'s' * (recording.wraps > 1)}.")
        if swipes > 1:
            said.append(f"The recording holds {swipes} swipes.")
        return (*self.rails(), *said)

    def trace(self, result: dict[str, Any], words: tuple[str, ...]) -> xarray.Dataset:
        """Return the whole record, with the baseline of this swipe subtracted."""
        recording = self.recording
        names = ("normal_force_measured", "lateral_force_measured")
        signals = dict(zip(names, recording.forces - self.baseline(recording.time), strict=True))
        if (speed := sliding_speed(recording)) is not None:
            signals["sliding_speed"] = speed
        return make_trace(
            {name: (("time",), values) for name, values in signals.items()},
            {"time": recording.time},
            {
                "source": recording.source,
                "channels": json.dumps(recording.channels.to_dict()),
                "swipe": json.dumps(result),
                "words": "\n".join(words),
            },
        )


def _slide(recording: Recording, distance: float | None) -> str:
    if distance is not None:
        return f"slides {distance * 1e3:.1f} mm"
    speed = recording.channels.speed
    return (
        "is taken to slide while the lateral force exceeds half of its largest value, because no position is recorded (the"
        " force of a finger that has stopped may stay as large); the speed is"
        f" {'unknown' if speed is None else f'the declared {speed * 1e3:.1f} mm/s'}"
    )


BLOCKS = 10
"""Number of parts of a window from whose scatter the statistical error is computed."""
_COVERAGE = 2.262
"""Standard errors on either side of an interval: 95 % for a mean of ten parts (Student's t)."""


def over_baselines(choices: Mapping[str, float], best: str, standard_error: float) -> Interval:
    """Make the interval of a number over the choices of the baseline, extended by 2.26 standard errors (95 %) on either side."""
    half = _COVERAGE * standard_error
    return Interval(
        value=choices[best],
        lower=min(choices.values()) - half,
        upper=max(choices.values()) + half,
        standard_error=standard_error,
        choices=choices,
        method="choices of the zero of the sensors, and scatter within the window",
    )


@dataclass(frozen=True, kw_only=True)
class Zero:
    """Zeros of normal and lateral force in one section free of load: median readings, with errors without the drift."""

    time: float
    level: Real
    error: Real


def block_means(values: Real, span: Span, *, median: bool = False) -> Real:
    """Return the means of `BLOCKS` equal parts of a section, or medians, which a brief touch changes less."""
    blocks = np.array_split(values[..., slice(*span)], BLOCKS, axis=-1)
    return np.stack([(np.median if median else np.mean)(block, axis=-1) for block in blocks], axis=-1)


def standard_error(means: Real) -> Real:
    """Return the standard error of the mean of independent numbers along the last axis."""
    return np.asarray(np.std(means, axis=-1, ddof=1) / np.sqrt(means.shape[-1]))


def _detrended(means: Real) -> Real:
    """Subtract a straight line, because a drift is covered by the choice of the baseline."""
    place = np.arange(BLOCKS) - (BLOCKS - 1) / 2
    return means - np.outer(means @ place, place) / (place @ place)
