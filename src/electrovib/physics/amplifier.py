"""The amplifier between the drive and the plate: its gain, bandwidth and limits."""

from __future__ import annotations

import re
import unicodedata
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Final, Self

import numpy as np
from pydantic import Field, model_validator

from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity
from electrovib.core.units import format_quantity, parse_quantity
from electrovib.physics.limits import VOLTAGE

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike, NDArray

_NOTHING: Final = re.compile(
    r"no|non|not|none|nil|null|nothing|without|absent|missing|false|off|unknown|undefined|assumed|ideal|planned|todo|tb[acd]|nein"
    r"|kein\w*|nichts?|ohne|sans|aucune?|rien|ningun[oa]|nada|sin|nessun[oa]|niente|senza|nenhuma?|sem|geen|niet|zonder|ingen|inget"
    r"|uden|utan|ei|bez|brak|nie|yok|не|нет|без|немає|なし|無し|没有|沒有|없음"
)
"""Words by which a text says that something is not there."""
_CURRENT: Final = re.compile(r"\d+(?:\.\d+)?\s*[pnuµμm]?A(?![A-Za-z])")


def negating_word(text: str) -> str:
    """Return the word by which a text says that nothing is there, or the text if it has no word at all; else nothing."""
    words = re.findall(r"[^\W\d_]{2,}", unicodedata.normalize("NFKC", text).casefold())
    return next((word for word in words if _NOTHING.fullmatch(word)), "" if words else repr(text))


class Amplifier(Model):
    """A voltage amplifier with a gain, one pole, a largest voltage and a largest current.

    Notes
    -----
    The target voltage `aim` is the gain times the drive, limited to plus and minus `saturation`. The voltage at the plate,
    `output`, follows it with one pole of `bandwidth`, or without delay if that is absent, while the required current lies
    between the sink and the source limit. Beyond a limit the amplifier is a source of that current, and the slew rate
    follows from the plate, the stray capacitance and the finger. The limits do not depend on the voltage; the small-signal
    response of a real amplifier has more poles. A waveform is exported on the strength of `bandwidth` and of the limits only
    if `hardware` names the amplifier that has them, by maker and model number.
    """

    equation: ClassVar[Mapping[str, str]] = {
        "aim": "gain*voltage if saturation is None else Max(-saturation, Min(saturation, gain*voltage))",
        "output'": "2*pi*bandwidth*(aim(voltage) - output)",
    }
    example: ClassVar[Mapping[str, Any]] = {"gain": 1.0, "source_current": 250e-6}

    gain: Annotated[Number, Quantity("1", -1e6, 1e6, "voltage at the plate over voltage of the drive")] = 1.0
    bandwidth: Annotated[
        Number | None, Quantity("Hz", 1e-3, 1e10, "corner of its one pole; without delay if absent")
    ] = None
    saturation: Annotated[
        Number | None, Quantity(*VOLTAGE, "largest voltage of either sign; unlimited if absent")
    ] = None
    source_current: Annotated[
        Number | None, Quantity("A", 1e-12, 1e3, "largest current out of the amplifier; unlimited if absent")
    ] = None
    sink_current: Annotated[
        Number | None,
        Quantity("A", 1e-12, 1e3, "largest current back into the amplifier; as the source if absent"),
    ] = None
    stray_capacitance: Annotated[
        Number, Quantity("F", 0, 1e-3, "capacitance of plate, cable and amplifier against ground")
    ] = 0.0
    hardware: Annotated[
        str,
        Field(
            description="maker and model number of this very amplifier where it stands before the plate; empty if assumed"
        ),
    ] = ""

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
    def hardware_fault(self) -> str:
        """Why the text of `hardware` names no amplifier that holds these limits; empty if it names one, or is empty."""
        text, largest = self.hardware, self.current_limits[1]
        stated = [parse_quantity(each, "A") for each in _CURRENT.findall(text)]
        if text and (word := negating_word(text)):
            return f"names no amplifier ({word})"
        if text and not re.search(r"\d", text):
            return "has no model number"
        if stated and min(stated) > largest:
            return f"states {format_quantity(min(stated), 'A')}, more than source_current = {format_quantity(largest, 'A')}"
        return ""

    @property
    def is_limited(self) -> bool:
        """Whether its response is not linear because it has a largest voltage or current."""
        return self.saturation is not None or bool(np.isfinite(self.current_limits[1]))

    @property
    def largest_voltage(self) -> float:
        """Largest voltage of either sign at the plate [V]; infinite if it is unlimited."""
        return np.inf if self.saturation is None else self.saturation

    @property
    def largest_input(self) -> float:
        """Largest voltage of the drive that is amplified without saturation [V]; infinite if there is none."""
        return self.largest_voltage / abs(self.gain) if self.gain else np.inf

    def aim(self, voltage: ArrayLike) -> NDArray[np.float64]:
        """Target voltage: the gain times the drive, within the saturation.

        Parameters
        ----------
        voltage : array_like, any shape
            Voltage of the drive [V]; NaN gives NaN.

        Returns
        -------
        target : ndarray
            Target voltage [V], same shape.
        """
        wanted = self.gain * np.asarray(voltage, dtype=float)
        return np.asarray(np.clip(wanted, -self.largest_voltage, self.largest_voltage))


IDEAL: Final = Amplifier()
"""A gain of 1 without pole and limits: the drive is the voltage of the plate."""
