"""Reduced swipes as results: the parts of a swipe, its forces over time, the numbers and the choices of the zero."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from electrovib.core.answer import REFERENCE, Answer, Curve, Document, Panel, Table
from electrovib.core.deprecation import former_attribute
from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity
from electrovib.data.atomic import Form
from electrovib.recordings.interval import Interval, NumberRow, numbers_csv, numbers_table
from electrovib.recordings.recording import Span, closed, runs
from electrovib.recordings.running_median import running_median

if TYPE_CHECKING:
    from collections.abc import Sequence

    import xarray

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
    if recording.position is None:
        return None
    position = running_median(recording.position, 5, beyond="edge")
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


@dataclass(frozen=True, kw_only=True, repr=False)
class SwipeResult(Answer):
    """One swipe, reduced to forces and friction.

    - `normal_force`, `lateral_force`: means over the window [N]; the lateral force is positive in the
      direction of the friction of this swipe.
    - `direction`: 1 if the position increases, else -1; without a position, the sign of the lateral force.
    - `speed`, `distance`: mean speed in the window and sliding distance of the whole slide. Without a
      position the speed is the declared one; None if not known.
    - `remarks`: what was measured and what limits it, warnings first.
    - `trace`: whole record, with the baseline of this swipe subtracted.
    """

    FILES: ClassVar = {"swipes.csv": Form.TABLE}
    normal_force: Interval
    lateral_force: Interval
    friction: Interval
    direction: int
    speed: float | None
    distance: float | None
    contact: tuple[float, float]
    window: tuple[float, float]
    remarks: tuple[str, ...]
    trace: xarray.Dataset
    words = former_attribute("words", "document", lambda self: self.remarks)

    @property
    def document(self) -> Document:
        """Friction and forces, the windows, and the choices of the zero."""
        return Swipes((self,)).document

    def content(self, name: str) -> str:
        """Write the numbers as CSV."""
        return Swipes((self,)).content(name)

    @property
    def warnings(self) -> list[str]:
        """What makes the numbers doubtful."""
        return [text for text in self.remarks if text.startswith("Warning")]

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers and texts for JSON, in SI, without the Trace."""
        return {
            **{name: plain(getattr(self, name)) for name in ("normal_force", "lateral_force", "friction")},
            "direction": self.direction,
            "speed": self.speed,
            "distance": self.distance,
            "contact": list(self.contact),
            "window": list(self.window),
            "words": list(self.remarks),
        }


class Swipes(Answer, tuple[SwipeResult, ...]):
    """All swipes of a recording, in the order of time."""

    __slots__ = ()
    FILES: ClassVar = {"swipes.csv": Form.TABLE}

    @property
    def document(self) -> Document:
        """Friction and forces of each swipe, the windows, and the choices of the zero."""
        many = len(self) > 1
        numbered = list(enumerate(self, start=1))
        return Document(
            title=f"{'Swipes' if many else 'Swipe'} in {Path(self[0].trace.attrs['source']).name}",
            sentences=[text for each in self for text in (_sentence(each), *each.warnings)],
            numbers=[numbers_table("Friction and forces", swipe_rows(self))],
            figures=[
                panel
                for number, each in numbered
                for panel in _panels(
                    each,
                    f" of swipe {number}" if many else " of the swipe",
                    id=f"swipe{number if many else ''}",
                )
            ],
            tables=[_zeros(self)],
            remarks=[
                f"{f'Swipe {number}: ' * many}{text}"
                for number, each in numbered
                for text in each.remarks
                if text not in each.warnings
            ],
        )

    def content(self, name: str) -> str:
        """Write the numbers as CSV."""
        del name
        return numbers_csv(swipe_rows(self))


def plain(found: Interval) -> dict[str, Any]:
    """Return plain numbers for JSON."""
    return {
        "value": found.value,
        "interval": list(found.ends),
        "baseline_interval": list(found.choice_ends),
        "by_baseline": dict(found.choices),
        "standard_error": found.standard_error,
    }


def swipe_rows(swipes: Sequence[SwipeResult]) -> list[NumberRow]:
    """List the numbers of swipes."""
    rows = []
    for number, swipe in enumerate(swipes, start=1):
        group = f"swipe {number}" if len(swipes) > 1 else "swipe"
        note = "; ".join(text.removeprefix("Warning: ") for text in swipe.warnings)
        how = "from the position" if swipe.distance is not None else "as declared"
        found = [
            ("friction", "1", swipe.friction, note),
            ("normal force", "N", swipe.normal_force, note),
            ("lateral force", "N", swipe.lateral_force, note),
            *(
                (name, unit, Interval(value=value, method=how), "")
                for name, unit, value in (("speed", "m/s", swipe.speed), ("distance", "m", swipe.distance))
                if value is not None
            ),
        ]
        rows += [
            NumberRow(group=group, name=name, unit=unit, number=each, note=note)
            for name, unit, each, note in found
        ]
    return rows


def _panels(swipe: SwipeResult, of: str, *, id: str) -> list[Panel]:  # noqa: A002 - the name of the field
    """Make the figures of a swipe over time: both forces of the record, and their quotient in the window of the averages."""
    time, normal, lateral = (
        np.asarray(swipe.trace[name].values)
        for name in ("time", "normal_force_measured", "lateral_force_measured")
    )
    margin = 0.3 * (swipe.contact[1] - swipe.contact[0])
    near = (time >= swipe.contact[0] - margin) & (time <= swipe.contact[1] + margin)
    inside = (time >= swipe.window[0]) & (time <= swipe.window[1]) & (normal != 0)
    ends: dict[str, Any] = {"x": np.array(swipe.window), "look": REFERENCE}
    top, mean = (np.full(2, value) for value in (normal[near].max(), swipe.friction.value))
    return [
        Panel(
            id=id,
            title=f"Forces{of}",
            caption="The zero of the sensors is subtracted. Grey: the time over which both are averaged.",
            x=("time", "s"),
            y=("force", "N"),
            curves=(
                Curve(label="averaged", y=0 * top, upper=top, kind="band", **ends),
                _line("normal force", time[near], normal[near]),
                _line("lateral force", time[near], lateral[near]),
            ),
        ),
        Panel(
            id=f"{id}_friction",
            title=f"Friction{of}",
            caption="Lateral over normal force at each sample of the time averaged over, and the friction of the swipe.",
            x=("time", "s"),
            y=("friction", "1"),
            curves=(
                _line("at each sample", time[inside], np.abs(lateral[inside] / normal[inside])),
                Curve(label="of the swipe", y=mean, kind="dashed", **ends),
            ),
        ),
    ]


def _line(label: str, time: Real, values: Real) -> Curve:
    return Curve(label=label, x=time, y=values)


def _sentence(swipe: SwipeResult) -> str:
    lower, upper = swipe.friction.ends
    speed = f" at {format_quantity(swipe.speed, 'm/s', digits=3)}" if swipe.speed else ""
    load = format_quantity(swipe.normal_force.value, "N", digits=3)
    return f"Friction {swipe.friction.value:.3f} ({lower:.3f} to {upper:.3f}) under {load}{speed}."


def _zeros(swipes: Sequence[SwipeResult]) -> Table:
    rows = tuple(
        (
            f"swipe {number}",
            name,
            f"{each.friction.choices[name]:.4g}",
            format_quantity(each.normal_force.choices[name], "N", digits=4),
            format_quantity(each.lateral_force.choices[name], "N", digits=4),
        )
        for number, each in enumerate(swipes, start=1)
        for name in each.friction.choices
    )
    return Table(
        "Choice of the zero",
        ("Swipe", "Zero of the sensors", "Friction", "Normal force", "Lateral force"),
        rows,
        caption="Before or after the contact, their mean, or interpolated in time between them.",
    )
