"""Lossless storage of a Trace as a MATLAB file."""

from __future__ import annotations

import io
import json
import re
import struct
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.budget import content_allowed
from electrovib.core.errors import InputError
from electrovib.core.signals import FORMAT
from electrovib.data.atomic import writing
from electrovib.data.faults import DAMAGE, damaged
from electrovib.data.marks import Form, unsigned
from electrovib.data.readers.matlab import read_variables
from electrovib.data.traces.structure import not_a_trace, prepared, rebuilt, structure_of

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

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
    names = matlab_names([entry["name"] for entry in structure["variables"]])
    content: dict[str, Any] = {}
    for entry in structure["variables"]:
        values = stored[entry["name"]].values
        kind = {"real": np.float64, "complex": np.complex128, "text": object}[entry["kind"]]
        content[names[entry["name"]]] = values.astype(kind)
    entries = structure["variables"]
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
    found = read_variables(path, needed="trace_json")
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
        return rebuilt(about["structure"], about["attributes"], arrays)
    except DAMAGE as error:
        raise damaged(path, "a MATLAB file", error) from None
