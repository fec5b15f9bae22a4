"""Largest constant force that a slow voltage, and a carrier, hold for a given time within limits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.scenario import Source, read_scenario
from electrovib.study.check import NEEDED
from electrovib.study.design.drive.function import design_drive
from electrovib.study.design.drive.limits import Bounds, unlimited
from electrovib.study.design.gain import carrier_gain

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from electrovib.core.arrays import Real
    from electrovib.study.check import LimitsSource

CARRIERS: Final = (100.0, 100e3)
"""Lowest and highest carrier by default [Hz]."""
_POINTS: Final = 181
_PROBE: Final = 1e-9
"""Constant force that is designed [N]; the force that is held follows from its scale."""


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
