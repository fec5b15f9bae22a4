"""The amplifier between the drive and the plate: what it multiplies, and what it cannot give."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import model_validator

from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike, NDArray

_CURRENT = Quantity("A", 1e-12, 1e3, "largest current")


class Amplifier(Model):
    """A voltage amplifier with a gain, one pole, a largest voltage and a largest current.

    Notes
    -----
    It aims at gain times the drive, held between plus and minus `saturation`. It follows that aim with one pole
    of `bandwidth`, v' = 2 pi bandwidth (aim - v), as long as the current that takes lies within what it can
    source and sink; else it gives that largest current, whatever the voltage then does: plate, stray
    capacitance and finger decide on the slew. The limits are independent of the voltage; a real amplifier's
    small-signal response has more poles.
    """

    example: ClassVar[Mapping[str, Any]] = {"gain": 1.0, "source_current": 250e-6}

    gain: Annotated[Number, Quantity("1", -1e6, 1e6, "voltage at the plate over voltage of the drive")] = 1.0
    bandwidth: Annotated[
        Number | None, Quantity("Hz", 1e-3, 1e10, "corner of its one pole; without delay if absent")
    ] = None
    saturation: Annotated[
        Number | None, Quantity("V", 1e-3, 1e6, "largest voltage of either sign; unlimited if absent")
    ] = None
    source_current: Annotated[Number | None, _CURRENT] = None
    sink_current: Annotated[
        Number | None,
        Quantity("A", 1e-12, 1e3, "largest current back into the amplifier; as the source if absent"),
    ] = None
    stray_capacitance: Annotated[
        Number, Quantity("F", 0, 1e-3, "of plate, cable and amplifier against ground")
    ] = 0.0

    @model_validator(mode="after")
    def _sinks_beside_a_source(self) -> Self:
        if self.sink_current is not None and self.source_current is None:
            raise ValueError(
                "sink_current needs source_current beside it, for instance source_current = '1 A' where the source is"
                " never the limit"
            )
        return self

    @property
    def current_limits(self) -> tuple[float, float]:
        """Lowest (into the amplifier, negative) and highest current [A]; infinite where there is no limit."""
        source = np.inf if self.source_current is None else self.source_current
        sink = source if self.sink_current is None else self.sink_current
        return -sink, source

    @property
    def is_limited(self) -> bool:
        """Tell whether its response departs from proportion: it has a largest voltage or current."""
        return self.saturation is not None or np.isfinite(self.current_limits[1])

    def aim(self, voltage: ArrayLike) -> NDArray[np.float64]:
        """Voltage it aims at.

        Parameters
        ----------
        voltage : array_like, any shape
            Of the drive [V]; NaN gives NaN.

        Returns
        -------
        ndarray
            V, same shape.
        """
        wanted = self.gain * np.asarray(voltage, dtype=float)
        highest = np.inf if self.saturation is None else self.saturation
        return np.asarray(np.clip(wanted, -highest, highest))
