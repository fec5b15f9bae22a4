"""Samples of the voltage that renders a texture at given positions of the finger."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.units import format_quantity
from electrovib.studies.texture.stream import added_friction

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.physics.texture.base import Texture
    from electrovib.studies.texture.set_up import AttractionOfFriction, RenderingHardware

_ROUNDED: Final = 1e-9
"""Relative excess that counts as rounding."""


@dataclass(frozen=True, kw_only=True)
class Synthesis:
    """Texture, friction, gain and limits that together determine each sample from position and velocity.

    With a carrier of frequency f, sample n is a(n) sin(2 pi f n/rate), where a^2 times the gain of the force
    at f is the wanted attraction; without a carrier it is a(n). Envelope and carrier depend on the sample and
    on the finger alone, so that the samples are the same in whatever blocks they are computed.
    """

    texture: Texture
    friction: AttractionOfFriction
    hardware: RenderingHardware
    rate: float

    @functools.cached_property
    def ramp_samples(self) -> int:
        """Intervals of a ramp, 1 at least."""
        return max(1, round(self.hardware.ramp * self.rate))

    def forces(self, position: Real, velocity: Real) -> Real:
        """Return the wanted attraction, out of range where it cannot be rendered; NaN where the texture gives none."""
        added = added_friction(self.texture, position, velocity, self.friction.plate)
        with np.errstate(over="ignore"):
            return self.friction.force(added)

    def amplitudes(self, forces: Real) -> Real:
        """Return the amplitude of the carrier, or the voltage without one; 0 for forces below 0."""
        hardware = self.hardware
        found = hardware.largest_amplitude * np.sqrt(np.maximum(forces / hardware.largest_force, 0.0))
        largest = hardware.largest_amplitude
        if found.max(initial=0.0) > largest:
            return np.where(found <= largest * (1 + _ROUNDED), np.minimum(found, largest), found)
        return np.asarray(found)

    def rising(self, first: int, amplitudes: Real) -> Real:
        """Return amplitudes from sample `first` on times the ramp at the beginning, which is 0 at sample 0."""
        if first >= self.ramp_samples:
            return amplitudes
        with np.errstate(invalid="ignore"):  # 0 times infinity, which `first_fault` finds
            return np.minimum(1.0, np.arange(first, first + len(amplitudes)) / self.ramp_samples) * amplitudes

    def falling(self, since: int, count: int, amplitude: float) -> Real:
        """Return `count` amplitudes of the ramp at the end after `since` of its samples; 0 from its end on."""
        steps = np.arange(since + 1, since + count + 1)
        return amplitude * np.maximum(0.0, 1 - steps / self.ramp_samples)

    def voltages(self, first: int, amplitudes: Real) -> Real:
        """Return the samples of the drive from sample `first` on."""
        carrier = self.hardware.carrier
        if not carrier:
            return amplitudes
        cycles = (
            math.fmod(first * carrier, self.rate) / self.rate
        )  # less than one cycle, however long the drive
        phase = np.arange(len(amplitudes)) * (2 * math.pi * carrier / self.rate) + 2 * math.pi * cycles
        return np.asarray(amplitudes * np.sin(phase) + 0.0)

    def first_fault(self, forces: Real, ramped: Real, before: float) -> tuple[int, str]:
        """Find the first sample at which the texture or a limit is not held, -1 if all are, and what is not held.

        With a carrier of angular frequency w the slope between two samples is at most the root of a'^2 + (w
        a)^2, with the slope a' and the larger amplitude a of both.
        """
        if len(ramped) == 0:
            return -1, ""
        with np.errstate(invalid="ignore"):  # infinite amplitudes
            return self._first_fault(forces, ramped, before)

    def _first_fault(self, forces: Real, ramped: Real, before: float) -> tuple[int, str]:
        hardware, both = self.hardware, np.concatenate(([before], ramped))
        steps = (both[1:] - both[:-1]) * self.rate
        largest_force, largest_slope = (
            limit * (1 + 2 * _ROUNDED) for limit in (hardware.largest_force, hardware.largest_slope)
        )
        turning = 2 * math.pi * hardware.carrier
        # one bound for all samples first, which nearly every block meets
        steepest = math.hypot(max(steps.max(), -steps.min()), turning * both.max())
        if steepest <= largest_slope and forces.min() >= 0 and forces.max() <= largest_force:
            return -1, ""
        slopes = np.hypot(steps, turning * np.maximum(both[1:], both[:-1]))
        held = (forces >= 0) & (forces <= largest_force) & (slopes <= largest_slope)
        if held.all():
            return -1, ""
        place = int(np.argmin(held))
        return place, self._why(
            float(forces[place]), float(slopes[place]), int(np.count_nonzero(np.isnan(forces))), len(forces)
        )

    def _why(self, force: float, slope: float, unknown: int, count: int) -> str:
        hardware = self.hardware
        if math.isnan(force):
            return (
                f"the model '{type(self.texture).__name__}' returned NaN or infinity, {unknown} of {count} values; the added"
                " friction has to be a number of newtons"
            )
        if not force >= 0:
            return (
                "the texture has less friction than the plate itself, and attraction only adds friction; raise the texture or"
                " lower its baseline"
            )
        if force > hardware.largest_force:
            wanted = (
                f"an attraction of {format_quantity(force, 'N', digits=4)}"
                if math.isfinite(force)
                else "more"
            )
            return (
                f"the texture needs {wanted}, and the hardware gives {format_quantity(hardware.largest_force, 'N', digits=4)} at"
                f" {format_quantity(hardware.largest_amplitude, 'V', digits=4)}, within {hardware.bound}; reduce the texture, or"
                " take another carrier"
            )
        return (
            f"the voltage changes at {format_quantity(slope, 'V/s', digits=4)}, and the limits of current and slew rate"
            f" allow {format_quantity(hardware.largest_slope, 'V/s', digits=4)}; take wider edges, a slower finger, or a shorter"
            " ramp, which leaves more of them to changes of the amplitude"
        )
