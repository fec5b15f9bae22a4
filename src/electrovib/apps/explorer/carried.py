"""Parameters that stay when a model of a scenario is replaced by another one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final

from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.core.quantity import quantity_of
from electrovib.physics.drive.base import Drive
from electrovib.physics.drive.levels import LEVELS, SWING, LevelledDrive

if TYPE_CHECKING:
    from electrovib.core.model import Model

_UNITS: Final = {"voltage": "V", "current": "A"}
"""Unit of what a drive prescribes."""


def carried(kind: type[Model], present: Model) -> dict[str, float]:
    """Return the values of a model that another model takes: those of the same name and unit, within its ranges.

    Parameters of parts of `present` count where no other parameter has their name.
    """
    known: dict[str, tuple[float, str]] = {}
    for path, value, quantity in sorted(present.parameters(), key=lambda each: each[0].count(".")):
        if value is not None:
            known.setdefault(path.rpartition(".")[2], (value, quantity.unit))
    found = {}
    for name in kind.model_fields:
        declared = quantity_of(kind, name)
        if declared is None or name not in known:
            continue
        value, unit = known[name]
        if unit == declared.unit and declared.low <= value <= declared.high:
            found[name] = value
    return found


def carried_drive(kind: type[Drive], present: Drive, *, limit: float | None = None) -> dict[str, Any]:
    """Return the parameters with which a drive of a kind replaces another one.

    They are the example of `kind`, with the highest and lowest voltage (or current), the frequency and every
    other parameter that both drives have. What does not fit the rest is left at the example. A drive that
    would exceed the `limit`, the largest magnitude that the set-up allows for what `kind` prescribes [V or
    A], and the present one, is reduced to the limit.
    """
    table = dict(kind.example)
    for group in (
        _levels_of(kind, present),
        *({name: value} for name, value in _others(kind, present).items()),
    ):
        changed = {name: value for name, value in table.items() if not _replaced(name, group)} | group
        if group and _is_valid(kind, changed):
            table = changed
    drive = _built(kind, table)
    allowed = (
        None if limit is None else max(limit, present.largest() if present.quantity == kind.quantity else 0.0)
    )
    if allowed is not None and drive.largest() > allowed:
        table = _reduced(kind, table, drive, allowed / drive.largest())
        drive = _built(kind, table)
    stored = drive.to_dict()
    return {name: stored[name] for name in kind.model_fields if stored.get(name) is not None}


def _levels_of(kind: type[Drive], present: Drive) -> dict[str, float]:
    """Return the levels of the present drive as the chosen one takes them; empty where one is a voltage, the other a current."""
    if kind.quantity != present.quantity:
        return {}
    if isinstance(present, LevelledDrive):
        high, low = present.high, present.low
    else:
        low, high = present.extremes()
        if low == high:  # a step from zero
            low, high = min(low, 0.0), max(high, 0.0)
    if issubclass(kind, LevelledDrive):
        if SWING[0] in kind.model_fields:  # its amplitude is positive
            high, low = max(high, low), min(high, low)
        return dict(zip(LEVELS, (high, low), strict=True))
    one = _only_level(kind)
    return {one: max(high, low, key=abs)} if one else {}


def _others(kind: type[Drive], present: Drive) -> dict[str, float]:
    """Return the parameters of the present drive that are not levels, and its frequency where only its period is known."""
    found = carried(kind, present)
    if issubclass(kind, LevelledDrive):
        found = {name: value for name, value in found.items() if name not in (*SWING, *LEVELS)}
    found.pop(_only_level(kind), None)
    frequency = quantity_of(kind, "frequency") if "frequency" in kind.model_fields else None
    if frequency is not None and "frequency" not in found and present.period:
        found["frequency"] = 1 / present.period
    return found


def _only_level(kind: type[Drive]) -> str:
    """Return the name of the one level of a drive that has neither amplitude nor high and low; empty otherwise."""
    if issubclass(kind, LevelledDrive):
        return ""
    unit = _UNITS[kind.quantity]
    found = [name for name in kind.model_fields if (each := quantity_of(kind, name)) and each.unit == unit]
    return found[0] if len(found) == 1 else ""


def _replaced(name: str, group: Mapping[str, Any]) -> bool:
    """Return whether a parameter of the example is given by others: levels are given as one pair or as the other."""
    return name in group or (LEVELS[0] in group and name in (*SWING, *LEVELS))


def _reduced(kind: type[Drive], table: Mapping[str, Any], drive: Drive, factor: float) -> dict[str, Any]:
    """Return a table whose levels are smaller by a factor; the table itself where the drive has no levels."""
    if isinstance(drive, LevelledDrive):
        group = {"high": factor * drive.high, "low": factor * drive.low}
    else:
        one = _only_level(kind)
        group = {one: factor * float(table[one])} if one else {}
    return {name: value for name, value in table.items() if not _replaced(name, group)} | group


def _is_valid(kind: type[Drive], table: Mapping[str, Any]) -> bool:
    try:
        _built(kind, table)
    except InputError:
        return False
    return True


def _built(kind: type[Drive], table: Mapping[str, Any]) -> Drive:
    return read_model(kind, dict(table))
