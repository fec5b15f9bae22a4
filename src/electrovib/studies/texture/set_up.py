"""Inputs that a drive and a stream of a texture share, read and checked."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, TypeAlias

from electrovib.core.errors import InputError
from electrovib.core.units import parse_quantity
from electrovib.scenario import Source, read_scenario
from electrovib.studies.check import LimitsSource, declared_limits, refuse_unlimited
from electrovib.studies.texture.friction import AttractionOfFriction
from electrovib.studies.texture.hardware import hardware
from electrovib.studies.texture.reading import read_texture
from electrovib.studies.texture.synthesis import Synthesis

if TYPE_CHECKING:
    from electrovib.physics.texture.base import Texture
    from electrovib.scenario import Scenario
    from electrovib.studies.check import DeclaredLimit
    from electrovib.studies.texture.reading import TextureSource

Amount: TypeAlias = float | str
"""A number in SI, or text with a unit."""
AllLimits: TypeAlias = "LimitsSource | Sequence[LimitsSource]"
RAMP: Final = 1e-3
"""Duration of a ramp at either end [s], by default; a choice."""
FREQUENCY: Final = 100.0
"""Frequency at which the force of a drive without carrier is taken [Hz], by default; a choice."""
FINEST: Final = 0.4
"""Highest carrier over the rate of samples [1]; a choice below the limit of 0.5."""


@dataclass(frozen=True, kw_only=True)
class RenderingSetUp:
    """Scenario and texture as they were read, with the strictest declared limit of each quantity."""

    scenario: Scenario
    texture: Texture
    declared: Mapping[str, DeclaredLimit]

    @classmethod
    def read(
        cls,
        scenario: Source,
        texture: TextureSource,
        changes: Mapping[str, Any] | None,
        limits: AllLimits,
        what: str,
    ) -> RenderingSetUp:
        """Read the inputs, and refuse them unless the largest voltage and the largest current are declared."""
        found, read = read_scenario(scenario, changes=changes), read_texture(texture)
        declared = declared_limits(found, limits)
        refuse_unlimited(declared, what=what)
        return cls(scenario=found, texture=read, declared=declared)

    def synthesis(self, *, carrier: float, frequency: float, ramp: float, rate: float) -> Synthesis:
        """Return what determines the samples; `carrier` is 0 without one, and the force is then taken at `frequency`."""
        if carrier > FINEST * rate:
            raise InputError(
                f"a carrier may have {FINEST:g} of the rate of {rate:g} Hz; take a rate of {carrier / FINEST:g} Hz or more",
                path="carrier",
                value=f"{carrier:g} Hz",
            )
        ramp = max(1, round(ramp * rate)) / rate
        plate = hardware(self.scenario, self.declared, carrier=carrier, frequency=frequency, ramp=ramp)
        friction = AttractionOfFriction(self.scenario, plate.largest_force)
        return Synthesis(texture=self.texture, friction=friction, hardware=plate, rate=rate)


def amount(value: Amount, unit: str, name: str, *, low: float, high: float) -> float:
    """Read a number with a unit within a range."""
    try:
        number = parse_quantity(value, unit) if isinstance(value, str) else float(value)
    except (TypeError, ValueError) as error:
        raise InputError(str(error), path=name, value=str(value)) from None
    if not (math.isfinite(number) and low <= number <= high):
        raise InputError(f"must lie between {low:g} and {high:g} {unit}", path=name, value=str(value))
    return number
