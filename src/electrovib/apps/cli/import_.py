"""``electrovib import``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from electrovib.apps.cli.options import Arguments, takes
from electrovib.apps.cli.recipe import OF_CLOCKS, OF_SAMPLE, OF_TRACE, READING, recipe_of, write_recipe
from electrovib.apps.cli.terminal import say, warned
from electrovib.core.errors import InputError


@takes("""
[file]              Any file that a reader takes; without one, list the readers.
--column
--set KEY=VALUE     Entry of the recipe. Of the file: time='t [us]', step='10 us', part=SHEET, reader=NAME, delimiter=',',
    decimal_comma=true, stamps=keep_increasing. Of the signals: scale.SIGNAL='4/9 N/V', offset.SIGNAL='20 mV' and
    baseline.SIGNAL='0 s..2 s' to subtract, shift.SIGNAL='1 ms' to add to its stamps, calibration.SIGNAL=FILE with readings
    and known values, trigger=SIGNAL whose first rise is time 0, detrend=SIGNAL,..., average=SIGNAL over whose periods,
    crop='0.1 s..0.5 s', resample='100 us'. Of an earlier Trace onto whose clock and samples they are put: with=TRACE,
    edges=SIGNAL or A=B that both hold, clock_shift='2 ms'. Of a material: area='1 cm2', thickness='200 um',
    series_resistance, parallel_capacitance, conductivity; repeatable.
--recipe
--as trace|material -> kind  What the file becomes: trace, or material (of a spectrum, written as .toml). [default: trace]
--layer
-o, --output FILE   Write the Trace (.nc, .csv, .mat), the material (.toml), or the recipe by which the Trace is made (.toml).
--force
""")
def command(given: Arguments) -> None:
    """Import a file of an instrument as a Trace.

    Without --column and --output, list its columns.
    """
    from electrovib.data.registry import format_lines
    from electrovib.recordings.importing import list_columns

    file, output, force = given.get("file"), given.get("output"), "force" in given
    if not file:
        return say(*format_lines())
    if given["kind"] not in ("trace", "material"):
        raise InputError(f"--as {given['kind']}: expected trace or material")
    if given["kind"] == "material":
        entries = recipe_of(given, only=(*OF_SAMPLE, "conductivity"), of="a material")
        return _as_material(file, output, given.get("layer", ""), entries, force=force)
    entries = recipe_of(given, only=(*OF_TRACE, *OF_CLOCKS), of="a Trace")
    if output is None and "columns" not in entries:
        return say(*list_columns(file, **{name: entries[name] for name in READING if name in entries}))
    clocks = [name for name in OF_CLOCKS if name in entries]
    if clocks and "with" not in clocks:
        raise InputError(f"{clocks[0]}: belongs to with=TRACE, which is not given")
    if output is not None and output.lower().endswith(".toml"):
        inputs = [Path(each) for each in (file, given.get("recipe")) if each]
        write_recipe(entries, Path(output), inputs, force=force)
        return say(f"written: {output}")
    return _as_trace(file, output, entries, force=force)


def _as_trace(file: str, output: str | None, entries: dict[str, Any], *, force: bool) -> None:
    """Import a Trace, write it, and print its history and diagnostics."""
    from electrovib.data.traces.opened import open_trace
    from electrovib.exports.save import check_output, save
    from electrovib.recordings.importing import import_file, merge_traces

    earlier, edges, shift = (entries.pop(name, None) for name in OF_CLOCKS)
    if output is not None:
        inputs = [Path(each) for each in (file, earlier) if each]
        check_output(output, {"time": 2}, inputs=inputs, force=force)
    trace = import_file(file, entries.pop("columns", {}), **entries)
    if earlier:
        trace = merge_traces(open_trace(earlier), trace, edges=edges or "", shift=shift)
    sizes = ", ".join(f"{size} values of {name}" for name, size in trace.sizes.items())
    say(f"{', '.join(map(str, trace.data_vars))}: {sizes}", *trace.attrs["history"].split("\n"))
    say(*warned(trace))
    if output is not None:
        say(*(f"written: {path}" for path in save(trace, output, force=force)))


def _as_material(file: str, output: str | None, layer: str, entries: dict[str, Any], *, force: bool) -> None:
    """Import a material, write it, and print its history and diagnostics."""
    from electrovib.data.atomic import check_writable, writing
    from electrovib.recordings.importing import import_material

    target = None if output is None else Path(output)
    if target is not None:
        if target.suffix.lower() != ".toml":
            raise InputError(f"a material is written as .toml, not as '{target.suffix}'", path=target)
        check_writable({target: None}, inputs=[Path(file)], force=force)
    found = import_material(file, **entries)
    say(*found.history, *(f"{each.state}: {each.text}" for each in found.diagnostics))
    if target is not None:
        with writing({target: None}, force=force) as temporaries:
            temporaries[target].write_text(found.to_toml(layer or "stratum_corneum"), encoding="utf-8")
        say(f"written: {target}")
