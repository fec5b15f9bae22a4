"""The checksum of a Trace: of its numbers, coordinates and attributes, the same in each format that it is stored in."""

from __future__ import annotations

import hashlib
import json
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import DataFileError

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    import xarray

CHECKSUM: Final = "checksum"
"""Attribute of a stored Trace, and comment of a CSV file, with the checksum of everything else."""


def checksum(trace: xarray.Dataset) -> str:
    """Return the checksum of a Trace, which depends neither on the order nor on the storage of its variables."""
    key = hashlib.sha256(_said(trace.attrs))
    for name in sorted(map(str, trace.variables)):
        variable = trace.variables[name]
        values: Any = variable.values
        if values.dtype.kind not in "fiubc":
            key.update(json.dumps(values.astype(str).tolist()).encode())
        else:
            values = values.astype(np.complex128 if values.dtype.kind == "c" else np.float64).ravel()
            numbers = np.array(values).view(np.float64)
            numbers[np.isnan(numbers)] = np.nan  # of many kinds, which text does not keep
            key.update(numbers.tobytes())
        place = [name, list(variable.dims), list(variable.shape), name in trace.coords]
        key.update(json.dumps(place).encode() + _said(variable.attrs))
    return key.hexdigest()[:32]


def _said(attributes: Mapping[Any, Any]) -> bytes:
    """Return attributes in an order of their own, each number as a float."""
    plain = {str(name): each if isinstance(each, str) else float(each) for name, each in attributes.items()}
    return json.dumps(plain, sort_keys=True).encode()


def verified(trace: xarray.Dataset, path: Path) -> xarray.Dataset:
    """Return a Trace that was read, without its checksum; one that contradicts it is refused, one without it says so."""
    stated = trace.attrs.pop(CHECKSUM, None)
    if stated is None:
        why = f"not verified: {path.name} states no checksum, so that damage of its numbers would not be noticed"
        told = json.loads(trace.attrs.get("validity", "[]"))
        trace.attrs["validity"] = json.dumps([*told, Diagnostic(CHECKSUM, "warning", why).to_dict()])
    elif stated != checksum(trace):
        raise DataFileError(
            "is damaged, or was edited: its content is not that of its checksum. Make it again; a .csv file that was edited on"
            f" purpose is read, not verified, without its line '# {CHECKSUM}: ...'",
            path=path,
        )
    return trace
