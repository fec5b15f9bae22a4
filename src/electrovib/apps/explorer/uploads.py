"""Files that a visitor drops on the page: recordings to compare with, and scenarios."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeVar

from electrovib.apps.explorer.limits import (
    LARGEST_SCENARIO,
    LARGEST_UPLOAD,
    LONGEST_NAME,
    MOST_PARAMETERS,
)
from electrovib.apps.explorer.reading import read_apart, read_tables_apart
from electrovib.apps.explorer.state import refuse_files, refuse_many_samples
from electrovib.core.errors import ElectrovibError, InputError, printable
from electrovib.core.signals import SIGNALS
from electrovib.data.recorded import Recorded
from electrovib.scenario import Scenario, read_scenario

if TYPE_CHECKING:
    import xarray

R = TypeVar("R")
SCENARIO_SUFFIX: Final = ".toml"
OVER_TIME: Final = tuple(name for name, each in SIGNALS.items() if each.dims == ("time",))
"""Signals that a column of a recording can be."""


@dataclass(frozen=True)
class Uploaded:
    """A file that was read, with its `recorded` columns where it is not yet known which signals they are, else its `trace`.

    The name is as the visitor's machine calls it, and used in texts only.
    """

    name: str
    recorded: Recorded | None = None
    trace: xarray.Dataset | None = None


def read_upload(name: str, content: bytes) -> Uploaded:
    """Read a recording from the bytes of a file, of whose name only the suffix is used.

    The bytes are written into a new folder with a name of our own, and the folder is removed when the file
    has been read. They are read in a process of their own with limited memory and time, whatever their
    format.
    """
    name = shown_name(name)
    found = _read(name, content)
    if isinstance(found, Recorded):
        return Uploaded(name, recorded=found)
    return Uploaded(name, trace=found)


def named(name: str, content: bytes, columns: Mapping[str, str], **options: Any) -> Uploaded:
    """Import a recording with the signals that a visitor has chosen for its columns.

    `columns` is signal to the heading of its column, with a unit in brackets where the file states none.
    Options are ``step``, the time between samples where the file has no time stamps, and ``scale``, signals
    to the sensitivities of their sensors, such as ``"1.5 N/V"``.
    """
    name = shown_name(name)
    found = _read(name, content, columns, **options)
    assert not isinstance(found, Recorded)
    return Uploaded(name, trace=found)


def _read(
    name: str,
    content: bytes,
    columns: Mapping[str, str] | None = None,
    **options: Any,
) -> xarray.Dataset | Recorded:
    """Read a recording through a file in a folder of its own."""
    refuse_large(name, len(content))
    return _through_a_file(name, content, lambda path: read_apart(path, columns, title=name, **options))


def _through_a_file(name: str, content: bytes, read: Callable[[Path], R]) -> R:
    """Write the bytes into a folder of their own, which is removed when they have been read."""
    with tempfile.TemporaryDirectory(prefix="electrovib-") as folder:
        path = Path(folder) / f"upload{_suffix(name)}"
        path.write_bytes(content)
        try:
            return read(path)
        except ElectrovibError as error:
            text = str(error).replace(str(path), name)
            raise InputError(text if name in text else f"{name}: {text}") from None


def read_uploaded_scenario(name: str, content: bytes) -> Scenario:
    """Read a scenario from the bytes of a TOML file, in which no file may be named."""
    name = shown_name(name)
    refuse_large(name, len(content), most=LARGEST_SCENARIO)
    tables: Any = _through_a_file(name, content, read_tables_apart)
    refuse_files(tables)
    scenario = refuse_many_samples(read_scenario(tables))
    if (count := len(list(scenario.parameters()))) > MOST_PARAMETERS:
        raise InputError(f"{name}: {count} parameters; a page shows scenarios of at most {MOST_PARAMETERS}.")
    return scenario


def refuse_large(name: str, size: int, *, most: int = LARGEST_UPLOAD) -> None:
    """Refuse a file of more bytes than are read."""
    if size > most:
        raise InputError(
            f"{name}: {size / 1e6:.3g} MB; a page takes such files of at most {most / 1e6:g} MB."
        )


def shown_name(name: str) -> str:
    """Return the name of a file as it is shown: a line of at most `LONGEST_NAME` letters, with its suffix."""
    plain = printable(name.replace("\\", "/").rpartition("/")[2]) or "the file"
    return plain if len(plain) <= LONGEST_NAME else f"{plain[: LONGEST_NAME - 20]}...{plain[-17:]}"


def _suffix(name: str) -> str:
    """Return the suffix of a name if it is one that a file may have: letters and digits only."""
    suffix = Path(name).suffix
    return suffix if suffix[1:].isalnum() and len(suffix) <= 8 and suffix.isascii() else ""
