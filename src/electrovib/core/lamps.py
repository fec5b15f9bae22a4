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
    value, limit : float, optional
        What was reached and what it was held against, both in `unit`; absent where there is no number.
    unit : str
        SI unit of both.
    """

    name: str
    state: str
    text: str
    value: float | None = None
    limit: float | None = None
    unit: str = ""

    def __post_init__(self) -> None:
        """Refuse an unknown state."""
        if self.state not in STATES:
            msg = f"lamp '{self.name}': state '{self.state}' is not one of {', '.join(STATES)}"
            raise ValueError(msg)

    def to_dict(self) -> dict[str, str | float]:
        """Give plain texts and numbers; numbers that are absent are left out."""
        content = asdict(self)
        if not self.unit:
            content = {name: content[name] for name in ("name", "state", "text")}
        return {name: value for name, value in content.items() if value is not None}
