"""Import of a file of an instrument as a Trace: its clock, its calibrations, its signals or spectrum."""

from __future__ import annotations

import hashlib
import json
from concurrent.futures import ThreadPoolExecutor
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import DataFileError, InputError, gathered, nearest, refuse
from electrovib.core.files import note_input
from electrovib.core.signals import SIGNALS, make_trace
from electrovib.data.guarded import check_file
from electrovib.data.recorded import column_of
from electrovib.data.registry import format_of, read_recorded
from electrovib.data.spectrum import spectrum_of, split_part
from electrovib.data.unit_words import kind_and_factor
from electrovib.recordings.importing.choice import calibrated_column, check_names
from electrovib.recordings.importing.clock import SampleTimes, held, sample_times
from electrovib.recordings.importing.notices import (
    about_file,
    about_parts,
    about_samples,
    account_of,
    not_read_words,
)
from electrovib.recordings.importing.own_material import phase_offset
from electrovib.recordings.importing.reduction import ReductionSteps, reduced
from electrovib.recordings.recording import SensorCalibration, calibrate

if TYPE_CHECKING:
    from collections.abc import Mapping

    import xarray

    from electrovib.core.arrays import Real
    from electrovib.data.recorded import DataColumn, Recorded
    from electrovib.recordings.recording import SensorCalibration


_LONGEST_SETTINGS: Final = 4000


def import_file(
    path: str | Path,
    columns: Mapping[str, str] | None = None,
    *,
    time: str = "",
    step: str | float | None = None,
    stamps: str = "refuse",
    reader: str = "",
    delimiter: str | None = None,
    decimal_comma: bool | None = None,
    part: str | None = None,
    calibration: Mapping[str, str | Path] | None = None,
    title: str = "",
    **reduction: Any,
) -> xarray.Dataset:
    """Import a file of an instrument: its columns become signals of a Trace, in SI, with their history.

    Parameters
    ----------
    path : str or Path
        Any file that a reader takes.
    columns : mapping of str to str, optional
        Signal of the nomenclature to the heading of its column, with a unit where the file states none:
        ``{"lateral_force_measured": "Ch2 (N)"}``. Of an impedance spectrum: ``frequency``, ``modulus``, ``phase``, ``real``,
        ``imaginary`` and other meanings to the headings, or nothing.
    time : str
        Column of the time stamps, with a unit where the file states none; found if empty.
    step : str or float, optional
        Time between samples [s], if there are no time stamps.
    stamps : str
        Treatment of time stamps that do not increase: ``"refuse"`` or ``"keep_increasing"``.
    reader : str
        Name of the reader; found from the first bytes if empty.
    delimiter : str, optional
        Of text: one character, or empty for blanks; found if not given.
    decimal_comma : bool, optional
        Of text: whether decimals are written with a comma; found if not given.
    part : str, optional
        Sheet of a spreadsheet, table of a Gamry file, or array whose length is chosen where a file holds several.
    calibration : mapping of str to path, optional
        Signal to a table of two columns with units, the reading of its sensor and the known value; the line fitted to it is used
        as the scale, and its error goes with the signal, as a fit reads it.
    title : str
        Title of the Trace; the name of the file if empty.
    **reduction
        ``scale``, ``offset``, ``shift``, ``trigger``, ``baseline``, ``detrend``, ``crop``, ``average`` and ``resample``, as
        described for `electrovib.recordings.importing.reduction.ReductionSteps`, applied in this order.

    Returns
    -------
    xarray.Dataset
        Trace with the signals over ``time`` [s], or with ``impedance`` [ohm] over ``frequency`` [Hz]. Attributes ``file``,
        ``file_sha256``, ``reader``, ``options`` and ``history`` state its origin, ``columns_of_file`` every column that was
        read and everything that was not, with the reason, ``validity`` the diagnostics.

    Raises
    ------
    InputError
        If the file cannot be read, a column or unit is unknown, or an option does not fit; all mistakes of a kind at once.
    """
    place = Path(path)
    check_file(place)
    note_input(place)
    table, spectrum = split_part(part)
    options = {"delimiter": delimiter, "decimal_comma": decimal_comma, "part": table}
    with ThreadPoolExecutor(1) as beside:
        checksum = beside.submit(_checksum, place)
        recorded = read_recorded(place, reader=reader, **options)
    stated: dict[str, Any] = {
        name: value for name, value in (options | {"part": part}).items() if value is not None
    }
    stated |= {"columns": dict(columns or {}), "time": time, "step": step, "stamps": stamps}
    stated |= {"calibration": {name: str(each) for name, each in calibration.items()}} if calibration else {}
    origin = {
        "title": title or place.stem,
        "electrovib": version("electrovib"),
        "file": place.name,
        "file_sha256": checksum.result(),
        "reader": reader or format_of(place).name,
        "options": json.dumps(stated | reduction, default=repr),
        "columns_of_file": json.dumps(account_of(recorded)),
        "file_preamble": json.dumps(dict(recorded.attributes))[:_LONGEST_SETTINGS],
    }
    wanted = dict(columns or {})
    if is_spectrum(wanted):
        scale = _reduction(reduction).scale
        trace = spectrum_trace(recorded, wanted, origin, spectrum=spectrum, scale=scale)  # type: ignore[arg-type]  # no calibrations yet
        given = reduction | {"time": time, "step": step, "calibration": calibration}
        given |= {"scale": None, "stamps": stamps != "refuse"}
        refuse([f"{name}: has no effect on a spectrum; omit it" for name, value in given.items() if value])
        return trace
    steps = _reduction(
        reduction | _with_calibrations(calibration or {}, wanted, reduction.get("scale") or {})
    )
    if problems := _wrong_names(wanted, steps):
        raise InputError(problems)
    if spectrum:
        raise InputError(f"part = {part}: the columns are signals over time, not a spectrum")
    chosen = _chosen(recorded, wanted)
    names = [each.name for each in chosen.values()]
    clock = sample_times(recorded, names, time=time, step=step, stamps=stamps)
    return _over_time(recorded, chosen, clock, steps, origin)


def _checksum(path: Path) -> str:
    """Return the SHA-256 of a file, which is taken beside its reading."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _chosen(recorded: Recorded, wanted: Mapping[str, str]) -> dict[str, DataColumn]:
    """Return the column of each signal, or refuse all names that no column has."""
    chosen: dict[str, DataColumn] = {}
    problems: list[str] = []
    for signal, column in wanted.items():
        with gathered(problems):
            chosen[signal] = column_of(recorded, column, option=f"columns.{signal}")
    refuse(problems)
    return chosen


def _wrong_names(wanted: Mapping[str, str], steps: ReductionSteps) -> list[str]:
    """List the names that are no signals over time, or that no column was chosen for."""
    named = {option: getattr(steps, option) for option in ("scale", "offset", "shift", "baseline")}
    named |= {"detrend": steps.detrend, "trigger": [steps.trigger], "average": [steps.average]}
    problems = check_names("columns", wanted)
    for option, names in named.items():
        problems += check_names(option, [name for name in names if name], wanted)
    return problems


def _with_calibrations(
    files: Mapping[str, str | Path], columns: Mapping[str, str], scale: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the scales with the calibration lines of files."""
    problems = check_names("calibration", files, columns)
    problems += [
        f"calibration.{name}: a scale is given too; omit one of the two" for name in files if name in scale
    ]
    refuse(problems)
    lines = {name: read_calibration(name, place) for name, place in files.items()}
    return {"scale": dict(scale) | lines} if lines else {}


def is_spectrum(columns: Mapping[str, str]) -> bool:
    """Return whether the chosen columns are those of a spectrum, or none are chosen."""
    return not columns or "frequency" in columns or "angular_frequency" in columns


def _reduction(given: Mapping[str, Any]) -> ReductionSteps:
    known = ReductionSteps.__dataclass_fields__
    problems = [
        f"{name}: is not an option of import_file.{nearest(name, known)}"
        for name in given
        if name not in known
    ]
    refuse(problems)
    fitting = {name: value for name, value in given.items() if value is not None}
    if "detrend" in fitting:
        trends = fitting["detrend"]
        fitting["detrend"] = (trends,) if isinstance(trends, str) else tuple(trends)
    return ReductionSteps(**fitting)


def _over_time(
    recorded: Recorded,
    columns: Mapping[str, DataColumn],
    clock: SampleTimes,
    steps: ReductionSteps,
    origin: dict[str, str],
) -> xarray.Dataset:
    read = f"{origin['file']} read by reader '{origin['reader']}'"
    history = [read, *not_read_words(recorded), *clock.steps]
    signals: dict[str, Real] = {}
    readings: dict[str, Real] = {}
    problems: list[str] = []
    for signal, column in columns.items():
        with gathered(problems):
            values, words = calibrated_column(
                column, signal, scale=steps.scale.get(signal), offset=steps.offset.get(signal)
            )
            signals[signal], readings[signal] = values[clock.rows], column.values[clock.rows]
            history += words
    refuse(problems)
    judged = about_samples(clock.time, readings, held=clock.held)
    diagnostics = [*about_file(recorded), *clock.diagnostics, *judged]
    time, signals = held(clock.time, signals) if clock.held else (clock.time, signals)
    found, signals, words = reduced(time, signals, steps)
    trace = make_trace(
        {name: (("time",), values) for name, values in signals.items()},
        {"time": found},
        origin | {"history": "\n".join(history + words), "validity": _validity(diagnostics)},
    )
    for name, scale in steps.scale.items():
        if isinstance(scale, SensorCalibration):
            zero_known = name in {*steps.baseline, *steps.detrend}
            trace[name].attrs |= scale.error(zero_known=zero_known).attributes()
    return trace


def _validity(diagnostics: list[Diagnostic]) -> str:
    return json.dumps([each.to_dict() for each in diagnostics])


def spectrum_trace(
    recorded: Recorded,
    columns: Mapping[str, str],
    origin: Mapping[str, str],
    *,
    spectrum: int = 0,
    scale: Mapping[str, str | float] | None = None,
) -> xarray.Dataset:
    """Return a measured impedance over frequency, or a permittivity over ``frequency`` and one ``layer``, as a Trace."""
    try:
        found = spectrum_of(recorded, columns=columns, spectrum=spectrum, scale=scale)
    except InputError as error:
        if columns:
            raise
        listed = ", ".join(f"'{each.name}'" for each in recorded.channels[:20])
        raise InputError(
            f"columns: name a column for each signal, such as lateral_force_measured = '{recorded.channels[-1].name}'; the file"
            f" has {listed}. It is not recognised as a spectrum either: {error.problems[0].reason}",
            path=origin["file"],
        ) from None
    if found.times_area:
        raise InputError(
            "columns: the impedance is one times an area; its permittivity is imported with --as material, --set area=... and"
            " thickness=...",
            path=origin["file"],
        )
    diagnostics = about_parts(recorded, found)
    if found.lossless:
        text = "the table states a permittivity without loss; the loss was assumed to be 0"
        diagnostics.append(Diagnostic("loss", "unknown", text))
    if found.impedance is not None and (offset := phase_offset(found.frequency, found.impedance)):
        text = f"{offset.sentence()}: the instrument is badly calibrated"
        diagnostics.append(Diagnostic("calibration of the instrument", "warning", text))
    history = f"{origin['file']} read by reader '{origin['reader']}'\nspectrum: {found.read_as}; sorted by frequency"
    attributes = {**origin, "history": history, "validity": _validity(diagnostics)}
    if found.impedance is not None:
        return make_trace(
            {"impedance": (("frequency",), found.impedance)}, {"frequency": found.frequency}, attributes
        )
    assert found.permittivity is not None
    return make_trace(
        {"permittivity": (("layer", "frequency"), found.permittivity[None])},
        {"frequency": found.frequency, "layer": ["sample"]},
        attributes,
    )


def read_calibration(signal: str, path: str | Path) -> SensorCalibration:
    """Fit the calibration line of a sensor to a table of readings with their unit and known values, in this order."""
    place = Path(path)
    note_input(place)
    recorded = read_recorded(place)
    if len(recorded.channels) != 2:
        listed = ", ".join(f"'{each.name}'" for each in recorded.channels[:20])
        raise DataFileError(
            f"calibration.{signal}: expected two columns, the reading and the known value; the file has {listed}.",
            path=place,
        )
    known: list[Real] = []
    for each, target in zip(recorded.channels, ("", SIGNALS[signal].unit), strict=True):
        found = kind_and_factor(each.unit) if each.unit else None
        if found is None or (target and found[0] != target):
            what = f"a unit of {target}" if target else "a unit that is known"
            raise DataFileError(
                f"calibration.{signal}: column '{each.name}' needs {what} in its heading, such as 'F [{target or 'V'}]'; it has"
                f" '{each.unit}'.",
                path=place,
            )
        known.append(np.asarray(each.values * found[1]))
    try:
        return calibrate(known[0], known[1])
    except InputError as error:
        raise DataFileError(str(error.problems[0].reason), path=place) from None
