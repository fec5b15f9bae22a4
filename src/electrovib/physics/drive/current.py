"""Drives that prescribe the current; the voltage follows from the finger and the plate."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from electrovib.core.arrays import Real
from electrovib.core.quantity import Number, Quantity
from electrovib.physics.drive.base import Drive
from electrovib.physics.drive.levels import IN_PLACE_OF_SWING
from electrovib.physics.drive.parts import Part
from electrovib.physics.drive.sines import Oscillation

if TYPE_CHECKING:
    from collections.abc import Mapping


class CurrentSine(Oscillation):
    """A sinusoidal current about an offset.

    Notes
    -----
    The charge of a blocking layer that starts from rest depends on the phase: I/w (1 - cos wt) under a current that
    starts as a sine (phase 0), I/w sin wt under one that starts as a cosine (phase pi/2). A constant current through a
    blocking layer charges it without bound.
    """

    quantity: ClassVar[str] = "current"
    equation: ClassVar[Mapping[str, str]] = {"current": "offset + amplitude*sin(2*pi*frequency*time + phase)"}
    example: ClassVar[Mapping[str, Any]] = {"amplitude": 1e-3, "frequency": 25e3}

    derived: ClassVar[Mapping[str, Quantity]] = {
        "high": Quantity("A", -10, 10, "highest current, offset + amplitude", IN_PLACE_OF_SWING),
        "low": Quantity("A", -10, 10, "lowest current, offset - amplitude", IN_PLACE_OF_SWING),
    }

    amplitude: Annotated[Number, Quantity("A", 0, 10, "peak current about the offset")]
    offset: Annotated[Number, Quantity("A", -10, 10, "constant current added, from time 0 on")] = 0.0


class CurrentAmplifier(Drive):
    """A current proportional to a command voltage, which is any drive.

    Notes
    -----
    i = v/R with the amplifier's sense resistor R: 1 kohm gives 1 mA for each volt of the command. The supply
    voltage is taken as unlimited; the voltage that the current needs is a signal of the result.
    """

    quantity: ClassVar[str] = "current"
    equation: ClassVar[Mapping[str, str]] = {"current": "command.voltage(time)/sense_resistance"}
    example: ClassVar[Mapping[str, Any]] = {
        "command": {"model": "Trapezium", "high": 1, "rise": 1e-3, "hold": 2e-3, "fall": 1e-3},
        "sense_resistance": 1e4,
    }

    command: Drive
    sense_resistance: Annotated[Number, Quantity("ohm", 0.1, 1e12, "command voltage over the current")]

    def parts(self) -> tuple[Part, ...]:
        """Return the parts of the command as currents [A]."""
        return tuple(part.with_levels(part.levels / self.sense_resistance) for part in self.command.parts())

    @property
    def period(self) -> float | None:
        """Period of the command [s]."""
        return self.command.period

    @property
    def duration(self) -> float:
        """Duration of the command [s]."""
        return self.command.duration

    @property
    def time_stamps(self) -> Real | None:
        """Times at which the command was measured [s]; None for a formula."""
        return self.command.time_stamps
