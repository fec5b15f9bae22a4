"""``electrovib import``."""

import functools
import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Final

import typer

from electrovib.apps.cli import options
from electrovib.apps.cli.terminal import say, warned
from electrovib.core.deprecation import former_value
from electrovib.core.errors import InputError

READING: Final = ("columns", "reader", "delimiter", "decimal_comma", "part")
_OF_SIGNALS: Final = ("columns", "scale", "offset", "shift", "baseline", "calibration")
OF_TRACE: Final = (
    *READING, "time", "step", "stamps", "scale", "offset", "shift", "trigger", "baseline", "detrend", "crop", "average",
    "resample", "calibration",
)  # fmt: skip
OF_SAMPLE: Final = (*READING, "area", "thickness", "series_resistance", "parallel_capacitance")
OF_CLOCKS: Final = ("with", "edges", "clock_shift")
_TEXTS: Final = (
    "time", "stamps", "reader", "delimiter", "part", "trigger", "average", "with", "edges", "columns", "calibration",
)  # fmt: skip
_NUMBERS: Final = (
    "step", "resample", "scale", "offset", "shift", "area", "thickness", "series_resistance", "parallel_capacitance",
    "conductivity", "clock_shift",
)  # fmt: skip
_EXPECTED: Final[dict[str, tuple[tuple[type, ...], str]]] = {
    **dict.fromkeys(_TEXTS, ((str,), "a text in quotes")),
    **dict.fromkeys(_NUMBERS, ((str, int, float), "a number in SI, or a text with a unit such as '10 us'")),
    **dict.fromkeys(("crop", "baseline"), ((str, list), "a span of time, such as '0.1 s..0.5 s'")),
    "detrend": ((str,), "the name of a signal, or a list of names"),
}
"""What an entry, each entry of a table, and each signal to detrend is."""
_KEYS: Final = tuple(dict.fromkeys([*OF_TRACE, *OF_SAMPLE, "conductivity", *OF_CLOCKS]))
"""Keys, named as the parameters of `electrovib.import_file`, `import_material` and `merge_traces`."""


def import_(
    *,
    file: Annotated[str | None, typer.Argument()] = None,
    columns: options.Columns = None,
    set: options.Changes = None,
    recipe: options.Text = None,
    kind: Annotated[str, typer.Option("--as")] = "trace",
    into: options.FileOptions,
) -> None:
    """Import a file of an instrument as a Trace.

    Without --column and --output, list its columns.

    Parameters
    ----------
    file
        Any file that a reader takes; without one, list the readers.
    set : KEY=VALUE
        Entry of the recipe. Of the file: time='t [us]', step='10 us', part=SHEET, reader=NAME, delimiter=',', decimal_comma=true,
        stamps=keep_increasing. Of the signals: scale.SIGNAL='4/9 N/V', offset.SIGNAL='20 mV' and baseline.SIGNAL='0 s..2 s' to
        subtract, shift.SIGNAL='1 ms' to add to its stamps, calibration.SIGNAL=FILE with readings and known values, trigger=SIGNAL
        whose first rise is time 0, detrend=SIGNAL,..., average=SIGNAL over whose periods, crop='0.1 s..0.5 s', resample='100 us'.
        Of an earlier Trace onto whose clock and samples they are put: with=TRACE, edges=SIGNAL or A=B that both hold,
        clock_shift='2 ms'. Of a material: area='1 cm2', thickness='200 um', series_resistance, parallel_capacitance,
        conductivity. Of a measurement, whose columns are value, at and spread: title, source, group, scenario, changes.PATH,
        quantity, over=PATH of what was varied, spread='10 %', spread_of=repeats, unknown.PATH='{ model = ... }' of what is not
        known, and the other entries of its file; repeatable.
    kind : trace|material|measurement
        What the file becomes: trace; material (of a spectrum, written as .toml); or measurement (of points, written as .toml), by
        which 'electrovib evidence' judges laws.
    output : FILE
        Write the Trace (.nc, .csv, .mat), the material or measurement (.toml), or the recipe by which the Trace is made (.toml).
    """
    from electrovib.data.registry import format_lines
    from electrovib.recordings.importing.import_file import list_account, list_columns

    if not file:
        return say(*format_lines())
    if kind not in ("trace", "material", "measurement"):
        raise InputError(f"--as {kind}: expected trace, material or measurement")
    read = functools.partial(recipe_of, recipe, set, columns)
    if kind != "trace":
        return _into_toml(kind, file, into, read)
    entries = read(only=(*OF_TRACE, *OF_CLOCKS), of="a Trace")
    if into.output is None and "columns" not in entries:
        return say(*list_columns(file, **{name: entries[name] for name in READING if name in entries}))
    clocks = [name for name in OF_CLOCKS if name in entries]
    if clocks and "with" not in clocks:
        raise InputError(f"{clocks[0]}: belongs to with=TRACE, which is not given")
    if into.output is not None and into.output.lower().endswith(".toml"):
        inputs = [Path(each) for each in (file, recipe) if each]
        reading = {name: entries[name] for name in READING[1:] if name in entries}
        account = list_account(file, **reading)
        write_recipe(entries, Path(into.output), inputs, account, force=into.force)
        return say(f"written: {into.output}")
    return _as_trace(file, into, entries)


def _as_trace(file: str, into: options.FileOptions, entries: dict[str, Any]) -> None:
    """Import a Trace, write it, and print its history and diagnostics."""
    from electrovib.data.traces import open_trace
    from electrovib.exports.save import check_output, save
    from electrovib.recordings.importing.import_file import import_file
    from electrovib.recordings.importing.merging import merge_traces

    earlier, edges, shift = (entries.pop(name, None) for name in OF_CLOCKS)
    if into.output is not None:
        inputs = [Path(each) for each in (file, earlier) if each]
        check_output(into.output, {"time": 2}, inputs=inputs, force=into.force)
    trace = import_file(file, entries.pop("columns", {}), **entries)
    if earlier:
        trace = merge_traces(open_trace(earlier), trace, edges=edges or "", shift=shift)
    sizes = ", ".join(f"{size} values of {name}" for name, size in trace.sizes.items())
    say(f"{', '.join(map(str, trace.data_vars))}: {sizes}", *trace.attrs["history"].split("\n"))
    say(*warned(trace))
    if into.output is not None:
        say(*(f"written: {path}" for path in save(trace, into.output, force=into.force)))


def _into_toml(kind: str, file: str, into: options.FileOptions, read: Callable[..., dict[str, Any]]) -> None:
    """Import a material or a measurement, print what is known of it, and write it."""
    from electrovib.data.atomic import Form, check_writable, write_text
    from electrovib.recordings.importing.own_material import SpectrumRecipe, import_material
    from electrovib.studies.evidence.entries import ENTRIES, TABLES
    from electrovib.studies.evidence.files import import_measurement

    form = Form.MEASUREMENT if kind == "measurement" else None
    targets = {Path(into.output): form} if into.output else {}
    for target in targets:
        if target.suffix.lower() != ".toml":
            raise InputError(f"a {kind} is written as .toml, not as '{target.suffix}'", path=target)
    check_writable(targets, inputs=[Path(file)], force=into.force)
    if kind == "material":
        entries = read(only=(*OF_SAMPLE, "conductivity"), of="a material")
        conductivity = entries.pop("conductivity", 0.0)
        material = import_material(file, SpectrumRecipe(**entries), conductivity=conductivity)
        lines = [*material.history, *(f"{each.state}: {each.text}" for each in material.diagnostics)]
        text = material.to_toml(former_value("layer", "stratum_corneum"))
    else:
        only, tables = (*READING, *ENTRIES), ("columns", *TABLES)
        entries = read(only=only, of="a measurement", tables=tables)
        folder = next((target.parent for target in targets), Path())
        points = import_measurement(file, entries.pop("columns", {}), folder=folder, **entries)
        lines, text = points.lines, points.to_toml()
    say(*lines)
    for target in targets:
        write_text(target, text, form, force=into.force)
        say(f"written: {target}")


def recipe_of(
    recipe: str | None,
    changes: Sequence[str] | None,
    columns: Sequence[str] | None,
    *,
    only: tuple[str, ...],
    of: str,
    tables: tuple[str, ...] = _OF_SIGNALS,
) -> dict[str, Any]:
    """Read a recipe, then what ``--set`` and ``--column`` add to it.

    `only` are the keys of what is made, which `of` names; those of `tables` have an entry for each signal or path.
    """
    from electrovib.core.parsing import read_toml_file, truth

    found: dict[str, Any] = {}
    if recipe:
        advice = "'electrovib import FILE --column SIGNAL=COLUMN -o lab.toml' writes one"
        found = read_toml_file(Path(recipe), kind="a recipe", advice=advice)
    for path, value in options.changes(changes).items():
        key, dot, signal = path.partition(".")
        value = truth(value, key) if key == "decimal_comma" else value  # noqa: PLW2901
        held = found.get(key)
        found[key] = {**(held if isinstance(held, dict) else {}), signal: value} if dot else value
    if columns:
        found["columns"] = {**found.get("columns", {}), **_columns(columns)}
    if problems := [why for key, value in found.items() if (why := _wrong(key, value, only, of, tables))]:
        raise InputError(problems)
    if isinstance(found.get("detrend"), str):
        found["detrend"] = options.names_of([found["detrend"]])
    return found


def _wrong(key: str, value: object, only: tuple[str, ...], of: str, tables: tuple[str, ...]) -> str:
    """Say what is wrong with an entry of a recipe; empty if nothing is."""
    from electrovib.core.errors import nearest
    from electrovib.core.mistakes import shown

    known = only if of == "a measurement" else _KEYS
    if key not in known:
        return f"{key}: no entry of a recipe.{nearest(key, known)}"
    if key not in only:
        return f"{key}: does not belong to {of}; omit it"
    if (key in tables) != isinstance(value, dict):
        each = ".SIGNAL" if tables is _OF_SIGNALS else ".PATH"
        return f"{key}: expected {key}{each if key in tables else ''}=VALUE"
    kinds, words = _EXPECTED.get(key, ((object,), ""))
    entries = (
        {f"{key}.{name}": each for name, each in value.items()} if isinstance(value, dict) else {key: value}
    )
    for name, held in entries.items():
        for one in held if key == "detrend" and isinstance(held, list) else [held]:
            if not isinstance(one, kinds) or (isinstance(one, bool) and int in kinds):
                return f"{name} = {shown(one)}: expected {words}"
    return ""


def _columns(given: Sequence[str]) -> dict[str, str]:
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


def write_recipe(
    entries: Mapping[str, Any], target: Path, inputs: list[Path], account: list[str], *, force: bool
) -> None:
    """Write a recipe as TOML, with the account of the file that it was made for as comments."""
    from electrovib.data.atomic import check_writable, write_text

    check_writable({target: None}, inputs=inputs, force=force)
    lines = ["# " + "".join(sign if sign.isprintable() else " " for sign in line) for line in account]
    lines += [f"{key} = {_toml(value)}" for key, value in entries.items() if not isinstance(value, dict)]
    for key, value in entries.items():
        if isinstance(value, dict):
            lines += ["", f"[{key}]", *(f"{name} = {_toml(text)}" for name, text in value.items())]
    write_text(target, "\n".join(lines) + "\n", None, force=force)


def _toml(value: object) -> str:
    """Write texts, numbers, truths and lists of them, which are the same in JSON and TOML."""
    return json.dumps(value, ensure_ascii=False)
