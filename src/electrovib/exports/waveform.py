"""Write the drive of a scenario as a waveform, within declared limits or not at all."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.answer import Answer, Curve, Document, Panel
from electrovib.core.deprecation import former_value
from electrovib.core.diagnostics import Diagnostic, warning_lines
from electrovib.core.errors import InputError, Problem, nearest, suggestion
from electrovib.core.files import inputs_noted
from electrovib.core.units import format_quantity
from electrovib.data.atomic import check_writable, output_path, writing
from electrovib.exports.waveform_formats import (
    INSTRUMENTS,
    WAVEFORM_FORMATS,
    Encoded,
    Scaling,
    WaveformFormat,
)
from electrovib.scenario import Scenario, Source, TimeGrid, read_scenario
from electrovib.studies import check as checks
from electrovib.studies.check.result import shown
from electrovib.studies.waveform import LARGEST_ERROR, MOST_POINTS, refuse_unless_zero_at_both_ends, waveform

if TYPE_CHECKING:
    from electrovib.studies.check import CheckResult, LimitsSource
    from electrovib.studies.waveform import Waveform


@dataclass(frozen=True, kw_only=True, repr=False)
class WrittenWaveform(Answer):
    """A waveform that was written, with its error, its scale and its check.

    - `path`: the file.
    - `waveform`: its samples as the file holds them, with the largest error.
    - `full_scale`: voltage of the drive at full scale [V]; None for a format without one.
    - `notes`: what the file is, and how to play it.
    - `check`: comparison of the samples of the file with the limits.
    """

    path: Path
    waveform: Waveform
    full_scale: float | None
    notes: tuple[str, ...]
    check: CheckResult

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """Diagnostics of the scenario under these samples, beyond those that the check states; the file states them too."""
        return self.check.diagnostics

    @property
    def document(self) -> Document:
        """Its notes, the limits that it was compared with, and its samples."""
        held = [
            f"{row.quantity} {shown(row.value, row.unit)}, limit {shown(row.limit, row.unit)}: {row.source}"
            for row in self.check.rows
            if row.limit is not None
        ]
        wave = self.waveform
        times, voltages = wave.times, wave.voltages
        if wave.held:
            times = np.append(np.repeat(times, 2)[1:], times[-1] + 1 / wave.rate)
            voltages = np.repeat(voltages, 2)
        figure = Panel(
            id="waveform", title="The waveform", caption=f"The samples as the file holds them, {wave.between}.",
            x=("time", "s"), y=("voltage", "V"), curves=(Curve(label=self.path.name, x=times, y=voltages),),
        )  # fmt: skip
        return Document(
            title=f"Waveform {self.path.name}",
            sentences=[*self.notes, *held],
            diagnostics=self.diagnostics,
            figures=[figure],
            remarks=[f"written: {self.path}"],
        )


def export_waveform(
    scenario: Source,
    path: str | Path,
    *,
    set: Mapping[str, Any] | None = None,  # noqa: A002 - the name of the option
    limits: LimitsSource | Sequence[LimitsSource] = None,
    instrument: str = "",
    rate: float | None = None,
    ramp: float | None = None,
    scaling: Scaling | None = None,
    edge: float | str | None = None,
    force: bool = False,
) -> WrittenWaveform:
    """Write the drive of a scenario as a waveform, within its limits or not at all.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        As for `electrovib.load`.
    path : str or Path
        The output: ``.csv``, ``.npy``, ``.mat``, ``.wav`` or ``.pwl``; of an instrument ``.csv``.
    set : mapping of str to value, optional
        Dotted path to value, put into the scenario.
    limits : as for `electrovib.check`
        Further limits; the largest voltage and the largest current have to be declared, here or in the scenario.
    instrument : str
        ``"hp_33120a"`` for a table of the codes of that generator.
    rate : float, optional
        Samples per second [Hz]; chosen if absent.
    ramp : float, optional
        Duration of a linear ramp from 0 V and to 0 V by which the drive is multiplied at either end [s]; none if absent, and
        then the drive itself has to begin and end at 0 V.
    scaling : Scaling, optional
        Voltage of the drive at full scale, of ``.wav`` and of an instrument, and over that of the instrument.
    edge : float or str, optional
        How what plays the samples passes from one to the next: ``"line"`` for straight lines, or the height of a step over its
        steepest slope [s] for an output that holds each sample; one pole at the frequency f has 1/(2 pi f). An instrument
        holds its samples, by steps unless an edge is declared; those of ``.pwl`` are joined by straight lines; for every other
        file it has to be given.
    force : bool
        Whether a file that was not written by electrovib may be replaced.

    Returns
    -------
    WrittenWaveform
        The file, with the largest error between the drive and what is played.

    Raises
    ------
    InputError
        Unless the limits are declared and held by the drive and by the samples as written, the error is at most 1 % of the
        largest voltage, what an instrument plays begins and ends at 0 V, and the file can be written. Nothing is clipped.

    Notes
    -----
    Bandwidth and limits of the scenario's amplifier count in the current only where ``circuit.amplifier.hardware`` names the
    amplifier that stands before the plate.

    Examples
    --------
    >>> limits = {"limits.voltage": "1 kV", "limits.current": "10 mA"}
    >>> found = ev.export_waveform("bau_2010/sine", "drive.csv", edge="line", ramp="1 ms", set=limits)
    >>> repr(found).splitlines()[1]
    '801 samples at 20 kHz; CSV, straight lines between the samples'
    """
    scale = {name: former_value(name, value) for name, value in vars(scaling or Scaling()).items()}
    return write_waveform(
        scenario, path, set=set, limits=limits, instrument=instrument, rate=rate, ramp=ramp,
        scaling=Scaling(**scale), edge=edge, force=force, remarks=former_value("remarks", ()),
    )  # fmt: skip


def write_waveform(
    scenario: Source,
    path: str | Path,
    *,
    set: Mapping[str, Any] | None = None,  # noqa: A002 - the name of the option
    limits: LimitsSource | Sequence[LimitsSource] = None,
    instrument: str = "",
    rate: float | None = None,
    ramp: float | None = None,
    scaling: Scaling | None = None,
    edge: float | str | None = None,
    force: bool = False,
    remarks: Sequence[str] = (),
) -> WrittenWaveform:
    """Write the drive of a scenario as `export_waveform` does, with further sentences about it in the file."""
    place = output_path(path)
    form = _format(place, instrument)
    with inputs_noted() as inputs:
        found = read_scenario(scenario, changes=set)
        declared = checks.declared_limits(found, limits)
    check_writable({place: form.form}, inputs=inputs, force=force)
    checks.refuse_unlimited(declared, what=f"{form.name} of a drive")
    played = Playing.declared(found, form, edge=edge)
    largest_error = float(former_value("largest_error", LARGEST_ERROR))
    wave = sampled_drive(found, form, rate=rate, largest_error=largest_error, ramp=ramp, held=played.held)
    encoded = form.encode(wave, scaling or Scaling())
    wave = _rounded(found, wave, encoded, ramp)
    wave.refuse_above(largest_error)
    if ramp is None and not played.held:
        played.clear_drive(form.name, limits=limits)
    check = played.cleared(wave, form.name, limits=limits)
    end, edges = float(found.time.times(found.drive)[-1]), ramp or 0.0
    checks.refuse_demanded(found, declared["voltage"], end - edges, "Nothing was written", start=edges)
    ramps = []
    if ramp is not None:
        ramps = [f"the drive is multiplied by linear ramps of {format_quantity(ramp, 's')} at either end"]
    doubts = checks.not_shown(check.rows)
    notes = (*about(found, wave, form), *remarks, *ramps, *played.notes, *encoded.notes, *doubts)
    with writing({place: form.form}, force=force) as temporaries:
        temporaries[place].write_bytes(form.content(encoded, (*notes, *warning_lines(check.diagnostics))))
    return WrittenWaveform(path=place, waveform=wave, full_scale=encoded.full_scale, notes=notes, check=check)


def check_waveform_file(
    path: str | Path,
    *,
    edge: float | str | None = None,
    inputs: Iterable[Path] = (),
    force: bool = False,
) -> None:
    """Check, before a long computation, whether a waveform can be written to a file."""
    place = output_path(path)
    form = _format(place, "")
    refuse_unsuited(form, edge)
    check_writable({place: form.form}, inputs=inputs, force=force)


def sampled_drive(
    scenario: Scenario,
    form: WaveformFormat,
    *,
    rate: float | None,
    largest_error: float,
    ramp: float | None = None,
    held: bool = False,
) -> Waveform:
    """Sample the drive of a scenario for a format, not yet rounded to what the format can hold."""
    drive, end = scenario.drive, float(scenario.time.times(scenario.drive)[-1])
    if drive.quantity == "voltage" and form.played and ramp is None:
        refuse_unless_zero_at_both_ends(drive, end)
    if rate is not None and form.whole_rate and math.isfinite(rate) and rate != round(rate):
        raise InputError(
            f"{form.name} has a whole number of samples per second", path="rate", value=f"{rate:g}"
        )
    wave = waveform(
        drive, end=end, rate=rate, rates=form.rates or None, held=held, largest_error=largest_error,
        most_points=form.most_points or MOST_POINTS, ramp=ramp,
    )  # fmt: skip
    if len(wave.times) < form.fewest_points:
        why = f"{len(wave.times)} samples are fewer than the {form.fewest_points} of {form.name}; take a higher rate"
        raise InputError(why, path="rate", value=f"{wave.rate:g}")
    return wave


def about(scenario: Scenario, wave: Waveform, form: WaveformFormat) -> tuple[str, ...]:
    """Return what a file of a waveform states about itself: title, number of samples and error."""
    title = " ".join(scenario.titled().split()) or "a scenario without a title"
    amplified = (
        " at the input of its amplifier" if scenario.circuit.amplifier is not None else " at the plate"
    )
    return (
        f"drive of: {title}; voltage{amplified}",
        f"{len(wave.times)} samples at {format_quantity(wave.rate, 'Hz', digits=9)}; {form.name}, {wave.between}",
        f"largest difference from the drive {format_quantity(wave.error, 'V', digits=3)}, {100 * wave.share:.3g} % of its largest"
        f" voltage {format_quantity(wave.peak, 'V', digits=6)}",
    )


def _rounded(scenario: Scenario, wave: Waveform, encoded: Encoded, ramp: float | None) -> Waveform:
    """Return the waveform with the voltages that the file holds, and their error."""
    if ramp is None:
        return wave.with_voltages(
            encoded.voltages, scenario.drive, float(scenario.time.times(scenario.drive)[-1])
        )
    off = float(np.max(np.abs(encoded.voltages - wave.voltages)))
    return replace(wave, voltages=encoded.voltages, error=wave.error + off)


def _format(path: Path, instrument: str) -> WaveformFormat:
    suffix = path.suffix.lower()
    if not instrument:
        if suffix not in WAVEFORM_FORMATS:
            near = suggestion(suffix, WAVEFORM_FORMATS) if suffix else ""
            why = f"a waveform is written as {', '.join(WAVEFORM_FORMATS)}, not as '{path.suffix}'.{near}"
            raise InputError(why, path=path)
        return WAVEFORM_FORMATS[suffix]
    if instrument not in INSTRUMENTS:
        why = f"no such instrument.{nearest(instrument, INSTRUMENTS)}"
        raise InputError(Problem(why, path="--instrument", value=instrument))
    if suffix != ".csv":
        raise InputError(f"a waveform of {instrument} is written as .csv, not as '{path.suffix}'.", path=path)
    return INSTRUMENTS[instrument]


_LINE: Final = "line"
"""Edge of a player that joins samples by straight lines."""
_DECLARE: Final = "Declare the edge that the output has: --edge TIME, such as --edge 10us"
_NOT_PRESENT: Final = (
    "Bandwidth, saturation and current limit of circuit.amplifier count in the current only where this very amplifier stands"
    " before the plate: declare its maker and model as circuit.amplifier.hardware, such as 'Trek 609E-6'"
)


@dataclass(frozen=True, kw_only=True)
class Playing:
    """What is declared of the output that plays a file, without an amplifier that is only assumed.

    `edge` is the height of a step between held samples over its steepest slope [s]; None for steps.
    """

    held: bool
    edge: float | None
    scenario: Scenario
    is_assumed: bool

    @classmethod
    def declared(cls, scenario: Scenario, form: WaveformFormat, *, edge: float | str | None) -> Playing:
        """Read the declarations of an export, or refuse those that do not suit the format."""
        refuse_unsuited(form, edge)
        amplifier = scenario.circuit.amplifier
        if amplifier is not None and (fault := amplifier.hardware_fault):
            why = (
                f"{fault}. Its limits count only where it stands before the plate: give maker and model number, such as"
                " 'Trek 609E-6', or leave hardware out. Nothing was written"
            )
            raise InputError(why, path="circuit.amplifier.hardware", value=amplifier.hardware)
        is_named = amplifier is not None and bool(amplifier.hardware)
        is_present = is_named or former_value("amplifier_present", otherwise=False) is True
        relied_on = scenario if is_present else checks.without_its_limits(scenario)
        held = form.played and not isinstance(edge, str)
        lasting = None if isinstance(edge, str) else edge
        return cls(held=held, edge=lasting, scenario=relied_on, is_assumed=relied_on is not scenario)

    @property
    def _consequence(self) -> str:
        return f"Nothing was written. {_NOT_PRESENT}" if self.is_assumed else "Nothing was written"

    def clear_drive(self, what: str, *, limits: LimitsSource | Sequence[LimitsSource]) -> None:
        """Refuse a drive that exceeds a limit between its samples."""
        end = float(self.scenario.time.times(self.scenario.drive)[-1])
        from_rest = self.scenario.model_copy(update={"time": TimeGrid(duration=end)})
        checks.cleared_for_output(from_rest, limits=limits, what=what, consequence=self._consequence)

    def cleared(
        self, wave: Waveform, what: str, *, limits: LimitsSource | Sequence[LimitsSource]
    ) -> CheckResult:
        """Compare the samples as they are played with the limits, or refuse them."""
        name = "the samples as written"
        if self.held:
            return checks.cleared_as_played(
                self.scenario, times=wave.times, voltages=wave.voltages, edge=self.edge, declare=_DECLARE,
                limits=limits, what=what, name=name, consequence=self._consequence,
            )  # fmt: skip
        joined = checks.with_drive(self.scenario, checks.sampled(wave.times, wave.voltages))
        return checks.cleared_for_output(
            joined, limits=limits, what=what, name=name, consequence=self._consequence
        )

    @property
    def notes(self) -> tuple[str, ...]:
        """What the comparison of the current with its limit relied on, as sentences."""
        edges = "steps" if self.edge is None else f"edges of {format_quantity(self.edge, 's', digits=4)}"
        judged = (
            f"the current was checked with each sample held until the next and {edges} between them"
            if self.held
            else "the current was checked with straight lines between the samples: an output that holds them makes steps, which"
            " were not checked"
        )
        amplifier = self.scenario.circuit.amplifier
        if amplifier is None or (amplifier.source_current is None and amplifier.bandwidth is None):
            return (judged,)
        name = amplifier.hardware or "declared to be present"
        return (
            judged,
            f"the current was checked with current limit and bandwidth of circuit.amplifier ({name}): the amplifier that is used"
            " has to have them in hardware",
        )


def refuse_unsuited(form: WaveformFormat, edge: float | str | None) -> None:
    """Refuse an edge that a format has no use for, and a file without one whose player is not known."""
    if not form.played and edge is not None:
        raise InputError(
            f"a {form.name} joins samples by straight lines; omit it", path="edge", value=str(edge)
        )
    if edge is None and form.played and not form.held:
        raise InputError(
            f"how the samples follow each other where a {form.name} is played is not declared: --edge {_LINE} if they are joined"
            " by straight lines, or --edge 10us, the height of a step over its steepest slope, if each is held until the next",
            path="edge",
        )
    if isinstance(edge, str) and (edge != _LINE or form.held):
        why = (
            f"{form.name} holds each sample: give a time"
            if form.held
            else f"must be '{_LINE}' or a time in s"
        )
        raise InputError(why, path="edge", value=edge)
    if edge is not None and not isinstance(edge, str) and not (math.isfinite(edge) and edge > 0):
        raise InputError("must be a time above 0 s", path="edge", value=str(edge))
