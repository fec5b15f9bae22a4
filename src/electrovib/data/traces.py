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
from electrovib.core.errors import DataFileError, InputError
from electrovib.core.file_kinds import other_kind
from electrovib.core.files import kind_of, note_input
from electrovib.core.signals import FORMAT
from electrovib.data.atomic import writing
from electrovib.data.faults import DAMAGE, check_file, damaged
from electrovib.data.marks import WRITTEN_BY, Form, unsigned, verified
from electrovib.data.trace_csv import (
    TYPES,
    load_csv,
    not_a_trace,
    prepared,
    rebuilt,
    structure_of,
    with_units_of_files,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    import xarray
    from numpy.typing import NDArray


_OWN: Final = ("trace_json", "units", "dimensions")
_KEYWORDS: Final = re.compile(
    "break|case|catch|classdef|continue|else|elseif|end|for|function|global|if|otherwise|parfor|persistent"
    "|return|spmd|switch|try|while"
)
_VERSION_5: Final = "MATLAB 5.0 MAT-file"
_HEADER: Final = 116  # bytes of text that a file begins with


def save_mat(trace: xarray.Dataset, path: Path, *, force: bool = False) -> list[Path]:
    """Write a Trace for MATLAB, one variable per signal.

    Names become MATLAB names (``drive.rise`` is ``drive_rise``). Beside the signals the file has the structs
    ``units`` and ``dimensions`` with a text per variable, and the JSON text ``trace_json`` with everything
    else, such as ``jsondecode(trace_json).attributes.scenario``. A variable holds at most 4 GB.
    """
    import scipy.io

    stored = prepared(trace, path)
    numeric = [str(name) for name, variable in stored.variables.items() if variable.dtype.kind in "fiubc"]
    structure = structure_of(path, stored, numeric)
    entries = structure["variables"]
    names = matlab_names([entry["name"] for entry in entries])
    kinds = {**TYPES, "text": object}
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

    found = read_variables(path)
    try:
        text = found.get("trace_json", "{}")
        about = json.loads(text) if isinstance(text, str) else {}
        if not isinstance(about, dict) or about.get("format") != FORMAT:
            raise not_a_trace(path)
        arrays: dict[str, NDArray[Any]] = {}
        for entry in about["structure"]["variables"]:
            if "values" not in entry:
                values = np.asarray(found[about["names"][entry["name"]]])
                # MATLAB saves complex numbers without imaginary part as real ones
                arrays[entry["name"]] = values.astype(np.complex128) if entry["kind"] == "complex" else values
        return verified(rebuilt(about["structure"], about["attributes"], arrays), {path: Form.MATLAB})
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
    from electrovib.data.guarded import GuardedReading
    from electrovib.data.readers.hdf5 import decoded, reader

    check_file(path)
    with GuardedReading(reader(path), path, texts=True) as reading:
        import xarray  # while the other process reads

        content = reading.content()
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
        return verified(_as_saved(loaded), {path: Form.NETCDF})
    except DAMAGE as error:
        raise damaged(path, "a netCDF file", error) from None


def _as_saved(loaded: xarray.Dataset) -> xarray.Dataset:
    trace = loaded.drop_encoding()
    trace.attrs.pop(WRITTEN_BY, None)
    for name, variable in list(trace.variables.items()):
        if str(name).startswith("long_attribute_"):
            trace.attrs[variable.attrs["attribute"]] = str(variable.values)
            trace = trace.drop_vars(str(name))
    return with_units_of_files(trace)


FORMATS: Final[dict[str, Callable[[Path], xarray.Dataset]]] = {
    ".nc": load_nc,
    ".csv": load_csv,
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
        File written by `electrovib.save`: ``.nc``, ``.csv`` (the main file of one or two) or ``.mat``.

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
