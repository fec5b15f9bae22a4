"""How the channels of touch weigh a displacement of the skin, and what a threshold is.

A displacement is felt by the channel whose weighted level is the highest. Levels are relative: how many decibels
below (or above) a sine of the same size at the best frequency. They become levels above threshold only with a
threshold that the user has measured. What is not in it: summation over time and area, masking, motion.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Final, Self

import numpy as np
from pydantic import model_validator

from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike, NDArray

BEST_FREQUENCIES: Final = (250.0, 300.0)
"""Where the Pacinian channel is most sensitive, as an interval in an abstract [Hz]."""
RECALLED_CORNER: Final = 100.0
"""Where the skin of a fingertip turns from elastic to viscous: recalled, never a default, only shown beside [Hz]."""
RYU: Final = "Ryu, Pyo, Lim, Kwon, Sci. Rep. 8, 4555 (2018), doi:10.1038/s41598-018-22865-x, abstract"
MOTION: Final = (
    "left out: summation over time and area, masking, and the motion of the finger without which a burst at 125 Hz is"
    " noticed by some 30 % only (doi:10.1098/rsif.2020.0783, abstract)"
)


class Channel(Model, family=True):
    """A channel of touch: how it weighs a displacement of the skin over frequency."""

    @abstractmethod
    def weight(self, frequency: ArrayLike) -> NDArray[np.float64]:
        """Sensitivity to a displacement.

        Parameters
        ----------
        frequency : array_like
            Hz, >= 0; NaN gives NaN.

        Returns
        -------
        ndarray
            1, same shape; 1 is the sensitivity of the Pacinian channel at its best frequency.
        """

    @abstractmethod
    def best(self) -> float:
        """Frequency to which the channel is most sensitive [Hz]."""


class Pacinian(Channel):
    """Pacinian channel: a U-shaped threshold of displacement, lowest at one frequency.

    Notes
    -----
    The band of 40 to 800 Hz and the best frequency of 250 to 300 Hz are from an abstract. That the curve is a
    power of frequency on either side, and that the power is 2 (12 dB an octave), is an assumption; the
    rounding where both meet follows from the formula and was not measured.
    """

    status: ClassVar[str] = "derived"
    reference: ClassVar[str] = (
        "40 to 800 Hz, best at 250 or 300 Hz: review of vibrotactile channels, abstract; 12 dB an octave: an assumption"
    )
    equation: ClassVar[Mapping[str, str]] = {
        "weight": "(order_below + order_above)*(frequency/best_frequency)**order_below"
        "/(order_above + order_below*(frequency/best_frequency)**(order_below + order_above))"
    }

    best_frequency: Annotated[Number, Quantity("Hz", 10, 2000, "frequency of the lowest threshold")] = 250.0
    order_below: Annotated[
        Number, Quantity("1", 0.1, 6, "power of frequency below it; 2 is 12 dB an octave")
    ] = 2.0
    order_above: Annotated[
        Number, Quantity("1", 0.1, 6, "power of frequency above it; 2 is 12 dB an octave")
    ] = 2.0

    def weight(self, frequency: ArrayLike) -> NDArray[np.float64]:
        """Sensitivity [1]; 1 at the best frequency [Hz], its highest."""
        ratio = np.asarray(frequency, dtype=float) / self.best_frequency
        low, high = self.order_below, self.order_above
        result: NDArray[np.float64] = (low + high) * ratio**low / (high + low * ratio ** (low + high))
        return result

    def best(self) -> float:
        """Frequency of the lowest threshold [Hz]."""
        return self.best_frequency


class NonPacinian(Channel):
    """Non-Pacinian channel: one threshold of displacement over a band of low frequencies.

    Notes
    -----
    -27 dB is a choice: with it both channels are alike at 37 Hz, where an abstract has them alike at 40 Hz. A
    flat threshold is how a chapter's abstract describes it; abstracts put the channel at 10 to 40 Hz or say
    that it reaches further up, 100 Hz is an assumption. The band ends abruptly, which receptors do not.
    """

    status: ClassVar[str] = "derived"
    reference: ClassVar[str] = (
        "thresholds of the two channels alike at 40 Hz: Guclu and Bolanowski, Vibrotactile thresholds of the"
        " Non-Pacinian I channel (2005), abstract; -27 dB and 10 to 100 Hz: assumptions"
    )

    sensitivity: Annotated[
        Number, Quantity("1", -80, 40, "dB above that of the Pacinian channel at its best frequency")
    ] = -27.0
    low: Annotated[Number, Quantity("Hz", 0, 1000, "lowest frequency")] = 10.0
    high: Annotated[Number, Quantity("Hz", 0.1, 2000, "highest frequency")] = 100.0

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.low >= self.high:
            raise ValueError("low must be below high")
        return self

    def weight(self, frequency: ArrayLike) -> NDArray[np.float64]:
        """Sensitivity [1]; 10^(sensitivity/20) in the band [Hz], ends included, 0 outside."""
        places = np.asarray(frequency, dtype=float)
        inside = (places >= self.low) & (places <= self.high)
        result: NDArray[np.float64] = np.where(inside, 10 ** (self.sensitivity / 20), 0.0 * places)
        return result

    def best(self) -> float:
        """Middle of the band, in the logarithm [Hz]; of its upper half if it begins at 0."""
        return float(np.sqrt((self.low or self.high / 4) * self.high))


class SkinCompliance(Model, family=True):
    """How far the skin under the finger moves for a lateral force on it."""

    @abstractmethod
    def compliance(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Lateral displacement of the skin per force.

        Parameters
        ----------
        frequency : array_like
            Hz, >= 0; NaN gives NaN.

        Returns
        -------
        ndarray
            m/N, complex, same shape.
        """


class ElasticSkin(SkinCompliance):
    """Skin that follows the force as a spring, at any frequency."""

    equation: ClassVar[Mapping[str, str]] = {"compliance": "1/stiffness"}
    example: ClassVar[Mapping[str, Any]] = {"stiffness": 1000.0}

    stiffness: Annotated[Number, Quantity("N/m", 1, 1e6, "lateral stiffness of the fingertip")]

    def compliance(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Lateral displacement per force [m/N] at frequencies in Hz."""
        places = np.asarray(frequency, dtype=float)
        result: NDArray[np.complex128] = 1 / self.stiffness + 0j * places
        return result


class ElasticViscousSkin(SkinCompliance):
    """Skin that follows the force as a spring at low and as a damper at high frequencies.

    Notes
    -----
    A spring and a damper side by side, corner = stiffness/(2 pi damping). A corner near 100 Hz and a stiffness
    near 1 N/mm are recalled of measurements on fingertips whose paper was not read: they are no defaults.
    """

    status: ClassVar[str] = "recalled"
    reference: ClassVar[str] = (
        "elastic below some 100 Hz, viscous above: Wiertlewski and Hayward 2012, not read"
    )
    equation: ClassVar[Mapping[str, str]] = {"compliance": "1/(stiffness*(1 + I*frequency/corner))"}
    example: ClassVar[Mapping[str, Any]] = {"stiffness": 1000.0, "corner": 100.0}

    stiffness: Annotated[Number, Quantity("N/m", 1, 1e6, "lateral stiffness of the fingertip")]
    corner: Annotated[Number, Quantity("Hz", 0.1, 1e5, "where the damper takes over from the spring")]

    def compliance(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Lateral displacement per force [m/N] at frequencies in Hz."""
        ratio = np.asarray(frequency, dtype=float) / self.corner
        in_phase = 1 / (self.stiffness * (1 + ratio**2))
        result: NDArray[np.complex128] = in_phase - 1j * ratio * in_phase
        return result


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
