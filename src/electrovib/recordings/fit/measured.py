"""What was measured, as a fit takes it: recordings with their settings, their noise and their session."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import InputError, nearest
from electrovib.core.signals import SIGNALS
from electrovib.core.units import format_quantity
from electrovib.recordings.calibration_error import CalibrationError
from electrovib.recordings.fit.prescribed import PRESCRIBING
from electrovib.recordings.fit.rounding import resolution_of

if TYPE_CHECKING:
    import xarray
    from numpy.typing import NDArray

    from electrovib.core.arrays import Real

PRESCRIBED: Final = frozenset({"time", "frequency", "layer", *PRESCRIBING})
"""Signals that a scenario is given and does not predict."""
PROPORTIONAL: Final = frozenset({"impedance"})
"""Signals whose noise is proportional to their modulus unless stated otherwise."""
AXES: Final = ("time", "frequency")


@dataclass(frozen=True, kw_only=True)
class MeasuredTrace:
    """One recording of an experiment, with what a fit has to know beside its numbers.

    - `trace`: signals over ``time`` or over ``frequency``.
    - `changes`: settings under which it was recorded and in which it differs from the scenario, by dotted
      path.
    - `noise`: standard deviation of a signal in its unit, of each part where it is complex, or over its
      modulus where it is among `proportional`; what is absent is estimated from the scatter of the residuals.
    - `proportional`: signals whose noise is proportional to their modulus, as an impedance analyser's is.
    - `offsets`: signals whose zero is unknown; a constant is fitted to each.
    - `session`: day, finger or mounting to which the recording belongs; parameters may vary between sessions.
    - `calibration`: systematic errors, by default those of an import with a calibration, see
      `CalibrationError.attributes`.
    """

    trace: xarray.Dataset
    name: str = "recording"
    changes: Mapping[str, Any] = field(default_factory=dict)
    noise: Mapping[str, float] = field(default_factory=dict)
    proportional: Collection[str] = PROPORTIONAL
    offsets: Collection[str] = ()
    session: str = ""
    calibration: Mapping[str, CalibrationError] = field(default_factory=dict)

    def calibration_of(self, signal: str) -> CalibrationError | None:
        """Return the systematic error of a signal; None where it is not stated."""
        if signal in self.calibration:
            return self.calibration[signal]
        return CalibrationError.from_attributes(self.trace[signal].attrs)


@dataclass(frozen=True, kw_only=True)
class Observed:
    """One signal of one recording.

    - `x`: times or frequencies, increasing [s or Hz]; `y`: real or complex, in the signal's unit.
    - `noise`: standard deviation over `scale`; None where it is not stated. `noise_alone` is that stated,
      without the rounding that `noise` includes where the resolution is larger.
    - `scale`: what the noise is proportional to: 1 in the signal's unit, or the modulus of the data.
    - `offset`: whether its zero is unknown.
    - `resolution`: step to which a real signal was rounded; 0 where none is found in its values.
    """

    signal: str
    axis: str
    x: Real
    y: NDArray[Any]
    noise: float | None
    scale: Real
    offset: bool
    resolution: float = 0.0
    noise_alone: float | None = None

    @property
    def relative(self) -> bool:
        """Whether the noise is proportional to the data."""
        return bool((self.scale != 1).any())

    @property
    def parts(self) -> int:
        """Real numbers for each sample: 2 of a complex signal."""
        return 2 if np.iscomplexobj(self.y) else 1

    @property
    def size(self) -> int:
        """Number of real numbers."""
        return self.x.size * self.parts


def observed(measured: MeasuredTrace, signals: Sequence[str] | None = None) -> tuple[Observed, ...]:
    """Collect the signals of a recording that a scenario predicts; samples that are no number are omitted."""
    trace = measured.trace
    offered = {
        str(name): str(variable.dims[0])
        for name, variable in trace.data_vars.items()
        if name in SIGNALS and name not in PRESCRIBED and len(variable.dims) == 1 and variable.dims[0] in AXES
    }
    wanted = list(offered) if signals is None else [name for name in signals if name in offered]
    problems = [
        f"{measured.name}: {what} = '{name}': the recording has no such signal.{nearest(name, offered)}"
        for what, names in (("noise", measured.noise), ("offsets", measured.offsets))
        for name in names
        if name not in offered
    ]
    problems += [
        f"{measured.name}: signals = '{name}': the scenario prescribes it, and a fit compares what a scenario predicts; omit it"
        for name in signals or ()
        if name in PRESCRIBED and name in trace.data_vars
    ]
    if not wanted and not problems:
        problems.append(
            f"{measured.name}: holds no signal to fit; it has {', '.join(map(str, trace.data_vars)) or 'no variables'}, and a"
            " fit takes signals of the nomenclature over time or frequency, such as electrostatic_force or impedance"
        )
    if problems:
        raise InputError(problems)
    return tuple(_observed(measured, name, offered[name]) for name in wanted)


def _observed(measured: MeasuredTrace, name: str, axis: str) -> Observed:
    x = np.asarray(measured.trace[axis].values, dtype=float)
    y = np.asarray(measured.trace[name].values)
    good = np.isfinite(y) & np.isfinite(x)
    noise = measured.noise.get(name)
    if noise is not None and not (np.isfinite(noise) and noise > 0):
        raise InputError(f"{measured.name}: noise.{name} = {noise}: expected a standard deviation above 0")
    if not good.any() or (np.diff(x[good]) <= 0).any():
        raise InputError(f"{measured.name}: {axis} of '{name}': expected increasing numbers")
    if name == "capacitance" and np.mean(y[good].real) < 0 and name not in measured.offsets:
        raise InputError(
            f"{measured.name}: 'capacitance' is {format_quantity(float(np.mean(y[good])), 'F', digits=3)} in the mean, and none"
            " is below 0: check the sign and the column; if too much stray capacitance was subtracted, let its zero be fitted:"
            " offsets = ['capacitance'], at the command line --zero capacitance"
        )
    scale = np.abs(y[good]) if name in measured.proportional else np.ones(good.sum())
    if (scale == 0).any():
        raise InputError(
            f"{measured.name}: '{name}' is 0 somewhere, where a noise proportional to it would be 0 too"
        )
    is_plain = not np.iscomplexobj(y) and name not in measured.proportional
    resolution = resolution_of(y[good]) if is_plain else 0.0
    return Observed(
        signal=name,
        axis=axis,
        x=x[good],
        y=y[good],
        noise=math.hypot(noise, resolution / math.sqrt(12)) if noise and resolution > noise else noise,
        scale=scale,
        offset=name in measured.offsets,
        resolution=resolution,
        noise_alone=noise,
    )
