"""Drive that renders a texture along a path, with the friction that the full model predicts; streams of textures, opened."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.answer import Document
from electrovib.core.diagnostics import Diagnostic, diagnostics_of
from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity
from electrovib.physics.time_profile import Steady
from electrovib.scenario import Scenario, Source
from electrovib.solve.simulate import simulate
from electrovib.studies.check import (
    CheckResult,
    cleared_for_output,
    not_shown,
    sampled,
    several_limits,
    with_drive,
)
from electrovib.studies.design.drive.target import force_panel
from electrovib.studies.design.result import Designed
from electrovib.studies.texture import set_up
from electrovib.studies.texture.reading import PathSource, TextureSource, read_path
from electrovib.studies.texture.set_up import AllLimits, Amount, Synthesis
from electrovib.studies.texture.stream import TextureStream
from electrovib.studies.waveform import MOST_POINTS

if TYPE_CHECKING:
    import xarray

    from electrovib.core.arrays import Real
    from electrovib.physics.texture.base import Texture
    from electrovib.physics.texture.path import FingerPath


LARGE: Final = 0.1
"""Misfit above which the reason is stated [1]; a choice."""
_ROUNDED: Final = 1e-9


@dataclass(frozen=True, kw_only=True, repr=False)
class TextureDrive(Designed):
    """Drive of a texture, simulated and within its limits.

    - `texture`, `path`: what is rendered, and the path of the finger.
    - `times`, `voltages`: samples of the drive, 0 V at either end, joined by straight lines; `rate`: samples
      per second.
    - `positions`, shape (n, 2): finger at these times.
    - `carrier`: its frequency; 0 without one.
    - `wanted_force`: attraction that the texture needs.
    - `predicted_force`, `predicted_friction`: of the full model, averaged over a period of the carrier where
      there is one; a friction is NaN where the finger rests and it is not determined.
    - `misfit`: root-mean-square difference of predicted and wanted attraction between the ramps over the
      root-mean-square of the wanted one; NaN for a texture without force.
    - `largest_force`: largest attraction that the limits allow.
    - `trace`: prediction of the full model, with friction; `check`: comparison with the limits.
    - `notes`: how the drive was made, and what was assumed.
    """

    form = "texture"
    texture: Texture
    path: FingerPath
    times: Real
    voltages: Real
    positions: Real
    rate: float
    carrier: float
    wanted_force: Real
    predicted_force: Real
    predicted_friction: Real
    misfit: float
    largest_force: float
    trace: xarray.Dataset
    check: CheckResult
    notes: tuple[str, ...]

    @property
    def scenario(self) -> Scenario:
        """Experiment with this drive, to be simulated or exported."""
        return self.check.scenario

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """Diagnostics of the prediction."""
        return tuple(diagnostics_of(self.trace))

    @property
    def document(self) -> Document:
        """What the drive reaches."""

        def shown(number: float, unit: str, digits: int = 4) -> str:
            return format_quantity(float(number), unit, digits=digits)

        known = self.predicted_friction[np.isfinite(self.predicted_friction)]
        span = "the friction is not determined: the finger rests"
        if len(known):
            span = f"friction {shown(known.min(), 'N', 5)} to {shown(known.max(), 'N', 5)}"
        said = [
            *self.notes,
            f"wanted attraction up to {shown(np.max(self.wanted_force), 'N')}, predicted up to"
            f" {shown(np.max(self.predicted_force), 'N')}; {span}",
            self.misfit_in_words,
            f"{len(self.times)} samples in {shown(self.times[-1], 's')}, up to {shown(np.max(np.abs(self.voltages)), 'V')},"
            " from 0 V to 0 V",
            *not_shown(self.check.rows),
        ]
        return self._document(
            said, figures=[force_panel(self.times, self.wanted_force, self.predicted_force)]
        )

    def numbers(self) -> dict[str, Any]:
        """Return what the drive reaches, in SI."""
        names = ("rate", "carrier", "misfit", "largest_force", "notes")
        return {name: getattr(self, name) for name in names}

    @property
    def misfit_in_words(self) -> str:
        """Misfit as a sentence; a large one without a carrier names the carrier."""
        if math.isnan(self.misfit):
            return "misfit not defined: the texture needs no force between the ramps"
        text = (
            f"misfit {100 * self.misfit:.3g} % (root-mean-square of predicted minus wanted attraction, over that of the"
            " wanted one)"
        )
        if self.misfit <= LARGE:
            return text
        if self.carrier:
            return f"{text}: the modulation is too fast for this carrier"
        return f"{text}: WITHOUT A CARRIER this stack does not follow the texture; take a carrier"


def texture_drive(
    scenario: Source,
    *,
    texture: TextureSource,
    path: PathSource,
    carrier: Amount | None = None,
    rate: Amount | None = None,
    ramp: Amount = set_up.RAMP,
    limits: AllLimits = None,
    set: Mapping[str, Any] | None = None,  # noqa: A002 - the name of the option
) -> TextureDrive:
    """Compute the drive that renders a texture while the finger follows a path, and predict its friction.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        As for `electrovib.load`; its drive is replaced.
    texture : str, Path, mapping or Texture
        A TOML file or a table, such as ``{"model": "Grating", "period": "2 mm", "amplitude": "1 mN"}``.
    path : str, Path, mapping or FingerPath
        A speed such as ``"30 mm/s"``, a file with the columns ``time`` and ``x``, or a table.
    carrier : float or str, optional
        Frequency of a carrier whose amplitude is modulated [Hz]; without it the voltage is the root of the force, by the gain
        at 100 Hz.
    rate : float or str, optional
        Samples per second [Hz]; by default 64 per cycle of the carrier, 10 kHz without one.
    ramp : float or str
        Duration of the rise from 0 V at the beginning and of the fall to 0 V after the end of the path [s].
    limits : as for `electrovib.check`
        Further limits; the largest voltage and the largest current have to be declared, here or in the scenario.
    set : mapping of str to value, optional
        Dotted path to value, put into the scenario.

    Returns
    -------
    TextureDrive
        Drive, prediction of the full model, misfit and check.

    Raises
    ------
    InputError
        Unless the limits are declared and held, and the texture can be rendered; nothing is clipped.

    Notes
    -----
    The attraction that adds the friction of the texture follows from the scenario's law of friction, and the amplitude from the
    mean force of the full model at the carrier. The gain contains neither the filtering of the modulation by the stack nor,
    without a carrier, the dependence of the force on frequency; the misfit states what both amount to.

    Examples
    --------
    >>> ridges = {"model": "Grating", "period": "2 mm", "amplitude": "0.5 mN"}
    >>> limits = {"voltage": "1 kV", "current": "10 mA"}
    >>> found = ev.texture_drive("bau_2010/sine", texture=ridges, path="50 mm/s", carrier="3 kHz", limits=limits)
    >>> f"misfit {found.misfit:.2%}"
    'misfit 0.18%'
    """
    found = set_up.RenderingSetUp.read(scenario, texture, set, limits, "the drive of a texture")
    followed = read_path(path, found.texture)
    synthesis = found.synthesis(carrier, ramp, rate, fastest=1e8)
    lasting = followed.duration + synthesis.hardware.ramp
    if lasting * synthesis.rate > MOST_POINTS:
        why = f"{lasting:g} s at {synthesis.rate:g} Hz are more than {MOST_POINTS} samples; take a shorter path or a lower rate"
        raise InputError(why, path="rate")
    positions, wanted, voltages = _samples(synthesis, followed)
    times, tone = np.arange(len(voltages)) / synthesis.rate, synthesis.hardware.carrier
    moving, motion_note = _moving(found.scenario, followed)
    driven = with_drive(_titled(moving, found.texture), sampled(times, voltages))
    check = cleared_for_output(
        driven, limits=limits, what="the drive of a texture", name="the drive of the texture"
    )
    trace = simulate(driven, time=times)
    predicted, friction = (
        np.asarray(trace[name].values) for name in ("electrostatic_force", "lateral_force")
    )
    if tone:
        predicted, friction = (mean_over_period(times, each, 1 / tone) for each in (predicted, friction))
    margin = synthesis.ramp_samples + (math.ceil(synthesis.rate / tone / 2) if tone else 0)
    return TextureDrive(
        texture=found.texture,
        path=followed,
        times=times,
        voltages=voltages,
        positions=positions,
        rate=synthesis.rate,
        carrier=tone,
        wanted_force=wanted,
        predicted_force=predicted,
        predicted_friction=friction,
        misfit=_misfit(predicted, wanted, margin, len(times) - margin),
        largest_force=synthesis.hardware.largest_force,
        trace=trace,
        check=check,
        notes=(*_notes(synthesis), motion_note),
        limits=several_limits(limits),
    )


def mean_over_period(times: Real, values: Real, period: float) -> Real:
    """Return the moving mean over one period, centred, of straight lines between samples; it is shorter at either end."""
    steps = np.diff(times) * (values[1:] + values[:-1]) / 2
    total = np.concatenate([[0.0], np.cumsum(steps)])
    first = np.maximum(times - period / 2, times[0])
    last = np.minimum(times + period / 2, times[-1])
    return np.asarray((np.interp(last, times, total) - np.interp(first, times, total)) / (last - first))


def _samples(synthesis: Synthesis, path: FingerPath) -> tuple[Real, Real, Real]:
    """Return positions, wanted attraction and voltages along a path, with the ramp at its end."""
    rate = synthesis.rate
    times = np.arange(math.floor(path.duration * rate * (1 + _ROUNDED)) + 1) / rate
    positions = path.positions(times)
    velocity = np.diff(positions, axis=0, prepend=positions[:1]) * rate
    forces = synthesis.forces(positions, velocity)
    ramped = synthesis.rising(0, synthesis.amplitudes(forces))
    place, why = synthesis.first_fault(forces, ramped, 0.0)
    if place >= 0:
        raise InputError(
            f"{why}. This is {format_quantity(times[place], 's', digits=4)} after the beginning of the path",
            path="texture",
        )
    end = synthesis.falling(0, synthesis.ramp_samples, float(ramped[-1]))
    voltages = synthesis.voltages(0, np.concatenate([ramped, end]))
    still = np.repeat(positions[-1:], len(end), axis=0)
    wanted = np.concatenate([forces, np.full(len(end), forces[-1])])
    return np.concatenate([positions, still]), wanted, voltages


def _moving(scenario: Scenario, path: FingerPath) -> tuple[Scenario, str]:
    """Return the scenario with the speed of the path where that is constant, and a note on the motion."""
    speed = path.steady_speed
    if speed is None or not isinstance(scenario.motion.time_profile, Steady):
        return (
            scenario,
            "the friction is predicted with the motion of the scenario, not with the speed of the path",
        )
    motion = scenario.motion.model_copy(update={"speed": speed})
    shown = format_quantity(speed, "m/s", digits=4)
    return scenario.model_copy(update={"motion": motion}), f"the friction is predicted at {shown}"


def _titled(scenario: Scenario, texture: Texture) -> Scenario:
    of = f" on the plate of: {scenario.titled()}" if scenario.titled() else ""
    return scenario.model_copy(update={"title": f"{type(texture).__name__}{of}"})


def _misfit(predicted: Real, wanted: Real, first: int, last: int) -> float:
    if last <= first:
        return math.nan
    size = float(np.sqrt(np.mean(wanted[first:last] ** 2)))
    return float(np.sqrt(np.mean((predicted - wanted)[first:last] ** 2))) / size if size else math.nan


def _notes(synthesis: Synthesis) -> tuple[str, ...]:
    hardware = synthesis.hardware
    how = "no carrier: the voltage is the root of the wanted force"
    if hardware.carrier:
        how = f"carrier of {format_quantity(hardware.carrier, 'Hz')}, its amplitude the root of the wanted force"
    return (
        f"{how}; {format_quantity(synthesis.rate, 'Hz')} samples, joined by straight lines",
        f"largest attraction {format_quantity(hardware.largest_force, 'N', digits=4)} at"
        f" {format_quantity(hardware.largest_amplitude, 'V', digits=4)}, determined by {hardware.bound}",
    )


LONGEST: Final = 600.0
"""Longest stream [s], by default; a choice."""
BOUNDED: Final = ("voltage", "current", "body_current", "slew_rate")
"""Limits with which a block of a stream can be compared."""
_CHECKED: Final = 0.05
"""Time at the largest amplitude for which a stream is checked before it begins [s]; a choice."""


def texture_stream(
    scenario: Source,
    *,
    texture: TextureSource,
    carrier: Amount | None = None,
    rate: Amount = 10e3,
    block: Amount = 1e-3,
    ramp: Amount = set_up.RAMP,
    dimensions: int = 1,
    longest: Amount = LONGEST,
    limits: AllLimits = None,
    set: Mapping[str, Any] | None = None,  # noqa: A002 - the name of the option
) -> TextureStream:
    """Return a stream of samples that render a texture while a finger moves.

    Parameters
    ----------
    scenario, texture, carrier, ramp, limits, set
        As for `electrovib.texture_drive`.
    rate : float or str
        Samples per second [Hz], 2.5 times the carrier at least.
    block : float or str
        Longest time between two calls of `render` [s], which is also the latency.
    dimensions : int
        1 for positions along x (of a picture along its middle), 2 for x and y.
    longest : float or str
        Duration at which the stream ends at 0 V [s].

    Returns
    -------
    TextureStream
        With ``render(position, time)``, which returns the samples of a block, and ``close()``.

    Raises
    ------
    InputError
        Unless the largest voltage and the largest current are declared, the layers respond linearly, and the largest amplitude
        passes every limit and breakdown.

    Notes
    -----
    Before the stream begins, a burst at the largest amplitude is compared with every limit and with breakdown. Each block is
    compared with the limits of voltage and current, the latter from the slope of the voltage and the charge that the stack and
    the stray capacitance can take up. Limits of charge, of stored energy and of root mean squares have no such bound, and a
    stream is refused where they are declared. A stream is never passed on to the bench.

    Examples
    --------
    >>> ridges = {"model": "Grating", "period": "2 mm", "amplitude": "0.5 mN"}
    >>> limits = {"voltage": "300 V", "current": "10 mA"}
    >>> stream = ev.texture_stream("bau_2010/sine", texture=ridges, limits=limits)
    >>> len(stream.render(position=0.001, time=0.001))
    10
    """
    found = set_up.RenderingSetUp.read(scenario, texture, set, limits, "a stream of a texture")
    if unbounded := [name for name in found.declared if name not in BOUNDED]:
        raise InputError(
            "a stream cannot be compared with this limit; compute the drive of a path with electrovib.texture_drive, which is",
            path=f"limits.{unbounded[0]}",
        )
    if dimensions not in (1, 2):
        raise InputError("must be 1 or 2", path="dimensions", value=str(dimensions))
    synthesis = found.synthesis(carrier, ramp, rate, fastest=1e7)
    span = set_up.amount(block, "s", "block", low=1 / synthesis.rate, high=1.0)
    lasting = set_up.amount(longest, "s", "longest", low=1e-3, high=86400.0)
    check = _cleared(found.scenario, synthesis, limits)
    return TextureStream(
        synthesis, block=round(span * synthesis.rate), dimensions=dimensions, longest=lasting, check=check
    )


def _cleared(scenario: Scenario, synthesis: Synthesis, limits: AllLimits) -> CheckResult:
    """Check a burst at the largest amplitude, or refuse the stream."""
    hardware = synthesis.hardware
    held = max(_CHECKED, 5 / hardware.carrier) if hardware.carrier else _CHECKED
    step = 1 / (set_up.IN_CYCLE * hardware.carrier) if hardware.carrier else hardware.ramp
    count = round((held + 2 * hardware.ramp) / step) + 1
    times = np.arange(count, dtype=np.float64) * np.float64(step)
    envelope = np.minimum(1.0, np.minimum(times, times[-1] - times) / hardware.ramp)
    wave = np.sin(2 * math.pi * hardware.carrier * times) if hardware.carrier else np.ones(len(times))
    voltages = np.asarray(hardware.largest_amplitude * envelope * wave, dtype=np.float64)
    return cleared_for_output(
        with_drive(scenario, sampled(times, voltages)),
        limits=limits,
        what="a stream of a texture",
        name="a burst at the largest amplitude of the stream",
        consequence="No stream was made; declare a lower limits.voltage",
    )
