"""Statements on how far a result can be believed."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import asdict, dataclass, fields
from typing import Any, Final

from electrovib.core.parsing import read_json
from electrovib.core.units import format_quantity

STATES: Final = ("ok", "unknown", "warning")
"""From best to worst."""


@dataclass(frozen=True)
class Diagnostic:
    """One statement on how far a result can be believed.

    `state` is ``"ok"``, ``"warning"`` (beyond the limit) or ``"unknown"`` (no limit known, or nothing to
    judge). `value`, the largest value reached, and `limit` are in the SI unit `unit`, and None where there is
    no number. `area` is the share of the contact area beyond the limit [1], None where nothing declares it.
    """

    name: str
    state: str
    text: str
    value: float | None = None
    limit: float | None = None
    unit: str = ""
    area: float | None = None

    def __post_init__(self) -> None:
        if self.state not in STATES:
            msg = f"diagnostic '{self.name}': state '{self.state}' is not one of {', '.join(STATES)}"
            raise ValueError(msg)

    def to_dict(self) -> dict[str, str | float]:
        """Return the texts and numbers as a mapping; numbers that are absent are omitted."""
        content = asdict(self)
        if not self.unit:
            content = {name: content[name] for name in ("name", "state", "text")}
        return {name: value for name, value in content.items() if value is not None}


def read_diagnostics(text: str) -> list[Diagnostic]:
    """Read the attribute ``validity`` of a Trace; what a sweep adds to it, such as the case, is also in the texts."""
    known = {each.name for each in fields(Diagnostic)}
    return [
        Diagnostic(**{name: content[name] for name in known & set(content)}) for content in read_json(text)
    ]


def diagnostics_of(result: Any) -> list[Diagnostic]:
    """Return the diagnostics of a Trace, sweep or study (attribute ``validity``) or of any other result that has them."""
    if not hasattr(result, "attrs"):
        return list(result.diagnostics)
    try:
        return read_diagnostics(result.attrs.get("validity", "[]"))
    except (TypeError, ValueError, KeyError):
        return [Diagnostic("validity", "unknown", "the diagnostics that this file states cannot be read")]


def warning_lines(diagnostics: Iterable[Diagnostic], *, brief: bool = False) -> list[str]:
    """Write one line for each different warning, and one for all that could not be judged, without reasons if `brief`."""
    found = list({each.text: each for each in diagnostics}.values())
    lines = [f"warning: {each.text}" for each in found if each.state == "warning"]
    unknown = dict.fromkeys(each.name if brief else each.text for each in found if each.state == "unknown")
    return [*lines, f"not judged: {'; '.join(unknown)}"] if unknown else lines


def reasons(diagnostics: Iterable[Diagnostic]) -> list[str]:
    """Return the sentences of what could not be judged, each once."""
    return list(dict.fromkeys(each.text for each in diagnostics if each.state == "unknown"))


def comment_lines(diagnostics: Iterable[Diagnostic]) -> str:
    """Return these lines as comments at the head of a text file."""
    return "".join(f"# {line}\n" for line in warning_lines(diagnostics))


def against(name: str, *, value: float, limit: float, unit: str, what: str, why: str) -> Diagnostic:
    """Compare a value with a limit, both in `unit`: a warning above it, unknown for NaN."""
    bound = format_quantity(limit, unit, digits=3)
    if math.isnan(value):
        return Diagnostic(name, "unknown", f"{what} is not known, so it was not compared with {bound}: {why}")
    if math.isinf(value):
        return Diagnostic(name, "warning", f"{what} has no bound, above {bound}: {why}")
    state = "warning" if value > limit else "ok"
    word = "above" if state == "warning" else "within"
    shown = format_quantity(value, unit, digits=3)
    return Diagnostic(name, state, f"{what} reaches {shown}, {word} {bound}: {why}", value, limit, unit)
