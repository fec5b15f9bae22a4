"""``electrovib import``."""

from __future__ import annotations

from typing import Any

import typer

from electrovib.apps.cli.force import Force
from electrovib.apps.cli.import_options import (
    Area,
    Averaged,
    Baselines,
    Becomes,
    Calibrations,
    ClockShift,
    Columns,
    Conductivity,
    Crop,
    DecimalComma,
    Delimiter,
    Detrended,
    Edges,
    LayerName,
    Listed,
    Offsets,
    Output,
    ParallelCapacitance,
    Part,
    ReaderName,
    Resample,
    Scales,
    SeriesResistance,
    Shifts,
    SourceFile,
    Stamps,
    Thickness,
    TimeColumn,
    TimeStep,
    Trigger,
    With,
)
from electrovib.apps.cli.terminal import say, warned


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("import")(command)


def command(
    file: SourceFile = "",
    output: Output = None,
    column: Columns = None,
    time: TimeColumn = "",
    step: TimeStep = None,
    stamps: Stamps = "refuse",
    scale: Scales = None,
    calibration: Calibrations = None,
    offset: Offsets = None,
    shift: Shifts = None,
    trigger: Trigger = "",
    baseline: Baselines = None,
    detrend: Detrended = None,
    crop: Crop = None,
    average: Averaged = "",
    resample: Resample = None,
    reader: ReaderName = "",
    delimiter: Delimiter = None,
    decimal_comma: DecimalComma = None,
    part: Part = None,
    beside: With = None,
    edges: Edges = "",
    clock_shift: ClockShift = None,
    kind: Becomes = "trace",
    area: Area = None,
    thickness: Thickness = None,
    series_resistance: SeriesResistance = "0 ohm",
    parallel_capacitance: ParallelCapacitance = "0 F",
    conductivity: Conductivity = "0 S/m",
    layer: LayerName = "stratum_corneum",
    listed: Listed = False,
    force: Force = False,
) -> None:
    """Import a file of an instrument as a Trace.

    Without --column and --output, list its columns.
    """
    if listed or not file:
        return _list_readers()
    _check_kind(kind)
    text: dict[str, Any] = {"reader": reader, "delimiter": delimiter, "decimal_comma": decimal_comma}
    text |= {} if part is None else {"part": part}
    if kind == "material":
        return _as_material(
            file, pairs("column", column), output, layer, force, area=area, thickness=thickness,
            series_resistance=series_resistance, parallel_capacitance=parallel_capacitance, conductivity=conductivity,
            **text,
        )  # fmt: skip
    if output is None and not column:
        return _list_columns(file, text)
    given: dict[str, Any] = {
        "scale": pairs("scale", scale), "offset": pairs("offset", offset), "shift": pairs("shift", shift),
        "trigger": trigger, "baseline": pairs("baseline", baseline), "detrend": detrend or [], "crop": crop, "average": average,
        "resample": resample, "calibration": pairs("calibration", calibration),
    }  # fmt: skip
    clocks = _clocks(beside, edges, clock_shift)
    return _as_trace(
        file, pairs("column", column), output, force, clocks, time=time, step=step, stamps=stamps,
        **text, **{name: value for name, value in given.items() if value},
    )  # fmt: skip


def _list_readers() -> None:
    from electrovib.data.registry import format_lines

    say(*format_lines())


def _list_columns(file: str, options: dict[str, Any]) -> None:
    from electrovib.recordings.importing import list_columns

    say(*list_columns(file, **options))


def _check_kind(kind: str) -> None:
    from electrovib.core.errors import InputError

    if kind not in ("trace", "material"):
        raise InputError(f"--as {kind}: expected trace or material")


def pairs(option: str, given: list[str] | None) -> dict[str, str]:
    """Split ``SIGNAL=TEXT`` at the first equals sign; each text needs one, and each signal is given once."""
    from electrovib.core.errors import InputError

    found: dict[str, str] = {}
    for text in given or []:
        name, sign, value = text.partition("=")
        if not sign or not name.strip() or not value.strip():
            raise InputError(f"--{option} {text}: expected SIGNAL=TEXT")
        if name.strip() in found:
            raise InputError(f"--{option} {text}: {name.strip()} is given twice")
        found[name.strip()] = value.strip()
    return found


def _clocks(beside: str | None, edges: str, shift: str | None) -> dict[str, str | None]:
    """Collect the options of a second record; they need the first one."""
    from electrovib.core.errors import InputError

    if beside is None and (edges or shift):
        raise InputError(
            f"{'--edges' if edges else '--clock-shift'}: belongs to --with TRACE, which is not given"
        )
    return {} if beside is None else {"path": beside, "edges": edges, "shift": shift}


def _as_trace(
    file: str,
    columns: dict[str, str],
    output: str | None,
    force: bool,
    clocks: dict[str, str | None],
    **options: Any,
) -> None:
    """Import a Trace, write it, and print its history and diagnostics."""
    from pathlib import Path

    from electrovib.data.traces.opened import open_trace
    from electrovib.export.save import check_output, save
    from electrovib.recordings.importing import import_file, merge_traces

    inputs = [Path(each) for each in (file, clocks.get("path")) if each]
    if output is not None:
        check_output(output, {"time": 2}, inputs=inputs, force=force)
    trace = import_file(file, columns, **options)
    if clocks:
        first = open_trace(str(clocks["path"]))
        trace = merge_traces(first, trace, edges=clocks["edges"] or "", shift=clocks["shift"])
    sizes = ", ".join(f"{size} values of {name}" for name, size in trace.sizes.items())
    say(f"{', '.join(map(str, trace.data_vars))}: {sizes}", *trace.attrs["history"].split("\n"))
    say(*warned(trace))
    if output is not None:
        say(*(f"written: {path}" for path in save(trace, output, force=force)))


def _as_material(
    file: str, columns: dict[str, str], output: str | None, layer: str, force: bool, **options: Any
) -> None:
    """Import a material, write it, and print its history and diagnostics."""
    from pathlib import Path

    from electrovib.core.errors import InputError
    from electrovib.data.atomic import check_writable, writing
    from electrovib.recordings.importing import import_material

    target = None if output is None else Path(output)
    if target is not None:
        if target.suffix.lower() != ".toml":
            raise InputError(f"a material is written as .toml, not as '{target.suffix}'", path=target)
        check_writable({target: None}, inputs=[Path(file)], force=force)
    found = import_material(file, columns=columns, **options)
    say(*found.history, *(f"{each.state}: {each.text}" for each in found.diagnostics))
    if target is not None:
        with writing({target: None}, force=force) as temporaries:
            temporaries[target].write_text(found.to_toml(layer), encoding="utf-8")
        say(f"written: {target}")
