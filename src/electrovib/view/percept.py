"""What a finger feels, in a few lines of text: the answer first, then what limits it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from electrovib.core.diagnostics import warning_lines
from electrovib.study.perceive import SETTLED

if TYPE_CHECKING:
    from electrovib.study.percept import Percept


def percept_lines(
    found: Percept, *, everything: bool = False, more: str = "calibrated_on lists assumptions"
) -> list[str]:
    """Report whether the drive is felt, by which channel and by how much, and then what limits this answer."""
    lines = [found.title] if found.title else []
    rest = "" if everything else f" ({more})"
    lines.append(found.answer if found.to_measure else f"{found.answer}{rest}")
    if found.to_measure:
        lines.append(f"{found.to_measure}{rest}")
    if found.loudest and everything:
        low, high = found.interval
        lines.append(
            f"strongest channel {found.loudest}: {_decibels(found.relative)} relative to a sine of equal force at"
            f" {found.best_frequency:g} Hz; {low:+.1f} to {high:+.1f} dB under other assumptions"
        )
    if abs(found.numerical_error) > SETTLED or (everything and math.isfinite(found.numerical_error)):
        lines.append(f"numerical error: {abs(found.numerical_error):.1g} dB")
    lines += warning_lines(found.diagnostics, brief=True)
    return lines + _details(found) if everything else lines


def _details(found: Percept) -> list[str]:
    status = " and ".join(dict.fromkeys(felt.status for felt in found.channels))
    lines = [
        f"evaluated: {found.spectrum.signal.replace('_', ' ')}, {found.spectrum.how}; channel weights: {status}, not measured"
    ]
    for felt in found.channels:
        level = f"{_decibels(felt.level)} re 1 {found.unit}" if math.isfinite(felt.level) else "nothing"
        relative = f", {_decibels(felt.relative)} relative" if math.isfinite(felt.relative) else ""
        lines.append(f"  {felt.channel}: {level}{relative} ({felt.status})")
    lines += [f"  {_decibels(value)} with {name}" for name, value in found.alternatives.items()]
    return [*lines, "assumptions:", *(f"  {text}" for text in found.calibrated_on)]


def _decibels(value: float) -> str:
    return f"{value:+.1f} dB"
