"""What a finger feels, in a few lines of text: the answer first, then what limits it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from electrovib.study.perceive import SETTLED

if TYPE_CHECKING:
    from electrovib.study.percept import Percept

WORDS: Final = {
    "detectable": "felt",
    "not detectable": "not felt",
    "within the uncertainty": "felt or not: undecided within the uncertainty",
}
"""Verdicts as answers."""


def percept_lines(
    found: Percept, *, everything: bool = False, more: str = "calibrated_on lists assumptions"
) -> list[str]:
    """Report whether the drive is felt, by which channel and by how much, and then what limits this answer.

    Parameters
    ----------
    found : Percept
        Levels and assumptions.
    everything : bool
        Whether to list the level of each channel, each alternative and each assumption with its source.
    more : str
        Where to find these if they are not listed.

    Returns
    -------
    list of str
        Lines; the answer comes first, after the title.
    """
    lines = [found.title] if found.title else []
    lines.append(_answer(found))
    if found.loudest:
        low, high = found.interval
        lines.append(
            f"{found.loudest}: {_decibels(found.relative)} relative to a sine of equal force at {found.best_frequency:g} Hz;"
            f" {low:+.1f} to {high:+.1f} dB under other assumptions"
        )
    status = " and ".join(dict.fromkeys(felt.status for felt in found.channels))
    lines.append(
        f"evaluated: {found.spectrum.signal.replace('_', ' ')}, {found.spectrum.how}; channel weights: {status}, not measured"
    )
    if abs(found.numerical_error) > SETTLED or (everything and math.isfinite(found.numerical_error)):
        lines.append(f"numerical error: {abs(found.numerical_error):.1g} dB")
    if everything:
        return lines + _details(found)
    return [
        *lines,
        f"not included: summation over time and area, masking, motion of the finger ({more})",
    ]


def _answer(found: Percept) -> str:
    if not found.loudest:
        return "not felt: nothing moves the skin"
    if found.sensation is None:
        return f"felt or not: unknown without {_missing(found)}; strongest in the {found.loudest} channel"
    level = f"{_decibels(found.sensation)} relative to the threshold, which is uncertain by {found.uncertainty:g} dB"
    return f"{WORDS[found.verdict]}, {found.loudest} channel: {level}"


def _missing(found: Percept) -> str:
    """Name what has to be given before a level can be compared with a threshold."""
    threshold = ["perception.threshold"] if found.uncertainty is None else []
    mechanics = ["perception.compliance"] if found.unit == "N" else []
    return " and ".join([*threshold, *mechanics])


def _details(found: Percept) -> list[str]:
    lines = []
    for felt in found.channels:
        level = f"{_decibels(felt.level)} re 1 {found.unit}" if math.isfinite(felt.level) else "nothing"
        relative = f", {_decibels(felt.relative)} relative" if math.isfinite(felt.relative) else ""
        lines.append(f"  {felt.channel}: {level}{relative} ({felt.status})")
    lines += [f"  {_decibels(value)} with {name}" for name, value in found.alternatives.items()]
    return [*lines, "assumptions:", *(f"  {text}" for text in found.calibrated_on)]


def _decibels(value: float) -> str:
    return f"{value:+.1f} dB"
