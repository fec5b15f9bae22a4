"""Design of a drive for a target of the electrostatic force, and the largest constant force that drives hold."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import InputError, nearest
from electrovib.core.units import parse_quantity
from electrovib.physics.drive.current import CurrentSine
from electrovib.physics.drive.sines import Sine
from electrovib.scenario import Source, read_scenario
from electrovib.studies.check import NEEDED, checked
from electrovib.studies.design.drive.carrier import design_carrier
from electrovib.studies.design.drive.direct import design_direct
from electrovib.studies.design.drive.played import Played
from electrovib.studies.design.drive.result import DesignedDrive
from electrovib.studies.design.drive.target import TargetSource, read_target
from electrovib.studies.design.gain import carrier_gain
from electrovib.studies.design.limits import Bounds, several_limits, unlimited

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from electrovib.core.arrays import Real
    from electrovib.physics.drive.base import Drive
    from electrovib.scenario import Scenario
    from electrovib.studies.check import LimitsSource
    from electrovib.studies.design.drive.played import FoundDrive

METHODS: Final = {
    "dc": "a slow voltage without a carrier, by the inverse of root, leak and dispersion",
    "carrier": "a carrier whose envelope is corrected until its mean force over each period is the target",
    "sqrt-am": "a carrier whose envelope is the square root of the target over the gain at the carrier, not corrected",
    "current": "as carrier, with a prescribed current",
}
"""Methods with their meanings."""
CARRIERS: Final = (100.0, 100e3)
"""Lowest and highest carrier by default [Hz]."""
_POINTS: Final = 181
_PROBE: Final = 1e-9
"""Constant force that is designed [N]; the force that is held follows from its scale."""


def design_drive(
    scenario: Scenario,
    *,
    target: TargetSource,
    method: str,
    carrier: float | str | None = None,
    rate: float | str | None = None,
    limits: LimitsSource | Sequence[LimitsSource] = None,
    progress: Callable[[int, int], None] | None = None,
) -> DesignedDrive:
    """Find the drive whose predicted electrostatic force is a target, or that follows it best within the limits.

    The carrier is by default the one that allows the largest force, from the larger of 1 kHz and ten times
    the highest frequency of the target on; the rate 64 in a period of the carrier, or 40 in one of the
    target. `progress` is not called: a design is one evaluation.
    """
    del progress
    if method not in METHODS:
        raise InputError(
            f"expected one of {', '.join(METHODS)}.{nearest(str(method), METHODS)}",
            path="method",
            value=str(method),
        )
    wanted = read_target(target)
    frequency, samples = _frequency(carrier, "carrier"), _frequency(rate, "rate")
    if method == "dc" and frequency is not None:
        raise InputError("method 'dc' has no carrier; omit it, or take another method", path="carrier")
    bounds = Bounds.of(scenario, limits)
    own = scenario.model_copy(update={"drive": _quantity(method)})
    linear = unlimited(own)
    if method == "dc":
        found = design_direct(linear, wanted, bounds, rate=samples)
    else:
        corrected = method != "sqrt-am"
        found = design_carrier(linear, wanted, bounds, carrier=frequency, rate=samples, corrected=corrected)
    played = Played(own, found.rate)
    several = several_limits(limits, scenario)
    return DesignedDrive(
        target=wanted,
        method=method,
        solution=found,
        predicted=found.predicted if own is linear else _predicted(played, found),
        bounds=bounds.declared,
        limits=several,
        check=checked(played.scenario(found.values), limits=list(several), name="the designed drive"),
    )


def _predicted(played: Played, found: FoundDrive) -> Real:
    """Return the mean forces of the full model with the limits of the amplifier [N]."""
    edges = found.edges
    width = round(float(edges[1] - edges[0]) * played.rate)
    first = round(float(edges[0]) * played.rate)
    return played.means(played.force(found.values), first, len(edges) - 1, width)


def _quantity(method: str) -> Drive:
    """Return a drive of the quantity that a method prescribes; it is replaced by the design."""
    if method == "current":
        return CurrentSine(amplitude=1e-6, frequency=1e3)
    return Sine(amplitude=1.0, frequency=1e3)


def _frequency(value: float | str | None, path: str) -> float | None:
    if value is None or not isinstance(value, str):
        return value
    try:
        return parse_quantity(value, "Hz")
    except ValueError as error:
        raise InputError(str(error), path=path, value=value) from None


@dataclass(frozen=True, kw_only=True)
class HeldForce:
    """Largest constant force within limits, by a slow voltage and over the frequency of a carrier.

    - `duration`, `direct`: time for which the slow voltage holds its force [s], and that force [N].
    - `carriers`: frequencies of the carrier [Hz].
    - `forces`, `amplitudes`: by the stray capacitance [F], mean force of a carrier of the largest amplitude
      [N], and that amplitude of the plate voltage [V].
    - `limits`: of voltage [V] and current [A]; `title`: of the scenario.
    """

    duration: float
    direct: float
    carriers: Real
    forces: dict[float, Real]
    amplitudes: dict[float, Real]
    limits: dict[str, float]
    title: str


def held_force(
    scenario: Source,
    *,
    duration: float = 1.0,
    carriers: ArrayLike | None = None,
    stray: Sequence[float] = (),
    limits: LimitsSource | Sequence[LimitsSource] = None,
    set: Mapping[str, Any] | None = None,  # noqa: A002 - the name of the option
) -> HeldForce:
    """Compute the largest constant force that a slow voltage and a carrier hold within declared limits."""
    found = read_scenario(scenario, changes=set)
    bounds = Bounds.of(found, limits)
    missing = [f"limits.{name}" for name in NEEDED if bounds.value(name) is None]
    if missing:
        raise InputError(
            f"{' and '.join(missing)}: not declared, and the largest force follows from the limits"
        )
    ends = np.geomspace(*CARRIERS, _POINTS)
    axis = ends if carriers is None else np.atleast_1d(np.asarray(carriers, dtype=float))
    plain = found.circuit.amplifier
    several = tuple(stray) or (0.0 if plain is None else plain.stray_capacitance,)
    forces, amplitudes = {}, {}
    for each in several:
        with_stray = found.replace({"circuit.amplifier.stray_capacitance": each}) if each or plain else found
        gain = carrier_gain(unlimited(with_stray), axis)
        peak = gain.largest_amplitude(bounds.limits(), slew=bounds.slew(with_stray))
        forces[each], amplitudes[each] = gain.force * peak**2, gain.voltage * peak
    level = ([0.0, duration], [_PROBE, _PROBE])
    direct = design_drive(found, target=level, method="dc", limits=limits)
    return HeldForce(
        duration=duration,
        direct=_PROBE * direct.scale,
        carriers=axis,
        forces=forces,
        amplitudes=amplitudes,
        limits={name: limit.value for name, limit in bounds.declared.items() if name in NEEDED},
        title=found.title,
    )
