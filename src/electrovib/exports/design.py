"""Files of a design: the scenario with the result in it, all numbers, or the drive as a waveform within limits."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final

from electrovib.core.errors import InputError
from electrovib.data.atomic import check_writable, write_text
from electrovib.data.marks import Form, unsigned
from electrovib.exports.waveform import check_waveform_file, export_waveform
from electrovib.exports.waveform_formats import FORMATS
from electrovib.scenario.toml import to_toml
from electrovib.studies.design.drive import DesignedDrive

if TYPE_CHECKING:
    from collections.abc import Iterable

    from electrovib.scenario import Scenario
    from electrovib.studies.design import Designed

FORMS: Final = {".toml": Form.SCENARIO, ".json": Form.DESIGN}
"""Suffix to form of the files that are no waveforms."""


def check_design_file(
    path: str | Path,
    *,
    edge: float | str | None = None,
    inputs: Iterable[Path] = (),
    force: bool = False,
) -> None:
    """Check before a computation that its result can be written."""
    place = Path(path)
    suffix = place.suffix.lower()
    if suffix not in FORMS and suffix not in FORMATS:
        known = ", ".join([*FORMS, *FORMATS])
        raise InputError(f"a design is written as {known}, not as '{suffix}'", path=place)
    if suffix in FORMATS:
        check_waveform_file(place, edge=edge, inputs=inputs, force=force)
    else:
        check_writable({place: FORMS[suffix]}, inputs=inputs, force=force)


def write_design(
    found: Designed,
    path: str | Path,
    *,
    edge: float | str | None = None,
    amplifier_present: bool = False,
    force: bool = False,
) -> list[str]:
    """Write the scenario with the result (``.toml``), all numbers (``.json``) or the drive as a waveform."""
    place = Path(path)
    check_design_file(place, edge=edge, force=force)
    suffix = place.suffix.lower()
    if suffix == ".json":
        write_text(place, found.content("design.json"), Form.DESIGN, force=force)
        return [f"written: {place}"]
    scenario = _scenario_of(found, place)
    if suffix == ".toml":
        text = f"# {unsigned(Form.SCENARIO)}\n{to_toml(scenario)}"
        write_text(place, text, Form.SCENARIO, force=force)
        return [f"written: {place}"]
    rate, notes = (found.rate, found.notes) if isinstance(found, DesignedDrive) else (None, ())
    written = export_waveform(
        scenario, place, limits=list(found.limits), force=force, rate=rate, remarks=notes, edge=edge,
        amplifier_present=amplifier_present,
    )  # fmt: skip
    return [*(each for each in written.notes if each not in notes), f"written: {written.path}"]


def _scenario_of(found: Designed, place: Path) -> Scenario:
    if found.scenario is None:
        raise InputError(
            "there is no result within the limits that could be written; nothing was written. All numbers are written as .json",
            path=place,
        )
    return found.scenario
