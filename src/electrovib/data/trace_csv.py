"""Lossless storage of a Trace as CSV, one file per dimension; of a sweep, one row per case."""

from __future__ import annotations

import csv
import hashlib
import json
import math
import warnings
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TextIO

import numpy as np

from electrovib.core.errors import DataFileError, InputError, refuse
from electrovib.core.files import note_input
from electrovib.core.signals import FORMAT, stamp
from electrovib.core.units import unit_in_files, unit_of_files
from electrovib.data.atomic import left_by_a_kill, writing
from electrovib.data.faults import DAMAGE, check_file, damaged
from electrovib.data.marks import WRITTEN_BY, Form, unsigned, verified

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Iterator, Mapping
    from pathlib import Path

    import xarray
    from numpy.typing import NDArray


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
    carriers: dict[str, Any] = {"": stamped, **{str(name): each for name, each in stamped.variables.items()}}
    for owner, carrier in carriers.items():
        carrier.attrs = {str(name): _plain(value) for name, value in carrier.attrs.items()}
        if owner and isinstance(unit := carrier.attrs.get("units"), str):
            carrier.attrs["units"] = unit_in_files(unit)
        problems += [
            f"{path}: attribute '{owner}{'.' * bool(owner)}{name}' is of type {type(value).__name__}, not a text or a number."
            for name, value in carrier.attrs.items()
            if not isinstance(value, (str, int, float))
        ]
    refuse(problems)
    return stamped


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, (np.generic, np.ndarray)) and np.ndim(value) == 0 else value


TYPES: Final = {"real": np.float64, "complex": np.complex128}
"""Types of numbers in a file, by the kind that its structure states."""


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

    variables: dict[str, Any] = {}
    for entry in structure["variables"]:
        shape = tuple(structure["sizes"][name] for name in entry["dims"])
        if "values" in entry:
            dtype = str if entry["kind"] == "text" else np.float64
            parts = [np.array(part, dtype=dtype).reshape(shape) for part in entry["values"]]
            array = joined(real=parts[0], imaginary=parts[1]) if entry["kind"] == "complex" else parts[0]
        else:
            array = arrays[entry["name"]].reshape(shape)
        variables[entry["name"]] = (tuple(entry["dims"]), array, entry["attributes"])
    coordinates = [entry["name"] for entry in structure["variables"] if entry["coordinate"]]
    found = xarray.Dataset(variables, attrs=dict(attributes)).set_coords(coordinates)
    return with_units_of_files(found)


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
        if variable.dtype.kind in ("fiub" if swept else "fiubc") and (swept or {*TABLES} & {*variable.dims})
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


def _columns(structure: Mapping[str, Any], over: str) -> Iterator[tuple[Any, list[str], dict[str, int]]]:
    """Iterate over the variables of a table, its coordinates first, with their headings, and the sizes of all their dimensions.

    First come those of the rows, which in a sweep are all its parameters, also where a variable does not depend on one.
    """
    sizes, swept = structure["sizes"], over == CASES
    along = list(sizes) if swept else [over]
    inside = [each for each in structure["variables"] if "values" not in each]
    found = [entry for entry in inside if swept or over in entry["dims"]]
    for entry in sorted(found, key=lambda each: not each["coordinate"] if swept else each["name"] != over):
        yield entry, _headings(structure, entry), {name: sizes[name] for name in [*along, *entry["dims"]]}


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
    for entry, own, sizes in _columns(structure, over):
        headings += own
        whole = trace[entry["name"]].variable.set_dims(sizes).values
        whole = np.ascontiguousarray(whole, TYPES[entry["kind"]]).view(np.float64)
        columns += list(whole.reshape(-1, len(own)).T) if own else []
    csv.writer(out, lineterminator="\n").writerow(headings)
    for start in range(0, len(columns[0]) if columns else 0, _BLOCK):
        block = [column[start : start + _BLOCK].tolist() for column in columns]
        out.writelines(",".join(map(repr, row)) + "\n" for row in zip(*block, strict=True))


def load_csv(path: Path) -> xarray.Dataset:
    """Read a Trace from CSV, with the file over frequency that belongs to it."""
    main = _read_part(path)
    if not {"structure", "attributes"} <= main.about.keys():
        raise DataFileError("is one part of a Trace; load the file it belongs to instead.", path=path)
    structure = main.about["structure"]
    arrays: dict[str, NDArray[Any]] = {}
    read: dict[Path, Form] = {}
    try:
        files = csv_files(structure["sizes"], path)
        for file, form in csv_forms(files).items():
            part = _of_same_save(main, file, files[file])
            arrays |= _read_arrays(part, structure, files[file])
            read[part.path] = form
        return verified(rebuilt(structure, main.about["attributes"], arrays), read)
    except DataFileError:
        raise
    except (*DAMAGE, InputError) as error:
        raise damaged(path, "a Trace", error) from None


class _Part(NamedTuple):
    """One file: the comments before its table, by their names, its headings, and its numbers, shape (rows, columns)."""

    path: Path
    about: dict[str, Any]
    table: dict[str, str]
    headings: list[str]
    numbers: NDArray[np.float64]


def _read_part(path: Path) -> _Part:
    check_file(path)
    about: dict[str, Any] = {}
    with path.open("rb") as file:
        if file.readline(len(FORMAT) + 4).decode(errors="replace").strip() != f"# {FORMAT}":
            raise not_a_trace(path)
        try:
            while (line := file.readline().decode()).startswith("#"):
                name, _, content = line[2:].partition(": ")
                about[name] = json.loads(content)
            headings = next(csv.reader([line]), [])
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # of a table without rows
                numbers = np.loadtxt(file, delimiter=",", ndmin=2)
            return _Part(path, about, about["table"], headings, numbers)
        except DAMAGE as error:
            raise damaged(path, "a Trace", error) from None


def _of_same_save(main: _Part, file: Path, over: str) -> _Part:
    """Return the table of a save: in the main file, the one beside it, or a temporary one left by a process killed in between."""
    parts = [main]
    if file != main.path:
        note_input(file)
        parts = [_read_part(file)] if file.exists() else []
        for left in left_by_a_kill(file):
            with suppress(DataFileError):
                parts.append(_read_part(left))
    for part in parts:
        if part.table == {"over": over, "key": main.table["key"]}:
            return part
    why = "is of another save than the file over time; the two do not belong together."
    if not file.exists():
        why = f"there is no such file, but {main.path.name} was saved together with it."
    raise DataFileError(why, path=file)


def _read_arrays(part: _Part, structure: Mapping[str, Any], over: str) -> dict[str, NDArray[Any]]:
    """Read the variables of a table: the first value along every parameter on which one does not depend."""
    import xarray

    columns = list(_columns(structure, over))
    if part.headings != [heading for _, own, _ in columns for heading in own]:
        why = "its columns are not those that were saved; leave them as they are."
        raise DataFileError(why, path=part.path)
    sizes = structure["sizes"]
    shape = (math.prod(sizes.values()) if over == CASES else sizes[over], len(part.headings))
    if part.numbers.shape != shape and (shape[0] or part.numbers.size):
        rows, wide = part.numbers.shape
        why = f"holds {rows} rows over {over} with {wide} numbers each, but {shape[0]} with {shape[1]} were saved."
        raise DataFileError(why, path=part.path)
    arrays: dict[str, NDArray[Any]] = {}
    left = part.numbers.reshape(shape)
    for entry, own, dims in columns:
        values, left = left[:, : len(own)], left[:, len(own) :]
        values = np.ascontiguousarray(values).view(TYPES[entry["kind"]]).reshape(tuple(dims.values()))
        found = xarray.Variable(tuple(dims), values).isel(dict.fromkeys(dims.keys() - entry["dims"], 0))
        arrays[entry["name"]] = found.transpose(*entry["dims"]).values
    return arrays
