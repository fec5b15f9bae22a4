"""Sections of a record in which the finger touches, slides or leaves the sensors free of load."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError
from electrovib.recordings.recording import Span, closed, runs

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.recordings.recording import Recording

SMOOTHING = 20e-3
"""Time within which a finger neither touches, nor lifts off, nor reverses [s]."""
SHORTEST = 0.1
"""Duration below which a contact or a pause counts as a bounce [s]."""
_LIGHT = 0.3
"""Fraction of the load above which a contact that has reached half of it continues."""
CLEAR = 5.0
"""Smallest load of a contact, in standard deviations of the signal without load."""
TRIM = 0.05
"""Fraction of a slide that is omitted at both of its ends."""
FEWEST_COUNTS = 100.0
"""Smallest distance of a slide, in counts of the encoder."""


@dataclass(frozen=True)
class Touch:
    """A contact: its samples, and those free of load up to the next contact before and after it, or None."""

    span: Span
    before: Span | None
    after: Span | None


def smoothed(time: Real, values: Real) -> Real:
    """Return the moving average over `SMOOTHING` around each sample."""
    from scipy.ndimage import uniform_filter1d

    return np.asarray(uniform_filter1d(values, _width(time), mode="nearest"), dtype=np.float64)


def find_contacts(recording: Recording) -> list[Touch]:
    """Find the contacts: the sections at the higher of the two levels that separate the normal force best."""
    time, force = recording.time, _level(recording.time, smoothed(recording.time, recording.normal_force))
    level = _split(force)
    low, high = force[force <= level], force[force > level]
    free, loaded = float(np.median(low)), float(np.median(high))
    noise = 1.4826 * float(np.median(np.abs(low - free)))
    if not loaded - free > CLEAR * noise:
        raise InputError(
            f"{recording.source}: no contact found: the normal force has no two distinct levels (the best separation is"
            f" {loaded - free:.3g} N, with a scatter of {noise:.3g} N at the lower level). Is normal.column the right one?"
        )
    count = max(1, round(SHORTEST / _period(time)))
    light = force > free + _LIGHT * (loaded - free)
    heavy = force > (free + loaded) / 2
    spans = [span for span in runs(closed(light, count)) if np.count_nonzero(heavy[slice(*span)]) >= count]
    if not spans:
        raise InputError(
            f"{recording.source}: no contact found that lasts {SHORTEST:g} s; the normal force reaches"
            f" {loaded - free:.3g} N for shorter times only."
        )
    if spans[0][0] == 0 and spans[-1][1] == len(time):
        raise InputError(
            f"{recording.source}: begins and ends under load, so that the zero of the sensors is unknown. If the"
            " finger was off the plate then, normal.sensitivity has the wrong sign."
        )
    return _with_free_sides(time, force, spans, (free, loaded))


def find_slides(recording: Recording, contact: Touch) -> list[Span]:
    """Find the sections of a contact in which the finger slides in one direction; none if there is no motion.

    With a position, the finger slides where the speed exceeds half of its largest value. Without one, it is
    taken to slide where the lateral force exceeds half of its largest lasting value, because nothing else in
    the record distinguishes sliding from rest; the force of a finger that stops and stays pressed may remain
    as large.
    """
    first, last = contact.span
    moving = sliding_speed(recording)
    if moving is None:
        moving, least = _rubbing(recording, contact), 0.0
        if moving is None:
            return []
    else:
        least = FEWEST_COUNTS * recording.step
    threshold = float(np.abs(moving[first:last]).max()) / 2
    count = max(1, round(SHORTEST / _period(recording.time)))
    found = []
    for sign in (1, -1):
        slides = runs(closed(sign * moving[first:last] > threshold, count)) if threshold else []
        found += [(first + a, first + b) for a, b in slides]
    # by the distance, or the duration if there is no position
    along = recording.time if recording.position is None else recording.position
    sizes = {(first, last): abs(along[last - 1] - along[first]) for first, last in found}
    longest = max(sizes.values(), default=0.0)
    return sorted(span for span, size in sizes.items() if size >= max(least, longest / 5))


def _rubbing(recording: Recording, contact: Touch) -> Real | None:
    """Return the lateral force about its zero, or None if it does not exceed its noise."""
    sides = [slice(*side) for side in (contact.before, contact.after) if side is not None]
    lateral = recording.lateral_force
    if not sides:
        return None
    zero = float(np.mean([np.median(lateral[side]) for side in sides]))
    even = smoothed(recording.time, lateral) - zero
    noise = max(float(np.std(even[side] - np.median(even[side]))) for side in sides)
    # a short peak, as of a finger that sticks before it slides, does not determine the level
    size = np.abs(even[slice(*contact.span)])
    largest = float(np.quantile(size, 0.9))
    return np.clip(even, -largest, largest) if largest > CLEAR * noise else None


def travel(recording: Recording, span: Span) -> float | None:
    """Return the distance between the first and the last sample of a section [m]; None without a position."""
    if recording.position is None:
        return None
    return float(abs(recording.position[span[1] - 1] - recording.position[span[0]]))


def sliding_speed(recording: Recording) -> Real | None:
    """Return the speed of the carriage over `SMOOTHING` [m/s], without single wrong counts; None without a position."""
    from scipy.ndimage import median_filter

    if recording.position is None:
        return None
    position = median_filter(recording.position, 5, mode="nearest")
    half = max(1, _width(recording.time) // 2)
    place = np.arange(len(position))
    later, earlier = np.minimum(place + half, len(position) - 1), np.maximum(place - half, 0)
    moved = (position[later] - position[earlier]) / (recording.time[later] - recording.time[earlier])
    return np.asarray(moved, dtype=np.float64)


def middle(recording: Recording, slide: Span, contact: Touch) -> Span:
    """Return the steady middle of a slide, without `TRIM` of its distance, or of its time without a position, at both ends."""
    first, last = slide
    along = recording.time if recording.position is None else recording.position
    gone = np.abs(along[first:last] - along[first])
    inside = np.flatnonzero((gone >= TRIM * gone[-1]) & (gone <= (1 - TRIM) * gone[-1]))
    guard = _width(recording.time)
    begin = max(first + int(inside[0]), contact.span[0] + guard)
    end = min(first + int(inside[-1]) + 1, contact.span[1] - guard)
    return begin, end


def _period(time: Real) -> float:
    return float((time[-1] - time[0]) / (len(time) - 1))


def _width(time: Real) -> int:
    return max(3, round(SMOOTHING / _period(time)))


def _level(time: Real, force: Real) -> Real:
    """Subtract the drift proportional to time for which two levels describe the force best."""
    thin = slice(None, None, max(1, len(force) // 2000))
    few, at = force[thin], np.linspace(-0.5, 0.5, len(force[thin]))
    span = 2 * float(np.ptp(few))
    best = 0.0
    for _ in range(3):  # each time around the best so far, ten times as fine
        slopes = best + span * np.linspace(-1, 1, 41)
        best = min(slopes, key=lambda slope: _scatter_about_two_levels(few - slope * at))
        span /= 10
    return np.asarray(force - best * (time - time.mean()) / (time[-1] - time[0]))


def _scatter_about_two_levels(values: Real) -> float:
    """Return the sum of squares about the means of the two groups for which it is least."""
    level = _split(values)
    high = values > level
    return float(
        sum(np.sum((part - part.mean()) ** 2) for part in (values[high], values[~high]) if len(part))
    )


def _split(values: Real) -> float:
    """Find the level that splits values into two groups of least scatter (Otsu's threshold)."""
    ordered = np.sort(values)
    count = np.arange(1, len(ordered))
    left = np.cumsum(ordered)[:-1]
    right = ordered.sum() - left
    between = count * (len(ordered) - count) * (left / count - right / (len(ordered) - count)) ** 2
    return float(ordered[int(np.argmax(between))])


def _with_free_sides(time: Real, force: Real, spans: list[Span], levels: tuple[float, float]) -> list[Touch]:
    """Add to each contact the samples free of load before and after it, without those in which the load changes."""
    free, loaded = levels
    tenth = force > free + (loaded - free) / 10
    shortest = max(3, round(SHORTEST / _period(time)))
    bounds = [0, *(edge for span in spans for edge in span), len(time)]
    found = []
    for number, (first, last) in enumerate(spans):
        start, stop = bounds[2 * number], bounds[2 * number + 3]
        rise = int(np.argmin(np.append(tenth[start:first][::-1], False)))
        fall = int(np.argmin(np.append(tenth[last:stop], False)))
        # the load reaches a tenth later than it begins: as much again is omitted, but at most half of what there is
        lead = min(2 * rise + shortest, (first - start) // 2)
        tail = min(2 * fall + shortest, (stop - last) // 2)
        before = (start, first - lead) if first - lead - start >= shortest else None
        after = (last + tail, stop) if stop - last - tail >= shortest else None
        found.append(Touch((first, last), before, after))
    return _with_far_sides(found)


def _with_far_sides(contacts: list[Touch]) -> list[Touch]:
    """Where a contact follows too soon, take the samples free of load before or after its neighbours."""

    def nearer(known: Span | None, own: Span | None) -> Span | None:
        return own or known

    befores = itertools.accumulate([each.before for each in contacts], nearer)
    afters = itertools.accumulate([each.after for each in contacts[::-1]], nearer)
    sides = zip(contacts, befores, reversed(list(afters)), strict=True)
    return [Touch(contact.span, before, after) for contact, before, after in sides]
