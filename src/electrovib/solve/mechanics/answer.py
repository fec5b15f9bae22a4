"""Results of the mechanics over time."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from electrovib.core.diagnostics import Diagnostic

if TYPE_CHECKING:
    from electrovib.core.arrays import Real


@dataclass
class Mechanics:
    """Results of the mechanics over time.

    Parameters
    ----------
    signals : dict
        Dimensions and values of every signal.
    how : dict
        Errors and events, for the attributes of the Trace.
    diagnostics : list of Diagnostic
        Diagnostics of the mechanics.
    """

    signals: dict[str, Any] = field(default_factory=dict)
    how: dict[str, Any] = field(default_factory=dict)
    diagnostics: list[Diagnostic] = field(default_factory=list)

    def add(self, rows: dict[str, Real]) -> None:
        """Add signals over time."""
        self.signals |= {name: (("time",), row) for name, row in rows.items()}
