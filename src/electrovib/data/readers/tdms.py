"""NI TDMS (.tdms), read with npTDMS."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.data.guarded import Reader, read_guarded
from electrovib.data.recorded import FileFormat, begins, check_declared, recorded_of, text_of

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from electrovib.data.recorded import Recorded

_PACKAGE: Final = "nptdms"
_UNITS: Final = ("unit_string", "NI_UnitDescription", "Unit", "unit")


def read_tdms(path: Path, *, part: str = "") -> Recorded:
    """Read the channels ``"group/channel"`` of a TDMS file that have the length with most numbers, or that of `part`."""
    found = read_guarded(Reader(f"{__name__}:channels", (_PACKAGE, "numpy"), "an NI TDMS file"), path)
    table = [(name, unit, values) for (_, name, unit, *_), values in found.items()]
    recorded = recorded_of(path, table, part=part)
    used = [(step, start) for (*_, step, start), values in found.items() if values.size == recorded.size]
    if recorded.time or used[0][0] is None or len({step for step, _ in used}) > 1:
        return recorded
    return recorded_of(
        path, table, step=used[0][0], start=used[0][1], attributes=recorded.attributes, part=part
    )


def channels(path: Path) -> Iterator[tuple[Any, Any]]:
    """Yield number, name, unit, step and start, and the values, of each channel of numbers; called in a guarded process."""
    from nptdms import TdmsFile

    with TdmsFile.open(path) as file:
        wanted = [
            (f"{group.name}/{channel.name}", channel)
            for group in file.groups()
            for channel in group.channels()
            if len(channel) and channel.dtype is not None and np.dtype(channel.dtype).kind in "fiub"
        ]
        check_declared(path, sum(len(channel) for _, channel in wanted))
        for at, (name, channel) in enumerate(wanted):
            properties = channel.properties
            unit = next((text_of(properties[key]) for key in _UNITS if properties.get(key)), "")
            step, start = properties.get("wf_increment"), properties.get("wf_start_offset", 0.0)
            even = isinstance(step, (int, float)) and np.isfinite(step) and step > 0
            begin = float(start) if isinstance(start, (int, float)) and np.isfinite(start) else 0.0
            yield (at, name, unit, float(step) if even else None, begin), np.asarray(channel[:], dtype=float)


FORMAT: Final = FileFormat(
    name="tdms",
    description="NI TDMS (.tdms)",
    can_read=begins(b"TDSm", ".tdms"),
    read=read_tdms,
    options=("part",),
    package=_PACKAGE,
)
