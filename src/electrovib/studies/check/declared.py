"""Limits declared in several places, of which the strictest counts."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, TypeAlias

from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.core.parsing import read_toml_file
from electrovib.core.units import format_quantity
from electrovib.physics.limits import WORDS, Limits, unit_of_limit
from electrovib.scenario import Scenario

NEEDED: Final = ("voltage", "current")
"""Limits without which nothing that can be played is written or played."""
LINES_TO_ADD: Final = 'limits = { voltage = "1 kV", current = "250 uA" }'
"""Line of a scenario, or of a file of limits, that declares what is needed, with the values of Vezzoli et al. 2014."""
LimitsSource: TypeAlias = "str | Path | Mapping[str, Any] | Limits | LimitsFrom | None"
"""Limits from a TOML file, a table, a `Limits`, or a `LimitsFrom`, which also names where they are declared."""


@dataclass(frozen=True)
class LimitsFrom:
    """Limits of one place, named as it is shown: ``the scenario``, a file; `notes` has the stated source of a limit."""

    place: str
    limits: Limits
    notes: Mapping[str, str] | None = None


@dataclass(frozen=True)
class DeclaredLimit:
    """The strictest limit of one quantity in its unit; `source` also has the less strict values of other places."""

    name: str
    value: float
    source: str


def limits_from(source: LimitsSource) -> LimitsFrom:
    """Read limits from one place; a TOML file has them alone or in a table ``[limits]``, and None declares none."""
    if source is None:
        return LimitsFrom("", Limits())
    if isinstance(source, LimitsFrom):
        return source
    if isinstance(source, Limits):
        return LimitsFrom("limits", source)
    if isinstance(source, Mapping):
        return LimitsFrom("limits", _built(source, ""))
    if not isinstance(source, str | Path):
        why = f"expected a TOML file or a table such as {LINES_TO_ADD}, not a {type(source).__name__}"  # type: ignore[unreachable]
        raise InputError(why, path="limits")
    tables = read_toml_file(
        Path(source), kind="a file of limits", advice=f"Give a TOML file with {LINES_TO_ADD}"
    )
    return LimitsFrom(str(source), _built(tables, f"{source}: "))


def limits_of(scenario: Scenario) -> LimitsFrom:
    """Return the limits of a scenario, with the sources that it states for them."""
    notes = {name: scenario.sources.get(f"limits.{name}", "") for name in WORDS}
    return LimitsFrom("the scenario", scenario.limits, notes)


def strictest(places: Iterable[LimitsFrom]) -> dict[str, DeclaredLimit]:
    """Combine limits of several places: of each quantity the smallest counts, of equal ones the first is named."""
    given = list(places)
    found = {}
    for name in WORDS:
        values = [(getattr(each.limits, name), each) for each in given]
        declared = sorted(
            ((value, each) for value, each in values if value is not None), key=lambda pair: pair[0]
        )
        if not declared:
            continue
        (value, first), *others = declared
        text = f"limits.{name} of {first.place}"
        if note := (first.notes or {}).get(name):
            text += f" ({note})"
        more = [
            f"{format_quantity(other, unit_of_limit(name), digits=6)} of {each.place}"
            for other, each in others
        ]
        found[name] = DeclaredLimit(
            name, value, text + (f"; also declared: {', '.join(more)}" if more else "")
        )
    return found


def refuse_unlimited(
    declared: Mapping[str, DeclaredLimit], *, what: str = "a waveform that can be played"
) -> None:
    """Refuse to continue unless the largest voltage and the largest current are declared."""
    missing = [name for name in NEEDED if name not in declared]
    if missing:
        words = " and ".join(f"limits.{name} ({WORDS[name]})" for name in missing)
        verb = "is" if len(missing) == 1 else "are"
        raise InputError(
            f"{words} {verb} not declared, and {what} needs the largest voltage and the largest"
            " current; nothing was written. Add to the scenario, before its first"
            f" table, or to the file of --limits, with the values of your set-up: {LINES_TO_ADD}; or --set limits.voltage=..."
        )


def unlimited_words(name: str) -> str:
    """Return how to declare a limit that is not declared."""
    return f"not declared; add limits.{name}"


def _built(content: Mapping[str, Any], start: str) -> Limits:
    inner = content.get("limits")
    table = inner if isinstance(inner, Mapping) else content
    table = {name: value for name, value in table.items() if name != "schema"}
    try:
        return read_model(Limits, table)
    except InputError as error:
        raise InputError(each.within(f"{start}limits") for each in error.problems) from None
