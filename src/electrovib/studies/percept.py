"""Levels at which a person feels a drive, and whether two drives can be discriminated."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Final

from electrovib.core.answer import Answer, Document
from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError
from electrovib.physics.perception import RYU
from electrovib.studies.felt_spectrum import Lines
from electrovib.studies.sensation import COMPLIANCE, THRESHOLD

VERDICTS: Final = ("detectable", "not detectable", "within the uncertainty", "relative only")
SETTLED: Final = 0.01
"""Change of a level with twice the samples up to which it is not stated [dB]."""
_ANSWERS: Final = {
    "detectable": "felt",
    "not detectable": "not felt",
    "within the uncertainty": "felt or not: undecided within the spread",
}


@dataclass(frozen=True, kw_only=True)
class Felt:
    """Level of one channel.

    - `channel`: name of the model of the channel.
    - `level`: [dB re 1 m], or [dB re 1 N] where the displacement is taken as proportional to the force.
    - `relative`: level relative to a sine of equal force at the best frequency [dB].
    - `status`, `source`: of the weight.
    """

    channel: str
    level: float
    relative: float
    status: str
    source: str


@dataclass(frozen=True, kw_only=True, repr=False)
class Percept(Answer):
    """Levels at which a person feels a drive.

    - `channels`: in the order of `Perception.channels`; `loudest`: with the highest level, empty if nothing
      moves.
    - `level`, `unit`: of that channel [dB re 1 `unit`]; the unit is ``"m"``, or ``"N"`` without mechanics.
    - `relative`: level relative to a sine of force at `best_frequency` whose amplitude is half of the
      peak-to-peak force [dB].
    - `alternatives`: `relative` under other assumptions that are as well founded; `interval`: lowest and
      highest of all these [dB].
    - `best_frequency`: of the most sensitive channel [Hz].
    - `sensation`: level relative to the detection threshold, middle of its range [dB]; None where nothing
      moves, or no threshold is known.
    - `uncertainty`: half of that range [dB]: uncertainty of the threshold, and spread of the published values
      that are assumed.
    - `felt_by`: channel that is highest above its threshold; empty without a level above threshold.
    - `left`: what is assumed, ``perception.threshold`` or ``perception.compliance``, to the uncertainty that
      remains once it has been measured [dB]; empty if both are given.
    - `verdict`: one of `VERDICTS`.
    - `difference_threshold`: of the voltage amplitude [dB].
    - `swing`: half of the peak-to-peak value of the signal [N] or [m]; `spectrum`: as it was evaluated.
    - `numerical_error`: change of the level with twice the samples [dB]; NaN for a measurement.
    - `calibrated_on`: assumptions and sources of the levels.
    - `diagnostics`: of the scenario, or those that a measurement states.
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
    felt_by: str
    left: Mapping[str, float]
    verdict: str
    difference_threshold: float
    swing: float
    spectrum: Lines
    numerical_error: float
    calibrated_on: tuple[str, ...]
    diagnostics: tuple[Diagnostic, ...]

    @property
    def answer(self) -> str:
        """Whether it is felt, by which channel, and by how much, with the spread of what is assumed."""
        if not self.loudest:
            return "not felt: nothing moves the skin"
        if self.sensation is None or self.uncertainty is None:
            return (
                f"felt or not: unknown without perception.threshold; strongest in the {self.loudest} channel"
            )
        low, high = self.sensation - self.uncertainty, self.sensation + self.uncertainty
        whose = "published detection thresholds" if THRESHOLD in self.left else "the detection threshold"
        level = f"{self.sensation:+.1f} dB ({low:+.1f} to {high:+.1f} dB) relative to {whose}"
        return f"{_ANSWERS[self.verdict]}, {self.felt_by} channel: {level}"

    @property
    def to_measure(self) -> str:
        """What is assumed, and what measuring it would change; empty if nothing is assumed."""
        if not self.left:
            return ""
        words = {THRESHOLD: "a detection threshold", COMPLIANCE: "a compliance of the skin"}
        named = " and ".join(words[name] for name in self.left)
        rest = ", ".join(f"{name} of your own leaves +-{value:.1f} dB" for name, value in self.left.items())
        return f"assumed from publications: {named}; {rest}"

    @property
    def sentences(self) -> list[str]:
        """Whether the drive is felt, by which channel and by how much, and what limits this answer."""
        told = [self.title, self.answer, self.to_measure]
        if abs(self.numerical_error) > SETTLED:
            told.append(f"numerical error: {abs(self.numerical_error):.1g} dB")
        return [each for each in told if each]

    @property
    def details(self) -> list[str]:
        """What was evaluated, the level of every channel, other assumptions, and their sources."""
        lines = []
        if self.loudest:
            low, high = self.interval
            lines.append(
                f"strongest channel {self.loudest}: {_decibels(self.relative)} relative to a sine of equal force at"
                f" {self.best_frequency:g} Hz; {low:+.1f} to {high:+.1f} dB under other assumptions"
            )
        if abs(self.numerical_error) <= SETTLED:
            lines.append(f"numerical error: {abs(self.numerical_error):.1g} dB")
        status = " and ".join(dict.fromkeys(felt.status for felt in self.channels))
        signal, how = self.spectrum.signal.replace("_", " "), self.spectrum.how
        lines.append(f"evaluated: {signal}, {how}; channel weights: {status}, not measured")
        for felt in self.channels:
            level = f"{_decibels(felt.level)} re 1 {self.unit}" if math.isfinite(felt.level) else "nothing"
            relative = f", {_decibels(felt.relative)} relative" if math.isfinite(felt.relative) else ""
            lines.append(f"  {felt.channel}: {level}{relative} ({felt.status})")
        lines += [f"  {_decibels(value)} with {name}" for name, value in self.alternatives.items()]
        return [*lines, "assumptions:", *(f"  {text}" for text in self.calibrated_on)]

    @property
    def document(self) -> Document:
        """The sentences, and where the assumptions are."""
        return Document(
            title=f"What is felt: {self.title or 'a scenario'}",
            sentences=self.sentences,
            diagnostics=self.diagnostics,
            remarks=["calibrated_on lists the assumptions"],
        )

    def to_dict(self) -> dict[str, Any]:
        """Return numbers, texts and lists; a level of minus infinity becomes None."""
        plain = asdict(self)
        for name in ("frequency", "amplitude"):
            plain["spectrum"][name] = plain["spectrum"][name].tolist()
        plain["alternatives"] = dict(self.alternatives)
        plain["left"] = dict(self.left)
        found: dict[str, Any] = _finite(plain)
        return found


def _decibels(value: float) -> str:
    return f"{value:+.1f} dB"


@dataclass(frozen=True, kw_only=True)
class Difference:
    """Difference of two percepts, and whether it is noticeable.

    - `difference`: level of the first relative to the second, as a change of the voltage amplitude [dB]: half
      that of the force.
    - `threshold`: difference threshold of the voltage amplitude [dB].
    - `noticeable`: whether the magnitude of the difference exceeds the threshold; `text`: the same in words,
      with the source of the threshold.
    - `diagnostics`: of both percepts.
    """

    difference: float
    threshold: float
    noticeable: bool
    text: str
    diagnostics: tuple[Diagnostic, ...]


def _finite(value: Any) -> Any:
    """Replace numbers that are not finite, which JSON cannot express, by None."""
    if isinstance(value, Mapping):
        return {key: _finite(inner) for key, inner in value.items()}
    if isinstance(value, (tuple, list)):
        return [_finite(inner) for inner in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def verdict(*, sensation: float | None, uncertainty: float | None) -> str:
    """Compare a level above threshold [dB] with the uncertainty of the threshold [dB]; None is not calibrated."""
    if sensation is None or uncertainty is None:
        return "relative only"
    if abs(sensation) <= uncertainty:
        return "within the uncertainty"
    return "detectable" if sensation > 0 else "not detectable"


def compare_percepts(first: Percept, second: Percept) -> Difference:
    """Judge whether two drives can be discriminated by their strength.

    Parameters
    ----------
    first, second : Percept
        Percepts with levels in the same unit.

    Returns
    -------
    difference : Difference
        Difference as a change of the voltage amplitude. The attraction is proportional to the square of the voltage, so
        1.21 dB of voltage are 2.42 dB of level.

    Raises
    ------
    InputError
        If only one of them has mechanics, or if nothing moves in one of them.
    """
    if first.unit != second.unit:
        raise InputError(
            "levels of a force and of a displacement cannot be compared: add perception.compliance to both, or to neither"
        )
    if not (first.loudest and second.loudest):
        raise InputError("in one of the two nothing moves the skin, so there is no level to compare")
    difference = (first.level - second.level) / 2
    threshold = min(first.difference_threshold, second.difference_threshold)
    noticeable = abs(difference) > threshold
    text = (
        f"{difference:+.2f} dB of voltage amplitude, where the change of the force is proportional to its square, difference"
        f" threshold {threshold:g} dB:"
        f" {'can' if noticeable else 'cannot'} be discriminated by strength; 1.21 dB is from {RYU}, which does not state its"
        " quantity: taken as voltage amplitude"
    )
    if first.loudest != second.loudest:
        text += f"; felt by different channels ({first.loudest}, {second.loudest}), by which they may be discriminated"
    both = tuple(dict.fromkeys((*first.diagnostics, *second.diagnostics)))
    return Difference(
        difference=difference, threshold=threshold, noticeable=noticeable, text=text, diagnostics=both
    )
