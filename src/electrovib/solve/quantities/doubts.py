"""Diagnostics of quantities that are unknown or not resolved."""

from __future__ import annotations

import math
from typing import Final

from electrovib.core.diagnostics import Diagnostic

UNRESOLVED: Final = 1e-6
"""Error of the mean over the signal's largest value [1] above which a warning is returned."""


def doubts(values: dict[str, float], errors: dict[str, float]) -> list[Diagnostic]:
    """Return which quantities are unknown, and which signals were not resolved."""
    return [*_unknown(values), *_unresolved(errors)]


def _unknown(values: dict[str, float]) -> list[Diagnostic]:
    """Return which quantities are unknown because their signal is."""
    lost = [name for name, value in values.items() if math.isnan(value)]
    text = f"{', '.join(lost)}: not known, because the signal is not known during part of the time"
    return [Diagnostic("quantities", "unknown", text)] if lost else []


def _unresolved(errors: dict[str, float]) -> list[Diagnostic]:
    """Return a warning where a signal varies faster than it could be resolved."""
    missed = {name: error for name, error in errors.items() if error > UNRESOLVED}
    if not missed:
        return []
    worst = max(missed, key=lambda name: missed[name])
    text = (
        f"{', '.join(missed)}: the signal varies too often to be resolved; the error of its mean may be about"
        f" {missed[worst]:.1g} of its largest value. A shorter time.duration resolves it better"
    )
    return [Diagnostic("resolution", "warning", text, missed[worst], UNRESOLVED, "1")]
