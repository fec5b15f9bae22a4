"""Lossless storage of a Trace as CSV, one file per dimension; of a sweep, one row per case."""

from __future__ import annotations

import csv
import hashlib
import itertools
import json
import math
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Final, TextIO

import numpy as np

from electrovib.core.errors import DataFileError, InputError, refuse
from electrovib.core.files import note_input
from electrovib.core.signals import FORMAT, stamp
from electrovib.core.units import unit_in_files, unit_of_files
from electrovib.data.atomic import left_by_a_kill, writing
from electrovib.data.faults import DAMAGE, check_file, damaged
from electrovib.data.marks import WRITTEN_BY, Form, unsigned
from electrovib.data.verified import verified

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Mapping
    from pathlib import Path

    import xarray
    from numpy.typing import NDArray

    from electrovib.data.text.table import TextTable


def not_a_trace(path: Path) -> DataFileError:
    """Return the error for a file that holds no Trace."""
    return DataFileError(
        f"is not a Trace ('{FORMAT}'); 'electrovib import' makes one of a file of an instrument.", path=path
    )


def prepared(trace: xarray.Dataset, path: Path) -> xarray.Dataset:
    """Return a copy with its units set, after checking that attributes are texts or numbers."""
    stamped = stamp(trace)
    stamped.attrs = {"format": FORMAT, **trace.attrs}
    problems = []
    carriers: dict[str, Any] = {f"{name}.": variable for name, variable in stamped.variables.items()}
    for owner, carrier in {"": stamped, **carriers}.items():
        carrier.attrs = {str(name): _plain(value) for name, value in carrier.attrs.items()}
        if owner and isinstance(unit := carrier.attrs.get("units"), str):
            carrier.attrs["units"] = unit_in_files(unit)
        problems += [
            f"{path}: attribute '{owner}{name}' is of type {type(value).__name__}, not a text or a number."
            for name, value in carrier.attrs.items()
            if not isinstance(value, (str, int, float))
        ]
    refuse(problems)
    return stamped


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, (np.generic, np.ndarray)) and np.ndim(value) == 0 else value


def structure_of(path: Path, trace: xarray.Dataset, elsewhere: Collection[str]) -> dict[str, Any]:
    """Describe a prepared Trace for JSON, without the numbers that are stored elsewhere in the file."""
    variables = []
    for name, variable in trace.variables.items():
        kind = {**dict.fromkeys("fiub", "real"), "c": "complex", **dict.fromkeys("UOT", "text")}.get(
            variable.dtype.kind
        )
        if kind is None:
            raise InputError(f"'{name}' holds '{variable.dtype}', neither numbers nor texts.", path=path)
        entry: dict[str, Any] = {"name": str(name), "dims": list(variable.dims), "kind": kind}
        entry |= {"coordinate": name in trace.coords, "attributes": dict(variable.attrs)}
        if name not in elsewhere:
            values = variable.values.astype(str) if kind == "text" else variable.values
            parts = [values.real, values.imag] if kind == "complex" else [values]
            entry["values"] = [part.tolist() for part in parts]
        variables.append(entry)
    return {"sizes": {str(name): size for name, size in trace.sizes.items()}, "variables": variables}


def rebuilt(
    structure: Mapping[str, Any], attributes: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]
) -> xarray.Dataset:
    """Rebuild the Trace that `structure_of` described, from the numbers stored elsewhere."""
    import xarray

    parts: dict[bool, dict[str, Any]] = {True: {}, False: {}}
    for entry in structure["variables"]:
        shape = tuple(structure["sizes"][name] for name in entry["dims"])
        if "values" in entry:
            dtype = str if entry["kind"] == "text" else np.float64
            values = [np.array(part, dtype=dtype).reshape(shape) for part in entry["values"]]
            array = joined(real=values[0], imaginary=values[1]) if entry["kind"] == "complex" else values[0]
        else:
            array = arrays[entry["name"]].reshape(shape)
        parts[bool(entry["coordinate"])][entry["name"]] = (tuple(entry["dims"]), array, entry["attributes"])
    return with_units_of_files(xarray.Dataset(parts[False], parts[True], dict(attributes)))


def with_units_of_files(trace: xarray.Dataset) -> xarray.Dataset:
    """Return a Trace that was read, with units as they are written inside."""
    for variable in trace.variables.values():
        if isinstance(unit := variable.attrs.get("units"), str):
            variable.attrs["units"] = unit_of_files(unit)
    return trace


def joined(*, real: NDArray[np.float64], imaginary: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Combine real and imaginary parts; adding ``1j`` times a part would spread NaN and lose -0."""
    whole = np.empty(np.shape(real), np.complex128)
    whole.real, whole.imag = real, imaginary
    return whole


TABLES: Final = ("time", "frequency")
"""Dimensions that a CSV file may run over, the one of the main file first."""

CASES: Final = "case"
"""Dimension of the table of a sweep: every combination of its parameters."""

_BLOCK: Final = 65536
_MOST_LAYERS: Final = 1000


def csv_files(sizes: Mapping[Any, int], path: Path) -> dict[Path, str]:
    """Return the CSV files of a Trace of these sizes, each with the dimension of its table."""
    sweeps = [str(name) for name in sizes if name not in (*TABLES, "layer")]
    tables = [name for name in TABLES if name in sizes]
    if not tables and "layer" not in sizes and "sample" not in sizes:
        return {path: CASES}
    if sweeps or not tables:
        also = f"also runs over {', '.join(sweeps)}" if sweeps else "has neither time nor frequency"
        raise InputError(
            f"a CSV file holds one dimension, but this Trace {also}; save as .nc or .mat.", path=path
        )
    return {path.with_suffix(f".{name}{path.suffix}") if i else path: name for i, name in enumerate(tables)}


def csv_forms(files: Iterable[Path]) -> dict[Path, Form]:
    """Return the form of each of the files of `csv_files`: the first holds what is needed to read the other."""
    return {file: Form.CSV_PART if number else Form.CSV for number, file in enumerate(files)}


def save_csv(trace: xarray.Dataset, path: Path, *, force: bool = False) -> list[Path]:
    """Write a Trace as CSV: one file over time, another over frequency; of a sweep, one row for each case.

    One column per layer, two for complex numbers; each number has the digits that restore the float exactly.
    A Trace with records of a sweep is refused.
    """
    stored = prepared(trace, path)
    files = csv_files(stored.sizes, path)
    swept = CASES in files.values()
    inside = {
        str(name)
        for name, variable in stored.variables.items()
        if (variable.dtype.kind in "fiub" if swept else set(TABLES) & set(variable.dims))
    }
    both = [name for name in sorted(inside) if set(TABLES) <= set(stored[name].dims)]
    if both:
        raise InputError(
            f"a CSV file holds one dimension, but '{both[0]}' has two; save as .nc or .mat.", path=path
        )
    structure = structure_of(path, stored, inside)
    said = f"# attributes: {_json(stored.attrs)}\n# structure: {_json(structure)}\n"
    judged = f"# validity: {json.dumps(stored.attrs['validity'])}\n" if "validity" in stored.attrs else ""
    key = hashlib.sha256(said.encode())
    for name in sorted(inside):
        key.update(stored[name].values.tobytes())
    forms = csv_forms(files)
    with writing(forms, force=force) as temporaries:
        for file, over in files.items():
            about = f"# table: {_json({'over': over, 'key': key.hexdigest()[:16]})}\n"
            mark = f"# {WRITTEN_BY}: {json.dumps(unsigned(forms[file]))}\n"
            with temporaries[file].open("w", encoding="utf-8", newline="") as out:
                out.write(f"# {FORMAT}\n{mark}{said if file == path else judged}{about}")
                _write_table(out, stored, structure, over)
    return list(files)


def _json(content: Mapping[str, Any]) -> str:
    return json.dumps(content, ensure_ascii=False)


def _entries(structure: Mapping[str, Any], over: str) -> list[Any]:
    """List the variables over one dimension, beginning with its coordinate."""
    if over == CASES:  # the parameters first
        found = [entry for entry in structure["variables"] if "values" not in entry]
        return sorted(found, key=lambda entry: not entry["coordinate"])
    found = [entry for entry in structure["variables"] if over in entry["dims"]]
    return sorted(found, key=lambda entry: bool(entry["name"] != over))


def _headings(structure: Mapping[str, Any], entry: Mapping[str, Any]) -> list[str]:
    """Return the headings of a variable: ``field[gap] [V/m]``, ``impedance.real [ohm]``."""
    labels = [""]
    if "layer" in entry["dims"]:
        listed = [e["values"][0] for e in structure["variables"] if e["name"] == "layer" and "values" in e]
        count = min(structure["sizes"]["layer"], _MOST_LAYERS)  # which a damaged file can give as any number
        labels = [f"[{label}]" for label in (listed[0] if listed else range(count))]
    parts = (".real", ".imag") if entry["kind"] == "complex" else ("",)
    unit = f" [{entry['attributes']['units']}]" if "units" in entry["attributes"] else ""
    return [f"{entry['name']}{label}{part}{unit}" for label in labels for part in parts]


def _write_table(out: TextIO, trace: xarray.Dataset, structure: Mapping[str, Any], over: str) -> None:
    headings: list[str] = []
    columns: list[NDArray[np.float64]] = []
    for entry in _entries(structure, over):
        headings += (own := _headings(structure, entry))
        if over == CASES:
            columns.append(_of_every_case(trace, entry["name"]))
            continue
        values = trace[entry["name"]].transpose(over, ...).values
        values = np.ascontiguousarray(values, np.complex128 if entry["kind"] == "complex" else np.float64)
        columns += list(values.view(np.float64).reshape(len(values), len(own)).T)
    csv.writer(out, lineterminator="\n").writerow(headings)
    for start in range(0, len(columns[0]) if columns else 0, _BLOCK):
        block = [column[start : start + _BLOCK].tolist() for column in columns]
        out.writelines(",".join(map(repr, row)) + "\n" for row in zip(*block, strict=True))


def _of_every_case(trace: xarray.Dataset, name: str) -> NDArray[np.float64]:
    """Repeat a variable along the parameters on which it does not depend."""
    whole = trace[name].variable.set_dims(dict(trace.sizes))  # type: ignore[no-untyped-call]
    return np.asarray(whole.values.astype(float).ravel())


def load_csv(path: Path) -> xarray.Dataset:
    """Read a Trace from CSV, with the file over frequency that belongs to it."""
    table, about = _read_part(path)
    if "structure" not in about or "attributes" not in about:
        raise DataFileError("is one part of a Trace; load the file it belongs to instead.", path=path)
    structure = about["structure"]
    arrays: dict[str, NDArray[Any]] = {}
    read: dict[Path, Form] = {}
    try:
        for file, over in csv_files(structure["sizes"], path).items():
            same_save = {"over": over, "key": about["table"]["key"]}
            if file != path:
                table = _read_other(file, path, same_save)
            elif about["table"] != same_save:
                raise _of_another_save(file)
            arrays |= _read_arrays(table, structure, over)
            read[table.path] = Form.CSV if file == path else Form.CSV_PART
        return verified(rebuilt(structure, about["attributes"], arrays), read)
    except DataFileError:
        raise
    except (*DAMAGE, InputError) as error:
        raise damaged(path, "a Trace", error) from None


def _read_other(file: Path, main: Path, same_save: object) -> TextTable:
    """Read the file saved together with the main one, or the temporary file left by a process killed in between."""
    note_input(file)
    if file.exists():
        table, about = _read_part(file)
        if about["table"] == same_save:
            return table
    for left in left_by_a_kill(file):
        with suppress(DataFileError):
            table, about = _read_part(left)
            if about["table"] == same_save:
                return table
    if file.exists():
        raise _of_another_save(file)
    raise DataFileError(f"there is no such file, but {main.name} was saved together with it.", path=file)


def _read_part(path: Path) -> tuple[TextTable, dict[str, Any]]:
    """Return the table of a file and the comments before it."""
    from electrovib.data.text.table import read_table

    check_file(path)
    with path.open("rb") as file:
        if file.readline(len(FORMAT) + 4).decode(errors="replace").strip() != f"# {FORMAT}":
            raise not_a_trace(path)
    table = read_table(path, delimiter=",")
    comments = [
        line[2:].partition(": ") for line in itertools.takewhile(lambda line: line[:1] == "#", table.lines())
    ]
    try:
        about = {name: json.loads(content) for name, _, content in comments[1:]}
        return table, about | {"table": about["table"]}
    except DAMAGE as error:
        raise damaged(path, "a Trace", error) from None


def _of_another_save(file: Path) -> DataFileError:
    return DataFileError(
        "is of another save than the file over time; the two do not belong together.", path=file
    )


def _read_arrays(table: TextTable, structure: Mapping[str, Any], over: str) -> dict[str, NDArray[Any]]:
    """Read the variables over one dimension."""
    entries = _entries(structure, over)
    headings = [_headings(structure, entry) for entry in entries]
    if list(table.headings) != list(itertools.chain(*headings)):
        raise DataFileError(
            f"{table.path}: its columns are not those that were saved; leave them as they are."
        )
    sizes = structure["sizes"]
    numbers = table.numbers(range(table.width))
    size = math.prod(sizes.values()) if over == CASES else sizes[over]
    if len(numbers) != size:
        raise DataFileError(f"{table.path}: holds {len(numbers)} rows over {over}, but {size} were saved.")
    if over == CASES:
        return {
            entry["name"]: _of_one_variable(numbers[:, place], sizes, entry["dims"])
            for place, entry in enumerate(entries)
        }
    arrays: dict[str, NDArray[Any]] = {}
    start = 0
    for entry, own in zip(entries, headings, strict=True):
        values = np.ascontiguousarray(numbers[:, start : start + len(own)])
        start += len(own)
        others = [structure["sizes"][name] for name in entry["dims"] if name != over]
        whole = values.view(np.complex128) if entry["kind"] == "complex" else values
        arrays[entry["name"]] = np.moveaxis(whole.reshape(size, *others), 0, entry["dims"].index(over))
    return arrays


def _of_one_variable(
    column: NDArray[np.float64], sizes: Mapping[str, int], dims: list[str]
) -> NDArray[np.float64]:
    """Restore a variable from its column: the first value along every parameter on which it does not depend."""
    whole = column.reshape(list(sizes.values()))
    taken = whole[tuple(slice(None) if dim in dims else 0 for dim in sizes)]
    kept = [dim for dim in sizes if dim in dims]
    return np.transpose(taken, [kept.index(dim) for dim in dims])
