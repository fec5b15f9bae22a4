"""What a person feels of a drive, as numbers and words, and whether two of them can be told apart."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Final

from electrovib.core.errors import InputError
from electrovib.physics.perception import MOTION, RYU, Perception
from electrovib.study.felt_spectrum import Lines

VERDICTS: Final = ("detectable", "not detectable", "within the uncertainty", "relative only")


@dataclass(frozen=True, kw_only=True)
class Felt:
    """One channel's answer.

    Parameters
    ----------
    channel : str
        Model.
    level : float
        dB re 1 m, or re 1 N where the displacement is taken in proportion to the force.
    relative : float
        dB above a sine of force as large at the best frequency.
    status, source : str
        How far its weight can be believed.
    """

    channel: str
    level: float
    relative: float
    status: str
    source: str


@dataclass(frozen=True, kw_only=True)
class Percept:
    """What a person feels of a drive.

    Parameters
    ----------
    title : str
        Of the scenario.
    channels : tuple of Felt
        In the order of `Perception.channels`.
    loudest : str
        The channel that decides; empty if nothing moves.
    level : float
        Of that channel, dB re 1 `unit`.
    unit : str
        ``"m"``, or ``"N"`` without mechanics.
    relative : float
        dB above a sine of force at `best_frequency` with half the peak to peak of this force as amplitude.
    interval : tuple of float
        Lowest and highest of `relative` and `alternatives` [dB].
    alternatives : mapping of str to float
        `relative` under other assumptions that are as well founded [dB].
    best_frequency : float
        Of the most sensitive channel [Hz].
    sensation : float or None
        dB above the threshold; None where it is not calibrated.
    uncertainty : float or None
        Of the threshold, dB.
    verdict : str
        One of `VERDICTS`.
    difference_threshold : float
        dB of voltage amplitude.
    swing : float
        Half of peak to peak of the signal, N or m.
    spectrum : Lines
        What was looked at.
    numerical_error : float
        Change of the level with twice the samples [dB]; NaN for a measurement.
    calibrated_on : tuple of str
        What every number stands on.
    """

    title: str
    channels: tuple[Felt, ...]
    loudest: str
    level: float
    unit: str
    relative: float
    interval: tuple[float, float]
    alternatives: Mapping[str, float]
    best_frequency: float
    sensation: float | None
    uncertainty: float | None
    verdict: str
    difference_threshold: float
    swing: float
    spectrum: Lines
    numerical_error: float
    calibrated_on: tuple[str, ...]

    def to_dict(self) -> dict[str, Any]:
        """Give plain numbers and texts; a level of minus infinity is None, the spectrum two lists."""
        plain = asdict(self)
        for name in ("frequency", "amplitude"):
            plain["spectrum"][name] = plain["spectrum"][name].tolist()
        plain["alternatives"] = dict(self.alternatives)
        found: dict[str, Any] = _finite(plain)
        return found


@dataclass(frozen=True, kw_only=True)
class Difference:
    """Whether two percepts can be told apart.

    Parameters
    ----------
    difference : float
        Level of the first above the second, as a change of voltage amplitude: half that of the force [dB].
    threshold : float
        dB of voltage amplitude.
    noticeable : bool
        Whether it is larger.
    text : str
        In words, with what it stands on.
    """

    difference: float
    threshold: float
    noticeable: bool
    text: str


def _finite(value: Any) -> Any:
    """Put None where a number is not finite, which JSON has no word for."""
    if isinstance(value, Mapping):
        return {key: _finite(inner) for key, inner in value.items()}
    if isinstance(value, (tuple, list)):
        return [_finite(inner) for inner in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def verdict(*, sensation: float | None, uncertainty: float | None) -> str:
    """Compare a level above threshold [dB] with the uncertainty of the threshold [dB].

    Parameters
    ----------
    sensation, uncertainty : float or None
        dB; None where the threshold is not calibrated.

    Returns
    -------
    str
        One of `VERDICTS`.
    """
    if sensation is None or uncertainty is None:
        return "relative only"
    if abs(sensation) <= uncertainty:
        return "within the uncertainty"
    return "detectable" if sensation > 0 else "not detectable"


def stands_on(found: Lines, person: Perception, given: Any) -> tuple[str, ...]:
    """Say what every number is calibrated on."""
    texts = [
        f"{type(channel).__name__}: {channel.status}; {channel.reference}" for channel in person.channels
    ]
    if found.signal == "skin_displacement":
        texts.append("mechanics: the displacement of the skin was measured")
    elif given is None:
        texts.append(
            "mechanics: none given, the displacement is taken in proportion to the force; give perception.compliance,"
            " for instance { model = 'ElasticViscousSkin', stiffness = ..., corner = ... }"
        )
    else:
        texts.append(f"mechanics: {type(given).__name__} as declared, values by the user or the scenario")
    if person.threshold is None:
        texts.append(
            "threshold: relative only, calibrate with perception.threshold and perception.threshold_uncertainty"
        )
    elif given is None and found.signal != "skin_displacement":
        texts.append(
            "threshold: a length, which needs perception.compliance to be compared with a force; relative only"
        )
    else:
        texts.append(
            f"threshold: {person.threshold:.4g} m within {person.threshold_uncertainty:g} dB, by the user"
        )
    texts.append(
        f"difference threshold: {person.difference_threshold:g} dB, taken as of voltage amplitude, which {RYU}, does not say"
    )
    return (*texts, MOTION)


def compare_percepts(first: Percept, second: Percept) -> Difference:
    """Tell whether two drives can be told apart by their strength.

    Parameters
    ----------
    first, second : Percept
        With levels in the same unit.

    Returns
    -------
    Difference
        The attraction goes as the square of the voltage, so 1.21 dB of voltage are 2.42 dB of level.

    Raises
    ------
    InputError
        If one has mechanics and the other none, or nothing moves in either.
    """
    if first.unit != second.unit:
        raise InputError(
            "levels of a force and of a displacement cannot be compared: give both perception.compliance, or neither"
        )
    if not (first.loudest and second.loudest):
        raise InputError(
            "nothing moves the skin in one of the two: whether it is felt is a question for the threshold"
        )
    difference = (first.level - second.level) / 2
    threshold = min(first.difference_threshold, second.difference_threshold)
    noticeable = abs(difference) > threshold
    text = (
        f"{difference:+.2f} dB of voltage amplitude against {threshold:g} dB: {'can' if noticeable else 'cannot'} be told"
        f" apart by strength; 1.21 dB is from {RYU}, which does not say of what: taken as of voltage amplitude"
    )
    if first.loudest != second.loudest:
        text += f"; felt by different channels ({first.loudest}, {second.loudest}), which may tell them apart otherwise"
    return Difference(difference=difference, threshold=threshold, noticeable=noticeable, text=text)
