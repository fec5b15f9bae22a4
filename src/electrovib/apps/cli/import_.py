"""``electrovib import``."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from electrovib.apps.cli import options
from electrovib.apps.cli.options import Text, Texts, many, output
from electrovib.apps.cli.recipe import OF_CLOCKS, OF_SAMPLE, OF_TRACE, READING, recipe_of, write_recipe
from electrovib.apps.cli.terminal import say, warned


def command(
    file: Annotated[
        str, typer.Argument(help="Any file that a reader takes; without one, list the readers.")
    ] = "",
    column: options.Column = None,
    changes: Annotated[
        Texts,
        many(
            "KEY=VALUE",
            "Entry of the recipe. Of the file: time='t [us]', step='10 us', part=SHEET, reader=NAME, delimiter=',',"
            " decimal_comma=true, stamps=keep_increasing. Of the signals: scale.SIGNAL='4/9 N/V', offset.SIGNAL='20 mV' and"
            " baseline.SIGNAL='0 s..2 s' to subtract, shift.SIGNAL='1 ms' to add to its stamps, calibration.SIGNAL=FILE with"
            " readings and known values, trigger=SIGNAL whose first rise is time 0, detrend=SIGNAL,..., average=SIGNAL over"
            " whose periods, crop='0.1 s..0.5 s', resample='100 us'. Of an earlier Trace onto whose clock and samples they are"
            " put: with=TRACE, edges=SIGNAL or A=B that both hold, clock_shift='2 ms'. Of a material: area='1 cm2',"
            " thickness='200 um', series_resistance, parallel_capacitance, conductivity",
            "--set",
        ),
    ] = None,
    recipe: options.Recipe = None,
    kind: Annotated[
        str,
        typer.Option(
            "--as", help="What the file becomes: trace, or material (of a spectrum, written as .toml)."
        ),
    ] = "trace",
    layer: options.Layer = "",
    written: Annotated[
        Text,
        output(
            "Write the Trace (.nc, .csv, .mat), the material (.toml), or the recipe by which the Trace is made (.toml)."
        ),
    ] = None,
    force: options.Force = False,
) -> None:
    """Import a file of an instrument as a Trace.

    Without --column and --output, list its columns.
    """
    from electrovib.core.errors import InputError

    if not file:
        return _list_readers()
    if kind not in ("trace", "material"):
        raise InputError(f"--as {kind}: expected trace or material")
    if kind == "material":
        entries = recipe_of(recipe, changes, column, only=(*OF_SAMPLE, "conductivity"), of="a material")
        return _as_material(file, written, layer or "stratum_corneum", force, **entries)
    entries = recipe_of(recipe, changes, column, only=(*OF_TRACE, *OF_CLOCKS), of="a Trace")
    if written is None and "columns" not in entries:
        return _list_columns(file, {name: entries[name] for name in READING if name in entries})
    clocks: dict[str, Any] = {name: entries.pop(name) for name in OF_CLOCKS if name in entries}
    if clocks and "with" not in clocks:
        raise InputError(f"{next(iter(clocks))}: belongs to with=TRACE, which is not given")
    if written is not None and written.lower().endswith(".toml"):
        inputs = [Path(each) for each in (file, recipe) if each]
        write_recipe(entries | clocks, Path(written), inputs, force=force)
        return say(f"written: {written}")
    return _as_trace(file, entries.pop("columns", {}), written, force, clocks, **entries)


def _list_readers() -> None:
    from electrovib.data.registry import format_lines

    say(*format_lines())


def _list_columns(file: str, options: dict[str, Any]) -> None:
    from electrovib.recordings.importing import list_columns

    say(*list_columns(file, **options))


def _as_trace(
    file: str,
    columns: dict[str, str],
    output: str | None,
    force: bool,
    clocks: Mapping[str, str],
    **options: Any,
) -> None:
    """Import a Trace, write it, and print its history and diagnostics."""
    from electrovib.data.traces import open_trace
    from electrovib.exports.save import check_output, save
    from electrovib.recordings.importing import import_file, merge_traces

    inputs = [Path(each) for each in (file, clocks.get("with")) if each]
    if output is not None:
        check_output(output, {"time": 2}, inputs=inputs, force=force)
    trace = import_file(file, columns, **options)
    if clocks:
        first = open_trace(clocks["with"])
        trace = merge_traces(first, trace, edges=clocks.get("edges", ""), shift=clocks.get("clock_shift"))
    sizes = ", ".join(f"{size} values of {name}" for name, size in trace.sizes.items())
    say(f"{', '.join(map(str, trace.data_vars))}: {sizes}", *trace.attrs["history"].split("\n"))
    say(*warned(trace))
    if output is not None:
        say(*(f"written: {path}" for path in save(trace, output, force=force)))


def _as_material(file: str, output: str | None, layer: str, force: bool, **options: Any) -> None:
    """Import a material, write it, and print its history and diagnostics."""
    from electrovib.core.errors import InputError
    from electrovib.data.atomic import check_writable, writing
    from electrovib.recordings.importing import import_material

    target = None if output is None else Path(output)
    if target is not None:
        if target.suffix.lower() != ".toml":
            raise InputError(f"a material is written as .toml, not as '{target.suffix}'", path=target)
        check_writable({target: None}, inputs=[Path(file)], force=force)
    found = import_material(file, **options)
    say(*found.history, *(f"{each.state}: {each.text}" for each in found.diagnostics))
    if target is not None:
        with writing({target: None}, force=force) as temporaries:
            temporaries[target].write_text(found.to_toml(layer), encoding="utf-8")
        say(f"written: {target}")
