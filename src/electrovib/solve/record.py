"""Signals of a scenario at some times, before they become a Trace."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.core.diagnostics import Diagnostic
    from electrovib.solve.diagnostics.peaks import PeakRecord
    from electrovib.solve.electrics.solution import Solution


@dataclass(frozen=True, kw_only=True)
class Record:
    """Signals of a scenario at some times.

    Parameters
    ----------
    times : ndarray, shape (n,)
        Increasing [s].
    solution : Solution
        Electrical response of the stack.
    signals : dict
        Dimensions and values of every signal over time, in its unit.
    how : dict
        Solver, reason for its choice, errors and events.
    diagnostics : list of Diagnostic
        Diagnostics of the mechanics.
    peaks : PeakRecord or None
        Quantities with limits over the whole run; None where these times resolve them.
    """

    times: Real
    solution: Solution
    signals: dict[str, Any]
    how: dict[str, Any]
    diagnostics: list[Diagnostic]
    peaks: PeakRecord | None = None
