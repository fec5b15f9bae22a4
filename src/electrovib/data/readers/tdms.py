"""NI TDMS (.tdms), read with npTDMS."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.data.file_format import FileFormat, begins
from electrovib.data.guarded import Reader, read_guarded
from electrovib.data.recorded import check_declared, check_package, recorded_of, text_of

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from electrovib.data.recorded import Recorded

_PACKAGE: Final = "nptdms"
_UNITS: Final = ("unit_string", "NI_UnitDescription", "Unit", "unit")


def read_tdms(path: Path, *, part: str = "") -> Recorded:
    """Read the channels ``"group/channel"`` of a TDMS file that have the length with most numbers, or that of `part`."""
    check_package(path, _PACKAGE, "NI TDMS")
    found = read_guarded(Reader(f"{__name__}:channels", (_PACKAGE, "numpy"), "an NI TDMS file"), path)
    table, steps = [], []
    for at in range(len(found) // 2):
        name, unit, step, start = found[f"about {at}"]
        table.append((name, unit, np.asarray(found[f"values {at}"], dtype=float)))
        steps.append((step, start))
    recorded = recorded_of(path, table, part=part)
    used = [steps[at] for at, (_, _, values) in enumerate(table) if values.size == recorded.size]
    if recorded.time or used[0][0] is None or len({step for step, _ in used}) > 1:
        return recorded
    return recorded_of(
        path, table, step=used[0][0], start=used[0][1], attributes=recorded.attributes, part=part
    )


def channels(path: Path) -> Iterator[tuple[str, Any]]:
    """Yield name, unit, step and start, then values, of each channel of numbers; called in a guarded process."""
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
            yield f"about {at}", [name, unit, float(step) if even else None, begin]
            yield f"values {at}", np.asarray(channel[:], dtype=float)


FORMAT: Final = FileFormat(
    name="tdms",
    description="NI TDMS (.tdms)",
    suffixes=(".tdms",),
    can_read=begins(b"TDSm", ".tdms"),
    read=read_tdms,
    options=("part",),
    package=_PACKAGE,
)
