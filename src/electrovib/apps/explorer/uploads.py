"""Files that a visitor drops on the page: recordings to compare with, and scenarios."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from electrovib.apps.explorer.limits import LARGEST_UPLOAD
from electrovib.apps.explorer.state import refuse_files, refuse_many_samples
from electrovib.core.errors import ElectrovibError, InputError
from electrovib.core.parsing import read_toml
from electrovib.core.signals import SIGNALS
from electrovib.scenario import Scenario, read_scenario

if TYPE_CHECKING:
    import xarray

    from electrovib.data.readers.recorded import Recorded

SCENARIO_SUFFIX: Final = ".toml"
MOST_VALUES: Final = 2_000_000
"""Numbers of a recording, all channels together."""
OVER_TIME: Final = tuple(name for name, each in SIGNALS.items() if each.dims == ("time",))
"""Signals that a column of a recording can be."""


@dataclass(frozen=True)
class Uploaded:
    """A file that was read.

    Parameters
    ----------
    name : str
        As the visitor's machine calls it; used in texts only.
    recorded : Recorded, optional
        Its columns, where it is not yet known which signals they are.
    trace : xarray.Dataset, optional
        The recording with named signals.
    """

    name: str
    recorded: Recorded | None = None
    trace: xarray.Dataset | None = None


def read_upload(name: str, content: bytes) -> Uploaded:
    """Read a recording from the bytes of a file.

    Parameters
    ----------
    name : str
        Name of the file; only its suffix is used.
    content : bytes
        The file.

    Returns
    -------
    Uploaded
        With a Trace if the file names its signals, else with its columns.

    Raises
    ------
    InputError, ElectrovibError
        If it is too large, or if no reader takes it.

    Notes
    -----
    The bytes are written into a new folder with a name of our own, and the folder is removed when the file has been read.
    Formats that need a native library are read in a child process, as everywhere in this package.
    """
    from electrovib.data.readers.registry import read_recorded
    from electrovib.data.traces import open_trace

    refuse_large(name, len(content))
    with tempfile.TemporaryDirectory(prefix="electrovib-") as folder:
        path = Path(folder) / f"upload{_suffix(name)}"
        path.write_bytes(content)
        try:
            trace = open_trace(path).load()
        except ElectrovibError:
            trace = None
        if trace is not None:
            return Uploaded(name, trace=_checked(trace))
        try:
            recorded = read_recorded(path)
        except ElectrovibError as error:
            raise InputError(str(error).replace(str(path), name)) from None
    if recorded.size * len(recorded.channels) > MOST_VALUES:
        raise InputError(
            f"{name}: {recorded.size} samples of {len(recorded.channels)} columns are more than a page reads."
        )
    return Uploaded(name, recorded=recorded)


def named(name: str, content: bytes, columns: Mapping[str, str], *, step: str = "") -> Uploaded:
    """Import a recording with the signals that a visitor has chosen for its columns.

    Parameters
    ----------
    name, content : str, bytes
        As for `read_upload`.
    columns : mapping of str to str
        Signal to the heading of its column, with a unit in brackets where the file states none.
    step : str
        Time between samples where the file has no time stamps.

    Returns
    -------
    Uploaded
        With a Trace.

    Raises
    ------
    InputError
        If a column or unit does not fit.
    """
    from electrovib.recordings.importing import import_file

    refuse_large(name, len(content))
    with tempfile.TemporaryDirectory(prefix="electrovib-") as folder:
        path = Path(folder) / f"upload{_suffix(name)}"
        path.write_bytes(content)
        try:
            return Uploaded(
                name, trace=_checked(import_file(path, dict(columns), step=step or None, title=name))
            )
        except ElectrovibError as error:
            raise InputError(str(error).replace(str(path), name)) from None


def read_uploaded_scenario(name: str, content: bytes) -> Scenario:
    """Read a scenario from the bytes of a TOML file, in which no file may be named.

    Raises
    ------
    InputError
        If it is too large, no TOML, names a file, or is no valid scenario.
    """
    refuse_large(name, len(content))
    try:
        tables: Any = read_toml(content.decode("utf-8"))
    except ValueError as error:
        raise InputError(f"{name}: not valid TOML: {error}") from None
    refuse_files(tables)
    return refuse_many_samples(read_scenario(tables))


def refuse_large(name: str, size: int) -> None:
    """Refuse a file of more than `LARGEST_UPLOAD` bytes."""
    if size > LARGEST_UPLOAD:
        raise InputError(
            f"{name}: {size / 1e6:.3g} MB; a page takes files of at most {LARGEST_UPLOAD / 1e6:g} MB."
        )


def _checked(trace: xarray.Dataset) -> xarray.Dataset:
    """Refuse a Trace that is no single recording over time or frequency."""
    if any(str(name) not in ("time", "frequency", "layer", "sample") for name in trace.dims):
        raise InputError("This is a sweep or a study; drop one recording.")
    if sum(int(each.size) for each in trace.data_vars.values()) > MOST_VALUES:
        raise InputError("This recording has more numbers than a page reads.")
    return trace


def _suffix(name: str) -> str:
    """Return the suffix of a name if it is one that a file may have: letters and digits only."""
    suffix = Path(name).suffix
    return suffix if suffix[1:].isalnum() and len(suffix) <= 8 and suffix.isascii() else ""
