"""What a person notices, by the channel that needs the least."""

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
    """What a person notices of a vibration of the skin.

    Notes
    -----
    Without `compliance`, and without a finger in the scenario, the displacement is taken in proportion to the
    force and only relative levels are given. The threshold belongs to one person or group, one contact and one
    procedure: it has to be measured, and is the amplitude (zero to peak) of a sine at the best frequency of
    the most sensitive channel.
    """

    status: ClassVar[str] = "abstract"
    reference: ClassVar[str] = f"difference threshold: {RYU}"

    channels: tuple[Channel, ...] = (Pacinian(), NonPacinian())
    compliance: SkinCompliance | None = None
    threshold: Annotated[
        Number | None,
        Quantity("m", 1e-12, 1e-2, "displacement just felt at the best frequency, zero to peak"),
    ] = None
    threshold_uncertainty: Annotated[
        Number | None, Quantity("1", 0, 60, "dB by which the threshold may be wrong, either way")
    ] = None
    difference_threshold: Annotated[
        Number, Quantity("1", 1e-3, 60, "dB of voltage amplitude by which two stimuli are told apart")
    ] = 1.21
    window: Annotated[
        Number, Quantity("s", 0.01, 100, "over which what does not repeat is averaged; a choice")
    ] = 0.5

    @model_validator(mode="after")
    def _complete(self) -> Self:
        if not self.channels:
            raise ValueError('channels must name at least one, for instance [{ model = "Pacinian" }]')
        if (self.threshold is None) != (self.threshold_uncertainty is None):
            raise ValueError(
                "threshold and threshold_uncertainty (in dB) go together: a calibration without an uncertainty is none"
            )
        return self

    def most_sensitive(self) -> Channel:
        """Give the channel that needs the least displacement."""
        return max(self.channels, key=lambda channel: float(channel.weight(channel.best())))


def decibels(ratio: ArrayLike) -> NDArray[np.float64]:
    """Level of a ratio of amplitudes.

    Parameters
    ----------
    ratio : array_like
        1, >= 0.

    Returns
    -------
    ndarray
        20 lg ratio [dB], same shape; minus infinity at 0.
    """
    amplitude = np.asarray(ratio, dtype=float)
    level = np.full(amplitude.shape, -np.inf)
    np.log10(amplitude, out=level, where=amplitude != 0)
    return np.asarray(20 * level)


def felt_amplitude(channel: Channel, frequency: ArrayLike, displacement: ArrayLike) -> float:
    r"""Amplitude at the Pacinian channel's best frequency that a channel takes for a spectrum of lines.

    Parameters
    ----------
    channel : Channel
        Whose weight it is.
    frequency : array_like, shape (n,)
        Hz, above 0.
    displacement : array_like, shape (n,)
        Amplitudes, zero to peak [m]; in N where the displacement is taken in proportion to the force.

    Returns
    -------
    float
        In the unit of `displacement`.

    Notes
    -----
    .. math:: \sqrt{\sum_k (w(f_k)\,|X_k|)^2}

    Powers add inside a channel; between channels the highest counts. Phase plays no role, so a train of short
    bursts is taken for noise of the same spectrum.
    """
    weighted = channel.weight(frequency) * np.abs(np.asarray(displacement))
    return float(np.sqrt(np.sum(weighted**2)))


def strongest(perception: Perception, frequency: ArrayLike, displacement: ArrayLike) -> float:
    """Felt amplitude of the channel that feels a spectrum of lines most.

    Parameters
    ----------
    perception : Perception
        Channels.
    frequency : array_like, shape (n,)
        Hz, above 0.
    displacement : array_like, shape (n,)
        Amplitudes, zero to peak [m], or [N] where the displacement is taken in proportion to the force.

    Returns
    -------
    float
        In the unit of `displacement`.
    """
    return max(felt_amplitude(channel, frequency, displacement) for channel in perception.channels)
