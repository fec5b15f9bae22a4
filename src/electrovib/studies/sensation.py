"""Level of a drive above the detection threshold: of the person at hand, or, as an assumption, of published ones."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.units import format_quantity
from electrovib.physics.perception import COMPLIANCES, MOTION, RYU, decibels, felt_amplitude

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.physics.perception import Channel, Perception
    from electrovib.studies.felt_spectrum import Lines

THRESHOLD, COMPLIANCE = "perception.threshold", "perception.compliance"
"""What a person can measure, and what is assumed otherwise."""


@dataclass(frozen=True, kw_only=True)
class Sensation:
    """Lowest and highest level above the detection threshold [dB] of the channel that is excited most.

    `left` is half the range that would remain if `THRESHOLD` or `COMPLIANCE`, where assumed, were measured
    [dB].
    """

    channel: str
    low: float
    high: float
    left: dict[str, float]


def thresholds_of(person: Perception) -> list[tuple[Channel, float, float]]:
    """Return each channel with the lowest and highest amplitude at weight 1 that is just felt [dB re 1 m].

    Published thresholds stand in for one of the person; a channel without any is absent.
    """
    if person.threshold is not None:
        level, doubt = float(decibels(person.threshold)), person.threshold_uncertainty or 0.0
        return [(channel, level - doubt, level + doubt) for channel in person.channels]
    found = []
    for channel in person.channels:
        equal = [each.amplitude * float(channel.weight(each.frequency)) for each in channel.published]
        if equal := [each for each in equal if each > 0]:
            found.append((channel, float(decibels(min(equal))), float(decibels(max(equal)))))
    return found


def skins_of(found: Lines, given: Any) -> list[Any]:
    """Return the given mechanics, or the softest and the stiffest published skin; None for a measured displacement."""
    if found.signal == "skin_displacement":
        return [None]
    return [given] if given is not None else [each.skin for each in COMPLIANCES]


def sensation_of(found: Lines, person: Perception, given: Any) -> Sensation | None:
    """Compare a spectrum with the detection threshold; None where nothing moves, or no threshold is known."""
    known = thresholds_of(person)
    skins = skins_of(found, given)
    levels = np.array([[_level(found, channel, skin) for channel, *_ in known] for skin in skins])
    if not known or not np.any(np.isfinite(levels)):
        return None
    lowest = np.array([low for _, low, _ in known])
    highest = np.array([high for *_, high in known])
    top, bottom = (np.max(levels - edge, axis=1) for edge in (lowest, highest))
    middle = levels - (lowest + highest) / 2
    left = {}
    if person.threshold is None:
        left[THRESHOLD] = float(np.ptp(np.max(middle, axis=1))) / 2
    if len(skins) > 1:
        left[COMPLIANCE] = float(np.max(top - bottom)) / 2
    strongest = known[int(np.argmax(np.mean(middle, axis=0)))][0]
    return Sensation(
        channel=type(strongest).__name__, low=float(np.min(bottom)), high=float(np.max(top)), left=left
    )


def _level(found: Lines, channel: Channel, skin: Any) -> float:
    """Return the level of a channel [dB re 1 m]."""
    moved = found.amplitude if skin is None else found.amplitude * np.abs(skin.compliance(found.frequency))
    return float(decibels(felt_amplitude(channel, found.frequency, moved)))


def just_felt(found: Lines, person: Perception, given: Any, frequency: Real) -> tuple[Real, Real]:
    """Compute the lowest and highest amplitude of a single sine that is just felt; infinite where none is."""
    known = thresholds_of(person)
    given_skins = [
        1.0 if skin is None else np.abs(skin.compliance(frequency)) for skin in skins_of(found, given)
    ]

    def amplitudes(edges: list[float]) -> Real:
        felt = [
            [
                each[0].weight(frequency) * skin / 10 ** (edge / 20)
                for each, edge in zip(known, edges, strict=True)
            ]
            for skin in given_skins
        ]
        with np.errstate(divide="ignore"):
            return np.asarray(1 / np.max(felt, axis=1))

    low = np.min(amplitudes([each[1] for each in known]), axis=0)
    high = np.max(amplitudes([each[2] for each in known]), axis=0)
    return low, high


def _assumed(found: Lines, person: Perception, given: Any) -> list[str]:
    """List the published values that stand for what was not measured, each with its source and status."""
    texts = []
    if person.threshold is None:
        texts += [
            f"assumed threshold, {type(channel).__name__}: {format_quantity(each.amplitude, 'm', digits=3)} at"
            f" {each.frequency:g} Hz, {each.conditions} ({each.status}: {each.source}; taken as zero to peak)"
            for channel in person.channels
            for each in channel.published
        ]
    if len(skins_of(found, given)) > 1:
        texts += [
            f"assumed compliance, {each.conditions} ({each.status}: {each.source})" for each in COMPLIANCES
        ]
    return texts


def stands_on(found: Lines, person: Perception, given: Any) -> tuple[str, ...]:
    """List the assumptions and sources of the levels."""
    texts = [
        f"{type(channel).__name__}: {channel.status}; {channel.reference}" for channel in person.channels
    ]
    if found.signal == "skin_displacement":
        texts.append("mechanics: the displacement of the skin was measured")
    elif given is not None:
        texts.append(f"mechanics: {type(given).__name__} with the values of the scenario or the user")
    else:
        texts.append(
            "mechanics: none given, relative levels take the displacement as proportional to the force"
        )
    texts += _assumed(found, person, given)
    if person.threshold is not None:
        texts.append(
            f"threshold: {format_quantity(person.threshold, 'm', digits=4)} with an uncertainty of"
            f" {person.threshold_uncertainty:g} dB, given by the user"
        )
    texts.append(
        f"difference threshold: {person.difference_threshold:g} dB, taken as that of the voltage amplitude, which"
        f" {RYU}, does not state"
    )
    return (*texts, MOTION)
