"""Statements on how far a result can be believed."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Final

STATES: Final = ("ok", "unknown", "warning")
"""From best to worst."""


@dataclass(frozen=True)
class Lamp:
    """One statement on how far a result can be believed.

    Parameters
    ----------
    name : str
        What is watched.
    state : str
        ``"ok"``, ``"warning"`` (beyond the limit) or ``"unknown"`` (no limit known, or nothing to watch).
    text : str
        With the value and the limit.
    """

    name: str
    state: str
    text: str

    def __post_init__(self) -> None:
        """Refuse an unknown state."""
        if self.state not in STATES:
            msg = f"lamp '{self.name}': state '{self.state}' is not one of {', '.join(STATES)}"
            raise ValueError(msg)

    def to_dict(self) -> dict[str, str]:
        """Give plain texts."""
        return asdict(self)
