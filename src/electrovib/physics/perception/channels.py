"""Tactile channels: sensitivity to a displacement of the skin over frequency."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, ClassVar, Final, Self

import numpy as np
from pydantic import model_validator

from electrovib.core.citation import SECOND_HAND
from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity

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
