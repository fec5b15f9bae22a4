"""Lossless storage of a Trace as netCDF or for MATLAB, and its reading in the format that the suffix of a name states."""

from __future__ import annotations

import io
import json
import os
import re
import struct
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeVar

import numpy as np

from electrovib.core.budget import content_allowed
from electrovib.core.errors import DataFileError, InputError, refuse
from electrovib.core.file_kinds import other_kind
from electrovib.core.files import kind_of, note_input
from electrovib.core.signals import FORMAT, stamp
from electrovib.core.units import unit_in_files, unit_of_files
from electrovib.data.atomic import WRITTEN_BY, Form, has_checksum, not_verified, unsigned, writing
from electrovib.data.guarded import DAMAGE, check_file, damaged

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    import xarray


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


def _with_units_of_files(trace: xarray.Dataset) -> xarray.Dataset:
    """Return a Trace that was read, with units as they are written inside."""
    for variable in trace.variables.values():
        if isinstance(unit := variable.attrs.get("units"), str):
            variable.attrs["units"] = unit_of_files(unit)
    return trace


_OWN: Final = ("trace_json", "units", "dimensions")
_KEYWORDS: Final = re.compile(
    "break|case|catch|classdef|continue|else|elseif|end|for|function|global|if|otherwise|parfor|persistent"
    "|return|spmd|switch|try|while"
)
_VERSION_5: Final = "MATLAB 5.0 MAT-file"
_HEADER: Final = 116  # bytes of text that a file begins with
_TYPES: Final = {"real": np.float64, "complex": np.complex128, "text": str}
"""Types of arrays, by the kind that the description of a Trace states."""


def save_mat(trace: xarray.Dataset, path: Path, *, force: bool = False) -> list[Path]:
    """Write a Trace for MATLAB, one variable per signal.

    Names become MATLAB names (``drive.rise`` is ``drive_rise``). Beside the signals the file has the structs
    ``units`` and ``dimensions`` with a text per variable, and the JSON text ``trace_json`` with everything
    else, such as ``jsondecode(trace_json).attributes.scenario``. A variable holds at most 4 GB.
    """
    import scipy.io

    stored = prepared(trace, path)
    structure = _structure_of(path, stored)
    entries = structure["variables"]
    names = matlab_names([entry["name"] for entry in entries])
    kinds = _TYPES | {"text": object}
    content: dict[str, Any] = {
        names[entry["name"]]: stored[entry["name"]].values.astype(kinds[entry["kind"]]) for entry in entries
    }
    content["units"] = {names[entry["name"]]: entry["attributes"].get("units", "") for entry in entries}
    content["dimensions"] = {names[entry["name"]]: ", ".join(entry["dims"]) for entry in entries}
    about = {"format": FORMAT, "attributes": stored.attrs, "structure": structure, "names": names}
    content["trace_json"] = json.dumps(about)
    file = io.BytesIO()
    try:
        for packed in (True, False):
            scipy.io.savemat(file, content, do_compression=packed, long_field_names=True, oned_as="column")
            if stored.nbytes <= content_allowed(file.tell()):
                break
            file = io.BytesIO()  # equal numbers, compressed more than the reader accepts
    except (ValueError, TypeError, struct.error, OverflowError, scipy.io.matlab.MatWriteError) as error:
        raise InputError(
            f"this Trace does not fit into a .mat file ({error}); save as .nc.", path=path
        ) from error
    header = f"{_VERSION_5}, {unsigned(Form.MATLAB)}"
    file.getbuffer()[:_HEADER] = header.ljust(_HEADER).encode()
    with writing({path: Form.MATLAB}, force=force) as temporaries:
        temporaries[path].write_bytes(file.getbuffer())
    return [path]


def _structure_of(path: Path, trace: xarray.Dataset) -> dict[str, Any]:
    """Describe a prepared Trace for JSON: everything but its numbers, which are variables of the file."""
    variables = []
    kinds = {**dict.fromkeys("fiub", "real"), "c": "complex", **dict.fromkeys("UOT", "text")}
    for name, variable in trace.variables.items():
        kind = kinds.get(variable.dtype.kind)
        if kind is None:
            raise InputError(f"'{name}' holds '{variable.dtype}', neither numbers nor texts.", path=path)
        entry: dict[str, Any] = {"name": str(name), "dims": list(variable.dims), "kind": kind}
        entry |= {"coordinate": name in trace.coords, "attributes": dict(variable.attrs)}
        if kind == "text":
            entry["values"] = [variable.values.astype(str).tolist()]
        variables.append(entry)
    return {"sizes": {str(name): size for name, size in trace.sizes.items()}, "variables": variables}


def _rebuilt(about: Mapping[str, Any], found: Mapping[str, Any]) -> xarray.Dataset:
    """Rebuild the Trace that `_structure_of` described, from the variables of the file."""
    import xarray

    structure = about["structure"]
    variables: dict[str, Any] = {}
    for entry in structure["variables"]:
        # MATLAB saves complex numbers without imaginary part as real ones
        kind, shape = _TYPES[entry["kind"]], tuple(structure["sizes"][name] for name in entry["dims"])
        values = entry["values"][0] if entry["kind"] == "text" else found[about["names"][entry["name"]]]
        variables[entry["name"]] = (
            tuple(entry["dims"]), np.asarray(values, kind).reshape(shape), entry["attributes"],
        )  # fmt: skip
    coordinates = [entry["name"] for entry in structure["variables"] if entry["coordinate"]]
    rebuilt = xarray.Dataset(variables, attrs=dict(about["attributes"])).set_coords(coordinates)
    return _with_units_of_files(rebuilt)


def matlab_names(names: Iterable[str]) -> dict[str, str]:
    """Assign a unique MATLAB variable name to each name."""
    found: dict[str, str] = {}
    for name in names:
        plain = re.sub(r"[^A-Za-z0-9_]", "_", name)[:55]
        if not plain[:1].isalpha() or _KEYWORDS.fullmatch(plain):
            plain = f"x{plain}"
        taken = {*_OWN, *found.values()}
        free = (f"{plain}_{number}" if number else plain for number in range(len(taken) + 1))
        found[name] = next(candidate for candidate in free if candidate not in taken)
    return found


def load_mat(path: Path) -> xarray.Dataset:
    """Read a Trace from a MATLAB file, also one that MATLAB has saved again; checksums of variables are verified."""
    from electrovib.data.readers.matlab import read_variables

    check_file(path)
    is_whole = has_checksum(path, Form.MATLAB)
    found = read_variables(path, is_whole=is_whole)
    try:
        text = found.get("trace_json", "{}")
        about = json.loads(text) if isinstance(text, str) else {}
        if not isinstance(about, dict) or about.get("format") != FORMAT:
            raise not_a_trace(path)
        trace = _rebuilt(about, found)
        return trace if is_whole else not_verified(trace, path)
    except DAMAGE as error:
        raise damaged(path, "a MATLAB file", error) from None


_LONG_TEXT: Final = 8000  # HDF5 refuses attributes beyond 64 kB, and keeps smaller ones together in one block


def save_nc(trace: xarray.Dataset, path: Path, *, force: bool = False) -> list[Path]:
    """Write a Trace as netCDF."""
    content = nc_content(trace, path)
    with writing({path: Form.NETCDF}, force=force) as temporaries:
        temporaries[path].write_bytes(content)
    return [path]


def nc_content(trace: xarray.Dataset, path: Path) -> bytes:
    """Write a Trace as netCDF into memory, because the HDF5 library ends the interpreter if the disk is full.

    Texts too long for an attribute become scalar variables ``long_attribute_0``, ... .
    """
    stored = prepared(trace, path).drop_encoding()
    attributes, stored.attrs = stored.attrs, {WRITTEN_BY: unsigned(Form.NETCDF)}
    for name, value in attributes.items():
        if isinstance(value, str) and len(value) > _LONG_TEXT:
            stored[f"long_attribute_{len(stored.variables)}"] = ((), value, {"attribute": name})
        else:
            stored.attrs[name] = int(value) if isinstance(value, bool) else value  # netCDF knows no booleans
    no_fill: dict[Any, Any] = {name: {"_FillValue": None} for name in stored.variables}
    try:
        return in_memory(stored, no_fill).getvalue()
    except (ValueError, TypeError) as error:
        raise InputError(f"this Trace cannot be written as netCDF: {error}", path=path) from error


def in_memory(stored: xarray.Dataset, encoding: dict[Any, Any]) -> io.BytesIO:
    """Write a dataset as netCDF into memory."""
    import h5netcdf
    from xarray.backends import H5NetCDFStore

    content = io.BytesIO()
    with h5netcdf.File(content, "w") as file:
        stored.dump_to_store(H5NetCDFStore(file), encoding=encoding)
    return content


def load_nc(path: Path) -> xarray.Dataset:
    """Read a Trace from netCDF."""
    import xarray

    from electrovib.data.readers.hdf5 import contents, decoded

    check_file(path)
    is_whole = has_checksum(path, Form.NETCDF)
    content = contents(path, is_whole=is_whole, texts=True)
    attributes = content.pop("attributes")
    if attributes.get("format") != FORMAT:
        raise not_a_trace(path)
    try:
        variables = {}
        for _, name in [key for key in content if key[0] == "about" and "/" not in key[1]]:
            about, raw = content["about", name], content.pop(("values", name), None)
            values = (
                np.array(raw, dtype=str).reshape(about["shape"]) if about["text"] else decoded(about, raw)[0]
            )
            if isinstance(values, str):
                raise DataFileError(f"'{name}' {values}.", path=path)
            stated = {key: each for key, each in about["attributes"].items() if key not in about["packing"]}
            variables[name] = xarray.Variable(about["dims"], values, stated)
        stored = xarray.Dataset(variables, attrs=attributes)
        loaded = xarray.decode_cf(
            stored, decode_times=False, decode_timedelta=False, mask_and_scale=False, concat_characters=False
        )
        found = _as_saved(loaded)
        return found if is_whole else not_verified(found, path)
    except DAMAGE as error:
        raise damaged(path, "a netCDF file", error) from None


def _as_saved(loaded: xarray.Dataset) -> xarray.Dataset:
    trace = loaded.drop_encoding()
    trace.attrs.pop(WRITTEN_BY, None)
    for name, variable in list(trace.variables.items()):
        if str(name).startswith("long_attribute_"):
            trace.attrs[variable.attrs["attribute"]] = str(variable.values)
            trace = trace.drop_vars(str(name))
    return _with_units_of_files(trace)


FORMATS: Final[dict[str, Callable[[Path], xarray.Dataset]]] = {
    ".nc": load_nc,
    ".mat": load_mat,
}
"""Maps a suffix to its reader."""


Source = TypeVar("Source")


def is_trace_file(source: object) -> bool:
    """Return whether something is, by its suffix, the name of a file of a Trace."""
    return isinstance(source, (str, os.PathLike)) and Path(source).suffix.lower() in FORMATS


def open_if_trace(source: Source) -> Source | xarray.Dataset:
    """Open a file of a Trace, and return anything else unchanged."""
    return open_trace(source) if is_trace_file(source) else source  # type: ignore[arg-type]  # it is a name


def open_trace(path: str | Path) -> xarray.Dataset:
    """Read a Trace, computed or measured.

    Parameters
    ----------
    path : str or Path
        File written by `electrovib.save`: ``.nc`` or ``.mat``.

    Returns
    -------
    xarray.Dataset
        Trace in memory, identical to the one that was saved.

    Raises
    ------
    DataFileError
        If there is no such file, if it is damaged, or if it holds no Trace.

    Examples
    --------
    >>> ev.save(ev.simulate("vezzoli_2014/fig6"), "fig6.nc")[0].name
    'fig6.nc'
    >>> with ev.open_trace("fig6.nc") as trace:
    ...     print(trace.sizes["time"])
    2001
    """
    place = Path(path)
    note_input(place)
    reader = FORMATS.get(place.suffix.lower())
    if reader is None and (why := other_kind(place, "a Trace")):
        raise DataFileError(why, path=place)
    if reader is None:
        if place.suffix or kind_of(place) == "folder":
            check_file(place)
        raise DataFileError(
            f"a Trace is opened from {', '.join(FORMATS)}, not from '{place.suffix or place}'; 'electrovib run' makes one of a"
            " scenario, which electrovib.load reads",
            path=place,
        )
    return reader(place)
