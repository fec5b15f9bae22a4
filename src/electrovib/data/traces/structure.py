"""Parts common to all formats of a Trace: units, attributes, and its structure as JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.errors import DataFileError, InputError
from electrovib.core.signals import FORMAT, stamp

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping
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
    carriers: dict[str, Any] = {f"{name}.": variable for name, variable in stamped.variables.items()}
    for owner, carrier in {"": stamped, **carriers}.items():
        carrier.attrs = {str(name): _plain(value) for name, value in carrier.attrs.items()}
        problems += [
            f"{path}: attribute '{owner}{name}' is of type {type(value).__name__}, not a text or a number."
            for name, value in carrier.attrs.items()
            if not isinstance(value, (str, int, float))
        ]
    if problems:
        raise InputError(problems)
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
    return xarray.Dataset(parts[False], parts[True], dict(attributes))


def joined(*, real: NDArray[np.float64], imaginary: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Combine real and imaginary parts; adding ``1j`` times a part would spread NaN and lose -0."""
    whole = np.empty(np.shape(real), np.complex128)
    whole.real, whole.imag = real, imaginary
    return whole
