"""Write a Trace, a study or any answer as its numbers, a page, a figure or a table of one column a signal, by the suffix."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from electrovib.core.answer import Answer
from electrovib.core.deprecation import former_values, present_names
from electrovib.core.diagnostics import Diagnostic, diagnostics_of, warning_lines
from electrovib.core.errors import InputError, suggestion
from electrovib.core.files import inputs_noted
from electrovib.core.signals import is_study_result, is_trace
from electrovib.data.atomic import Form, check_writable, csv_head, output_path, write_text, writing
from electrovib.data.traces import nc_content, prepared, save_mat, save_nc
from electrovib.exports.spice.netlist import netlist
from electrovib.exports.waveform import check_waveform_file, export_waveform, write_waveform
from electrovib.exports.waveform_formats import WAVEFORM_FORMATS
from electrovib.physics.limits import broken
from electrovib.scenario import Source, read_scenario
from electrovib.solve.effort import refuse_large
from electrovib.solve.simulate import simulate
from electrovib.studies.design.drive.function import DesignedDrive
from electrovib.studies.design.result import Designed
from electrovib.studies.texture.drive import TextureDrive
from electrovib.view.files import check_document, save_answer, written

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    import xarray
    from numpy.typing import NDArray

_TABLES: Final = ("time", "frequency")
"""Dimensions over which a table may run; of a Trace with both it is the first."""


def save_csv(trace: xarray.Dataset, path: Path, *, force: bool = False) -> list[Path]:
    """Write a Trace as a table over time, or over frequency if it has no time; of a sweep, a row for each case.

    A layer has a column, a complex number two; a heading has the unit, and a number all its digits. Comments in
    the first lines, which begin with ``#``, state the diagnostics, and what is not in the table.
    """
    import pandas as pd

    stored = prepared(trace, path)
    rows = rows_of_table(stored.sizes, path)
    others = [name for name in _TABLES if name in stored.sizes and name not in rows]
    kept = stored.drop_dims(others)
    left = ", ".join(str(name) for name in stored.variables if name not in kept.variables)
    table = pd.DataFrame(dict(_columns(kept, {name: stored.sizes[name] for name in rows})))
    remarks = [stored.attrs.get("title", ""), left and f"not in this table, but in .nc and .mat: {left}"]
    with (
        writing({path: Form.TABLE}, force=force) as temporaries,
        temporaries[path].open("w", encoding="utf-8", newline="") as out,
    ):
        out.write(csv_head(remarks, diagnostics_of(stored)))
        table.to_csv(out, index=False, lineterminator="\n")
    return [path]


def rows_of_table(sizes: Mapping[Any, int], path: Path) -> list[str]:
    """Return the dimensions of a Trace of these sizes over which its table has rows; refuse records of a sweep."""
    tables = [name for name in _TABLES if name in sizes]
    sweeps = [str(name) for name in sizes if name not in (*_TABLES, "layer")]
    if not tables and not {"layer", "sample"} & set(sizes):
        return sweeps
    if sweeps or not tables:
        also = f"also runs over {', '.join(sweeps)}" if sweeps else "has neither time nor frequency"
        raise InputError(
            f"a CSV file holds one dimension, but this Trace {also}; save as .nc or .mat.", path=path
        )
    return tables[:1]


def _columns(trace: xarray.Dataset, rows: Mapping[str, int]) -> Iterator[tuple[str, NDArray[Any]]]:
    """Iterate over headings and columns, those of the rows first: ``field[gap] [V/m]``, ``impedance.real [ohm]``."""
    layers = (
        trace["layer"].to_numpy().tolist() if "layer" in trace.coords else range(trace.sizes.get("layer", 0))
    )
    for name in dict.fromkeys((*rows, *trace.coords, *trace.data_vars)):
        if name not in trace.variables or name == "layer":
            continue
        variable = trace[name].variable
        has_layers = "layer" in variable.dims
        whole = variable.set_dims(dict(rows) | ({"layer": len(layers)} if has_layers else {})).to_numpy()
        columns = whole.reshape(math.prod(rows.values()), len(layers) if has_layers else 1).T
        unit = f" [{variable.attrs['units']}]" if "units" in variable.attrs else ""
        for label, column in zip(
            [f"[{each}]" for each in layers] if has_layers else [""], columns, strict=True
        ):
            parts = {".real": column.real, ".imag": column.imag} if column.dtype.kind == "c" else {"": column}
            yield from ((f"{name}{label}{part}{unit}", values) for part, values in parts.items())


FORMATS: Final[dict[str, Callable[..., list[Path]]]] = {".nc": save_nc, ".csv": save_csv, ".mat": save_mat}
"""Suffix to writer of a Trace."""
_FORMS: Final = {".nc": Form.NETCDF, ".csv": Form.TABLE, ".mat": Form.MATLAB}
_IN_FOLDER: Final = {"trace.nc": Form.NETCDF}


def save(
    trace: xarray.Dataset | Answer, path: str | Path, *, style: str = "", force: bool = False
) -> list[Path]:
    """Write a Trace or any other result as numbers, a page, a figure or tables.

    Parameters
    ----------
    trace : xarray.Dataset or Answer
        Any Trace; the units of its signals are written anew. Or any other result that has a `document`.
    path : str or Path
        The output: of a Trace ``.nc`` (netCDF) or ``.mat`` (MATLAB), which hold everything, or ``.csv``, a table of plain
        values over time (over frequency if it has no time; of a sweep a row for each case), which is not opened as a Trace
        again. Of another result the suffix of one of its files such as ``.csv``. Of each ``.html``, its first figure as
        ``.pdf``, ``.svg`` or ``.png``, its tables as ``.tex``; without a suffix a folder with the page, all figures and files.
    style : str, optional
        Of a figure: ``"journal"`` for 85 mm in width and text of 8 pt; by default that of a page.
    force : bool
        Whether a file that was not written by electrovib may be replaced.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    InputError
        If the suffix is unknown, the file cannot be written or would replace one that electrovib did not write in this
        form, or the format cannot hold this Trace.

    Examples
    --------
    >>> [path.name for path in ev.save(ev.check("bau_2010/sine"), "check.json")]
    ['check.json']
    """
    from electrovib.view.files import in_style, save_answer, save_document

    path = output_path(path)
    with in_style(style, [path]):
        if is_study_result(trace) and not isinstance(trace, Answer):
            from electrovib.studies.population.answer import StudyResult

            trace = StudyResult.of(trace)
        if isinstance(trace, Answer):
            return save_answer(trace, path, force=force)
        if not is_trace(trace):
            kind = type(trace).__name__
            why = f"only a Trace or a result with a document is saved, not a {kind}; a scenario is written by its to_toml()"
            raise InputError(why, path=path)
        if not _is_document(path):
            return _writer(path)(trace, path, force=force)
        from electrovib.view.report import document_of

        document = document_of({path.stem: trace})
        return save_document(document, path, _IN_FOLDER, lambda _: nc_content(trace, path), force=force)


def check_output(
    path: str | Path,
    sizes: Mapping[str, int],
    *,
    inputs: Iterable[Path] = (),
    force: bool = False,
    shown: bool = True,
) -> None:
    """Check before a long computation that `save` can write a Trace; only the names of `sizes` count.

    Pages, figures and tables, in which a Trace is `shown`, can be refused.
    """
    path = output_path(path)
    if shown and _is_document(path):
        from electrovib.view.files import check_document

        return check_document(path, _IN_FOLDER, inputs=inputs, force=force)
    _writer(path, shown=shown)
    suffix = path.suffix.lower()
    if suffix == ".csv":
        rows_of_table(sizes, path)
    check_writable({path: _FORMS[suffix]}, inputs=inputs, force=force)
    return None


def _is_document(path: Path) -> bool:
    from electrovib.view.files import SUFFIXES, is_file

    return path.suffix.lower() in SUFFIXES or not is_file(path)


def _writer(path: Path, *, shown: bool = True) -> Callable[..., list[Path]]:
    from electrovib.view.files import SUFFIXES

    writer = FORMATS.get(path.suffix.lower())
    if writer is None:
        near = suggestion(path.suffix.lower(), FORMATS) if path.suffix else ""
        why = f"a Trace is saved as {', '.join([*FORMATS, *(SUFFIXES if shown else ())])}, not as '{path.suffix}'.{near}"
        raise InputError(why, path=path)
    return writer


WRITERS: Final[dict[str, Callable[..., str]]] = {".cir": netlist}
"""Suffix to writer, which takes the scenario and the `name` of the file."""


def export(
    scenario: Source,
    path: str | Path,
    *,
    set: Mapping[str, Any] | None = None,  # noqa: A002 - the name of the option
    force: bool = False,
    **options: Any,
) -> Path:
    """Write a scenario as a netlist for a circuit simulator, or its drive as a waveform.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        As for `electrovib.load`.
    path : str or Path
        The output: ``.cir``, a netlist that ``ngspice -b`` runs as it is, or a waveform: ``.csv``, ``.npy``, ``.mat``,
        ``.wav`` or ``.pwl``.
    set : mapping of str to value, optional
        Dotted path to value: ``{"drive.high": "150 V"}``.
    force : bool
        Whether a file that was not written by electrovib may be replaced.
    **options
        Of a waveform, as for `electrovib.export_waveform`: ``limits``, ``rate``, ``edge`` and others.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If the suffix is unknown, the file cannot be written or would replace an input or a file not written by
        electrovib, a part of the scenario has no exact form in a netlist, `simulate` refuses the scenario, or a result
        exceeds one of its declared `limits`.
    NotCausalError
        If the force law has no time-domain form.

    Examples
    --------
    >>> ev.export("vezzoli_2014/fig6", "fig6.cir").read_text().splitlines()[0]
    '* Vezzoli 2014, figure 6: 0 to 1000 V trapezoidal pulse on a plastic film'
    """
    place = output_path(path)
    if options or place.suffix.lower() in WAVEFORM_FORMATS:
        present, gone = present_names("export_waveform", options)
        with former_values(**gone):
            return export_waveform(scenario, place, set=set, force=force, **present).path
    return export_netlist(scenario, place, changes=set, force=force).path


@dataclass(frozen=True, kw_only=True)
class WrittenNetlist:
    """A netlist that was written, with the diagnostics of its scenario, which the file states too."""

    path: Path
    diagnostics: tuple[Diagnostic, ...]


def export_netlist(
    scenario: Source, place: Path, *, changes: Mapping[str, Any] | None = None, force: bool = False
) -> WrittenNetlist:
    """Write a scenario as a netlist, as `export` does."""
    writer = WRITERS.get(place.suffix.lower())
    if writer is None:
        allowed = ", ".join(WRITERS)
        waves = ", ".join(WAVEFORM_FORMATS)
        why = f"a scenario is exported as {allowed}, and its drive as {waves}, not as '{place.suffix}'."
        raise InputError(why, path=place)
    with inputs_noted() as inputs:
        found = read_scenario(scenario, changes=changes)
    check_writable({place: Form.NETLIST}, inputs=inputs, force=force)
    refuse_large(found)
    text = writer(found, name=place.stem)
    diagnostics = tuple(diagnostics_of(simulate(found)))
    if problems := [f"{each.text}. Nothing was written" for each in broken(diagnostics)]:
        raise InputError(problems)
    stated = "".join(f"* {line}\n" for line in warning_lines(diagnostics))
    head, newline, rest = text.partition("\n")
    write_text(place, f"{head}{newline}{stated}{rest}", Form.NETLIST, force=force)
    return WrittenNetlist(path=place, diagnostics=diagnostics)


def check_design_file(
    kind: type[Designed],
    path: str | Path,
    *,
    edge: float | str | None = None,
    inputs: Iterable[Path] = (),
    force: bool = False,
) -> None:
    """Check before a computation that its result can be written."""
    place = output_path(path)
    if place.suffix.lower() in WAVEFORM_FORMATS:
        check_waveform_file(place, edge=edge, inputs=inputs, force=force)
    else:
        waveforms = {f"drive{suffix}": None for suffix in WAVEFORM_FORMATS if place.suffix}
        check_document(place, {**kind.FILES, **waveforms}, inputs=inputs, force=force)


def write_design(
    found: Designed, path: str | Path, *, edge: float | str | None = None, force: bool = False
) -> list[str]:
    """Write the drive of a design as a waveform, or the design as any other answer."""
    place = output_path(path)
    check_design_file(type(found), place, edge=edge, force=force)
    suffix = place.suffix.lower()
    if suffix not in {".toml", *WAVEFORM_FORMATS}:
        save_answer(found, place, force=force)
        return [written(place, lambda: found.document, found.files)]
    if found.scenario is None:
        raise InputError(
            "there is no result within the limits that could be written; nothing was written. All numbers are written as .json",
            path=place,
        )
    if suffix == ".toml":
        return [f"written: {path}" for path in save_answer(found, place, force=force)]
    rate, notes = (found.rate, found.notes) if isinstance(found, DesignedDrive | TextureDrive) else (None, ())
    waveform = write_waveform(
        found.scenario, place, limits=list(found.limits), force=force, rate=rate, remarks=notes, edge=edge,
    )  # fmt: skip
    return [*(each for each in waveform.document.sentences if each not in notes), f"written: {waveform.path}"]
