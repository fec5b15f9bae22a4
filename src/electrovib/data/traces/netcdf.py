"""Lossless storage of a Trace as netCDF."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.signals import FORMAT
from electrovib.data.atomic import writing
from electrovib.data.faults import DAMAGE, check_file, damaged
from electrovib.data.guarded import GuardedReading
from electrovib.data.marks import WRITTEN_BY, Form, unsigned
from electrovib.data.readers.hdf5 import reader
from electrovib.data.traces.structure import not_a_trace, prepared

if TYPE_CHECKING:
    from pathlib import Path

    import xarray

_LONG_TEXT: Final = 8000  # HDF5 refuses attributes beyond 64 kB, and keeps smaller ones together in one block


def save_nc(trace: xarray.Dataset, path: Path, *, force: bool = False) -> list[Path]:
    """Write a Trace as netCDF.

    Texts too long for an attribute become scalar variables ``long_attribute_0``, ... . The file is built in
    memory, because the HDF5 library ends the interpreter if the disk is full.
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
        content = in_memory(stored, no_fill)
    except (ValueError, TypeError) as error:
        raise InputError(f"this Trace cannot be written as netCDF: {error}", path=path) from error
    with writing({path: Form.NETCDF}, force=force) as temporaries:
        temporaries[path].write_bytes(content.getbuffer())
    return [path]


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
    check_file(path)
    with GuardedReading(reader(path, "everything"), path) as reading:
        import xarray  # while the other process reads

        content = reading.content()
    attributes = content.pop("attributes")
    if attributes.get("format") != FORMAT:
        raise not_a_trace(path)
    try:
        variables = {}
        for name in [key.removeprefix("about ") for key in content if key.startswith("about ")]:
            about, values = content[f"about {name}"], content.pop(f"values {name}")
            array = np.array(values, dtype=str).reshape(about["shape"]) if about["text"] else values
            variables[name] = xarray.Variable(about["dims"], array, about["attributes"])
        stored = xarray.Dataset(variables, attrs=attributes)
        return _as_saved(
            xarray.decode_cf(
                stored,
                decode_times=False,
                decode_timedelta=False,
                mask_and_scale=False,
                concat_characters=False,
            )
        )
    except DAMAGE as error:
        raise damaged(path, "a netCDF file", error) from None


def _as_saved(loaded: xarray.Dataset) -> xarray.Dataset:
    trace = loaded.drop_encoding()
    trace.attrs.pop(WRITTEN_BY, None)
    for name, variable in list(trace.variables.items()):
        if str(name).startswith("long_attribute_"):
            trace.attrs[variable.attrs["attribute"]] = str(variable.values)
            trace = trace.drop_vars(str(name))
    return trace
