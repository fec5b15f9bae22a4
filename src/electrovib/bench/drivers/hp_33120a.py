"""HP / Agilent 33120A function generator: one arbitrary waveform, played once for each trigger from the bus.

Commands, with their source status:

=========================== ==========================================================================================
``OUTPut:LOAD INFinity``    manual p. 151 (output group: ``OUTPut:LOAD`` and ``OUTPut:SYNC``, no command that switches the
                            output off); the default is 50 ohm, and a high-impedance load then receives twice the voltage
                            that was set; ``OUTPut:LOAD?`` answers 9.9E+37 for INFinity
``DATA:DAC VOLATILE``       manual, page not noted: up to 16 000 points of 12 bits, -2047 to 2047, as a binary block
``FORMat:BORDer NORMal``    manual, page not noted: the most significant byte of each point comes first
``APPLy:DC DEF,DEF,0``      unverified (a public list of commands): 0 V, constant
``BM:NCYCles``, ``BM:PHASe``, unverified: one cycle for each trigger, which begins at the first point
``BM:SOURce``, ``BM:STATe``
``TRIGger:SOURce BUS``      unverified: trigger by ``*TRG``
``FUNCtion:USER VOLATILE``, unverified: selects the waveform in volatile memory
``FUNCtion:SHAPe USER``
``FREQuency``, ``VOLTage``, unverified
``VOLTage:OFFSet``,
``VOLTage:UNIT VPP``
``DATA:ATTRibute:POINts?``  unverified
``SYSTem:ERRor?``, ``*CLS``, unverified for this model; common commands of SCPI and IEEE 488.2
``*IDN?``, ``*TRG``
=========================== ==========================================================================================

``*RST`` is never sent: after it the generator may put out a continuous sine.

`VOLTage` is taken as the voltage between the points -2047 and 2047. It is not verified whether the instrument means the
peak-to-peak value of the points that are used instead, which for a drive of one sign would double the voltage; the burst at
low voltage is compared with the plan for this reason. Both bursts play the same points, so that their ratio is that of the
two values of `VOLTage` in either case. The offset stays 0, so that the output between bursts is the first point, 0 V, for
every amplitude.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.bench.link import BenchError
from electrovib.exports import waveform_formats as waveforms

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from electrovib.bench.link import Link

HIGH_IMPEDANCE: Final = 9.9e37
LARGEST_AMPLITUDE: Final = 2 * waveforms.HP_LARGEST_VOLTAGE
"""Largest peak-to-peak voltage into a high impedance [V]; unverified."""
_SETTINGS_CONFLICT: Final = "-221"
_MOST_ERRORS: Final = 20
_AGREES: Final = 1e-3


class Hp33120a:
    """Driver of the HP / Agilent 33120A; `also` is a further model that the user has named, empty for none."""

    models: Final = ("33120A",)
    largest_code: Final = waveforms.HP_LARGEST_CODE
    codes_of = staticmethod(waveforms.codes_of)
    voltages_of = staticmethod(waveforms.voltages_of)
    most_points: Final = waveforms.HP_MOST_POINTS
    fewest_points: Final = waveforms.HP_FEWEST_POINTS
    amplitudes: Final = (waveforms.HP_SMALLEST_AMPLITUDE, LARGEST_AMPLITUDE)

    def __init__(self, link: Link, *, also: str = "") -> None:
        self.link = link
        self._also = also

    def identify(self) -> str:
        """Return maker, model and versions; a model that is not known is refused."""
        return self.link.identify(self.models, self._also, "generator.accept_model")

    def zero(self) -> None:
        """Put out 0 V, constant: ``APPLy:DC DEF,DEF,0``, and refuse a generator that reports anything else."""
        self.link.write("APPL:DC DEF,DEF,0")
        shape, offset = self.link.ask("FUNC:SHAP?"), self.link.ask_number("VOLT:OFFS?")
        if not shape.upper().startswith("DC") or abs(offset) > 1e-3:
            raise BenchError(
                f"the generator reports shape '{shape[:20]}' with an offset of {offset:g} V, where DC and 0 V were set"
            )

    def set_burst(self) -> None:
        """Set one cycle for each trigger.

        It is unverified whether burst mode can be switched on at a constant voltage: a settings conflict is
        accepted here, the command is repeated with the waveform, and the state is read back before anything
        is enabled.
        """
        self.link.write("*CLS", "BM:SOUR INT", "BM:NCYC 1", "BM:PHAS 0", "BM:STAT ON")
        self._refuse_errors(accepted=_SETTINGS_CONFLICT)

    def set_trigger(self) -> None:
        """Take the trigger from the bus, and announce each burst at the SYNC output."""
        self.link.write("TRIG:SOUR BUS", "OUTP:SYNC ON")
        self._refuse_errors()

    def set_load(self) -> None:
        """Set a load of high impedance, and refuse another one, with which the voltage would be twice what is set."""
        self.link.write("OUTP:LOAD INF")
        load = self.link.ask_number("OUTP:LOAD?")
        if not load >= HIGH_IMPEDANCE * (1 - 1e-6):
            raise BenchError(
                f"the generator reports a load of {load:g} ohm after 'OUTP:LOAD INF': the amplifier would receive another"
                " voltage than is set, for 50 ohm twice as much"
            )

    def download(self, codes: NDArray[np.int16], duration: float, amplitude: float) -> None:
        """Load a waveform and select it as a burst.

        `codes` (n,) are from -2047 to 2047, the first and the last 0; `duration` is that of one cycle [s],
        and `amplitude` the voltage between the lowest and the highest code into a high impedance [V].
        """
        fewest, most, largest = self.fewest_points, self.most_points, max(int(codes.max()), -int(codes.min()))
        if not fewest <= codes.size <= most or largest > self.largest_code:
            raise BenchError(
                f"a waveform of {codes.size} points up to {largest} does not fit the generator: {fewest} to {most} points of up"
                f" to {self.largest_code}"
            )
        if codes[0] or codes[-1]:
            raise BenchError("a waveform for the bench begins and ends at 0 V")
        self.link.write("FORM:BORD NORM")
        self.link.write_block("DATA:DAC VOLATILE, ", codes.astype(">i2").tobytes())
        self.link.write("FUNC:USER VOLATILE", "VOLT:UNIT VPP")
        self.link.write("FUNC:SHAP USER;:BM:STAT ON")  # one message: in between the waveform would repeat
        self.link.write(f"FREQ {1 / duration:.9E}")
        self.set_amplitude(amplitude)

    def set_amplitude(self, amplitude: float) -> None:
        """Set the voltage between the points -2047 and 2047 [V], without an offset."""
        self.link.write("VOLT:OFFS 0", f"VOLT {amplitude:.6E}")
        self._refuse_errors()

    @staticmethod
    def expected(points: int, duration: float, amplitude: float) -> dict[str, Any]:
        """Return what the instrument has to report by query, a text or a number; arguments as for `download`."""
        return {
            "FUNC:SHAP?": "USER", "FUNC:USER?": "VOLATILE", "DATA:ATTR:POIN? VOLATILE": points,
            "FREQ?": 1 / duration, "VOLT?": amplitude, "VOLT:OFFS?": 0.0, "VOLT:UNIT?": "VPP",
            "OUTP:LOAD?": HIGH_IMPEDANCE, "BM:STAT?": 1, "BM:NCYC?": 1, "BM:PHAS?": 0.0, "BM:SOUR?": "INT",
            "TRIG:SOUR?": "BUS",
        }  # fmt: skip

    def trigger(self) -> None:
        """Play the waveform once: ``*TRG``."""
        self.link.write("*TRG")

    def _refuse_errors(self, accepted: str = "") -> None:
        """Read the queue of errors until it is empty."""
        for _ in range(_MOST_ERRORS):
            error = self.link.ask("SYST:ERR?")
            number = error.partition(",")[0]
            if number.strip().lstrip("+") in ("0", "-0"):
                return
            if number.strip() != accepted:
                raise BenchError(f"the generator reports the error {error[:100]}")
        raise BenchError(f"the generator reports more than {_MOST_ERRORS} errors")


def mismatches(found: Mapping[str, str], expected: Mapping[str, Any]) -> list[str]:
    """Compare replies with the settings that were expected, by query: one sentence for each difference.

    A count, of type int, has to agree exactly, another number to `_AGREES` of it; that much where it is 0.
    """
    wrong = []
    for query, wanted in expected.items():
        reply = found.get(query, "")
        if isinstance(wanted, str):
            if reply.strip('"').upper()[:3] != wanted.upper()[:3]:
                wrong.append(f"'{query}' answers '{reply[:40]}', where {wanted} was set")
            continue
        try:
            number = float(reply)
        except ValueError:
            number = float("nan")
        allowed = 0 if isinstance(wanted, int) else _AGREES * (abs(wanted) or 1.0)
        if not abs(number - wanted) <= allowed:
            wrong.append(f"'{query}' answers '{reply[:40]}', where {wanted:g} was set")
    return wrong
