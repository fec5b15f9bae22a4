"""The contact over a voltage that changes slowly: each rest begins with the former, so that hysteresis is followed."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple

from electrovib.core.arrays import Real
from electrovib.solve.rough_contact.potential import Attraction, MaxwellStress
from electrovib.solve.rough_contact.rest import Loaded, Rest

Pull = Callable[[float], Attraction]
"""Attraction at a voltage [V]."""


class Fall(NamedTuple):
    """The voltage [V] beyond which a contact falls into another rest, the last rest before and the first after it."""

    voltage: float
    before: Rest
    after: Rest


def follow(
    loaded: Loaded, pull: Pull, voltages: Iterable[float], *, start: Real | None = None
) -> tuple[Rest, ...]:
    """Return the rest at each voltage [V], which begins with the gap of the former one; the first with `start`."""
    rests: list[Rest] = []
    for voltage in voltages:
        rests.append(loaded.rest(pull(voltage), start=start))
        start = rests[-1].gap
    return tuple(rests)


def follow_voltages(
    loaded: Loaded, voltages: Iterable[float], *, electrical_thickness: float
) -> tuple[Rest, ...]:
    """Return the rest at each voltage [V] across layers of an electrical thickness [m] and the gap, in this order."""
    return follow(
        loaded,
        lambda voltage: MaxwellStress(voltage=voltage, electrical_thickness=electrical_thickness),
        voltages,
    )


def fall(
    loaded: Loaded,
    pull: Pull,
    voltages: Iterable[float],
    *,
    start: Real | None = None,
    accuracy: float = 1e-4,
) -> Fall | None:
    """Return the first voltage [V] through which the contact falls: shut where they rise, open where they fall.

    Halved between two of them up to an accuracy relative to the larger; every step begins with the last rest before the fall.
    None where the contact follows the voltage to its end.
    """
    first, *others = voltages
    begin, before = first, loaded.rest(pull(first), start=start)
    for voltage in others:
        end, after = voltage, loaded.rest(pull(voltage), start=before.gap)
        while after.fell and abs(end - begin) > accuracy * max(abs(begin), abs(end)):
            middle = (begin + end) / 2
            found = loaded.rest(pull(middle), start=before.gap)
            if found.fell:
                end, after = middle, found
            else:
                begin, before = middle, found
        if after.fell:
            after = loaded.rest(pull(end), start=before.gap)
        if after.fell:
            return Fall(begin, before, after)
        begin, before = end, after
    return None
