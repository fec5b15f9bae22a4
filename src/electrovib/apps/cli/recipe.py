"""The recipe by which a file of an instrument is read: options, or a TOML file that another import reads."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from electrovib.apps.cli.options import Arguments, names_of
from electrovib.core.errors import InputError

READING: Final = ("columns", "reader", "delimiter", "decimal_comma", "part")
_OF_SIGNALS: Final = ("columns", "scale", "offset", "shift", "baseline", "calibration")
OF_TRACE: Final = (
    *READING, "time", "step", "stamps", "scale", "offset", "shift", "trigger", "baseline", "detrend", "crop", "average",
    "resample", "calibration",
)  # fmt: skip
OF_SAMPLE: Final = (*READING, "area", "thickness", "series_resistance", "parallel_capacitance")
OF_CLOCKS: Final = ("with", "edges", "clock_shift")
_KEYS: Final = tuple(dict.fromkeys([*OF_TRACE, *OF_SAMPLE, "conductivity", *OF_CLOCKS]))
"""Keys, named as the parameters of `electrovib.import_file`, `import_material` and `merge_traces`."""


def recipe_of(given: Arguments, *, only: tuple[str, ...], of: str) -> dict[str, Any]:
    """Read a recipe, then what ``--set`` and ``--column`` add to it; `only` are the keys of what is made, named by `of`."""
    from electrovib.apps.changes import read_changes
    from electrovib.data.toml_file import read_toml_file

    found: dict[str, Any] = {}
    if "recipe" in given:
        advice = "'electrovib import FILE --column SIGNAL=COLUMN -o lab.toml' writes one"
        found = read_toml_file(Path(given["recipe"]), kind="a recipe", advice=advice)
    for path, value in read_changes(given.get("set", ())).items():
        key, dot, signal = path.partition(".")
        if dot:
            held = found.get(key)
            found[key] = {**(held if isinstance(held, dict) else {}), signal: value}
        else:
            found[key] = {"true": True, "false": False}.get(value, value) if isinstance(value, str) else value
    if "columns" in given:
        found["columns"] = {**found.get("columns", {}), **_columns(given["columns"])}
    if problems := [why for key, value in found.items() if (why := _wrong(key, value, only, of))]:
        raise InputError(problems)
    if isinstance(found.get("detrend"), str):
        found["detrend"] = names_of([found["detrend"]])
    return found


def _wrong(key: str, value: object, only: tuple[str, ...], of: str) -> str:
    """Say what is wrong with an entry of a recipe; empty if nothing is."""
    from electrovib.core.errors import nearest

    if key not in _KEYS:
        return f"{key}: no entry of a recipe.{nearest(key, _KEYS)}"
    if key not in only:
        return f"{key}: does not belong to {of}; omit it"
    if (key in _OF_SIGNALS) != isinstance(value, dict):
        return f"{key}: expected {key}.SIGNAL=VALUE" if key in _OF_SIGNALS else f"{key}: expected {key}=VALUE"
    return ""


def _columns(given: list[str]) -> dict[str, str]:
    """Split ``SIGNAL=COLUMN`` at the first equals sign; each needs a column, and each signal is given once."""
    found: dict[str, str] = {}
    for text in given:
        signal, sign, column = (part.strip() for part in text.partition("="))
        if not (sign and signal and column):
            raise InputError(f"--column {text}: expected SIGNAL=COLUMN")
        if signal in found:
            raise InputError(f"--column {text}: {signal} is given twice")
        found[signal] = column
    return found


def write_recipe(entries: Mapping[str, Any], target: Path, inputs: list[Path], *, force: bool) -> None:
    """Write a recipe as TOML."""
    from electrovib.data.atomic import check_writable, writing

    check_writable({target: None}, inputs=inputs, force=force)
    lines = [f"{key} = {_toml(value)}" for key, value in entries.items() if not isinstance(value, dict)]
    for key, value in entries.items():
        if isinstance(value, dict):
            lines += ["", f"[{key}]", *(f"{name} = {_toml(text)}" for name, text in value.items())]
    with writing({target: None}, force=force) as temporaries:
        temporaries[target].write_text("\n".join(lines) + "\n", encoding="utf-8")


def _toml(value: object) -> str:
    return json.dumps(
        value, ensure_ascii=False
    )  # texts, numbers, truths and lists of them are the same in TOML
