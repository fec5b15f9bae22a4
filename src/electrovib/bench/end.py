"""What every end of a run does after 0 V: say how the bench was left, keep what was read, and only then make the Trace."""

from __future__ import annotations

import json
import os
import sys
import tempfile
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from electrovib.bench.faults import BenchError
from electrovib.bench.sequence import RunRecord
from electrovib.bench.trace import trace_of
from electrovib.core.errors import ElectrovibError, printable
from electrovib.export.save import save

if TYPE_CHECKING:
    from collections.abc import Mapping

    import xarray

    from electrovib.bench.plan import BenchPlan


def incomplete(path: Path) -> Path:
    """Return the file to which a run that is stopped writes what it has."""
    return path.with_name(f"{path.stem}.incomplete{path.suffix}")


def rehearse(plan: BenchPlan, output: Path | None, about: Mapping[str, str | int | float]) -> None:
    """Save readings of 0, so that all modules of the end are imported, and found to work, before anything is enabled."""
    record = RunRecord(burst="rehearsal", time=np.zeros(2))
    record.channels = {name: np.zeros(2) for name in plan.settings.channels()}
    with tempfile.TemporaryDirectory() as folder:
        place = None if output is None else Path(folder, f"rehearsal{output.suffix}")
        trace, why = saved(plan, record, about, output=place)
    if trace is None:
        raise BenchError(why)


def tell(sentences: list[str]) -> None:
    """Print sentences on the screen, which may be closed by now."""
    for sentence in sentences:
        with suppress(OSError, ValueError):
            print(f"electrovib: {printable(sentence)}", file=sys.stderr, flush=True)


def saved(
    plan: BenchPlan,
    record: RunRecord,
    about: Mapping[str, str | int | float],
    *,
    output: Path | None,
    force: bool = False,
    stopped: str = "",
) -> tuple[xarray.Dataset | None, list[str]]:
    """Keep what was read as it is, until it is saved as a Trace.

    The Trace is returned if it could be made and saved, and in words where the data are, or why not.
    `stopped` is why the run was stopped, empty for a complete one; the file is then that of `incomplete`.
    """
    if output is not None and stopped:
        output = incomplete(output)
    raw, sentences = (None, []) if output is None else _kept(record, output)
    written: list[Path] = []
    try:
        trace = trace_of(plan, record, about=about, stopped=stopped)
        if output is not None:
            written = save(trace, output, force=force)
    except Exception as error:  # noqa: BLE001  # what was read is kept, whatever fails
        return None, [f"the data could not be written as a Trace: {_reason(error)}", *sentences]
    _remove(raw)
    which = "the data so far" if stopped else "the data"
    return trace, [f"{which}: {', '.join(map(str, written))}"] if written else []


def _kept(record: RunRecord, output: Path) -> tuple[Path | None, list[str]]:
    """Write what was read as numbers and texts, beside the output; return the file, and where the data are or why not."""
    raw = None
    try:
        handle, name = tempfile.mkstemp(prefix=f"{output.stem}.raw.", suffix=".json", dir=output.parent)
        raw = Path(name)
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(json.dumps(asdict(record), default=np.ndarray.tolist))
    except Exception as error:  # noqa: BLE001  # the Trace is tried in any case
        _remove(raw)
        return None, [f"what was read could not be written either: {_reason(error)}"]
    return raw, [f"what was read is kept as it is: {raw}"]


def _remove(raw: Path | None) -> None:
    if raw is not None:
        with suppress(OSError):
            raw.unlink()


def _reason(error: Exception) -> str:
    return (
        "; ".join(error.problems)
        if isinstance(error, ElectrovibError)
        else f"{type(error).__name__}: {error}"
    )
