"""A Trace as a MATLAB file, without loss."""

from __future__ import annotations

import io
import json
import re
import struct
import zlib
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import DataFileError, InputError
from electrovib.core.trace import FORMAT
from electrovib.data.atomic import writing
from electrovib.data.columns import DAMAGE, check_file, damaged
from electrovib.data.marks import Form, unsigned
from electrovib.data.traces import not_a_trace, prepared, rebuilt, structure_of

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
_COMPRESSED: Final = 15  # element type of the format
_VERSION_5: Final = "MATLAB 5.0 MAT-file"
_HEADER: Final = 116  # bytes of text that a file begins with


def save_mat(trace: xarray.Dataset, path: Path, *, force: bool = False) -> list[Path]:
    """Write a Trace for MATLAB, one variable per signal.

    Parameters
    ----------
    trace : xarray.Dataset
        Any Trace; units are stamped again.
    path : Path
        The output, version 5 of the format, compressed; replaced as a whole.
    force : bool
        Whether a file that we did not write may be replaced.

    Returns
    -------
    list of Path
        The file.

    Raises
    ------
    InputError
        If the file cannot be written, would replace one that is not ours, or the Trace is too large for the format
        (4 GB a variable).

    Notes
    -----
    Names become MATLAB names (``drive.rise`` is ``drive_rise``). Beside the signals the file has the structs
    ``units`` and ``dimensions`` with a text per variable, and the JSON text ``trace_json`` with all the rest:
    ``jsondecode(trace_json).attributes.scenario``.
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
        scipy.io.savemat(file, content, do_compression=True, long_field_names=True, oned_as="column")
    except (ValueError, TypeError, struct.error, OverflowError, scipy.io.matlab.MatWriteError) as error:
        raise InputError(
            f"{path}: this Trace does not fit into a .mat file ({error}); save as .nc."
        ) from error
    header = f"{_VERSION_5}, {unsigned(Form.MATLAB)}"
    file.getbuffer()[:_HEADER] = header.ljust(_HEADER).encode()
    with writing({path: Form.MATLAB}, force=force) as temporaries:
        temporaries[path].write_bytes(file.getbuffer())
    return [path]


def matlab_names(names: Iterable[str]) -> dict[str, str]:
    """Give each name a MATLAB variable name of its own.

    Parameters
    ----------
    names : iterable of str
        Names of a Trace.

    Returns
    -------
    dict of str to str
        Letters, digits and underscores, at most 63, a letter first, no keyword, no two alike.
    """
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
    """Read a Trace from a MATLAB file.

    Parameters
    ----------
    path : Path
        Written by `save_mat`; one saved again by MATLAB with ``-v7`` is fine too.

    Returns
    -------
    xarray.Dataset
        Identical to what was saved.

    Raises
    ------
    DataFileError
        If the file is damaged, is not a Trace, or is not of the compressed version 5.

    Notes
    -----
    The reader beneath can crash the interpreter at a malformed file. Every element is therefore checked first
    against the checksum that compression carries: accidental damage is caught. A file forged with right
    checksums is not, so open files of strangers elsewhere first.
    """
    import scipy.io

    check_file(path)
    try:
        _check_elements(path, path.read_bytes())
        names = [name for name, _, _ in scipy.io.whosmat(path, appendmat=False)]
        if "trace_json" not in names:
            raise not_a_trace(path)
        content = scipy.io.loadmat(path, appendmat=False)
        text = content["trace_json"]
        about = json.loads(str(text.item())) if text.size == 1 and text.dtype.kind == "U" else {}
        if not isinstance(about, dict) or about.get("format") != FORMAT:
            raise not_a_trace(path)
        return rebuilt(about["structure"], about["attributes"], _arrays(about, content))
    except (*DAMAGE, zlib.error, scipy.io.matlab.MatReadError) as error:
        raise damaged(path, "a MATLAB file", error) from None


def _arrays(about: dict[str, Any], content: dict[str, Any]) -> dict[str, NDArray[Any]]:
    arrays: dict[str, NDArray[Any]] = {}
    for entry in about["structure"]["variables"]:
        if "values" not in entry:
            kind = np.complex128 if entry["kind"] == "complex" else np.float64
            arrays[entry["name"]] = content[about["names"][entry["name"]]].astype(kind)
    return arrays


def _check_elements(path: Path, raw: bytes) -> None:
    """Walk over the elements; all must be compressed, whole, and right in their checksum."""
    if not raw.startswith(_VERSION_5.encode()) or raw[124:128] not in (b"\x00\x01IM", b"\x01\x00MI"):
        newer = " of version 7.3; save it with -v7" if b"MATLAB 7.3" in raw[:116] else ""
        raise DataFileError(f"{path}: is not a MATLAB file of version 5{newer}.")
    order = "<" if raw[126:128] == b"IM" else ">"
    place = 128
    while place < len(raw):
        kind, size = struct.unpack_from(f"{order}II", raw, place)
        place += 8 + size
        if kind != _COMPRESSED:
            raise DataFileError(f"{path}: is not a compressed MATLAB file; was it saved with -v6? Use -v7.")
        if place > len(raw):
            raise DataFileError(f"{path}: is cut short: {place - len(raw)} bytes are missing.")
        zlib.decompress(memoryview(raw)[place - size : place])
