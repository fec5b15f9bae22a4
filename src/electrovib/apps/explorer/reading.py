"""A recording on the page: read in a process of its own with limits of memory and time, and parameters fitted to it."""

from __future__ import annotations

import json
import os
import tempfile
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeVar

import numpy as np

from electrovib.apps.explorer import runner
from electrovib.apps.explorer.runner import SERVER_ENDS, InterruptedWorkError, closed_at_end, interruptible
from electrovib.apps.explorer.state import refuse_files, refuse_many_samples
from electrovib.core.budget import budget
from electrovib.core.errors import ElectrovibError, InputError, printable
from electrovib.core.parsing import read_toml
from electrovib.core.signals import SIGNALS
from electrovib.data.guarded import GuardedReading, Reader, ReaderLimits
from electrovib.data.recorded import ChannelClock, DataColumn, NotRead, Recorded
from electrovib.scenario import Scenario, read_scenario

if TYPE_CHECKING:
    import xarray

    from electrovib.view.fitted import FitResult

R = TypeVar("R")
LIMITS: Final = ReaderLimits(
    memory=600_000_000, content=16 * runner.MOST_VALUES + 4_000_000, processor_time=10.0, waiting_time=60.0
)
"""Of the process that reads a file; the processes of native formats that it starts have no higher ones."""
_READER: Final = Reader(
    f"{__name__}:contents",
    ("numpy", "xarray", "electrovib.data.traces", "electrovib.recordings.importing.import_file"),
    "a recording",
)
_TOML_LIMITS: Final = ReaderLimits(
    memory=200_000_000, content=20_000_000, processor_time=5.0, waiting_time=30.0
)
_TOML_READER: Final = Reader(f"{__name__}:tables", ("electrovib.core.parsing",), "a TOML file")
_FOLDERS: Final = ("HOME", "TMPDIR", "XDG_CACHE_HOME", "XDG_CONFIG_HOME", "MPLCONFIGDIR")
"""Settings that state where a library may keep files."""
_PLAIN: Final = "fiucb"
"""Kinds of arrays that are handed over as bytes."""
_DIMENSIONS: Final = ("time", "frequency", "layer", "sample")
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


def read_upload(
    name: str, content: bytes, columns: Mapping[str, str] | None = None, **options: Any
) -> Uploaded:
    """Read a recording from the bytes of a file, of whose name only the suffix is used.

    `columns` are the signals that a visitor has chosen for the columns, as in `read_apart`, with its options.
    """
    name = shown_name(name)
    found = _through_a_file(
        name, content, runner.LARGEST_UPLOAD, lambda path: read_apart(path, columns, title=name, **options)
    )
    return Uploaded(name, found) if isinstance(found, Recorded) else Uploaded(name, trace=found)


def read_uploaded_scenario(name: str, content: bytes) -> Scenario:
    """Read a scenario from the bytes of a TOML file, in which no file may be named."""
    name = shown_name(name)
    tables: Any = _through_a_file(name, content, runner.LARGEST_SCENARIO, read_tables_apart)
    refuse_files(tables)
    scenario = refuse_many_samples(read_scenario(tables))
    if (count := len(list(scenario.parameters()))) > runner.MOST_PARAMETERS:
        raise InputError(
            f"{name}: {count} parameters; a page shows scenarios of at most {runner.MOST_PARAMETERS}."
        )
    return scenario


def _through_a_file(name: str, content: bytes, most: int, read: Callable[[Path], R]) -> R:
    """Write at most some bytes into a file with a name of our own, in a new folder that is removed when it was read."""
    if len(content) > most:
        raise InputError(
            f"{name}: {len(content) / 1e6:.3g} MB; a page takes such files of at most {most / 1e6:g} MB."
        )
    suffix = Path(name).suffix
    is_plain = suffix[1:].isalnum() and len(suffix) <= 8 and suffix.isascii()
    with tempfile.TemporaryDirectory(prefix="electrovib-") as folder:
        path = Path(folder) / f"upload{suffix if is_plain else ''}"
        path.write_bytes(content)
        try:
            return read(path)
        except ElectrovibError as error:
            text = str(error).replace(str(path), name)
            raise InputError(text if name in text else f"{name}: {text}") from None


def shown_name(name: str) -> str:
    """Return the name of a file as it is shown: a line of at most `LONGEST_NAME` letters, with its suffix."""
    plain, most = printable(name.replace("\\", "/").rpartition("/")[2]) or "the file", runner.LONGEST_NAME
    return plain if len(plain) <= most else f"{plain[: most - 20]}...{plain[-17:]}"


def read_apart(
    path: Path, columns: Mapping[str, str] | None = None, **options: Any
) -> xarray.Dataset | Recorded:
    """Read a recording in a process of its own: a Trace if the file names its signals or `columns` do, else its columns.

    `columns` is signal to the heading of its column, with a unit in brackets where the file states none; options
    are ``step`` and ``scale`` of `electrovib.import_file` and a ``title``, of which an empty one is not stated. A file
    that no reader takes, that is damaged or too large, or that takes too much time or memory, is refused.
    """
    wanted = dict(columns) if columns else None
    return _unpacked(_read_by(_READER, path, LIMITS, columns=wanted, options=options))


def read_tables_apart(path: Path) -> Any:
    """Read a TOML file in a process of its own, as some short texts take the parser minutes.

    Its dates and times become texts. A text that is not valid, nested too deeply, or takes too much time or
    memory is refused.
    """
    return _read_by(_TOML_READER, path, _TOML_LIMITS)["tables"]


def _read_by(reader: Reader, path: Path, most: ReaderLimits, **arguments: Any) -> dict[str, Any]:
    with GuardedReading(reader, path, limits=most, **arguments) as reading, closed_at_end(reading.stop):
        return reading.content()


def contents(
    path: Path, *, columns: Mapping[str, str] | None, options: Mapping[str, Any]
) -> Iterator[tuple[str, Any]]:
    """Yield the parts of a recording; called in the process of its own."""
    _limit_children_and_files(path.parent)
    found = read_here(path, columns, **options)
    yield from _packed_columns(found) if isinstance(found, Recorded) else _packed_trace(found)


def tables(path: Path) -> Iterator[tuple[str, Any]]:
    """Yield the tables of a TOML file; called in the process of its own."""
    _limit_children_and_files(path.parent)
    yield "tables", read_tables_here(path)


def _limit_children_and_files(folder: Path) -> None:
    """Let no process that is started from here have more memory than this one, and let none write into a file.

    Libraries that keep a cache get a folder that is removed with the file that is read.
    """
    os.environ.update(dict.fromkeys(_FOLDERS, str(folder)))
    try:
        import resource
    except ImportError:  # no such limits here
        return
    memory = resource.getrlimit(resource.RLIMIT_AS)[0]
    resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))


def read_tables_here(path: Path) -> Any:
    """Read a TOML file in this process; as `read_tables_apart`."""
    try:
        return json.loads(json.dumps(read_toml(path.read_text(encoding="utf-8")), default=str))
    except ValueError as error:
        raise InputError(f"not valid TOML: {error}") from None


def read_here(
    path: Path, columns: Mapping[str, str] | None = None, **options: Any
) -> xarray.Dataset | Recorded:
    """Read a recording in this process; as `read_apart`."""
    from electrovib.data.registry import read_recorded
    from electrovib.data.traces import open_trace
    from electrovib.recordings.importing.import_file import import_file

    if columns is not None:
        given = {name: value for name, value in options.items() if value}
        titled = {"title": given.pop("title")} if "title" in given else {}
        return _checked_trace(import_file(path, dict(columns), **given).assign_attrs(titled))
    try:
        trace = open_trace(path).load()
    except ElectrovibError:
        _refuse_long_lines(path)
        return _checked_columns(read_recorded(path))
    return _checked_trace(trace)


def _refuse_long_lines(path: Path) -> None:
    """Refuse a text with lines that are longer than a row of the columns that a page offers."""
    from electrovib.data.registry import format_of

    if format_of(path).name != "text":
        return
    ends = np.flatnonzero(np.frombuffer(path.read_bytes() + b"\n", np.uint8) == ord("\n"))
    if (longest := int(np.diff(ends, prepend=-1).max())) > runner.LONGEST_LINE:
        raise InputError(
            f"This file has a line of {longest} letters; a recording has a row of at most {runner.LONGEST_LINE} per sample."
        )


def _checked_trace(trace: xarray.Dataset) -> xarray.Dataset:
    """Refuse a Trace that is no single recording over time or frequency."""
    if any(str(name) not in _DIMENSIONS for name in trace.dims):
        raise InputError("This is a sweep or a study; drop one recording.")
    if sum(int(each.size) for each in trace.variables.values()) > runner.MOST_VALUES:
        raise InputError("This recording has more numbers than a page reads.")
    return trace


def _checked_columns(recorded: Recorded) -> Recorded:
    """Refuse columns that are more, or have longer names, than a page offers."""
    count = len(recorded.channels)
    if recorded.size * count > runner.MOST_VALUES or count > runner.MOST_COLUMNS:
        raise InputError(
            f"This file has {recorded.size} samples of {count} columns, which are more than a page reads: at most"
            f" {runner.MOST_COLUMNS} columns and {runner.MOST_VALUES} numbers."
        )
    for each in recorded.channels:
        if max(len(each.name), len(each.unit)) > runner.LONGEST_NAME:
            raise InputError(
                f"The heading '{each.name[:40]}...' has {len(each.name)} letters; at most {runner.LONGEST_NAME} are read."
            )
    return recorded


def _packed_trace(trace: xarray.Dataset) -> Iterator[tuple[str, Any]]:
    described = trace.to_dict(data=False)
    for name, each in (described["coords"] | described["data_vars"]).items():
        values = trace[name].values
        if values.dtype.kind in _PLAIN:
            yield f"values of {name}", values
        else:
            each["data"] = values.tolist()
    yield "trace", described


def _packed_columns(recorded: Recorded) -> Iterator[tuple[str, Any]]:
    for number, each in enumerate(recorded.channels):
        yield f"values of {number}", np.asarray(each.values)
    channels = [(each.name, each.unit) for each in recorded.channels]
    attributes = {str(key): str(value) for key, value in recorded.attributes.items()}
    others = [vars(each) for each in recorded.not_read]
    clocks = {name: vars(each) for name, each in recorded.clocks.items()}
    stated = {"channels": channels, "attributes": attributes, "not_read": others, "clocks": clocks}
    yield "columns", {**vars(recorded), **stated}


def _unpacked(parts: Mapping[str, Any]) -> xarray.Dataset | Recorded:
    if described := parts.get("columns"):
        channels = tuple(
            DataColumn(name=name, unit=unit, values=parts[f"values of {number}"])
            for number, (name, unit) in enumerate(described["channels"])
        )
        others = tuple(NotRead(**each) for each in described["not_read"])
        clocks = {name: ChannelClock(**each) for name, each in described["clocks"].items()}
        return Recorded(**{**described, "channels": channels, "not_read": others, "clocks": clocks})
    import xarray

    described = parts["trace"]
    for name, each in (described["coords"] | described["data_vars"]).items():
        each.setdefault("data", parts.get(f"values of {name}"))
    return xarray.Dataset.from_dict(described)


MOST_FREE: Final = 6
"""Parameters that a page fits at once."""
LONGEST_FIT: Final = 120.0
"""Seconds after which a fit is ended."""
_WITHOUT_EFFECT: Final = frozenset({"perception", "limits", "time", "frequency"})
"""Sections whose parameters change no signal."""


def fittable(scenario: Scenario) -> list[str]:
    """Return the paths of the parameters that a page offers to fit: those with a value that changes a signal."""
    from electrovib.apps.explorer.controls import controls

    found = (each for each in controls(scenario) if each.value is not None)
    return [each.path for each in found if each.section not in _WITHOUT_EFFECT]


@dataclass
class RunningFit:
    """A fit that runs in a thread, can be observed, and can be cancelled.

    `free` are the dotted paths of the unknown parameters; `evaluations` counts the predictions so far, and
    `squares` is the weighted sum of squares of the last one.
    """

    scenario: Scenario
    measured: xarray.Dataset
    free: Sequence[str]
    evaluations: int = 0
    squares: float = float("nan")
    _cancelled: threading.Event = field(default_factory=threading.Event)

    def __post_init__(self) -> None:
        """Refuse what a page does not fit."""
        if not 1 <= len(self.free) <= MOST_FREE:
            raise InputError(
                f"{len(self.free)} parameters are chosen; a page fits one to {MOST_FREE} at once."
            )

    @property
    def progress(self) -> str:
        """What is known while the fit runs, in words."""
        return f"{self.evaluations} evaluations, sum of squares {self.squares:.4g}"

    def cancel(self) -> None:
        """End the fit at its next evaluation."""
        self._cancelled.set()

    def run(self) -> FitResult:
        """Fit the parameters to the recording, as `electrovib.fit`.

        An error is raised if the fit was cancelled, takes too long, or does not find the parameters.
        """
        from time import monotonic

        from electrovib.apps.fit import fit

        end = monotonic() + LONGEST_FIT

        def is_over() -> bool:
            return self._cancelled.is_set() or SERVER_ENDS.is_set() or monotonic() > end

        def progress(evaluations: int, squares: float) -> bool:
            self.evaluations, self.squares = evaluations, squares
            return is_over()

        try:
            with budget(time=runner.LONGEST_RUN, memory=runner.LARGEST_RUN), interruptible(is_over):
                return fit(self.scenario, self.measured, free=self.free, progress=progress)
        except (ElectrovibError, InterruptedWorkError):
            if not is_over():
                raise
            late = f"The fit was ended after {LONGEST_FIT:g} s; free fewer parameters."
            raise InputError("The fit was cancelled." if self._cancelled.is_set() else late) from None
