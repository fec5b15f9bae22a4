"""Felt level of a vibration, by the most sensitive channel."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, ClassVar, Final, Self

import numpy as np
from pydantic import model_validator

from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity
from electrovib.physics.perception.channels import RYU, Channel, NonPacinian, Pacinian
from electrovib.physics.perception.compliance import SkinCompliance

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray


MOTION: Final = (
    "left out: summation over time and area, masking, and the motion of the finger without which a burst at 125 Hz is"
    " noticed by some 30 % only (doi:10.1098/rsif.2020.0783, abstract)"
)


class Perception(Model):
    """Perception of a vibration of the skin by a person or a group.

    Notes
    -----
    Without `compliance`, and without a finger in the scenario, relative levels take the displacement as proportional to
    the force, and levels above threshold take published skins. The threshold holds for one person or group, one contact
    and one procedure. It has to be measured; without it published ones are taken. It is the amplitude (zero to peak) of
    a sine at the best frequency of the most sensitive channel.
    """

    status: ClassVar[str] = "abstract"
    reference: ClassVar[str] = f"difference threshold: {RYU}"

    channels: tuple[Channel, ...] = (Pacinian(), NonPacinian())
    compliance: SkinCompliance | None = None
    threshold: Annotated[
        Number | None,
        Quantity("m", 1e-12, 1e-2, "detection threshold of displacement at the best frequency, zero to peak"),
    ] = None
    threshold_uncertainty: Annotated[
        Number | None, Quantity("1", 0, 60, "uncertainty of the threshold, plus or minus, in dB")
    ] = None
    difference_threshold: Annotated[
        Number,
        Quantity("1", 1e-3, 60, "difference threshold of the voltage amplitude between two stimuli, in dB"),
    ] = 1.21
    window: Annotated[
        Number, Quantity("s", 0.01, 100, "averaging time of a signal that does not repeat; a choice")
    ] = 0.5

    @model_validator(mode="after")
    def _complete(self) -> Self:
        if not self.channels:
            raise ValueError('channels must name at least one, for instance [{ model = "Pacinian" }]')
        if (self.threshold is None) != (self.threshold_uncertainty is None):
            raise ValueError(
                "threshold and threshold_uncertainty (in dB) have to be given together: a calibration needs its uncertainty"
            )
        return self

    def most_sensitive(self) -> Channel:
        """Return the channel with the lowest threshold of displacement."""
        return max(self.channels, key=lambda channel: float(channel.weight(channel.best())))


def decibels(ratio: ArrayLike) -> NDArray[np.float64]:
    """Return the level of a ratio of amplitudes in decibels: 20 lg ratio, minus infinity at 0."""
    amplitude = np.asarray(ratio, dtype=float)
    level = np.full(amplitude.shape, -np.inf)
    np.log10(amplitude, out=level, where=amplitude != 0)
    return np.asarray(20 * level)


def felt_amplitude(channel: Channel, frequency: ArrayLike, displacement: ArrayLike) -> float:
    r"""Return the amplitude at the Pacinian channel's best frequency that is equivalent to a line spectrum in a channel.

    `frequency` (n,) [Hz], above 0; `displacement` (n,) amplitudes zero to peak [m], or [N] where the
    displacement is assumed proportional to the force. The result has the unit of `displacement` and is

    .. math:: \sqrt{\sum_k (w(f_k)\,|X_k|)^2}

    Powers add within a channel; between channels the highest counts. The phase has no effect, so a train of
    short bursts is equivalent to noise of the same spectrum.
    """
    weighted = channel.weight(frequency) * np.abs(np.asarray(displacement))
    return float(np.sqrt(np.sum(weighted**2)))


def strongest(perception: Perception, frequency: ArrayLike, displacement: ArrayLike) -> float:
    """Return the largest equivalent amplitude of a line spectrum over the channels, as `felt_amplitude`."""
    return max(felt_amplitude(channel, frequency, displacement) for channel in perception.channels)
