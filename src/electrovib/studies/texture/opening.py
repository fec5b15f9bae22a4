"""Streams of textures, opened: the inputs read, the limits compared with the largest amplitude."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.physics.limits import MEAN_SQUARES
from electrovib.scenario import Source
from electrovib.studies.check import cleared_for_output, sampled, with_drive
from electrovib.studies.texture.reading import TextureSource
from electrovib.studies.texture.set_up import FREQUENCY, RAMP, AllLimits, Amount, RenderingSetUp, amount
from electrovib.studies.texture.stream import TextureStream

if TYPE_CHECKING:
    from electrovib.scenario import Scenario
    from electrovib.studies.check import CheckResult
    from electrovib.studies.texture.synthesis import Synthesis

LONGEST: Final = 600.0
"""Longest stream [s], by default; a choice."""
UNBOUNDED: Final = ("charge", "stored_energy", *MEAN_SQUARES)
"""Limits with which a block of a stream cannot be compared."""
_CHECKED: Final = 0.05
"""Time at the largest amplitude for which a stream is checked before it begins [s]; a choice."""
_IN_CYCLE: Final = 64


def texture_stream(
    scenario: Source,
    *,
    texture: TextureSource,
    carrier: Amount | None = None,
    frequency: Amount = FREQUENCY,
    rate: Amount = 10e3,
    block: Amount = 1e-3,
    ramp: Amount = RAMP,
    dimensions: int = 1,
    longest: Amount = LONGEST,
    limits: AllLimits = None,
    set: Mapping[str, Any] | None = None,  # noqa: A002 - the name of the option
) -> TextureStream:
    """Return a stream of samples that render a texture while a finger moves.

    Parameters
    ----------
    scenario, texture, carrier, frequency, ramp, limits, set
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
    """
    found = RenderingSetUp.read(scenario, texture, set, limits, "a stream of a texture")
    if unbounded := [name for name in UNBOUNDED if name in found.declared]:
        raise InputError(
            "a stream cannot be compared with this limit; compute the drive of a path with electrovib.texture_drive, which is",
            path=f"limits.{unbounded[0]}",
        )
    if dimensions not in (1, 2):
        raise InputError("must be 1 or 2", path="dimensions", value=str(dimensions))
    tone = 0.0 if carrier is None else amount(carrier, "Hz", "carrier", low=1e-3, high=1e7)
    per_second = amount(rate, "Hz", "rate", low=1.0, high=1e7)
    span = amount(block, "s", "block", low=1 / per_second, high=1.0)
    lasting = amount(longest, "s", "longest", low=1e-3, high=86400.0)
    synthesis = found.synthesis(
        carrier=tone,
        frequency=amount(frequency, "Hz", "frequency", low=1e-3, high=1e7),
        ramp=amount(ramp, "s", "ramp", low=1e-6, high=10.0),
        rate=per_second,
    )
    check = _cleared(found.scenario, synthesis, limits)
    return TextureStream(
        synthesis, block=round(span * per_second), dimensions=dimensions, longest=lasting, check=check
    )


def _cleared(scenario: Scenario, synthesis: Synthesis, limits: AllLimits) -> CheckResult:
    """Check a burst at the largest amplitude, or refuse the stream."""
    hardware = synthesis.hardware
    held = max(_CHECKED, 5 / hardware.carrier) if hardware.carrier else _CHECKED
    step = 1 / (_IN_CYCLE * hardware.carrier) if hardware.carrier else hardware.ramp
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
