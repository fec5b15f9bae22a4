"""The circuit in series with the stack: the resistance of the amplifier and the return path through the body."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np

from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity
from electrovib.physics.amplifier import IDEAL, Amplifier

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike

    from electrovib.core.arrays import Complex

_BODY = "1 kohm is the usual design value of a body (IEEE guide, second-hand)"
_RESISTANCE = Quantity("ohm", 0, 1e12, "resistance of the body", _BODY)


@dataclass(frozen=True, kw_only=True)
class SeriesElement:
    """A resistance plus a capacitor with its leak: Z(s) = resistance + elastance/(s + rate).

    `resistance` [ohm]; `elastance`, one over the capacitance [1/F], 0 for none; `rate`, one over leak
    resistance times capacitance [1/s], 0 for a capacitor that does not leak; net `charge` of the body at time
    0 [C].
    """

    resistance: float = 0.0
    elastance: float = 0.0
    rate: float = 0.0
    charge: float = 0.0

    def impedance(self, frequency: ArrayLike) -> Complex:
        """Impedance [ohm] at frequencies in Hz."""
        axis = 2j * np.pi * np.asarray(frequency, dtype=float)
        total: Complex = self.resistance + self.elastance / (axis + self.rate)
        return total


class ReturnPath(Model, family=True):
    """The return path of the current from the finger to the amplifier."""

    @abstractmethod
    def element(self) -> SeriesElement:
        """Return the impedance of the return path, without a second contact."""

    def second_contact(self, first_area: float) -> float:
        """Return the area of the first contact over that of the second.

        Parameters
        ----------
        first_area : float
            Area of the first contact [m2], above 0.

        Returns
        -------
        area_ratio : float
            Area of the first contact over that of the second, dimensionless; 0 without a second contact.
        """
        del first_area
        return 0.0


class Grounded(ReturnPath):
    """A body connected to ground, for instance by a wrist strap."""

    equation: ClassVar[Mapping[str, str]] = {"element.impedance": "resistance"}

    resistance: Annotated[Number, Quantity("ohm", 0, 1e12, "resistance of body and strap", _BODY)] = 1000.0

    def element(self) -> SeriesElement:
        """Return the resistance of body and strap."""
        return SeriesElement(resistance=self.resistance)


class Floating(ReturnPath):
    """A body connected to ground only by its capacitance, and by a leakage resistance if there is one.

    Notes
    -----
    Finger and body are neutral at time 0. A finger that has charged the film by rubbing has lost that charge: the body then
    starts with minus the `initial_charge` of the film times the contact area, which is declared as `charge`.
    """

    equation: ClassVar[Mapping[str, str]] = {
        "conductance": "0 if leak is None else 1/leak",
        "element.impedance": "resistance + 1/(conductance + 2*pi*I*frequency*capacitance)",
    }
    example: ClassVar[Mapping[str, Any]] = {"capacitance": 150e-12}

    capacitance: Annotated[
        Number,
        Quantity("F", 1e-14, 1e-3, "capacitance of the body to ground, 100 to 400 pF for a standing person"),
    ]
    resistance: Annotated[Number, _RESISTANCE] = 1000.0
    leak: Annotated[
        Number | None, Quantity("ohm", 1, 1e18, "leakage resistance of shoes and floor, if they conduct")
    ] = None
    charge: Annotated[Number, Quantity("C", -1e-3, 1e-3, "net charge of finger and body at time 0")] = 0.0

    def element(self) -> SeriesElement:
        """Return the resistance of the body and its leaking capacitance."""
        rate = 0.0 if self.leak is None else 1 / (self.leak * self.capacitance)
        return SeriesElement(
            resistance=self.resistance, elastance=1 / self.capacitance, rate=rate, charge=self.charge
        )


class SecondElectrode(ReturnPath):
    """A second electrode under the same finger: the current enters by one contact and leaves by the other.

    Notes
    -----
    Both contacts have the same layers; the force is the sum over both. The second contact carries no charge at time 0.
    Fields, displacements and voltages of layers and stack are those of the first contact; those of the second are larger
    by the ratio of the first area to the second, because both carry the same current. Breakdown, the linearity of the skin and
    electrowetting are judged at the smaller contact.
    """

    equation: ClassVar[Mapping[str, str]] = {
        "element.impedance": "resistance",
        "second_contact": "first_area/area",
    }
    example: ClassVar[Mapping[str, Any]] = {"area": 0.5e-4}

    area: Annotated[Number, Quantity("m2", 1e-9, 1, "contact area on the second electrode")]
    resistance: Annotated[
        Number, Quantity("ohm", 0, 1e12, "resistance through the finger between the contacts", "a choice")
    ] = 1000.0

    def element(self) -> SeriesElement:
        """Return the resistance through the finger."""
        return SeriesElement(resistance=self.resistance)

    def second_contact(self, first_area: float) -> float:
        """Return the area of the first contact over that of the second, dimensionless."""
        return first_area / self.area


class Circuit(Model):
    """The circuit around the stack; the return path has to be declared."""

    equation: ClassVar[Mapping[str, str]] = {
        "element.impedance": "source_resistance + return_path.element().impedance(frequency)",
    }
    example: ClassVar[Mapping[str, Any]] = {"return_path": {"model": "Grounded"}}

    amplifier: Amplifier | None = None
    return_path: ReturnPath
    source_resistance: Annotated[
        Number, Quantity("ohm", 0, 1e12, "resistance between amplifier and plate")
    ] = 0.0

    @property
    def supply(self) -> Amplifier:
        """The amplifier, an ideal one where none is declared."""
        return self.amplifier or IDEAL

    def element(self) -> SeriesElement:
        """Return source resistance and return path in series."""
        back = self.return_path.element()
        return replace(back, resistance=self.source_resistance + back.resistance)
