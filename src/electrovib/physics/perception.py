"""Perception of vibration: frequency weighting of the tactile channels, and thresholds.

A displacement is felt by the channel whose weighted level is the highest. Levels are relative to a sine of the same
amplitude at the best frequency, in decibels. They become levels above threshold by a threshold and a compliance: those of
the person at hand, or else published ones, as assumptions with their spread.
Summation over time and area, masking and motion are not modelled.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Final, Self

import numpy as np
from pydantic import model_validator

from electrovib.core.citation import SECOND_HAND
from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity
from electrovib.core.units import format_quantity
from electrovib.physics.finger import GrowthWithSpeed

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike, NDArray


BEST_FREQUENCIES: Final = (250.0, 300.0)
"""Range of the best frequency of the Pacinian channel [Hz], from an abstract."""


RYU: Final = "Ryu, Pyo, Lim, Kwon, Sci. Rep. 8, 4555 (2018), doi:10.1038/s41598-018-22865-x, abstract"


ISRAR: Final = "Israr, Choi and Tan, IROS 2006, 472, as tabled in github.com/adambickerdike/Stabilisation_Pen"
"""Vibration of a held pen, second-hand."""


@dataclass(frozen=True, kw_only=True)
class DetectionThreshold:
    """A published threshold of vibration, an assumption where the person at hand has not been measured.

    `amplitude` [m] that is just felt at the `frequency` of the sine [Hz], taken as zero to peak, which none
    of the quotations states; `conditions` are contact and direction, `status` says how the source was read.
    """

    amplitude: float
    frequency: float
    conditions: str
    source: str
    status: str = SECOND_HAND


class Channel(Model, family=True):
    """A tactile channel: its sensitivity to a displacement of the skin over frequency."""

    never_negative: ClassVar[frozenset[str]] = frozenset({"weight", "best"})

    published: ClassVar[tuple[DetectionThreshold, ...]] = ()
    """Published thresholds at frequencies at which this channel is the most sensitive one."""

    @abstractmethod
    def weight(self, frequency: ArrayLike) -> NDArray[np.float64]:
        """Return the sensitivity to a displacement.

        Parameters
        ----------
        frequency : array_like
            Frequency [Hz], >= 0; NaN gives NaN.

        Returns
        -------
        sensitivity : ndarray, same shape
            Sensitivity [1] relative to the Pacinian channel at its best frequency.
        """

    @abstractmethod
    def best(self) -> float:
        """Return the frequency of highest sensitivity [Hz]."""


class Pacinian(Channel):
    """Pacinian channel: a U-shaped threshold of displacement, lowest at one frequency.

    Notes
    -----
    The band of 40 to 800 Hz and the best frequency of 250 to 300 Hz are from an abstract. A power of frequency on
    either side with exponent 2 (12 dB per octave) is an assumption; the rounding at the minimum follows from the
    formula and was not measured.
    """

    status: ClassVar[str] = "derived"
    reference: ClassVar[str] = (
        "40 to 800 Hz, best at 250 or 300 Hz: review of vibrotactile channels, abstract; 12 dB per octave: an assumption"
    )
    equation: ClassVar[Mapping[str, str]] = {
        "weight": "(order_below + order_above)*(frequency/best_frequency)**order_below"
        "/(order_above + order_below*(frequency/best_frequency)**(order_below + order_above))"
    }

    published: ClassVar[tuple[DetectionThreshold, ...]] = (
        DetectionThreshold(
            amplitude=0.03e-6,
            frequency=150.0,
            conditions="grasped cylinder, tangential, whole hand",
            source=f"Brisben 1999, quoted by {ISRAR}",
        ),
        DetectionThreshold(amplitude=0.06e-6, frequency=320.0, conditions="held pen", source=ISRAR),
        DetectionThreshold(
            amplitude=0.13e-6,
            frequency=300.0,
            conditions="thenar with surround, normal",
            source=f"Bolanowski 1988, quoted by {ISRAR}",
        ),
    )

    best_frequency: Annotated[Number, Quantity("Hz", 10, 2000, "frequency of the lowest threshold")] = 250.0
    order_below: Annotated[
        Number, Quantity("1", 0.1, 6, "power of frequency below it; 2 is 12 dB per octave")
    ] = 2.0
    order_above: Annotated[
        Number, Quantity("1", 0.1, 6, "power of frequency above it; 2 is 12 dB per octave")
    ] = 2.0

    def weight(self, frequency: ArrayLike) -> NDArray[np.float64]:
        """Return the sensitivity [1], 1 at the best frequency [Hz] and lower elsewhere."""
        ratio = np.asarray(frequency, dtype=float) / self.best_frequency
        low, high = self.order_below, self.order_above
        result: NDArray[np.float64] = (low + high) * ratio**low / (high + low * ratio ** (low + high))
        return result

    def best(self) -> float:
        """Return the frequency of the lowest threshold [Hz]."""
        return self.best_frequency


class NonPacinian(Channel):
    """Non-Pacinian channel: one threshold of displacement over a band of low frequencies.

    Notes
    -----
    -27 dB is a choice that makes both channels equally sensitive at 37 Hz; in an abstract they are at 40 Hz. The
    abstract of a book chapter describes the threshold as flat. Abstracts give the band as 10 to 40 Hz or as extending
    further up; 100 Hz is an assumption. The band ends abruptly, unlike that of receptors.
    """

    status: ClassVar[str] = "derived"
    reference: ClassVar[str] = (
        "thresholds of the two channels alike at 40 Hz: Guclu and Bolanowski, Vibrotactile thresholds of the"
        " Non-Pacinian I channel (2005), abstract; -27 dB and 10 to 100 Hz: assumptions"
    )

    equation: ClassVar[Mapping[str, str]] = {
        "weight": "10**(sensitivity/20) if low <= frequency <= high else 0",
    }
    published: ClassVar[tuple[DetectionThreshold, ...]] = (
        DetectionThreshold(amplitude=26e-6, frequency=10.0, conditions="held pen", source=ISRAR),
        DetectionThreshold(amplitude=8.5e-6, frequency=20.0, conditions="held pen", source=ISRAR),
        DetectionThreshold(
            amplitude=25e-6,
            frequency=30.0,
            conditions="thenar, plateau below 30 Hz",
            source="Bolanowski 1988, quoted by Tan, Srinivasan, Eberman and Cheng 1994, as tabled in"
            " github.com/adambickerdike/Stabilisation_Pen",
        ),
    )
    sensitivity: Annotated[
        Number, Quantity("1", -80, 40, "dB above that of the Pacinian channel at its best frequency")
    ] = -27.0
    low: Annotated[Number, Quantity("Hz", 0, 1000, "lowest frequency of the band")] = 10.0
    high: Annotated[Number, Quantity("Hz", 0.1, 2000, "highest frequency of the band")] = 100.0

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.low >= self.high:
            raise ValueError("low must be below high")
        return self

    def weight(self, frequency: ArrayLike) -> NDArray[np.float64]:
        """Return the sensitivity [1]: 10^(sensitivity/20) in the band [Hz], ends included, 0 outside."""
        places = np.asarray(frequency, dtype=float)
        inside = (places >= self.low) & (places <= self.high)
        result: NDArray[np.float64] = np.where(inside, 10 ** (self.sensitivity / 20), 0.0 * places)
        return result

    def best(self) -> float:
        """Return the geometric mean of the band [Hz]; half its upper end if it begins at 0."""
        return float(np.sqrt((self.low or self.high / 4) * self.high))


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


UNVERIFIED_CORNER: Final = 100.0
"""Frequency at which fingertip skin turns from elastic to viscous [Hz], cited from memory, unverified: shown, never used."""


class SkinCompliance(Model, family=True):
    """Lateral displacement of the skin under the finger per lateral force."""

    @abstractmethod
    def compliance(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Return the lateral displacement of the skin per force.

        Parameters
        ----------
        frequency : array_like
            Frequency [Hz], >= 0; NaN gives NaN.

        Returns
        -------
        compliance : ndarray of complex, same shape
            Displacement per force [m/N].
        """


class ElasticSkin(SkinCompliance):
    """Elastic skin: a spring at all frequencies."""

    equation: ClassVar[Mapping[str, str]] = {"compliance": "1/stiffness"}
    example: ClassVar[Mapping[str, Any]] = {"stiffness": 1000.0}

    stiffness: Annotated[Number, Quantity("N/m", 1, 1e6, "lateral stiffness of the fingertip")]

    def compliance(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Return the lateral displacement per force [m/N] at frequencies [Hz]."""
        places = np.asarray(frequency, dtype=float)
        result: NDArray[np.complex128] = 1 / self.stiffness + 0j * places
        return result


class ElasticViscousSkin(SkinCompliance):
    """Viscoelastic skin: a spring at low and a damper at high frequencies.

    Notes
    -----
    A spring and a damper in parallel, corner = stiffness/(2 pi damping). A corner near 100 Hz and a stiffness near
    1 N/mm, measured on fingertips, are cited from memory, unverified, and therefore not defaults.
    """

    status: ClassVar[str] = "unverified"
    reference: ClassVar[str] = (
        "elastic below some 100 Hz, viscous above: Wiertlewski and Hayward 2012, cited from memory, unverified"
    )
    equation: ClassVar[Mapping[str, str]] = {"compliance": "1/(stiffness*(1 + I*frequency/corner))"}
    example: ClassVar[Mapping[str, Any]] = {"stiffness": 1000.0, "corner": 100.0}

    stiffness: Annotated[Number, Quantity("N/m", 1, 1e6, "lateral stiffness of the fingertip")]
    corner: Annotated[
        Number, Quantity("Hz", 0.1, 1e5, "frequency above which the damper dominates the spring")
    ]

    def compliance(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Return the lateral displacement per force [m/N] at frequencies [Hz]."""
        ratio = np.asarray(frequency, dtype=float) / self.corner
        in_phase = 1 / (self.stiffness * (1 + ratio**2))
        result: NDArray[np.complex128] = in_phase - 1j * ratio * in_phase
        return result


@dataclass(frozen=True, kw_only=True)
class PublishedCompliance:
    """A lateral skin from publications, an assumption where the finger at hand has not been measured.

    `conditions`, `source` and `status` say what was measured, by whom, and how it was read.
    """

    skin: SkinCompliance
    conditions: str
    source: str
    status: str


_STIFFNESS: Final = GrowthWithSpeed(known_at=0.02).added_stiffness(0.1)
_PEN, _PEN_CONTACT, _FINGER_CONTACT = 15.8, 400e-6, 1e-4
"""Largest impedance of the hand on a pen [N s/m], its smallest contact, and that of a finger [m2]."""
_DAMPING: Final = _PEN * _FINGER_CONTACT / _PEN_CONTACT
COMPLIANCES: Final = (
    PublishedCompliance(
        skin=ElasticSkin(stiffness=_STIFFNESS),
        conditions=f"softest: {format_quantity(_STIFFNESS, 'N/m', digits=3)}, the rise of the stiffness of the fingertip from 20"
        " to 100 mm/s; that at 20 mm/s, which was not read, is left out",
        source="arXiv:2505.11162, abstract",
        status="derived",
    ),
    PublishedCompliance(
        skin=ElasticViscousSkin(stiffness=_STIFFNESS, corner=_STIFFNESS / (2 * math.pi * _DAMPING)),
        conditions=f"stiffest: with a damping of {format_quantity(_DAMPING, 'N s/m', digits=3)}, that of a hand on a pen below"
        " 40 Hz (-36 dB re 1 N s/mm on 400 mm2) for 1 cm2",
        source=ISRAR,
        status=SECOND_HAND,
    ),
)
"""Softest and stiffest lateral skin that publications give: the ends of what is assumed without a measurement."""
