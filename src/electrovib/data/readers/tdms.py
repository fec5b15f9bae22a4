"""NI TDMS (.tdms), read with npTDMS."""

from __future__ import annotations

import dataclasses
import logging
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.data.guarded import read_by_library
from electrovib.data.recorded import (
    ChannelClock,
    FileFormat,
    NotRead,
    begins,
    check_declared,
    recorded_of,
    text_of,
)

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from electrovib.data.recorded import Recorded

_PACKAGE: Final = "nptdms"
_UNITS: Final = ("unit_string", "NI_UnitDescription", "Unit", "unit")


def read_tdms(path: Path, *, part: str = "") -> Recorded:
    """Read the channels ``"group/channel"`` of a TDMS file that have the length with most numbers, or that of `part`.

    The times of waveforms count from the earliest start among all channels of the file.
    """
    found = read_by_library(lambda: dict(_channels(path)), path, "an NI TDMS file")
    others = [NotRead(name=name, why=why) for name, why in found.pop("not read", [])]
    origin = found.pop("first time", "")
    table = [(name, unit, values) for (_, name, unit, *_), values in found.items()]
    about = {"first_time": origin} if origin else {}
    recorded = recorded_of(table, attributes=about, part=part, not_read=others)
    stated = {name: ChannelClock(step=step, start=start) for _, name, _, step, start in found}
    evenly = {each.name: stated[each.name] for each in recorded.channels if each.name != recorded.time}
    first = next((each for each in evenly.values() if each.step is not None), ChannelClock())
    clocks = {name: each for name, each in evenly.items() if each != first}
    return dataclasses.replace(
        recorded,
        step=first.step,
        start=first.start,
        clocks={} if recorded.time else clocks,
    )


def _channels(path: Path) -> Iterator[tuple[Any, Any]]:
    """Yield number, name, unit, step and start, and the values, of each channel of numbers."""
    from nptdms import TdmsFile
    from nptdms.log import log_manager

    log_manager.set_level(logging.ERROR)  # it would warn on the terminal of a last segment that is not whole
    # the library leaves a damaged file that it opened itself open
    with path.open("rb") as opened, TdmsFile.open(opened) as file:
        all_channels = {
            f"{group.name}/{each.name}": each for group in file.groups() for each in group.channels()
        }
        why = {name: _not_numbers(each) for name, each in all_channels.items()}
        wanted = {name: each for name, each in all_channels.items() if not why[name]}
        check_declared(path, sum(map(len, wanted.values())))
        begins = [start for each in wanted.values() if (start := _start_time(each)) is not None]
        if begins:
            yield "first time", text_of(min(begins))
        yield "not read", [(name, reason) for name, reason in why.items() if reason]
        for at, (name, channel) in enumerate(wanted.items()):
            properties = channel.properties
            unit = next((text_of(properties[key]) for key in _UNITS if properties.get(key)), "")
            step, offset = properties.get("wf_increment"), properties.get("wf_start_offset", 0.0)
            even = isinstance(step, (int, float)) and np.isfinite(step) and step > 0
            begin = float(offset) if isinstance(offset, (int, float)) and np.isfinite(offset) else 0.0
            moment = _start_time(channel)
            begin += 0.0 if moment is None else float((moment - min(begins)) / np.timedelta64(1, "s"))
            values = np.asarray(channel[:])
            if values.dtype.kind == "M":  # stamps; those of waveforms have priority over them
                unit, values = "s", (values - values[0]) / np.timedelta64(1, "s")
            yield (at, name, unit, float(step) if even else None, begin), np.asarray(values, dtype=float)


def _not_numbers(channel: Any) -> str:
    """Say why a channel is no row of numbers; empty if it is one."""
    if not len(channel):
        return "it is empty"
    if channel.dtype is None or np.dtype(channel.dtype).kind not in "fiubM":
        return f"it holds {text_of(channel.dtype)}, not numbers"
    return ""


def _start_time(channel: Any) -> np.datetime64 | None:
    """Return when a waveform began; None if that is not stated."""
    start = channel.properties.get("wf_start_time")
    return start if isinstance(start, np.datetime64) and not np.isnat(start) else None


FORMAT: Final = FileFormat(
    name="tdms",
    description="NI TDMS (.tdms)",
    can_read=begins(b"TDSm", ".tdms"),
    read=read_tdms,
    options=("part",),
    package=_PACKAGE,
)
